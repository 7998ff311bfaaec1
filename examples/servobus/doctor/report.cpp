// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "report.hpp"

#include <cstdio>

namespace tool::diagnosis {
namespace {

// "1 finding matters", "2 findings matter"
std::string findings_that(unsigned count, const char* one, const char* many) {
    return counted(count, "finding") + ' ' + (count == 1 ? one : many);
}

std::string held_text(const servobus::entry& row, const held_registers& held) {
    std::vector<u16> words;
    for (std::size_t i = 0; i < row.words(); ++i)
        words.push_back(held.word(static_cast<u16>(row.address + i)));
    return std::string{static_cast<const char*>(row.name)} + '=' + value_text(choose(row), words);
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

std::string report::command_for(const std::string& device, const std::string& name,
                                const std::string& rest) const {
    return "servobus " + name + ' ' + port_ + ' ' + device + (rest.empty() ? "" : " " + rest) + options_;
}

void report::finding(const check& c, const held_registers& held, const servobus::catalogue& map) {
    std::string text;
    for (const u16 address : c.of.all())
        text += (text.empty() ? "" : ", ") + held_text(*map.find(address), held);
    text += std::string{": "} + c.why;
    if (c.more != nullptr) text += ". " + c.more(held, c);
    if (text.ends_with('.')) text.pop_back();
    const std::string write = c.by.compose != nullptr ? c.by.compose(held, c) : c.by.write;
    std::string act = c.by.act;
    if (!write.empty()) act += (act.empty() ? "" : ": ") + command("write", write);
    c.is == refuses ? refuse(text, act) : warn(text, act);
}

int report::end(bool can_be_enabled) {
    std::string text = device_ + ": ";
    if (refusals_ != 0) text += findings_that(refusals_, "refuses an enable", "refuse an enable");
    if (unknown_ != 0) {
        text += std::string{refusals_ != 0 ? "; " : ""} + counted(unknown_, "register") +
                (unknown_ == 1 ? " that decides" : " that decide") + " could not be read";
    }
    if (refusals_ == 0 && unknown_ == 0 && can_be_enabled) text += "nothing refuses an enable";
    if (others_ != 0) {
        text += (text.ends_with(": ") ? "" : "; ") + findings_that(others_, "matters", "matter");
    } else if (text.ends_with(": ")) {
        text += "nothing found";
    }
    std::printf("%s\n", text.c_str());
    return refusals_ != 0 || unknown_ != 0 ? failed : done;
}

} // namespace tool::diagnosis
