// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus alarms: a drive's alarms as CSV, with advice from its manual.
#include <cstdio>

#include <servobus/device/c630s/advice.hpp>
#include <servobus/device/yako/advice.hpp>
#include <servobus/device/yako/feedback.hpp>
#include <servobus/device/zlac8015d/advice.hpp>

#include "../tool.hpp"

namespace tool {

std::vector<alarm_row> zlac8015d_alarms() {
    namespace zlac = servobus::zlac8015d;
    std::vector<alarm_row> rows;
    for (const zlac::fault f : zlac::all_faults)
        rows.push_back({hex_word(static_cast<u16>(f)), "fault", "unstated", text(f), zlac::advice_for(f)});
    return rows;
}

std::vector<alarm_row> yako_alarms() {
    namespace yako = servobus::yako;
    std::vector<alarm_row> rows;
    for (u16 error = 1; error <= yako::error_code.limits.high; ++error)
        rows.push_back(
            {std::to_string(error), "alarm", "unstated", yako::error_text(error), yako::advice_for(error)});
    return rows;
}

std::vector<alarm_row> c630s_alarms() {
    namespace c630s = servobus::c630s;
    std::vector<alarm_row> rows;
    for (const c630s::alarm& a : c630s::alarms) {
        char code[8];
        (void)std::snprintf(code, sizeof code, "Er.%03X", static_cast<unsigned>(a.code) & 0xFFFu);
        rows.push_back(
            {code, text(a.kind), a.is_resettable ? "yes" : "no", a.name, c630s::advice_for(a.code)});
    }
    return rows;
}

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
