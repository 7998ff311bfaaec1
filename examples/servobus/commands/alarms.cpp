// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus alarms: a drive's alarms as CSV.
#include <cstdio>

#include <servobus/device/c630s/alarms.hpp>
#include <servobus/device/c630s/values.hpp>

#include "../tool.hpp"

namespace tool {

int alarms(const arguments& asked) {
    if (asked.words().size() != 1) return complain(usage, "alarms takes one DEVICE");
    const device* of = find_device(asked.words()[0]);
    if (of == nullptr) return usage;
    if (std::string_view{of->facts().name} != servobus::c630s::device::facts.name)
        return complain(usage,
                        std::string{of->facts().name} +
                            " has no table of alarms; c630s has one (servobus map names fault registers)");
    (void)std::puts("code,class,resettable,name");
    for (const servobus::c630s::alarm& a : servobus::c630s::alarms)
        std::printf("Er.%03X,%s,%s,%s\n", static_cast<unsigned>(a.code), text(a.kind),
                    a.is_resettable ? "yes" : "no", a.name);
    return done;
}

} // namespace tool
