// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Errors of a plan, with their figures. A plan that calls one of these functions does not compile, since printing is no
// constant expression. clang++ shows the function and its arguments, g++ the text, which so begins with the function's
// name. Nothing is ever printed: only the consteval constructor of a plan calls them. clang++ refuses a constexpr
// function that no argument makes a constant, so each function does nothing for 0.
#pragma once

namespace servobus::detail {

/// The node's frames take the most of the time.
constexpr void the_entries_of_this_plan_do_not_fit_on_the_line(unsigned long load_per_mille,
                                                               unsigned long address,
                                                               unsigned long node_per_mille) {
    if (load_per_mille == 0) return;
    __builtin_printf("the_entries_of_this_plan_do_not_fit_on_the_line: frames take %lu thousandths of the "
                     "time, and those of node %lu alone %lu: a longer period of "
                     "cyclic<..>(..), .feedback or commands(..), or timing_at(..) of a higher baud rate",
                     load_per_mille, address, node_per_mille);
}
constexpr void a_drive_has_one_facade(unsigned long address) {
    if (address == 0) return;
    __builtin_printf(
        "a_drive_has_one_facade: node %lu has two controlled(..): one, or a node of its own for each drive",
        address);
}
constexpr void the_requests_to_a_node_are_one_entry(unsigned long address) {
    if (address == 0) return;
    __builtin_printf("the_requests_to_a_node_are_one_entry: node %lu has two own_requests(..): one, of the "
                     "shorter period and the more words",
                     address);
}
constexpr void the_times_of_this_plan_are_longer_than_its_clock_can_tell(unsigned long address,
                                                                         unsigned long longest_us) {
    if (address == 0) return;
    __builtin_printf("the_times_of_this_plan_are_longer_than_its_clock_can_tell: node %lu may get no request "
                     "for %lu us, and 1800000000 are the most: a shorter period of it, or "
                     "responds_within(node, ..) for the nodes that it waits for",
                     address, longest_us);
}
/// Either of the last two figures mends the plan: the longest time that `responds_within` may grant each node, or the
/// node's watchdog.
constexpr void a_drive_of_this_plan_could_miss_its_keep_alive(unsigned long address,
                                                              unsigned long keep_alive_us,
                                                              unsigned long longest_us,
                                                              unsigned long response_ms,
                                                              unsigned long watchdog_ms) {
    if (address == 0) return;
    __builtin_printf("a_drive_of_this_plan_could_miss_its_keep_alive: node %lu stops after %lu us without a "
                     "request, and there may be none for %lu us: "
                     "responds_within(node, %lu ms at most) for each node (0: no time is short enough), "
                     "or keeps_alive(%lu ms) and that watchdog in the drive",
                     address, keep_alive_us, longest_us, response_ms, watchdog_ms);
}

/// The first rule that a plan breaks, and the figures of its error.
struct plan_fault {
    enum class kind : unsigned char { none, load, two_facades, two_requests, too_long, keep_alive };

    kind rule = kind::none;
    unsigned long figures[5]{};
};

/// Judged first and refused afterwards: g++ prints each call on the way to an error, with all types and values.
constexpr void refuse(const plan_fault& why) {
    const auto& f = why.figures;
    switch (why.rule) {
    case plan_fault::kind::none: return;
    case plan_fault::kind::load: return the_entries_of_this_plan_do_not_fit_on_the_line(f[0], f[1], f[2]);
    case plan_fault::kind::two_facades: return a_drive_has_one_facade(f[0]);
    case plan_fault::kind::two_requests: return the_requests_to_a_node_are_one_entry(f[0]);
    case plan_fault::kind::too_long:
        return the_times_of_this_plan_are_longer_than_its_clock_can_tell(f[0], f[1]);
    case plan_fault::kind::keep_alive:
        return a_drive_of_this_plan_could_miss_its_keep_alive(f[0], f[1], f[2], f[3], f[4]);
    }
}

} // namespace servobus::detail
