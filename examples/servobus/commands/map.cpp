// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus map: a drive's registers as CSV, or one of them in words.
#include <cstdio>

#include "../device_file/map_text.hpp"
#include "../devices/devices.hpp"
#include "../registers/session.hpp"
#include "../streams/messages.hpp"
#include "commands.hpp"
#include "map_register.hpp"

namespace tool {

int map(const arguments& asked) {
    const std::vector<std::string>& words = asked.words();
    if (words.empty() || words.size() > 2)
        return complain(usage, "map takes one DEVICE, and one REG at most");
    const device* of = find_device(words[0]);
    if (of == nullptr) return usage;
    const bool is_long = asked.has("long");
    const bool has_profile = asked.has("profile");
    if (words.size() == 2) {
        if (is_long || has_profile)
            return complain(usage, std::string{is_long ? "--long" : "--profile"} +
                                       " is for the whole map, without REG");
        const std::optional<chosen> one = parse_register({.kind = of}, words[1]);
        if (!one) return usage;
        print_register(*of, *one);
        return done;
    }
    if (has_profile) (void)std::fputs(profile_lines(of->facts()).c_str(), stdout);
    (void)std::puts(map_header(is_long).c_str());
    for (const servobus::table t : all_tables) {
        for (const servobus::entry& e : of->rows_of(t)) {
            const char* const sentence = is_long ? of->sentence(e, t) : nullptr;
            const servobus::entry* const by = of->scaling_row(e);
            const char* const scaled_by = by != nullptr ? static_cast<const char*>(by->name) : nullptr;
            (void)std::puts(map_row(e, of->facts(), sentence, t, scaled_by).c_str());
        }
    }
    return done;
}

} // namespace tool
