// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a line reports of its frames: counters, or a trace hook for every frame. An observer is part of the
// line's type; the empty one costs nothing. line/line.hpp includes it; programs use it to count or trace
// frames.
//
//     struct trace : unobserved {
//         void on_response(bytes b, status why) { std::printf("%zu %s\n", b.size(), text(why.error())); }
//     };
//     line<my_uart, both<counters, trace>> wire{uart, modbus::timing_at(115200)};
//     std::printf("%u timeouts\n", unsigned{wire.observer().timeouts});
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/result.hpp>

namespace servobus {

/// Sees every frame: `on_request(frame)` as it begins to leave, `on_response(bytes, why)` as a transaction
/// ends, with whatever came and `errc::ok` or the reason; `on_unexpected(bytes)` for bytes outside a
/// transaction.
template <class O>
concept observer = requires(O& o, bytes frame, status why) {
    o.on_request(frame);
    o.on_response(frame, why);
    o.on_unexpected(frame);
};

/// Sees nothing.
struct unobserved {
    constexpr void on_request(bytes) {}
    constexpr void on_response(bytes, status) {}
    constexpr void on_unexpected(bytes) {}
};

/// Counts what happens on a line. The counts wrap.
struct counters {
    std::uint32_t requests = 0;
    std::uint32_t responses = 0; ///< valid ones, exceptions included
    std::uint32_t exceptions = 0;
    std::uint32_t timeouts = 0; ///< no response, or a gateway's exception in place of one
    std::uint32_t crc_errors = 0;
    std::uint32_t malformed = 0; ///< responses that were cut or did not fit their request
    std::uint32_t transport_errors = 0;
    std::uint32_t unexpected_bytes = 0; ///< late, doubled or foreign bytes outside a transaction

    constexpr void on_request(bytes) { ++requests; }
    constexpr void on_unexpected(bytes b) { unexpected_bytes += static_cast<std::uint32_t>(b.size()); }
    constexpr void on_response(bytes, status why) {
        switch (why.error()) {
        case errc::ok: ++responses; break;
        case errc::exception:
        case errc::acknowledged:
            ++responses;
            ++exceptions;
            break;
        case errc::timeout:
        case errc::gateway_exception: ++timeouts; break;
        case errc::bad_crc: ++crc_errors; break;
        case errc::send_failed:
        case errc::partial_send:
        case errc::receive_failed:
        case errc::port_lost:
        case errc::clock_stopped: ++transport_errors; break;
        default: ++malformed;
        }
    }
};

/// Two observers: `both<counters, my_trace>`.
template <observer A, observer B> struct both : A, B {
    constexpr void on_request(bytes b) {
        A::on_request(b);
        B::on_request(b);
    }
    constexpr void on_response(bytes b, status why) {
        A::on_response(b, why);
        B::on_response(b, why);
    }
    constexpr void on_unexpected(bytes b) {
        A::on_unexpected(b);
        B::on_unexpected(b);
    }
};

} // namespace servobus
