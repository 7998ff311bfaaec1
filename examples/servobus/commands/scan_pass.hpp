// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A scan at one setting of the line: who responds at which address, and what else was heard.
#pragma once

#include <array>
#include <string>
#include <vector>

#include <servobus/client/identification.hpp>
#include <servobus/client/scan.hpp>

#include "../os/hear.hpp"
#include "../registers/session.hpp"
#include "../streams/progress.hpp"

namespace tool::scanning {

// Identifications have no fixed length.
using scanned_line = servobus::line<any_port, stray_bytes, servobus::echoed, servobus::modbus::open_lengths>;

struct plan {
    std::vector<std::uint32_t> rates;
    std::vector<std::string> formats;
    std::uint8_t first = 1;
    std::uint8_t last = 247;
    servobus::response_limits limits{};
    servobus::bus_gaps gaps{}; ///< without an option none
    bool has_quarantine = false;
    std::optional<servobus::duration> longest_pause{};
    serial_settings settings{}; ///< but for rate and format
    bool identifies = false;
    bool names_settings = false; ///< the command line does: a simulator may insist on its rate
    bool has_setting = true;     ///< false: a gateway has it, or the port has no wire

    bool has_several() const { return rates.size() * formats.size() > 1; }
};

struct scanned {
    std::size_t found = 0;        ///< addresses that respond
    std::size_t settings = 0;     ///< of the line
    std::size_t without_echo = 0; ///< settings at which the first request did not come back
    std::size_t of_gateway = 0;   ///< addresses for which a gateway has said that it got no response
    std::size_t echoed = 0;       ///< settings at which a request came back that should not
};

/// Asks every address of a plan on an open port.
class scan_pass {
  public:
    /// `setting`: as it is shown.
    scan_pass(any_port& port, std::string setting, const plan& p, servobus::modbus::rtu_timing timing,
              scanned& all)
        : port_{&port}, setting_{std::move(setting)}, p_{&p}, all_{&all}, on_{port, timing},
          shown_{setting_, static_cast<std::size_t>(p.last - p.first) + 1} {
        on_.echo().is_on = p.settings.keeps_echo;
    }

    /// Returns `done` or an exit status after a complaint.
    int run();

  private:
    int look_at(std::uint8_t node);
    int look_longer(std::uint8_t node, servobus::duration longest);
    int look_again();
    int fail(std::uint8_t node, servobus::status why);
    int garbled(std::uint8_t node);
    int present(std::uint8_t node, const servobus::response_limits& limits);
    void listen(servobus::duration time);
    int print(std::uint8_t node, const std::string& who);
    void say(const std::string& what);

    any_port* port_;
    std::string setting_;
    const plan* p_;
    scanned* all_;
    scanned_line on_;
    progress shown_;
    std::array<bool, 256> has_responded_{};
    line_account heard_{}; ///< while nothing was asked
    bool is_damage_said_ = false;
    bool is_over_ = false; ///< the adapter is set otherwise
};

} // namespace tool::scanning
