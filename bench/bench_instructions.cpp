// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Repeats one operation of one side, so that callgrind can count its instructions:
//
//   instructions check                   checks that the sides are correct
//   instructions operations              prints the names of the operations, one a line
//   instructions SIDE OPERATION TIMES    repeats the operation; status 3 if SIDE does not have it
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "operations.hpp"

namespace {

constexpr const bench::side* sides[] = {
    &bench::servobus_side,
    &bench::hand_written_side,
    &bench::reading_only_side,
    &bench::libmodbus_side,
};

int repeat(const bench::side& who, const bench::operation& what, long times) {
    void (*const run)(bench::task&) = who.*what.run;
    if (run == nullptr) return 3;
    bench::task t;
    bench::prepare(t, who, what);
    bool all = true;
    for (long i = 0; i < times; ++i) {
        t.wire->clock += 5000; // us between two operations
        run(t);
        all = all && t.ok;
    }
    return all ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
    const std::string_view first = argc > 1 ? argv[1] : "";
    if (argc == 2 && first == "check") {
        const bool is_sound = bench::is_correct(bench::servobus_side) &&
                              bench::is_correct(bench::hand_written_side) &&
                              bench::works(bench::libmodbus_side);
        return is_sound ? 0 : 1;
    }
    if (argc == 2 && first == "operations") {
        for (const bench::operation& o : bench::operations) std::puts(o.name);
        return 0;
    }
    if (argc != 4) return 2;
    for (const bench::side* const s : sides) {
        if (first != s->name) continue;
        for (const bench::operation& o : bench::operations) {
            if (std::string_view{argv[2]} == o.name) return repeat(*s, o, std::atol(argv[3]));
        }
    }
    return 2;
}
