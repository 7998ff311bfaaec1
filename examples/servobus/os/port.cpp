// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The names of ports, and what opening one fails with, in words.
#include "port.hpp"

#include <algorithm>
#include <optional>

#include "../frames/log_line.hpp"
#include "../streams/messages.hpp"
#include "../words/numbers.hpp"
#include "port_users.hpp"

namespace tool {
namespace {

using servobus::errc;

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
    const errc why = port.open(name, settings).error();
    if (why == errc::ok) return done;
    if (why == errc::port_in_use) {
        std::string users;
        for (const os::port_user& u : os::users_of(name))
            users += (users.empty() ? ": " : ", ") + os::text_of(u);
        return complain_of(name, os::in_use_text + users);
    }
    if (why == errc::no_permission) return complain_of(name, text(why) + os::advice_on_access(name));
    if (why == errc::no_such_port) return complain_of(name, text(why));
    const int error = static_cast<int>(port.os_error());
    if (why == errc::bad_argument)
        return complain_of(name, "no serial device, or not with these settings: " + os::error_text(error));
    if (why == errc::rs485_refused || why == errc::rs485_late)
        return complain_of(name, text(why) + (error == 0 ? std::string{} : ": " + os::error_text(error)));
    return complain_of(name, os::error_text(error));
}

int explain_failure(const native::tcp& port, const char* name, errc why) {
    if (why == errc::ok) return done;
    if (why == errc::bad_argument)
        return complain_of(name, os::resolve_error_text(static_cast<int>(port.resolve_error())));
    return complain_of(name, why == errc::timeout ? "the host does not answer"
                                                  : os::error_text(static_cast<int>(port.os_error())));
}

// Windows has no pseudo-terminals, and its port no such function.
template <class Port> bool has_no_wire(const Port& port) {
    if constexpr (requires { port.is_pseudo_terminal(); }) {
        return port.is_pseudo_terminal();
    } else {
        return false;
    }
}

// True for an error that the bytes of an exchange have caused.
bool is_of_exchange(errc why) {
    using enum errc;
    for (const errc one : {port_lost, no_echo, collision, own_echo, timeout, truncated_response, bad_crc,
                           wrong_node, wrong_function, wrong_byte_count, wrong_address, wrong_value,
                           wrong_quantity, too_short, too_long, bad_gap}) {
        if (why == one) return true;
    }
    return false;
}

// Appends the bytes that came, up to some frames of them.
void keep(std::vector<std::uint8_t>& kept, servobus::byte_buffer from, std::size_t count) {
    constexpr std::size_t most = 4 * servobus::modbus::max_frame;
    const servobus::bytes arrived = servobus::bytes{from}.first(count);
    if (kept.size() + count <= most) kept.insert(kept.end(), arrived.begin(), arrived.end());
}

} // namespace

bool any_port::is_tcp(std::string_view name) { return name.starts_with("tcp://"); }
bool any_port::is_mbap(std::string_view name) { return name.starts_with("mbap://"); }
bool any_port::is_network(std::string_view name) { return is_tcp(name) || is_mbap(name); }

bool leaves_setting_to_gateway(const arguments& asked) {
    if (asked.has("rs485")) {
        complain(usage, "the gateway switches the driver of its line, not --rs485");
        return false;
    }
    if (!asked.has("baud") && !asked.has("format")) return true;
    complain(usage, "the gateway sets rate and format of its line, not --baud and --format");
    return false;
}

servobus::transfer recorded_tcp::receive(servobus::byte_buffer in) {
    const servobus::transfer t = native::tcp::receive(in);
    if (t) keep(came, in, *t);
    return t;
}

int any_port::open(const char* name, const serial_settings& settings) {
    removes_echo_ = settings.keeps_echo;
    name_ = name;
    settings_ = settings;
    if (!is_network(name)) return open_serial(port_.emplace<native::serial>(), name, settings);
    const bool has_mbap = is_mbap(name);
    const std::optional<endpoint> at = parse_endpoint(name, has_mbap ? "502" : "");
    if (!at) return usage;
    host_ = at->host;
    service_ = at->service;
    connected_at_ = native::monotonic_now();
    const char* host = host_.c_str();
    const char* service = service_.c_str();
    if (has_mbap) {
        auto& port = port_.emplace<mbap>();
        return explain_failure(port.stream(), name, port.open(host, service).error());
    }
    auto& port = port_.emplace<native::tcp>();
    return explain_failure(port, name, port.open(host, service).error());
}

