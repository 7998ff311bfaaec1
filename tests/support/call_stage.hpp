// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// One call of a client in one world, for run/client/call_worlds.cpp: what the device and the wire do to each of its
// requests, and the course of the call as it is seen from outside.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/line/blocking_line.hpp>
#include <tests/support/line_and_client.hpp>

#include <tests/support/scripted_port.hpp>
#include <tests/support/worn_device.hpp>

namespace tests::calls {

using namespace servobus;

namespace fixture {
using namespace servobus;

using device = tests::worn_device;
template <class T> using rw = reg<T, access::rw, device>;
inline constexpr rw<u16> light{0x0300, {0, 1000}, no_unit, 0};
inline constexpr rw<i32> place{0x0301, full<i32>, units::pulse, 0};
inline constexpr rw<i32> far_place{0x0501, full<i32>, units::pulse, 0};
inline constexpr rw<u16> kept{0x0200, {0, 1000}, no_unit, 0, saved_on_write};
inline constexpr rw<u16> address{0x0400, {1, 99}, no_unit, 1, communication};
inline constexpr rw<u16> delay{0x0402, {0, 99}, no_unit, 1, saved_on_write | communication};
inline constexpr rw<u16> order{0x0019, {0, 1}, no_unit, 0};
inline constexpr rw<u16> wear{0x0C0D, {0, 1}, no_unit, 1};
} // namespace fixture

enum class fault : std::uint8_t {
    none,
    request_lost,
    response_lost,
    damaged,
    cut,
    echoed, // the request comes back, and no response
    hurt,   // exception 1: the device says that it received a damaged request
    refused,
    accepted, // exception 5: the device goes on with it and has not finished
    end
};

enum class call : std::uint8_t {
    read_one,
    read_pair,
    read_parts, // two requests, each with a value of two words
    write_one,
    write_pair,
    write_block,
    write_kept, // with a token
    write_address,
    write_delay, // a setting of the line that is kept: with a token
    write_order,
    write_wear,
    write_wear_by_token,
    end
};

struct world {
    call what = call::read_one;
    std::array<fault, 4> faults{}; // of the requests of the call, in their order
    bool is_echo_possible = false;
    bool has_stated_order = false; // the node was made with another one than the device has
    bool learns_anew = false;      // a stepped call waits, and meanwhile word order and token are read again
    std::uint8_t retries = 2;
};

// The course of a call, as seen from outside.
struct course {
    std::vector<byte_list> frames;     // of the call
    std::vector<byte_list> afterwards; // writes after it, by the word order and the token of before its end
    std::map<std::uint16_t, std::uint16_t> words;
    errc error = errc::ok;
    outcome how = outcome::not_sent;
    std::optional<std::int64_t> value;
    std::array<unsigned, static_cast<std::size_t>(fault::end)> played{};
    bool operator==(const course&) const = default;
};

inline bool is_write(const byte_list& frame) { return frame[1] != 0x03; }

template <class Port> using full_line = line<Port>;
template <class Port> using small_line = blocking_line<Port, modbus::timing_at(115200)>;
using port_type = tests::waiting_scripted_port;

template <class Line> struct stage {
    port_type port;
    tests::register_file file;
    std::optional<Line> on;
    std::optional<client<Line, fixture::device>> drive;
    course seen;
    std::optional<ram_only> token;
    const world& in;
    std::size_t asked = 0;
    bool is_on = false;

    explicit stage(const world& of) : in{of} {
        for (const unsigned from : {0x0019u, 0x0200u, 0x0300u, 0x0400u, 0x0500u, 0x0C0Du}) {
            for (unsigned i = 0; i < 8; ++i) file.words[static_cast<std::uint16_t>(from + i)] = 0;
        }
        file.words[0x0019] = 1; // low word first
        file.words[0x0301] = 7;
        file.words[0x0501] = 9;
        file.words[0x0400] = 1;
        port.device = [this](scripted_port& p, const tests::sent_frame& f) { respond(p, f); };
        begin_line();
        node<fixture::device> at{1};
        at.read_retries = in.retries;
        if (in.has_stated_order) at.word_order = word_order::high_first;
        drive.emplace(*on, at);
        REQUIRE(drive->learn_word_order()); // rules out an echo, too
        const auto now = drive->ram_only();
        REQUIRE(now);
        token = *now;
        if (in.is_echo_possible) {
            if constexpr (Line::is_small) {
                begin_line(); // such a line never forgets
                drive.emplace(*on, at);
            } else {
                REQUIRE(on->retime(modbus::timing_at(115200)) == errc::ok);
            }
        }
        port.frames.clear();
        is_on = true;
    }
    stage(const stage&) = delete;

    void begin_line() {
        if constexpr (Line::is_small)
            on.emplace(port);
        else
            on.emplace(port, modbus::timing_at(115200));
    }

    void respond(scripted_port& p, const tests::sent_frame& f) {
        const fault now = is_on && asked < in.faults.size() ? in.faults[asked++] : fault::none;
        if (is_on) ++seen.played[static_cast<std::size_t>(now)];
        if (now == fault::request_lost) return;
        if (now == fault::echoed) return p.say(500, f.data);
        if (now == fault::hurt || now == fault::refused)
            return p.say(500, tests::exception_response(1, f.data[1], now == fault::hurt ? 1 : 4));
        byte_list said = file.response_to(f.data);
        if (now == fault::accepted) return p.say(500, tests::exception_response(1, f.data[1], 5));
        if (now == fault::response_lost) return;
        if (now == fault::damaged) said[said.size() - 3] ^= 0x10;
        if (now == fault::cut) said.resize(said.size() - 2);
        p.say(500, said);
    }

    course end(const status& how, std::optional<std::int64_t> value = {}) {
        seen.error = how.error();
        seen.how = how.outcome();
        seen.value = value;
        for (const auto& f : port.frames) seen.frames.push_back(f.data);
        seen.words = file.words;
        is_on = false;
        port.frames.clear();
        (void)drive->template write<fixture::kept>(6, *token);
        (void)drive->template write<fixture::place>(3 * units::pulse);
        for (const auto& f : port.frames) {
            if (is_write(f.data)) seen.afterwards.push_back(f.data);
        }
        return seen;
    }
    // While a stepped call waits for its turn.
    void learn_anew() {
        is_on = false;
        const auto before = port.frames;
        if (drive->learn_word_order()) {
            if (const auto now = drive->ram_only()) token = *now;
        }
        port.frames = before;
        is_on = true;
    }
};

} // namespace tests::calls
