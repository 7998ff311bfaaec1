// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus scan: who answers on a line, at which rate and address, and which of the known drives it is, or what it says of
// itself.
#include <cstdio>

#include <servobus/client/identification.hpp>
#include <servobus/client/scan.hpp>
#include <servobus/modbus/diagnostics.hpp>

#include "../identity.hpp"
#include "../os/interrupts.hpp"
#include "../session.hpp"
#include "../text/progress.hpp"
#include "../text/streams.hpp"

namespace tool {
namespace {

using servobus::finding;
using servobus::presence;
// Identifications have no fixed length.
using scanned_line =
    servobus::line<any_port, servobus::counters, servobus::echoed, servobus::modbus::open_lengths>;

std::vector<std::string> split(std::string_view text) {
    std::vector<std::string> parts;
    while (true) {
        const std::size_t comma = text.find(',');
        parts.emplace_back(text.substr(0, comma));
        if (comma == text.npos) return parts;
        text.remove_prefix(comma + 1);
    }
}

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

// Several requests to one address: a late response to one of them must not be taken for that to the next.
const char* name_of(scanned_line& on, std::uint8_t node_address, const plan& p) {
    servobus::bus_gaps gaps = p.gaps;
    if (!p.has_quarantine) gaps.quarantine = servobus::milliseconds(300);
    const char* const name = name_of_drive(
        node_address, [&](u16 address) { return look_for(on, node_address, p.limits, address, gaps); });
    return name != nullptr ? name : "unknown device";
}

const char* name_of_object(std::uint8_t id) {
    static constexpr const char* names[] = {"vendor",       "product code", "revision",        "vendor URL",
                                            "product name", "model name",   "application name"};
    return id < std::size(names) ? names[id] : nullptr;
}
// Text in quotes; what is no printable ASCII as \\xNN.
std::string quoted(servobus::bytes text) {
    std::string all = "\"";
    for (const std::uint8_t byte : text) {
        char shown[5];
        const bool is_plain = byte >= 0x20 && byte < 0x7F && byte != '"' && byte != '\\';
        std::snprintf(shown, sizeof shown, is_plain ? "%c" : "\\x%02X", unsigned{byte});
        all += shown;
    }
    return all + "\"";
}
// Asks a device what it is, by function 2Bh, then by 11h.
std::string identification_of(scanned_line& on, std::uint8_t node_address, const plan& p) {
    namespace modbus = servobus::modbus;
    servobus::client device{on, servobus::node<any_device>{node_address}};
    device.node().limits = p.limits;
    device.node().gaps.gap = p.gaps.gap;
    if (p.has_quarantine) device.node().gaps.quarantine = p.gaps.quarantine;
    device.node().read_retries = 1;
    std::string said;
    const auto add = [&said](const modbus::identification_object& object) {
        char number[16];
        std::snprintf(number, sizeof number, "object %02X", unsigned{object.id});
        const char* name = name_of_object(object.id);
        said += (said.empty() ? "" : ", ") + std::string{name != nullptr ? name : number} + " " +
                quoted(object.value);
    };
    // A device that has the basic objects only may refuse the regular ones.
    for (const auto kind : {modbus::identification::regular, modbus::identification::basic}) {
        const servobus::status why = read_identification(device, kind, add);
        if (why || !said.empty())
            return said + (why ? "" : ", and no more: " + std::string{text(why.error())});
        if (why.error() != servobus::errc::exception) break;
    }
    std::uint8_t room[modbus::max_pdu];
    std::uint8_t request[1];
    (void)modbus::put_bare_request(request, modbus::function::report_server_id);
    const auto response = device.transact(request, room, modbus::length_rule::of_function());
    if (!response) return "no identification";
    const auto id = modbus::parse_server_id(*response);
    return id ? "server ID " + quoted(*id) : "no identification";
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

struct scanned {
    std::size_t found = 0;        ///< addresses that respond
    std::size_t settings = 0;     ///< of the line
    std::size_t without_echo = 0; ///< settings at which the first request did not come back
};

// One setting of the line. Returns `done` or an exit status after a complaint.
int scan_at(const char* path, std::uint32_t baud, const std::string& format, plan& p, scanned& all) {
    std::size_t garbled = 0;
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
    const std::string setting = p.has_setting ? std::to_string(baud) + " " + format : "- -";
    scanned_line on{port, timing_on(path, baud, p.longest_pause)};
    on.echo().is_on = p.settings.keeps_echo;
    ++all.settings;
    progress shown{setting, static_cast<std::size_t>(p.last - p.first) + 1};
    for (unsigned node_address = p.first; node_address <= p.last; ++node_address) {
        if (interrupts::came())
            return complain(failed, setting + ": interrupted at node " + std::to_string(node_address));
        const auto node = static_cast<std::uint8_t>(node_address);
        const finding f = look_for(on, node, p.limits, 0, p.gaps);
        // The request may come back at another setting.
        if (f.why.error() == servobus::errc::no_echo && node == p.first && p.has_several()) {
            shown.end();
            note(setting + ": " + text(f.why.error()));
            ++all.without_echo;
            return done;
        }
        if (f.what == presence::failed) {
            shown.end();
            return complain(failed, setting + " node " + std::to_string(node_address) + ": " +
                                        why_text(target{}, f.why, port));
        }
        if (f.what != presence::no_response) {
            const bool is_garbled = f.what == presence::garbled;
            std::string who = is_garbled ? "garbled" : name_of(on, node, p);
            if (p.identifies && !is_garbled) who += ": " + identification_of(on, node, p);
            shown.end();
            std::printf("%s %u %s\n", setting.c_str(), node_address, who.c_str());
            if (!streams::flush()) return failed;
            ++all.found;
            garbled += f.what == presence::garbled ? 1u : 0u;
        }
        shown.at(node_address - p.first + 1u);
    }
    if (garbled > 1 && garbled == static_cast<std::size_t>(p.last - p.first) + 1)
        note(setting +
             ": every address is garbled, as through an adapter that receives what it sends: try --echo on");
    return done;
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
    return complain(failed, "no device responds");
}

} // namespace tool
