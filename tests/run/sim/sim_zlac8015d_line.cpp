// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The virtual line with simulated ZLAC8015Ds and a client on it: wire times, several drives, baud rates,
// planned faults, echoes, broadcasts.
#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include <servobus/client/client.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <tests/support/zlac8015d_bench.hpp>

namespace sim_zlac8015d_line_tests {

using namespace servobus;
using namespace zlac8015d_bench;

// Faults of the line

namespace {
constexpr sim::fault_plan parsed(const char* text) {
    sim::fault_plan plan;
    return sim::parse_faults(text, plan) ? plan : sim::fault_plan{.lost_response = 999};
}
static_assert(parsed("late").late_response != 0 && parsed("late").lost_response == 0);
static_assert(parsed("late,lossy").late_response != 0 && parsed("late,lossy").lost_request != 0);
static_assert(parsed("noisy,doubled").noise_after != 0 && parsed("noisy,doubled").doubled_response != 0);
static_assert(parsed("none").lost_response == 0 && parsed("unplugged").is_unplugged &&
              parsed("cut").cut_response != 0);
static_assert(parsed("").lost_response == 999 && parsed("late,").lost_response == 999 &&
              parsed("lat").lost_response == 999);
static_assert(parsed("later").lost_response == 999 && parsed(",late").lost_response == 999);
} // namespace

TEST_CASE("an unknown fault leaves the plan as it was") {
    sim::fault_plan plan;
    CHECK(!sim::parse_faults("doubled,tripled", plan));
    CHECK(plan.doubled_response == 0);
}

TEST_CASE("a fault source causes faults as often as planned, and the same faults for the same seed") {
    sim::fault_plan plan{.lost_response = 100, .late_response = 500, .doubled_response = 1000};
    sim::fault_source a{42, plan};
    sim::fault_source b{42, plan};
    int lost = 0;
    int late = 0;
    for (int i = 0; i < 10'000; ++i) {
        const sim::fate f = a.decide();
        const sim::fate g = b.decide();
        CHECK((f.is_lost == g.is_lost && f.delay == g.delay && f.seed == g.seed));
        CHECK((f.is_doubled && !f.is_cut && f.noise_before == 0));
        lost += f.is_lost ? 1 : 0;
        late += f.delay == plan.late_by ? 1 : 0;
    }
    CHECK(about(lost, 1000, 150));
    CHECK(about(late, 5000, 250));
}

TEST_CASE("each kind of fault changes a frame as planned") {
    const std::vector<std::uint8_t> frame{1, 2, 3, 4, 5, 6, 7, 8};
    std::array<std::uint8_t, sim::max_spoiled> out{};
    const auto size = [&](const sim::fate& f) { return sim::spoil(f, frame, out); };
    for (std::uint32_t seed = 0; seed < 200; ++seed) {
        CHECK(size({.seed = seed}) == 8);
        CHECK(same_bytes(bytes{out}.first(8), frame));
        CHECK(size({.is_lost = true, .seed = seed}) == 0);
        CHECK(size({.is_cut = true, .seed = seed}) < 8);
        CHECK(size({.noise_before = 2, .noise_after = 3, .seed = seed}) == 13);
        CHECK(same_bytes(bytes{out}.subspan(2, 8), frame));
        CHECK(size({.is_corrupted = true, .seed = seed}) == 8);
        int wrong = 0;
        for (std::size_t i = 0; i < 8; ++i) wrong += out[i] != frame[i] ? 1 : 0;
        CHECK(wrong == 1);
    }
}

// The line

namespace {

static_assert(waiting_port<sim::virtual_line>);
static_assert(port<sim::virtual_line>);

using wire_line = line<sim::virtual_line>;

struct machine {
    sim::zlac8015d drive{};
    sim::station<sim::zlac8015d> station{drive};
    sim::virtual_line wire;
    wire_line on;
    client<wire_line, map::device> wheels;

