// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus map: a drive's registers as CSV, or one of them in words.
#include <cstdio>

#include "../session.hpp"
#include "map_register.hpp"

namespace tool {
namespace {

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

// `sentence`: null if the row has none.
void print_row(const servobus::entry& e, const char* sentence) {
    const bool is_saved = has(e.flags, flag::saved) || has(e.flags, flag::saved_on_write);
    std::string row = hex_word(e.address) + ',' + static_cast<const char*>(e.name) + ',' +
                      std::to_string(e.words()) + ',' + text(e.kind) + ',' + text(e.rights) + ',' +
                      (is_saved ? "yes" : "no") + ',' + when(e) + ',' + effective(e) + ',' + modes(e) + ',' +
                      (e.limits.is_stated ? raw_text(e.limits.low) : "") + ',' +
                      (e.limits.is_stated ? raw_text(e.limits.high) : "") + ',' +
                      (e.initial != servobus::no_default ? raw_text(e.initial) : "") + ',' +
                      scale_text(e.unit_of_count) + ',' + symbol(e.unit_of_count.of);
    if (sentence != nullptr) row += std::string{",\""} + sentence + '"'; // none has a quote
    (void)std::puts(row.c_str());
}

} // namespace

int map(const arguments& asked) {
    const std::vector<std::string>& words = asked.words();
    if (words.empty() || words.size() > 2)
        return complain(usage, "map takes one DEVICE, and one REG at most");
    const device* of = find_device(words[0]);
    if (of == nullptr) return usage;
    const bool is_long = asked.has("long");
    if (words.size() == 2) {
        if (is_long) return complain(usage, "--long is for the whole map, without REG");
        const std::optional<chosen> one = parse_register({.kind = of}, words[1]);
        if (!one) return usage;
        print_register(*of, *one->row);
        return done;
    }
    std::printf("address,name,words,type,access,saved,when,effective,modes,min,max,default,scale,unit%s\n",
                is_long ? ",description" : "");
    for (const servobus::entry& e : of->map->entries)
        print_row(e, is_long ? of->map->sentence(e.address) : nullptr);
    return done;
}

} // namespace tool
