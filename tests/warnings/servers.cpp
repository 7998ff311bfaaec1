// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Servers of rows in strict and in host timing, with each option, arrays and computed rows. Their ports are declared
// but not defined, so that no compiler knows the values. This file is only compiled.
#include <cstdint>

#include <servobus/modbus/crc_tables.hpp>
#include <servobus/server/host_row_server.hpp>
#include <servobus/server/row_server.hpp>

#include <examples/own_device/hoist_server.hpp>

using namespace servobus;

struct wire {
    transfer send(bytes);
    bool sent();
    transfer receive(byte_buffer);
    instant now();
};
struct motor {
    reading<hoist::position> position() const;
    u16 current() const;
    void go_to(reading<hoist::target> target);
};
reading<hoist::load> measured_load();

inline constexpr reg_array<hoist::rw<i32>, 8> stops{{0x0100, {0, 100'000}, units::pulse, 0}, 2};
inline constexpr discrete_input<hoist::device> is_open{0x0000};
inline constexpr char id[] = "H-10";

using values = row_values<hoist::target, hoist::speed, hoist::pump, hoist::temperature, stops, is_open,
                          computed<hoist::load, measured_load>>;
constexpr auto strict = modbus::timing_at(19200, modbus::timing_mode::strict);
using small_server = row_server<wire, values, strict>;
using full_server = row_server<wire, values, strict, with_mask_write, with_read_write, with_return_query_data,
                               with_identification<hoist::about>, with_server_id<id>,
                               with_crc<modbus::crc_table16>, with_leading_bytes<4>>;
using host_server = host_row_server<wire, values, with_mask_write, with_read_write, with_return_query_data,
                                    with_identification<hoist::about>, with_server_id<id>>;

void run(hoist::firmware<wire>& device, motor& shaft) { device.step(shaft); }
void run(small_server& server) { server.step(); }
void run(full_server& server) {
    if (!server.is_answering()) server.set_address(9);
    server.step();
}
void run(host_server& server) { server.step(); }

status keep(values& all, i32 measured, std::size_t i) {
    all.set<hoist::temperature>(clamped(measured * units::degree_celsius));
    all.set<is_open>(measured > 0);
    if (all.get<stops>(i).count() != measured) return all.set<stops>(i, checked(raw(measured)));
    set<hoist::speed>(all, 5 * units::r_per_min);
    if (get<hoist::pump>(all)) all.reset();
    return all.set<hoist::target>(checked(raw(measured)));
}
std::size_t answer(values& all, std::uint8_t (&pdu)[253], std::size_t size) {
    return request_executor<values, with_mask_write>{all}.execute(pdu, size);
}
