// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Calls for rows of all four tables, and functions 16h and 17h, on a line with random faults, blocking and stepped,
// with calls that are given up. Each fact of the device changes before each call, so an older response shows as a wrong
// value. The judge sees the wire and the model of the device, and nothing of the library but what the calls return.
#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <map>

#include <servobus/any_device.hpp>
#include <servobus/line/blocking_line.hpp>
#include <tests/support/line_and_client.hpp>

#include <tests/support/tank.hpp>

namespace table_worlds_tests {

using namespace servobus;
namespace tank = tests::tank;
using tests::byte_list;
using tests::dice;
using tests::framed;
using tests::low_byte;
using tests::scripted_port;
using tests::sent_frame;
using tests::operator+;

namespace {
constexpr modbus::rtu_timing timing = modbus::timing_at(115200);

struct any_line {
    using line = servobus::line<tests::waiting_scripted_port>;
    static line on(tests::waiting_scripted_port& port) { return line{port, timing}; }
};
struct small_line {
    using line = blocking_line<tests::waiting_scripted_port, timing>;
    static line on(tests::waiting_scripted_port& port) { return line{port}; }
};

struct tcp_port : tests::waiting_scripted_port {
    static constexpr bool has_gateway = true;
};

bool is_write(const sent_frame& f) { return f.data.size() > 1 && f.data[1] >= 5; }

template <class Kind> struct world {
    tests::waiting_scripted_port port;
    tests::plain_tables model = tank::model();
    typename Kind::line on = Kind::on(port);
    client<typename Kind::line, tank::device> io{on, node<tank::device>{1}};
    dice random;
    unsigned faults = 0; // in sixteenths of the requests

    explicit world(std::uint64_t seed) : random{seed} {
        port.device = [this](scripted_port& p, const sent_frame& f) { respond(p, f); };
    }
    world(const world&) = delete;

    void respond(scripted_port& p, const sent_frame& f) {
        const unsigned fault = random.below(16) < faults ? 1 + random.below(10) : 0;
        if (fault == 1) return; // the request is lost
        const byte_list& q = f.data;
        if (q.size() < 4 || q[0] != 1 || framed({q.begin(), q.end() - 2}) != q) return;
        byte_list r = framed(byte_list{1} + model.answer({q.begin() + 1, q.end() - 2}));
        const auto at = [&] { return random.below(static_cast<std::uint32_t>(r.size())); };
        switch (fault) {
        case 2: return; // the response is lost
        case 3: {       // a damaged bit
            std::uint8_t& byte = r[at()];
            byte = low_byte(byte ^ 1u << random.below(8));
            break;
        }
        case 4: r.resize(at()); break; // cut
        case 5: r = r + r; break;      // twice without a gap
        case 6:                        // and once more, before the gap that the next request needs is over
            p.say(500 + 96 * r.size() + random.below(1500), r);
            return p.say(500, r);
        case 7: return p.say(101'000 + random.below(90'000), r); // late
        case 8:
            p.say(300, framed({2, q[1], 2, random.byte(), random.byte()})); // another node's
            return p.say(4000, r);
        case 9: { // noise in its place
            byte_list noise(1 + random.below(40));
            for (std::uint8_t& byte : noise) byte = random.byte();
            return p.say(500, noise);
        }
        case 10: r = r + byte_list(1 + random.below(3)); break; // zeros after it
        default: break;
        }
        if (!r.empty()) p.say(200 + random.below(3000), r);
    }
    void change_facts() {
        for (auto* table : {&model.coils, &model.discrete_inputs})
            for (auto& [address, is_on] : *table) is_on = random.below(2) != 0;
        for (auto* table : {&model.holding_registers, &model.input_registers})
            for (auto& [address, word] : *table) word = random.below(0x10000);
        port.frames.clear();
    }
    unsigned pair(std::map<unsigned, unsigned>& of, unsigned at) { return of[at] * 0x10000u + of[at + 1]; }

