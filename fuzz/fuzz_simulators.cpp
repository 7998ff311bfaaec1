// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The simulated drives: any writes at any time, while inputs, shafts and power change. There is no undefined
// behaviour, a refused write changes nothing, and a register of the map can always be read.
#include <array>
#include <cstdint>
#include <span>

#include <servobus/device/c630s/catalogue.hpp>
#include <servobus/device/yako/closed_loop_catalogue.hpp>
#include <servobus/device/yako/open_loop_catalogue.hpp>
#include <servobus/device/zlac8015d/catalogue.hpp>
#include <servobus/modbus/server.hpp>
#include <servobus/sim/c630s.hpp>
#include <servobus/sim/yako.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include "support.hpp"

using namespace servobus;
using fuzz::require;

namespace {

void disturb(sim::yako_drive& drive, unsigned what, std::uint16_t with) {
    switch (what % 6) {
    case 0: return drive.power_cycle();
    case 1: return drive.raise_alarm(with);
    case 2: return drive.end_alarm();
    case 3: return drive.set_input(with % 4u, (with & 0x100u) != 0);
    case 4: return drive.block_shaft((with & 1u) != 0);
    default: return drive.push_shaft(static_cast<std::int16_t>(with));
    }
}
void disturb(sim::c630s& drive, unsigned what, std::uint16_t with) {
    switch (what % 7) {
    case 0: return drive.power_cycle();
    case 1: return drive.end_causes();
    case 2: return drive.set_input(1u + with % 8u, (with & 0x100u) != 0);
    case 3: return drive.block_shaft((with & 1u) != 0);
    case 4: return drive.send_pulses(static_cast<std::int16_t>(with));
    case 5: return drive.set_bus_voltage(with);
    default: return drive.set_module_temperature(static_cast<std::int16_t>(with));
    }
}
void disturb(sim::zlac8015d& drive, unsigned, std::uint16_t) { drive.power_cycle(); }

// The time in us that an input may let pass: 800 ticks of a drive in motion. One first byte in sixteen gives ten
// times as many, for a whole homing and for slow ramps.
template <class Model> constexpr std::uint32_t short_life = 200'000;
template <> constexpr std::uint32_t short_life<sim::c630s> = 800'000;

template <class Model> void run(fuzz::input& in, bool is_long, const servobus::catalogue& map) {
    Model drive;
    const modbus::server_rules rules = modbus::rules_of(drive);
    instant now{0xFFFF'0000u};
    std::uint32_t left = short_life<Model> * (is_long ? 10 : 1);
    std::array<std::uint8_t, modbus::max_pdu> request{};
    std::array<std::uint8_t, modbus::max_pdu> response{};
    drive.advance(now);
    while (!in.empty()) {
        const unsigned what = in.byte();
        const entry& e = map.entries[in.word() % map.entries.size()];
        const std::uint16_t value = in.word();
        std::size_t size = 0;
        const auto count = static_cast<std::uint16_t>(1u + (what >> 4 & 7u));
        switch (what % 8) {
        case 0:
        case 1:
        case 2: size = modbus::put_write_request(request, e.address, value); break;
        case 3: {
            std::array<std::uint16_t, 8> words{};
            for (std::size_t i = 0; i < count; ++i) words[i] = i == 0 ? value : in.word();
            size = modbus::put_write_request(request, e.address,
                                             std::span<const std::uint16_t>{words}.first(count));
            break;
        }
        case 4:
            size =
                modbus::put_read_request(request, modbus::function::read_holding_registers, e.address, count);
            break;
        case 5: disturb(drive, what / 8, value); break;
        default: {
            const std::uint32_t wanted = value % 4u == 3 ? value * 40u : value; // up to 2.6 s
            const std::uint32_t us = wanted < left ? wanted : left;
            now = now + duration{us};
            left -= us;
        }
        }
        drive.advance(now);
        if (size != 0) {
            const std::uint32_t writes = drive.writes();
            const std::size_t got = respond(drive, bytes{request}.first(size), response, rules);
            require(got >= 2, "a drive responds to every request");
            if ((response[0] & 0x80u) != 0)
                require(drive.writes() == writes, "G14 a refused write has changed nothing");
        }
        if (e.rights == access::wo) continue;
        std::array<std::uint16_t, 2> held{};
        require(drive.read(e.address, std::span<std::uint16_t>{held}.first(e.words())) == 0,
                "a register of the map can be read");
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::input in{data, size};
    const unsigned kind = in.byte();
    const bool is_long = kind >= 0xF0;
    switch (kind % 4) {
    case 0: run<sim::zlac8015d>(in, is_long, zlac8015d::catalogue); break;
    case 1: run<sim::yako_closed_loop>(in, is_long, yako::closed_loop::catalogue); break;
    case 2: run<sim::yako_open_loop>(in, is_long, yako::open_loop::catalogue); break;
    default: run<sim::c630s>(in, is_long, c630s::catalogue);
    }
    return 0;
}
