// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "one_request.hpp"

#include <algorithm>

#include "../streams/messages.hpp"

namespace tool {
namespace {

namespace modbus = servobus::modbus;

// Every function whose response says its own length. The others end where a gap follows.
modbus::length_rule rule_of(servobus::bytes pdu) {
    switch (pdu[0]) {
    case 0x07:
    case 0x08:
    case 0x0B:
    case 0x0C:
    case 0x11:
    case 0x18: return modbus::length_rule::of_function();
    case 0x14: // file records
    case 0x15: return modbus::length_rule::counted(1);
    }
    const bool is_identification = pdu[0] == 0x2B && pdu.size() > 1 && pdu[1] == modbus::mei_identification;
    return is_identification ? modbus::length_rule::of_function() : modbus::length_rule::until_gap();
}

} // namespace

int one_request::open(const arguments& asked, const target& of) {
    session checked; // has the rules of these options
    if (const int status = checked.check(asked, of); status != done) return status;
    of_ = of;
    const char* const path = asked.words()[0].c_str();
    const servobus::profile& facts = of.facts();
    serial_settings settings = native::settings_of(facts);
    settings.baud = checked.baud();
    settings.format = checked.format();
    settings.keeps_echo = checked.removes_echo();
    if (const char* const how = asked.text("rs485")) (void)os::set_rs485(settings, how);
    std::optional<servobus::duration> longest_pause;
    (void)parse_longest_pause(asked, longest_pause);
    const auto retries = asked.number("retries", 0, 100, facts.read_retries);
    const auto gap = asked.number("gap", 0, 60'000, facts.gap.us / 1000);
    retries_ = static_cast<std::uint8_t>(retries.value_or(0));
    // The adapter returns nothing, says who knows it. A known drive answers the read all the same.
    const bool is_known_drive = of.kind != nullptr && of.kind->file == nullptr;
    is_echo_ruled_out_ = asked.has("echo") && !settings.keeps_echo && !is_known_drive;

    if (const int status = port_.open(path, settings); status != done) return status;
    port_.keep_connected();
    if (of.is_peer()) port_.set_peer_unit(of.peer_unit);
    any_node node{of.node};
    node.read_retries = 0; // `shows_no_echo` has them
    node.limits = facts.limits;
    node.limits.response = checked.response_limit();
    if (any_port::is_network(path)) {
        node.limits.has_gateway = true;
        if (!asked.has("timeout")) node.limits.response = node.limits.response + network_delay;
    }
    node.gaps = {.gap = facts.gap, .quarantine = facts.quarantine};
    if (asked.has("gap")) node.gaps.gap = servobus::milliseconds(static_cast<std::uint32_t>(gap.value_or(0)));
    if (const auto ms = asked.number("quarantine", 0, 60'000, 0); ms && asked.has("quarantine"))
        node.gaps.quarantine = servobus::milliseconds(static_cast<std::uint32_t>(*ms));
    line_.emplace(port_, timing_on(path, settings.baud, longest_pause));
    line_->echo().is_on = settings.keeps_echo;
    client_.emplace(*line_, node);
    return done;
}

servobus::result<servobus::bytes> one_request::transact(servobus::bytes pdu, servobus::byte_buffer room) {
    const servobus::result<servobus::bytes> response = client_->transact(pdu, room, rule_of(pdu));
    if (response || response.status().error() != servobus::errc::own_echo) return response;
    // What came is known: the request.
    std::copy(pdu.begin(), pdu.end(), room.begin());
    const servobus::bytes repeated = servobus::bytes{room}.first(pdu.size());
    return is_echo_ruled_out_ || shows_no_echo() ? repeated : response;
}

// An adapter that returns what it sends returns the read too: silence is no echo either.
bool one_request::shows_no_echo() {
    bool is_silent = true;
    for (unsigned tries = 0; tries <= retries_; ++tries) {
        u16 word[1];
        const servobus::status why = client_->read_words(0, word);
        if (line_->is_echo_ruled_out(client_->node().address)) return true;
        is_silent = is_silent && why.error() == servobus::errc::timeout && !port_.response_time();
    }
    return is_silent;
}

std::string one_request::why_text(servobus::status why) const {
    std::string words = tool::why_text(of_, why, port_);
    if (why.error() == servobus::errc::own_echo && words.find("--echo on") == words.npos)
        words += ": --echo off says that this adapter returns nothing";
    return words;
}

} // namespace tool
