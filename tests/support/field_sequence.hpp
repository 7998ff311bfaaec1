// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Requests that programs of others have sent to real drives (tests/field/*.txt), played to a simulated one. A line is
//     > 01 06 20 0E 00 08 = echo     a request without its CRC, and the response
//     wait 500                       milliseconds
//     restart                        the drive is switched off and on
//     switch enables_without_mode=yes    the simulated drive's switch under which the sequence plays
// The response is `echo`, the request's own bytes; `ack10`, the acknowledgement of 10h; or its bytes without the CRC.
// `ex` is any exception, `any` anything else, and `moves` a word that is not 0. A comment stands behind #.
#pragma once

#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <servobus/sim/line.hpp>
#include <servobus/sim/station.hpp>

#include <tests/support/scripted_port.hpp>

namespace field {

using frame = std::vector<std::uint8_t>;

struct line {
    unsigned number = 0; ///< in the file
    frame request{};     ///< without the CRC; empty: a wait
    std::string wanted{};
    std::uint32_t wait_ms = 0;
    bool is_restart = false;
};

inline frame bytes_of(const std::string& hex) {
    frame all;
    std::istringstream words{hex};
    for (std::string word; words >> word;)
        all.push_back(static_cast<std::uint8_t>(std::stoul(word, nullptr, 16)));
    return all;
}

/// The lines of a file below tests/field; empty if it cannot be read.
inline std::vector<line> sequence(const std::string& name) {
    std::ifstream file{"tests/field/" + name + ".txt"};
    std::vector<line> all;
    unsigned number = 0;
    for (std::string text; std::getline(file, text);) {
        ++number;
        text = text.substr(0, text.find('#'));
        if (text.starts_with("restart")) {
            all.push_back({.number = number, .is_restart = true});
        } else if (text.starts_with("wait")) {
            all.push_back(
                {.number = number, .wait_ms = static_cast<std::uint32_t>(std::stoul(text.substr(4)))});
        } else if (text.starts_with(">")) {
            const std::size_t equals = text.find('=');
            std::string wanted = text.substr(equals + 1);
            wanted.erase(0, wanted.find_first_not_of(' '));
            wanted.erase(wanted.find_last_not_of(' ') + 1);
            all.push_back(
                {.number = number, .request = bytes_of(text.substr(1, equals - 1)), .wanted = wanted});
        }
    }
    return all;
}

/// True if a response, without its CRC, is as the line wants it.
inline bool is_wanted(const line& of, const frame& got) {
    if (got.size() < 3 || got[0] != of.request[0]) return false;
    const bool is_exception = (got[1] & 0x80u) != 0;
    if (of.wanted == "ex") return is_exception;
    if (of.wanted == "any") return !is_exception;
    if (of.wanted == "moves") {
        for (std::size_t i = 3; i < got.size(); ++i) {
            if (got[i] != 0) return !is_exception;
        }
        return false;
    }
    if (of.wanted == "echo") return got == of.request;
    if (of.wanted == "ack10") return got == frame(of.request.begin(), of.request.begin() + 6);
    return got == bytes_of(of.wanted);
}

/// Plays a sequence to a drive: the numbers of the lines that got another response, or none.
template <class Drive> std::vector<unsigned> mismatches(Drive& drive, const std::string& name) {
    servobus::sim::station station{drive};
    servobus::sim::virtual_line wire{drive.baud()};
    wire.attach(station);
    std::vector<unsigned> wrong;
    for (const line& l : sequence(name)) {
        wire.pass(servobus::milliseconds(l.request.empty() ? l.wait_ms : 3));
        if (l.is_restart) drive.power_cycle();
        if (l.request.empty()) continue;
        const frame sent = tests::framed(l.request);
        (void)wire.send(sent);
        wire.pass(servobus::milliseconds(100));
        frame got(260);
        const auto came = wire.receive(got);
        const std::size_t size = came ? *came : 0u;
        got.resize(size);
        const frame whole = got;
        got.resize(size < 2 ? 0 : size - 2);
        if (whole != tests::framed(got) || !is_wanted(l, got)) wrong.push_back(l.number);
    }
    return wrong;
}

} // namespace field