    std::size_t writes() const {
        std::size_t n = 0;
        for (const sent_frame& f : port.frames) n += is_write(f);
        return n;
    }
    // `is_done`: the device has what was written.
    void judge_write(status why, bool is_done) {
        CHECK(writes() <= 1);
        if (why) CHECK((is_done && writes() == 1));
        if (!why.was_sent()) CHECK(writes() == 0);
        CHECK(why.error() != errc::bad_argument);
        if (faults == 0) CHECK(why);
    }
    template <class Result> bool judge_read(const Result& seen) {
        if (faults == 0) CHECK(seen);
        CHECK(seen.error() != errc::bad_argument);
        return seen.error() == errc::ok;
    }
    template <class Result> void judge_inputs(const Result& seen) {
        if (!judge_read(seen)) return;
        CHECK(seen->template get<tank::level>() == model.input_registers[0]);
        CHECK(seen->template get<tank::volume>() == pair(model.input_registers, 2));
        CHECK(seen->template get<tank::valve>() == model.coils[3]);
        CHECK(seen->template get<tank::heater>() == model.coils[5]);
        CHECK(seen->template get<tank::is_door_open>() == model.discrete_inputs[9]);
        CHECK(static_cast<unsigned>(seen->template get<tank::target>()) == pair(model.holding_registers, 4));
    }
    template <class Result> void judge_both(const Result& seen, unsigned state) {
        judge_write(seen.error() == errc::ok ? status::sent(errc::ok) : seen.status(),
                    model.holding_registers[4] == 0 && model.holding_registers[5] == 77);
        if (seen) {
            CHECK(seen->template get<tank::target>() == 77);
            CHECK(seen->template get<tank::state>() == state);
        }
    }
};

template <class Kind> void call(world<Kind>& w, unsigned which) {
    auto& io = w.io;
    auto& m = w.model;
    const bool is_on = w.random.below(2) != 0;
    const unsigned before = m.holding_registers[0];
    switch (which) {
    case 0:
        return w.judge_inputs(io.template read<tank::level, tank::volume, tank::valve, tank::heater,
                                               tank::is_door_open, tank::target>());
    case 1: {
        const auto seen = io.template read<tank::lamp>();
        if (w.judge_read(seen)) CHECK(*seen == m.coils[0x10]);
        return;
    }
    case 2: {
        const status why = io.template write<tank::pump>(is_on);
        return w.judge_write(why, m.coils[4] == is_on);
    }
    case 3: {
        const status why = io.template write<tank::valve, tank::pump, tank::heater>(is_on, !is_on, is_on);
        return w.judge_write(why, m.coils[3] == is_on && m.coils[4] != is_on && m.coils[5] == is_on);
    }
    case 4: {
        const status why = io.template change_bits<tank::options, 0x0FF0>(0x0AB0);
        return w.judge_write(why, m.holding_registers[0] == ((before & 0xF00Fu) | 0x0AB0u));
    }
    default: {
        const auto seen = io.template write_then_read<rows<tank::target, tank::state>, tank::target>(raw(77));
        return w.judge_both(seen, m.holding_registers[6]);
    }
    }
}
constexpr unsigned calls = 6;

// Steps a call to its end, or gives it up on the way: by `cancel`, or as it is destroyed.
template <class W, class Call> bool steps(W& w, Call& call, bool gives_up) {
    const unsigned most = gives_up ? w.random.below(60) : 100'000;
    for (unsigned i = 0; i < most && !call.done(); ++i) {
        (void)call.step();
        w.port.time += 100;
    }
    if (call.done()) return true;
    CHECK(gives_up);
    return false;
}
template <class W, class Call, class Judge> void judge_stepped(W& w, Call& call, bool gives_up, Judge judge) {
    if (steps(w, call, gives_up)) return judge();
    call.cancel();
    CHECK(!call.status());
    CHECK(call.status().was_sent() == (w.writes() != 0));
    CHECK(w.writes() <= 1);
}
} // namespace

#define WORLDS_ON_EACH_LINE any_line, small_line

TEST_CASE_TEMPLATE("G2, G16, G32: random faults make no wrong value and no second write, on any table", Kind,
                   WORLDS_ON_EACH_LINE) {
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        CAPTURE(seed);
        world<Kind> w{seed};
        for (unsigned i = 0; i < 40; ++i) {
            CAPTURE(i);
            w.faults = i % 3 == 0 ? 0 : 8;
            w.change_facts();
            call(w, w.random.below(calls));
        }
        CHECK(!w.port.ran_away);
    }
}

