// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "report.hpp"

#include <cstdio>

#include "../registers/typed_value.hpp"
#include "../streams/messages.hpp"
#include "../words/numbers.hpp"

namespace tool::diagnosis {
namespace {

// "1 finding matters", "2 findings matter"
std::string findings_that(unsigned count, const char* one, const char* many) {
    return counted(count, "finding") + ' ' + (count == 1 ? one : many);
}

std::vector<u16> content_of(const servobus::entry& row, const held_registers& held) {
    std::vector<u16> words;
    for (std::size_t i = 0; i < row.words(); ++i)
        words.push_back(held.word(static_cast<u16>(row.address + i)));
    return words;
}
std::vector<u16> content_of(const servobus::entry& row, const new_value& wanted) {
    const auto low = static_cast<u16>(wanted.bits & 0xFFFFu);
    if (row.words() == 1) return {low};
    return {static_cast<u16>(wanted.bits >> 16), low};
}
std::string held_text(const servobus::entry& row, const held_registers& held) {
    return std::string{static_cast<const char*>(row.name)} + '=' +
           value_text(choose(row), content_of(row, held));
}
// `REG=VALUE ...` for `servobus write`.
std::string written_by(const check& c, const held_registers& held, const servobus::catalogue& map) {
    if (c.by.compose == nullptr) return c.by.write;
    std::string all;
    for (const new_value& wanted : c.by.compose(held, c)) {
        const servobus::entry& row = *map.find(wanted.address);
        all += (all.empty() ? "" : " ") + typed_assignment(choose(row), content_of(row, wanted));
    }
    return all;
}

} // namespace

void report::say(const char* word, const std::string& text, const std::string& act) {
    std::printf("%-8s %s%s%s\n", word, text.c_str(), act.empty() ? "" : " -> ", act.c_str());
}

void report::refuse(const std::string& what, const std::string& act) {
    say("refused", what, act);
    ++refusals_;
}
void report::warn(const std::string& what, const std::string& act) {
    say("matters", what, act);
    ++others_;
}
void report::unread(const std::string& what, bool is_needed) {
    say("unread", what + (is_needed ? ", which decides whether an enable is refused" : ""));
    ++(is_needed ? unknown_ : others_);
}
void report::differ(const std::string& what) { say("differs", what); }
void report::differ_from_default(const std::string& value, const std::string& initial) {
    differ(value + ": the default is " + initial);
    ++changed_;
}

std::string report::command_for(const std::string& device, const std::string& name,
                                const std::string& rest) const {
    return "servobus " + name + ' ' + port_ + ' ' + device + (rest.empty() ? "" : " " + rest) + options_;
}

void report::finding(const check& c, const held_registers& held, const servobus::catalogue& map) {
    std::string text;
    const watched shown = c.shown_by != nullptr ? c.shown_by(held, c) : c.of;
    for (const u16 address : shown.all())
        text += (text.empty() ? "" : ", ") + held_text(*map.find(address), held);
    text += std::string{": "} + c.why;
    if (c.more != nullptr) text += ". " + c.more(held, c);
    const auto listed = c.differing != nullptr ? c.differing(held, c) : std::vector<new_value>{};
    if (!listed.empty()) {
        text += ". " + counted(listed.size(), "register") + (listed.size() == 1 ? " differs" : " differ") +
                (is_long_ ? ", listed below" : ", listed by " + command("doctor", "--long"));
    }
    if (text.ends_with('.')) text.pop_back();
    const std::string write = written_by(c, held, map);
    std::string act = c.by.act;
    if (!write.empty()) act += (act.empty() ? "" : ": ") + command("write", write);
    c.is == refuses ? refuse(text, act) : warn(text, act);
    for (const new_value& wanted : listed) {
        const servobus::entry& row = *map.find(wanted.address);
        if (is_long_)
            differ(held_text(row, held) + ": has to be " + value_text(choose(row), content_of(row, wanted)));
    }
}

int report::end(bool can_be_enabled) {
    std::string text = device_ + ": ";
    if (refusals_ != 0) {
        text += can_be_enabled
                    ? findings_that(refusals_, "refuses an enable", "refuse an enable")
                    : findings_that(refusals_, "keeps it from being used", "keep it from being used");
    }
    if (unknown_ != 0) {
        text += std::string{refusals_ != 0 ? "; " : ""} + counted(unknown_, "register") +
                (unknown_ == 1 ? " that decides" : " that decide") + " could not be read";
    }
    if (refusals_ == 0 && unknown_ == 0 && can_be_enabled) text += "nothing refuses an enable";
    if (others_ != 0)
        text += (text.ends_with(": ") ? "" : "; ") + findings_that(others_, "matters", "matter");
    if (changed_ != 0) {
        text += (text.ends_with(": ") ? "" : "; ") + counted(changed_, "register") +
                (changed_ == 1 ? " differs from its default" : " differ from their defaults");
    }
    if (text.ends_with(": ")) text += "nothing found";
    std::printf("%s\n", text.c_str());
    return refusals_ != 0 || unknown_ != 0 ? failed : done;
}

} // namespace tool::diagnosis
