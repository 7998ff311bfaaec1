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

bool is_one_bit(unsigned mask) { return mask != 0 && (mask & (mask - 1)) == 0; }

unsigned lowest_bit(unsigned mask) {
    unsigned bit = 0;
    while ((mask >> bit & 1u) == 0) ++bit;
    return bit;
}

// The manuals write command codes and alarms in hexadecimal, everything else as decimal numbers.
bool is_hexadecimal(const entry& e) {
    if (e.is_signed()) return false;
    unsigned highest = 0;
    for (const named_value& v : e.values) highest = v.value > highest ? v.value : highest;
    return highest > (has(e.flags, trigger) ? 0xFu : 0xFFu);
}

void print_value(const entry& e, const named_value& v, bool in_hexadecimal) {
    const unsigned mask = v.mask;
    const unsigned value = v.value;
    if (mask == 0xFFFF && in_hexadecimal) {
        std::printf("\t0x%02X %s", value, v.name);
    } else if (mask == 0xFFFF) {
        std::printf("\t%lld %s", static_cast<long long>(e.number(value)), v.name);
    } else if (is_one_bit(mask) && value == mask) {
        std::printf("\tbit %u %s", lowest_bit(mask), v.name);
    } else {
        std::printf("\tbits 0x%04X = 0x%04X %s", mask, value, v.name);
    }
}

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
        const bool in_hexadecimal = is_hexadecimal(e);
        for (const named_value& v : e.values) print_value(e, v, in_hexadecimal);
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
