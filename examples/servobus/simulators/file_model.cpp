// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "file_model.hpp"

#include <algorithm>
#include <utility>

#include <servobus/modbus/bits.hpp>
#include <servobus/modbus/pdu.hpp>

#include "../device_file/map_text.hpp"
#include "../devices/row_words.hpp"

namespace tool {
namespace {

constexpr std::uint8_t illegal_function = 1, illegal_address = 2, illegal_value = 3;

bool is_reading(std::uint8_t code) { return code <= 4; }
bool is_write_of_one(std::uint8_t code) { return code == 0x05 || code == 0x06; }

std::optional<servobus::table> table_of(std::uint8_t code) {
    switch (code) {
    case 0x01:
    case 0x05:
    case 0x0F: return servobus::table::coils;
    case 0x02: return servobus::table::discrete_inputs;
    case 0x03:
    case 0x06:
    case 0x10: return servobus::table::holding_registers;
    case 0x04: return servobus::table::input_registers;
    default: return std::nullopt;
    }
}

// A raw value that means none is one that a device may be given.
bool is_allowed(const servobus::entry& e, std::span<const u16> words) {
    const bool is_none = !is_text(e) && value_of_words(e, words).is == servobus::row_value::state::no_value;
    return is_none || takes_words(e, words);
}

// A text is empty; a number is its default, or the allowed one next to 0.
std::vector<u16> first_words(const servobus::entry& e) {
    if (is_text(e)) return std::vector<u16>(e.words());
    const std::int64_t initial = e.initial != servobus::no_default ? e.initial : 0;
    return words_of(e, std::clamp(initial, e.limits.low, e.limits.high));
}

} // namespace

file_model::file_model(const device& of, std::uint8_t node, std::uint32_t baud)
    : facts_{&of.facts()}, node_{node}, baud_{baud} {
    for (const servobus::table t : all_tables) {
        for (const servobus::entry& e : of.rows_of(t))
            rows_[static_cast<std::size_t>(t)].push_back({&e, first_words(e)});
    }
}

servobus::word_order file_model::order_of(const servobus::entry& e) const {
    using enum servobus::word_order;
    if (e.own_word_order != unknown) return e.own_word_order;
    if (facts_->word_order != unknown) return facts_->word_order;
    for (const row& r : rows_of(servobus::table::holding_registers)) {
        if (r.what->address == facts_->word_order_register) return r.words[0] == 0 ? high_first : low_first;
    }
    return high_first;
}

// From the order of row_words.hpp to that of the device, or back.
std::vector<u16> file_model::reordered(const servobus::entry& e, std::span<const u16> words) const {
    const servobus::words_in_order ordered{e, words, 0, order_of(e)};
    std::vector<u16> all(e.words());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = ordered[i];
    return all;
}

// The rows of all addresses. Each register has one with another access than that.
std::uint8_t file_model::find(servobus::table of, std::size_t address, std::size_t quantity,
                              servobus::access not_this, found_rows& found) const {
    const std::vector<row>& all = rows_of(of);
    const auto first =
        std::ranges::lower_bound(all, address, {}, [](const row& r) { return r.what->address; });
    std::size_t next = address;
    auto last = first;
    while (last != all.end() && next < address + quantity) {
        if (last->what->address != next) return illegal_address;
        bool has_access = false;
        do {
            has_access = has_access || last->what->rights != not_this;
            next = last->what->address + last->what->words();
            ++last;
        } while (last != all.end() && last->what->address < next);
        if (!has_access) return illegal_address;
    }
    found = {static_cast<std::size_t>(first - all.begin()), static_cast<std::size_t>(last - first)};
    return next == address + quantity ? std::uint8_t{0} : illegal_address;
}

std::uint8_t file_model::read(servobus::bytes pdu, servobus::table of, servobus::byte_buffer out) const {
    const std::size_t address = servobus::load_word(pdu, 1), quantity = servobus::load_word(pdu, 3);
    const std::size_t most = is_of_bits(of) ? servobus::modbus::max_read_bits : facts_->max_read;
    if (pdu.size() != 5 || quantity == 0 || quantity > most) return illegal_value;
    found_rows found{};
    const std::uint8_t refusal = find(of, address, quantity, servobus::access::wo, found);
    if (refusal != 0) return refusal;
    const std::size_t size = is_of_bits(of) ? servobus::modbus::bytes_of_bits(quantity) : 2 * quantity;
    out[0] = pdu[0];
    out[1] = static_cast<std::uint8_t>(size);
    std::fill_n(out.data() + 2, size, std::uint8_t{0});
    for (std::size_t i = 0; i < found.count; ++i) {
        const row& r = rows_of(of)[found.first + i];
        const std::size_t place = r.what->address - address;
        if (is_of_bits(of)) {
            if (r.words[0] != 0)
                out[2 + place / 8] = static_cast<std::uint8_t>(out[2 + place / 8] | 1u << place % 8);
            continue;
        }
        if (r.what->rights == servobus::access::wo) continue; // a part beside others
        const std::vector<u16> words = reordered(*r.what, r.words);
        for (std::size_t k = 0; k < words.size(); ++k) {
            const std::size_t at = 2 + 2 * (place + k);
            servobus::store_word(out, at, static_cast<u16>(servobus::load_word(out, at) | words[k]));
        }
    }
    return 0;
}

bool file_model::is_named_word(std::size_t address, u16 word) const {
    const auto is_it = [&](const row& r) {
        return r.what->address == address && is_named_code(*r.what, word);
    };
    return word > 1 && std::ranges::any_of(rows_of(servobus::table::coils), is_it);
}

std::uint8_t file_model::write(servobus::bytes pdu, servobus::table of) {
    const bool is_one = is_write_of_one(pdu[0]);
    if (pdu.size() < 5 || (is_one && pdu.size() != 5)) return illegal_value;
    const std::size_t address = servobus::load_word(pdu, 1);
    const std::size_t quantity = is_one ? 1 : servobus::load_word(pdu, 3);
    servobus::bytes data = pdu.subspan(3);
    bool keeps_state = false;
    if (!is_one) {
        const std::size_t most = is_of_bits(of) ? servobus::modbus::max_write_bits : facts_->max_write;
        const std::size_t size = is_of_bits(of) ? servobus::modbus::bytes_of_bits(quantity) : 2 * quantity;
        if (quantity == 0 || quantity > most || pdu.size() != 6 + size || pdu[5] != size)
            return illegal_value;
        data = pdu.subspan(6);
    } else if (is_of_bits(of)) {
        const u16 word = servobus::load_word(data, 0);
        keeps_state = is_named_word(address, word);
        if (!keeps_state && word != servobus::modbus::coil_on && word != servobus::modbus::coil_off)
            return illegal_value;
    }
    found_rows found{};
    const std::uint8_t refusal = find(of, address, quantity, servobus::access::ro, found);
    if (refusal != 0 || keeps_state) return refusal;

    std::vector<std::vector<u16>> values;
    for (std::size_t i = 0; i < found.count; ++i) {
        const row& r = rows_of(of)[found.first + i];
        const servobus::entry& e = *r.what;
        const std::size_t place = e.address - address;
        std::vector<u16> sent;
        if (is_of_bits(of)) {
            sent = {static_cast<u16>(is_one ? data[0] != 0 : (data[place / 8] >> place % 8 & 1u) != 0)};
        } else {
            for (std::size_t k = 0; k < e.words(); ++k)
                sent.push_back(servobus::load_word(data, 2 * (place + k)));
            sent = reordered(e, sent);
        }
        if (e.is_part()) sent[0] = static_cast<u16>(sent[0] & e.form->mask());
        if (e.rights == servobus::access::ro) sent = r.words; // a part beside others
        if (e.rights != servobus::access::ro && !is_allowed(e, sent)) return illegal_value;
        values.push_back(std::move(sent));
    }
    for (std::size_t i = 0; i < found.count; ++i)
        rows_[static_cast<std::size_t>(of)][found.first + i].words = values[i];
    return 0;
}

// A device that takes blocks only has function 05 for words beside on and off.
bool file_model::takes_function(servobus::bytes pdu, servobus::table of) const {
    if (rows_of(of).empty()) return false;
    const bool is_refused = (pdu[0] == 0x05 && facts_->refuses_function_05()) ||
                            (pdu[0] == 0x06 && facts_->refuses_function_06());
    if (!is_refused) return true;
    return is_of_bits(of) && pdu.size() == 5 &&
           is_named_word(servobus::load_word(pdu, 1), servobus::load_word(pdu, 3));
}

std::size_t file_model::execute(servobus::bytes pdu, servobus::byte_buffer out) {
    const std::uint8_t code = pdu[0];
    const std::optional<servobus::table> of = table_of(code);
    if (!of || !takes_function(pdu, *of)) return servobus::modbus::put_exception(out, code, illegal_function);
    if (is_reading(code)) {
        const std::uint8_t refusal = pdu.size() < 5 ? illegal_value : read(pdu, *of, out);
        return refusal != 0 ? servobus::modbus::put_exception(out, code, refusal) : std::size_t{2} + out[1];
    }
    const std::uint8_t refusal = write(pdu, *of);
    if (refusal != 0) return servobus::modbus::put_exception(out, code, refusal);
    std::copy_n(pdu.begin(), 5, out.data());
    if (code == 0x10 && facts_->limits.echoes_byte_count) servobus::store_word(out, 3, pdu[5]);
    return 5;
}

bool file_server::is_executed(std::uint8_t code) { return table_of(code).has_value(); }

std::size_t file_server::execute(servobus::bytes frame, servobus::byte_buffer pdu) {
    // A broadcast read has no response and no effect.
    if (frame[0] == servobus::modbus::broadcast && is_reading(frame[1])) return 0;
    return model_->execute(frame.subspan(1, frame.size() - 3), pdu);
}

} // namespace tool
