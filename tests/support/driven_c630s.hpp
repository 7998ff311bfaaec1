// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A C630S drive facade that controls the simulated drive over a virtual line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <servobus/device/c630s.hpp>
#include <tests/support/simulated_c630s.hpp>

namespace simulated {

struct driven_c630s : simulated_c630s {
    using drive_type = servobus::c630s::drive<line_type>;
    using frame = std::vector<std::uint8_t>;

    drive_type drive{line, 1, servobus::unsupervised};

    using simulated_c630s::simulated_c630s;

    /// Initialises the drive and sets it up, with a power cycle if the setup needs one.
    bool make_ready() {
        using namespace servobus::c630s;
        if (!drive.run(init{}) || !drive.run(set_up{})) return false;
        if (drive.needs_power_cycle()) {
            model.power_cycle();
            if (!drive.run(init{})) return false;
        }
        return drive.state() == drive_state::disabled;
    }

    /// Lets time pass while the program reads feedback.
    bool live(servobus::duration time) {
        const std::uint64_t end = wire.time_us() + time.us;
        while (wire.time_us() < end) {
            if (!drive.read()) return false;
            wire.pass(servobus::milliseconds(50));
        }
        return true;
    }

    /// One iteration of a superloop.
    void turn() {
        const servobus::duration idle = drive.step();
        wire.wait(idle.us == 0 ? servobus::microseconds(10) : idle);
    }
    void loop(std::uint32_t ms) {
        const std::uint64_t end = wire.time_us() + std::uint64_t{ms} * 1000u;
        while (wire.time_us() < end) turn();
    }

    /// The words that were written to this address, in the order in which they were sent.
    std::vector<std::uint16_t> written_to(std::uint16_t address) const {
        std::vector<std::uint16_t> words;
        for (const frame& f : requests) {
            if (!servobus::modbus::is_write(f[1])) continue;
            const unsigned first = servobus::load_word(f, 2);
            const unsigned count = f[1] == 0x06 ? 1u : servobus::load_word(f, 4);
            if (address < first || address >= first + count) continue;
            words.push_back(servobus::load_word(f, f[1] == 0x06 ? 4u : 7u + 2u * (address - first)));
        }
        return words;
    }

    std::int64_t r_per_min() const {
        const std::int64_t micro = model.speed();
        return (micro + (micro < 0 ? -500'000 : 500'000)) / 1'000'000;
    }
};

} // namespace simulated
