// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "line_findings.hpp"

#include <algorithm>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "../os/port_users.hpp"

namespace tool::diagnosis {
namespace {

using servobus::errc;

std::string ms_text(servobus::duration d) {
    char text[32];
    (void)std::snprintf(text, sizeof text, "%u.%u", d.us / 1000, d.us / 100 % 10);
    return text;
}

std::string setting_of(const session& on) {
    if (on.port().is_network()) return "through the gateway";
    return "at " + std::to_string(on.baud()) + " " + text(on.format());
}

// So many reads find what happens to one of ten with a probability of 0.96.
constexpr unsigned reads = 30;

// `2: no response, 1: wrong CRC`
std::string list_of(const std::map<std::string, unsigned>& counts) {
    std::string all;
    for (const auto& [what, count] : counts)
        all += (all.empty() ? "" : ", ") + std::to_string(count) + ": " + what;
    return all;
}

bool is_damage(errc why) {
    using enum errc;
    for (const errc one : {truncated_response, bad_crc, wrong_function, wrong_byte_count, wrong_address,
                           wrong_value, wrong_quantity, too_short, too_long, bad_gap, collision}) {
        if (why == one) return true;
    }
    return false;
}

// `what` is what the bytes show, in words.
std::string advice_on(const report& to, const std::string& port, servobus::status why, const session& on,
                      const std::string& what) {
    if (what.find("--echo on") != what.npos) return to.command("doctor", "--echo on");
    if (what.find("--echo off") != what.npos) {
        std::string without = to.command("doctor");
        const std::string option = " --echo on";
        if (without.ends_with(option)) without.resize(without.size() - option.size());
        return without;
    }
    if (what.find("try tcp://") != what.npos) return "give the port that it names";
    if (on.port().is_network())
        return "check the node, and the rate and format that the gateway has: servobus scan " + port;
    const std::string scan = "servobus scan " + port + to.echo_option();
    if (is_damage(why.error()) || what.find(" came") != what.npos) {
        return "another rate or format, two devices at one address, another program, or noise: try " + scan +
               ", then termination and common ground";
    }
    return "the supply, A and B swapped, the node, the rate, the format, or the adapter's direction: try "
           "swapping A and "
           "B, then " +
           scan;
}

} // namespace

void judge_port(report& to, const std::string& port) {
    if (any_port::is_network(port)) return;
    for (const os::port_user& user : os::users_of(port)) {
        to.warn(port + " is open in " + text_of(user) + " too: two programs take each other's responses",
                "end one of them: kill " + std::to_string(user.pid));
    }
    const std::optional<os::latency_timer> timer = os::latency_of(port);
    if (timer && timer->ms > 1) {
        to.warn(
            "latency_timer=" + std::to_string(timer->ms) +
                " ms: the adapter keeps what it received for so long, and each response is that much later",
            "echo 1 | sudo tee " + timer->path);
    }
}

void explain_silence(report& to, const std::string& port, const target& of, servobus::status why,
                     const session& on) {
    const std::string what = why_text(of, why, on);
    if (why.error() == errc::exception) {
        to.refuse("the device responds, and " + what + ": perhaps it is another device than " +
                      of.kind->word(),
                  "servobus scan " + port + to.echo_option());
        return;
    }
    if (why.error() == errc::port_lost) return to.refuse(what, "plug the adapter in, and check its cable");
    std::string text = what.substr(0, what.find(": try ")); // what to try is said after the arrow
    text += ", node " + std::to_string(of.node) + ' ' + setting_of(on);
    if (why.error() == errc::timeout && what == servobus::text(errc::timeout))
        text += ": not a single byte came";
    to.refuse(text, advice_on(to, port, why, on, what));
}

response_times judge_responses(report& to, session& on, const servobus::entry& row, servobus::table from) {
    response_times r;
    std::vector<servobus::duration> took;
    std::map<std::string, unsigned> failures; // by what is wrong with them
    for (r.asked = 0; r.asked < reads; ++r.asked) {
        const servobus::status why = on.probe(row, from);
        if (!why.has_response()) ++failures[servobus::text(why.error())];
        const std::optional<servobus::duration> time = on.port().response_time();
        if (why.has_response() && time) took.push_back(*time);
    }
    std::sort(took.begin(), took.end(), [](auto a, auto b) { return a.us < b.us; });
    r.answered = static_cast<unsigned>(took.size());
    const std::string allowed = std::to_string(on.response_limit().us / 1000) + " ms that are allowed";
    if (!took.empty()) {
        r.least = took.front();
        r.median = took[took.size() / 2];
        r.most = took.back();
        to.line(std::to_string(r.answered) + " of " + std::to_string(r.asked) + " reads " + setting_of(on) +
                " have a response, which begins after " + ms_text(r.least) + ", " + ms_text(r.median) + ", " +
                ms_text(r.most) + " ms (least, median, most) of the " + allowed);
    }
    if (r.answered < r.asked) {
        to.warn(std::to_string(r.asked - r.answered) + " of " + std::to_string(r.asked) +
                    " reads have no valid response (" + list_of(failures) +
                    "): writes will end as unknown, and setpoints be late",
                "check wires, termination and common ground; where there was no response, a --timeout of " +
                    std::to_string(4 * on.response_limit().us / 1000));
    }
    if (r.most.us > on.response_limit().us / 2) {
        to.warn("responses begin after up to " + ms_text(r.most) + " ms of the " + allowed +
                    ": some will be late",
                "a longer --timeout, and in a program longer limits.response of the node");
    } else if (r.most.us > 10 * r.median.us + 20'000) {
        to.warn("a response began after " + ms_text(r.most) + " ms, half of them within " +
                    ms_text(r.median) + " ms: what delayed it may delay another one beyond the " + allowed,
                "look for it in the adapter, the gateway or this computer; or a longer --timeout");
    }
    return r;
}

void judge_period(report& to, const session& on, const response_times& took, unsigned devices,
                  unsigned period_ms) {
    // A setpoint of two words and its response, and a read of eleven words, as those of a ZLAC8015D. The gap before a
    // response is a part of its time.
    constexpr std::size_t characters = 13 + 8 + 8 + 27;
    const servobus::modbus::rtu_timing timing = on.timing();
    const servobus::duration one =
        timing.wire_time(characters) + servobus::duration{timing.t3_5} * 2u + took.median * 2u;
    const servobus::duration all = one * devices;
    if (period_ms == 0) {
        to.line("a setpoint and a read of the feedback take " + ms_text(all) + " ms here" +
                (devices == 1 ? "" : ", for all devices"));
    } else if (all.us > period_ms * 1000u) {
        to.warn("a period of " + std::to_string(period_ms) +
                    " ms is too short: a setpoint and a read of the feedback take " + ms_text(all) +
                    " ms here" + (devices == 1 ? "" : ", for all devices"),
                "a longer period or a higher rate");
    }
}

} // namespace tool::diagnosis
