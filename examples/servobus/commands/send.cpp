// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus send: one request of any function, and its response in hex and in words.
#include <array>
#include <cstdio>
#include <string>

#include "../capture/capture.hpp"
#include "../registers/consent.hpp"
#include "../streams/messages.hpp"
#include "../streams/streams.hpp"
#include "commands.hpp"
#include "one_request.hpp"
#include "typed_pdu.hpp"

namespace tool {
namespace {

namespace modbus = servobus::modbus;

// As it is on a serial line.
frame_bytes frame_of(const target& of, servobus::bytes pdu) {
    frame_bytes frame(pdu.size() + 3);
    frame[0] = of.node;
    std::copy(pdu.begin(), pdu.end(), frame.begin() + 1);
    (void)modbus::close_frame(frame, pdu.size());
    return frame;
}

// `device`: as the command line names it.
void print(const target& of, const std::string& device, servobus::bytes request, servobus::bytes response) {
    const std::string named[] = {of.is_peer() ? "raw" : device}; // it has no rows, and no address on a line
    const std::optional<line_devices> devices = line_devices::parse(named);
    if (!devices) return;
    frame_explainer explainer{*devices};
    (void)explainer.explain({servobus::direction::request, frame_of(of, request)});
    const auto said = explainer.explain({servobus::direction::response, frame_of(of, response)});
    std::printf("%s\n%s\n", line_of(said.frame).c_str(), said.text.c_str());
}

// A request that is no read may have been carried out though its response is missing.
std::string failure_text(const one_request& on, servobus::status why, bool is_read) {
    const bool is_plain = is_read || why.outcome() == servobus::outcome::refused;
    return (is_plain ? std::string{} : std::string{text(why.outcome())} + ", ") + on.why_text(why);
}

} // namespace

int send(const arguments& asked) {
    if (asked.words().size() < 2)
        return complain(usage, "send takes PORT DEVICE[:NODE] and the bytes of a request in hex");
    const std::optional<target> of = parse_target(asked.words()[1]);
    if (!of) return usage;
    const std::optional<frame_bytes> pdu = parse_pdu(std::span{asked.words()}.subspan(2));
    if (!pdu) return usage;
    one_request on;
    if (const int status = on.open(asked, *of); status != done) return status;
    const bool is_read = is_pure_read(*pdu);
    if (!is_read) {
        note("warning: function " + function_text(*pdu) +
             " may write, and it is sent as it is: who knows what it moves");
        const int status = ask_consent(asked, "send", "send", "not confirmed, nothing was sent");
        if (status != done) return status;
    }
    std::array<std::uint8_t, modbus::max_pdu> room{};
    const servobus::result<servobus::bytes> response = on.transact(*pdu, room);
    if (!response) return complain(failed, failure_text(on, response.status(), is_read));
    print(*of, asked.words()[1], *pdu, *response);
    return streams::flush() ? done : failed;
}

} // namespace tool
