// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus backup: a drive's parameters into a file.
#include <cstdio>

#include <servobus/registers/value_text.hpp>

#include "../os/file_target.hpp"
#include "../os/interrupts.hpp"
#include "../parameters/parameters.hpp"
#include "../streams/messages.hpp"
#include "commands.hpp"

namespace tool {
namespace {

// A remark for each, and no words where the drive holds what restore would refuse.
std::size_t judge(std::vector<parameter>& all, std::string& first) {
    std::size_t left_out = 0;
    for (parameter& p : all) {
        if (p.words) {
            p.remark = words_text(*p.row, *p.words);
            if (takes_words(*p.row, *p.words)) continue;
            if (has_number(value_of_words(*p.row, *p.words), {}))
                p.remark += ", outside " + std::to_string(p.row->limits.low) + " .. " +
                            std::to_string(p.row->limits.high);
            p.words.reset();
        }
        if (left_out++ == 0) first = static_cast<const char*>(p.row->name) + (", " + p.remark);
    }
    return left_out;
}

} // namespace

int backup(const arguments& asked) {
    if (asked.words().size() < 2 || asked.words().size() > 3)
        return complain(usage, "backup takes PORT DEVICE[:NODE] and a FILE, or none for standard output");
    const std::optional<target> of = parse_target(asked.words()[1]);
    if (!of) return usage;
    if (of->kind == nullptr) return complain(usage, "backup needs a device with a map, not raw");
    session on;
    if (const int status = on.check(asked, *of); status != done) return status;
    std::optional<file_target> file;
    if (asked.words().size() == 3) {
        file.emplace(asked.words()[2]);
        if (const int status = file->prepare(asked.words()[0].c_str()); status != done) return status;
    }
    if (const int status = on.open(asked.words()[0].c_str()); status != done) return status;

    if (!of->kind->has_flags) {
        note(
            "warning: " + of->kind->word() +
            " has no column flags, so that triggers and targets are in the backup; restore takes none of it");
    }
    interrupts::arm();
    std::vector<const servobus::entry*> rows;
    for (const servobus::entry& e : of->kind->map->entries) {
        if (is_parameter(e)) rows.push_back(&e);
    }
    std::optional<std::vector<parameter>> all = read_parameters(on, *of, rows);
    if (!all) return failed;
    std::string first;
    const std::size_t left_out = judge(*all, first);
    if (left_out == all->size()) return complain(failed, "the drive refuses every register: " + first);
    if (left_out != 0) {
        note("warning: " + std::to_string(left_out) + " of " + std::to_string(all->size()) +
             " registers are marked ? and will not be restored, the first is " + first);
    }
    const std::string text = file_text(*of->kind, *all);
    if (file) return file->put(text);
    (void)std::fputs(text.c_str(), stdout);
    return done;
}

} // namespace tool
