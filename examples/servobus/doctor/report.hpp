// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The output of `servobus doctor`: a line a finding, and how many there were.
#pragma once

#include <string>

#include "../registers/session.hpp"
#include "check.hpp"

namespace tool::diagnosis {

/// The findings about one device. The first word of a line says how bad it is.
class report {
  public:
    /// `options`: those of the line, with a blank in front, as a command that mends something needs them. `is_long`:
    /// each register that differs has a line.
    report(std::string port, std::string device, std::string options, bool is_long)
        : port_{std::move(port)}, device_{std::move(device)}, options_{std::move(options)}, is_long_{
                                                                                                is_long} {}

    /// About the port or the line. `act`: what to try; empty: nothing.
    void line(const std::string& what) { say("line", what); }
    void refuse(const std::string& what, const std::string& act);
    void warn(const std::string& what, const std::string& act);
    bool has_refusal() const { return refusals_ != 0; }
    /// A register that could not be read. `is_needed`: to judge whether an enable is refused.
    void unread(const std::string& what, bool is_needed);
    void differ(const std::string& what);
    /// A register of a device from a file, which no finding has.
    void differ_from_default(const std::string& value, const std::string& initial);
    void finding(const check& c, const held_registers& held, const servobus::catalogue& map);

    /// ` --echo on` if the command line has it.
    std::string echo_option() const {
        return options_.find(" --echo on") != options_.npos ? " --echo on" : "";
    }
    /// `servobus COMMAND PORT DEVICE REST`, with the options of the line.
    std::string command(const std::string& name, const std::string& rest = "") const {
        return command_for(device_, name, rest);
    }
    /// The same for another device, `c630s:2`.
    std::string command_for(const std::string& device, const std::string& name,
                            const std::string& rest = "") const;

    /// Prints how many findings there are. Returns the exit status.
    int end(bool can_be_enabled);

  private:
    void say(const char* word, const std::string& text, const std::string& act = "");

    std::string port_;
    std::string device_;
    std::string options_;
    bool is_long_;
    unsigned refusals_ = 0;
    unsigned others_ = 0;
    unsigned changed_ = 0; ///< differ from their defaults
    unsigned unknown_ = 0; ///< unread, and needed
};

} // namespace tool::diagnosis
