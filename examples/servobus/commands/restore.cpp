// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus restore: a drive's parameters from a file. It writes only what differs, each once, and reads each
// back; nothing is sent before the whole file has been found good.
#include <cstdio>

#include "../os/interrupts.hpp"
#include "../parameters/changes.hpp"
#include "../registers/consent.hpp"
#include "../streams/messages.hpp"
#include "../words/numbers.hpp"
#include "commands.hpp"

namespace tool {
namespace {

class restoration {
  public:
    restoration(const target& of, const arguments& asked)
        : asked_{&asked}, changes_{on_,
                                   of,
                                   {.verb = "restore",
                                    .is_dry = asked.has("dry-run"),
                                    .saves = asked.has("save"),
                                    .in_parts = asked.has("part")}} {}

    int run(const std::vector<parameter>& file) {
        interrupts::arm();
        if (const int status = changes_.look_for_rest(); status != done) return status;
        std::vector<parameter> wanted;
        for (const parameter& p : file) {
            if (is_restorable(*p.row) && p.words) wanted.push_back(p);
        }
        if (const int status = changes_.compare(wanted); status != done) return status;
        say_what_differs(file);
        if (const int status = changes_.say_cost(); status != done) return status;
        if (asked_->has("dry-run")) {
            changes_.print();
            return done;
        }
        if (changes_.all().empty() && !asked_->has("save")) return done;
        if (const int status = ask_consent(*asked_, "restore"); status != done) return status;
        if (const int status = changes_.look_for_rest(); status != done)
            return status; // that may have taken long
        if (const int status = changes_.write(); status != done) return status;
        return asked_->has("save") ? changes_.save() : done;
    }

    session& line() { return on_; }

  private:
    void say_what_differs(const std::vector<parameter>& file) const {
        std::size_t skipped = 0;
        std::size_t unknown = 0;
        for (const parameter& p : file) {
            if (!is_restorable(*p.row)) {
                ++skipped;
            } else if (!p.words) {
                ++unknown;
            }
        }
        const std::size_t compared = file.size() - skipped - unknown;
        note(std::to_string(changes_.differing()) + " of " + counted(compared, "parameter") +
             " differ; skipped: " + counted(skipped, "row") + " (the line's settings, triggers, targets)" +
             (unknown != 0 ? ", " + std::to_string(unknown) + " marked ?" : ""));
    }

    const arguments* asked_;
    session on_;
    changes changes_;
};

} // namespace

int restore(const arguments& asked) {
    if (asked.words().size() != 3) return complain(usage, "restore takes PORT DEVICE[:NODE] FILE");
    const std::optional<target> of = parse_target(asked.words()[1]);
    if (!of) return usage;
    if (of->kind == nullptr) return complain(usage, "restore needs a device with a map, not raw");
    if (asked.has("save") && !of->kind->save)
        return complain(usage, std::string{"--save: "} + of->facts().name + " has no command to save");
    if (asked.has("part") && of->kind->most_stored == 0)
        return complain(usage, std::string{"--part: "} + of->facts().name + " takes all at once");
    if (const int status = refuse_moving(*of->kind, "restore"); status != done) return status;
    const std::optional<std::vector<parameter>> file = parse_file(*of->kind, asked.words()[2]);
    if (!file) return usage;
    restoration r{*of, asked};
    if (const int status = r.line().check(asked, *of); status != done) return status;
    if (const int status = r.line().open(asked.words()[0].c_str()); status != done) return status;
    return r.run(*file);
}

} // namespace tool
