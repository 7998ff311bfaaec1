// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Every mend of the wrong programs beside this one, in one program that must compile: it guards the harness.
#include <array>

#include <servobus/any_device.hpp>
#include <servobus/any_value.hpp>
#include <servobus/axis/differential.hpp>
#include <servobus/client/change_address.hpp>
#include <servobus/client/settings_on_one_line.hpp>
#include <servobus/client/stepped_read.hpp>
#include <servobus/client/stepped_write.hpp>
#include <servobus/control/arguments.hpp>
#include <servobus/control/setpoint_loop.hpp>
#include <servobus/control/take_over.hpp>
#include <servobus/device/c630s.hpp>
#include <servobus/device/c630s/registers.hpp>
#include <servobus/device/yako/wiring.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/line/ring.hpp>
#include <servobus/modbus/functions.hpp>
#include <servobus/registers/catalogue.hpp>
#include <servobus/registers/literals.hpp>
#include <servobus/server/host_row_server.hpp>

#include "../../examples/own_device/own_subject.hpp"
#include "basin.hpp"
#include "belts.hpp"
#include "chassis.hpp"
#include "drives.hpp"
#include "gauge.hpp"
#include "meters.hpp"
#include "program.hpp"
#include "served.hpp"

namespace c630s = servobus::c630s;
using servobus::differential;
using namespace servobus::c630s::literals;
#include "stepper.hpp"
#include "switched.hpp"
#include "travel.hpp"

inline constexpr servobus::reg<servobus::u16, servobus::access::wo, zlac::device> kick{
    0x3000, {0, 1}, servobus::no_unit, 0};
inline constexpr servobus::reg<servobus::u16, servobus::access::rw, zlac::device> gain_23{
    0x3000, {1, 100}, servobus::no_unit, 1};
inline constexpr servobus::reg<servobus::i16, servobus::access::rw, zlac::device> gain_24{
    0x3000, {-1, 100}, servobus::no_unit, 0};
inline constexpr servobus::reg<servobus::u16, servobus::access::rw, zlac::device> gain_25{
    0x3000, {1, 100}, servobus::no_unit, 1};
inline constexpr servobus::reg<servobus::u32, servobus::access::rw, zlac::device> gain_26{
    0xFFFE, servobus::full<servobus::u32>, servobus::no_unit, 0};
inline constexpr servobus::reg_array<servobus::reg<servobus::u32, servobus::access::rw, zlac::device>, 8>
    places{{0x3000, servobus::full<servobus::u32>, servobus::no_unit, 0}, 2};
inline constexpr servobus::reg_array<servobus::reg<servobus::u32, servobus::access::rw, zlac::device>, 8>
    ends{{0xFFF0, servobus::full<servobus::u32>, servobus::no_unit, 0}, 2};
struct whole_port {
    servobus::transfer send(servobus::bytes) { return std::uint16_t{0}; }
    bool sent() { return false; }
    servobus::transfer receive(servobus::byte_buffer) { return std::uint16_t{0}; }
    servobus::instant now() { return {}; }
};
static_assert(servobus::port<whole_port>);
inline constexpr servobus::unit grain = units::volt / 65000;
struct talkative {
    static constexpr servobus::profile facts{.name = "talkative", .max_read = 125};
};
inline constexpr servobus::step mode =
    servobus::steps::write<zlac::mode_of_operation>(zlac::operating_mode{3});
inline constexpr servobus::step full =
    servobus::steps::write<zlac::left_target_torque>(servobus::clamped(servobus::raw(99999)));
inline constexpr std::array stops{servobus::steps::write_zero<zlac::left_target_position>()};
inline constexpr servobus::routine steps{stops};
inline constexpr servobus::step zero =
    servobus::steps::write_zero<zlac::left_target_position, zlac::right_target_position>();
inline constexpr servobus::step wait_standstill =
    servobus::steps::expect_zero<zlac::left_target_speed, zlac::right_target_speed>();
