// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Clients on a line, a line with local echo and a blocking line, PDUs of all functions, a server, a pseudo-terminal and
// a ring. Their ports are declared but not defined, so that no compiler knows the values. This file is only
// compiled.
#include <array>
#include <cstdint>
#include <span>

#include <servobus/any_device.hpp>
#include <servobus/client/change_address.hpp>
#include <servobus/client/change_baud_rate.hpp>
#include <servobus/client/free_calls.hpp>
#include <servobus/client/identification.hpp>
#include <servobus/client/peer_node.hpp>
#include <servobus/client/scan.hpp>
#include <servobus/device/c630s/registers.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/zlac8015d/registers.hpp>
#include <servobus/line/blocking_line.hpp>
#include <servobus/line/ring.hpp>
#include <servobus/modbus/crc_tables.hpp>
#include <servobus/modbus/functions.hpp>
#include <servobus/modbus/growing_response.hpp>
#include <servobus/modbus/response_lengths.hpp>
#include <servobus/modbus/response_rules.hpp>
#include <servobus/modbus/server.hpp>
#include <servobus/posix/pseudo_terminal.hpp>
#include <servobus/registers/tables.hpp>

using namespace servobus;

struct wire {
    transfer send(bytes);
    bool sent();
    transfer receive(byte_buffer);
    instant now();
    void wait(duration);
};
struct memory {
    std::uint8_t read(std::uint16_t address, std::span<std::uint16_t> to);
    std::uint8_t write(std::uint16_t address, words_view from);
};
errc set_port(std::uint32_t baud);

using plain_line = line<wire>;
using echo_line = line<wire, counters, echoed>;
using tight_line = blocking_line<wire, modbus::timing_at(115200)>;
using strict_line = blocking_line<wire, modbus::timing_at(115200, modbus::timing_mode::strict),
                                  milliseconds(100), modbus::crc_table16>;

errc check_a_response(bytes request, bytes response) {
    modbus::growing_response growing{request};
    if (growing.least_length(response) != response.size()) return errc::truncated_response;
    return modbus::check_response(request, response).error();
}
std::size_t build_requests(byte_buffer out, std::uint16_t address, modbus::bits_view coils) {
    const std::uint16_t values[]{address, 1};
    std::size_t built = modbus::put_read_bits_request(out, modbus::function::read_coils, address, 8);
    built += modbus::put_write_coil_request(out, address, coils[0]);
    built += modbus::put_write_coils_request(out, address, coils);
    built += modbus::put_mask_write_request(out, {address, 1, 2});
    built += modbus::put_read_write_request(out, address, 2, address, values);
    built += modbus::put_return_query_data_request(out, values);
    built += modbus::put_diagnostic_request(out, modbus::diagnostic::bus_messages);
    built += modbus::put_bare_request(out, modbus::function::report_server_id);
    built += modbus::put_fifo_request(out, address);
    return built + modbus::put_identification_request(out, {modbus::identification::basic, 0});
}
std::size_t length_of_identification(modbus::identification_parts& all, bytes response) {
    std::size_t length = 0;
    if (const auto part = all.take(response)) {
        for (const modbus::identification_object object : *part) length += object.value.size();
    }
    return length;
}

template <class Client> errc use_wheels(Client& drive, int wanted) {
    using namespace zlac8015d;
    const auto seen = drive.template read<left_faults, right_faults, left_actual_position,
                                          right_actual_position, left_actual_speed>();
    if (!seen) return seen.error();
    if (const auto one = read<bus_voltage>(drive); !one) return one.error();
    if (const status w = write<left_max_speed>(drive, clamped(wanted)); !w) return w.error();
    if (const status w = drive.template write<left_acceleration_time>(checked(wanted)); !w) return w.error();
    if (const status w = drive.template write_if_different<right_max_speed>(clamped(wanted)); !w)
        return w.error();
    if (const status w = drive.template broadcast<control_word>(control_code::stop); !w) return w.error();
    return drive.template write<left_target_speed, right_target_speed>(checked(raw(wanted)), raw(50)).error();
}
template <class Client> errc use_servo(Client& servo, std::size_t index, int wanted) {
    if (const status f = servo.learn_word_order(); f.error() != errc::ok) return f.error();
    const auto proof = servo.ram_only();
    if (!proof) return proof.error();
    if (const status w = servo.template write<c630s::target_speed>(clamped(wanted), *proof); !w)
        return w.error();
    const status w = servo.template write<c630s::position_segment_speeds>(index, checked(wanted), *proof);
    return w ? servo.template read<c630s::feedback_pulses>().error() : w.error();
}

