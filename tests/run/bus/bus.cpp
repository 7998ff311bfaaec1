// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A bus with two wheels and a lift on one line, in virtual time: feedback, cyclic reads, commands between them, stops
// ahead of all, keep-alives, and drives that are absent and return.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include <tests/support/driven_wheels_and_lift.hpp>
#include <tests/support/loop_bound.hpp>
#include <tests/support/scripted_port.hpp>

namespace bus_tests {

using namespace servobus;
using namespace servobus::units;

namespace {

using tests::fast_plan, tests::lift_node, tests::wheels_node;
using wheels_device = zlac8015d::device;

static_assert(fast_plan.drives == 2 && fast_plan.size == 3);
static_assert(fast_plan.response_room == 9 && fast_plan.words == 4);
static_assert(fast_plan.load_per_mille() > 400 && fast_plan.load_per_mille() < 900);
// A stop waits for at most one exchange in progress: a frame, 30 ms without a response, the inter-byte limit.
static_assert(fast_plan.worst_case_stop_latency() > milliseconds(30));
static_assert(fast_plan.worst_case_stop_latency() < milliseconds(100));
static_assert(fast_plan.worst_case_stop_latency(2) > fast_plan.worst_case_stop_latency());
static_assert(fast_plan.longest_gap(fast_plan.controlled[0]) <= milliseconds(938));

constexpr auto speeds_read =
    cyclic<zlac8015d::left_actual_speed, zlac8015d::right_actual_speed>(wheels_node, milliseconds(20));
static_assert(speeds_read.keep_alive == duration{});
static_assert(speeds_read.keeps_alive(milliseconds(500)).keep_alive == milliseconds(500));

consteval auto two_reads(std::uint32_t baud, duration period, back_off rules = {}) {
    return poll_plan{modbus::timing_at(baud),
                     cyclic<zlac8015d::left_actual_speed, zlac8015d::right_actual_speed>(wheels_node, period),
                     cyclic<yako::status_word>(lift_node, period), rules};
}
// The shortest periods that the line allows if both drives respond t3.5 after a request.
consteval auto busy(std::uint32_t baud) {
    const auto slow = two_reads(baud, milliseconds(1000));
    return two_reads(baud, slow.shortest(slow.polls[0]) + slow.shortest(slow.polls[1]));
}
inline constexpr auto busy_at_9600 = busy(9600);
inline constexpr auto busy_at_57600 = busy(57'600);
inline constexpr auto busy_at_115200 = busy(115'200);
static_assert(busy_at_9600.load_per_mille() >= 999);

struct seen_frame {
    std::uint64_t begin;
    std::uint64_t end;
    std::vector<std::uint8_t> data;
};

struct seen_requests {
    struct request {
        std::uint8_t address;
        bool is_read;
    };
    std::vector<request> asked{};

    void on_request(bytes frame) { asked.push_back({frame[0], frame[1] == 0x03}); }
    void on_response(bytes, status) {}
    void on_unexpected(bytes) {}
};

bool is_stop(const std::vector<std::uint8_t>& frame) { // 200Eh = 05h or 07h
    return frame[0] == 1 && frame[1] == 0x06 && frame[2] == 0x20 && frame[3] == 0x0E &&
           (frame[5] == 5 || frame[5] == 7);
}

struct rig : tests::wheels_and_lift, tests::wheels_and_lift_program {
    std::vector<seen_frame> requests;

    rig() : wheels_and_lift_program{wire} { wire.set_hook(&rig::note, this); }

    static void note(void* self, const sim::wire_byte& b) {
        auto& r = *static_cast<rig*>(self);
        if (!b.is_from_client) return;
        const bool is_new = r.requests.empty() ||
                            modbus::request_length(r.requests.back().data) == r.requests.back().data.size();
        if (is_new) r.requests.push_back({b.at_us - 96, 0, {}});
        r.requests.back().data.push_back(b.value);
        r.requests.back().end = b.at_us;
    }
    std::size_t stops_in(std::uint32_t ms) {
        const std::size_t seen = requests.size();
        run(ms);
        std::size_t n = 0;
        for (std::size_t i = seen; i < requests.size(); ++i) n += is_stop(requests[i].data) ? 1u : 0u;
        return n;
    }
};

struct plain_store {
    static std::uint8_t read(std::uint16_t address, std::span<std::uint16_t> to) {
        for (std::uint16_t& word : to) word = address++;
        return 0;
    }
    static std::uint8_t write(std::uint16_t, words_view) { return 0; }
};

// Two drives that are only read, every 20 ms each. The first one may refuse.
struct refusing_store {
    std::uint32_t refuses_from = ~std::uint32_t{0};
    std::uint32_t asked = 0;
    std::uint8_t read(std::uint16_t, std::span<std::uint16_t> to) {
        for (std::uint16_t& word : to) word = 5;
        return asked++ >= refuses_from ? 2 : 0;
    }
    static std::uint8_t write(std::uint16_t, words_view) { return 0; }
};
inline constexpr auto both_at_50_hz = two_reads(115200, milliseconds(20));
inline constexpr auto with_hasty_retries =
    two_reads(115200, milliseconds(20), {.failures = 3, .retry_every = milliseconds(1)});
template <const auto& Plan = both_at_50_hz> struct rig_of_stores {
    refusing_store wheels_store;
    plain_store lift_store;
    sim::station<refusing_store> wheels{wheels_store, 1, 115200};
    sim::station<plain_store> lift{lift_store, 2, 115200};
    sim::virtual_line wire{115200};
    scheduled_line<sim::virtual_line> on{wire, modbus::timing_at(115200)};
    bus<Plan, scheduled_line<sim::virtual_line>> all{on};

    rig_of_stores() {
        wire.attach(wheels);
        wire.attach(lift);
    }
    rig_of_stores(const rig_of_stores&) = delete;
};

// How many per cent of the reads for which there is time the bus makes.
template <const auto& Plan> std::uint64_t share_of_the_possible(std::uint32_t baud) {
    plain_store store;
    sim::station<plain_store> wheels{store, 1, baud};
    sim::station<plain_store> lift{store, 2, baud};
    sim::virtual_line wire{baud};
    wire.attach(wheels);
    wire.attach(lift);
    scheduled_line on{wire, Plan.timing()};
    bus<Plan, decltype(on)> all{on};
    all.run_for(milliseconds(1000));
    const std::uint32_t before = all.count(0) + all.count(1);
    all.run_for(milliseconds(20'000));
    const std::uint64_t made = all.count(0) + all.count(1) - before;
    return made * Plan.polls[0].period.us * 100u / (2u * 20'000'000u);
}

} // namespace

TEST_CASE(
    "a bus reads feedback and registers at the rates of its plan, with commands of two drives between") {
    rig r;
    REQUIRE(r.command(r.wheels, init{}));
    REQUIRE(r.command(r.lift, init{}));
    REQUIRE(r.command(r.wheels, zlac8015d::enable_in{zlac8015d::operating_mode::velocity}));
    REQUIRE(r.command(r.wheels, velocity{30 * r_per_min, 30 * r_per_min}));
    r.run(100);
    const std::uint32_t before[] = {r.all.count(0), r.all.count(1), r.all.count(2)};
    const std::size_t seen = r.requests.size();
    const std::uint64_t end = r.wire.time_us() + 3'000'000;
    while (r.wire.time_us() < end) {
        r.turn();
        REQUIRE(r.wheels.feedback(milliseconds(45)));
        REQUIRE(r.lift.feedback(milliseconds(65)));
    }
    CHECK(r.all.count(0) - before[0] >= 59);
    CHECK(r.all.count(0) - before[0] <= 61);
    CHECK(r.all.count(1) - before[1] >= 49);
    CHECK(r.all.count(1) - before[1] <= 51);
    CHECK(r.all.count(2) - before[2] >= 29);
    CHECK(r.all.count(2) - before[2] <= 31);
    std::size_t images[3]{};
    for (std::size_t i = seen; i < r.requests.size(); ++i) {
        const auto& f = r.requests[i].data;
        if (f.size() == 8 && (f[5] == 11 || f[5] == 7)) ++images[f[0]];
    }
    CHECK(images[1] >= 130); // a period counts from the last response
    CHECK(images[1] <= 151);
    CHECK(images[2] >= 85);
    CHECK(images[2] <= 101);
    CHECK(r.wheels.feedback(milliseconds(40))->left_speed.rounded(r_per_min) == 30);
    CHECK(r.all.latest<zlac8015d::bus_voltage>(wheels_node, milliseconds(100)));
    CHECK(r.all.latest<yako::closed_loop::output_polarity>(lift_node, milliseconds(120)));
    CHECK(r.all.latest<yako::actual_position>(lift_node, milliseconds(200)));
    CHECK(r.wheels_model.enabled());
}

TEST_CASE("S1: a bus sends nothing to a drive of which nothing is known") {
    rig r;
    r.run(3000);
    CHECK(r.requests.empty());
    CHECK(r.all.latest<zlac8015d::bus_voltage>(wheels_node, milliseconds(1000)).error() == errc::needs_init);
    CHECK(r.wheels.feedback(milliseconds(1000)).error() == errc::needs_init);
    REQUIRE(r.command(r.lift, init{}));
    const std::size_t after = r.requests.size();
    r.run(1000);
    CHECK(r.requests.size() > after + 30);
    for (std::size_t i = after; i < r.requests.size(); ++i) CHECK(r.requests[i].data[0] == 2);
}

TEST_CASE("keeps_alive() changes nothing of a read but its keep-alive") {
    const auto kept = speeds_read.keeps_alive(milliseconds(500));
    CHECK(kept.keep_alive == milliseconds(500));
    CHECK(kept.node_address == 1);
    CHECK(kept.address == zlac8015d::left_actual_speed.address);
    CHECK(kept.words == 2);
    CHECK(kept.period == milliseconds(20));
    CHECK(kept.limits.response == milliseconds(30));
    CHECK(kept.gaps.quarantine == milliseconds(40));
    CHECK(kept.keeps_alive({}).keep_alive == duration{});
}

TEST_CASE("G36: a value becomes stale, and none from before a restart is delivered after it") {
    rig r;
    REQUIRE(r.command(r.wheels, init{}));
    REQUIRE(r.command(r.lift, init{}));
    CHECK(r.all.latest<yako::actual_position>(lift_node, milliseconds(1000)).error() ==
          errc::timeout); // none was read yet
    r.run(300);
    CHECK(r.all.latest<zlac8015d::bus_voltage>(wheels_node, milliseconds(100)));
    CHECK(r.all.latest<yako::actual_position>(lift_node, milliseconds(200)));
    CHECK(r.lift.feedback(milliseconds(100)));
    r.wire.set_connected(1, false);
    r.run(2000);
    CHECK(r.all.latest<yako::actual_position>(lift_node, milliseconds(200)).error() != errc::ok);
    CHECK(r.lift.feedback(milliseconds(200)).error() == errc::timeout);
    CHECK(r.lift.feedback(milliseconds(10'000))); // an old one
    r.wire.set_connected(1, true);
    r.run(4000);
    CHECK(r.all.latest<yako::actual_position>(lift_node, milliseconds(200)));
    CHECK(r.lift.feedback(milliseconds(100)));
    r.wire.set_connected(1, false);
    r.lift_model.power_cycle();
    r.run(200);
    r.wire.set_connected(1, true);
    r.run(4000);
    CHECK(r.lift.state() == yako::drive_state::needs_init);
    CHECK(r.all.latest<yako::actual_position>(lift_node, milliseconds(100'000)).error() == errc::needs_init);
    CHECK(r.lift.feedback(milliseconds(100'000)).error() == errc::needs_init);
    REQUIRE(r.lift.begin(init{}) == errc::ok);
    const std::uint64_t begun = r.wire.time_us();
    for (tests::loop_bound left{"the end of a command"}; !r.lift.is_idle(); left.use()) {
        r.turn();
        const auto oldest = milliseconds(static_cast<std::uint32_t>((r.wire.time_us() - begun) / 1000));
        CHECK_FALSE(r.all.latest<yako::actual_position>(lift_node, milliseconds(100'000)));
        CHECK(bool{r.lift.feedback(milliseconds(100'000))} ==
              bool{r.lift.feedback(oldest)}); // none of before
    }
    CHECK(r.lift.last());
}

TEST_CASE("G25: a stop has left within the plan's bound, whatever else is in progress") {
    std::uint64_t longest = 0;
    for (std::uint32_t offset = 0; offset < 60; ++offset) {
        rig r;
        REQUIRE(r.command(r.wheels, init{}));
        REQUIRE(r.command(r.lift, init{}));
        REQUIRE(r.command(r.wheels, zlac8015d::enable_in{zlac8015d::operating_mode::velocity}));
        REQUIRE(r.command(r.wheels, velocity{30 * r_per_min, 30 * r_per_min}));
        if (offset % 2 == 1) r.wire.set_connected(1, false); // the lift does not respond
        r.run(50);
        (void)r.lift.begin(enable{});
        const std::uint64_t until = r.wire.time_us() + offset * 1777u;
        while (r.wire.time_us() < until) r.turn();
        (void)r.wheels.begin(velocity{20 * r_per_min, 20 * r_per_min}); // may still wait for the line
        for (std::uint32_t i = 0; i < offset % 5; ++i) r.turn();
        std::size_t first = r.requests.size();
        const std::uint64_t ordered = r.wire.time_us();
        REQUIRE(r.wheels.begin(quick_stop{}) == errc::ok);
        for (tests::loop_bound left{"the end of a command"}; !r.wheels.is_idle(); left.use()) r.turn();
        CHECK(r.wheels.last());
        while (first < r.requests.size() && !is_stop(r.requests[first].data)) ++first;
        REQUIRE(first < r.requests.size());
        CHECK(r.requests[first - 1].begin <= ordered + 100); // the frame in progress
        const std::uint64_t latency = r.requests[first].end - ordered;
        longest = latency > longest ? latency : longest;
        CHECK(latency <= fast_plan.worst_case_stop_latency().us);
    }
    CHECK(longest > milliseconds(25).us); // some stops did have to wait
}

TEST_CASE("G25: the bound of a stop also holds when a program runs the bus in consecutive blocking calls") {
    for (const std::uint32_t slice : {500u, 1000u, 2000u, 3000u, 5000u}) {
        for (std::uint32_t offset = 0; offset < 10; ++offset) {
            CAPTURE(slice);
            CAPTURE(offset);
            rig r;
            REQUIRE(r.command(r.lift, init{}));
            const auto run_on = [&] { r.all.run_for(microseconds(slice)); };
            const std::uint64_t begin = r.wire.time_us() + 200'000 + offset * 1087;
            while (r.wire.time_us() < begin) run_on();
            std::size_t first = r.requests.size();
            const std::uint64_t ordered = r.wire.time_us();
            REQUIRE(r.wheels.begin(quick_stop{}) == errc::ok);
            for (tests::loop_bound left{"the end of a command"}; !r.wheels.is_idle(); left.use()) run_on();
            while (first < r.requests.size() && !is_stop(r.requests[first].data)) ++first;
            REQUIRE(first < r.requests.size());
            // The wheels are not initialised yet, so their facade sends zero targets before the stop.
            CHECK(r.requests[first - 1].data[1] == 0x10);
            CHECK(r.requests[first].end - ordered <= 2 * fast_plan.worst_case_stop_latency().us);
        }
    }
}

TEST_CASE("G25: a stop is the next frame also if the program pauses between its command and the next step") {
    for (const std::uint32_t pause_ms : {0u, 100u, 600u, 900u}) {
        for (std::uint32_t ms = 0; ms < 20; ++ms) { // at other places in the frames of the others
            CAPTURE(pause_ms);
            CAPTURE(ms);
            rig r;
            REQUIRE(r.command(r.wheels, init{}));
            REQUIRE(r.command(r.lift, init{}));
            REQUIRE(r.command(r.lift, enable{}));
            r.run(100 + ms);
            REQUIRE(r.lift.begin(quick_stop{}) == errc::ok);
            r.wire.pass(milliseconds(pause_ms));
            const std::size_t before = r.requests.size();
            while (r.requests.size() == before || r.requests[before].data.size() < 2) r.turn();
            CHECK(r.requests[before].data[0] == 2);
            CHECK(modbus::is_write(r.requests[before].data[1]));
        }
    }
}

TEST_CASE("G19: a drive with a watchdog gets a request in time, whichever other drives are absent") {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        rig r;
        REQUIRE(r.command(r.wheels, init{}));
        REQUIRE(r.command(r.lift, init{}));
        REQUIRE(r.command(r.wheels, zlac8015d::watchdog{1000 * millisecond}));
        REQUIRE(r.command(r.wheels, zlac8015d::enable_in{zlac8015d::operating_mode::velocity}));
        REQUIRE(r.command(r.wheels, velocity{30 * r_per_min, 30 * r_per_min}));
        sim::dice random{seed};
        std::uint64_t last = r.wire.time_us();
        std::uint64_t longest = 0;
        for (int i = 0; i < 40; ++i) {
            r.wire.set_connected(1, random.below(3) != 0);
            if (random.below(2) == 0 && r.lift.is_idle()) (void)r.lift.begin(init{});
            const std::size_t seen = r.requests.size();
            r.run(100 + random.below(400));
            for (std::size_t k = seen; k < r.requests.size(); ++k) {
                const seen_frame& f = r.requests[k];
                if (f.data[0] != 1) continue;
                longest = f.begin > last && f.begin - last > longest ? f.begin - last : longest;
                last = f.begin;
            }
        }
        CHECK(longest <= 1'000'000);
        CHECK(longest > 15'000);
        CHECK(r.wheels_model.enabled());
    }
}

TEST_CASE("G28: an absent drive costs the others no more than the plan states, and is found again within the "
          "stated time") {
    constexpr std::uint32_t seconds = 10;
    for (std::uint32_t offset = 0; offset < 20; ++offset) {
        rig r;
        REQUIRE(r.command(r.wheels, init{}));
        REQUIRE(r.command(r.lift, init{}));
        r.run(500);
        r.wire.set_connected(1, false);
        r.run(2500 + 53 * offset);
        REQUIRE(r.all.is_absent(2));
        REQUIRE(r.lift.is_absent());
        CHECK_FALSE(r.all.is_absent(1));
        const std::uint32_t before = r.all.count(0);
        r.run(seconds * 1000);
        // One read every 50 ms, less those that the absent drive costs. Each attempt also delays one read.
        constexpr std::uint32_t lost = fast_plan.absent_load_per_mille() * seconds / 50 + seconds + 1;
        CHECK(r.all.count(0) - before >= 20 * seconds - lost);
        r.wire.set_connected(1, true);
        const std::uint64_t back = r.wire.time_us();
        while (r.all.is_absent(2) && r.wire.time_us() < back + 60'000'000) r.turn();
        CHECK(r.wire.time_us() - back <= fast_plan.rediscovery_bound(2).us);
        const std::uint32_t again = r.all.count(1);
        r.run(3000);
        CHECK(r.all.count(1) - again >= 48);
        CHECK(r.lift.feedback(milliseconds(100)));
    }
    static_assert(fast_plan.absent_load_per_mille() < 200); // of the lift, and of reads
    static_assert(fast_plan.rediscovery_bound(1) < milliseconds(3500));
    static_assert(fast_plan.rediscovery_bound() > fast_plan.rediscovery_bound(2)); // of all three reads
}

TEST_CASE("G28: when all nodes are absent, each is found again within the stated time") {
    for (const std::size_t returns : {std::size_t{0}, std::size_t{1}}) {
        for (std::uint32_t offset = 0; offset < 12; ++offset) {
            rig_of_stores<> r;
            r.all.run_for(milliseconds(500));
            r.wire.set_connected(0, false);
            r.wire.set_connected(1, false);
            r.all.run_for(milliseconds(2000 + 97 * offset));
            const auto node_address = static_cast<std::uint8_t>(returns + 1);
            REQUIRE(r.all.is_absent(node_address));
            r.wire.set_connected(returns, true);
            const std::uint64_t back = r.wire.time_us();
            while (r.all.is_absent(node_address) && r.wire.time_us() < back + 60'000'000)
                r.all.run_for(milliseconds(1));
            CHECK(r.wire.time_us() - back <= both_at_50_hz.rediscovery_bound().us);
        }
    }
}

TEST_CASE("G26: a stop without a confirmation is repeated until the drive confirms it") {
    rig r;
    REQUIRE(r.command(r.wheels, init{}));
    REQUIRE(r.command(r.wheels, zlac8015d::enable_in{zlac8015d::operating_mode::velocity}));
    REQUIRE(r.command(r.wheels, velocity{30 * r_per_min, 30 * r_per_min}));
    r.run(500);
    r.wire.set_connected(0, false);
    const command_status stopped = r.command(r.wheels, quick_stop{});
    CHECK(stopped.outcome() == outcome::unknown); // it ended at its time limit, like a blocking call (G29)
    CHECK(r.stops_in(3000) >= 5);
    CHECK(r.wheels_model.enabled());
    r.wire.set_connected(0, true);
    r.run(3000);
    CHECK_FALSE(r.wheels_model.left().speed != 0);
    CHECK(r.stops_in(2000) == 0); // confirmed: no further stops
}

TEST_CASE("G19, G26: stops that are repeated to an absent drive alternate with the reads") {
    rig r;
    REQUIRE(r.command(r.wheels, init{}));
    REQUIRE(r.command(r.lift, init{}));
    r.run(500);
    r.wire.set_connected(1, false);
    CHECK_FALSE(r.command(r.lift, halt{}));
    r.run(2000);
    const std::size_t seen = r.requests.size();
    r.run(10'000);
    std::uint64_t longest = 0;
    std::size_t stops = 0;
    std::uint64_t last_stop = 0;
    std::uint64_t last_to_wheels = 0;
    std::uint64_t longest_pause = 0;
    bool has_read = true;
    for (std::size_t i = seen; i < r.requests.size(); ++i) {
        const seen_frame& f = r.requests[i];
        if (f.data.size() < 8) break; // it is still leaving
        const bool is_to_wheels = f.data[0] == 1;
        if (is_to_wheels) {
            if (last_to_wheels != 0) longest = std::max(longest, f.begin - last_to_wheels);
            last_to_wheels = f.begin;
        }
        if (!is_to_wheels && f.data[1] == 0x06) {
            ++stops;
            CHECK(has_read);
            has_read = false;
            if (last_stop != 0) longest_pause = std::max(longest_pause, f.begin - last_stop);
            last_stop = f.begin;
        }
        has_read = has_read || f.data[1] == 0x03;
    }
    CHECK(stops > 20);
    CHECK(longest <= fast_plan.longest_gap(fast_plan.controlled[0]).us);
    CHECK(longest_pause <= fast_plan.longest_stop_pause().us);
}

namespace {
template <std::uint8_t Address> consteval auto status_of() {
    return cyclic<zlac8015d::status_word>(responds_within(node<wheels_device>{Address}, milliseconds(30)),
                                          milliseconds(100));
}
template <std::uint8_t Address> consteval auto controlled_wheels() {
    return controlled(responds_within(node<wheels_device>{Address}, milliseconds(30)), unsupervised);
}
inline constexpr poll_plan crowd{modbus::timing_at(115200),
                                 status_of<1>(),
                                 controlled_wheels<2>(),
                                 controlled_wheels<3>(),
                                 controlled_wheels<4>(),
                                 controlled_wheels<5>(),
                                 status_of<6>(),
                                 status_of<7>(),
                                 status_of<8>()};
} // namespace

TEST_CASE(
    "G19: when many facades repeat their stops, one of each goes between two reads, and each facade gets "
    "its share") {
    plain_store store;
    using station = sim::station<plain_store>;
    std::array<station, 8> stations{station{store, 1, 115200}, station{store, 2, 115200},
                                    station{store, 3, 115200}, station{store, 4, 115200},
                                    station{store, 5, 115200}, station{store, 6, 115200},
                                    station{store, 7, 115200}, station{store, 8, 115200}};
    sim::virtual_line wire{115200};
    for (station& s : stations) REQUIRE(wire.attach(s));
    using line_type = scheduled_line<sim::virtual_line, seen_requests>;
    line_type on{wire, crowd.timing()};
    zlac8015d::drive<line_type> two{on, responds_within(node<wheels_device>{2}, milliseconds(30)), by_plan},
        three{on, responds_within(node<wheels_device>{3}, milliseconds(30)), by_plan},
        four{on, responds_within(node<wheels_device>{4}, milliseconds(30)), by_plan},
        five{on, responds_within(node<wheels_device>{5}, milliseconds(30)), by_plan};
    auto all = make_bus<crowd>(on, two, three, four, five);
    all.run_for(milliseconds(500));
    on.observer() = {};
    for (std::size_t i = 1; i < stations.size(); ++i) wire.set_connected(i, false);
    for (auto* drive : {&two, &three, &four, &five}) REQUIRE(drive->begin(halt{}) == errc::ok);
    std::uint64_t last = 0;
    std::uint64_t longest = 0;
    while (wire.time_us() < 12'000'000) {
        const std::size_t before = on.observer().asked.size();
        const duration idle = all.step();
        if (on.observer().asked.size() != before && on.observer().asked.back().address == 1) {
            if (last != 0) longest = std::max(longest, wire.time_us() - last);
            last = wire.time_us();
        }
        wire.wait(idle.us == 0 ? microseconds(1) : idle);
    }
    CHECK(longest <= crowd.longest_gap(crowd.polls[0]).us);
    CHECK(longest > 500'000);
    const auto& asked = on.observer().asked;
    std::array<unsigned, 6> writes{};
    for (const auto& request : asked) {
        if (!request.is_read) ++writes[request.address];
    }
    for (const std::size_t node_address : {2u, 3u, 4u, 5u}) CHECK(writes[node_address] + 2 >= writes[2]);
    CHECK(writes[2] > 5);
}

TEST_CASE("a blocking command of one drive runs to its end while the bus continues its reads") {
    rig r;
    REQUIRE(r.all.run(r.wheels, init{}));
    REQUIRE(r.all.run(r.lift, init{}));
    const std::uint32_t before = r.all.count(0);
    r.all.run_for(milliseconds(1000));
    CHECK(r.all.count(0) - before >= 19);
    REQUIRE(r.all.run(r.lift, enable{}));
    const yako::arrival there = r.all.run(r.lift, move_by{2000 * pulse}, wait_reached{});
    CHECK(there.how == arrival_state::reached);
    CHECK(r.lift_model.view().position == 2000);
    CHECK(r.all.count(0) - before >= 25);
    REQUIRE(r.all.run(r.wheels, zlac8015d::enable_in{zlac8015d::operating_mode::relative_position}));
    const auto turned = r.all.run(r.wheels, move_by{4096 * pulse, -4096 * pulse}, wait_reached{});
    CHECK(turned.how == arrival_state::reached);
}

TEST_CASE("G28: a drive that refuses a read is present, and is read as often as any other") {
    rig_of_stores<> r;
    SUBCASE("always") {
        r.wheels_store.refuses_from = 0;
        r.all.run_for(milliseconds(3000));
        CHECK_FALSE(r.all.is_absent(1));
        const auto refused = r.all.latest<zlac8015d::left_actual_speed>(wheels_node, milliseconds(1000));
        CHECK(refused.error() == errc::exception);
        CHECK(refused.exception() == 2);
        CHECK(r.all.count(0) == 0);
        CHECK(r.wheels_store.asked >= 145);
    }
    SUBCASE("between timeouts, of which three in a row would make it absent") {
        r.wheels_store.refuses_from = 0;
        for (int i = 0; i < 20; ++i) {
            r.wire.set_connected(0, i % 2 == 0);
            const std::uint32_t asked = r.wire.requests();
            while (r.wire.requests() < asked + 4) r.all.run_for(milliseconds(1)); // two of each drive
            CHECK_FALSE(r.all.is_absent(1));
        }
        CHECK(r.wheels_store.asked > 10);
        r.wire.set_connected(0, false);
        r.all.run_for(milliseconds(1000));
        CHECK(r.all.is_absent(1));
    }
}

TEST_CASE("reads keep their rate on average, though the program's loop begins each one late") {
    for (const std::uint32_t loop_us : {1'000u, 2'000u, 3'000u}) {
        CAPTURE(loop_us);
        rig_of_stores<> r;
        r.all.run_for(milliseconds(500));
        const std::uint32_t before = r.all.count(0);
        const instant start = r.wire.now();
        for (std::uint32_t loops = 1; loops <= 10'000'000 / loop_us; ++loops) {
            r.all.step();
            const instant next = start + microseconds(loops * loop_us);
            while (went_back(next, r.wire.now())) r.wire.wait(since(r.wire.now(), next));
        }
        CHECK(r.all.count(0) - before >= 499); // one every 20 ms
        CHECK(r.all.count(0) - before <= 501);
    }
}

TEST_CASE("G28: a drive stays absent as long as it does not respond") {
    rig_of_stores<with_hasty_retries> r;
    r.wire.set_connected(0, false);
    r.all.run_for(milliseconds(500));
    REQUIRE(r.all.is_absent(1));
    for (int i = 0; i < 600; ++i) {
        r.all.run_for(milliseconds(80));
        REQUIRE(r.all.is_absent(1));
    }
    r.wire.set_connected(0, true);
    r.all.run_for(milliseconds(200));
    CHECK_FALSE(r.all.is_absent(1));
    CHECK(r.all.latest<zlac8015d::left_actual_speed>(wheels_node, milliseconds(100)));
}

TEST_CASE("a blocking command that is refused before it sends anything does not step the bus") {
    rig r;
    const command_status early = r.all.run(r.wheels, velocity{30 * r_per_min, 30 * r_per_min});
    CHECK(early.outcome() == outcome::not_sent);
    CHECK(early.error() == errc::needs_init);
    CHECK(r.wheels.last().error() == errc::needs_init);
    CHECK(r.wire.requests() == 0);
}

TEST_CASE("a bus makes at least 98 % of the reads that frames and gaps allow") {
    SUBCASE("9600 Bd") { CHECK(share_of_the_possible<busy_at_9600>(9600) >= 98); }
    SUBCASE("57600 Bd") { CHECK(share_of_the_possible<busy_at_57600>(57'600) >= 98); }
    SUBCASE("115200 Bd") { CHECK(share_of_the_possible<busy_at_115200>(115'200) >= 98); }
}

} // namespace bus_tests
