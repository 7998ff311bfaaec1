// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Requests that a program steps on the line of its bus: the plan has them or they are refused, a node that is gone is
// backed off, and the bounds hold. Judged by the frames on the wire.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <servobus/bus/bus.hpp>
#include <servobus/client/stepped_read.hpp>
#include <servobus/client/stepped_write.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/yako.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <tests/support/loop_bound.hpp>
#include <tests/support/scripted_port.hpp>

namespace other_requests_tests {

using namespace servobus;
using namespace servobus::units;

namespace {

template <class Device>
constexpr node<Device> slow(std::uint8_t address, std::uint32_t limit_ms, std::uint32_t quarantine_ms = 30) {
    node<Device> n{address};
    n.limits.response = milliseconds(limit_ms);
    n.gaps.quarantine = milliseconds(quarantine_ms);
    return n;
}
using sensor = yako::closed_loop::device;
constexpr auto wheels_node = slow<zlac8015d::device>(1, 20);
constexpr auto sensor_node = slow<sensor>(9, 100);
constexpr auto second_node = slow<sensor>(10, 100);

constexpr poll_plan plan{
    modbus::timing_at(115200),
    controlled(wheels_node, {.feedback = milliseconds(20), .command_timeout = milliseconds(500)})
        .commands(milliseconds(40)),
    own_requests(sensor_node, milliseconds(50), 2), own_requests(second_node, milliseconds(50), 2)};

constexpr poll_plan with_one_node{
    modbus::timing_at(115200),
    controlled(wheels_node, {.feedback = milliseconds(20), .command_timeout = milliseconds(500)})
        .commands(milliseconds(40)),
    own_requests(sensor_node, milliseconds(50), 2)};

/// A request of the program takes 20 ms on the wire.
constexpr poll_plan with_long_writes{
    modbus::timing_at(115200),
    controlled(wheels_node, {.feedback = milliseconds(100), .command_timeout = no_command_timeout}),
    own_requests(sensor_node, milliseconds(500), 100)};

/// The bus reads the node of the program's requests too.
constexpr poll_plan with_reads_of_it{
    modbus::timing_at(115200),
    controlled(wheels_node, {.feedback = milliseconds(100), .command_timeout = no_command_timeout}),
    cyclic<yako::status_word>(sensor_node, milliseconds(200)),
    own_requests(sensor_node, milliseconds(50), 2)};

/// Beside commands back to back it fills the line.
constexpr poll_plan crowded{
    modbus::timing_at(115200),
    controlled(wheels_node, {.feedback = milliseconds(20), .command_timeout = no_command_timeout}),
    cyclic<zlac8015d::bus_voltage>(wheels_node, milliseconds(20)),
    own_requests(sensor_node, milliseconds(50), 1)};

/// Refuses all requests by one exception.
struct refusing_sensor {
    std::uint8_t number;
    unsigned writes = 0;

    std::uint8_t read(std::uint16_t, std::span<std::uint16_t>) { return number; }
    std::uint8_t write(std::uint16_t, words_view) {
        ++writes;
        return number;
    }
};

struct request {
    std::uint64_t begin, end;
    std::vector<std::uint8_t> data;
};

struct rig {
    using line_type = scheduled_line<sim::virtual_line>;

    sim::zlac8015d model{};
    sim::yako_closed_loop first_model{sim::yako_options{.switches = 9}};
    sim::yako_closed_loop second_model{sim::yako_options{.switches = 10}};
    sim::station<sim::zlac8015d> station{model};
    sim::station<sim::yako_closed_loop> first_station{first_model};
    sim::station<sim::yako_closed_loop> second_station{second_model};
    sim::virtual_line wire{115200};
    line_type on{wire, plan.timing()};
    zlac8015d::drive<line_type> wheels{on, wheels_node, by_plan};
    bus<plan, line_type, decltype(wheels)> all{on, wheels};
    std::vector<request> seen{};
    std::vector<std::uint8_t> open{};

