// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "machine.hpp"

#include <algorithm>
#include <cstdio>

#include "../device_file/device_file.hpp"
#include "../devices/devices.hpp"
#include "../parameters/changes.hpp"
#include "../streams/messages.hpp"
#include "../words/nearest.hpp"

namespace tool {
namespace {

constexpr std::size_t largest_machine_file = 1'000'000; // bytes of a machine file

bool responds(session& on, const machine_section& wanted) {
    const asked_row first = first_readable(*wanted.kind);
    if (first.row == nullptr) return false;
    std::vector<u16> words(first.row->words());
    const servobus::errc error = on.read(choose(*first.row, first.in), words).error();
    return error == servobus::errc::ok || error == servobus::errc::exception;
}

} // namespace

std::string text_of(const place& where) {
    return "node " + std::to_string(where.node) + ", " + std::to_string(where.baud) + " baud " +
           text(where.format);
}

place finished_place(const machine_section& wanted) { return {wanted.node, wanted.baud, wanted.format}; }

int choose_sections(const arguments& asked, std::vector<machine_section>& sections) {
    const std::string& path = asked.words()[1];
    std::string why;
    const std::string text = read_text_file(path, largest_machine_file, why);
    if (!why.empty()) return complain(usage, why);
    machine_file file;
    if (why = file.parse(path, text); !why.empty()) return complain(usage, path + ':' + why);
    for (std::size_t i = 2; i < asked.words().size(); ++i) {
        const machine_section* const named = file.find(asked.words()[i]);
        if (named == nullptr) {
            std::vector<std::string_view> known;
            for (const machine_section& s : file.sections()) known.push_back(s.name);
            return complain(usage, path + " has no drive [" + asked.words()[i] + "]" +
                                       did_you_mean(asked.words()[i], known, ""));
        }
        if (std::ranges::find(sections, named->name, &machine_section::name) != sections.end())
            return complain(usage, "[" + named->name + "] is named twice");
        sections.push_back(*named);
    }
    if (asked.words().size() == 2) sections = file.sections();
    for (machine_section& s : sections) {
        if (s.says_rate) continue;
        const std::optional<rate_and_format> setting = parse_rate_and_format(asked, {s.baud, s.format});
        if (!setting) return usage;
        s.baud = setting->baud;
        s.format = setting->format;
    }
    if (asked.has("at") && sections.size() != 1)
        return complain(usage, "--at is about one drive: name it behind " + path);
    if (any_port::is_network(asked.words()[0])) {
        for (const machine_section& s : sections) {
            for (const machine_line& l : s.lines) {
                if (!l.is_required && is_of_line(*s.kind, *l.row) && l.row->address != s.kind->node_register)
                    return complain(usage,
                                    path + ':' + std::to_string(l.line) + ": " + name_of(*l.row) +
                                        " cannot be set through a gateway, which has a rate of its own");
            }
        }
    }
    return done;
}

// Opens a session at one place, whether a drive responds there or not.
static int open_at(const arguments& asked, const machine_section& wanted, const place& where,
                   found_drive& made) {
    made.of = target{.kind = wanted.kind, .node = where.node, .has_node = true};
    made.where = where;
    made.on = std::make_unique<session>();
    if (const int status = made.on->check(asked, made.of); status != done) return status;
    if (!any_port::is_network(asked.words()[0])) made.on->set_rate(where.baud, where.format);
    return made.on->open(asked.words()[0].c_str());
}

int find_among(const arguments& asked, const machine_section& wanted, const std::vector<place>& places,
               std::optional<found_drive>& found) {
    for (const place& where : places) {
        found.emplace();
        if (const int status = open_at(asked, wanted, where, *found); status != done) return status;
        if (responds(*found->on, wanted)) return done;
    }
    found.reset();
    return done;
}

int find_drive(const arguments& asked, const machine_section& wanted, found_drive& found) {
    const place finished = finished_place(wanted);
    const auto node = asked.number("at", wanted.kind->facts().lowest_address,
                                   wanted.kind->facts().highest_address, finished.node);
    const auto setting = parse_rate_and_format(asked, {finished.baud, finished.format});
    if (!node || !setting) return usage;
    const place now{static_cast<std::uint8_t>(*node), setting->baud, setting->format};

    std::optional<found_drive> first;
    if (const int status = find_among(asked, wanted, {now}, first); status != done) return status;
    const bool is_one_place = now.node == finished.node && first && first->on->port().ignores_rate();
    if (now != finished && !is_one_place) {
        if (first) first->on.reset(); // a port has one user
        std::optional<found_drive> second;
        if (const int status = find_among(asked, wanted, {finished}, second); status != done) return status;
        if (first && second)
            return complain(failed, "[" + wanted.name + "]: two drives respond, at " + text_of(now) +
                                        " and at " + text_of(finished) + "; connect one alone");
        if (first) {
            if (const int status = find_among(asked, wanted, {now}, first); status != done) return status;
        } else {
            first = std::move(second);
        }
    }
    if (!first) {
        return complain(failed, "[" + wanted.name + "] does not respond at " + text_of(now) +
                                    (now == finished ? "; --at, --baud and --format say where it is now"
                                                     : ", nor at " + text_of(finished)));
    }
    found = std::move(*first);
    return done;
}

int compare_required(found_drive& at, const machine_section& wanted, std::size_t& differing) {
    const std::vector<parameter> required = wanted.required();
    changes found{*at.on, at.of, {.verb = "diff", .is_dry = true}};
    if (const int status = found.read_differences(required); status != done) return status;
    for (const change& c : found.all()) {
        std::printf("%s.%s is %s, required %s\n", wanted.name.c_str(), name_of(*c.row).c_str(),
                    words_text(*c.row, c.before).c_str(), words_text(*c.row, c.after).c_str());
    }
    differing += found.differing();
    return done;
}

} // namespace tool
