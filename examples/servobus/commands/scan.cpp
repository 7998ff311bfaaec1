// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus scan: who answers on a line, at which rate and address, and which of the known drives it is, or what it says
// of itself.
#include <utility>

#include "../frames/line_words.hpp"
#include "../os/interrupts.hpp"
#include "../streams/messages.hpp"
#include "../words/numbers.hpp"
#include "commands.hpp"
#include "scan_pass.hpp"

namespace tool {
namespace {

using scanning::plan;
using scanning::scanned;

std::vector<std::string> split(std::string_view text) {
    std::vector<std::string> parts;
    while (true) {
        const std::size_t comma = text.find(',');
        parts.emplace_back(text.substr(0, comma));
        if (comma == text.npos) return parts;
        text.remove_prefix(comma + 1);
    }
}

std::optional<plan> plan_of(const arguments& asked) {
    plan p;
    const char* rates = asked.text("baud");
    for (const std::string& rate : split(rates != nullptr ? rates : "9600,19200,38400,57600,115200")) {
        const std::optional<std::int64_t> number = parse_integer(rate);
        if (!number || *number < lowest_baud || *number > highest_baud) {
            complain(usage, "--baud takes rates from 600 to 4000000, with commas, not '" + rate + "'");
            return std::nullopt;
        }
        p.rates.push_back(static_cast<std::uint32_t>(*number));
    }
    const char* formats = asked.text("format");
    for (const std::string& format : split(formats != nullptr ? formats : "8N1,8N2")) {
        if (!parse_format(format)) {
            complain(usage, "--format takes 8N1, 8N2, 8E1 and 8O1, with commas, not '" + format + "'");
            return std::nullopt;
        }
        p.formats.push_back(format);
    }
    if (const char* nodes = asked.text("nodes")) {
        const std::string_view text{nodes};
        const std::size_t dash = text.find('-');
        const auto first = parse_integer(text.substr(0, dash));
        const auto last = dash == text.npos ? first : parse_integer(text.substr(dash + 1));
        if (!first || !last || *first < 1 || *last > 247 || *first > *last) {
            complain(usage,
                     "--nodes takes addresses from 1 to 247, A or A-B, not '" + std::string{text} + "'");
            return std::nullopt;
        }
        p.first = static_cast<std::uint8_t>(*first);
        p.last = static_cast<std::uint8_t>(*last);
    }
    const auto timeout = asked.number("timeout", 1, 60'000, 50);
    const auto echoes = asked.on_or_off("echo");
    const auto gap = asked.number("gap", 0, 60'000, 0);
    const auto quarantine = asked.number("quarantine", 0, 60'000, 0);
    if (!timeout || !echoes || !gap || !quarantine || !parse_longest_pause(asked, p.longest_pause))
        return std::nullopt;
    p.gaps = {.gap = servobus::milliseconds(static_cast<std::uint32_t>(*gap)),
              .quarantine = servobus::milliseconds(static_cast<std::uint32_t>(*quarantine))};
    p.has_quarantine = asked.has("quarantine");
    p.limits.response = servobus::milliseconds(static_cast<std::uint32_t>(*timeout));
    p.settings.keeps_echo = *echoes;
    if (const char* const how = asked.text("rs485")) {
        if (const std::string why = os::set_rs485(p.settings, how); !why.empty()) {
            complain(usage, why);
            return std::nullopt;
        }
    }
    p.identifies = asked.has("identify");
    p.names_settings = asked.has("baud") || asked.has("format");
    return p;
}

// One setting of the line. Returns `done` or an exit status after a complaint.
int scan_at(const char* path, std::uint32_t baud, const std::string& format, plan& p, scanned& all) {
    any_port port;
    serial_settings settings = p.settings;
    settings.baud = baud;
    settings.format = *parse_format(format);
    if (const int status = port.open(path, settings); status != done) return status;
    port.keep_connected();
    if (port.ignores_rate() && !p.names_settings && p.has_several()) {
        note(std::string{path} + " is a pseudo-terminal, which has no rate and no format: scanning once");
        p.rates.resize(1);
        p.formats.resize(1);
        p.has_setting = false;
    }
    ++all.settings;
    scanning::scan_pass pass{port, p.has_setting ? std::to_string(baud) + " " + format : "- -", p,
                             timing_on(path, baud, p.longest_pause), all};
    return pass.run();
}

std::string words_on_nobody(const plan& p, const scanned& all, bool is_network) {
    if (all.of_gateway != 0)
        return "no device responds: the gateway says that it got no response at any address";
    const std::uint32_t limit = p.limits.response.us / 1000, longer = is_network ? 2000 : 500;
    return "no device responds within " + std::to_string(limit) + " ms" +
           (limit < longer ? ": a slower one needs --timeout " + std::to_string(longer) : std::string{}) +
           (is_network ? "; the gateway is connected, and may serve one client at a time"
                       : "; else the supply, A and B swapped, or another rate, format or address");
}

} // namespace

int scan(const arguments& asked) {
    if (asked.words().size() != 1) return complain(usage, "scan takes one PORT");
    std::optional<plan> p = plan_of(asked);
    if (!p) return usage;
    const char* path = asked.words()[0].c_str();
    if (any_port::is_network(path)) {
        if (!leaves_setting_to_gateway(asked)) return usage;
        p->has_setting = false;
        p->limits.has_gateway = true;
        p->rates.resize(1); // one pass
        p->formats.resize(1);
        if (!asked.has("timeout")) p->limits.response = p->limits.response + network_delay;
    }
    interrupts::arm();
    scanned all;
    // Where the port has no rate, `scan_at` leaves one pass.
    for (std::size_t rate = 0; rate < p->rates.size(); ++rate) {
        for (std::size_t format = 0; format < p->formats.size(); ++format) {
            const int status = scan_at(path, p->rates[rate], std::string{p->formats[format]}, *p, all);
            if (status != done) return status;
        }
    }
    if (all.found != 0) return done;
    if (all.without_echo == all.settings)
        return complain(failed, std::string{text(servobus::errc::no_echo)} +
                                    " at any rate and format: try --echo off");
    if (all.echoed == all.settings)
        return complain(failed, "what came is the request's own echo: try --echo on");
    return complain(failed, words_on_nobody(*p, all, any_port::is_network(path)));
}

} // namespace tool
