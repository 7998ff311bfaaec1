// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The job written by hand, without the library: the floor of the picture in bench/README.md. Two constant frames with
// their CRC; a response is awaited for 100 ms, and its length and CRC are checked by a table of 16 entries. It keeps
// none of the promises: no gap, no check of address, function and counts, no exception, no retry, no late response.
#include "board.hpp"

namespace {

constexpr std::uint16_t crc_of_four_bits[16] = {
    0x0000, 0xCC01, 0xD801, 0x1400, 0xF001, 0x3C00, 0x2800, 0xE401,
    0xA001, 0x6C00, 0x7800, 0xB401, 0x5000, 0x9C01, 0x8801, 0x4400,
};
constexpr std::uint32_t crc_over(const std::uint8_t* data, std::uint32_t size) {
    std::uint32_t crc = 0xFFFF;
    for (const std::uint8_t* const end = data + size; data != end; ++data) {
        crc ^= *data;
        crc = crc >> 4 ^ crc_of_four_bits[crc & 15u];
        crc = crc >> 4 ^ crc_of_four_bits[crc & 15u];
    }
    return crc;
}

constexpr std::uint8_t read_state[] = {0x01, 0x03, 0x20, 0xA5, 0x00, 0x08, 0x5F, 0xEF};
constexpr std::uint8_t write_speeds[] = {0x01, 0x10, 0x20, 0x88, 0x00, 0x02, 0x04,
                                         0x00, 0x3C, 0x00, 0x32, 0x22, 0x71};
static_assert(crc_over(read_state, sizeof read_state) == 0);
static_assert(crc_over(write_speeds, sizeof write_speeds) == 0);

bool exchange(const std::uint8_t* request, std::uint32_t size, std::uint8_t* response, std::uint32_t length) {
    uart_send(request, size);
    while (!uart_sent()) {}
    const std::uint32_t begin = clock_us();
    for (std::uint32_t count = 0; count < length;) {
        const std::int32_t byte = uart_receive();
        if (byte >= 0)
            response[count++] = static_cast<std::uint8_t>(byte);
        else if (clock_us() - begin >= 100'000)
            return false;
    }
    return crc_over(response, length) == 0;
}

std::int32_t position_at(const std::uint8_t* bytes) {
    return static_cast<std::int32_t>(std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 |
                                     std::uint32_t{bytes[2]} << 8 | bytes[3]);
}

} // namespace

extern "C" bool job() {
    std::uint8_t response[21];
    return exchange(read_state, sizeof read_state, response, 21) &&
           position_at(response + 7) < position_at(response + 11) &&
           exchange(write_speeds, sizeof write_speeds, response, 8);
}
