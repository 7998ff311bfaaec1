// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus alarms: a drive's alarms as CSV, with advice from its manual.
#include <cstdio>

#include "../devices/devices.hpp"
#include "../streams/messages.hpp"
#include "commands.hpp"

namespace tool {

int alarms(const arguments& asked) {
    if (asked.words().size() != 1) return complain(usage, "alarms takes one DEVICE");
    const device* of = find_device(asked.words()[0]);
    if (of == nullptr) return usage;
    if (of->alarms == nullptr) return complain(usage, of->word() + ": a device file has no alarms");
    (void)std::puts("code,class,resettable,name,cause,remedy,reset");
    for (const alarm_row& a : of->alarms()) { // no advice has a quote
        std::printf("%s,%s,%s,%s,\"%s\",\"%s\",\"%s\"\n", a.code.c_str(), a.kind, a.resettable, a.name,
                    a.what.cause, a.what.remedy, a.what.reset);
    }
    return done;
}

} // namespace tool