errc on_line(plain_line& on, int wanted) {
    client drive{on, node<zlac8015d::device>{1}};
    return use_wheels(drive, wanted);
}
errc on_echo(echo_line& on, int wanted) {
    client drive{on, node<zlac8015d::device>{1}};
    return use_wheels(drive, wanted);
}
errc on_blocking_line(tight_line& on, int wanted) {
    client drive{on, node<zlac8015d::device>{1}};
    return use_wheels(drive, wanted);
}
errc on_strict_line(strict_line& on, int wanted) {
    client drive{on, fixed_node<zlac8015d::device, 3>{}};
    return use_wheels(drive, wanted);
}
errc servo_on_line(plain_line& on, std::size_t index, int wanted) {
    client servo{on, node<c630s::device>{5}};
    return use_servo(servo, index, wanted);
}
errc servo_on_blocking_line(tight_line& on, std::size_t index, int wanted) {
    client servo{on, node<c630s::device>{5}};
    return use_servo(servo, index, wanted);
}
errc any_pdu(plain_line& on, bytes pdu, byte_buffer response, slice<u16> words) {
    client stepper{on, node<yako::closed_loop::device>{2}};
    if (const status f = stepper.read_words(7, words); f.error() != errc::ok) return f.error();
    if (const status w = stepper.write_words(7, words); !w) return w.error();
    return stepper.transact(pdu, response).error();
}

namespace tank {
struct device {
    static constexpr profile facts{.name = "tank"};
};
constexpr coil<access::rw, device> valve{3};
constexpr coil<access::rw, device> pump{4};
constexpr discrete_input<device> is_full{0};
constexpr input_reg<i32, device> level{0, full<i32>, no_unit, no_default};
constexpr reg<u16, access::rw, device> options{0, full<u16>, no_unit, 0};
} // namespace tank
using open_line = line<wire, counters, unechoed, modbus::open_lengths>;

template <class Client> errc use_tank(Client& io, int wanted) {
    const auto seen = io.template read<tank::level, tank::valve, tank::is_full>();
    if (!seen) return seen.error();
    if (const auto one = io.template read<tank::pump>(); !one) return one.error();
    if (const status w = io.template write<tank::valve>(wanted > 0); !w) return w.error();
    if (const status w = io.template write<tank::valve, tank::pump>(true, wanted > 1); !w) return w.error();
    if (const status w = io.template change_bits<tank::options, 3>(2); !w) return w.error();
    return io.template write_then_read<rows<tank::options>, tank::options>(checked(wanted)).error();
}
errc tank_on_line(plain_line& on, int wanted) {
    client io{on, node<tank::device>{9}};
    return use_tank(io, wanted);
}
errc tank_on_blocking_line(tight_line& on, int wanted) {
    client io{on, fixed_node<tank::device, 9>{}};
    return use_tank(io, wanted);
}
errc identify(open_line& on, byte_buffer room, std::size_t& length) {
    client io{on, node<tank::device>{9}};
    const auto own = io.transact(hex("41"), room, modbus::length_rule::counted(1));
    if (!own) return own.error();
    const auto add = [&length](const modbus::identification_object& o) { length += o.value.size(); };
    return read_identification(io, modbus::identification::basic, add).error();
}

errc move_drive(plain_line& on, std::uint8_t to) {
    client servo{on, node<c630s::device>{1}};
    return change_address<c630s::node_address>(servo, to).error();
}
errc speed_up(plain_line& on) {
    client drive{on, node<zlac8015d::device>{1}};
    return change_baud_rate<zlac8015d::rs485_baud_rate>(drive, zlac8015d::baud_rate::baud_57600,
                                                        {115200, 57600}, set_port)
        .error();
}
bool is_there(plain_line& on, std::uint8_t node_address) {
    return look_for(on, node_address, {}).what == presence::present;
}

bytes serve(modbus::server<memory>& of, bytes arrived, instant now) {
    of.feed(arrived, now);
    of.elapse(now);
    const bytes response = of.response(now);
    if (!response.empty()) of.sent(now);
    return response;
}
bool serve_on(posix::pseudo_terminal& port, const char* link, modbus::server<memory>& of, byte_buffer room) {
    if (!port.is_open() && port.open(link) != errc::ok) return false;
    port.wait(milliseconds(5));
    const transfer came = port.receive(room);
    return came && port.send(serve(of, room.first(*came), port.now())) && port.sent();
}
std::size_t through(ring<256>& r, std::uint8_t byte, byte_buffer to) { return r.push(byte) ? r.pop(to) : 0; }
