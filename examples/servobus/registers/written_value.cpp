// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Values as people write them: quantities with the register's scale, exact or refused; floats, texts; codes and bits by
// their names.
#include <servobus/registers/value_text.hpp>

#include <algorithm>
#include <numeric>

#include "../device_file/map_text.hpp"
#include "../device_file/named_values.hpp"
#include "../devices/row_words.hpp"
#include "../streams/messages.hpp"
#include "../words/nearest.hpp"
#include "../words/numbers.hpp"
#include "session.hpp"

namespace tool {
namespace {

using servobus::entry;

std::string printed(const entry& e, std::int64_t count) {
    char room[64];
    servobus::text_writer text{room};
    servobus::put_quantity(text, e, count);
    return {room, text.size()};
}

bool is_number(std::string_view text) {
    if (text.starts_with('-')) text.remove_prefix(1);
    return !text.empty() && text[0] >= '0' && text[0] <= '9';
}

// One name of a code or bit, blanks written as _.
bool has_name(const servobus::named_value& v, std::string_view name) {
    const std::string_view own = v.name;
    if (own.size() != name.size()) return false;
    for (std::size_t i = 0; i < own.size(); ++i) {
        if ((own[i] == ' ' ? '_' : own[i]) != (name[i] == ' ' ? '_' : name[i])) return false;
    }
    return true;
}

// True if a name of the bit is `on` for 0 or `off` for 1: neither word means the usual then.
bool has_own_on_or_off(const entry& e) {
    return std::ranges::any_of(
        e.values, [](const servobus::named_value& v) { return has_name(v, v.value == 0 ? "on" : "off"); });
}

// The bits of a code, or of several fields joined by +.
std::optional<u32> parse_names(const entry& e, std::string_view text) {
    u32 bits = 0;
    u32 taken = 0;
    while (true) {
        const std::size_t plus = text.find('+');
        const std::string_view name = text.substr(0, plus);
        bool is_known = false;
        for (const servobus::named_value& v : e.values) {
            if (is_known || !has_name(v, name)) continue;
            const u32 mask = v.is_whole() ? ~u32{0} : v.mask;
            if ((taken & mask) != 0) return std::nullopt;
            taken |= mask;
            bits |= v.value;
            is_known = true;
        }
        if (!is_known) return std::nullopt;
        if (plus == text.npos) return bits;
        text.remove_prefix(plus + 1);
    }
}

// The complaint about names of which one is none of the register's.
std::string no_name(const entry& e, std::string_view text) {
    const std::vector<std::string> known = names_of(e);
    const std::string all = codes_of(e);
    const std::string complaint = "'" + std::string{text} + "' is none of ";
    while (true) {
        const std::size_t plus = text.find('+');
        const std::string_view name = text.substr(0, plus);
        if (std::ranges::none_of(e.values, [&](const auto& v) { return has_name(v, name); })) {
            const std::string meant =
                did_you_mean(name, std::vector<std::string_view>{known.begin(), known.end()}, "");
            return meant.empty() ? complaint + all : complaint + "its names" + meant;
        }
        if (plus == text.npos) return complaint + all;
        text.remove_prefix(plus + 1);
    }
}

struct decimal {
    bool is_negative = false;
    std::uint64_t digits = 0;
    unsigned decimals = 0;
};

// At most 12 digits behind the point, so that nothing below overflows.
std::optional<decimal> parse_decimal(std::string_view text) {
    decimal d{.is_negative = text.starts_with('-')};
    if (d.is_negative || text.starts_with('+')) text.remove_prefix(1);
    bool has_point = false;
    bool has_digit = false;
    for (const char c : text) {
        if (c == '.' && !has_point) {
            has_point = true;
            continue;
        }
        const auto digit = static_cast<std::uint64_t>(c - '0');
        const bool is_too_large = d.digits > (~std::uint64_t{0} - 9) / 10;
        if (c < '0' || c > '9' || d.decimals == 12 || (is_too_large && d.digits * 10 / 10 != d.digits))
            return std::nullopt;
        if (is_too_large && ~std::uint64_t{0} - d.digits * 10 < digit) return std::nullopt;
        d.digits = d.digits * 10 + digit;
        has_digit = true;
        if (has_point) ++d.decimals;
    }
    return has_digit ? std::optional{d} : std::nullopt;
}

enum class reading_error { none, no_number, inexact, too_large };

// A number in the register's unit as the bits of counts.
reading_error parse_quantity(const entry& e, std::string_view text, std::uint64_t& bits) {
    std::optional<decimal> d = parse_decimal(text);
    if (!d) return reading_error::no_number;
    const bool is_raw = has(e.flags, servobus::flag::scaled_elsewhere);
    const servobus::unit u = is_raw ? servobus::unit{} : e.unit_of_count;
    std::uint64_t divisor = u.numerator;
    for (unsigned i = 0; i < d->decimals; ++i) divisor *= 10;
    const std::uint64_t common = d->digits == 0 ? divisor : std::gcd(d->digits, divisor);
    divisor /= common;
    if (u.denominator % divisor != 0) return reading_error::inexact;
    const std::uint64_t size = d->digits / common, by = u.denominator / divisor;
    if (size > ~std::uint64_t{0} / by) return reading_error::too_large;
    const servobus::number_bits found = bits_of_number(e, d->is_negative, size * by);
    bits = found.bits;
    return found.fits ? reading_error::none : reading_error::too_large;
}

std::string limits_text(const entry& e) {
    const bool has_range = is_plain(e) || e.limits.is_stated;
    return has_range
               ? "outside " + printed(e, e.limits.low) + " .. " + printed(e, e.limits.high) + what_it_takes(e)
               : std::string{"beyond "} + (e.is_part() ? "its bits" : text(e.kind)) + what_it_takes(e);
}

// Each of these sets `words`, or returns the reason.
std::string read_text(const entry& e, std::string_view text, std::vector<u16>& words) {
    const std::optional<std::vector<u16>> found = parse_text(e, text);
    if (!found)
        return '\'' + std::string{text} + "' has more than " + std::to_string(2 * e.words()) +
               " characters, or a \\ that begins none such as \\x0A";
    words = *found;
    return {};
}

std::string read_float(const entry& e, std::string_view text, std::vector<u16>& words) {
    const std::string shown = '\'' + std::string{text} + '\'';
    const bool is_raw = text.starts_with("0x") || text.starts_with("0X");
    const std::optional<std::uint64_t> bits = is_raw ? parse_magnitude(text) : parse_float(e, text);
    if (!bits || *bits > all_bits_of(e)) return shown + " is no finite number of " + servobus::text(e.kind);
    const servobus::row_value v = value_of(e, *bits);
    if (v.is == servobus::row_value::state::real && !takes(e, v)) return shown + " is " + limits_text(e);
    words = words_of_bits(e, *bits);
    return {};
}

} // namespace

std::string undocumented_zero(const entry& e) {
    return std::string{e.name} + ": what 0 does is not documented; only \"write PORT raw:NODE " +
           hex_word(e.address) + "=0\" writes it";
}

std::string read_value(const entry& e, bool is_bit, std::string_view text, std::vector<u16>& words) {
    const std::string shown{text};
    const auto refuse = [&](const std::string& why) { return std::string{e.name} + ": " + why; };
    if (e.rights == servobus::access::ro) return refuse("this register is read-only");
    if (is_text(e) || is_float(e)) {
        const std::string why = is_text(e) ? read_text(e, text, words) : read_float(e, text, words);
        return why.empty() ? why : refuse(why);
    }

    std::uint64_t bits = 0;
    const bool is_raw = text.starts_with("0x") || text.starts_with("0X");
    if (is_raw) {
        const std::optional<std::uint64_t> content = parse_magnitude(text);
        if (!content || *content > all_bits_of(e)) return refuse("'" + shown + "' does not fit the register");
        bits = *content;
    } else if (const auto named = parse_names(e, text)) { // first, since a name may begin with a digit: 8N1
        bits = *named;
    } else if (is_bit && (text == "on" || text == "off") && !has_own_on_or_off(e)) {
        bits = text == "on" ? 1 : 0;
    } else if (!e.is_quantity() && !is_number(text)) {
        return refuse(no_name(e, text));
    } else if (e.names == servobus::naming::halves) {
        return refuse("two values in one word: give the content as 0x....");
    } else if (unknown_scale(e).is == servobus::row_scale::state::unknown) {
        return refuse("another row sets its scale: give the raw content, 0x....");
    } else {
        switch (parse_quantity(e, text, bits)) {
        case reading_error::none: break;
        case reading_error::no_number:
            return refuse("'" + shown + (is_bit ? "' is neither on nor off" : "' is no number") +
                          what_it_takes(e));
        case reading_error::too_large: return refuse("'" + shown + "' is " + limits_text(e));
        case reading_error::inexact:
            if (has(e.flags, servobus::flag::scaled_elsewhere))
                return refuse("another register sets the scale: give whole counts, not '" + shown + "'");
            return refuse("'" + shown + "' is no whole number of counts; one is " + printed(e, 1));
        }
    }
    const servobus::row_value v = value_of(e, bits);
    const bool is_none = v.is == servobus::row_value::state::no_value && !is_named_code(e, bits);
    if (is_none && !is_raw) return refuse("'" + shown + "' means no value: give the raw content, 0x....");
    if (!is_none && !takes(e, v)) return refuse("'" + shown + "' is " + limits_text(e));
    if (bits == 0 && has(e.flags, servobus::flag::zero_by_name)) return undocumented_zero(e);
    words = words_of_bits(e, bits);
    return {};
}

std::optional<std::vector<u16>> parse_value(const chosen& what, std::string_view text) {
    if (what.row == nullptr) return parse_raw_values(what, text);
    std::vector<u16> words;
    const std::string why = read_value(*what.row, what.form.is_bit(), text, words);
    if (why.empty()) return words;
    complain(usage, why);
    return std::nullopt;
}

} // namespace tool
