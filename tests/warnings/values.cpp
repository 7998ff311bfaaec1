// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Rows of each type of value and each option: read, written, in a plan, in a server, in a catalogue. The port is
// declared but not defined, so that no compiler knows the values. This file is only compiled.
#include <cstdint>

#include <servobus/any_value.hpp>
#include <servobus/bus/bus.hpp>
#include <servobus/bus/scheduled_line.hpp>
#include <servobus/line/blocking_line.hpp>
#include <servobus/registers/device_unit.hpp>
#include <servobus/registers/value_forms.hpp>
#include <servobus/server/host_row_server.hpp>
#include <servobus/server/stored_number.hpp>
#include <servobus/servobus.hpp>

using namespace servobus;
using namespace servobus::units;

struct wire {
    transfer send(bytes);
    bool sent();
    transfer receive(byte_buffer);
    instant now();
};
enum class phase : std::uint32_t { idle, heating };

struct meter {
    static constexpr profile facts{.name = "meter", .writes_blocks_only = block_writes::registers};
};
template <class T> using rw = reg<T, access::rw, meter>;
template <class T> using ro = reg<T, access::ro, meter>;
inline constexpr input_reg<f32, meter> voltage{0x0000, full<f32>, volt, no_default};
inline constexpr input_reg<f64, meter> flow{0x0002, full<f64>, litre_per_minute, no_default};
inline constexpr rw<f32> target{0x0010, {-20, 400}, degree_celsius, 21};
inline constexpr rw<f64> ratio{0x0012, full<f64>, no_unit, no_default};
inline constexpr rw<u64> energy{0x0016, full<u64>, watt_hour, no_default};
inline constexpr rw<i64> balance{0x001A, full<i64>, watt_hour, no_default};
inline constexpr reg_array<input_reg<u64, meter>, 3> totals{{0x0020, full<u64>, no_unit, no_default}, 4};
inline constexpr rw<text_of<4>> name{0x0030, full<text_of<4>>, no_unit, no_default};
inline constexpr rw<with<u16, bits<0, 3>>> selector{0x0040, full<u16>, no_unit, no_default};
inline constexpr rw<with<u16, bits<4, 15>>> level{0x0040, {0, 1000}, percent / 10, no_default};
inline constexpr rw<bcd<2>> date{0x0041, full<bcd<2>>, no_unit, no_default};
inline constexpr rw<sign_magnitude<1>> torque{0x0043, full<sign_magnitude<1>>, percent, no_default};
inline constexpr rw<with<u16, offset<-1000>>> battery{0x0044, {-400, 800}, degree_celsius / 10, no_default};
inline constexpr rw<with<u32, low_word_first>> daily{0x0045, full<u32>, kilowatt_hour, no_default};
inline constexpr rw<phase> now{0x0047, {0, 1}, no_unit, no_default};
inline constexpr ro<with<i16, or_none<-0x8000>>> exponent{0x0049, full<i16>, no_unit, no_default};
inline constexpr ro<with<u64, ten_to<exponent>>> total{0x004A, full<u64>, watt_hour, no_default};
inline constexpr ro<u16> ct{0x004E, {1, 1000}, times, no_default};
inline constexpr ro<with<u16, times_row<ct>>> primary{0x004F, full<u16>, ampere / 1000, no_default};
inline constexpr coil<access::rw, meter> relay{0x0000};

constexpr poll_plan plan{
    modbus::timing_at(9600), cyclic<voltage, flow>(node<meter>{1}, milliseconds(500)),
    cyclic<selector, level, date, torque, battery, daily, now>(node<meter>{1}, milliseconds(500)),
    cyclic<exponent, total>(node<meter>{1}, milliseconds(500))};
inline constexpr entry entries[]{list("target", target), list("name", name), list("level", level),
                                 list("total", total)};
using kept_values = row_values<voltage, target, date, torque, battery, now>;

template <class Client> std::int64_t use(Client& io, double wanted, std::int32_t n, const char* text) {
    std::int64_t sum = 0;
    if (const auto v = io.template read<voltage>()) sum += v->rounded(millivolt).value_or(0);
    if (const auto v = io.template read<flow>()) sum += v->rounded(litre_per_minute).value_or(0);
    if (const auto v = io.template read<totals>(static_cast<std::size_t>(n)))
        sum += static_cast<std::int64_t>(*v);
    if (const auto v = io.template read<total, exponent, primary, ct>()) {
        if (const auto t = v->template get<total>()) sum += t->rounded(kilowatt_hour);
        sum += v->template get<primary>().count();
    }
    const bool is_done =
        io.template write<target>(checked(wanted)) && io.template write<ratio>(clamped(wanted)) &&
        io.template write<energy>(checked(n * watt_hour)) &&
        io.template write<balance>(checked(n * watt_hour)) && io.template write<name>(checked(text)) &&
        io.template change_bits<selector>(checked(n)) &&
        io.template write<date, torque, battery, daily>(checked(n), clamped(n * percent),
                                                        checked(n * degree_celsius), checked(raw(n))) &&
        io.template write<now>(phase::heating) && io.template write<relay>(coil_word{0x5500}) &&
        io.template write_if_different<energy>(checked(n * watt_hour));
    const auto both = io.template write_then_read<rows<name>, energy>(checked(n * watt_hour));
    return is_done && both ? sum : -sum;
}

std::int64_t on_a_line(wire& port, double wanted, std::int32_t n, const char* text) {
    line on{port, modbus::timing_at(9600)};
    client io{on, node<meter>{1}};
    stepped_read<decltype(io), energy> energy_now{io};
    stepped_write<decltype(io), name> rename{io};
    stepped_change_bits<decltype(io), level> change{io};
    (void)energy_now.begin();
    (void)rename.begin(checked(text));
    (void)change.begin(checked(n * percent));
    energy_now.step();
    rename.step();
    change.step();
    return use(io, wanted, n, text);
}
std::int64_t on_a_blocking_line(wire& port, double wanted, std::int32_t n, const char* text) {
    blocking_line<wire, modbus::timing_at(9600)> on{port};
    client io{on, fixed_node<meter, 1>{}};
    return use(io, wanted, n, text);
}
std::int64_t on_a_bus(wire& port) {
    scheduled_line<wire> on{port, modbus::timing_at(9600)};
    bus<plan, scheduled_line<wire>> all{on};
    all.step();
    const auto now_of = all.latest<level>(node<meter>{1}, milliseconds(900));
    return now_of ? now_of->count() : -1;
}
void serve(wire& port, kept_values& held, float measured, std::int32_t n) {
    host_row_server<wire, kept_values> server{port, held, 1, modbus::timing_at(9600)};
    held.set<voltage>(measured);
    held.set<target>(clamped(measured));
    (void)held.set<date>(checked(n));
    server.step();
}
std::size_t listed() { return std::size(entries); }
