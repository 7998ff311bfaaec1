// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A ZLAC8015D drive facade that controls the simulated drive over a virtual line, and a log of the requests
// on the wire.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <servobus/device/zlac8015d.hpp>
#include <servobus/servobus.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/zlac8015d.hpp>
#include <tests/support/transaction_fault.hpp>

namespace simulated {

using frame = std::vector<std::uint8_t>;

/// Logs the requests on the wire; finds their ends by function and byte count.
struct request_log {
    std::vector<frame> frames;
    frame open;

    static void note(void* self, const servobus::sim::wire_byte& b) {
        if (!b.is_from_client) return;
        auto& log = *static_cast<request_log*>(self);
        log.open.push_back(b.value);
        if (log.open.size() == servobus::modbus::request_length(log.open)) {
            log.frames.push_back(log.open);
            log.open.clear();
        }
    }
};

inline constexpr auto zero_targets =
    servobus::modbus::write_frame(1, 0x2088, std::array<std::uint16_t, 2>{0, 0});

/// True for a frame that enables the drive, starts a move or sets a target other than zero.
inline bool is_motion_or_enable(servobus::bytes f) {
    if (f.size() < 8 || !servobus::modbus::is_write(f[1])) return false;
    const unsigned address = servobus::load_word(f, 2);
    if (address == 0x200E) return f[5] >= 0x08; // enable and starts
    if (address < 0x2088 || address > 0x2091) return false;
    for (std::size_t i = f[1] == 0x06 ? 4 : 7; i + 2 < f.size(); ++i) {
        if (f[i] != 0) return true;
    }
    return false;
}

/// True if both wheels turn with about 2 r/min or less.
inline bool are_slow(const servobus::sim::zlac8015d& model) {
    const auto is_slow = [](const servobus::sim::wheel_view& w) {
        return w.speed < 2'100'000 && w.speed > -2'100'000;
    };
    return is_slow(model.left()) && is_slow(model.right());
}

struct driven_zlac8015d {
    refusing<servobus::sim::zlac8015d> model;
    servobus::sim::station<refusing<servobus::sim::zlac8015d>> station{model};
    servobus::sim::virtual_line wire;
    using line_type = servobus::line<servobus::sim::virtual_line>;
    line_type line{wire, servobus::modbus::timing_at(115200)};
    servobus::zlac8015d::drive<line_type> drive;
    request_log log;
    servobus::sim::zlac8015d_options interpretations;
    std::uint32_t saves = 0; // number of saves before the test began

    /// The brakes are released, whichever code does that, and remain released after a restart. `seed`: of the faults
    /// of the line.
    explicit driven_zlac8015d(servobus::sim::zlac8015d_options options = {},
                              const servobus::supervision& by = servobus::unsupervised,
                              std::uint64_t seed = 1,
                              const servobus::node<servobus::zlac8015d::device>& at =
                                  servobus::node<servobus::zlac8015d::device>{1})
        : model{options}, wire{115200, seed}, drive{line, at, by}, interpretations{options} {
        if (options.code_1 == servobus::sim::zlac8015d_options::brake::releases) {
            set_by_hand(0x201A, 1);
            set_by_hand(0x201B, 1);
            save_by_hand();
        }
        wire.attach(station);
        wire.set_hook(&request_log::note, &log);
    }

    /// Lets time pass while the program reads feedback, so that the drive's watchdog does not expire.
    bool live(servobus::duration time) {
        const std::uint64_t end = wire.time_us() + time.us;
        while (wire.time_us() < end) {
            if (!drive.read()) return false;
            wire.pass(servobus::milliseconds(50));
        }
        return true;
    }

    /// Sets a register without a request, as if it had been set up before the test.
    void set_by_hand(std::uint16_t address, std::uint16_t value) {
        const std::array<std::uint8_t, 2> word{static_cast<std::uint8_t>(value >> 8),
                                               static_cast<std::uint8_t>(value & 0xFFu)};
        (void)model.write(address, servobus::words_view{word});
    }
    /// Speeds count 1/n r/min: set, saved and powered off and on before the test.
    void have_resolution(std::uint16_t n) {
        model.store(0x2022, n);
        model.power_cycle();
    }
    void save_by_hand() {
        set_by_hand(0x2010, 1);
        saves = model.saves();
    }

    /// Requests logged so far that equal this frame.
    std::size_t sent(servobus::bytes wanted) const {
        std::size_t n = 0;
        for (const frame& f : log.frames) n += servobus::same_bytes(f, wanted) ? 1u : 0u;
        return n;
    }
};

/// A drive whose speeds count 0.1 r/min, as `resolution{10}` and a power cycle leave it.
struct finer_zlac8015d : driven_zlac8015d {
    explicit finer_zlac8015d(servobus::sim::zlac8015d_options options = {},
                             const servobus::supervision& by = servobus::unsupervised, std::uint64_t seed = 1)
        : driven_zlac8015d{options, by, seed} {
        have_resolution(10);
    }
};

} // namespace simulated
