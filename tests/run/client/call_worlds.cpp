// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// One call in one world, by three players: blocking on a line, stepped on a line, blocking on a blocking line. In
// each of thousands of worlds the same responses are lost, damaged, cut, echoed or refused. The frames on the wire,
// the drive's registers, the outcome and the value must be the same for all; and a judge that sees the wire only
// says what no player may do.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <servobus/client/stepped_read.hpp>
#include <servobus/client/stepped_write.hpp>
#include <servobus/line/blocking_line.hpp>
#include <tests/support/line_and_client.hpp>

#include <tests/support/call_stage.hpp>

namespace call_worlds_tests {

using namespace servobus;
using namespace tests::calls;
using tests::byte_list;

namespace {

std::int64_t number(std::uint16_t value) { return value; }
template <class Q> std::int64_t number(const Q& value) { return value.count(); }

template <class Line> course play_blocking(const world& in) {
    stage<Line> s{in};
    auto& d = *s.drive;
    const auto read_end = [&](const auto& r) {
        return r ? s.end(r.status(), number(*r)) : s.end(r.status());
    };
    switch (in.what) {
    case call::read_one: return read_end(d.template read<fixture::light>());
    case call::read_pair: return read_end(d.template read<fixture::place>());
    case call::read_parts: {
        const auto all = d.template read<fixture::place, fixture::far_place>();
        if (!all) return s.end(all.status());
        return s.end(all.status(), number(all->template get<fixture::place>()) * 0x1'0000'0000 +
                                       number(all->template get<fixture::far_place>()));
    }
    case call::write_one: return s.end(d.template write<fixture::light>(5));
    case call::write_pair: return s.end(d.template write<fixture::place>(0x0001'0002 * units::pulse));
    case call::write_block:
        return s.end(d.template write<fixture::light, fixture::place>(5, 0x0001'0002 * units::pulse));
    case call::write_kept: return s.end(d.template write<fixture::kept>(5, *s.token));
    case call::write_address: return s.end(d.template write<fixture::address>(5));
    case call::write_delay: return s.end(d.template write<fixture::delay>(5, *s.token));
    case call::write_order: return s.end(d.template write<fixture::order>(0));
    case call::write_wear: return s.end(d.template write<fixture::wear>(0));
    default: return s.end(d.template write<fixture::wear>(0, *s.token));
    }
}

course play_stepped(const world& in) {
    using line_type = full_line<port_type>;
    using client_type = client<line_type, fixture::device>;
    stage<line_type> s{in};
    auto& d = *s.drive;
    const auto finish = [&](status begun, auto& c) {
        if (begun != errc::ok) return begun;
        if (in.learns_anew) s.learn_anew();
        for (int i = 0; i < 20'000 && !c.done(); ++i) {
            (void)c.step();
            s.port.time += 100;
        }
        REQUIRE(c.done());
        return c.status();
    };
    const auto read_end = [&](auto& c) {
        (void)finish(c.begin(), c);
        const auto r = c.value();
        return r ? s.end(r.status(), number(*r)) : s.end(r.status());
    };
    switch (in.what) {
    case call::read_one: {
        stepped_read<client_type, fixture::light> c{d};
        return read_end(c);
    }
    case call::read_pair: {
        stepped_read<client_type, fixture::place> c{d};
        return read_end(c);
    }
    case call::read_parts: {
        stepped_read<client_type, fixture::place, fixture::far_place> c{d};
        (void)finish(c.begin(), c);
        const auto all = c.value();
        if (!all) return s.end(all.status());
        return s.end(all.status(), number(all->template get<fixture::place>()) * 0x1'0000'0000 +
                                       number(all->template get<fixture::far_place>()));
    }
    case call::write_one: {
        stepped_write<client_type, fixture::light> c{d};
        return s.end(finish(c.begin(5), c));
    }
    case call::write_pair: {
        stepped_write<client_type, fixture::place> c{d};
        return s.end(finish(c.begin(0x0001'0002 * units::pulse), c));
    }
    case call::write_block: {
        stepped_write<client_type, fixture::light, fixture::place> c{d};
        return s.end(finish(c.begin(5, 0x0001'0002 * units::pulse), c));
    }
    case call::write_kept: {
        stepped_write<client_type, fixture::kept> c{d};
        return s.end(finish(c.begin(5, *s.token), c));
    }
    case call::write_address: {
        stepped_write<client_type, fixture::address> c{d};
        return s.end(finish(c.begin(5), c));
    }
    case call::write_delay: {
        stepped_write<client_type, fixture::delay> c{d};
        return s.end(finish(c.begin(5, *s.token), c));
    }
    case call::write_order: {
        stepped_write<client_type, fixture::order> c{d};
        return s.end(finish(c.begin(0), c));
    }
    case call::write_wear: {
        stepped_write<client_type, fixture::wear> c{d};
        return s.end(finish(c.begin(0), c));
    }
    default: {
        stepped_write<client_type, fixture::wear> c{d};
        return s.end(finish(c.begin(0, *s.token), c));
    }
    }
}

// True if a request that this fault hits gets a valid response, be it a refusal.
bool has_response(fault f) {
    return f == fault::none || f == fault::hurt || f == fault::refused || f == fault::accepted;
}
bool is_refusal(fault f) { return f == fault::hurt || f == fault::refused; }

// True if a client that has learned nothing of its node can make the call.
bool needs_nothing(call c) { return c == call::read_one || c == call::write_one || c == call::write_address; }

bool needs_token(call c) {
    return c == call::write_kept || c == call::write_delay || c == call::write_wear_by_token;
}

// Judges by the frames on the wire: a write leaves once, and not after a missing response, or a write of the switch,
// has made its token stale.
void judge(const world& in, const course& of) {
    unsigned writes = 0;
    bool is_void = false;
    bool may_be_set = false;
    for (std::size_t i = 0; i < of.frames.size(); ++i) {
        if (is_write(of.frames[i])) {
            ++writes;
            if (needs_token(in.what)) CHECK_FALSE(is_void);
        }
        const fault f = i < in.faults.size() ? in.faults[i] : fault::none;
        // The echo of a function 06 is its response once an echo is ruled out.
        is_void = is_void || !(has_response(f) || (f == fault::echoed && of.frames[i][1] == 0x06));
        may_be_set = may_be_set || (is_write(of.frames[i]) && !is_refusal(f));
    }
    // The switch, or the word order, may have been set: what was read of it before is not used any more.
    for (const byte_list& later : of.afterwards) {
        const bool has_order = later[1] == 0x10;
        if (has_order) CHECK_FALSE((may_be_set && in.what == call::write_order));
        if (!has_order) CHECK_FALSE((is_void || (may_be_set && in.what >= call::write_wear)));
    }
    CHECK(writes <= 1); // G15
    if (in.what <= call::read_parts) CHECK(of.frames.size() <= 2 * (in.retries + 1u));
    if (writes == 0 && in.what > call::read_parts) CHECK(of.how == outcome::not_sent);
    // The stated word order is not the device's: a value in it is the user's mistake, one in a mixture never.
    if (of.value && in.what == call::read_parts) {
        const bool is_learned = *of.value == 7 * 0x1'0000'0000 + 9;
        const bool is_stated =
            in.has_stated_order && *of.value == 7 * 0x1'0000ll * 0x1'0000'0000 + 9 * 0x1'0000;
        CHECK((is_learned || is_stated));
    }
}

world drawn(tests::dice& by) {
    world in;
    in.what = static_cast<call>(by.below(static_cast<std::uint32_t>(call::end)));
    for (fault& f : in.faults) {
        if (by.below(2) != 0) f = static_cast<fault>(by.below(static_cast<std::uint32_t>(fault::end)));
    }
    in.is_echo_possible = by.below(2) != 0;
    in.has_stated_order = by.below(2) != 0;
    in.learns_anew = !in.is_echo_possible && by.below(2) != 0; // a read rules out an echo
    in.retries = static_cast<std::uint8_t>(by.below(4));
    return in;
}

} // namespace

TEST_CASE("G15, G17, G18, G21: a blocking call and a stepped one are the same in every world") {
    tests::dice by{36};
    std::array<unsigned, static_cast<std::size_t>(fault::end)> played{};
    std::array<unsigned, static_cast<std::size_t>(call::end)> called{};
    unsigned refused_on_the_way = 0;
    unsigned mixed = 0;
    unsigned asked_first = 0; // on a blocking line
    for (int i = 0; i < 4000; ++i) {
        const world in = drawn(by);
        CAPTURE(i);
        CAPTURE(static_cast<int>(in.what));
        const course blocking = play_blocking<full_line<port_type>>(in);
        judge(in, blocking);
        REQUIRE(play_stepped(in) == blocking);
        for (std::size_t f = 0; f < played.size(); ++f) played[f] += blocking.played[f];
        ++called[static_cast<std::size_t>(in.what)];
        refused_on_the_way += blocking.error == errc::needs_init && !blocking.frames.empty();
        mixed += in.what == call::read_parts && blocking.error == errc::needs_word_order;
        if (!in.is_echo_possible || needs_nothing(in.what)) {
            course small = play_blocking<small_line<port_type>>(in);
            if (in.is_echo_possible)
                small.afterwards = blocking.afterwards; // a new client has learned nothing
            judge(in, small);
            REQUIRE(small == blocking);
            asked_first += in.is_echo_possible && in.what == call::write_address;
        }
    }
    for (const unsigned times : played) CHECK(times > 100);
    for (const unsigned times : called) CHECK(times > 100);
    CHECK(refused_on_the_way > 10); // the read that is to rule out an echo made the token void
    CHECK(asked_first > 100);
    CHECK(mixed > 10); // the word order changed between two parts
}

} // namespace call_worlds_tests