    rig() {
        wire.attach(station);
        wire.attach(first_station);
        wire.attach(second_station);
        wire.set_hook(&rig::note, this);
        REQUIRE(all.run(wheels, init{}));
        enable();
    }
    rig(const rig&) = delete;
    rig& operator=(const rig&) = delete;

    static void note(void* self, const sim::wire_byte& b) {
        if (!b.is_from_client) return;
        auto& r = *static_cast<rig*>(self);
        r.open.push_back(b.value);
        if (r.open.size() != modbus::request_length(r.open)) return;
        r.seen.push_back({b.at_us - r.open.size() * 96, b.at_us, r.open});
        r.open.clear();
    }
    void enable() {
        REQUIRE(all.run(wheels, zlac8015d::enable_in{zlac8015d::operating_mode::velocity}));
        REQUIRE(all.run(wheels, velocity{30 * r_per_min, 30 * r_per_min}));
    }
    std::size_t count_to(std::uint8_t address) const {
        std::size_t n = 0;
        for (const request& r : seen) n += r.data[0] == address ? 1u : 0u;
        return n;
    }
    std::size_t setpoints() const {
        std::size_t n = 0;
        for (const request& r : seen) n += r.data[1] == 0x10 ? 1u : 0u;
        return n;
    }
};

/// A program that asks a node every 50 ms, beside its bus.
template <class Line> struct asking {
    using client_type = client<Line, sensor>;

    client_type node;
    stepped_read<client_type, yako::status_word> read{node};
    std::uint64_t next = 0;
    std::size_t good = 0;
    std::size_t bad = 0;
    bool is_under_way = false;

    asking(Line& on, const servobus::node<sensor>& at) : node{on, at} {}

    duration step(sim::virtual_line& wire) {
        if (!is_under_way) {
            if (wire.time_us() < next) return milliseconds(1);
            next = wire.time_us() + 50'000;
            REQUIRE(read.begin() == errc::ok);
            is_under_way = true;
        }
        const duration idle = read.step();
        if (!read.done()) return idle;
        is_under_way = false;
        (read.value() ? good : bad) += 1;
        return {};
    }
};
template <class Line> asking(Line&, const node<sensor>&) -> asking<Line>;

void turn(rig& r, asking<rig::line_type>& a, asking<rig::line_type>& b) {
    const duration idle = shorter_of(r.all.step(), shorter_of(a.step(r.wire), b.step(r.wire)));
    r.wire.wait(longer_of(idle, microseconds(1)));
}
void run(rig& r, std::uint32_t ms, asking<rig::line_type>& a, asking<rig::line_type>& b) {
    const std::uint64_t end = r.wire.time_us() + std::uint64_t{ms} * 1000;
    std::uint64_t next = r.wire.time_us();
    while (r.wire.time_us() < end) {
        turn(r, a, b);
        if (r.wire.time_us() < next || !r.wheels.is_idle()) continue;
        next += 40'000;
        CHECK(r.wheels.begin(velocity{30 * r_per_min, 30 * r_per_min}) == errc::ok);
    }
}

constexpr auto lift_node = slow<sensor>(2, 50, 60);
constexpr poll_plan alone{
    modbus::timing_at(9600),
    controlled(lift_node, {.feedback = milliseconds(200), .command_timeout = no_command_timeout})};
constexpr poll_plan beside{
    modbus::timing_at(9600),
    controlled(lift_node, {.feedback = milliseconds(200), .command_timeout = no_command_timeout}),
    own_requests(slow<sensor>(9, 300, 90), milliseconds(500), 10)};

} // namespace

TEST_CASE(
    "G25: a stop has left within the plan's bound beside the program's own requests, also to a node that "
    "is gone") {
    for (const bool is_gone : {false, true}) {
        CAPTURE(is_gone);
        rig r;
        asking sensor_of_program{r.on, sensor_node};
        asking second_of_program{r.on, second_node};
        std::uint64_t longest = 0;
        std::size_t during = 0; // a request of the program's own
        for (std::uint32_t k = 0; k < 80; ++k) {
            r.wire.set_connected(1, !is_gone);
            const std::size_t before = r.seen.size();
            run(r, 60 + k % 7 * 150, sensor_of_program, second_of_program);
            // Half of the stops are commanded while the response of the sensor is awaited.
            if (k % 2 == 0) {
                const std::size_t asked = r.count_to(9);
                const std::uint64_t end = r.wire.time_us() + 1'200'000;
                while (r.count_to(9) == asked && r.wire.time_us() < end)
                    turn(r, sensor_of_program, second_of_program);
            }
            REQUIRE(r.seen.size() > before);
            const bool is_sensor = r.seen.back().data[0] == 9;
            const std::uint64_t ordered = r.wire.time_us();
            REQUIRE(r.wheels.begin(quick_stop{}) == errc::ok);
            while (r.seen.back().begin < ordered) turn(r, sensor_of_program, second_of_program);
            const std::size_t first = r.seen.size() - 1;
            CHECK(r.seen[first].data[0] == 1); // no other frame went before it
            const std::uint64_t took = r.seen[first].end - ordered;
            CHECK(took <= plan.worst_case_stop_latency().us);
            longest = took > longest ? took : longest;
            during += is_sensor ? 1u : 0u;
            for (tests::loop_bound left{"the end of a command"}; !r.wheels.is_idle(); left.use())
                turn(r, sensor_of_program, second_of_program);
            REQUIRE(r.wheels.last());
            REQUIRE(r.wheels.begin(zlac8015d::enable_in{zlac8015d::operating_mode::velocity}) == errc::ok);
            for (tests::loop_bound left{"the end of a command"}; !r.wheels.is_idle(); left.use())
                turn(r, sensor_of_program, second_of_program);
            REQUIRE(r.wheels.last());
        }
        CHECK(during > 30);
        CHECK((sensor_of_program.good > 100) == !is_gone);
        if (is_gone) CHECK(longest > 100'000); // the whole limit of the node that is gone
    }
}

TEST_CASE("an address at which a plan has no drive is not that of another") {
    for (unsigned address = 0; address < 256; ++address) {
        CAPTURE(address);
        CHECK(plan.drive_at(static_cast<std::uint8_t>(address)) == (address == 1 ? 0u : plan.drives));
    }
}

TEST_CASE("G28: a node of the program's own requests that is gone is asked once a second, and found when it "
          "returns") {
    rig r;
    asking gone{r.on, sensor_node};
    asking present{r.on, second_node};
    run(r, 1000, gone, present);
    CHECK(gone.good > 15);
    CHECK(gone.bad == 0);
    r.wire.set_connected(1, false);
    run(r, 1000, gone, present); // until it counts as gone
    const std::size_t asked = r.count_to(9);
    const std::size_t setpoints = r.setpoints();
    const std::size_t good = present.good;
    run(r, 20'000, gone, present);
    CHECK(r.count_to(9) - asked >= 18);
    CHECK(r.count_to(9) - asked <= 22);
    CHECK(r.setpoints() - setpoints > 20 * 20);
    CHECK(present.good - good > 20 * 15); // the node beside it is not
    CHECK(present.bad == 0);
    const std::size_t before = gone.good;
    r.wire.set_connected(1, true);
    run(r, 1200, gone, present);
    CHECK(gone.good > before);
    const std::size_t again = gone.good;
    run(r, 2000, gone, present);
    CHECK(gone.good > again + 30); // and at its own rate again
}

namespace {

/// A node counts as gone after so many requests of the program without a response.
template <std::uint8_t Failures>
constexpr poll_plan giving_up{
    modbus::timing_at(115200),
    controlled(wheels_node, {.feedback = milliseconds(20), .command_timeout = no_command_timeout}),
    own_requests(sensor_node, milliseconds(50), 2), back_off{.failures = Failures}};

/// The requests that reach the wire in 0.9 s, each of which takes 0.15 s, once the node is silent.
template <std::uint8_t Failures> std::size_t asked_while_silent() {
    rig r; // its bus is not stepped any more
    bus<giving_up<Failures>, rig::line_type, decltype(r.wheels)> all{r.on, r.wheels};
    asking a{r.on, sensor_node};
    const auto run_for = [&](std::uint32_t ms) {
        const std::uint64_t end = r.wire.time_us() + std::uint64_t{ms} * 1000;
        while (r.wire.time_us() < end)
            r.wire.wait(longer_of(shorter_of(all.step(), a.step(r.wire)), microseconds(1)));
    };
    run_for(5000);
    const std::size_t before = r.count_to(9);
    r.wire.set_connected(1, false);
    run_for(900);
    return r.count_to(9) - before;
}

} // namespace

TEST_CASE("G28: a node of the program's own requests is gone after as many misses as the plan says, three at "
          "most") {
    const std::size_t after_one = asked_while_silent<1>();
    CHECK(asked_while_silent<2>() == after_one + 1);
    CHECK(asked_while_silent<3>() == after_one + 2);
    CHECK(asked_while_silent<9>() == after_one + 2);
}

namespace {

// A program asks a node that refuses everything, every 50 ms for 3 s, and writes once.
template <const auto& Plan, bool HasReads> void ask_one_that_refuses(std::uint8_t number) {
    using line_type = scheduled_line<sim::virtual_line>;
    sim::zlac8015d model{};
    refusing_sensor refuses{number};
    sim::station<sim::zlac8015d> station{model};
    sim::station<refusing_sensor> other_station{refuses, 9, 115200};
    sim::virtual_line wire{115200};
    line_type on{wire, Plan.timing()};
    zlac8015d::drive<line_type> wheels{on, wheels_node, by_plan};
    bus<Plan, line_type, decltype(wheels)> all{on, wheels};
    wire.attach(station);
    wire.attach(other_station);
    REQUIRE(all.run(wheels, init{}));
    client<line_type, sensor> direct{on, sensor_node};
    stepped_read_words<decltype(direct), 2> read{direct};
    stepped_write_words<decltype(direct), 1> write{direct};
    const auto until = [&](std::uint64_t at) {
        while (wire.time_us() < at) wire.wait(longer_of(all.step(), microseconds(1)));
    };
    const auto ended = [&](auto& call) {
        for (const std::uint64_t end = wire.time_us() + 1'000'000; !call.done() && wire.time_us() < end;)
            wire.wait(longer_of(shorter_of(all.step(), call.step()), microseconds(1)));
        REQUIRE(call.done());
        return call.status();
    };
    unsigned refused = 0;
    for (const std::uint64_t end = wire.time_us() + 3'000'000; wire.time_us() < end;) {
        const std::uint64_t next = wire.time_us() + 50'000;
        REQUIRE(read.begin(0xFFF0, 2) == errc::ok);
        const status got = ended(read);
        CHECK(got.exception() == number);
        CHECK(got.error() == errc::exception);
        refused += got.has_response() ? 1u : 0u;
        until(next);
    }
    CHECK(refused > 30); // a node that is gone is asked once a second
    if constexpr (HasReads) {
        CHECK_FALSE(all.is_absent(9));
        CHECK(all.template latest<yako::status_word>(sensor_node, milliseconds(500)).error() ==
              errc::exception);
    }
    REQUIRE(write.begin(u16{0x0020}, u16{1}) == errc::ok);
    const status how = ended(write);
    CHECK(how.exception() == number);
    CHECK(how.outcome() == outcome::refused); // G16
    CHECK(refuses.writes == 1);               // G15
}

} // namespace

TEST_CASE(
    "G28: a node that refuses is there: own requests, cyclic reads, and a client's write beside the bus") {
    for (std::uint8_t number = 1; number <= 6; ++number) {
        CAPTURE(static_cast<int>(number));
        ask_one_that_refuses<with_one_node, false>(number);
        ask_one_that_refuses<with_reads_of_it, true>(number);
    }
}

TEST_CASE("G28: a request that has ended, or that never left, is no miss of its node") {
    for (const bool is_unplugged : {false, true}) {
        CAPTURE(is_unplugged);
        rig r;
        std::array<std::uint8_t, 64> response{};
        const auto request = modbus::read_frame(9, 0x06, 2);
        const auto ended = [&] {
            modbus::exchange x{request, response, r.on.timing(), sensor_node.limits};
            const std::uint64_t end = r.wire.time_us() + 300'000;
            while (!x.done() && r.wire.time_us() < end)
                r.wire.wait(longer_of(microseconds(1), r.on.step(x, sensor_node.gaps)));
            REQUIRE(x.done());
            for (int i = 0; i < 5; ++i) CHECK(r.on.step(x, sensor_node.gaps) == duration{}); // once more
            return x.status();
        };
        if (is_unplugged) {
            r.wire.unplug();
            for (int i = 0; i < 5; ++i) CHECK(ended() == status{errc::port_lost});
            r.wire.plug();
            r.wire.pass(milliseconds(200));
        }
        r.wire.set_connected(1, false);
        for (int i = 0; i < 2; ++i) REQUIRE(ended() == status::sent(errc::timeout)); // it is gone after three
        r.wire.set_connected(1, true);
        CHECK(ended());
        CHECK(ended());
    }
}

TEST_CASE(
    "G28: the program's own requests to a node that the bus reads too are sent, though it does not respond") {
    rig r; // its bus is not stepped any more
    bus<with_reads_of_it, rig::line_type, decltype(r.wheels)> all{r.on, r.wheels};
    asking a{r.on, sensor_node};
    const auto run_for = [&](std::uint32_t ms) {
        const std::uint64_t end = r.wire.time_us() + std::uint64_t{ms} * 1000;
        while (r.wire.time_us() < end)
            r.wire.wait(longer_of(shorter_of(all.step(), a.step(r.wire)), microseconds(1)));
    };
    run_for(1000);
    CHECK(a.good > 10);
    r.wire.set_connected(1, false);
    run_for(3000); // the reads of the bus are backed off now
    CHECK(all.is_absent(9));
    const std::size_t bad = a.bad;
    run_for(10'000);
    CHECK(a.bad - bad >= 15); // three attempts of about 0.15 s each
    r.wire.set_connected(1, true);
    const std::size_t good = a.good;
    run_for(600);
    CHECK(a.good > good);
}

TEST_CASE("G25: a request beside the bus that its plan does not have is refused before anything is sent, but "
          "a stop is not") {
    rig r;
    const auto ends = [&](modbus::exchange& x, const bus_gaps& gaps) {
        const std::size_t before = r.seen.size();
        const std::uint64_t end = r.wire.time_us() + 300'000;
        while (!x.done() && r.wire.time_us() < end) {
            const duration idle = r.on.step(x, gaps);
            r.wire.wait(longer_of(microseconds(1), shorter_of(idle, r.all.step())));
        }
        REQUIRE(x.done());
        bool is_seen = false;
        for (std::size_t i = before; i < r.seen.size(); ++i)
            is_seen = is_seen || same_bytes(bytes{r.seen[i].data}, x.request());
        CHECK(is_seen == x.was_sent());
        return x.status();
    };
    std::array<std::uint8_t, 64> response{};
    const auto ends_of = [&](bytes request, const node<sensor>& of, const bus_gaps& gaps) {
        modbus::exchange x{request, response, r.on.timing(), of.limits};
        return ends(x, gaps);
    };
    const auto is_refused = [&](const status& s) {
        return s.error() == errc::not_in_plan && s.outcome() == outcome::not_sent;
    };
    const auto read = [](std::uint8_t address, std::uint16_t words) {
        return modbus::read_frame(address, 0x06, words);
    };
    CHECK(ends_of(read(9, 2), sensor_node, sensor_node.gaps));
    CHECK(is_refused(ends_of(read(9, 5), sensor_node, sensor_node.gaps))); // more words
    CHECK(is_refused(ends_of(read(5, 2), sensor_node, sensor_node.gaps))); // another node
    CHECK(is_refused(ends_of(read(1, 2), sensor_node, sensor_node.gaps))); // the bus's own drive
    const node<sensor> later = slow<sensor>(9, 101);
    CHECK(is_refused(ends_of(read(9, 2), later, later.gaps))); // a longer time limit
    const node<sensor> more_careful = slow<sensor>(9, 100, 31);
    CHECK(is_refused(ends_of(read(9, 2), sensor_node, more_careful.gaps)));
    const bus_gaps wider{.gap = milliseconds(3), .quarantine = {}};
    CHECK(is_refused(ends_of(read(9, 2), sensor_node, wider)));
    // A broadcast is no longer than they are; a long one would be.
    const response_limits long_after{.turnaround = milliseconds(400)};
    const auto to_all = modbus::write_frame(modbus::broadcast, 0x27, 0x0100);
    CHECK(ends_of(to_all, sensor_node, sensor_node.gaps));
    modbus::exchange slow_broadcast{to_all, response, r.on.timing(), long_after};
    CHECK(is_refused(ends(slow_broadcast, sensor_node.gaps)));
    // A stop is sent, whatever the plan says.
    const auto stop = modbus::write_frame(5, 0x27, 0x0100);
    modbus::exchange urgent{stop, response, r.on.timing(), sensor_node.limits, priority::stop};
    CHECK(ends(urgent, sensor_node.gaps).error() == errc::timeout);
    CHECK(r.wheels.state() == zlac8015d::drive_state::enabled);
}

TEST_CASE("G25: a stop that was begun goes before a request that the program steps first") {
    std::size_t near = 0; // stops that were commanded while the request waited to be sent
    for (std::uint32_t k = 0; k < 60; ++k) {
        CAPTURE(k);
        rig r;
        asking own{r.on, sensor_node};
        while (!own.is_under_way || k % 2 == 1) {
            (void)own.step(r.wire);
            if (r.wire.time_us() > 1'000'000) break;
            r.wire.wait(longer_of(microseconds(1), r.all.step()));
        }
        r.wire.pass(microseconds(k * 37));
        const std::size_t before = r.seen.size();
        const std::uint64_t ordered = r.wire.time_us();
        REQUIRE(r.wheels.begin(quick_stop{}) == errc::ok);
        near += own.is_under_way ? 1u : 0u;
        while (r.seen.size() == before || r.seen.back().begin < ordered) {
            (void)own.step(r.wire); // before the bus
            r.wire.wait(longer_of(microseconds(1), r.all.step()));
        }
        CHECK(r.seen.back().data[0] == 1);
        CHECK(r.seen.back().data[1] == 6);
    }
    CHECK(near >= 30);
}

TEST_CASE(
    "G25: a stop that waits leaves a response the time that it may take, however long its request was") {
    for (const std::uint8_t words : {std::uint8_t{1}, std::uint8_t{100}}) {
        CAPTURE(words);
        tests::scripted_port port;
        scheduled_line<tests::scripted_port> on{port, with_long_writes.timing()};
        zlac8015d::drive wheels{on, wheels_node, by_plan};
        [[maybe_unused]] auto all = make_bus<with_long_writes>(on, wheels); // the line is its line now
        // The response begins at the end of its time limit, and has nearly the longest pause.
        port.device = [](tests::scripted_port& p, const tests::sent_frame& f) {
            if (f.data[0] != sensor_node.address) return;
            const tests::byte_list response = tests::acknowledgement(f.data);
            p.say(99'500, {response.begin(), response.begin() + 4});
            p.say(99'500 + 4 * 96 + 19'500, {response.begin() + 4, response.end()});
        };
        tests::byte_list request{
            sensor_node.address, 0x10, 0x00, 0x20, 0x00, words, static_cast<std::uint8_t>(2 * words)};
        request.resize(7u + 2u * words);
        request = tests::framed(request);
        const tests::byte_list stop = tests::framed({1, 0x06, 0x20, 0x0E, 0x00, 0x07});
        std::array<std::uint8_t, 8> response{};
        std::array<std::uint8_t, 8> room{};
        modbus::exchange own{request, response, on.timing(), sensor_node.limits};
        modbus::exchange urgent{stop, room, on.timing(), wheels_node.limits, priority::stop};
        while (own.is_to_leave()) on.step(own, sensor_node.gaps);
        for (tests::loop_bound left{"the end of a call"}; !own.done(); left.use()) {
            on.step(urgent, wheels_node.gaps);
            on.step(own, sensor_node.gaps);
        }
        CHECK(own.status() == errc::ok);
        REQUIRE(port.frames.size() == 1);
        while (urgent.is_to_leave()) on.step(urgent, wheels_node.gaps);
        REQUIRE(port.frames.size() == 2);
        CHECK(port.frames[1].data == stop);
    }
}

TEST_CASE("G28: the program's own request has its turn on a line that the bus alone could fill") {
    rig r; // its bus is not stepped any more
    bus<crowded, rig::line_type, decltype(r.wheels)> all{r.on, r.wheels};
    asking own{r.on, sensor_node};
    const std::size_t before = r.seen.size();
    const std::uint64_t end = r.wire.time_us() + 5'000'000;
    bool is_setting = false;
    while (r.wire.time_us() < end) {
        if (r.wheels.is_idle()) { // commands back to back
            is_setting = !is_setting;
            REQUIRE(r.wheels.begin(velocity{30 * r_per_min, (is_setting ? 30 : 20) * r_per_min}) == errc::ok);
        }
        const duration idle = all.step();
        r.wire.wait(longer_of(microseconds(1), shorter_of(idle, own.step(r.wire))));
    }
    CHECK(r.seen.size() - before > 800);
    CHECK(own.bad == 0);
    CHECK(own.good > 80);
}

TEST_CASE(
    "G28: of the requests that wait beside a bus, the one that has waited longest counts, in whatever order "
    "the program steps them") {
    for (const std::uint16_t first : {std::uint16_t{1}, std::uint16_t{0x7FFF}, std::uint16_t{0xFFF0}}) {
        CAPTURE(first);
        const auto later = static_cast<std::uint16_t>(first + 20); // tickets wrap
        detail::other_requests others;
        CHECK(others.take_waiting() == 0);
        others.note_waiting(later);
        others.note_waiting(first);
        CHECK(others.take_waiting() == first);
        others.note_waiting(first);
        others.note_waiting(later);
        CHECK(others.take_waiting() == first);
        CHECK(others.take_waiting() == 0); // one that still waits is noted again
        others.note_waiting(later);
        CHECK(others.take_waiting() == later);
    }
}

TEST_CASE("G28: a silent node is due again after each window, however long a plan makes it") {
    for (const std::uint32_t window_ms : {1000u, 29'000u, 34'000u, 67'000u, 1'800'000u}) {
        CAPTURE(window_ms);
        detail::other_requests others;
        unsigned asked = 0;
        for (std::uint64_t ms = 0; ms < 300'000; ms += 50) {
            const instant now{static_cast<std::uint32_t>(ms * 1000)};
            if (!others.is_due(3, now, milliseconds(window_ms))) continue;
            others.note(3, false);
            ++asked;
        }
        const std::uint32_t kept_ms = window_ms < 30'000 ? window_ms : 30'000;
        CHECK(asked >= 300'000 / (kept_ms + 200));
        CHECK(asked <= 300'000 / (kept_ms - 200) + 1);
    }
}

TEST_CASE("G19, G25, G28: the program's own requests count in a plan's times, to the microsecond") {
    // At 9600 Bd a character takes 1146 us, t3.5 4011 us. The request of 29 bytes, or of 8 with a response of 25.
    constexpr std::uint32_t t3_5 = 4011;
    CHECK(beside.load_per_mille() == alone.load_per_mille() + (2 * t3_5 + 37 * 1146u) / 500 + 1);
    constexpr std::uint32_t most = t3_5 + 29 * 1146 + 300'000 + 90'000 + 25 * 1146 + 90'000;
    CHECK(beside.longest_stop_pause().us - alone.longest_stop_pause().us == most + 2 * 30'000);
    CHECK(beside.absent_load_per_mille() - alone.absent_load_per_mille() >= most / 1000);
    // The request, its limit, the gap after it, a late response with its pauses, the gap, the stop.
    CHECK(beside.worst_case_stop_latency().us ==
          8 * 1146 + 300'000 + t3_5 + (25 * 1146 + 25 * 1719) + t3_5 + 13 * 1146);
    CHECK(alone.worst_case_stop_latency().us < 200'000);
}

} // namespace other_requests_tests
