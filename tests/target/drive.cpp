// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How the simulated drive executes a request: RS485 manual V1.07, sections 3.1 (velocity mode) and 4
// (registers).
#include "drive.hpp"

#include <array>
#include <cstddef>

namespace simulated_drive {
namespace {

constexpr std::uint32_t first = 0x2000, last = 0x20B0, most_words = 32;

// The factory values of the registers that a program may read: watchdog in ms, highest speed in r/min,
// resolution of speeds, and the positions of two wheels that have turned a little.
constexpr auto factory = [] {
    std::array<std::uint16_t, last - first + 1> words{};
    words[0x00] = 1000;
    words[0x08] = 1000;
    words[0x22] = 1;
    words[0xA8] = 1;
    words[0xAA] = 2;
    return words;
}();

std::array<std::uint16_t, last - first + 1> words = factory;
std::array<std::uint8_t, 5 + 2 * most_words> response;
std::uint32_t count = 0;
bool is_enabled = false;
bool has_turned = false;

std::uint32_t word_at(const std::uint8_t* p) { return std::uint32_t{p[0]} << 8 | p[1]; }

std::uint32_t crc(const std::uint8_t* p, std::uint32_t size) {
    std::uint32_t sum = 0xFFFF;
    for (std::uint32_t i = 0; i < size; ++i) {
        sum ^= p[i];
        for (int bit = 0; bit < 8; ++bit) sum = (sum & 1u) != 0 ? sum >> 1 ^ 0xA001u : sum >> 1;
    }
    return sum;
}

// 200Eh: stop and quick stop free or hold the shafts, enable needs a mode.
void obey(std::uint32_t code) {
    if (code == 0x05 || code == 0x07) is_enabled = false;
    if (code == 0x08) is_enabled = words[0x0D] != 0;
}

// 20A2h, 20ABh, 20ACh: a drive without ramps. Its wheels have their target speeds immediately (r/min; read in
// tenths).
void move() {
    const bool is_driving = is_enabled && words[0x0D] == 3;
    std::uint32_t state = is_enabled ? 0x4040u : 0u;
    for (std::size_t wheel = 0; wheel < 2; ++wheel) {
        const std::uint32_t speed = is_driving ? words[0x88 + wheel] : 0u;
        words[0xAB + wheel] = static_cast<std::uint16_t>(10 * speed);
        if (speed == 0) continue;
        state |= wheel == 0 ? 0x0100u : 0x0001u;
        has_turned = true;
    }
    words[0xA2] = static_cast<std::uint16_t>(state);
}

// Returns false for an address that cannot be written.
bool write(std::uint32_t address, std::uint32_t value) {
    if (address < first || address >= first + 0xA0) return false;
    words[address - first] = static_cast<std::uint16_t>(value);
    if (address == first + 0x0E) obey(value);
    return true;
}

// Makes the response and returns its size without the CRC. What it cannot execute gets exception 2.
std::uint32_t execute(const std::uint8_t* request, std::uint32_t size) {
    for (std::size_t i = 0; i < 6; ++i) response[i] = request[i];
    const std::uint32_t address = word_at(request + 2);
    const std::uint32_t quantity = word_at(request + 4);
    if (request[1] == 0x03 && size == 8 && quantity <= most_words && address >= first &&
        address + quantity <= last + 1) {
        response[2] = static_cast<std::uint8_t>(2 * quantity);
        for (std::uint32_t i = 0; i < quantity; ++i) {
            response[3 + 2 * i] = static_cast<std::uint8_t>(words[address - first + i] >> 8);
            response[4 + 2 * i] = static_cast<std::uint8_t>(words[address - first + i] & 0xFFu);
        }
        return 3 + 2 * quantity;
    }
    if (request[1] == 0x06 && size == 8 && write(address, quantity)) return 6;
    if (request[1] == 0x10 && size == 9 + 2 * quantity && request[6] == 2 * quantity) {
        bool is_written = true;
        for (std::uint32_t i = 0; i < quantity; ++i)
            is_written = write(address + i, word_at(request + 7 + 2 * i)) && is_written;
        if (is_written) return 6;
    }
    response[1] = static_cast<std::uint8_t>(request[1] | 0x80u);
    response[2] = 0x02;
    return 3;
}

} // namespace

frame answer(const std::uint8_t* request, std::uint32_t size) {
    if (size < 8 || request[0] != 1) return {};
    const std::uint32_t sum = crc(request, size - 2);
    if (request[size - 2] != (sum & 0xFFu) || request[size - 1] != sum >> 8) return {};
    std::uint32_t filled = execute(request, size);
    move();
    ++count;
    const std::uint32_t own = crc(response.data(), filled);
    response[filled++] = static_cast<std::uint8_t>(own & 0xFFu);
    response[filled++] = static_cast<std::uint8_t>(own >> 8);
    return {response.data(), response.data() + filled};
}

std::uint32_t answered() { return count; }

bool has_run() {
    const bool is_over = has_turned && !is_enabled && words[0xAB] == 0 && words[0xAC] == 0;
    has_turned = false;
    return is_over;
}

} // namespace simulated_drive
