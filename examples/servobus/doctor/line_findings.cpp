// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "line_findings.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "../os/hear.hpp"
#include "../os/interrupts.hpp"
#include "../os/port_users.hpp"
#include "../words/numbers.hpp"

namespace tool::diagnosis {
namespace {

using servobus::errc;
using servobus::milliseconds;

// So many reads find what happens to one of ten with a probability of 0.96.
constexpr unsigned reads = 30;

std::string setting_of(const session& on) {
    if (on.port().is_network()) return "through the gateway";
    return "at " + std::to_string(on.baud()) + " " + text(on.format());
}

// The command without one of its options.
std::string drop_option(std::string command, const std::string& name) {
    const std::size_t at = command.find(" --" + name + ' ');
    if (at == command.npos) return command;
    const std::size_t value = command.find(' ', at + 1) + 1;
    return command.erase(at, std::min(command.find(' ', value), command.size()) - at);
}

line_terms terms_of(const report& to, const std::string& port, const target& of, const session& on) {
    line_terms t;
    t.who = "node " + std::to_string(of.node);
    t.setting = setting_of(on);
    t.limit = on.response_limit();
    t.removes_echo = on.removes_echo();
    t.is_network = on.port().is_network();
    t.without_echo = drop_option(to.command("doctor"), "echo");
    t.with_echo = to.command("doctor", "--echo on");
    t.with_timeout = drop_option(to.command("doctor"), "timeout") + " --timeout ";
    t.with_pause = drop_option(to.command("doctor"), "inter-byte") + " --inter-byte ";
    t.scan = "servobus scan " + port + to.echo_option();
    return t;
}

// The response limit of a program whose responses began after `most`. An adapter's latency timer may take 16 ms.
unsigned limit_for(servobus::duration most) {
    const unsigned ms = (most.us + 999) / 1000;
    return (std::max({30u, 2 * ms, ms + 16}) + 9) / 10 * 10;
}

// As a program names the device. The header that `servobus cpp` makes of a file has a `device` too.
std::string type_of(const target& of) {
    const std::string name = of.kind->word();
    if (of.kind->file != nullptr) return "device";
    if (name == "yako-closed-loop") return "yako::closed_loop::device";
    if (name == "yako-open-loop") return "yako::open_loop::device";
    return name + "::device";
}

// The line of code that states the limit, where the profile's is too short, or far longer than it needs to be.
void state_limit(report& to, const target& of, const session& on, const line_account& heard) {
    const unsigned usual = of.facts().limits.response.us / 1000;
    const unsigned wanted = limit_for(heard.most());
    if (on.port().is_network() || !heard.is_reliable() || (wanted <= usual && wanted > usual / 2)) return;
    const std::string ms = std::to_string(wanted);
    to.line("in a program: responds_within(node<" + type_of(of) + ">{" + std::to_string(of.node) +
            "}, milliseconds(" + ms + ")) waits " + ms + " ms for a response; by default it is " +
            std::to_string(usual) + " ms");
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

void line_hearing::listen() { account_.add(on_->hear({}, milliseconds(300)), on_->response_limit()); }

void line_hearing::ask(unsigned count, const servobus::entry& row, servobus::table from) {
    constexpr unsigned until_dead = 3; // reads without a byte on a line that gives none
    const std::vector<std::uint8_t> request = on_->read_request(row, from);
    const servobus::duration limit = on_->response_limit();
    for (unsigned i = 0; i < count && !interrupts::came(); ++i) {
        const bool is_first = account_.asked < until_dead;
        if (!is_first && account_.silent == account_.asked) return;
        const servobus::duration longest =
            account_.asked == 0
                ? limit + milliseconds(3000) // a response that is later than this is taken for two
            : is_first ? limit + milliseconds(1000)
                       : std::max(limit + milliseconds(300), account_.most() * 2u);
        account_.add(on_->hear(request, longest), limit, on_->timing().visible_gap());
    }
}

void explain_silence(report& to, const std::string& port, const target& of, servobus::status why, session& on,
                     line_hearing& ear, const asked_row& asked) {
    const std::string what = why_text(of, why, on);
    constexpr std::uint8_t last_of_request = 3; // illegal function, address, value
    if (why.error() == errc::exception && why.exception() > last_of_request)
        return to.refuse("the device responds, and " + what, "ask again: " + to.command("doctor"));
    if (why.error() == errc::exception) {
        to.refuse("the device responds, and " + what + ": perhaps it is another device than " +
                      of.kind->word(),
                  "servobus scan " + port + to.echo_option());
        return;
    }
    const bool is_foreign = what.find("try tcp://") != what.npos;
    if (why.error() == errc::port_lost || is_foreign) {
        return to.refuse(what, is_foreign ? "give the port that it names"
                               : on.port().is_network()
                                   ? "end its other clients, then " + to.command("doctor")
                                   : "plug the adapter in, and check its cable");
    }
    (void)on.hear({}, on.response_limit() + milliseconds(1500)); // a late response belongs to no later read
    const bool is_first = ear.account().asked == 0;
    ear.ask(reads, *asked.row, asked.in);
    const std::vector<remark> remarks = remarks_on(ear.account(), terms_of(to, port, of, on));
    if (remarks.empty()) {
        return to.refuse(what + ", node " + std::to_string(of.node) + ' ' + setting_of(on) +
                             "; then all of " + counted(ear.account().asked, "read") +
                             " of one register, with pauses between them, had a response",
                         "it fails now and then; or with several registers at once: termination, " +
                             drop_option(to.command("doctor"), "inter-byte") + " --inter-byte 100" +
                             "; or right after a response: " + drop_option(to.command("doctor"), "gap") +
                             " --gap 25");
    }
    to.refuse(remarks[0].what, remarks[0].act);
    for (std::size_t i = 1; i < remarks.size(); ++i) to.warn(remarks[i].what, remarks[i].act);
    if (is_first && ear.account().answered != 0) state_limit(to, of, on, ear.account());
}

void judge_responses(report& to, const std::string& port, const target& of, session& on, line_hearing& ear,
                     const asked_row& asked) {
    ear.ask(reads, *asked.row, asked.in);
    const line_account& heard = ear.account();
    const std::string allowed = std::to_string(on.response_limit().us / 1000) + " ms are allowed";
    if (heard.answered != 0) {
        to.line(std::to_string(heard.answered) + " of " + counted(heard.asked, "read") + ' ' +
                setting_of(on) + (heard.answered == 1 ? " has" : " have") +
                " a response, which begins after " + ms_text(heard.least()) + ", " + ms_text(heard.median()) +
                ", " + ms_text(heard.most()) + " ms (least, median, most); " + allowed);
        state_limit(to, of, on, heard);
    }
    const std::vector<remark> remarks = remarks_on(heard, terms_of(to, port, of, on));
    for (const remark& r : remarks) heard.is_reliable() ? to.warn(r.what, r.act) : to.refuse(r.what, r.act);
}

void judge_period(report& to, const session& on, servobus::duration response, bool is_drive, unsigned devices,
                  unsigned period_ms) {
    // A setpoint of two words and its response, and a read of eleven words, as those of a ZLAC8015D. The gap before a
    // response is a part of its time.
    constexpr std::size_t characters = 13 + 8 + 8 + 27;
    const servobus::modbus::rtu_timing timing = on.timing();
    const servobus::duration one =
        timing.wire_time(characters) + servobus::duration{timing.t3_5} * 2u + response * 2u;
    const servobus::duration all = one * devices;
    const std::string take = std::string{is_drive ? "a setpoint and a read of the feedback take "
                                                  : "a write of two registers and a read of eleven take "} +
                             ms_text(all) + " ms here" + (devices == 1 ? "" : ", for all devices");
    if (period_ms == 0) {
        to.line(take);
    } else if (all.us > period_ms * 1000u) {
        to.warn("a period of " + std::to_string(period_ms) + " ms is too short: " + take,
                "a longer period or a higher rate");
    }
}

} // namespace tool::diagnosis