inline constexpr servobus::step zero_speed = servobus::steps::write_zero<zlac::left_target_speed>();
inline constexpr servobus::step go_to = servobus::steps::write_arguments<switched::place>();
inline constexpr servobus::step low_bit =
    servobus::steps::expect_bits<zlac::left_actual_position>(0x0000'0001, 1, servobus::errc::busy);
inline constexpr servobus::step awaited = servobus::steps::until_bits<zlac::left_faults>(0x8000, 0, 100);
inline constexpr servobus::step at_zero =
    servobus::steps::expect_zero<zlac::left_target_position>(servobus::errc::busy);
inline constexpr servobus::step cleared =
    servobus::steps::until_bits<zlac::left_actual_position>(0xFFFF'FFFF, 0, 100);
inline constexpr servobus::step near_zero = servobus::steps::until_within<zlac::left_actual_speed>(20, 100);
inline constexpr servobus::step is_slow =
    servobus::steps::expect_within<zlac::left_actual_speed>(20, servobus::errc::busy);
inline constexpr servobus::step stopped =
    servobus::steps::repeatable(servobus::steps::write<travel>(0x1'0000));
inline constexpr servobus::step kicked = servobus::steps::write<kick>(1);
inline constexpr servobus::step look =
    servobus::steps::fetch<servobus::at<places, 0>, servobus::at<places, 1>>();
inline constexpr servobus::step speeds =
    servobus::steps::write_arguments<zlac::left_target_speed, zlac::right_target_speed>(4);
inline constexpr servobus::step feedback =
    servobus::steps::fetch<zlac::left_actual_speed, zlac::right_actual_speed>(14);
inline constexpr servobus::label name = "left_position_at_the_last_stop";
inline constexpr servobus::step stop =
    servobus::steps::repeatable(servobus::steps::write<zlac::control_word>(zlac::control_code::stop));
inline constexpr servobus::step too = servobus::steps::after_a_stop(servobus::steps::repeatable(
    servobus::steps::write_zero<zlac::left_target_torque, zlac::right_target_torque>()));

inline constexpr servobus::step start =
    servobus::steps::write<zlac::control_word>(zlac::control_code::start_both);
inline constexpr servobus::step home = servobus::steps::write_zero<zlac::left_target_position>();
constexpr zlac::prepared_command plan_init() {
    return {.steps = zlac::routines::init, .then = zlac::effect::initialised};
}
static_assert(plan_init().steps.size() != 0);
struct short_model : zlac::model {
    static constexpr servobus::errc admit(const zlac::prepared_command&, servobus::duration) {
        return servobus::errc::ok;
    }
    static constexpr void preempt(const zlac::prepared_command&) {}
    static constexpr servobus::feedback_blocks blocks{servobus::image_of<zlac::status_word>::block};
    static constexpr std::uint8_t fault_at =
        servobus::image_of<zlac::left_faults>::place_of<zlac::left_faults>;
    static constexpr servobus::stop_rules stops{.at_fault = servobus::stop_priority::disable,
                                                .after_restart = false,
                                                .disable_replaces_quick_stop = false};
};
static_assert(servobus::drive_model<short_model> && short_model::fault_at == 0);
enum class effect : std::uint8_t { none, moved, end };
inline constexpr auto kinds = servobus::command_kinds<effect>{}
                                  .of(servobus::command_kind::other, effect::none)
                                  .of(servobus::command_kind::move, effect::moved)
                                  .with_new_origin();
static_assert(kinds.is_complete() && kinds.are_origins_stated());

inline void literals() {
    using namespace servobus::literals;
    (void)(1000_mm);
    (void)(10_mm);
    (void)(652.3125_mm);
    (void)(2147_m);
    (void)(90_degree).rounded(servobus::units::degree);
    (void)zlac::watchdog{servobus::milliseconds(2)};
    (void)zlac::watchdog{some_number() * units::millisecond};
}
struct hooks {
    std::uint8_t before_write(const tank_changes&) { return 0; }
    void after_write(const tank_changes&) {}
};
inline void serve() {
    (void)servobus::row_values<tank::dose, tank::flow>{};
    (void)servobus::row_values<tank::dose>{};
    (void)servobus::row_values<scale::pair_word_order, scale::weight>{};
    (void)servobus::row_values<tank::flow, tank::limit>{};
    (void)servobus::row_values<tank::limit, tank::flow>{};
    tank_values values;
    (void)values.get<tank::flow>();
    (void)values.set<tank::flow>(1000);
    int flow = tank::measured_flow();
    (void)values.set<tank::flow>(servobus::checked(flow));
    (void)values.set<tank::valve>(true);
    (void)servobus::row_values<servobus::computed<tank::flow, tank::measured_flow>>{};
    hooks own;
    (void)servobus::request_executor<tank_values, servobus::with_hooks<hooks>>{values, own};
    (void)servobus::request_executor<tank_values, servobus::with_mask_write>{values};
    silent_port port;
    (void)servobus::host_row_server<silent_port, tank_values>{port, values, 7,
                                                              servobus::modbus::timing_at(9600)};
}

// clang-format off
namespace modbus = servobus::modbus;
constexpr int pdus() {
    std::uint8_t pdu[16]{};
    constexpr std::uint16_t values[]{255, 255};
    constexpr bool coils[]{true, false};
    (void)modbus::put_read_bits_request(pdu, modbus::function::read_coils, 0, 2000);
    (void)modbus::put_read_bits_request(pdu, modbus::function::read_discrete_inputs, 0xFFFF, 1);
    (void)modbus::put_read_bits_request(pdu, modbus::function::read_coils, 0, 8);
    (void)modbus::put_write_coil_request(pdu, 0x00AC, true);
    (void)modbus::put_write_coils_request(pdu, 0xFFFE, coils);
    (void)modbus::put_write_coils_request(pdu, 0, modbus::bits_view{servobus::hex("CD 01"), 10});
    (void)modbus::put_read_write_request(pdu, 3, 6, 14, values);
    (void)modbus::put_read_write_request(pdu, 3, 6, 0xFFFE, values);
    (void)modbus::put_return_query_data_request(pdu, values);
    (void)modbus::put_diagnostic_request(pdu, modbus::diagnostic::bus_messages);
    (void)modbus::put_bare_request(pdu, modbus::function::report_server_id);
    (void)modbus::put_identification_request(pdu, {modbus::identification::regular, 0});
    return pdu[0];
}
static_assert(pdus() == 0x2B);
using namespace servobus;
inline constexpr poll_plan plan_1{modbus::timing_at(9600), controlled(node<zlac::device>{1}, unsupervised),
    cyclic<zlac::status_word>(node<zlac::device>{1}, milliseconds(50))};
constexpr auto quick_node = [] {
    node<zlac::device> n{1};
    n.limits.response = milliseconds(3);
    n.gaps.quarantine = milliseconds(2);
    return n;
}();
constexpr auto slow_node = [] {
    node<zlac::device> n{2};
    n.limits.response = milliseconds(300'000);
    return n;
}();
constexpr supervision supervised{.feedback = milliseconds(100), .command_timeout = milliseconds(500)};
inline constexpr poll_plan plan_4{
    modbus::timing_at(115200, modbus::timing_mode::strict),
    cyclic<zlac::status_word>(quick_node, milliseconds(900)).keeps_alive(milliseconds(1000))};
inline constexpr poll_plan plan_2{modbus::timing_at(115200),
    cyclic<zlac::status_word>(node<zlac::device>{1}, milliseconds(50)).keeps_alive(milliseconds(1000))};
inline constexpr poll_plan plan_3{modbus::timing_at(115200),
    cyclic<zlac::left_actual_speed, zlac::right_actual_speed>(node<zlac::device>{1}, milliseconds(50))};
inline constexpr poll_plan plan_5{modbus::timing_at(115200),
    controlled(node<zlac::device>{1}, {.command_timeout = milliseconds(300)}), controlled(node<zlac::device>{2}, unsupervised)};
inline constexpr poll_plan plan_6{modbus::timing_at(115200),
    cyclic<zlac::status_word>(node<zlac::device>{1}, milliseconds(1'700'000))};
inline constexpr poll_plan plan_7{modbus::timing_at(115200),
    cyclic<zlac::status_word>(node<zlac::device>{1}, milliseconds(1'000'000)),
    cyclic<zlac::status_word>(slow_node, milliseconds(1000))};
inline constexpr poll_plan plan_8{modbus::timing_at(115200),
    controlled(node<zlac::device>{1}, {.feedback = milliseconds(20), .command_timeout = milliseconds(300)})};
inline constexpr poll_plan plan_9{modbus::timing_at(9600),
    controlled(node<zlac::device>{1}, supervised).commands(milliseconds(100))};
inline constexpr poll_plan plan_10{modbus::timing_at(115200),
    controlled(node<zlac::device>{1}, supervised).keeps_alive(milliseconds(5000)),
    controlled(node<zlac::device>{2}, supervised).keeps_alive(milliseconds(5000)),
    controlled(node<zlac::device>{3}, supervised).keeps_alive(milliseconds(5000))};
inline constexpr poll_plan plan_11{modbus::timing_at(115200), cyclic<other::speed>(node<other::device>{1},
    milliseconds(50))};
inline constexpr poll_plan plan_12{modbus::timing_at(115200), controlled(node<zlac::device>{1}, {.command_timeout = milliseconds(300)})};
inline constexpr poll_plan plan_13{modbus::timing_at(115200), controlled(node<zlac::device>{1}, {.command_timeout = milliseconds(300)}),
    own_requests(node<zlac::device>{9}, milliseconds(500), 4)};
inline constexpr poll_plan plan_14{modbus::timing_at(115200), controlled(node<zlac::device>{1}, {.command_timeout = milliseconds(300)}),
    own_requests(node<zlac::device>{9}, milliseconds(500), 125)};
consteval node<zlac::device> quick(std::uint8_t address) {
    return responds_within(node<zlac::device>{address}, milliseconds(53));
}
constexpr supervision supervised_by_default{.feedback = milliseconds(20), .command_timeout = milliseconds(300)};
inline constexpr poll_plan plan_16{modbus::timing_at(115200),
    controlled(quick(1), supervised_by_default), controlled(quick(2), supervised_by_default),
    cyclic<zlac::bus_voltage>(quick(1), milliseconds(200)), cyclic<zlac::bus_voltage>(quick(2), milliseconds(200)),
    cyclic<zlac::status_word>(quick(1), milliseconds(100))};
inline constexpr poll_plan plan_15{modbus::timing_at(115200), controlled(node<zlac::device>{1}, {.command_timeout = milliseconds(300)}),
    own_requests(node<zlac::device>{8}, milliseconds(1'700'000), 2)};
inline constexpr poll_plan plan_17{modbus::timing_at(115200),
    cyclic<basin::valve, basin::pump>(node<basin::device>{9}, milliseconds(50))};
constexpr node<other::device> left_fan{1}, right_fan{2};
inline constexpr poll_plan plan_18{modbus::timing_at(115200), cyclic<other::speed>(left_fan, milliseconds(200)),
    cyclic<other::speed>(right_fan, milliseconds(200))};
inline constexpr poll_plan plan_19{modbus::timing_at(115200),
    cyclic<zlac::left_actual_speed, zlac::right_actual_speed>(node<zlac::device>{1}, milliseconds(50))};
bool has_values(const bus<plan_18, scheduled_line<some_port>>& all) {
    const auto seen = all.latest<other::speed>(left_fan, milliseconds(500));
    return bool{seen};
}
bool has_other_values(const bus<plan_18, scheduled_line<some_port>>& all) {
    const auto seen = all.latest<other::speed>(right_fan, milliseconds(500));
    return bool{seen};
}
bool has_speeds(const bus<plan_19, scheduled_line<some_port>>& all) {
    constexpr node<zlac::device> wheels{1};
    const auto seen = all.latest<zlac::left_actual_speed, zlac::right_actual_speed>(wheels, milliseconds(100));
    return bool{seen};
}
// clang-format on

struct model : zlac::model {
    static constexpr register_block image{zlac::status_word.address, 11};
};
static_assert(sizeof(facade<model, line<some_port>>) != 0);

using one_register = servobus::with<servobus::u16, servobus::bits<0, 3>>;
using by_exponent = servobus::with<servobus::u16, servobus::ten_to<meters::exponent>>;

int main() {
    some_drive drive;
    some_stepper stepper;
    int wanted = some_number();
    constexpr std::array<std::uint16_t, 2> words{1, 2};
    (void)drive.write<kick>(1);
    (void)drive.write<zlac::node_address>(2);
    (void)drive.read<gain_23>();
    (void)drive.read<gain_24>();
    (void)drive.read<gain_25>();
    (void)drive.read<gain_26>();
    (void)drive.write<zlac::left_max_speed>(1000);
    (void)drive.write<zlac::left_max_speed>(1);
    (void)drive.write<zlac::host_timeout>(1000);
    (void)drive.write<zlac::left_max_current>(30 * units::ampere);
    (void)drive.write<zlac::left_max_speed>(100 * units::r_per_min);
    (void)drive.read<zlac::bus_voltage>();
    (void)servobus::stepped_read<decltype(drive), zlac::bus_voltage>{drive}.begin();
    (void)drive.read<zlac::left_actual_speed>();
    (void)drive.write<zlac::left_max_speed>(1);
    (void)drive.write<zlac::left_rated_current>(1500 * units::milliampere);
    (void)drive.write<zlac::left_rated_current>(1500 * units::milliampere);
    (void)drive.write<zlac::left_rated_current>(15 * units::ampere);
    (void)drive.write<zlac::left_max_current>(125 * servobus::part<10>(units::ampere));
    (void)drive.write<zlac::left_target_speed>(raw(100));
    (void)drive.write<zlac::control_word>(zlac::control_code::enable);
    (void)drive.write<zlac::control_word>(zlac::control_code::enable);
    (void)drive.write<zlac::left_max_speed>(checked(wanted));
    (void)drive.write<zlac::left_max_speed>(checked(5));
    (void)drive.write<zlac::left_max_speed>(clamped(5));
    (void)drive.write<zlac::left_acceleration_time>(500);
    (void)drive.write<zlac::host_timeout>(500 * units::millisecond);
    (void)drive.write_word(0x2100, 5);
    constexpr zlac::speed slow{25 * servobus::part<10>(units::r_per_min)};
    (void)slow;
    (void)drive.write<zlac::left_target_speed, zlac::right_target_speed>(raw(0), raw(0));
    (void)drive.write<zlac::left_target_speed, zlac::right_target_speed>(raw(0), raw(0));
    (void)drive.read<zlac::bus_voltage, zlac::status_word>();
    (void)drive.write<zlac::left_max_speed, zlac::right_max_speed>(1, 1);
    (void)drive.read<zlac::bus_voltage, zlac::status_word>();
    (void)drive.read<zlac::bus_voltage, zlac::hall_state>()->get<zlac::hall_state>();
    (void)drive.read<zlac::bus_voltage>()->rounded(units::volt);
    (void)drive.read<zlac::bus_voltage>()->rounded(units::volt);
    constexpr auto request_27 = servobus::modbus::read_frame(1, 0x2000, 125);
    constexpr auto request_28 = servobus::modbus::read_frame(1, 0xFFFF, 1);
    constexpr auto request_29 = servobus::modbus::write_frame(1, 0xFFFE, words);
    constexpr auto frame_30 = servobus::hex("01 06 20 0E 00 08");
    constexpr auto frame_31 = servobus::hex("01 06 20 0E");
    (void)stepper.run(yako::open_loop::home{yako::homing::home_24});
    (void)stepper.run(yako::open_loop::home{yako::homing::home_24});
    (void)stepper.run(yako::set_speed_segment{16, 60 * units::r_per_min});
    (void)stepper.run(servobus::take_over{servobus::disable{}, yako::save{}});
    {
        some_wheels wheels;
        some_servo servo;
        (void)wheels.run(zlac::ramps{800 * units::millisecond, 500 * units::millisecond});
        (void)wheels.run(zlac::watchdog{500 * units::millisecond});
        (void)wheels.run(servobus::enable{});
        (void)wheels.run(zlac::torque{500 * units::milliampere, {}});
        (void)change_address<zlac::node_address>(drive, 9);
        (void)wheels.run(zlac::set<zlac::left_speed_kp>{600});
        (void)stepper.run(yako::set<yako::open_loop::max_current>{3 * units::ampere});
        (void)stepper.run(yako::set_microsteps{2000});
        (void)stepper.run(yako::wire_inputs{.x0 = yako::input_function::home});
        (void)servo.run(c630s::enable_in{c630s::control_mode::speed});
        (void)servo.run(hold{60 * units::r_per_min, servobus::runs_on_without_line{}});
        (void)servo.run(servobus::velocity{30 * units::r_per_min});
        (void)wheels.run(servobus::velocity{30 * units::r_per_min, 30 * units::r_per_min});
        (void)stepper.run(servobus::move_by{400 * units::pulse});
        (void)servobus::move_to{5 * units::micrometre};
        (void)stepper.run(servobus::velocity{60 * units::r_per_min});
        (void)wheels.run(servobus::velocity{30 * units::r_per_min, 40 * units::r_per_min});
        constexpr servobus::limit_travel limits{-500 * units::pulse, 40'000 * units::pulse};
        (void)stepper.run(limits);
        (void)servo.run(c630s::keep<c630s::pulses_per_revolution>{checked(raw(10000))});
        (void)wheels.run(zlac::save{});
        (void)stepper.run(yako::save{});
    }
    constexpr auto shared = servobus::settings_on_one_line<9600>(servobus::node<zlac::device>{1},
                                                                 servobus::node<c630s::device>{2});
    (void)shared;
    constexpr auto formats =
        servobus::settings_on_one_line(servobus::node<gauge>{1}, servobus::node<c630s::device>{2});
    (void)formats;
    servobus::setpoint_loop lift{stepper, servobus::take_over{servobus::disable{}}};
    (void)lift;
    servobus::setpoint_loop homed{stepper, servobus::take_over{servobus::disable{}}, servobus::enable{},
                                  servobus::after_enable{yako::open_loop::home{yako::homing::home_24}}};
    homed.command();
    (void)request_27;
    (void)request_28;
    (void)request_29;
    (void)frame_30;
    (void)frame_31;
    some_port port;
    scheduled_line wire{port, plan_12.timing()};
    zlac::drive wheels{wire, 1, by_plan};
    (void)zlac::drive{wire, 1, {.feedback = milliseconds(20), .command_timeout = milliseconds(300)}};
    constexpr auto on = zlac::enable_in{zlac::operating_mode::velocity};
    (void)on;
    auto all = make_bus<plan_12>(wire, wheels);
    (void)all.step();
    servobus::client servo{wire, servobus::node<c630s::device>{1}};
    servo.node().word_order = servobus::word_order::low_first;
    (void)servo.ram_only();
    (void)servo.read<c630s::position_segment_speeds>(2);
    (void)servo.write<c630s::target_speed>(300, *servo.ram_only());
    servobus::stepped_write<decltype(servo), c630s::target_speed> target{servo};
    (void)target.begin(300, *servo.ram_only());
    (void)servo.write<c630s::position_segment_speeds>(2, 300, *servo.ram_only());
    some_meters meter;
    (void)meter.read<meters::current, meters::exponent>();
    (void)meter.read<meters::current, meters::exponent>()->get<meters::current>();
    (void)meter.change_bits<meters::mode>(3);
    (void)meter.change_bits<meters::mode>(15);
    (void)meter.change_bits<meters::mode_and_level, 0x000F>(3);
    (void)meter.read<meters::mode, meters::level>();
    const servobus::i32 watts = meter.read<meters::power>()->value_or({}).count();
    const servobus::i32 volts = meter.read<meters::voltage>()->rounded(units::volt).value_or(0);
    (void)watts;
    (void)volts;
    (void)meter.write<meters::target>(399.5f);
    (void)meter.write<meters::target>(21.5f);
    (void)meter.write<meters::name>("8 LETTER");
    some_basin io;
    (void)io.write<basin::valve>(true);
    (void)io.write<basin::valve, basin::pump>(true, false);
    (void)io.write<basin::pump>(true);
    (void)io.read<basin::is_full>();
    (void)io.read<basin::level>();
    (void)io.read<basin::lamp>();
    (void)io.change_bits<basin::options, 0x0003>(1);
    (void)io.write_then_read<servobus::rows<basin::options>, basin::ramp>(5);
    (void)io.write<basin::depth>(5);
    (void)io.store<basin::kept>(1);
    (void)io.write<basin::wide>(5u);
    (void)io.store<basin::night_light>(true);
    bool is_open = true;
    (void)io.write<basin::valve>(is_open);
    (void)io.broadcast<basin::valve, basin::pump>(true, false);
    (void)io.store<basin::lamps>(2, true);
    (void)io.write<servobus::at<basin::lamps, 0>, servobus::at<basin::lamps, 1>>(true, false);
    (void)io.read<basin::valve, servobus::at<basin::lamps, 0>, servobus::at<basin::lamps, 1>>();
    (void)io.read<basin::sensors>(2);
    servobus::stepped_read<some_basin, basin::sensors> sensor{io};
    servobus::stepped_change_bits<some_basin, basin::options, 0x0003> bits{io};
    (void)bits.begin(1);
    servobus::stepped_store<some_basin, basin::night_light> light{io};
    (void)light.begin(true);
    servobus::stepped_write_then_read<some_basin, servobus::rows<basin::options>, basin::ramp> both{io};
    (void)both.begin(5);
    (void)servobus::ring<4>{};
    (void)servobus::commands::argument<zlac::left_max_speed>(60 * units::r_per_min);
    (void)servobus::commands::argument<zlac::host_timeout>(60 * units::millisecond);
    constexpr std::uint16_t address = "P0B-07"_p;
    (void)address;
    servobus::sim::conformance<winch::subject> kit{nullptr};
    (void)kit;
    (void)servobus::scale::of(16'384, 652'300);
    (void)servobus::scale::of(16'384, 652'195);
    (void)servobus::diameter(207.6_mm);
    (void)rolling(4.2_m, counts_per_turn{16384});
    (void)rolling(652.3_mm, counts_per_turn{4 * 4096});
    (void)rolling(652.3_mm, counts_per_turn{16384}, gear_ratio{37, 10});
    (void)axle::of({.left = tyre, .right = tyre, .track = 500_mm});
    (void)axle::of({.left = rolling(652.3_mm, counts_per_turn{4}), .right = tyre, .track = 500_mm});
    (void)differential::of({.left = tyre, .right = tyre, .track = 500_mm});
    servobus::supervision by{.feedback = servobus::milliseconds(20),
                             .command_timeout = servobus::milliseconds(300)};
    (void)by;
    zlac::axes belts{line_of_belts, 1, belt, belt, servobus::unsupervised};
    (void)belts;
    (void)axle::of({.left = rolling(652'301_um, counts_per_turn{1u << 28}), .right = tyre, .track = 500_mm});
}