    explicit machine(const sim::line_settings& settings = {})
        : wire{settings}, on{wire, modbus::timing_at(settings.baud)}, wheels{on, node<map::device>{1}} {
        wire.attach(station);
    }
};

} // namespace

TEST_CASE("the virtual line transfers requests and responses with real wire times") {
    machine m;
    CHECK(m.wheels.read<map::bus_voltage>().value().count() == 2400);
    const std::uint64_t before = m.wire.time_us();
    for (int i = 0; i < 100; ++i) CHECK(m.wheels.read<map::bus_voltage>());
    const std::uint64_t each = (m.wire.time_us() - before) / 100;
    // 8 + 7 characters of 96 us, t3.5 before the request and before the response
    CHECK(each >= 15 * 96 + 2 * 1750);
    CHECK(each <= (15 * 96 + 2 * 1750) * 101 / 100);
    CHECK(m.wire.requests() == 101);
    CHECK(m.wire.responses() == 101);
    CHECK(m.wire.collisions() == 0);
    CHECK(m.station.server().dropped() == 0);
}

TEST_CASE("the clocks of the virtual line and of its drives continue through a wrap") {
    machine m{{.start = instant{0xFFFF'FFFFu - 300'000}}};
    CHECK(m.wheels.write<map::mode_of_operation>(operating_mode::velocity));
    CHECK(m.wheels.write<map::control_word>(control_code::enable));
    CHECK(m.wheels.write<map::left_target_speed>(raw(60)));
    for (int i = 0; i < 100; ++i) {
        CHECK(m.wheels.read<map::left_actual_speed>());
        m.wire.pass(milliseconds(20));
    }
    CHECK(m.wheels.read<map::left_actual_speed>().value().count() == 600);
}

TEST_CASE("the response delay of a device is observed") {
    machine m;
    (void)m.wheels.read<map::bus_voltage>();
    const duration limit = m.wheels.node().limits.response;
    const duration in_time = limit - milliseconds(5);
    m.station.set_response_delay(in_time);
    const std::uint64_t before = m.wire.time_us();
    CHECK(m.wheels.read<map::bus_voltage>());
    CHECK(about(static_cast<std::int64_t>(m.wire.time_us() - before), 1750 + 15 * 96 + in_time.us, 100));
    m.station.set_response_delay(limit + milliseconds(5));
    m.wheels.node().read_retries = 0;
    CHECK(m.wheels.read<map::bus_voltage>().error() == errc::timeout);
}

TEST_CASE("several drives respond at their own addresses over 20 hours of virtual time") {
    std::array<sim::zlac8015d, 3> drives{};
    std::array<sim::station<sim::zlac8015d>, 3> stations{sim::station{drives[0], 1, 115200},
                                                         sim::station{drives[1], 1, 115200},
                                                         sim::station{drives[2], 1, 115200}};
    sim::virtual_line wire{115200};
    wire_line on{wire, modbus::timing_at(115200)};
    for (std::size_t i = 0; i < 3; ++i) {
        const auto node_address = static_cast<std::uint8_t>(10 + i);
        const std::array<std::uint8_t, 2> raw{0, node_address};
        const std::array<std::uint8_t, 2> one{0, 1};
        CHECK(drives[i].write(0x2001, words_view{raw}) == 0);
        CHECK(drives[i].address() == 1); // not before the next power-on
        CHECK(drives[i].write(0x2010, words_view{one}) == 0);
        drives[i].power_cycle();
        CHECK(drives[i].address() == node_address);
        drives[i].set_bus_voltage(static_cast<std::uint16_t>(1000 + i));
        CHECK(wire.attach(stations[i]));
    }
    for (int round = 0; round < 40; ++round) {
        for (std::size_t i = 0; i < 3; ++i) {
            client<wire_line, map::device> c{on, node<map::device>{static_cast<std::uint8_t>(10 + i)}};
            CHECK(c.read<map::bus_voltage>().value().count() == static_cast<int>(1000 + i));
        }
        wire.pass(milliseconds(1'800'000));
    }
    CHECK(wire.time_us() > std::uint64_t{20} * 3'600'000'000);
}

TEST_CASE("a drive with another baud rate gives no valid response until the line has the same rate") {
    machine m;
    CHECK(m.wheels.write<map::rs485_baud_rate>(map::baud_rate::baud_9600));
    CHECK(m.wheels.read<map::bus_voltage>()); // still the old rate
    CHECK(m.wheels.write<map::save_parameters>(map::parameter_save::save_all));
    m.drive.power_cycle();
    CHECK(m.drive.baud() == 9600);
    CHECK(!m.wheels.read<map::bus_voltage>());
    m.wire.set_baud(9600);
    wire_line slow{m.wire, modbus::timing_at(9600)};
    client<wire_line, map::device> c{slow, node<map::device>{1}};
    CHECK(c.read<map::bus_voltage>());
}

TEST_CASE("an unplugged port returns port_lost, a cut wire and an absent device cause a timeout, and all "
          "recover") {
    machine m;
    m.wheels.node().read_retries = 0;
    CHECK(m.wheels.read<map::bus_voltage>());
    m.wire.unplug();
    CHECK(m.wheels.read<map::bus_voltage>().error() == errc::port_lost);
    m.wire.plug();
    CHECK(m.wheels.read<map::bus_voltage>());
    m.wire.cut_for(milliseconds(50));
    CHECK(m.wheels.read<map::bus_voltage>().error() == errc::timeout);
    CHECK(m.wheels.read<map::bus_voltage>());
    m.wire.set_connected(0, false);
    CHECK(m.wheels.read<map::bus_voltage>().error() == errc::timeout);
    m.drive.power_cycle();
    m.wire.set_connected(0, true);
    CHECK(m.wheels.read<map::bus_voltage>());
    m.wire.faults().is_unplugged = true;
    CHECK(m.wheels.read<map::bus_voltage>().error() == errc::timeout);
}

TEST_CASE("two devices with one address garble each other's responses") {
    machine m;
    sim::zlac8015d twin;
    sim::station other{twin};
    m.wire.attach(other);
    m.wheels.node().read_retries = 0;
    CHECK(!m.wheels.read<map::bus_voltage>());
    CHECK(m.wire.collisions() > 0);
    other.set_response_delay(milliseconds(2)); // the second begins in the middle of the first
    const std::uint32_t before = m.wire.collisions();
    CHECK(!m.wheels.read<map::status_word>());
    CHECK(m.wire.collisions() > before);
}

TEST_CASE("each planned fault has its effect at the client, and never a wrong value") {
    // A response that begins after limit and quarantine may be taken for the one to the next request (G2).
    const node<map::device> at{1};
    const duration latest = at.limits.response + at.gaps.quarantine - milliseconds(2);
    for (const char* names : {"late", "lossy", "noisy", "doubled", "cut", "late,lossy,noisy,doubled,cut"}) {
        CAPTURE(std::string{names});
        unsigned struck = 0;
        for (std::uint64_t seed = 1; seed <= 12; ++seed) {
            CAPTURE(seed);
            machine m{{.seed = seed}};
            m.wheels.node().read_retries = 0;
            sim::fault_plan plan;
            CHECK(sim::parse_faults(names, plan));
            const duration past_limit = latest - at.limits.response;
            plan.late_by =
                at.limits.response + duration{past_limit.us / 12 * static_cast<std::uint32_t>(seed)};
            m.wire.faults() = plan;
            int failed = 0;
            for (std::uint16_t i = 0; i < 1000; ++i) {
                m.drive.set_bus_voltage(static_cast<std::uint16_t>(2000 + i));
                const auto got = m.wheels.read<map::bus_voltage>();
                if (!got) {
                    ++failed;
                    continue;
                }
                CHECK(got->count() == 2000 + i);
            }
            CHECK(failed < 400);
            CHECK(m.wire.struck() != 0);
            struck += m.wire.struck();
        }
        CHECK(struck > 12 * 10);
    }
}

TEST_CASE("the same seed gives the same run, byte for byte") {
    const auto run = [](std::uint64_t seed) {
        std::vector<std::uint64_t> log;
        machine m{{.seed = seed}};
        m.wire.set_hook(
            [](void* context, const sim::wire_byte& b) {
                static_cast<std::vector<std::uint64_t>*>(context)->push_back(
                    b.at_us << 9 | std::uint64_t{b.value} << 1 | (b.is_from_client ? 1u : 0u));
            },
            &log);
        sim::parse_faults("late,lossy,noisy,doubled,cut", m.wire.faults());
        for (int i = 0; i < 200; ++i) (void)m.wheels.read<map::left_actual_position>();
        CHECK(m.wire.struck() > 10);
        return log;
    };
    const auto first = run(7);
    CHECK(first.size() > 2000);
    CHECK(run(7) == first);
    CHECK(run(8) != first);
}

TEST_CASE("the client receives an echo while it sends, and a delayed echo later") {
    for (const std::uint32_t delay : {0u, 250u}) {
        machine m{{.echoes = true, .echo_delay = microseconds(delay)}};
        const std::array<std::uint8_t, 5> out{1, 2, 3, 4, 5};
        CHECK(*m.wire.send(out) == 5);
        m.wire.pass(microseconds(96 * 4));
        std::array<std::uint8_t, 8> in{};
        CHECK(*m.wire.receive(in) == (delay == 0 ? 4 : 1));
        while (!m.wire.sent()) {}
        CHECK(*m.wire.receive(in) == 0); // the port has emptied its receiver
        m.wire.pass(milliseconds(1));
        CHECK(*m.wire.receive(in) == (delay == 0 ? 0 : 3));
        if (delay == 0) CHECK(m.wheels.read<map::bus_voltage>());
    }
}

TEST_CASE("G14: the simulated drive responds over the line with the exceptions of its manual") {
    machine m;
    std::array<u16, 2> words{};
    CHECK(m.wheels.read_words(0x2015, std::span<u16>{words}.first(1)) == status::sent(errc::exception, 2));
    CHECK(m.wheels.write_word(0x2008, 0) == status::sent(errc::exception, 3));
    CHECK(m.wheels.write_word(0x20A1, 0) == status::sent(errc::exception, 2));
    CHECK(m.wheels.read_words(0x2000, words, modbus::function::read_input_registers) ==
          status::sent(errc::exception, 1));
}

TEST_CASE("broadcast writes reach every drive on the line") {
    machine m;
    sim::zlac8015d second;
    sim::station at_the_second{second, 2, 115200};
    const std::array<std::uint8_t, 2> two{0, 2};
    const std::array<std::uint8_t, 2> one{0, 1};
    CHECK(second.write(0x2001, words_view{two}) == 0);
    CHECK(second.write(0x2010, words_view{one}) == 0);
    second.power_cycle();
    m.wire.attach(at_the_second);
    CHECK(m.wheels.broadcast<map::left_acceleration_time>(123));
    CHECK(m.drive.peek(0x2080) == 123);
    CHECK(second.peek(0x2080) == 123);
    CHECK(m.wire.responses() == 0);
}

} // namespace sim_zlac8015d_line_tests
