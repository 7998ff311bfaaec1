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
#include <map>
#include <optional>
#include <vector>

#include <servobus/client/stepped_read.hpp>
#include <servobus/client/stepped_write.hpp>
#include <servobus/line/blocking_line.hpp>
#include <servobus/servobus.hpp>

#include <tests/support/scripted_port.hpp>
#include <tests/support/worn_device.hpp>

namespace call_worlds_tests {

using namespace servobus;
using tests::byte_list;
using tests::scripted_port;

namespace {

namespace fixture {
using namespace servobus;

using device = tests::worn_device;
template <class T> using rw = reg<T, access::rw, device>;
inline constexpr rw<u16> light{0x0300, {0, 1000}, no_unit, 0};
inline constexpr rw<i32> place{0x0301, full<i32>, units::pulse, 0};
inline constexpr rw<i32> far_place{0x0501, full<i32>, units::pulse, 0};
inline constexpr rw<u16> kept{0x0200, {0, 1000}, no_unit, 0, saved_on_write};
inline constexpr rw<u16> address{0x0400, {1, 99}, no_unit, 1, communication};
inline constexpr rw<u16> delay{0x0402, {0, 99}, no_unit, 1, saved_on_write | communication};
inline constexpr rw<u16> order{0x0019, {0, 1}, no_unit, 0};
inline constexpr rw<u16> wear{0x0C0D, {0, 1}, no_unit, 1};
} // namespace fixture

enum class fault : std::uint8_t {
    none,
    request_lost,
    response_lost,
    damaged,
    cut,
    echoed, // the request comes back, and no response
    hurt,   // exception 1: the device says that it received a damaged request
    refused,
    accepted, // exception 5: the device goes on with it and has not finished
    end
};

enum class call : std::uint8_t {
    read_one,
    read_pair,
    read_parts, // two requests, each with a value of two words
    write_one,
    write_pair,
    write_block,
    write_kept, // with a token
    write_address,
    write_delay, // a setting of the line that is kept: with a token
    write_order,
    write_wear,
    end
};

struct world {
    call what = call::read_one;
    std::array<fault, 4> faults{}; // of the requests of the call, in their order
    bool is_echo_possible = false;
    bool has_stated_order = false; // the node was made with another one than the device has
    bool learns_anew = false;      // a stepped call waits, and meanwhile word order and token are read again
    std::uint8_t retries = 2;
};

// The course of a call, as seen from outside.
struct course {
    std::vector<byte_list> frames;     // of the call
    std::vector<byte_list> afterwards; // writes after it, by the word order and the token of before its end
    std::map<std::uint16_t, std::uint16_t> words;
    errc error = errc::ok;
    outcome how = outcome::not_sent;
    std::optional<std::int64_t> value;
    std::array<unsigned, static_cast<std::size_t>(fault::end)> played{};
    bool operator==(const course&) const = default;
};

bool is_write(const byte_list& frame) { return frame[1] != 0x03; }

template <class Port> using full_line = line<Port>;
template <class Port> using small_line = blocking_line<Port, modbus::timing_at(115200)>;
using port_type = tests::waiting_scripted_port;

template <class Line> struct stage {
    port_type port;
    tests::register_file file;
    std::optional<Line> on;
    std::optional<client<Line, fixture::device>> drive;
    course seen;
    std::optional<ram_only> token;
    const world& in;
    std::size_t asked = 0;
    bool is_on = false;

    explicit stage(const world& of) : in{of} {
        for (const unsigned from : {0x0019u, 0x0200u, 0x0300u, 0x0400u, 0x0500u, 0x0C0Du}) {
            for (unsigned i = 0; i < 8; ++i) file.words[static_cast<std::uint16_t>(from + i)] = 0;
        }
        file.words[0x0019] = 1; // low word first
        file.words[0x0301] = 7;
        file.words[0x0501] = 9;
        file.words[0x0400] = 1;
        port.device = [this](scripted_port& p, const tests::sent_frame& f) { respond(p, f); };
        begin_line();
        node<fixture::device> at{1};
        at.read_retries = in.retries;
        if (in.has_stated_order) at.word_order = word_order::high_first;
        drive.emplace(*on, at);
        REQUIRE(drive->learn_word_order()); // rules out an echo, too
        const auto now = drive->ram_only();
        REQUIRE(now);
        token = *now;
        if (in.is_echo_possible) {
            if constexpr (Line::is_small) {
                begin_line(); // such a line never forgets
                drive.emplace(*on, at);
            } else {
                REQUIRE(on->retime(modbus::timing_at(115200)) == errc::ok);
            }
        }
        port.frames.clear();
        is_on = true;
    }
    stage(const stage&) = delete;

    void begin_line() {
        if constexpr (Line::is_small)
            on.emplace(port);
        else
            on.emplace(port, modbus::timing_at(115200));
    }

    void respond(scripted_port& p, const tests::sent_frame& f) {
        const fault now = is_on && asked < in.faults.size() ? in.faults[asked++] : fault::none;
        if (is_on) ++seen.played[static_cast<std::size_t>(now)];
        if (now == fault::request_lost) return;
        if (now == fault::echoed) return p.say(500, f.data);
        if (now == fault::hurt || now == fault::refused)
            return p.say(500, tests::exception_response(1, f.data[1], now == fault::hurt ? 1 : 4));
        byte_list said = file.response_to(f.data);
        if (now == fault::accepted) return p.say(500, tests::exception_response(1, f.data[1], 5));
        if (now == fault::response_lost) return;
        if (now == fault::damaged) said[said.size() - 3] ^= 0x10;
        if (now == fault::cut) said.resize(said.size() - 2);
        p.say(500, said);
    }

    course end(const status& how, std::optional<std::int64_t> value = {}) {
        seen.error = how.error();
        seen.how = how.outcome();
        seen.value = value;
        for (const auto& f : port.frames) seen.frames.push_back(f.data);
        seen.words = file.words;
        is_on = false;
        port.frames.clear();
        (void)drive->template write<fixture::kept>(6, *token);
        (void)drive->template write<fixture::place>(3 * units::pulse);
        for (const auto& f : port.frames) {
            if (is_write(f.data)) seen.afterwards.push_back(f.data);
        }
        return seen;
    }
    // While a stepped call waits for its turn.
    void learn_anew() {
        is_on = false;
        const auto before = port.frames;
        if (drive->learn_word_order()) {
            if (const auto now = drive->ram_only()) token = *now;
        }
        port.frames = before;
        is_on = true;
    }
};

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
    default: return s.end(d.template write<fixture::wear>(0));
    }
}

course play_stepped(const world& in) {
    using line_type = full_line<port_type>;
    using client_type = client<line_type, fixture::device>;
    stage<line_type> s{in};
    auto& d = *s.drive;
    const auto finish = [&](errc begun, auto& c) {
        if (begun != errc::ok) return status{begun};
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
    default: {
        stepped_write<client_type, fixture::wear> c{d};
        return s.end(finish(c.begin(0), c));
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

bool needs_token(call c) { return c == call::write_kept || c == call::write_delay; }

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
        if (!has_order) CHECK_FALSE((is_void || (may_be_set && in.what == call::write_wear)));
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
