// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Rows of all four tables, and functions 16h and 17h, where the line or the device is at fault: echoes that fit as
// responses, facts of a node that become stale, calls that are given up, gateways, and random faults.
#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <servobus/any_device.hpp>
#include <servobus/bus/bus.hpp>
#include <servobus/bus/plan.hpp>
#include <servobus/bus/scheduled_line.hpp>
#include <servobus/client/free_calls.hpp>
#include <servobus/line/blocking_line.hpp>

#include <tests/support/line_and_client.hpp>

#include <tests/support/tank.hpp>

namespace table_faults_tests {

using namespace servobus;
using tests::byte_list;
using tests::framed;
using tests::scripted_port;
using tests::sent_frame;
using tests::operator+;

namespace {
constexpr modbus::rtu_timing timing = modbus::timing_at(115200);

// A device that has what can be learned: a word order and an EEPROM switch. Coils have the numbers of both registers.
struct device {
    static constexpr profile facts{.name = "learner",
                                   .word_order = word_order::unknown,
                                   .word_order_register = 0x0019,
                                   .eeprom_switch = 0x0C0D};
};
inline constexpr coil<access::rw, device> coil_19{0x0019};
inline constexpr coil<access::rw, device> coil_c0d{0x0C0D};
inline constexpr coil<access::rw, device> coil_18{0x0018};
inline constexpr coil<access::rw, device> kept_1{0x0018, false, saved_on_write};
inline constexpr coil<access::rw, device> kept_2{0x0019, false, saved_on_write};
inline constexpr discrete_input<device> input{0x0000};
inline constexpr input_reg<u32, device> energy{0x0000, full<u32>, no_unit, no_default};
inline constexpr input_reg<u32, device> power{0x0010, full<u32>, no_unit, no_default};
inline constexpr reg<u16, access::rw, device> order{0x0019, {0, 1}, no_unit, 0};
inline constexpr reg<u16, access::rw, device> light{0x0300, full<u16>, no_unit, 0};
inline constexpr reg<u32, access::rw, device> place{0x0301, full<u32>, no_unit, 0};
inline constexpr reg<u16, access::rw, device> kept{0x0200, full<u16>, no_unit, 0, saved_on_write};
// Function 17h: five registers are read from 0A00h on, and one is written: request and response have 15 bytes, and the
// byte count of the response is the high byte of the address.
inline constexpr reg<u16, access::rw, device> five_1{0x0A00, full<u16>, no_unit, 0};
inline constexpr reg<u16, access::rw, device> five_2{0x0A01, full<u16>, no_unit, 0};
inline constexpr reg<u16, access::rw, device> five_3{0x0A02, full<u16>, no_unit, 0};
inline constexpr reg<u16, access::rw, device> five_4{0x0A03, full<u16>, no_unit, 0};
inline constexpr reg<u16, access::rw, device> five_5{0x0A04, full<u16>, no_unit, 0};
using five = rows<five_1, five_2, five_3, five_4, five_5>;
// 24 coils from 0300h on: a request of 8 bytes, a response of 8 bytes, and its byte count is 3.
template <std::size_t N> inline constexpr coil<access::rw, device> bit{static_cast<u16>(0x0300u + N)};

tests::plain_tables model() {
    tests::plain_tables m;
    for (const unsigned at : {0x18u, 0x19u, 0xC0Du}) m.coils[at] = false;
    for (unsigned at = 0x300; at < 0x318; ++at) m.coils[at] = at % 3 == 0;
    m.discrete_inputs[0] = true;
    for (const unsigned at : {0u, 1u, 0x10u, 0x11u}) m.input_registers[at] = at + 1;
    for (const unsigned at :
         {0x19u, 0x200u, 0x300u, 0x301u, 0x302u, 0xC0Du, 0xA00u, 0xA01u, 0xA02u, 0xA03u, 0xA04u})
        m.holding_registers[at] = 0;
    return m;
}

struct any_line {
    using line = servobus::scheduled_line<tests::waiting_scripted_port>;
    static line on(tests::waiting_scripted_port& port) { return line{port, timing}; }
};
struct small_line {
    using line = blocking_line<tests::waiting_scripted_port, timing>;
    static line on(tests::waiting_scripted_port& port) { return line{port}; }
};

template <class Kind> struct setup {
    tests::waiting_scripted_port port;
    tests::plain_tables tables = model();
    typename Kind::line on = Kind::on(port);
    client<typename Kind::line, device> drive;

    explicit setup(word_order stated = word_order::unknown) : drive{on, node_of(stated)} { answers(); }
    setup(const setup&) = delete;
    void answers() {
        port.device = [this](scripted_port& p, const sent_frame& f) { tables(p, f, 1); };
    }
    void echoes() {
        port.device = [](scripted_port& p, const sent_frame& f) { p.say(0, f.data); };
    }
    template <class Call> void finish(Call& call) {
        for (int i = 0; i < 20'000 && !call.done(); ++i) {
            (void)call.step();
            port.time += 200;
        }
        REQUIRE(call.done());
    }
    static node<device> node_of(word_order stated) {
        node<device> n{1};
        n.word_order = stated;
        return n;
    }
    std::size_t sent_with(std::uint8_t code) const {
        std::size_t n = 0;
        for (const sent_frame& f : port.frames) n += f.data.size() > 1 && f.data[1] == code;
        return n;
    }
};
using line_setup = setup<any_line>;
using test_client = decltype(line_setup::drive);

template <class Client, std::size_t... N> auto read_bits(Client& io, std::index_sequence<N...>) {
    return io.template read<bit<N>...>();
}
template <std::size_t... N> auto stepped_bits(line_setup& s, std::index_sequence<N...>) {
    stepped_read<test_client, bit<N>...> call{s.drive};
    CHECK(call.begin() == errc::ok);
    s.finish(call);
    return call.value();
}
template <std::size_t... N> consteval auto cyclic_bits(std::index_sequence<N...>) {
    return cyclic<bit<N>...>(node<device>{1}, milliseconds(50));
}
constexpr auto bits_entry = cyclic_bits(std::make_index_sequence<24>{});
constexpr poll_plan bits_plan{timing, bits_entry};
constexpr auto two_bytes_entry = cyclic_bits(std::make_index_sequence<11>{});
constexpr poll_plan two_bytes_plan{timing, two_bytes_entry};

// A request has at most 2000 bits, and at most as many registers as the device gives.
namespace parts {
struct device {
    static constexpr profile facts{.name = "small", .max_read = 2};
};
inline constexpr input_reg<u16, device> word_0{0, full<u16>, no_unit, 0};
inline constexpr input_reg<u16, device> word_1{1, full<u16>, no_unit, 0};
inline constexpr input_reg<u16, device> word_2{2, full<u16>, no_unit, 0};
inline constexpr discrete_input<device> bit_0{0};
inline constexpr discrete_input<device> bit_1{1};
inline constexpr discrete_input<device> bit_2{2};
static_assert(readings<word_0, word_1, word_2>::plan.count == 2);
static_assert(readings<word_0, word_1, word_2>::plan.requests[0].quantity == 2);
static_assert(readings<bit_0, bit_1, bit_2>::plan.count == 1);
constexpr auto most = servobus::detail::plan_tables<3>(
    {{table::coils, 0, 1999}, {table::coils, 2000, 1}, {table::coils, 1999, 1}}, 2);
static_assert(most.count == 2 && most.requests[0].quantity == 2000 && !most.overlaps);
static_assert(most.longest_response == 255 && most.bytes == 251 && most.requests[1].offset == 250);
} // namespace parts
} // namespace

#define FAULTS_ON_EACH_LINE any_line, small_line

TEST_CASE_TEMPLATE("G3: an echo that is as long as the response to a read of bits is no value", Kind,
                   FAULTS_ON_EACH_LINE) {
    setup<Kind> r;
    r.echoes();
    const auto all = read_bits(r.drive, std::make_index_sequence<24>{});
    CHECK(all.error() == errc::own_echo);
    CHECK(read_bits(r.drive, std::make_index_sequence<21>{}).error() == errc::own_echo);
    CHECK(!r.on.is_echo_ruled_out());

    setup<Kind> good; // where something else has been received, such a response is one
    const auto seen = read_bits(good.drive, std::make_index_sequence<24>{});
    REQUIRE(seen);
    CHECK((seen->template get<bit<0>>() && seen->template get<bit<9>>() && seen->template get<bit<21>>()));
    CHECK((!seen->template get<bit<1>>() && !seen->template get<bit<8>>() && !seen->template get<bit<23>>()));
    good.port.device = [](scripted_port& p, const sent_frame& f) { p.say(500, f.data); };
    CHECK(read_bits(good.drive, std::make_index_sequence<24>{}));
}

TEST_CASE("G3: the same for a stepped read, and for a bus") {
    line_setup r;
    r.echoes();
    CHECK(stepped_bits(r, std::make_index_sequence<24>{}).error() == errc::own_echo);
    CHECK(!r.on.is_echo_ruled_out());

    bus<bits_plan, any_line::line> all{r.on};
    all.run_for(milliseconds(500));
    CHECK(all.latest<bit<0>>(milliseconds(400)).error() == errc::own_echo);
    r.answers();
    all.run_for(milliseconds(2500));
    CHECK(all.latest<bit<0>>(milliseconds(400)));
}

TEST_CASE("a bus has each bit of a read of several bytes, and judges the padding of the last one") {
    line_setup r;
    bus<two_bytes_plan, any_line::line> all{r.on};
    all.run_for(milliseconds(200));
    const auto seen =
        all.latest<bit<0>, bit<1>, bit<6>, bit<8>, bit<9>, bit<10>>(node<device>{1}, milliseconds(100));
    REQUIRE(seen);
    CHECK((seen->get<bit<0>>() && seen->get<bit<6>>() && seen->get<bit<9>>()));
    CHECK((!seen->get<bit<1>>() && !seen->get<bit<8>>() && !seen->get<bit<10>>()));
    r.port.device = [](scripted_port& p, const sent_frame&) { p.say(500, framed({1, 1, 2, 0x01, 0x08})); };
    all.run_for(milliseconds(200));
    CHECK(all.latest<bit<0>>(milliseconds(100)).error() == errc::unexpected_value);
    r.port.device = [](scripted_port& p, const sent_frame&) { p.say(500, framed({1, 1, 2, 0xFF, 0x04})); };
    all.run_for(milliseconds(200));
    CHECK(all.latest<bit<0>>(milliseconds(100)));
}

TEST_CASE_TEMPLATE("G2: a response to 05 or 0F has the address and the value or quantity of its request",
                   Kind, FAULTS_ON_EACH_LINE) {
    setup<Kind> r;
    CHECK(r.drive.template read<input>());
    const auto answer = [&](const byte_list& body) {
        r.port.device = [body](scripted_port& p, const sent_frame&) { p.say(500, framed(body)); };
    };
    answer({1, 5, 0, 0x18, 0, 0});
    CHECK(r.drive.template write<coil_18>(true).error() == errc::wrong_value);
    answer({1, 5, 0, 0x19, 0xFF, 0});
    CHECK(r.drive.template write<coil_18>(true).error() == errc::wrong_address);
    answer({1, 15, 0, 0x18, 0, 3});
    CHECK(r.drive.template write<coil_18, coil_19>(true, true).error() == errc::wrong_quantity);
    answer({1, 15, 0, 0x19, 0, 2});
    CHECK(r.drive.template write<coil_18, coil_19>(true, true).error() == errc::wrong_address);
    answer({1, 5, 0, 0x18, 0xFF, 0});
    CHECK(r.drive.template write<coil_18, coil_19>(true, true).error() == errc::wrong_function);
}

TEST_CASE_TEMPLATE("a read that fails leaves nothing of its response", Kind, FAULTS_ON_EACH_LINE) {
    setup<Kind> r;
    r.port.device = [](scripted_port& p, const sent_frame&) { p.say(500, framed({1, 1, 1, 0xFF})); };
    const auto bad = r.drive.template read<coil_18, coil_19>();
    CHECK(bad.error() == errc::unexpected_value);
    CHECK((!bad->template get<coil_18>() && !bad->template get<coil_19>()));
    r.port.device = [&](scripted_port& p, const sent_frame& f) {
        if (f.data[1] == 2) r.tables(p, f, 1);
    };
    r.tables.coils[0x18] = true;
    const auto half = r.drive.template read<coil_18, input, light>(); // the coil goes first
    CHECK(half.error() == errc::timeout);
    CHECK((!half->template get<coil_18>() && !half->template get<input>()));
}

TEST_CASE_TEMPLATE("G3: an echo that is as long as the response of function 17h is none", Kind,
                   FAULTS_ON_EACH_LINE) {
    setup<Kind> r;
    r.echoes();
    const auto seen = r.drive.template write_then_read<five, light>(raw(7));
    CHECK(seen.error() == errc::own_echo);
    CHECK(seen.status().was_sent());
    r.answers();
    CHECK(r.drive.template write_then_read<five, light>(raw(7)));
    CHECK(r.tables.holding_registers[0x300] == 7);
}
TEST_CASE("G3: the same for a stepped call of function 17h") {
    line_setup r;
    r.echoes();
    stepped_write_then_read<test_client, five, light> call{r.drive};
    CHECK(call.begin(raw(7)) == errc::ok);
    r.finish(call);
    CHECK(call.value().error() == errc::own_echo);
    CHECK(call.status().was_sent());
}

TEST_CASE_TEMPLATE("G18, G22: a coil with the number of a setting's register is not that setting", Kind,
                   FAULTS_ON_EACH_LINE) {
    setup<Kind> r;
    REQUIRE(r.drive.learn_word_order());
    const auto token = r.drive.ram_only();
    REQUIRE(token);
    CHECK(r.drive.template write<coil_19>(true));
    CHECK(r.drive.template write<coil_c0d>(true));
    CHECK(r.drive.template write<coil_18, coil_19>(true, false));
    CHECK(r.drive.template broadcast<coil_19>(true));
    CHECK(r.drive.template read<energy>());
    CHECK(r.drive.template write<kept>(raw(3), *token));
}

TEST_CASE_TEMPLATE(
    "G18, G22: a write of coils or bits, or a 17h, without a response makes stale what was learned", Kind,
    FAULTS_ON_EACH_LINE) {
    for (int call = 0; call < 5; ++call) {
        CAPTURE(call);
        setup<Kind> r;
        REQUIRE(r.drive.learn_word_order());
        const auto token = r.drive.ram_only();
        REQUIRE(token);
        r.port.frames.clear();
        r.port.device = nullptr;
        status why;
        if (call == 0) why = r.drive.template write<coil_18>(true);
        if (call == 1) why = r.drive.template write<coil_18, coil_19>(true, true);
        if (call == 2) why = r.drive.template change_bits<light, 3>(1);
        if (call == 3) why = r.drive.template write_then_read<rows<light>, light>(raw(1)).status();
        if (call == 4) why = r.drive.template read<input>().status();
        CHECK(why.error() == errc::timeout);
        CHECK(r.port.frames.size() == (call == 4 ? 3 : 1)); // a write is never repeated
        r.answers();
        CHECK(r.drive.template read<energy>().error() == errc::needs_word_order);
        CHECK(r.drive.template write<kept>(raw(3), *token).error() == errc::needs_init);
        CHECK(r.drive.template write_then_read<rows<light>, place>(raw(1)).error() == errc::needs_word_order);
    }
}

TEST_CASE_TEMPLATE("G22: a word order that changes between the parts of a read leaves no value", Kind,
                   FAULTS_ON_EACH_LINE) {
    setup<Kind> r;
    REQUIRE(r.drive.learn_word_order());
    int lost = 0;
    r.port.device = [&](scripted_port& p, const sent_frame& f) {
        if (f.data[3] == 0x10 && lost++ == 0) return; // the second part: one attempt has no response
        r.tables(p, f, 1);
    };
    CHECK(r.drive.template read<energy, power>().error() == errc::needs_word_order);
    CHECK(lost == 2);

    setup<Kind> stated{word_order::high_first}; // which counts again once the learned one is stale
    stated.tables.holding_registers[0x19] = 1;
    REQUIRE(stated.drive.learn_word_order());
    const auto learned = stated.drive.template read<energy, power>();
    REQUIRE(learned);
    CHECK(learned->template get<energy>() == 0x2'0001u);
    CHECK(*stated.drive.template read<power>() == 0x12'0011u);
    lost = 0;
    stated.port.device = [&](scripted_port& p, const sent_frame& f) {
        if (f.data[3] == 0x10 && lost++ == 0) return;
        stated.tables(p, f, 1);
    };
    CHECK(stated.drive.template read<energy, power>().error() == errc::needs_word_order);
    const auto after = stated.drive.template read<energy, power>();
    REQUIRE(after);
    CHECK(after->template get<energy>() == 0x1'0002u);
}

TEST_CASE("G22: the same for a stepped read; and a 17h that waits while the word order becomes stale sends "
          "nothing") {
    line_setup r;
    REQUIRE(r.drive.learn_word_order());
    int lost = 0;
    r.port.device = [&](scripted_port& p, const sent_frame& f) {
        if (f.data[3] == 0x10 && lost++ == 0) return;
        r.tables(p, f, 1);
    };
    stepped_read<test_client, energy, power> read{r.drive};
    CHECK(read.begin() == errc::ok);
    r.finish(read);
    CHECK(read.value().error() == errc::needs_word_order);

    line_setup stated{word_order::high_first};
    stated.tables.holding_registers[0x19] = 1;
    REQUIRE(stated.drive.learn_word_order());
    lost = 0;
    stated.port.device = [&](scripted_port& p, const sent_frame& f) {
        if (f.data[3] == 0x10 && lost++ == 0) return;
        stated.tables(p, f, 1);
    };
    lost = 1;
    stepped_read<test_client, power> one{stated.drive};
    CHECK(one.begin() == errc::ok);
    stated.finish(one);
    CHECK(*one.value() == 0x12'0011u);
    stepped_read<test_client, energy, power> two{stated.drive};
    CHECK(two.begin() == errc::ok);
    stated.finish(two);
    REQUIRE(two.value());
    CHECK(two.value()->get<energy>() == 0x2'0001u);
    lost = 0;
    CHECK(two.begin() == errc::ok);
    stated.finish(two);
    CHECK(two.value().error() == errc::needs_word_order);
    CHECK(two.begin() == errc::ok);
    stated.finish(two);
    REQUIRE(two.value());
    CHECK(two.value()->get<energy>() == 0x1'0002u);

    r.answers();
    REQUIRE(r.drive.learn_word_order());
    r.port.device = nullptr;
    stepped_read<test_client, input> before{r.drive}; // has the line, and gets no response
    CHECK(before.begin() == errc::ok);
    (void)before.step();
    stepped_write_then_read<test_client, rows<place>, place> both{r.drive};
    CHECK(both.begin(raw(5)) == errc::ok);
    for (int i = 0; i < 20'000 && !(before.done() && both.done()); ++i) {
        (void)before.step();
        (void)both.step();
        r.port.time += 200;
    }
    CHECK(before.value().error() == errc::timeout);
    CHECK(both.value().error() == errc::needs_word_order);
    CHECK(!both.status().was_sent());
    CHECK(r.sent_with(0x17) == 0);
}

TEST_CASE_TEMPLATE("G22: function 17h writes and reads in the word order that was learned", Kind,
                   FAULTS_ON_EACH_LINE) {
    setup<Kind> r;
    r.tables.holding_registers[0x19] = 1; // low first
    CHECK(r.drive.template write_then_read<rows<place>, place>(raw(0x1'0002)).error() ==
          errc::needs_word_order);
    REQUIRE(r.drive.learn_word_order());
    const auto seen = r.drive.template write_then_read<rows<place>, place>(raw(0x1'0002));
    REQUIRE(seen);
    CHECK(seen->template get<place>() == 0x1'0002u);
    CHECK((r.tables.holding_registers[0x301] == 2 && r.tables.holding_registers[0x302] == 1));
}
TEST_CASE("G22: the same stepped") {
    line_setup r;
    r.tables.holding_registers[0x19] = 1;
    stepped_write_then_read<test_client, rows<place>, place> both{r.drive};
    CHECK(both.begin(raw(0x1'0002)) == errc::needs_word_order);
    REQUIRE(r.drive.learn_word_order());
    CHECK(both.begin(raw(0x1'0002)) == errc::ok);
    r.finish(both);
    REQUIRE(both.value());
    CHECK(both.value()->get<place>() == 0x1'0002u);
    CHECK((r.tables.holding_registers[0x301] == 2 && r.tables.holding_registers[0x302] == 1));
}

TEST_CASE_TEMPLATE("a coil that the device keeps at each write is stored by name", Kind,
                   FAULTS_ON_EACH_LINE) {
    setup<Kind> r;
    CHECK(r.drive.template read<input>());
    CHECK(r.drive.template store<kept_1>(true));
    CHECK(r.tables.coils[0x18]);
    CHECK(r.drive.template store<kept_1, kept_2>(false, true));
    CHECK((!r.tables.coils[0x18] && r.tables.coils[0x19]));
}
TEST_CASE("the same stepped") {
    line_setup r;
    CHECK(r.drive.read<input>());
    stepped_store<test_client, kept_1> one{r.drive};
    CHECK(one.begin(true) == errc::ok);
    r.finish(one);
    CHECK(r.tables.coils[0x18]);
    stepped_store<test_client, kept_1, kept_2> two{r.drive};
    CHECK(two.begin(false, true) == errc::ok);
    r.finish(two);
    CHECK(two.status());
    CHECK((!r.tables.coils[0x18] && r.tables.coils[0x19]));
}

TEST_CASE_TEMPLATE("each call for rows of all tables has a free twin", Kind, FAULTS_ON_EACH_LINE) {
    setup<Kind> r;
    auto& io = r.drive;
    CHECK(*read<input>(io));
    CHECK(write<coil_18>(io, true));
    CHECK(write<coil_18, coil_19>(io, true, true));
    CHECK(r.tables.coils[0x19]);
    CHECK(store<kept_1>(io, false));
    CHECK(!r.tables.coils[0x18]);
    CHECK(broadcast<coil_18>(io, true));
    CHECK(r.tables.coils[0x18]);
    CHECK(change_bits<light, 0x00F0>(io, 0x0050));
    CHECK(r.tables.holding_registers[0x300] == 0x0050);
    const auto seen = write_then_read<rows<light>, five_1>(io, raw(7));
    REQUIRE(seen);
    CHECK(servobus::get<light>(*seen) == 0x0050);
    const auto both = read<coil_18, input>(io);
    REQUIRE(both);
    CHECK(servobus::get<coil_18>(*both));
}

} // namespace table_faults_tests
