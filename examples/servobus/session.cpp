// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A drive on an open port: its settings from the command line, and failures in words.
#include "session.hpp"

#include <cstring>

namespace tool {

std::optional<target> parse_target(std::string_view text) {
    const std::size_t colon = text.find(':');
    const std::string_view name = text.substr(0, colon);
    target t;
    if (name != "raw") {
        t.kind = find_device(name);
        if (t.kind == nullptr) return std::nullopt;
    }
    if (colon == text.npos) return t;
    const servobus::profile& facts = t.facts();
    const std::optional<std::int64_t> node = parse_integer(text.substr(colon + 1));
    if (!node || *node < facts.lowest_unit || *node > facts.highest_unit) {
        complain(usage, "'" + std::string{text.substr(colon + 1)} + "' is no node address of " + facts.name +
                            ": " + std::to_string(facts.lowest_unit) + " to " +
                            std::to_string(facts.highest_unit));
        return std::nullopt;
    }
    t.node = static_cast<std::uint8_t>(*node);
    return t;
}

std::string why_text(const target& of, servobus::failure why, int os_error) {
    if (why.code == servobus::errc::exception) {
        return "refused, exception " + std::to_string(why.exception) + " (" +
               of.facts().meaning(why.exception) + ")";
    }
    std::string words = servobus::text(why.code);
    if (why.code == servobus::errc::port_lost && os_error != 0)
        words += std::string{": "} + std::strerror(os_error);
    return words;
}

namespace {
std::optional<servobus::character_format> parse_format(std::string_view text) {
    using servobus::character_format;
    if (text == "8N1") return character_format::n81;
    if (text == "8N2") return character_format::n82;
    if (text == "8E1") return character_format::e81;
    if (text == "8O1") return character_format::o81;
    return std::nullopt;
}
} // namespace

int session::check(const arguments& asked, const target& of) {
    const servobus::profile& facts = of.facts();
    settings_ = servobus::posix::settings_of(facts);
    node_ = servobus::node<any_device>{of.node};
    node_.order = facts.order;
    node_.limits = facts.limits;
    node_.quiet = {.gap = facts.gap, .quarantine = facts.quarantine};

    const auto baud = asked.number("baud", 600, 4'000'000, facts.baud);
    const auto timeout = asked.number("timeout", 1, 60'000, facts.limits.response.us / 1000);
    const auto retries = asked.number("retries", 0, 100, facts.read_retries);
    if (!baud || !timeout || !retries) return usage;
    settings_.baud = static_cast<std::uint32_t>(*baud);
    node_.limits.response = servobus::milliseconds(static_cast<std::uint32_t>(*timeout));
    node_.read_retries = static_cast<std::uint8_t>(*retries);

    if (const char* format = asked.text("format")) {
        const std::optional<servobus::character_format> parsed = parse_format(format);
        if (!parsed)
            return complain(usage, std::string{"--format takes 8N1, 8N2, 8E1 or 8O1, not '"} + format + "'");
        settings_.format = *parsed;
    }
    if (const char* echo = asked.text("echo")) {
        if (std::string_view{echo} == "on")
            return complain(usage, "--echo on is not supported yet: switch the adapter's echo off");
        if (std::string_view{echo} != "off")
            return complain(usage, std::string{"--echo takes on or off, not '"} + echo + "'");
    }
    return done;
}

int session::open(const char* path) {
    const servobus::errc why = port_.open(path, settings_);
    if (why == servobus::errc::busy)
        return complain(failed, std::string{"cannot open "} + path + ": another program uses it");
    if (why != servobus::errc::ok) {
        const std::string reason = why == servobus::errc::bad_argument
                                       ? "no serial device, or not with these settings"
                                       : std::strerror(port_.os_error());
        return complain(failed, std::string{"cannot open "} + path + ": " + reason);
    }
    line_.emplace(port_, servobus::modbus::timing_at(settings_.baud));
    client_.emplace(*line_, node_);
    return done;
}

} // namespace tool