void any_port::set_peer_unit(std::uint8_t unit) {
    peer_unit_ = unit;
    std::get<mbap>(port_).set_peer_unit(unit);
}

// A connection that the peer has answered is followed by the next one immediately. One that it has not answered costs a
// pause, twice as long each time: a small gateway fails under many connections a second.
void any_port::pause_before_connecting() {
    using servobus::milliseconds;
    constexpr servobus::duration first = milliseconds(100), longest = milliseconds(3200);
    pause_ = is_answered_since_ ? servobus::duration{}
             : pause_ < first   ? first
             : pause_ < longest ? pause_ * 2
                                : longest;
    is_answered_since_ = false;
    const servobus::duration gone = since(connected_at_, native::monotonic_now());
    if (gone < pause_) native::sleep_for(servobus::duration{pause_.us - gone.us});
    connected_at_ = native::monotonic_now();
}

servobus::status any_port::reconnect() {
    if (!is_network()) return errc::ok;
    pause_before_connecting();
    ++connections_;
    is_fresh_ = true;
    left_to_send_ = 0;
    if (auto* modbus_tcp = std::get_if<mbap>(&port_)) {
        modbus_tcp->stream().abort();
        return modbus_tcp->open(host_.c_str(), service_.c_str());
    }
    auto& tcp = std::get<native::tcp>(port_);
    tcp.abort();
    return tcp.open(host_.c_str(), service_.c_str());
}

servobus::status any_port::reopen() {
    return is_network() ? reconnect() : std::get<native::serial>(port_).open(name_.c_str(), settings_);
}

bool any_port::is_foreign() const {
    const auto* modbus_tcp = std::get_if<mbap>(&port_);
    return modbus_tcp != nullptr && modbus_tcp->is_foreign() && !has_answered_;
}

// True if the response to the last request has come.
bool any_port::is_answered() const {
    return !request_.empty() && !response_.empty() && response_[0] == request_[0] &&
           bool{servobus::modbus::open_frame(response_)};
}

int any_port::os_error() const {
    if (const auto* modbus_tcp = std::get_if<mbap>(&port_))
        return static_cast<int>(modbus_tcp->stream().os_error());
    if (const auto* tcp = std::get_if<native::tcp>(&port_)) return static_cast<int>(tcp->os_error());
    return static_cast<int>(std::get<native::serial>(port_).os_error());
}

bool any_port::ignores_rate() const {
    return std::visit([](const auto& p) { return has_no_wire(p); }, port_);
}

servobus::bytes any_port::came() const {
    const auto* modbus_tcp = std::get_if<mbap>(&port_);
    return modbus_tcp != nullptr ? servobus::bytes{modbus_tcp->stream().came} : servobus::bytes{came_};
}

std::string any_port::echo_diagnosis(servobus::status why) const {
    const auto contains = [](servobus::bytes all, servobus::bytes part) {
        return std::search(all.begin(), all.end(), part.begin(), part.end()) != all.end();
    };
    if (removes_echo_) {
        // The response of a drive in place of the echo.
        const bool has_response = why == errc::collision && !contains(came_, request_) &&
                                  !log_line::find_frames(came_, request_).frames.empty();
        return why == errc::no_echo || has_response ? std::string{text(errc::no_echo)} + ": try --echo off"
                                                    : std::string{};
    }
    if (request_.empty() || !contains(came_, request_)) return {};
    // A response to these equals its request. What came for any other, also for the read after a write, is no response.
    const std::uint8_t function = request_.size() > 1 ? request_[1] : std::uint8_t{0};
    const bool may_be_response = function == 0x05 || function == 0x06 || function == 0x08 || function == 0x16;
    return why == errc::own_echo && may_be_response ? std::string{text(why.error())} + ": try --echo on"
                                                    : "what came is the request's own echo: try --echo on";
}

