// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Errors of a plan, with their figures. A plan that calls one of these functions does not compile, since printing is no
// constant expression. clang++ shows the function and its arguments, g++ the text and its figures. Nothing is ever
// printed: only the consteval constructor of a plan calls them. clang++ refuses a constexpr function that no argument
// makes a constant, so each function does nothing for 0.
#pragma once

namespace servobus::detail {

constexpr void the_entries_of_this_plan_do_not_fit_on_the_line(unsigned long load_per_mille) {
    if (load_per_mille != 0)
        __builtin_printf(
            "frames take %lu thousandths of the time: make periods longer, or the baud rate higher",
            load_per_mille);
}
constexpr void a_drive_has_one_facade(unsigned long address) {
    if (address != 0) __builtin_printf("two controlled(..) have address %lu", address);
}
constexpr void the_requests_to_a_node_are_one_entry(unsigned long address) {
    if (address != 0) __builtin_printf("two own_requests(..) have address %lu", address);
}
constexpr void the_times_of_this_plan_are_longer_than_its_clock_can_tell(unsigned long address,
                                                                         unsigned long longest_us) {
    if (address != 0)
        __builtin_printf("node %lu may get no request for %lu us: half an hour is the most", address,
                         longest_us);
}
/// The last two arguments mend it, each alone: limits.response and gaps.quarantine of all nodes (0: no time is short
/// enough), or a longer keep-alive of the drive.
constexpr void a_drive_of_this_plan_could_miss_its_keep_alive(unsigned long address,
                                                              unsigned long keep_alive_us,
                                                              unsigned long longest_us,
                                                              unsigned long response_and_quarantine_ms,
                                                              unsigned long longer_keep_alive_ms) {
    if (address != 0)
        __builtin_printf(
            "drive %lu: its keep-alive is %lu us, and it may get no request for %lu us; set "
            "limits.response and gaps.quarantine of all nodes to %lu ms (0: no time is short enough), or "
            "its keeps_alive(..) to %lu ms",
            address, keep_alive_us, longest_us, response_and_quarantine_ms, longer_keep_alive_ms);
}

} // namespace servobus::detail
