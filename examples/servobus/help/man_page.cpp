// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus manual: the manual page. It has no date, so that the same version is always the same page.
#include <cstdio>

#include "../streams/messages.hpp"
#include "help.hpp"
#include "topics.hpp"

namespace tool {
namespace {

// Text that roff prints as it is: its escape character, the characters that typesetting would replace by
// others, and what at the beginning of a line would be a request.
std::string roff(std::string_view text) {
    std::string out;
    for (const char c : text) {
        const bool begins_line = out.empty() || out.back() == '\n';
        if (begins_line && (c == '.' || c == '\'')) out += "\\&";
        switch (c) {
        case '\\': out += "\\e"; break;
        case '-': out += "\\-"; break;
        case '\'': out += "\\(aq"; break;
        case '`': out += "\\(ga"; break;
        case '^': out += "\\(ha"; break;
        case '~': out += "\\(ti"; break;
        case '"': out += "\\(dq"; break;
        default: out += c;
        }
    }
    return out;
}

std::string bold(std::string_view text) { return "\\fB" + roff(text) + "\\fR"; }
std::string italic(std::string_view text) { return "\\fI" + roff(text) + "\\fR"; }

// Paragraphs, as in the table: an empty line would be a break of another size.
void put_text(std::string& out, std::string_view text, std::string_view between) {
    while (true) {
        const std::size_t end = text.find("\n\n");
        out += roff(text.substr(0, end)) + "\n";
        if (end == text.npos) return;
        out += between;
        text.remove_prefix(end + 2);
    }
}

void put_paragraphs(std::string& out, std::span<const option> options) {
    for (const option& o : options) {
        out += ".TP\n" + bold("--" + std::string{o.name});
        if (o.takes_value()) out += " " + italic(o.value);
        out += "\n" + roff(o.help) + ".\n";
    }
}

// Placeholders of a command's words, and what stands for itself.
std::string placeholders_of(const command& c) {
    if (c.words.empty()) return {};
    const char first = c.words[0];
    return " " + (first >= 'a' && first <= 'z' ? bold(c.words) : italic(c.words));
}

} // namespace

std::string manual_page(const command_table& all) {
    std::string out = ".\\\" SPDX-FileCopyrightText: The servobus authors\n"
                      ".\\\" SPDX-License-Identifier: BSL-1.0\n"
                      ".TH SERVOBUS 1 \"\" \"servobus " +
                      version_text() + "\" \"User Commands\"\n.nh\n.ad l\n.SH NAME\nservobus \\- " +
                      roff(purpose) + "\n.SH SYNOPSIS\n";
    for (const command& c : all.all) {
        const bool has_options = !c.options.empty() || !c.shared.empty();
        out += bold("servobus " + std::string{c.name}) + placeholders_of(c) +
               (has_options ? " [\\fIOPTION\\fR...]" : "") + "\n.br\n";
    }
    out += bold("servobus") + " [" + italic("COMMAND") + "] " + bold("--help") + "\n.br\n" +
           bold("servobus --version") + "\n.SH ARGUMENTS\n";
    for (const topic& t : topics()) {
        out += ".TP\n" + italic(t.name) + "\n";
        put_text(out, t.about, ".IP\n");
    }
    out += ".SH COMMANDS\n";
    for (const command& c : all.all) {
        out += ".SS \"" + bold(c.name) + placeholders_of(c) + "\"\n" + roff(sentence(c.summary)) + "\n";
        put_text(out, c.about, ".PP\n");
        put_paragraphs(out, c.options);
    }
    out += ".SH OPTIONS\n";
    for (const option_group* group : all.shared) {
        out += ".SS \"" + roff(group->title) + "\"\nFor " + users_of(*group, all) + ".\n" +
               roff(group->note) + "\n";
        put_paragraphs(out, group->options);
    }
    out += ".SH EXIT STATUS\n";
    put_text(out, exit_status, ".PP\n");
    out += ".SH EXAMPLES\n";
    for (const example& e : examples()) out += ".TP\n" + bold(e.line) + "\n" + roff(e.what) + ".\n";
    return out;
}

int print_manual(const command_table& all, const arguments& asked) {
    if (!asked.words().empty()) return complain(usage, "manual takes no words");
    (void)std::fputs(manual_page(all).c_str(), stdout);
    return done;
}

} // namespace tool
