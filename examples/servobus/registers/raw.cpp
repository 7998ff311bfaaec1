// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "raw.hpp"

#include <bit>
#include <charconv>
#include <cmath>

#include <servobus/modbus/bits.hpp>

#include "../streams/messages.hpp"
#include "../words/nearest.hpp"
#include "../words/numbers.hpp"
#include "session.hpp"

namespace tool {
namespace {

using servobus::table;

struct named_table {
    std::string_view name;
    servobus::table of;
};
constexpr named_table tables[] = {{"coil", table::coils},
                                  {"discrete", table::discrete_inputs},
                                  {"holding", table::holding_registers},
                                  {"input", table::input_registers}};

struct named_type {
    std::string_view name;
    raw_type type;
};
constexpr named_type types[] = {{"u16", raw_type::unsigned_word},
                                {"i16", raw_type::signed_word},
                                {"u32", raw_type::unsigned_pair},
                                {"i32", raw_type::signed_pair},
                                {"f32", raw_type::float_pair}};

template <class Named, std::size_t N> const Named* find(const Named (&all)[N], std::string_view name) {
    for (const Named& one : all) {
        if (one.name == name) return &one;
    }
    return nullptr;
}

std::string_view table_name(servobus::table of) {
    for (const named_table& t : tables) {
        if (t.of == of) return t.name;
    }
    return "";
}

std::optional<chosen> refuse(std::string_view text, const std::string& why) {
    complain(usage, "'" + std::string{text} + "' " + why);
    return std::nullopt;
}

std::optional<chosen> refuse_part(std::string_view text, std::string_view part) {
    const std::vector<std::string_view> known{"coil", "discrete", "holding", "input", "u16", "i16",
                                              "u32",  "i32",      "f32",     "hi",    "lo"};
    return refuse(text, "is no ADDRESS, ADDRESS:COUNT or [TABLE:]ADDRESS[:COUNT][:TYPE][:hi|lo]: '" +
                            std::string{part} + "'" + did_you_mean(part, known, "") +
                            (part.empty() ? " is empty" : ""));
}

std::string_view next_part(std::string_view& rest) {
    const std::size_t colon = rest.find(':');
    const std::string_view part = rest.substr(0, colon);
    rest.remove_prefix(colon == rest.npos ? rest.size() : colon + 1);
    return part;
}

u32 bits_of(const raw_form& form, std::span<const u16> words) {
    return form.width() == 2 ? servobus::join_words(words[0], words[1], form.order) : u32{words[0]};
}

// The bits of a value; none if it does not fit.
std::optional<u32> parse_bits(raw_type type, std::string_view text) {
    if (type == raw_type::bit) {
        if (text == "on" || text == "1" || text == "true") return 1;
        if (text == "off" || text == "0" || text == "false") return 0;
        return std::nullopt;
    }
    if (type == raw_type::float_pair) {
        float value = 0;
        const char* const end = text.data() + text.size();
        const auto [stopped, error] = std::from_chars(text.data(), end, value);
        if (error != std::errc{} || stopped != end || !std::isfinite(value)) return std::nullopt;
        return std::bit_cast<u32>(value);
    }
    struct range {
        std::int64_t low;
        std::int64_t high;
    };
    const range within = type == raw_type::word            ? range{-0x8000, 0xFFFF}
                         : type == raw_type::unsigned_word ? range{0, 0xFFFF}
                         : type == raw_type::signed_word   ? range{-0x8000, 0x7FFF}
                         : type == raw_type::unsigned_pair ? range{0, 0xFFFF'FFFF}
                                                           : range{-0x8000'0000LL, 0x7FFF'FFFF};
    const std::optional<std::int64_t> value = parse_integer(text);
    if (!value || *value < within.low || *value > within.high) return std::nullopt;
    return static_cast<u32>(static_cast<std::uint64_t>(*value));
}

const char* what_fits(raw_type type) {
    switch (type) {
    case raw_type::bit: return "neither on nor off (nor 1 or 0)";
    case raw_type::word: return "no 16-bit number";
    case raw_type::unsigned_word: return "no whole number from 0 to 65535";
    case raw_type::signed_word: return "no whole number from -32768 to 32767";
    case raw_type::unsigned_pair: return "no whole number from 0 to 4294967295";
    case raw_type::signed_pair: return "no whole number from -2147483648 to 2147483647";
    case raw_type::float_pair: return "no number of single precision";
    }
    return "";
}

std::string raw_hex(u32 bits, std::size_t digits) {
    constexpr char all[] = "0123456789ABCDEF";
    std::string text(digits, '0');
    for (std::size_t i = digits; i-- != 0; bits >>= 4) text[i] = all[bits & 0xFu];
    return "0x" + text;
}

std::string typed_number(raw_type type, u32 bits) {
    switch (type) {
    case raw_type::signed_word: return std::to_string(static_cast<std::int16_t>(bits));
    case raw_type::signed_pair: return std::to_string(static_cast<std::int32_t>(bits));
    case raw_type::float_pair: {
        char room[32];
        const std::to_chars_result end = std::to_chars(room, room + sizeof room, std::bit_cast<float>(bits));
        return {room, end.ptr};
    }
    default: return std::to_string(bits);
    }
}

} // namespace

std::optional<chosen> parse_raw_register(std::string_view text) {
    std::string_view rest = text;
    std::string_view part = next_part(rest);
    raw_form form;
    if (const named_table* t = find(tables, part)) {
        form.table = t->of;
        form.has_table = true;
        const bool is_bit = t->of == table::coils || t->of == table::discrete_inputs;
        if (is_bit) form.type = raw_type::bit;
        part = next_part(rest);
    }
    const std::optional<std::int64_t> address = parse_integer(part);
    if (!address) return refuse_part(text, part);
    std::optional<std::int64_t> count;
    bool has_order = false;
    bool has_type = false;
    while (!rest.empty() || text.ends_with(':')) {
        part = next_part(rest);
        const named_type* const type = find(types, part);
        if (type != nullptr && form.is_bit()) return refuse(text, "is a bit, which has no type");
        if (type != nullptr && !has_type) {
            form.type = type->type;
            has_type = true;
        } else if ((part == "hi" || part == "lo") && !has_order) {
            form.order = part == "hi" ? servobus::word_order::high_first : servobus::word_order::low_first;
            has_order = true;
        } else if (const auto number = parse_integer(part); number && !count) {
            count = number;
        } else {
            return refuse_part(text, part);
        }
        if (rest.empty()) break;
    }
    if (has_order && form.width() != 2)
        return refuse(text, "has no word order: hi and lo are for u32, i32 and f32");
    const std::int64_t most = form.is_bit() ? servobus::modbus::max_read_bits : servobus::modbus::max_read;
    const std::int64_t width = static_cast<std::int64_t>(form.width());
    const std::int64_t values = count.value_or(1);
    if (*address < 0 || *address > 0xFFFF || values < 1 || values > most / width ||
        *address + values * width > 0x1'0000) {
        return refuse(text, "is no ADDRESS or ADDRESS:COUNT (0x0000 to 0xFFFF, at most " +
                                std::to_string(most / width) + ")");
    }
    return chosen{std::string{text}, static_cast<u16>(*address), static_cast<u16>(values * width), nullptr,
                  form};
}

std::optional<std::vector<u16>> parse_raw_values(const chosen& what, std::string_view text) {
    const raw_form& form = what.form;
    if (!form.is_writable()) {
        complain(usage, what.name + (form.is_bit() ? ": discrete inputs are read-only"
                                                   : ": input registers are read-only"));
        return std::nullopt;
    }
    std::vector<u16> words;
    const std::string shown{text};
    while (true) {
        const std::size_t comma = text.find(',');
        const std::optional<u32> bits = parse_bits(form.type, text.substr(0, comma));
        if (!bits) {
            complain(usage,
                     what.name + ": '" + shown + "' is " + what_fits(form.type) + ", or several with commas");
            return std::nullopt;
        }
        if (form.width() == 2) {
            const servobus::word_pair pair = servobus::split_words(*bits, form.order);
            words.insert(words.end(), {pair.first, pair.second});
        } else {
            words.push_back(static_cast<u16>(*bits & 0xFFFFu));
        }
        if (comma == text.npos) break;
        text.remove_prefix(comma + 1);
    }
    const std::size_t most = form.is_bit() ? servobus::modbus::max_write_bits : servobus::modbus::max_write;
    if (words.size() == what.words && words.size() <= most) return words;
    complain(usage, what.name + ": " + std::to_string(words.size() / form.width()) + " values for " +
                        std::to_string(raw_count(what)) + (form.is_bit() ? " coils" : " registers") +
                        " (at most " + std::to_string(most / form.width()) + ")");
    return std::nullopt;
}

std::size_t raw_count(const chosen& what) { return what.words / what.form.width(); }

std::string raw_name(const chosen& what, std::size_t index) {
    const std::string address = hex_word(static_cast<u16>(what.address + index * what.form.width()));
    return what.form.has_table ? std::string{table_name(what.form.table)} + ':' + address : address;
}
std::string raw_name(const chosen& what) {
    return raw_name(what, 0) + (raw_count(what) == 1 ? "" : ':' + std::to_string(raw_count(what)));
}

std::string raw_number(const raw_form& form, std::span<const u16> words) {
    const u32 bits = bits_of(form, words);
    const bool is_finite = form.type != raw_type::float_pair || std::isfinite(std::bit_cast<float>(bits));
    return is_finite ? typed_number(form.type, bits) : "nan";
}

std::string raw_text(const raw_form& form, std::span<const u16> words) {
    const u32 bits = bits_of(form, words);
    if (form.is_bit()) return bits != 0 ? "on" : "off";
    return typed_number(form.type, bits) + " (" + raw_hex(bits, 4 * form.width()) + ")";
}

std::vector<std::string> raw_tables(bool writable_only) {
    std::vector<std::string> names;
    for (const named_table& t : tables) {
        const raw_form form{.table = t.of};
        if (!writable_only || form.is_writable()) names.push_back(std::string{t.name} + ':');
    }
    return names;
}

} // namespace tool
