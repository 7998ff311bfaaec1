// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "scan_pass.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

#include <servobus/modbus/diagnostics.hpp>

#include "../devices/device.hpp"
#include "../devices/identity.hpp"
#include "../frames/line_words.hpp"
#include "../os/interrupts.hpp"
#include "../streams/messages.hpp"
#include "../streams/streams.hpp"
#include "../words/numbers.hpp"

namespace tool::scanning {
namespace {

using servobus::finding;
using servobus::presence;

// Who is at an address, and how well it was heard.
struct introduced {
    std::string name;
    unsigned asked = 0;
    unsigned lost = 0;
};
// Several requests to one address: a late response to one of them must not be taken for that to the next. What is lost
// is asked again: no name is concluded from a response that did not come.
introduced introduce(scanned_line& on, std::uint8_t node_address, const plan& p,
                     const servobus::response_limits& limits) {
    constexpr unsigned tries = 4;
    servobus::bus_gaps gaps = p.gaps;
    if (!p.has_quarantine) gaps.quarantine = std::max(limits.response, servobus::milliseconds(300));
    introduced who;
    const auto look = [&](u16 address) {
        finding f;
        for (unsigned i = 0; i < tries; ++i) {
            f = look_for(on, node_address, limits, address, gaps);
            ++who.asked;
            const bool is_busy = f.why.exception() > 3;
            if ((f.what == presence::present && !is_busy) || f.what == presence::failed) break;
            ++who.lost;
        }
        return f;
    };
    const named_drive is = name_of_drive(node_address, look);
    who.name = is.name != nullptr ? is.name : is.is_judged ? "unknown device" : "not identified";
    return who;
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
std::string identification_of(scanned_line& on, std::uint8_t node_address, const plan& p,
                              const servobus::response_limits& limits) {
    namespace modbus = servobus::modbus;
    servobus::client device{on, servobus::node<any_device>{node_address}};
    device.node().limits = limits;
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

std::size_t frames_of(std::uint8_t node, servobus::bytes all) {
    const auto found = log_line::find_frames(all).frames;
    return static_cast<std::size_t>(
        std::count_if(found.begin(), found.end(), [&](const found_frame& f) { return f.frame[0] == node; }));
}

} // namespace

int scan_pass::run() {
    listen(servobus::milliseconds(100));
    if (!heard_.unasked.empty()) say(words_on_unasked(heard_));
    for (unsigned address = p_->first; address <= p_->last; ++address) {
        if (interrupts::came())
            return complain(failed, setting_ + ": interrupted at node " + std::to_string(address));
        const int status = look_at(static_cast<std::uint8_t>(address));
        if (status != done || is_over_) return status;
        shown_.at(address - p_->first + 1u);
    }
    return look_again();
}

int scan_pass::look_at(std::uint8_t node) {
    const finding f = look_for(on_, node, p_->limits, 0, p_->gaps);
    // The request may come back at another setting.
    if (f.why.error() == servobus::errc::no_echo && node == p_->first && p_->has_several()) {
        say(text(f.why.error()));
        ++all_->without_echo;
        is_over_ = true;
        return done;
    }
    if (f.what == presence::failed) return fail(node, f.why);
    if (f.what == presence::garbled && port_->diagnosis(f.why).find("--echo on") != std::string::npos) {
        if (p_->has_several()) say("what came is the request's own echo: try --echo on");
        ++all_->echoed;
        is_over_ = true;
        return done;
    }
    if (f.why.error() == servobus::errc::gateway_exception) {
        ++all_->of_gateway;
        return done;
    }
    if (f.what == presence::no_response) {
        // A few addresses at one setting are worth more than a request each.
        const bool are_few = !p_->has_several() && p_->last - p_->first < 8;
        return are_few ? look_longer(node, p_->limits.response + servobus::milliseconds(300)) : done;
    }
    return f.what == presence::garbled ? garbled(node) : present(node, p_->limits);
}

// Says of the first one what it is.
int scan_pass::garbled(std::uint8_t node) {
    if (!heard_.unasked.empty()) return done; // what is garbled here is not of this address
    if (!std::exchange(is_damage_said_, true)) {
        line_account heard;
        const auto request = servobus::modbus::read_frame(node, 0, 1);
        constexpr unsigned reads = 6;
        for (unsigned i = 0; i < reads; ++i)
            heard.add(hear(*port_, request, p_->limits.response), p_->limits.response);
        if (heard.paused != 0) {
            say(words_on_pause(heard) + ": give --inter-byte " + std::to_string(pause_for(heard)) +
                " with every command");
            return print(node, "garbled");
        }
        if (heard.answered != 0) {
            say(std::to_string(heard.damaged + heard.silent) + " of " + counted(heard.asked, "read") +
                " of node " + std::to_string(node) +
                " had no valid response: check wires, termination, common ground and supply");
            is_damage_said_ = false; // of another address
            return present(node, p_->limits);
        }
        if (heard.damaged != 0) {
            say(words_on_damage(heard, "node " + std::to_string(node)) +
                ": another rate or format, two devices at one address, another program, or noise");
        }
    }
    return print(node, "garbled");
}

int scan_pass::fail(std::uint8_t node, servobus::status why) {
    shown_.end();
    listen(servobus::milliseconds(500));
    return complain(failed, setting_ + " node " + std::to_string(node) + ": " +
                                why_text(target{}, why, *port_) +
                                (!heard_.unasked.empty() ? "; " + words_on_unasked(heard_) : std::string{}));
}

// A device that has responded.
int scan_pass::present(std::uint8_t node, const servobus::response_limits& limits) {
    line_account after;
    after.add(hear(*port_, {}, until_second_response), limits.response);
    has_responded_[node] = true;
    if (frames_of(node, after.unasked) != 0) {
        say(words_on_two_responses("node " + std::to_string(node), false));
        return print(node, "not identified");
    }
    if (!after.unasked.empty() && heard_.unasked.empty()) {
        say(counted(after.unasked.size(), "byte") + " came after the response of node " +
            std::to_string(node) + ": another program or master sends on this line, or it picks up noise");
    }
    introduced who = introduce(on_, node, *p_, limits);
    if (p_->identifies) who.name += ": " + identification_of(on_, node, *p_, limits);
    const int status = print(node, who.name);
    if (who.lost != 0) {
        say(std::to_string(who.lost) + " of " + counted(who.asked, "read") + " of node " +
            std::to_string(node) +
            " had no valid response: check wires, termination, common ground and supply; doctor counts "
            "them");
    }
    return status;
}

// Whose response came while the next address was asked already.
int scan_pass::look_again() {
    const overheard after = hear(*port_, {}, servobus::milliseconds(300));
    std::vector<std::uint8_t> all = on_.observer().all;
    for (const overheard_byte& b : after.came) all.push_back(b.byte);
    for (const found_frame& f : log_line::find_frames(all).frames) {
        const std::uint8_t node = f.frame[0];
        if (node < p_->first || node > p_->last || has_responded_[node]) continue;
        if (const int status = look_longer(node, servobus::milliseconds(1500)); status != done) return status;
    }
    return done;
}

// An address that gave no response in time: its response may be late, or lost now and then.
int scan_pass::look_longer(std::uint8_t node, servobus::duration longest) {
    constexpr unsigned tries = 2;
    const auto request = servobus::modbus::read_frame(node, 0, 1);
    parsed_read late;
    // A late response belongs to no later read.
    (void)hear(*port_, {}, std::max(p_->gaps.gap, p_->limits.response * 2u + servobus::milliseconds(100)));
    for (unsigned i = 0; i < tries && late.responses.empty(); ++i)
        late = parse_overheard(hear(*port_, request, longest));
    if (late.responses.empty()) return done;
    servobus::response_limits limits = p_->limits;
    if (limits.response < late.responses[0]) {
        const unsigned ms = timeout_for(late.responses[0]);
        limits.response = servobus::milliseconds(ms);
        say("node " + std::to_string(node) + " responds after " + ms_text(late.responses[0]) +
            " ms, later than the " + std::to_string(p_->limits.response.us / 1000) +
            " ms that are allowed: give --timeout " + std::to_string(ms) + " with every command");
    } else {
        say("node " + std::to_string(node) +
            " gave no response to the first request: a bad line, or a device that "
            "responds now and then; doctor counts it");
    }
    return present(node, limits);
}

void scan_pass::listen(servobus::duration time) { heard_.add(hear(*port_, {}, time), p_->limits.response); }

int scan_pass::print(std::uint8_t node, const std::string& who) {
    shown_.end();
    std::printf("%s %u %s\n", setting_.c_str(), unsigned{node}, who.c_str());
    ++all_->found;
    return streams::flush() ? done : failed;
}

void scan_pass::say(const std::string& what) {
    shown_.end();
    note(setting_ + ": " + what);
}

} // namespace tool::scanning
