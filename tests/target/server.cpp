// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A server of the rows of examples/own_device/hoist.hpp: ten holding registers, two of them of 32 bits, four coils and
// two input registers. NOTHING: the same program without the library.
#include "board.hpp"

#ifdef NOTHING

extern "C" bool job() {
    static constexpr std::uint8_t nothing[1]{};
    (void)clock_us();
    return uart_receive() >= 0 || !uart_sent() || uart_send(nothing, 0) == 0;
}

#else

#include <examples/own_device/hoist.hpp>
#include <servobus/modbus/crc_tables.hpp>
#include <servobus/server/row_server.hpp>

namespace {

using namespace servobus;
#ifdef ONLY_HOLDING
using rows = row_values<hoist::operating_mode, hoist::speed, hoist::ramp, hoist::target, hoist::current_limit,
                        hoist::options, hoist::status_word, hoist::position, hoist::load, hoist::fault>;
#else
using rows =
    row_values<hoist::operating_mode, hoist::speed, hoist::ramp, hoist::target, hoist::current_limit,
               hoist::options, hoist::status_word, hoist::position, hoist::load, hoist::fault,
               hoist::temperature, hoist::voltage, hoist::pump, hoist::fan, hoist::lamp, hoist::horn>;
#endif
constexpr auto timing = modbus::timing_at(115200, modbus::timing_mode::strict);
inline constexpr identity about[]{{0, "Hoists"}, {1, "H-10"}, {2, "V1.0"}};

struct hooks {
    static inline bool is_new = false;
    static std::uint8_t before_write(const changes<rows>& c) {
        return c.is_written<hoist::operating_mode>() && c.get<hoist::fault>() != 0 ? 4 : 0;
    }
    static void after_write(const changes<rows>& c) { is_new = is_new || c.is_written<hoist::target>(); }
};

#ifndef OPTIONS
#define OPTIONS
#endif
uart port_1;
constinit rows values;
#ifdef HOOKS
hooks own;
constinit row_server<uart, rows, timing, with_hooks<hooks>> server{port_1, values, 1, own};
#else
constinit row_server<uart, rows, timing OPTIONS> server{port_1, values, 1};
#endif

} // namespace

extern "C" bool job() {
    server.step();
    return true;
}

#endif
