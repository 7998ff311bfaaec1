// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "file_model.hpp"

#include <algorithm>

#include <servobus/modbus/bits.hpp>
#include <servobus/modbus/pdu.hpp>

#include "../device_file/map_text.hpp"

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

bool is_allowed(const servobus::entry& e, u32 bits) { return e.takes(e.number(bits)); }

} // namespace

file_model::file_model(const device& of, std::uint8_t node, std::uint32_t baud)
    : facts_{&of.facts()}, node_{node}, baud_{baud} {
    for (const servobus::table t : all_tables) {
        for (const servobus::entry& e : of.rows_of(t)) {
            const std::int64_t initial = e.initial != servobus::no_default ? e.initial : 0;
            const std::int64_t value = std::clamp(initial, e.limits.low, e.limits.high);
            rows_[static_cast<std::size_t>(t)].push_back({&e, static_cast<u32>(value)});
        }
    }
}

bool file_model::is_high_first(const servobus::entry& e) const {
    using enum servobus::word_order;
    if (e.own_word_order != unknown) return e.own_word_order == high_first;
    if (facts_->word_order != unknown) return facts_->word_order == high_first;
    for (const row& r : rows_of(servobus::table::holding_registers)) {
        if (r.what->address == facts_->word_order_register) return r.bits == 0;
    }
    return true;
}

// The rows of all addresses, none of them without that access.
std::uint8_t file_model::find(servobus::table of, std::size_t address, std::size_t quantity,
                              servobus::access not_this, found_rows& found) const {
    const std::vector<row>& all = rows_of(of);
    const auto first =
        std::ranges::lower_bound(all, address, {}, [](const row& r) { return r.what->address; });
    std::size_t next = address;
    auto last = first;
    for (; last != all.end() && next < address + quantity; ++last) {
        if (last->what->address != next || last->what->rights == not_this) return illegal_address;
        next += last->what->words();
    }
    found = {static_cast<std::size_t>(first - all.begin()), static_cast<std::size_t>(last - first)};
    return next == address + quantity ? std::uint8_t{0} : illegal_address;
}

std::uint8_t file_model::read(servobus::bytes pdu, servobus::table of, servobus::byte_buffer out) const {
    const std::size_t quantity = servobus::load_word(pdu, 3);
    const std::size_t most = is_of_bits(of) ? servobus::modbus::max_read_bits : facts_->max_read;
    if (pdu.size() != 5 || quantity == 0 || quantity > most) return illegal_value;
    found_rows found{};
    const std::uint8_t refusal = find(of, servobus::load_word(pdu, 1), quantity, servobus::access::wo, found);
    if (refusal != 0) return refusal;
    const std::size_t size = is_of_bits(of) ? servobus::modbus::bytes_of_bits(quantity) : 2 * quantity;
    out[0] = pdu[0];
    out[1] = static_cast<std::uint8_t>(size);
    std::fill_n(out.data() + 2, size, std::uint8_t{0});
    std::size_t at = 2;
    for (std::size_t i = 0; i < found.count; ++i) {
        const row& r = rows_of(of)[found.first + i];
        if (is_of_bits(of)) {
            if (r.bits != 0) out[2 + i / 8] = static_cast<std::uint8_t>(out[2 + i / 8] | 1u << i % 8);
            continue;
        }
        const u16 low = static_cast<u16>(r.bits), high = static_cast<u16>(r.bits >> 16);
        const bool is_pair = r.what->words() == 2;
        servobus::store_word(out, at, is_pair && is_high_first(*r.what) ? high : low);
        if (is_pair) servobus::store_word(out, at + 2, is_high_first(*r.what) ? low : high);
        at += 2 * r.what->words();
    }
    return 0;
}

std::uint8_t file_model::write(servobus::bytes pdu, servobus::table of) {
    const bool is_one = is_write_of_one(pdu[0]);
    if (pdu.size() < 5 || (is_one && pdu.size() != 5)) return illegal_value;
    const std::size_t quantity = is_one ? 1 : servobus::load_word(pdu, 3);
    servobus::bytes data = pdu.subspan(3);
    if (!is_one) {
        const std::size_t most = is_of_bits(of) ? servobus::modbus::max_write_bits : facts_->max_write;
        const std::size_t size = is_of_bits(of) ? servobus::modbus::bytes_of_bits(quantity) : 2 * quantity;
        if (quantity == 0 || quantity > most || pdu.size() != 6 + size || pdu[5] != size)
            return illegal_value;
        data = pdu.subspan(6);
    } else if (is_of_bits(of)) {
        const u16 word = servobus::load_word(data, 0);
        if (word != servobus::modbus::coil_on && word != servobus::modbus::coil_off) return illegal_value;
    }
    found_rows found{};
    const std::uint8_t refusal = find(of, servobus::load_word(pdu, 1), quantity, servobus::access::ro, found);
    if (refusal != 0) return refusal;

    std::vector<u32> values;
    std::size_t at = 0;
    for (std::size_t i = 0; i < found.count; ++i) {
        const servobus::entry& e = *rows_of(of)[found.first + i].what;
        u32 bits = 0;
        if (is_of_bits(of)) {
            bits = is_one ? u32{data[0] != 0} : u32{data[i / 8]} >> i % 8 & 1u;
        } else {
            const u32 first = servobus::load_word(data, at);
            const u32 second = e.words() == 2 ? servobus::load_word(data, at + 2) : u32{0};
            bits = e.words() == 1 ? first : is_high_first(e) ? first << 16 | second : second << 16 | first;
            at += 2 * e.words();
        }
        if (!is_allowed(e, bits)) return illegal_value;
        values.push_back(bits);
    }
    for (std::size_t i = 0; i < found.count; ++i)
        rows_[static_cast<std::size_t>(of)][found.first + i].bits = values[i];
    return 0;
}

std::size_t file_model::execute(servobus::bytes pdu, servobus::byte_buffer out) {
    const std::uint8_t code = pdu[0];
    const std::optional<servobus::table> of = table_of(code);
    const bool has_table = of && !rows_of(*of).empty();
    if (!has_table) return servobus::modbus::put_exception(out, code, illegal_function);
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
