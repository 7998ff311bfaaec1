// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Reads and writes of each type of value, blocking and stepped, in both word orders. The model of the device shares
// nothing with the library.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include <tests/support/line_and_client.hpp>

#include <tests/support/every_value.hpp>
#include <tests/support/scripted_port.hpp>

namespace value_tests {

namespace every_value = tests::every_value;
using namespace servobus;
using namespace servobus::units;
using every_value::mode, every_value::phase;

namespace {
constexpr modbus::rtu_timing timing = modbus::timing_at(115200);
using port = tests::waiting_scripted_port;

template <word_order Order, bool Blocks = false, class Wire = line<port>> struct bench {
    static constexpr word_order order = Order;
    using device = every_value::device<Order, Blocks>;
    using rows = every_value::rows<device>;
    using client_type = client<Wire, device>;

    port uart;
    tests::plain_tables model = every_value::model(Order);
    Wire on = [this] {
        if constexpr (Wire::is_small)
            return Wire{uart};
        else
            return Wire{uart, timing};
    }();
    client_type io{on, node<device>{1}};

    bench() {
        model.takes_blocks_only = Blocks;
        uart.device = [this](tests::scripted_port& p, const tests::sent_frame& f) { model(p, f, 1); };
    }
    bench(const bench&) = delete;

    std::vector<unsigned> held(unsigned address, unsigned count) const {
        std::vector<unsigned> words;
        for (unsigned i = 0; i < count; ++i) words.push_back(model.holding_registers.at(address + i));
        return words;
    }
    template <class T> std::vector<unsigned> words(T value) const {
        return every_value::words_of(value, Order);
    }
    std::size_t requests() const { return model.requests.size(); }
    unsigned last_code() const { return model.requests.back().at(0); }
};
using high = bench<word_order::high_first>;
using low = bench<word_order::low_first>;
using high_by_blocks = bench<word_order::high_first, true>;
using small = bench<word_order::low_first, false, blocking_line<port, timing>>;

template <class Call> void finish(Call& call) {
    while (!call.done()) call.step();
}
} // namespace

#define EACH_ORDER high, low, high_by_blocks, small

TEST_CASE_TEMPLATE("each type is read", B, EACH_ORDER) {
    using r = typename B::rows;
    B b;
    CHECK(b.io.template read<r::voltage>()->value() == 230.1f);
    CHECK(*b.io.template read<r::voltage>()->rounded(millivolt) == 230'100);
    CHECK(b.io.template read<r::flow>()->value() == -12.5);
    CHECK(*b.io.template read<r::counter>() == 0xFFFF'FFFF'FFFF'FFFE);
    CHECK(*b.io.template read<r::counters>(2) == 7);
    CHECK(b.io.template read<r::currents>(1)->value() == 1.5f);
    CHECK(b.io.template read<r::target>()->in(part<10>(degree_celsius)) == 215.0f);
    CHECK(b.io.template read<r::ratio>()->value() == 1e-300);
    CHECK(b.io.template read<r::energy>()->count() == 4'294'967'298u);
    CHECK(b.io.template read<r::balance>()->count() == -5);
    CHECK(*b.io.template read<r::name>() == "KPE7B");
    CHECK(*b.io.template read<r::model>() == "HEAT1");
    CHECK(b.io.template read<r::model>()->size() == 5);
    CHECK(*b.io.template read<r::selector>() == 1);
    CHECK(b.io.template read<r::level>()->count() == 100);
    CHECK(b.io.template read<r::inside>()->count() == 21);
    CHECK(b.io.template read<r::outside>()->count() == -5);
    CHECK(**b.io.template read<r::hour>() == 23);
    CHECK(**b.io.template read<r::date>() == 20'261'201);
    CHECK(b.io.template read<r::torque>()->count() == -3);
    CHECK(b.io.template read<r::current>()->count() == -3000);
    CHECK(b.io.template read<r::battery>()->count() == 253);
    CHECK(!*b.io.template read<r::ac_power>());
    CHECK(b.io.template read<r::low_word>()->count() == 0x0001'01D0);
    CHECK(b.io.template read<r::high_word>()->count() == 0x0001'01D0);
    CHECK(b.io.template read<r::swapped>()->value() == 230.1f);
    CHECK(*b.io.template read<r::now>() == phase::heating);
    CHECK(*b.io.template read<r::operation>() == mode::automatic);
}

TEST_CASE_TEMPLATE("a value and the row that scales it come in one request", B, EACH_ORDER) {
    using r = typename B::rows;
    B b;
    const auto now = b.io.template read<r::power, r::total, r::exponent>();
    REQUIRE(now);
    CHECK(b.requests() == 1);
    CHECK(now->template get<r::power>()->rounded(part<1000>(watt)) == 12'340);
    CHECK(now->template get<r::power>()->rounded(watt) == 12);
    CHECK(now->template get<r::total>()->rounded(watt_hour) == 1235);
    const auto current = b.io.template read<r::primary, r::ct_ratio>();
    CHECK(current->template get<r::primary>().count() == 4000);

    // The row that scales may have none too.
    for (const unsigned exponent : {0x8000u, 0xFFFFu}) {
        for (const unsigned ratio : {0u, 3u}) {
            every_value::put(b.model.holding_registers, 0x5C, {exponent, 1234, ratio, 40});
            const auto own =
                b.io.template read<r::own_power, r::own_exponent, r::own_current, r::own_ratio>();
            REQUIRE(own);
            const auto power = own->template get<r::own_power>();
            CHECK(power.has_value() == (exponent == 0xFFFF));
            if (power) CHECK(power->rounded(watt) == 123);
            const auto own_current = own->template get<r::own_current>();
            CHECK(own_current.has_value() == (ratio != 0));
            if (own_current) CHECK(own_current->count() == 120);
        }
    }

    b.model.holding_registers[0x55] = 0x8000; // none
    CHECK(!b.io.template read<r::power, r::exponent>()->template get<r::power>());
    b.model.holding_registers[0x55] = 5;
    for (const unsigned exponent : {0x8000u, 11u, 0xFFF5u, 0x7FFFu}) { // no exponent that a value has
        b.model.holding_registers[0x54] = exponent;
        CHECK(!b.io.template read<r::power, r::exponent>()->template get<r::power>());
    }
    b.model.holding_registers[0x54] = 10;
    CHECK(b.io.template read<r::power, r::exponent>()->template get<r::power>()->rounded(watt) ==
          2'147'483'647);
}

TEST_CASE_TEMPLATE("rows of each type are read in one request", B, EACH_ORDER) {
    using r = typename B::rows;
    B b;
    const auto all = b.io.template read<r::outside, r::selector, r::level, r::inside, r::hour, r::date,
                                        r::torque, r::current, r::battery, r::ac_power, r::low_word,
                                        r::high_word, r::swapped, r::now, r::operation>();
    REQUIRE(all);
    CHECK(b.requests() == 1);
    CHECK(std::remove_cvref_t<decltype(*all)>::is_one_frame);
    CHECK(all->template get<r::selector>() == 1);
    CHECK(all->template get<r::level>().count() == 100);
    CHECK(all->template get<r::inside>().count() == 21);
    CHECK(all->template get<r::outside>().count() == -5);
    CHECK(*all->template get<r::date>() == 20'261'201);
    CHECK(all->template get<r::current>().count() == -3000);
    CHECK(all->template get<r::swapped>().value() == 230.1f);
    CHECK(all->template get<r::low_word>().count() == 0x0001'01D0);
    CHECK(all->template get<r::now>() == phase::heating);
    CHECK(all->template get<r::operation>() == mode::automatic);
    // Pairs alone go the way of integers.
    const auto pairs = b.io.template read<r::target, r::gain>();
    CHECK(pairs->template get<r::target>().value() == 21.5f);
    CHECK(b.requests() == 2);
}

TEST_CASE("wrong digits, and what stands for none, are no values") {
    high b;
    using r = high::rows;
    for (unsigned raw = 0; raw < 0x1'0000; ++raw) {
        b.model.holding_registers[0x42] = raw;
        bool is_number = true;
        unsigned number = 0;
        for (const unsigned at : {12u, 8u, 4u, 0u}) {
            const unsigned digit = raw >> at & 0xF;
            is_number = is_number && digit < 10;
            number = 10 * number + digit;
        }
        if (raw % 256 != 0 && raw % 17 != 0 && raw > 0x300) continue; // enough of them for a line
        const auto hour = b.io.read<r::hour>();
        REQUIRE(hour);
        CHECK(hour->has_value() == is_number);
        if (is_number) CHECK(**hour == number);
    }
    for (const float none : {std::nanf(""), INFINITY, -INFINITY}) {
        every_value::put(b.model.input_registers, 0, b.words(none));
        CHECK(!b.io.read<r::voltage>()->has_value());
        CHECK(!b.io.read<r::voltage>()->rounded(volt));
    }
}

TEST_CASE_TEMPLATE("each type is written", B, EACH_ORDER) {
    using r = typename B::rows;
    B b;
    const unsigned one = b.model.takes_blocks_only ? 0x10 : 0x06;
    CHECK(b.io.template write<r::target>(-19.5f));
    CHECK(b.held(0x10, 2) == b.words(-19.5f));
    CHECK(b.io.template write<r::target>(22 * degree_celsius));
    CHECK(b.held(0x10, 2) == b.words(22.0f));
    CHECK(b.io.template write<r::target>(checked(399.5)));
    CHECK(b.held(0x10, 2) == b.words(399.5f));
    CHECK(b.io.template write<r::target>(clamped(1e300)));
    CHECK(b.held(0x10, 2) == b.words(400.0f));
    CHECK(b.io.template write<r::ratio>(2.5));
    CHECK(b.held(0x14, 4) == b.words(2.5));
    CHECK(b.io.template write<r::energy>(5 * kilowatt_hour));
    CHECK(b.held(0x20, 4) == b.words(std::uint64_t{5000}));
    CHECK(b.io.template write<r::serial_code>(0xFFFF'FFFF'FFFF'FFFFu));
    CHECK(b.held(0x29, 4) == std::vector<unsigned>(4, 0xFFFF));
    CHECK(b.io.template write<r::balance>(-7 * watt_hour));
    CHECK(b.held(0x25, 4) == b.words(std::int64_t{-7}));
    CHECK(b.io.template write<r::name>("SDM120M"));
    CHECK(b.held(0x30, 4) == std::vector<unsigned>{0x5344, 0x4D31, 0x3230, 0x4D00});
    CHECK(b.io.template write<r::name>("AB"));
    CHECK(b.held(0x30, 4) == std::vector<unsigned>{0x4142, 0, 0, 0});
    CHECK(b.io.template write<r::model>("ABC"));
    CHECK(b.held(0x34, 3) == std::vector<unsigned>{0x4241, 0x0043, 0});
    CHECK(b.io.template write<r::hour>(1234));
    CHECK(b.held(0x42, 1) == std::vector<unsigned>{0x1234});
    CHECK(b.last_code() == one);
    CHECK(b.io.template write<r::date>(19'991'231));
    CHECK(b.held(0x43, 2) == b.words(std::uint32_t{0x1999'1231}));
    CHECK(b.io.template write<r::torque>(-100 * percent));
    CHECK(b.held(0x45, 1) == std::vector<unsigned>{0x8064});
    CHECK(b.io.template write<r::current>(-3 * ampere));
    CHECK(b.held(0x46, 2) == b.words(std::uint32_t{0x8000'0BB8}));
    CHECK(b.io.template write<r::battery>(-40 * degree_celsius));
    CHECK(b.held(0x48, 1) == std::vector<unsigned>{600});
    CHECK(b.io.template write<r::low_word>(raw(65'537u)));
    CHECK(b.io.template write<r::high_word>(raw(131'075u)));
    CHECK(b.held(0x4B, 4) == std::vector<unsigned>{1, 1, 2, 3});
    CHECK(b.io.template write<r::swapped>(230.1f));
    CHECK(b.held(0x4F, 2) == (B::order == word_order::low_first ? std::vector<unsigned>{0x9A19, 0x6643}
                                                                : std::vector<unsigned>{0x6643, 0x9A19}));
    CHECK(b.io.template write<r::now>(phase::idle));
    CHECK(b.held(0x51, 2) == b.words(std::uint32_t{1}));
    CHECK(b.last_code() == 0x10);
}

TEST_CASE_TEMPLATE("values of several types are written in one frame", B, EACH_ORDER) {
    using r = typename B::rows;
    B b;
    CHECK(b.io.template write<r::target, r::gain, r::ratio>(21.5f, -1.0f, 0.5));
    CHECK(b.requests() == 1);
    CHECK(b.held(0x10, 2) == b.words(21.5f));
    CHECK(b.held(0x12, 2) == b.words(-1.0f));
    CHECK(b.held(0x14, 4) == b.words(0.5));
    CHECK(b.io.template write<r::energy, r::after_energy, r::balance>(5 * kilowatt_hour, 9, -2 * watt_hour));
    CHECK(b.held(0x20, 4) == b.words(std::uint64_t{5000}));
    CHECK(b.held(0x24, 1) == std::vector<unsigned>{9});
    CHECK(b.held(0x25, 4) == b.words(std::int64_t{-2}));
    // One that cannot be written sends nothing.
    const std::size_t before = b.requests();
    CHECK(b.io.template write<r::target, r::gain>(checked(401.0f), 1.0f).error() == errc::out_of_range);
    CHECK(b.requests() == before);
}

TEST_CASE_TEMPLATE("a write and a read in one transaction take each type", B, EACH_ORDER) {
    using r = typename B::rows;
    B b;
    const auto now =
        b.io.template write_then_read<rows<r::low_word, r::high_word>, r::target, r::gain, r::ratio>(
            21.0f, 2.0f, 3.0);
    REQUIRE(now);
    CHECK(b.held(0x14, 4) == b.words(3.0));
    CHECK(now->template get<r::low_word>().count() == 0x0001'01D0);
    const auto text = b.io.template write_then_read<rows<r::name, r::model>, r::energy>(1 * watt_hour);
    CHECK(text->template get<r::name>() == "KPE7B");
    CHECK(text->template get<r::model>() == "HEAT1");
}

TEST_CASE_TEMPLATE("a part of a register is changed, and the others are not", B, EACH_ORDER) {
    using r = typename B::rows;
    B b;
    CHECK(b.io.template change_bits<r::selector>(14));
    CHECK(b.held(0x40, 1) == std::vector<unsigned>{0x064E});
    CHECK(b.model.requests.front().at(0) == 0x16);
    CHECK(b.io.template change_bits<r::level>(70 * percent));
    CHECK(b.held(0x40, 1) == std::vector<unsigned>{700u * 16 + 14});
    CHECK(b.io.template change_bits<r::operation>(mode::on));
    CHECK(b.held(0x53, 1) == std::vector<unsigned>{0x4001});
    const std::size_t before = b.requests();
    CHECK(b.io.template change_bits<r::selector>(checked(16)).error() == errc::out_of_range);
    CHECK(b.requests() == before);
}

TEST_CASE("values that a row does not have are refused, and nothing is sent") {
    high b;
    using r = high::rows;
    const auto refused = [&](status why, errc how) {
        CHECK(why.error() == how);
        CHECK(!why.was_sent());
    };
    for (const double none : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
        refused(b.io.write<r::target>(checked(none)), errc::out_of_range);
        refused(b.io.write<r::gain>(checked(none)), errc::out_of_range);
        refused(b.io.write<r::ratio>(checked(none)), errc::out_of_range);
    }
    refused(b.io.write<r::gain>(clamped(std::nanf(""))), errc::out_of_range);
    refused(b.io.write<r::gain>(checked(1e39)), errc::out_of_range);
    refused(b.io.write<r::target>(checked(std::nextafter(400.0f, 500.0f))), errc::out_of_range);
    refused(b.io.write<r::energy>(checked(-1 * watt_hour)), errc::out_of_range);
    refused(b.io.write<r::serial_code>(checked(-1)), errc::out_of_range);
    refused(b.io.write<r::name>(checked(static_cast<const char*>("NINE LONG"))), errc::out_of_range);
    refused(b.io.write<r::hour>(checked(10'000)), errc::out_of_range);
    refused(b.io.write<r::torque>(checked(-32'768 * percent)), errc::out_of_range);
    refused(b.io.write<r::battery>(checked(81 * degree_celsius)), errc::out_of_range);
    refused(b.io.write<r::battery>(checked(5 * part<1000>(degree_celsius))), errc::inexact);
    CHECK(b.requests() == 0);
}

TEST_CASE_TEMPLATE("a value is written if the device holds another one", B, EACH_ORDER) {
    using r = typename B::rows;
    B b;
    CHECK(b.io.template write_if_different<r::energy>(raw(4'294'967'298u)));
    CHECK(b.requests() == 1); // the read
    CHECK(b.io.template write_if_different<r::energy>(raw(4'294'967'299u)));
    CHECK(b.requests() == 3);
    CHECK(b.held(0x20, 4) == b.words(std::uint64_t{4'294'967'299}));
    CHECK(b.io.template write_if_different<r::target>(21.5f));
    CHECK(b.requests() == 4);
    CHECK(b.io.template broadcast<r::energy>(1 * watt_hour));
    CHECK(b.held(0x20, 4) == b.words(std::uint64_t{1}));
}

TEST_CASE_TEMPLATE("a coil takes another word than on and off", B, high, low, small) {
    using r = typename B::rows;
    B b;
    b.model.toggle = 0x5500;
    CHECK(b.io.template read<r::relay>());
    CHECK(b.io.template write<r::relay>(coil_word{0x5500}));
    CHECK(b.model.coils.at(0));
    CHECK(b.io.template write<r::relay>(coil_word{0x5500}));
    CHECK(!b.model.coils.at(0));
    CHECK(b.io.template write<r::relay>(coil_word{0x1234}).exception() == 3);
}

TEST_CASE("a device that takes blocks only gets a coil by 0Fh") {
    high_by_blocks b;
    using r = high_by_blocks::rows;
    CHECK(b.io.write<r::relay>(true));
    CHECK(b.last_code() == 0x0F);
    CHECK(b.model.coils.at(0));
    CHECK(b.io.write_word(0x24, 77));
    CHECK(b.last_code() == 0x10);
    stepped_write<high_by_blocks::client_type, r::lamp> lamp{b.io};
    CHECK(lamp.begin(true));
    finish(lamp);
    CHECK(lamp.status());
    CHECK(b.last_code() == 0x0F);
    CHECK(b.model.coils.at(1));
    stepped_write<high_by_blocks::client_type, r::after_energy> one{b.io};
    CHECK(one.begin(5));
    finish(one);
    CHECK(one.status());
    CHECK(b.last_code() == 0x10);
    CHECK(b.held(0x24, 1) == std::vector<unsigned>{5});
}

#define EACH_STEPPED high, low, high_by_blocks

TEST_CASE_TEMPLATE("stepped calls take each type", B, EACH_STEPPED) {
    using r = typename B::rows;
    using io = typename B::client_type;
    B b;
    const auto value_of = [](auto& call) {
        REQUIRE(call.begin());
        finish(call);
        const auto v = call.value();
        REQUIRE(v);
        return *v;
    };
    stepped_read<io, r::energy> energy{b.io};
    CHECK(value_of(energy).count() == 4'294'967'298u);
    stepped_read<io, r::voltage> voltage{b.io};
    CHECK(value_of(voltage).value() == 230.1f);
    stepped_read<io, r::target> target{b.io};
    CHECK(value_of(target).value() == 21.5f);
    stepped_read<io, r::name> name{b.io};
    CHECK(value_of(name) == "KPE7B");
    stepped_read<io, r::selector, r::level, r::energy> several{b.io};
    const auto all = value_of(several);
    CHECK(all.template get<r::level>().count() == 100);
    CHECK(all.template get<r::energy>().count() == 4'294'967'298u);
    stepped_read<io, r::counters> counters{b.io};
    REQUIRE(counters.begin(2));
    finish(counters);
    CHECK(*counters.value() == 7);

    stepped_write<io, r::energy> put{b.io};
    CHECK(put.begin(5 * kilowatt_hour));
    finish(put);
    CHECK(put.status());
    CHECK(b.held(0x20, 4) == b.words(std::uint64_t{5000}));
    stepped_write<io, r::name> rename{b.io};
    CHECK(rename.begin("XY"));
    finish(rename);
    CHECK(b.held(0x30, 2) == std::vector<unsigned>{0x5859, 0});
    stepped_write<io, r::target, r::gain, r::ratio> three{b.io};
    CHECK(three.begin(1.0f, 2.0f, 3.0));
    finish(three);
    CHECK(three.status());
    CHECK(b.held(0x14, 4) == b.words(3.0));
    stepped_write<io, r::hour> hour{b.io};
    CHECK(hour.begin(59));
    finish(hour);
    CHECK(b.held(0x42, 1) == std::vector<unsigned>{0x59});
    stepped_change_bits<io, r::selector> part{b.io};
    CHECK(part.begin(3));
    finish(part);
    CHECK(part.status());
    CHECK(b.held(0x40, 1) == std::vector<unsigned>{0x0643});
    CHECK(part.begin(checked(16)).error() == errc::out_of_range);
    stepped_write_then_read<io, rows<r::name>, r::energy> both{b.io};
    CHECK(both.begin(2 * watt_hour));
    finish(both);
    CHECK(both.value()->template get<r::name>() == "XY");
    CHECK(b.held(0x20, 4) == b.words(std::uint64_t{2}));
}

namespace {
struct switching {
    static constexpr profile facts{.name = "switching",
                                   .word_order = word_order::unknown,
                                   .word_order_register = 0x0019,
                                   .baud = 115200};
};
} // namespace

TEST_CASE("values of a device that can switch its word order wait for it") {
    using r = every_value::rows<switching>;
    port uart;
    tests::plain_tables model = every_value::model(word_order::low_first);
    uart.device = [&](tests::scripted_port& p, const tests::sent_frame& f) { model(p, f, 1); };
    line<port> on{uart, timing};
    client io{on, node<switching>{1}};
    const auto refused = [&](status why) {
        CHECK(why.error() == errc::needs_word_order);
        CHECK(!why.was_sent());
    };
    refused(io.read<r::energy>().status());
    refused(io.read<r::target>().status());
    refused(io.read<r::counters>(0).status());
    refused(io.read<r::swapped>().status());
    refused(io.write<r::energy>(1 * watt_hour));
    refused(io.write<r::target>(1.0f));
    refused(io.write<r::energy, r::after_energy>(1 * watt_hour, 2));
    CHECK(model.requests.empty());
    // Text, parts and rows of an order of their own do not need it.
    CHECK(*io.read<r::name>() == "KPE7B");
    CHECK(io.read<r::low_word, r::high_word>()->get<r::high_word>().count() == 0x0001'01D0);
    CHECK(io.read<r::selector, r::hour>()->get<r::selector>() == 1);
    CHECK(io.write<r::low_word>(raw(3u)));
    model.holding_registers[0x19] = 1;
    CHECK(io.learn_word_order());
    CHECK(io.read<r::energy>()->count() == 4'294'967'298u);
    CHECK(io.write<r::energy>(5 * kilowatt_hour));
    CHECK(model.holding_registers[0x20] == 5000);
    // A lost response makes it stale.
    uart.device = [](tests::scripted_port&, const tests::sent_frame&) {};
    CHECK(!io.read<r::name>());
    uart.device = [&](tests::scripted_port& p, const tests::sent_frame& f) { model(p, f, 1); };
    refused(io.read<r::energy>().status());
}

} // namespace value_tests
