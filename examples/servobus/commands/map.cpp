// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus map: a drive's registers as CSV.
#include "../tool.hpp"

#include <cstdio>

#include <servobus/registers/format.hpp>

namespace tool {
namespace {

// The worth of one count without needless zeros: 1, 0.1, 25.
std::string scale_text(servobus::unit u) {
    char room[32];
    servobus::text_writer text{room};
    servobus::put_count(text, 1, u);
    return {room, text.size()};
}

std::string raw_text(std::int64_t value) { return std::to_string(value); }

using servobus::flag;

const char* when(const servobus::entry& e) {
    if (has(e.flags, flag::when_stopped)) return "stopped";
    return has(e.flags, flag::when_running) ? "running" : "";
}

const char* effective(const servobus::entry& e) {
    if (has(e.flags, flag::immediate)) return "immediate";
    if (has(e.flags, flag::at_stop)) return "at_stop";
    return has(e.flags, flag::after_power_cycle) ? "power_cycle" : "";
}

std::string modes(const servobus::entry& e) {
    if (has(e.flags, flag::every_mode)) return "ALL";
    std::string letters;
    if (has(e.flags, flag::position_mode)) letters += 'P';
    if (has(e.flags, flag::speed_mode)) letters += 'S';
    if (has(e.flags, flag::torque_mode)) letters += 'T';
    return letters;
}

void print_row(const servobus::entry& e) {
    const bool is_saved = has(e.flags, flag::saved) || has(e.flags, flag::saved_on_write);
    const std::string row = hex_word(e.address) + ',' + static_cast<const char*>(e.name) + ',' +
                            std::to_string(e.words()) + ',' + text(e.kind) + ',' + text(e.rights) + ',' +
                            (is_saved ? "yes" : "no") + ',' + when(e) + ',' + effective(e) + ',' + modes(e) +
                            ',' + (e.limits.is_stated ? raw_text(e.limits.low) : "") + ',' +
                            (e.limits.is_stated ? raw_text(e.limits.high) : "") + ',' +
                            (e.initial != servobus::no_default ? raw_text(e.initial) : "") + ',' +
                            scale_text(e.unit_of_count) + ',' + symbol(e.unit_of_count.of);
    (void)std::puts(row.c_str());
}

} // namespace

int map(const arguments& asked) {
    if (asked.words().size() != 1) return complain(usage, "map takes one DEVICE");
    const device* of = find_device(asked.words()[0]);
    if (of == nullptr) return usage;
    (void)std::puts("address,name,words,type,access,saved,when,effective,modes,min,max,default,scale,unit");
    for (const servobus::entry& e : of->map->entries) print_row(e);
    return done;
}

} // namespace tool
