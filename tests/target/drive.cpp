// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// How the simulated drive executes a request: RS485 manual V1.07, sections 3.1 (velocity mode), 3.2
// (position modes), 3.4 (quick stop), 3.5 (faults) and 4 (registers).
#include "drive.hpp"

#include <array>
#include <cstddef>

namespace simulated_drive {
namespace {

constexpr std::uint32_t first = 0x2000, last = 0x20B0, most_words = 32;

// The factory values of the registers that a program may read: watchdog in ms, highest speed in r/min,
// resolution of speeds, speed of moves, and the positions of two wheels that have turned a little.
constexpr auto factory = [] {
    std::array<std::uint16_t, last - first + 1> words{};
    words[0x00] = 1000;
    words[0x08] = 1000;
    words[0x22] = 1;
    words[0x8E] = 120;
    words[0x8F] = 120;
    words[0xA8] = 1;
    words[0xAA] = 2;
    return words;
}();

std::array<std::uint16_t, last - first + 1> words = factory;
std::array<std::uint8_t, 5 + 2 * most_words> response;
std::uint32_t count = 0;

// As the status word has it, for one wheel in bits 7:6.
enum class shafts : std::uint32_t { released = 0x00, locked = 0x40, emergency_stop = 0x80, alarm = 0xC0 };
shafts state = shafts::released;

struct wheel {
    std::uint32_t position_at; // 20A7h or 20A9h
    std::uint32_t target_at;   // 208Ah or 208Ch
    std::uint32_t left = 0;    // counts to the target of the move under way
    std::uint32_t moved = 0;   // counts, by moves
};
wheel wheels[]{{0xA7, 0x8A}, {0xA9, 0x8C}};

bool has_turned = false;
bool was_held = false;
bool was_reset = false;

std::uint32_t word_at(const std::uint8_t* p) { return std::uint32_t{p[0]} << 8 | p[1]; }

std::uint32_t crc(const std::uint8_t* p, std::uint32_t size) {
    std::uint32_t sum = 0xFFFF;
    for (std::uint32_t i = 0; i < size; ++i) {
        sum ^= p[i];
        for (int bit = 0; bit < 8; ++bit) sum = (sum & 1u) != 0 ? sum >> 1 ^ 0xA001u : sum >> 1;
    }
    return sum;
}

std::uint32_t pair_at(std::uint32_t at) { return std::uint32_t{words[at]} << 16 | words[at + 1]; }

void leave(shafts next) {
    state = next;
    for (wheel& w : wheels) w.left = 0;
}

// Section 3.2: a start needs an enabled position mode, and 200Fh as the code has it.
void start(wheel& w, std::uint32_t is_synchronous) {
    const std::uint32_t mode = words[0x0D];
    if (state != shafts::locked || (mode != 1 && mode != 2) || words[0x0F] != is_synchronous) return;
    w.left = pair_at(w.target_at) - (mode == 2 ? pair_at(w.position_at) : 0u);
}

// 200Eh: stop frees the shafts, quick stop holds them, enable needs a mode and no fault.
void obey(std::uint32_t code) {
    const bool is_faulted = words[0xA5] != 0;
    switch (code) {
    case 0x05:
        if (state != shafts::locked) return;
        was_held = true;
        return leave(shafts::emergency_stop);
    case 0x06:
        if (!is_faulted) return;
        was_reset = true;
        words[0xA5] = 0;
        return leave(shafts::released);
    case 0x07:
        if (!is_faulted) leave(shafts::released);
        return;
    case 0x08:
        if (!is_faulted && words[0x0D] != 0) leave(shafts::locked);
        return;
    case 0x10: start(wheels[0], 1); return start(wheels[1], 1);
    case 0x11: return start(wheels[0], 0);
    case 0x12: return start(wheels[1], 0);
    default: return;
    }
}

// Some counts of a move at each request.
void advance(wheel& w) {
    constexpr std::uint32_t most = 1000;
    const bool is_backward = w.left >> 31 != 0;
    const std::uint32_t far = is_backward ? 0u - w.left : w.left;
    const std::uint32_t counts = far < most ? far : most;
    const std::uint32_t way = is_backward ? 0u - counts : counts;
    const std::uint32_t position = pair_at(w.position_at) + way;
    words[w.position_at] = static_cast<std::uint16_t>(position >> 16);
    words[w.position_at + 1] = static_cast<std::uint16_t>(position);
    w.left -= way;
    w.moved += way;
}

// 20A2h, 20A7h..20ACh: a drive without ramps. Its wheels have their target speeds immediately (r/min; read in
// tenths). Only moves change the positions.
void move() {
    const bool has_velocity = state == shafts::locked && words[0x0D] == 3;
    std::uint32_t status = static_cast<std::uint32_t>(state) * 0x0101u;
    for (std::size_t i = 0; i < 2; ++i) {
        std::uint32_t speed = has_velocity ? words[0x88 + i] : 0u;
        if (wheels[i].left != 0) {
            speed = wheels[i].left >> 31 != 0 ? 0u - words[0x8E + i] : words[0x8E + i];
            advance(wheels[i]);
        }
        words[0xAB + i] = static_cast<std::uint16_t>(10 * speed);
        if (speed == 0) continue;
        status |= i == 0 ? 0x0100u : 0x0001u;
        has_turned = true;
    }
    words[0xA2] = static_cast<std::uint16_t>(status);
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
    const bool is_over = has_turned && state == shafts::released && words[0xAB] == 0 && words[0xAC] == 0;
    has_turned = false;
    return is_over;
}

void set_fault(std::uint32_t code) {
    words[0xA5] = static_cast<std::uint16_t>(code);
    if (code != 0) leave(shafts::alarm);
}

bool has_done_all(std::int32_t left, std::int32_t right) {
    bool is_done = was_held && was_reset && words[0xA5] == 0;
    was_held = was_reset = false;
    for (wheel& w : wheels) {
        const std::int32_t asked = &w == wheels ? left : right;
        is_done = is_done && w.left == 0 && w.moved == static_cast<std::uint32_t>(asked);
        w.moved = 0;
    }
    return is_done;
}

} // namespace simulated_drive