std::string any_port::diagnosis(servobus::status why) const {
    if (!is_of_exchange(why.error())) return {};
    if (const auto* modbus_tcp = std::get_if<mbap>(&port_)) {
        const bool is_ipv6 = host_.find(':') != host_.npos;
        // An RTU frame may be shorter than the header of Modbus TCP.
        if (modbus_tcp->is_foreign() && has_answered_) return "a header of Modbus TCP was wrong";
        if (modbus_tcp->is_foreign() || servobus::modbus::open_frame(came()))
            return "what came is no Modbus TCP: try tcp://" + (is_ipv6 ? '[' + host_ + ']' : host_) + ':' +
                   service_;
    } else if (std::string words = echo_diagnosis(why); !words.empty()) {
        return words;
    }
    if (why != errc::timeout || request_.empty()) return {};
    const std::size_t echo = removes_echo_ ? request_.size() : 0; // as far as it came
    const std::size_t count = came().size() - std::min(echo, came().size());
    if (count == 0 && is_network() && !has_answered_)
        return "no response: the connection is open, and not a byte came; the gateway may serve one client "
               "at a time";
    if (count == 0) return {};
    const bool is_to_peer = request_[0] == servobus::modbus::peer_address;
    return std::to_string(count) + (count == 1 ? " byte" : " bytes") + " came, none a response of " +
           (is_to_peer ? "unit " + std::to_string(peer_unit_) : "node " + std::to_string(request_[0]));
}

servobus::transfer any_port::send(servobus::bytes out) {
    const servobus::transfer took = std::visit([&](auto& p) { return p.send(out); }, port_);
    if (!took || *took == 0) return took;
    // The rest of a frame is offered again in the size in which it was left.
    if (left_to_send_ == 0 || left_to_send_ != out.size()) {
        request_.assign(out.begin(), out.end());
        came_.clear();
        response_.clear();
        sent_at_.reset();
        answered_at_.reset();
        is_fresh_ = false;
        if (auto* modbus_tcp = std::get_if<mbap>(&port_)) modbus_tcp->stream().came.clear();
    }
    left_to_send_ = out.size() - *took;
    return took;
}
bool any_port::sent() {
    const bool is_sent = std::visit([](auto& p) { return p.sent(); }, port_);
    if (is_sent && left_to_send_ == 0 && !sent_at_) sent_at_ = now();
    return is_sent;
}
std::optional<servobus::duration> any_port::response_time() const {
    if (!sent_at_ || !answered_at_) return std::nullopt;
    return servobus::went_back(*sent_at_, *answered_at_) ? servobus::duration{}
                                                         : servobus::since(*sent_at_, *answered_at_);
}
servobus::transfer any_port::receive(servobus::byte_buffer in) {
    const servobus::transfer t = receive_now(in);
    const bool is_closed = !t && t.error() == errc::port_lost && !is_foreign();
    // While a request is under way its response is lost. A peer that has never responded may have another protocol.
    const bool is_idle = has_answered_ && (is_fresh_ || is_answered());
    if (!is_closed || !keeps_connected_ || !is_network() || !is_idle) return t;
    if (reconnect() != errc::ok) return t;
    if (!is_said_anew_) note(name_ + " closes its connections; each is made anew");
    is_said_anew_ = true;
    return std::uint16_t{0};
}
servobus::transfer any_port::receive_now(servobus::byte_buffer in) {
    const servobus::transfer t = std::visit([&](auto& p) { return p.receive(in); }, port_);
    if (!t) return t;
    keep(response_, in, *t);
    const std::size_t echo = removes_echo_ ? request_.size() : 0;
    if (!answered_at_ && response_.size() > echo) answered_at_ = now();
    is_answered_since_ = is_answered_since_ || (*t != 0 && is_answered());
    has_answered_ = has_answered_ || is_answered_since_;
    if (!std::holds_alternative<mbap>(port_)) keep(came_, in, *t);
    return t;
}
servobus::instant any_port::now() const {
    return std::visit([](const auto& p) { return p.now(); }, port_);
}
void any_port::wait(servobus::duration d) {
    std::visit([&](auto& p) { p.wait(d); }, port_);
}

servobus::modbus::rtu_timing timing_on(std::string_view name, std::uint32_t baud,
                                       std::optional<servobus::duration> longest_pause) {
    using servobus::modbus::timing_at;
    constexpr servobus::duration of_network = servobus::milliseconds(200);
    if (!longest_pause && any_port::is_network(name)) longest_pause = of_network;
    if (!longest_pause) return timing_at(baud);
    return timing_at(baud, servobus::modbus::timing_mode::host, *longest_pause);
}

bool parse_longest_pause(const arguments& asked, std::optional<servobus::duration>& longest_pause) {
    if (!asked.has("inter-byte")) return true;
    const auto ms = asked.number("inter-byte", 0, 10'000, 0);
    if (ms) longest_pause = servobus::milliseconds(static_cast<std::uint32_t>(*ms));
    return ms.has_value();
}

} // namespace tool
