// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The entries of a plan: drives with a facade, rows that are read again and again, the program's own requests,
// and when a node counts as absent. bus/plan.hpp includes it.
//
//     constexpr auto wheels_entry = controlled(
//         wheels_node, {.feedback = milliseconds(20), .command_timeout = milliseconds(300)});
//     constexpr auto voltage_entry = cyclic<zlac8015d::bus_voltage>(wheels_node, milliseconds(200));
//     constexpr auto own_entry = own_requests(wheels_node, milliseconds(500), 4); // of the program, 4 words at most
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/client/node.hpp>
#include <servobus/control/image.hpp>
#include <servobus/control/supervised_node.hpp>
#include <servobus/control/supervision.hpp>
#include <servobus/registers/block.hpp>

namespace servobus {

/// A clock wraps after 71 minutes, and instants more than half of that apart have no order.
inline constexpr duration longest_period = milliseconds(1'800'000);

namespace detail {
// Not constexpr on purpose: a plan that calls one does not compile, and the error names the rule.
inline void a_cyclic_read_is_one_frame_of_adjacent_rows_of_a_table() {}
inline void a_cyclic_read_has_a_period_of_half_an_hour_at_most() {}
inline void a_plan_states_the_supervision_itself() {}
inline void requests_have_a_period_of_half_an_hour_at_most() {}
inline void a_request_has_1_to_125_registers() {}
inline void a_node_of_a_plan_has_an_address_that_its_device_can_have() {}
// No part of the template: of a template that cannot be constant g++ says first that it is no constexpr function.
constexpr void check_one_frame(bool is_one_frame) {
    if (!is_one_frame) a_cyclic_read_is_one_frame_of_adjacent_rows_of_a_table();
}
} // namespace detail

/// A cyclic read as the bus sees it: one request to one node.
struct poll {
    std::uint8_t node_address = 0;
    std::uint8_t code = 0x03; ///< 01..04: of the table
    std::uint16_t address = 0;
    std::uint16_t quantity = 0; ///< registers or bits
    std::uint16_t words = 0;    ///< that the bus keeps of it
    duration period{};
    duration keep_alive{}; ///< the node's own watchdog; 0: none
    servobus::word_order word_order = word_order::high_first;
    response_limits limits{};
    bus_gaps gaps{};

