// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Reads what a device says of itself, function 2Bh/0Eh, in as many parts as it takes. The line has
// `modbus::open_lengths`. Programs include it to find out which device is there.
//
//     const auto print = [](const modbus::identification_object& o) { // 0: vendor, 1: product, 2: revision
//         for (const std::uint8_t letter : o.value) std::putchar(letter);
//     };
//     if (!read_identification(io, modbus::identification::basic, print)) return 1;
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/client/open_responses.hpp>
#include <servobus/client/raw_client.hpp>
#include <servobus/modbus/identification.hpp>

namespace servobus {

/// Calls `take(object)` for each object of a kind, in ascending order, as the parts come. A part without a valid
/// response is asked for again as often as the node says; objects of the parts before it have been taken already.
/// Errors: those of `client::transact` with a rule, and of `modbus::identification_parts::take`. A device whose
/// identification does not end is left after 256 parts at most.
template <class Client, class Take>
constexpr status read_identification(Client& of, modbus::identification kind, Take&& take) {
    modbus::identification_parts parts{kind};
    std::uint8_t room[modbus::max_pdu]{};
    for (std::uint8_t failed = 0; !parts.is_done();) {
        std::uint8_t request[4]{};
        (void)modbus::put_identification_request(request, parts.request());
        const result<bytes> response = of.transact(request, room, modbus::length_rule::of_function());
        if (!response) {
            const auto& node = of.node();
            if (!request_machine::is_worth_a_retry(response.status(), node) || failed++ >= node.read_retries)
                return response.status();
            continue;
        }
        failed = 0;
        const result<modbus::identification_part> part = parts.take(*response);
        if (!part) return part.status();
        for (const modbus::identification_object& object : *part) take(object);
    }
    return status::sent(errc::ok);
}

} // namespace servobus
