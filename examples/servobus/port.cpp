// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The names of ports, and what opening one fails with, in words.
#include "port.hpp"

#include <optional>

#include "tool.hpp"

namespace tool {
namespace {

using servobus::errc;

bool is_mbap(std::string_view name) { return name.starts_with("mbap://"); }

struct endpoint {
    std::string host;
    std::string service;
};

// HOST:PORT, [IPv6]:PORT; without :PORT the one that is given. Complains by itself.
std::optional<endpoint> parse_endpoint(std::string_view name, std::string_view otherwise) {
    std::string_view rest = name.substr(name.find("://") + 3);
    endpoint e;
    const auto bad = [&](const std::string& why) {
        complain(usage, "'" + std::string{name} + "' is no address: " + why);
        return std::optional<endpoint>{};
    };
    if (rest.starts_with('[')) {
        const std::size_t end = rest.find(']');
        if (end == rest.npos) return bad("']' is missing");
        e.host = rest.substr(1, end - 1);
        rest.remove_prefix(end + 1);
    } else {
        const std::size_t colon = rest.find(':');
        e.host = rest.substr(0, colon);
        rest.remove_prefix(colon == rest.npos ? rest.size() : colon);
        if (rest.find(':', 1) != rest.npos) return bad("an IPv6 address is written in brackets, [::1]:502");
    }
    if (e.host.empty()) return bad("the host is missing");
    if (rest.empty() && otherwise.empty()) return bad("the port is missing, tcp://HOST:PORT");
    e.service = rest.empty() ? otherwise : rest.substr(1);
    const std::optional<std::int64_t> number = parse_integer(e.service);
    if ((!rest.empty() && rest[0] != ':') || !number || *number < 1 || *number > 65535)
        return bad("a port is a number from 1 to 65535");
    e.service = std::to_string(*number);
    return e;
}

int complain_of(const char* name, const std::string& why) {
    return complain(failed, std::string{"cannot open "} + name + ": " + why);
}

int open_serial(native::serial& port, const char* name, const serial_settings& settings) {
    const errc why = port.open(name, settings);
    if (why == errc::ok) return done;
    if (why == errc::busy) return complain_of(name, os::busy_text);
    return complain_of(name, why == errc::bad_argument ? "no serial device, or not with these settings"
                                                       : os::error_text(static_cast<int>(port.os_error())));
}

int explain_failure(const native::tcp& port, const char* name, errc why) {
    if (why == errc::ok) return done;
    if (why == errc::bad_argument)
        return complain_of(name, os::resolve_error_text(static_cast<int>(port.resolve_error())));
    return complain_of(name, why == errc::timeout ? "the host does not answer"
                                                  : os::error_text(static_cast<int>(port.os_error())));
}

} // namespace

bool any_port::is_tcp(std::string_view name) { return name.starts_with("tcp://"); }
bool any_port::is_network(std::string_view name) { return is_tcp(name) || is_mbap(name); }

bool leaves_setting_to_gateway(const arguments& asked) {
    if (!asked.has("baud") && !asked.has("format")) return true;
    complain(usage, "the gateway sets rate and format of its line, not --baud and --format");
    return false;
}

int any_port::open(const char* name, const serial_settings& settings) {
    if (!is_network(name)) return open_serial(port_.emplace<native::serial>(), name, settings);
    const bool has_mbap = is_mbap(name);
    const std::optional<endpoint> at = parse_endpoint(name, has_mbap ? "502" : "");
    if (!at) return usage;
    host_ = at->host;
    service_ = at->service;
    const char* host = host_.c_str();
    const char* service = service_.c_str();
    if (has_mbap) {
        auto& port = port_.emplace<native::mbap>();
        return explain_failure(port.stream(), name, port.open(host, service));
    }
    auto& port = port_.emplace<native::tcp>();
    return explain_failure(port, name, port.open(host, service));
}

servobus::errc any_port::reconnect() {
    if (auto* mbap = std::get_if<native::mbap>(&port_)) {
        mbap->stream().abort();
        return mbap->open(host_.c_str(), service_.c_str());
    }
    auto* tcp = std::get_if<native::tcp>(&port_);
    if (tcp == nullptr) return errc::ok;
    tcp->abort();
    return tcp->open(host_.c_str(), service_.c_str());
}

int any_port::os_error() const {
    if (const auto* mbap = std::get_if<native::mbap>(&port_))
        return static_cast<int>(mbap->stream().os_error());
    if (const auto* tcp = std::get_if<native::tcp>(&port_)) return static_cast<int>(tcp->os_error());
    return static_cast<int>(std::get<native::serial>(port_).os_error());
}

servobus::transfer any_port::send(servobus::bytes out) {
    return std::visit([&](auto& p) { return p.send(out); }, port_);
}
bool any_port::sent() {
    return std::visit([](auto& p) { return p.sent(); }, port_);
}
servobus::transfer any_port::receive(servobus::byte_buffer in) {
    return std::visit([&](auto& p) { return p.receive(in); }, port_);
}
servobus::instant any_port::now() const {
    return std::visit([](const auto& p) { return p.now(); }, port_);
}
void any_port::wait(servobus::duration d) {
    std::visit([&](auto& p) { p.wait(d); }, port_);
}

bool is_no_response(std::string_view port, const servobus::status& why) {
    return is_mbap(port) && (why.exception() == 0x0A || why.exception() == 0x0B);
}

servobus::modbus::rtu_timing timing_on(std::string_view name, std::uint32_t baud) {
    using servobus::modbus::timing_at;
    constexpr servobus::duration longest_pause = servobus::milliseconds(200);
    if (!any_port::is_network(name)) return timing_at(baud);
    return timing_at(baud, servobus::modbus::timing_mode::host, longest_pause);
}

} // namespace tool