    constexpr std::size_t response_size() const {
        return 5u + (code <= 0x02 ? (quantity + 7u) / 8u : 2u * words);
    }
};

namespace detail {
/// Where a cyclic read finds its rows.
struct cyclic_request {
    std::uint8_t code;
    std::uint16_t address;
    std::uint16_t quantity;
    std::uint16_t words; // that hold its data
};
template <const auto&... Rs> consteval cyclic_request request_of() {
    const auto& plan = readings<Rs...>::plan;
    const auto& first = plan.requests[0];
    if constexpr ((needs_table_calls<Rs> || ...))
        return {first.code(), first.address, first.quantity,
                static_cast<std::uint16_t>((first.size() + 1) / 2)};
    else
        return {0x03, first.address, plan.words, plan.words};
}
} // namespace detail

/// A cyclic read of `Rs`, which come in one frame, and so belong to one moment.
template <const auto&... Rs> struct cyclic_read : poll {
    /// The node stops when it gets no request for `time`: the plan must reach it within that.
    constexpr cyclic_read keeps_alive(duration time) const {
        cyclic_read r = *this;
        r.keep_alive = time;
        return r;
    }
};

/// Reads `Rs` of a node every `period`, as well as the line allows; of a controlled drive only while its state is
/// known.
template <const auto&... Rs, device_class Device>
consteval cyclic_read<Rs...> cyclic(const node<Device>& at, duration period) {
    static_assert((belongs_to<typename row_type<Rs>::device, Device> && ...),
                  "this register belongs to another device");
    detail::check_one_frame(readings<Rs...>::is_one_frame);
    if (period == duration{} || period > longest_period)
        detail::a_cyclic_read_has_a_period_of_half_an_hour_at_most();
    if (!at.is_valid()) detail::a_node_of_a_plan_has_an_address_that_its_device_can_have();
    constexpr detail::cyclic_request request = detail::request_of<Rs...>();
    return {{.node_address = at.address,
             .code = request.code,
             .address = request.address,
             .quantity = request.quantity,
             .words = request.words,
             .period = period,
             .word_order = at.word_order,
             .limits = at.limits,
             .gaps = at.gaps}};
}

/// The frames that the facade of a drive sends by itself, and how often.
struct controlled_node : supervised_node {
    duration command_period{}; ///< between commands of the application; 0: not known
    duration keep_alive{};     ///< after it the facade counts the drive's own watchdog as expired; 0: none
    std::uint8_t image_words = 0;
    std::uint8_t slower_words = 0;      ///< in the longest block that is read less often
    std::uint8_t refreshes_between = 0; ///< refreshes of the image for one of a slower block
};

/// A drive with a facade of `Model`.
template <class Model> struct controlled_drive : controlled_node {
    static constexpr bool has_watchdog = Model::watchdog(Model::unknown) != duration{};

    /// The application commands a speed or a torque once a `period`, which counts in the load of the line.
    constexpr controlled_drive commands(duration period) const {
        controlled_drive d = *this;
        d.command_period = period;
        return d;
    }
    /// The time of the drive's own watchdog, if it is not that of the factory.
    constexpr controlled_drive keeps_alive(duration time) const {
        controlled_drive d = *this;
        d.keep_alive = has_watchdog ? at_least(time) : duration{};
        return d;
    }
};

/// A drive that has a facade on the bus. Its feedback is read every `by.feedback`; `by.command_timeout` is stated, or
/// `no_command_timeout` by name. The facade takes limits, gaps and these times from the plan.
template <device_class Device> consteval auto controlled(const node<Device>& at, const supervision& by) {
    static_assert(
        requires(const Device& device) { model_of(device); },
        "a controlled drive needs its header, such as servobus/device/zlac8015d.hpp");
    using model = decltype(model_of(*static_cast<const Device*>(nullptr)));
    if (!at.is_valid()) detail::a_node_of_a_plan_has_an_address_that_its_device_can_have();
    if (by.command_timeout.is_by_plan()) detail::a_plan_states_the_supervision_itself();
    controlled_drive<model> d{};
    d.address = at.address;
    d.limits = at.limits;
    d.gaps = at.gaps;
    d.by = by;
    d.keep_alive = model::watchdog(model::unknown);
    d.image_words = model::blocks.image().words;
    d.slower_words = model::blocks.longest_other();
    d.refreshes_between = model::blocks.images_between();
    return d;
}

/// The program's own requests to a node, which it steps on the line beside the bus, one at a time.
struct requested_node {
    std::uint8_t address = 0;
    std::uint16_t words = 0; ///< the most that a request or a response carries
    duration period{};
    response_limits limits{};
    bus_gaps gaps{};

    constexpr std::size_t longest_request() const { return 9u + 2u * words; }
    constexpr std::size_t longest_response() const { return 5u + 2u * words; }
};

/// The program's own requests to a node, stepped on the line of the bus: at most one every `period` and of at most
/// `words` registers, or 16 bits for each. Function 16h counts as two registers, and 17h as those that it writes, those
/// that it reads, and one more. They count in the plan's times; any other request beside the bus ends with
/// `errc::not_in_plan`, but for stops. A node without a drive or a read in the plan that did not respond three times is
/// asked once every `back_off::retry_every`, 30 s at most.
template <device_class Device>
consteval requested_node own_requests(const node<Device>& to, duration period, std::uint16_t words) {
    if (period == duration{} || period > longest_period)
        detail::requests_have_a_period_of_half_an_hour_at_most();
    if (words == 0 || words > modbus::max_read) detail::a_request_has_1_to_125_registers();
    if (!to.is_valid()) detail::a_node_of_a_plan_has_an_address_that_its_device_can_have();
    return {.address = to.address, .words = words, .period = period, .limits = to.limits, .gaps = to.gaps};
}

/// When a node counts as absent, and how often it is asked then.
struct back_off {
    /// So many failures in a row, and a missed keep-alive: then a cyclic read's node counts as absent.
    std::uint8_t failures = 3;
    duration retry_every =
        milliseconds(1000); ///< for all absent nodes that are read together, and for all absent
                            ///< drives together: it bounds the time that they take from the others
    duration stop_every = milliseconds(100); ///< a stop of a facade that was not confirmed is repeated
};

} // namespace servobus
