// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "line_words.hpp"

#include <cstdio>
#include <utility>

#include "../words/numbers.hpp"

namespace tool {
namespace {

const char* const check_wires = "check wires, termination, common ground and supply";

remark on_silence(const line_account& heard, const line_terms& terms) {
    const std::string who = ", " + terms.who + ' ' + terms.setting;
    if (terms.is_network) {
        return {"no response" + who + ": the gateway is connected, and not a single byte came",
                "it may serve one client at a time: end the others; the node, the protocol (tcp:// or "
                "mbap://), and the "
                "rate and format that the gateway has: " +
                    terms.scan + " --nodes " + terms.who.substr(terms.who.rfind(' ') + 1) +
                    " --timeout 2000"};
    }
    const bool has_echo = heard.echoed != 0;
    return {(has_echo ? "no response" + who + ": the request's own echo came, and not a single byte after it"
                      : "no response" + who + ": not a single byte came"),
            "the supply, A and B swapped, the node, the rate, the format, or the adapter's direction: try "
            "swapping A and "
            "B, then " +
                terms.scan + ", and with --timeout 500"};
}

// `2 with a wrong CRC, 1 cut short`
std::string damage_text(const line_account& heard) {
    const std::pair<unsigned, const char*> kinds[] = {
        {heard.silent, "without a byte"},
        {heard.bad_crc, "with a wrong CRC"},
        {heard.cut, "cut short"},
        {heard.damaged - heard.bad_crc - heard.cut, "with other bytes"}};
    std::string all;
    for (const auto& [count, what] : kinds) {
        if (count != 0) all += (all.empty() ? "" : ", ") + std::to_string(count) + " " + what;
    }
    return all;
}

} // namespace

std::string ms_text(servobus::duration d) {
    char text[32];
    (void)std::snprintf(text, sizeof text, "%u.%u", d.us / 1000, d.us / 100 % 10);
    return text;
}

unsigned timeout_for(servobus::duration most) { return (most.us / 1000 * 2 / 100 + 1) * 100; }

std::string words_on_unasked(const line_account& heard) {
    const found_frames found = log_line::find_frames(heard.unasked);
    const std::string when =
        " came in " + std::to_string(heard.listened.us / 1000) + " ms while nothing was asked here";
    if (!found.frames.empty()) {
        return counted(found.frames.size(), "frame") + when + ", the first of node " +
               std::to_string(found.frames[0].frame[0]) + ": another master or program is on this line";
    }
    return counted(heard.unasked.size(), "byte") + when +
           ": another program or device sends on this line, or it picks up noise";
}

std::string words_on_damage(const line_account& heard, const std::string& who) {
    std::string what = counted(heard.strays.size(), "byte") + " came, none a response of " + who + ": of " +
                       counted(heard.asked, "read") + ' ' + damage_text(heard);
    for (const found_frame& f : log_line::find_frames(heard.strays).frames) {
        const std::string other = "node " + std::to_string(f.frame[0]);
        if (other != who) return what + ", but frames of " + other;
    }
    return what;
}

std::string words_on_pause(const line_account& heard) {
    return std::to_string(heard.paused) + " of " + counted(heard.asked, "read") +
           (heard.paused == 1 ? " has" : " have") + " a pause inside the response, of up to " +
           ms_text(heard.pause) + " ms: a client takes it for its end";
}
unsigned pause_for(const line_account& heard) { return heard.pause.us / 1000 * 2 + 1; }

std::string words_on_two_responses(const std::string& who, bool differ) {
    return "a request to " + who + " had two responses" + (differ ? " that differ" : "") +
           ": two devices have this address, or something on the line sends them twice; a value may be of "
           "another "
           "register";
}

std::vector<remark> remarks_on(const line_account& heard, const line_terms& terms) {
    std::vector<remark> all;
    const auto say = [&all](remark r) { all.push_back(std::move(r)); };
    const bool is_answered = heard.answered != 0;
    const std::string reads = " of " + counted(heard.asked, "read");
    if (!heard.unasked.empty())
        say({words_on_unasked(heard),
             "a line has one master: end the other; then termination, common ground and bias resistors"});
    if (!terms.removes_echo && heard.echoed != 0) {
        say({is_answered ? "the request's own echo comes before each response"
                         : "what came is the request's own echo, and no response after it",
             terms.with_echo +
                 (is_answered ? ""
                              : "; if no response comes then, the supply, A and B swapped, or the node")});
        if (!is_answered) return all;
    }
    if (terms.removes_echo && heard.echoed == 0 && heard.asked != 0 && heard.silent != heard.asked)
        say({"the request did not come back as echo", terms.without_echo});
    if (heard.asked != 0 && heard.silent == heard.asked) say(on_silence(heard, terms));
    if (!is_answered && heard.damaged != 0 && heard.unasked.empty()) {
        say({words_on_damage(heard, terms.who) + ", " + terms.setting,
             terms.is_network
                 ? "check the node, and the rate and format that the gateway has: " + terms.scan
                 : "another rate or format, two devices at one address, another program, or noise: try " +
                       terms.scan + ", then termination and common ground"});
    }
    if (heard.of_gateway != 0) {
        const char* const what =
            heard.gateway_exception == 0x0A ? "has no path to it" : "got no response of it";
        say({std::to_string(heard.of_gateway) + reads + " have exception " +
                 std::to_string(heard.gateway_exception) + ", by which a gateway says that it " + what,
             "the node, the supply of the device, the gateway's rate and format, and the wires behind it"});
    }
    if (heard.paused != 0)
        say({words_on_pause(heard),
             terms.with_pause + std::to_string(pause_for(heard)) + ", and with every command"});
    if (heard.doubled != 0)
        say({words_on_two_responses(terms.who, heard.differing != 0),
             "take one of them off the line, and give it another address"});
    else if (is_answered && heard.beside != 0 && heard.unasked.empty())
        say({counted(heard.beside, "byte") +
                 " came beside the responses: another program or master sends on this line, or "
                 "it picks up noise",
             "end the other one; then termination, common ground and bias resistors"});
    const unsigned lost = heard.silent + heard.damaged;
    if (is_answered && lost != 0) {
        std::string what = std::to_string(lost) + reads + (lost == 1 ? " has" : " have") + " no response, " +
                           damage_text(heard) + ": writes will end as unknown, and setpoints be late";
        if (heard.late == 0) what += "; the others begin within " + ms_text(heard.most()) + " ms";
        say({what, std::string{check_wires} + (heard.late == 0 ? "; a longer --timeout is no help" : "")});
    }
    const std::string allowed = std::to_string(terms.limit.us / 1000) + " ms that are allowed";
    const std::string longer = terms.with_timeout + std::to_string(timeout_for(heard.most())) +
                               ", and with every command; in a program a longer limits.response of the node";
    const std::string look = "look for what delays them in the adapter, the gateway or this computer; or ";
    if (heard.late != 0) {
        const bool is_usual = terms.limit.us / 2 < heard.median().us;
        say({std::to_string(heard.late) + " of " + counted(heard.answered, "response") + " began after the " +
                 allowed + ", the last after " + ms_text(heard.most()) + " ms" +
                 (is_usual ? "" : ", half of them within " + ms_text(heard.median()) + " ms"),
             (is_usual ? "" : look) + longer});
    } else if (heard.most().us > terms.limit.us / 2) {
        say({"responses begin after up to " + ms_text(heard.most()) + " ms of the " + allowed +
                 ": some will be late",
             longer});
    } else if (heard.most().us > 10 * heard.median().us + 20'000) {
        say({"a response began after " + ms_text(heard.most()) + " ms, half of them within " +
                 ms_text(heard.median()) + " ms: what delayed it may delay another one beyond the " + allowed,
             look + "a longer --timeout"});
    }
    return all;
}

} // namespace tool
