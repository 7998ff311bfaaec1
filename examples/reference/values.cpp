// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the pages of the maps say beyond `servobus map`: a line for each register of each drive, in columns
// divided by tabs. DEVICE ADDRESS FLAGS, then a column for each value or bit that has a name.
#include <cstdio>

#include <servobus/device/c630s/catalogue.hpp>
#include <servobus/device/yako/closed_loop_catalogue.hpp>
#include <servobus/device/yako/open_loop_catalogue.hpp>
#include <servobus/device/zlac8015d/catalogue.hpp>

#include "../servobus/device_file/named_values.hpp"

namespace {

using namespace servobus;

struct named_flag {
    flag of;
    const char* words;
};
constexpr named_flag flags[] = {
    {trigger, "acts when written"},
    {motion, "moves an enabled motor"},
    {communication, "setting of the line"},
    {scaled_elsewhere, "another register sets the scale"},
    {saved_on_write, "EEPROM"},
    {zero_by_name, "0 only by undocumented_zero"},
};

void print(const catalogue& map) {
    for (const entry& e : map.entries) {
        std::printf("%s\t0x%04X\t", map.device->name, unsigned{e.address});
        const char* between = "";
        for (const named_flag& f : flags) {
            if (!has(e.flags, f.of)) continue;
            std::printf("%s%s", between, f.words);
            between = "; ";
        }
        if (e.names == naming::halves) std::printf("\thigh byte left\tlow byte right");
        for (const named_value& v : e.values) std::printf("\t%s %s", tool::code_text(e, v).c_str(), v.name);
        std::putchar('\n');
    }
}

} // namespace

int main() {
    print(zlac8015d::catalogue);
    print(yako::closed_loop::catalogue);
    print(yako::open_loop::catalogue);
    print(c630s::catalogue);
    return 0;
}
