// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Arrays of coils, of discrete inputs and of input registers: blocking, stepped and served. The expected requests are
// written out.
#include <doctest/doctest.h>

#include <cstdint>
#include <vector>

#include <servobus/any_device.hpp>
#include <servobus/line/blocking_line.hpp>
#include <servobus/server/changes.hpp>
#include <servobus/server/request_executor.hpp>
#include <servobus/server/row_values.hpp>
#include <tests/support/line_and_client.hpp>

#include <tests/support/plain_tables.hpp>

namespace table_arrays_tests {

using namespace servobus;
using tests::byte_list;
using tests::scripted_port;
using tests::sent_frame;

namespace {
struct device {
    static constexpr profile facts{
        .name = "relays", .max_read = 8, .max_write = 6, .word_order = word_order::low_first};
};
inline constexpr reg_array<coil<access::rw, device>, 10> outputs{{0x0000}, 1};
inline constexpr reg_array<coil<access::wo, device>, 2> resets{{0x0100}, 0x10};
inline constexpr reg_array<discrete_input<device>, 4> inputs{{0x0008}, 2};
inline constexpr reg_array<input_reg<u16, device>, 3> currents{{0x0001, full<u16>, units::milliampere, 0}, 2};
inline constexpr reg_array<input_reg<u32, device>, 2> energies{{0x0010, full<u32>, no_unit, 0}, 4};

static_assert(is_register_array<outputs> && !is_bit<outputs> && is_bit<at<outputs, 3>>);
static_assert(table_of<inputs> == table::discrete_inputs && at<inputs, 3>.address == 0x000E);
static_assert(row_type<outputs>::words == 1 && row_type<energies>::words == 2);

constexpr modbus::rtu_timing timing = modbus::timing_at(115200);

struct on_any_line {
    tests::waiting_scripted_port port;
    line<tests::waiting_scripted_port> on{port, timing};
    client<line<tests::waiting_scripted_port>, device> drive{on, node<device>{1}};
};
struct on_small_line {
    tests::waiting_scripted_port port;
    blocking_line<tests::waiting_scripted_port, timing> on{port};
    client<blocking_line<tests::waiting_scripted_port, timing>, device> drive{on, node<device>{1}};
};

template <class Base> struct setup : Base {
    tests::plain_tables model;
    setup() {
        for (unsigned i = 0; i < 10; ++i) model.coils[i] = false;
        for (unsigned i = 8; i < 15; ++i) model.discrete_inputs[i] = false;
        for (unsigned i = 0; i < 0x20; ++i) model.input_registers[i] = 0;
        model.coils[0x100] = model.coils[0x110] = false;
        model.holding_registers[0] = 0;
        this->port.device = [this](scripted_port& p, const sent_frame& f) { model(p, f, 1); };
        CHECK(this->drive.read_words(0, word)); // rules out an echo
        model.requests.clear();
    }
    std::uint16_t word[1]{};
};
} // namespace

TEST_CASE_TEMPLATE("an element of an array of coils or inputs is read by its index", Kind, on_any_line,
                   on_small_line) {
    setup<Kind> r;
    r.model.coils[9] = r.model.discrete_inputs[14] = true;
    r.model.input_registers[5] = 250;
    r.model.input_registers[0x14] = 2;
    r.model.input_registers[0x15] = 1;
    CHECK(*r.drive.template read<outputs>(9));
    CHECK(!*r.drive.template read<outputs>(0));
    CHECK(*r.drive.template read<inputs>(3));
    CHECK(*r.drive.template read<currents>(2) == 250 * units::milliampere);
    CHECK(*r.drive.template read<energies>(1) == 0x1'0002);
    const std::vector<byte_list> asked{
        {1, 0, 9, 0, 1}, {1, 0, 0, 0, 1}, {2, 0, 14, 0, 1}, {4, 0, 5, 0, 1}, {4, 0, 0x14, 0, 2}};
    CHECK(r.model.requests == asked);
    CHECK(r.drive.template read<outputs>(10).error() == errc::bad_argument);
    CHECK(r.drive.template read<inputs>(4).error() == errc::bad_argument);
    CHECK(r.drive.template read<energies>(2).error() == errc::bad_argument);
    CHECK(r.model.requests.size() == 5);
}

TEST_CASE_TEMPLATE("bits after that of an element are no value", Kind, on_any_line, on_small_line) {
    setup<Kind> r;
    r.port.device = [](scripted_port& p, const sent_frame& f) {
        p.say(500, tests::framed({1, f.data[1], 1, 3}));
    };
    CHECK(r.drive.template read<outputs>(0).error() == errc::unexpected_value);
    CHECK(r.drive.template read<inputs>(0).error() == errc::unexpected_value);
}

TEST_CASE_TEMPLATE("an element that the device refuses has no value", Kind, on_any_line, on_small_line) {
    setup<Kind> r;
    r.port.device = [](scripted_port& p, const sent_frame& f) {
        p.say(500, tests::framed({1, static_cast<std::uint8_t>(f.data[1] | 0x80), 2}));
    };
    CHECK(r.drive.template read<currents>(0).error() == errc::exception);
    CHECK(r.drive.template read<energies>(0).error() == errc::exception);
    CHECK(r.drive.template read<inputs>(0).error() == errc::exception);
}

TEST_CASE_TEMPLATE("an element of an array of coils is written by function 05", Kind, on_any_line,
                   on_small_line) {
    setup<Kind> r;
    CHECK(r.drive.template write<outputs>(9, true));
    CHECK(r.drive.template store<outputs>(2, false));
    CHECK(r.drive.template write<resets>(1, true));
    CHECK(r.drive.template write<outputs>(10, true).error() == errc::bad_argument);
    CHECK(r.drive.template store<outputs>(10, true).error() == errc::bad_argument);
    const std::vector<byte_list> asked{{5, 0, 9, 0xFF, 0}, {5, 0, 2, 0, 0}, {5, 1, 0x10, 0xFF, 0}};
    CHECK(r.model.requests == asked);
    CHECK(r.model.coils[9]);
    CHECK(write<outputs>(r.drive, 3, true));
    CHECK(store<outputs>(r.drive, 4, true));
    CHECK(*read<outputs>(r.drive, 3));
    CHECK(r.model.coils[4]);
}

TEST_CASE_TEMPLATE("elements of arrays are rows: adjacent ones travel in one request", Kind, on_any_line,
                   on_small_line) {
    setup<Kind> r;
    CHECK(r.drive.template write<at<outputs, 0>, at<outputs, 1>, at<outputs, 2>>(true, false, true));
    const auto seen = r.drive.template read<at<outputs, 0>, at<outputs, 1>, at<outputs, 2>, at<inputs, 0>>();
    REQUIRE(seen);
    CHECK(seen->template get<at<outputs, 2>>());
    CHECK(!seen->template get<at<outputs, 1>>());
    const std::vector<byte_list> asked{{0x0F, 0, 0, 0, 3, 1, 5}, {1, 0, 0, 0, 3}, {2, 0, 8, 0, 1}};
    CHECK(r.model.requests == asked);
}

TEST_CASE_TEMPLATE("adjacent coils are broadcast in one frame", Kind, on_any_line, on_small_line) {
    setup<Kind> r;
    const auto before = r.port.frames.size();
    CHECK(r.drive.template broadcast<at<outputs, 8>, at<outputs, 9>>(true, true));
    REQUIRE(r.port.frames.size() == before + 1);
    CHECK(r.port.frames.back().data == tests::framed({0, 0x0F, 0, 8, 0, 2, 1, 3}));
    CHECK(broadcast<at<outputs, 8>, at<outputs, 9>>(r.drive, true, false));
    CHECK(r.port.frames.back().data == tests::framed({0, 0x0F, 0, 8, 0, 2, 1, 1}));
}

namespace {
template <class Call, class Machine> void finish(Call& call, Machine& r) {
    for (int i = 0; i < 20'000 && !call.done(); ++i) {
        (void)call.step();
        r.port.time += 200;
    }
    REQUIRE(call.done());
}
} // namespace

TEST_CASE("elements are read and written without waiting") {
    setup<on_any_line> r;
    using client_type = decltype(r.drive);
    r.model.discrete_inputs[12] = true;
    r.model.input_registers[0x14] = 2;
    r.model.input_registers[0x15] = 1;
    stepped_write<client_type, outputs> write{r.drive};
    CHECK(write.begin(7, true) == errc::ok);
    CHECK(write.begin(6, true) == errc::busy);
    finish(write, r);
    CHECK(write.status());
    CHECK(write.begin(10, true) == errc::bad_argument);
    stepped_read<client_type, inputs> input{r.drive};
    CHECK(input.begin(2) == errc::ok);
    CHECK(input.begin(1) == errc::busy);
    finish(input, r);
    CHECK(*input.value());
    CHECK(input.begin(1) == errc::ok);
    finish(input, r);
    CHECK(!*input.value());
    CHECK(input.begin(4) == errc::bad_argument);
    CHECK(input.value().error() == errc::bad_argument);
    stepped_read<client_type, energies> energy{r.drive};
    CHECK(energy.begin(1) == errc::ok);
    finish(energy, r);
    CHECK(*energy.value() == 0x1'0002);
    const std::vector<byte_list> asked{
        {5, 0, 7, 0xFF, 0}, {2, 0, 12, 0, 1}, {2, 0, 10, 0, 1}, {4, 0, 0x14, 0, 2}};
    CHECK(r.model.requests == asked);
}

namespace {
struct switchable {
    static constexpr profile facts{
        .name = "switchable", .word_order = word_order::unknown, .word_order_register = 0x0007};
};
inline constexpr reg_array<input_reg<u32, switchable>, 2> counts{{0x0010, full<u32>, no_unit, 0}, 2};
} // namespace

TEST_CASE("an element of two words has the word order that was learned") {
    tests::waiting_scripted_port port;
    tests::plain_tables model;
    model.holding_registers[7] = 1;
    model.input_registers = {{0x12, 2}, {0x13, 1}};
    bool loses = false;
    port.device = [&](scripted_port& p, const sent_frame& f) {
        if (!loses) model(p, f, 1);
        loses = false;
    };
    line<tests::waiting_scripted_port> on{port, timing};
    client<line<tests::waiting_scripted_port>, switchable> drive{on, node<switchable>{1}};
    CHECK(drive.read<counts>(1).error() == errc::needs_word_order);
    CHECK(port.frames.empty());
    CHECK(drive.learn_word_order());
    CHECK(*drive.read<counts>(1) == 0x1'0002);
    loses = true; // the device may have restarted with another word order
    CHECK(drive.read<counts>(1).error() == errc::needs_word_order);
    CHECK(drive.learn_word_order());
    stepped_read<decltype(drive), counts> count{drive};
    CHECK(count.begin(1) == errc::ok);
    for (int i = 0; i < 20'000 && !count.done(); ++i) {
        (void)count.step();
        port.time += 200;
    }
    CHECK(*count.value() == 0x1'0002);
}

TEST_CASE("a server has arrays of coils and inputs") {
    using values_type = row_values<outputs, resets, inputs, currents, energies>;
    values_type values;
    request_executor<values_type> server{values};
    const auto ask = [&](const byte_list& pdu) {
        std::uint8_t room[253]{};
        for (std::size_t i = 0; i < pdu.size(); ++i) room[i] = pdu[i];
        const std::size_t size = server.execute(room, pdu.size());
        return byte_list(room, room + size);
    };
    values.set<outputs>(9, true);
    values.set<inputs>(1, true);
    values.set<energies>(1, raw(0x1'0002u));
    CHECK(ask({1, 0, 0, 0, 10}) == byte_list{1, 2, 0, 2});
    CHECK(ask({2, 0, 10, 0, 1}) == byte_list{2, 1, 1});
    CHECK(ask({2, 0, 9, 0, 1}) == byte_list{0x82, 2}); // between two elements
    CHECK(ask({4, 0, 0x14, 0, 2}) == byte_list{4, 4, 0, 2, 0, 1});
    CHECK(ask({0x0F, 0, 0, 0, 9, 2, 0x05, 0x01}) == byte_list{0x0F, 0, 0, 0, 9});
    CHECK(values.get<outputs>(0));
    CHECK(!values.get<outputs>(1));
    CHECK(values.get<outputs>(2));
    CHECK(values.get<outputs>(8));
    CHECK(values.get<outputs>(9));
    CHECK(values.get<inputs>(1));
    CHECK(!values.get<inputs>(0));
    values.set<outputs>(9, false);
    values.set<inputs>(1, false);
    CHECK(ask({1, 0, 9, 0, 1}) == byte_list{1, 1, 0});
    CHECK(ask({2, 0, 10, 0, 1}) == byte_list{2, 1, 0});
}

namespace {
using two_arrays = row_values<outputs, inputs>;
struct one_way_valves { // an output that is on stays on
    std::uint8_t before_write(const changes<two_arrays>& written) {
        const bool turns_off = written.is_written<outputs>(3) && !written.get<outputs>(3);
        return turns_off || written.is_written<inputs>(0) ? 4 : 0;
    }
    void after_write(const changes<two_arrays>&) {}
};
} // namespace

TEST_CASE("a hook sees the elements of an array of coils") {
    two_arrays values;
    one_way_valves hooks;
    request_executor<two_arrays, with_hooks<one_way_valves>> server{values, hooks};
    const auto first_byte = [&](const byte_list& pdu) {
        std::uint8_t room[253]{};
        for (std::size_t i = 0; i < pdu.size(); ++i) room[i] = pdu[i];
        (void)server.execute(room, pdu.size());
        return unsigned{room[0]};
    };
    CHECK(first_byte({0x0F, 0, 2, 0, 2, 1, 2}) == 0x0F);
    CHECK(values.get<outputs>(3));
    CHECK(first_byte({0x0F, 0, 2, 0, 2, 1, 1}) == 0x8F);
    CHECK(!values.get<outputs>(2)); // all or nothing
    CHECK(first_byte({5, 0, 2, 0, 0}) == 5);
}

} // namespace table_arrays_tests
