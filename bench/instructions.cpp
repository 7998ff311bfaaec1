// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Repeats one operation of one side, for a count of its instructions from outside:
//
//   instructions SIDE OPERATION TIMES    OPERATION by its number; "none" makes the loop alone
//   instructions list                    the operations, one a line
//   instructions check                   are all sides correct?
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "operations.hpp"

namespace {

const bench::side* const sides[] = {
    &bench::servobus_side,
    &bench::hand_written_side,
    &bench::reading_only_side,
};

void nothing(bench::task&) {}

} // namespace

int main(int argc, char** argv) {
    using namespace std::literals;
    if (argc == 2 && argv[1] == "list"sv) {
        for (const bench::operation& o : bench::operations) std::puts(o.name);
        return 0;
    }
    if (argc == 2 && argv[1] == "check"sv)
        return bench::is_correct(bench::servobus_side) && bench::is_correct(bench::hand_written_side) ? 0 : 1;
    if (argc != 4) return 2;
    for (const bench::side* const s : sides) {
        if (argv[1] != std::string_view{s->name}) continue;
        const auto at = static_cast<std::size_t>(std::atoi(argv[2]));
        if (at >= bench::operations.size()) return 2;
        bench::task t;
        bench::prepare(t, *s, bench::operations[at]);
        void (*volatile run)(bench::task&) = s->*bench::operations[at].run;
        if (run == nullptr) run = nothing;
        void (*const chosen)(bench::task&) = run;
        const long times = std::atol(argv[3]);
        for (long i = 0; i < times; ++i) {
            t.wire->clock += 5000; // us between two operations
            chosen(t);
        }
        return 0;
    }
    return 2;
}
