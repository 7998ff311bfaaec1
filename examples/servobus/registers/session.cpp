// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A drive on an open port: its settings from the command line, and failures in words.
#include "session.hpp"

#include <algorithm>

#include "../devices/devices.hpp"
#include "../streams/messages.hpp"
#include "../words/numbers.hpp"

namespace tool {

std::optional<target> parse_target(std::string_view text) {
    const device_word word = split_device(text);
    target t;
    if (word.name != "raw") {
        t.kind = find_device(word.name);
        if (t.kind == nullptr) return std::nullopt;
    }
    const servobus::profile& facts = t.facts();
    if (!word.node) {
        t.node = std::max(t.node, facts.lowest_address);
        return t;
    }
    t.has_node = true;
    const std::optional<std::int64_t> node = parse_integer(*word.node);
    const bool is_peer =
        node && (*node == servobus::modbus::broadcast || *node == servobus::modbus::peer_address);
    if (t.kind == nullptr && is_peer) {
        t.node = servobus::modbus::peer_address;
        t.peer_unit = static_cast<std::uint8_t>(*node);
        return t;
    }
    if (!node || *node < facts.lowest_address || *node > facts.highest_address) {
        complain(usage, "'" + std::string{*word.node} + "' is no node address of " + facts.name + ": " +
                            std::to_string(facts.lowest_address) + " to " +
                            std::to_string(facts.highest_address));
        return std::nullopt;
    }
    t.node = static_cast<std::uint8_t>(*node);
    t.peer_unit = t.is_peer() ? t.node : std::uint8_t{0};
    return t;
}

int refuse_peer(const target& of) {
    const std::string unit = std::to_string(of.peer_unit);
    return complain(usage, "unit " + unit + " is the device itself on mbap://HOST; on a serial line " + unit +
                               (of.peer_unit == servobus::modbus::broadcast
                                    ? " is a broadcast, which no node responds to"
                                    : " is reserved") +
                               ": take a node from 1 to 247");
}

// Modbus Application Protocol V1.1b3, 7.
static const char* gateway_words(std::uint8_t number) {
    return number == 0x0A ? "gateway path unavailable" : "gateway target device failed to respond";
}

// The device's own words, or those of the standard.
static const char* exception_words(const servobus::profile& facts, std::uint8_t number) {
    for (const auto& table : {facts.exceptions, any_device::facts.exceptions}) {
        for (const servobus::exception_meaning& e : table) {
            if (e.number == number) return e.words;
        }
    }
    return number == 0x0A || number == 0x0B ? gateway_words(number) : "unknown exception";
}

std::string why_text(const target& of, servobus::status why, const any_port& port) {
    if (std::string words = port.diagnosis(why); !words.empty()) return words;
    if (why.error() == servobus::errc::exception) {
        return "refused, exception " + std::to_string(why.exception()) + " (" +
               exception_words(of.facts(), why.exception()) + ")";
    }
    std::string words = servobus::text(why.error());
    if (why.error() == servobus::errc::gateway_exception)
        words +=
            " (exception " + std::to_string(why.exception()) + ", " + gateway_words(why.exception()) + ")";
    if (why.error() == servobus::errc::port_lost && port.os_error() != 0)
        words += std::string{": "} + os::error_text(port.os_error());
    if (why.error() == servobus::errc::port_lost && port.is_network() && !port.has_answered())
        words += "; the gateway takes no further connection, or restarts";
    if (why.error() == servobus::errc::line_busy)
        words += ": another program or device sends on it, or it picks up noise";
    return words;
}

std::string why_text(const target& of, servobus::status why, const session& on) {
    return why_text(of, why, on.port());
}

std::string advice_on_number(const chosen& what, servobus::status why) {
    using enum servobus::table;
    constexpr std::uint8_t illegal_address = 2;
    if (what.row != nullptr || why.exception() != illegal_address) return {};
    const std::string number = std::to_string(what.address);
    if (what.name.find(number) == what.name.npos)
        return {}; // it was typed in hexadecimal, as it stands in a frame
    struct numbered {
        servobus::table in;
        u16 first;
    };
    for (const numbered& n :
         {numbered{discrete_inputs, 10001}, {input_registers, 30001}, {holding_registers, 40001}}) {
        if (what.address < n.first || what.address - n.first > 9998) continue;
        chosen meant = what;
        meant.form.table = n.in;
        meant.form.has_table = what.form.has_table || n.in != holding_registers;
        meant.address = static_cast<u16>(what.address - n.first);
        return "; a manual that counts from " + std::to_string(n.first) + " means " + raw_name(meant) +
               " by " + number;
    }
    return {};
}

std::string why_text(const target& of, const chosen& what, const servobus::status& w, const session& on) {
    const bool is_refused = w.outcome() == servobus::outcome::refused;
    std::string words = is_refused ? "" : std::string{text(w.outcome())} + ", ";
    words += why_text(of, w, on);
    const bool is_known_drive = of.kind != nullptr && of.kind->file == nullptr;
    if (!w.was_sent() && w.error() == servobus::errc::timeout && !is_known_drive)
        words += " to the read that goes before: it rules out that the write's response is the request's own "
                 "echo. "
                 "--echo off says that this adapter returns nothing";
    if (w.error() == servobus::errc::own_echo && !is_known_drive && words.find("--echo on") == words.npos)
        words += ": --echo off says that this adapter returns nothing";
    constexpr std::uint8_t illegal_function = 1;
    if (is_refused && w.exception() == illegal_function && !is_known_drive && what.words == 1)
        words += "; for a device that takes function " + std::string{what.form.is_bit() ? "0Fh" : "10h"} +
                 " alone: --blocks-only";
    if (is_refused && what.row != nullptr && has(what.row->flags, servobus::flag::when_stopped))
        words += ", may be written only while the motor stands";
    return words + advice_on_number(what, w);
}

std::optional<rate_and_format> parse_rate_and_format(const arguments& asked, rate_and_format otherwise) {
    const auto baud = asked.number("baud", lowest_baud, highest_baud, otherwise.baud);
    if (!baud) return std::nullopt;
    otherwise.baud = static_cast<std::uint32_t>(*baud);
    const char* const format = asked.text("format");
    if (format == nullptr) return otherwise;
    const std::optional<servobus::character_format> parsed = parse_format(format);
    if (!parsed) {
        complain(usage, std::string{"--format takes "} + formats_taken + ", not '" + format + "'");
        return std::nullopt;
    }
    return rate_and_format{otherwise.baud, *parsed};
}

// A profile may state a short limit, as drives have shown. The tool meets drives that are not measured yet. It waits at
// least as long as for a device of which nothing is known.
static servobus::duration usual_response(const servobus::profile& facts) {
    constexpr servobus::profile unknown{.name = ""};
    return longer_of(facts.limits.response, unknown.limits.response);
}

int session::check(const arguments& asked, const target& of) {
    if (any_port::is_network(asked.words()[0]) && !leaves_setting_to_gateway(asked)) return usage;
    if (of.is_peer() && !any_port::is_mbap(asked.words()[0])) return refuse_peer(of);
    const servobus::profile& facts = of.facts();
    settings_ = native::settings_of(facts);
    node_ = any_node{of.node};
    peer_unit_ = of.peer_unit;
    facts_ = &facts;
    kind_ = of.kind;
    word_order_ = facts.word_order;
    node_.limits = facts.limits;
    node_.gaps = {.gap = facts.gap, .quarantine = facts.quarantine};

    const auto setting = parse_rate_and_format(asked, {facts.baud, facts.format});
    const auto timeout = asked.number("timeout", 1, 60'000, usual_response(facts).us / 1000);
    const auto retries = asked.number("retries", 0, 100, facts.read_retries);
    if (!setting || !timeout || !retries) return usage;
    settings_.baud = setting->baud;
    settings_.format = setting->format;
    node_.limits.response = servobus::milliseconds(static_cast<std::uint32_t>(*timeout));
    has_timeout_ = asked.has("timeout");
    retries_ = static_cast<std::uint8_t>(*retries);
    if (!parse_longest_pause(asked, longest_pause_) || !check_gaps(asked)) return usage;

    const std::optional<bool> echoes = asked.on_or_off("echo");
    if (!echoes) return usage;
    settings_.keeps_echo = *echoes;
    const bool is_known_drive = of.kind != nullptr && of.kind->file == nullptr; // which answers reads
    has_no_echo_ = asked.has("echo") && !*echoes && !is_known_drive;
    has_function_05_ = !asked.has("blocks-only") && !facts.refuses_function_05();
    has_function_06_ = !asked.has("blocks-only") && !facts.refuses_function_06();
    if (const char* const how = asked.text("rs485")) {
        if (const std::string why = os::set_rs485(settings_, how); !why.empty()) return complain(usage, why);
    }
    return done;
}

// A late response must begin within the quarantine, which drops it. A longer timeout means a slower drive, whose
// responses may be late by as much. A shorter timeout leaves the drive as slow as it is: its own limits still count.
bool session::check_gaps(const arguments& asked) {
    const auto gap = asked.number("gap", 0, 60'000, facts_->gap.us / 1000);
    const auto quarantine = asked.number("quarantine", 0, 60'000, facts_->quarantine.us / 1000);
    if (!gap || !quarantine) return false;
    if (asked.has("gap")) node_.gaps.gap = servobus::milliseconds(static_cast<std::uint32_t>(*gap));
    has_quarantine_ = asked.has("quarantine");
    if (has_quarantine_) {
        node_.gaps.quarantine = servobus::milliseconds(static_cast<std::uint32_t>(*quarantine));
    }
    later_quarantine_ = node_.gaps.quarantine;
    if (!has_quarantine_ && has_timeout_) {
        const servobus::duration wait = node_.limits.response;
        const servobus::duration usual = usual_response(*facts_) + facts_->quarantine;
        later_quarantine_ = longer_of(later_quarantine_, wait);
        if (wait < usual) later_quarantine_ = longer_of(later_quarantine_, usual - wait);
    }
    return true;
}

int session::open(const char* path) {
    name_ = path;
    if (const int status = port_.open(path, settings_); status != done) return status;
    port_.keep_connected();
    if (node_.address == servobus::modbus::peer_address) port_.set_peer_unit(peer_unit_);
    if (any_port::is_network(path)) {
        node_.limits.has_gateway = true;
        if (!has_timeout_) node_.limits.response = node_.limits.response + network_delay;
        // No response can come late there: its connection is dropped, or it has the number of its request.
        if (!has_quarantine_) node_.gaps.quarantine = node_.gaps.quarantine + network_delay;
        later_quarantine_ = node_.gaps.quarantine;
    }
    is_tcp_ = any_port::is_tcp(path);
    node_.read_retries = 0; // `read_repeated` has them
    line_.emplace(port_, timing_on(path, settings_.baud, longest_pause_));
    line_->echo().is_on = settings_.keeps_echo;
    client_.emplace(*line_, node_);
    return done;
}

} // namespace tool
