// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus diff: the drives of a machine file compared with it. It only reads.
#include "../machine/machine.hpp"
#include "../os/interrupts.hpp"
#include "../parameters/changes.hpp"
#include "../streams/messages.hpp"
#include "commands.hpp"

namespace tool {

int diff(const arguments& asked) {
    if (asked.words().size() < 2)
        return complain(usage, "diff takes PORT, a machine FILE, and NAMEs of its drives");
    std::vector<machine_section> sections;
    if (const int status = choose_sections(asked, sections); status != done) return status;
    interrupts::arm();
    std::size_t differing = 0;
    for (const machine_section& wanted : sections) {
        found_drive at;
        if (const int status = find_drive(asked, wanted, at); status != done) return status;
        if (const int status = compare_required(at, wanted, differing); status != done) return status;
        changes found{*at.on, at.of, {.verb = "diff", .is_dry = true, .drive = wanted.name + '.'}};
        if (const int status = found.read_differences(wanted.wanted()); status != done) return status;
        found.print();
        differing += found.differing();
    }
    return differing == 0 ? done : failed;
}

} // namespace tool
