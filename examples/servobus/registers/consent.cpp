// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "consent.hpp"

#include "../streams/messages.hpp"
#include "../streams/streams.hpp"
#include "session.hpp"

namespace tool {

int ask_consent(const arguments& asked, const std::string& verb, const char* to_do, const char* refusal) {
    if (asked.has("yes")) return done;
    if (!streams::flush()) return failed;
    if (answer_to("Type " + verb + " to " + to_do + ": ") == verb) return done;
    return complain(failed, std::string{refusal} + "; --yes does it without a question");
}

std::string peril(const target& of, const chosen& what, std::span<const u16> words) {
    using servobus::flag;
    if (what.row == nullptr) return "is not in a map: who knows what it moves";
    if (words.size() == 1 && of.kind->is_stop(what.address, words[0])) return {};
    if (!of.kind->has_flags) return "is in a file without the column flags: who knows what it moves";
    if (has(what.row->flags, flag::motion))
        return of.kind->file != nullptr ? "moves the machine" : "moves the motor of an enabled drive";
    if (has(what.row->flags, flag::trigger)) return "acts as it is written";
    return {};
}

} // namespace tool
