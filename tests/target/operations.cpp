// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Each operation of the protocol in a separate function, `measured_...`: the CRC by each engine, building
// requests, parsing a response. The job calls them one after the other. The compiler knows none of the
// inputs.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <servobus/modbus/crc_tables.hpp>
#include <servobus/modbus/rtu.hpp>

#include "board.hpp"

namespace {

using namespace servobus;
using namespace servobus::modbus;

std::array<std::uint8_t, 32> room;
std::array<std::uint16_t, 8> words{1, 2, 3, 4, 5, 6, 7, 8};
alignas(4) std::array<std::uint8_t, 264> message;

byte_buffer pdu() { return byte_buffer{room}.subspan(1); }

// Short and long frames, and the long ones at an odd address.
template <class Measured> bool all_lengths(Measured crc) {
    const std::uint8_t* const p = message.data();
    return (crc(p, 8) | crc(p, 64) | crc(p, 256) | crc(p + 1, 64) | crc(p + 1, 256)) != 0;
}

} // namespace

extern "C" {

[[gnu::noipa]] void prepare() {
    for (std::size_t i = 0; i < message.size(); ++i) message[i] = static_cast<std::uint8_t>(17 * i);
    room = {0x01, 0x03, 0x10, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x01, 0x00,
            0x00, 0x00, 0x02, 0x00, 0x00, 0x32, 0x00, 0x32, 0x94, 0x64};
}

[[gnu::noipa]] std::uint16_t measured_bitwise(const std::uint8_t* p, std::size_t n) {
    return crc16<crc_bitwise>({p, n});
}
[[gnu::noipa]] std::uint16_t measured_table16(const std::uint8_t* p, std::size_t n) {
    return crc16<crc_table16>({p, n});
}
[[gnu::noipa]] std::uint16_t measured_table256(const std::uint8_t* p, std::size_t n) {
    return crc16<crc_table256>({p, n});
}
[[gnu::noipa]] std::uint16_t measured_trinomial8(const std::uint8_t* p, std::size_t n) {
    return crc16<crc_trinomial<8>>({p, n});
}
[[gnu::noipa]] std::uint16_t measured_trinomial16(const std::uint8_t* p, std::size_t n) {
    return crc16<crc_trinomial<16>>({p, n});
}
[[gnu::noipa]] std::uint16_t measured_trinomial32(const std::uint8_t* p, std::size_t n) {
    return crc16<crc_trinomial<32>>({p, n});
}

[[gnu::noipa]] bool measured_build_06(std::uint8_t node_address, std::uint16_t address, std::uint16_t value) {
    room[0] = node_address;
    return close_frame(room, put_write_request(pdu(), address, value)) == 8;
}
[[gnu::noipa]] bool measured_build_03(std::uint8_t node_address, std::uint16_t address,
                                      std::uint16_t quantity) {
    room[0] = node_address;
    constexpr function code = function::read_holding_registers;
    return close_frame(room, put_read_request(pdu(), code, address, quantity)) == 8;
}
[[gnu::noipa]] bool measured_build_10h(std::uint8_t node_address, std::uint16_t address,
                                       std::size_t quantity) {
    room[0] = node_address;
    const std::span<const std::uint16_t> values{words.data(), quantity};
    return close_frame(room, put_write_request(pdu(), address, values)) == 25;
}
[[gnu::noipa]] bool measured_parse_03(std::uint8_t node_address, std::size_t size, std::size_t quantity) {
    const result<opened> f = open_frame(bytes{room}.first(size));
    if (!f || f->address != node_address) return false;
    const result<response> r = parse_response(f->pdu);
    if (!r || r->code != 0x03 || r->is_exception || r->quantity != quantity) return false;
    r->values().copy_to(std::span{words}.first(quantity));
    return true;
}

bool job() {
    prepare();
    const bool has_crc = all_lengths(measured_bitwise) && all_lengths(measured_table16) &&
                         all_lengths(measured_table256) && all_lengths(measured_trinomial8) &&
                         all_lengths(measured_trinomial16) && all_lengths(measured_trinomial32);
    const bool is_parsed = measured_parse_03(1, 21, 8) && words[7] == 0x32;
    return has_crc && is_parsed && measured_build_06(1, 0x2088, 60) && measured_build_03(1, 0x20A5, 8) &&
           measured_build_10h(1, 0x2088, 8);
}
}