TEST_CASE("G2, G16, G33: the same stepped, and with calls that are given up at any step") {
    using io_type = decltype(world<any_line>::io);
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        CAPTURE(seed);
        world<any_line> w{seed};
        auto& m = w.model;
        for (unsigned i = 0; i < 40; ++i) {
            CAPTURE(i);
            w.faults = i % 3 == 0 ? 0 : 8;
            const bool gives_up = w.random.below(3) == 0;
            if (gives_up) w.faults = 8;
            w.change_facts();
            const bool is_on = w.random.below(2) != 0;
            const unsigned before = m.holding_registers[0];
            switch (w.random.below(calls)) {
            case 0: {
                stepped_read<io_type, tank::level, tank::volume, tank::valve, tank::heater,
                             tank::is_door_open, tank::target>
                    read{w.io};
                REQUIRE(read.begin() == errc::ok);
                if (steps(w, read, gives_up)) w.judge_inputs(read.value());
                break;
            }
            case 1: {
                stepped_read<io_type, tank::lamp> read{w.io};
                REQUIRE(read.begin() == errc::ok);
                if (!steps(w, read, gives_up)) break;
                const auto seen = read.value();
                if (w.judge_read(seen)) CHECK(*seen == m.coils[0x10]);
                break;
            }
            case 2: {
                stepped_write<io_type, tank::pump> write{w.io};
                REQUIRE(write.begin(is_on) == errc::ok);
                judge_stepped(w, write, gives_up,
                              [&] { w.judge_write(write.status(), m.coils[4] == is_on); });
                break;
            }
            case 3: {
                stepped_write<io_type, tank::valve, tank::pump, tank::heater> write{w.io};
                REQUIRE(write.begin(is_on, !is_on, is_on) == errc::ok);
                judge_stepped(w, write, gives_up, [&] {
                    w.judge_write(write.status(),
                                  m.coils[3] == is_on && m.coils[4] != is_on && m.coils[5] == is_on);
                });
                break;
            }
            case 4: {
                stepped_change_bits<io_type, tank::options, 0x0FF0> change{w.io};
                REQUIRE(change.begin(0x0AB0) == errc::ok);
                judge_stepped(w, change, gives_up, [&] {
                    w.judge_write(change.status(), m.holding_registers[0] == ((before & 0xF00Fu) | 0x0AB0u));
                });
                break;
            }
            default: {
                stepped_write_then_read<io_type, rows<tank::target, tank::state>, tank::target> both{w.io};
                REQUIRE(both.begin(raw(77)) == errc::ok);
                judge_stepped(w, both, gives_up, [&] { w.judge_both(both.value(), m.holding_registers[6]); });
            }
            }
        }
        CHECK(!w.port.ran_away);
    }
}

TEST_CASE_TEMPLATE("G38: a gateway that responds in the node's place has not written, nor read", Kind,
                   any_line, small_line) {
    for (const std::uint8_t number : {std::uint8_t{0x0A}, std::uint8_t{0x0B}}) {
        CAPTURE(unsigned{number});
        world<Kind> w{1};
        w.io.node().limits.has_gateway = true;
        w.port.device = [number](scripted_port& p, const sent_frame& f) {
            p.say(500, tests::exception_response(1, f.data[1], number));
        };
        for (unsigned which = 0; which < calls; ++which) {
            CAPTURE(which);
            w.port.frames.clear();
            status why;
            if (which == 0) why = w.io.template read<tank::valve, tank::level>().status();
            if (which == 1) why = w.io.template read<tank::is_full>().status();
            if (which == 2) why = w.io.template write<tank::pump>(true);
            if (which == 3) why = w.io.template write<tank::valve, tank::pump>(true, true);
            if (which == 4) why = w.io.template change_bits<tank::options, 1>(1);
            if (which == 5)
                why = w.io.template write_then_read<rows<tank::state>, tank::target>(raw(1)).status();
            CHECK(why.error() == errc::gateway_exception);
            CHECK(why.exception() == number);
            CHECK(!why.has_response());
            CHECK(w.writes() == (which < 2 ? 0 : 1));
            CHECK(!w.on.is_echo_ruled_out());
        }
    }
}

TEST_CASE_TEMPLATE("G38: a broadcast of a coil that a gateway refuses is not done", Kind, any_line,
                   small_line) {
    tcp_port port;
    const auto judge = [&](auto& on) {
        client io{on, node<tank::device>{1}};
        CHECK(io.template broadcast<tank::reset>(true)); // no refusal
        port.device = [](scripted_port& p, const sent_frame& f) {
            p.say(500, tests::exception_response(0, f.data[1], 4));
        };
        CHECK(io.template broadcast<tank::reset>(true).error() == errc::gateway_exception);
        CHECK(port.frames.size() == 2);
    };
    if constexpr (Kind::line::is_small) {
        blocking_line<tcp_port, timing> on{port};
        judge(on);
    } else {
        line<tcp_port> on{port, timing};
        judge(on);
    }
}

} // namespace table_worlds_tests
