// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Bad input that a line does not refuse yet: each of these tests fails.
#include <doctest/doctest.h>

#include <servobus/line/line.hpp>

#include <tests/support/client_rig.hpp>
#include <tests/support/line_rig.hpp>

using namespace servobus;
using namespace tests::whole_line;
using tests::byte_list, tests::scripted_port;

namespace {

struct odd : scripted_port {
    std::size_t takes_in_all = 1000; ///< bytes, and then none
    bool is_never_empty = false;     ///< once a request has left
    bool says_sent_early = false;    ///< `sent` is true while the request leaves

    transfer send(bytes out) {
        const transfer took = scripted_port::send(out.size() < takes_in_all ? out : out.first(takes_in_all));
        if (took) takes_in_all -= *took;
        return took;
    }
    bool sent() { return scripted_port::sent() || says_sent_early; }
    transfer receive(byte_buffer in) {
        const transfer came = scripted_port::receive(in);
        if (!is_never_empty || frames.empty() || time < frames.back().end || ran_away) return came;
        in[0] = 0x55;
        return std::uint16_t{1};
    }
};

} // namespace

TEST_CASE("G29: a port that takes some bytes of a request and then no more ends the call of a line in time") {
    rig<odd> r;
    r.settle();
    r.port.most_calls = 4'000'000;
    r.port.takes_in_all = 3;
    const std::uint64_t begun = r.port.time;
    CHECK(r.run(write_one).why == status::sent(errc::partial_send));
    CHECK(r.port.time - begun <= r.bound(write_one, 8) + 200);
}

TEST_CASE("G29: a port that is never empty once a request has left ends the call of a line in time") {
    rig<odd> r;
    r.settle();
    r.port.most_calls = 4'000'000;
    r.port.is_never_empty = true;
    const std::uint64_t begun = r.port.time;
    CHECK(r.run(read_one).why == status::sent(errc::timeout));
    CHECK(r.port.time - begun <= r.bound(read_one, 7) + 200);
}

TEST_CASE("G15: an exchange that is copied while it is under way is sent once, though both are stepped") {
    for (const int begun : {1, 20, 26}) { // it waits for its gap, or leaves
        CAPTURE(begun);
        rig<odd> r;
        r.settle();
        r.port.takes_at_most = 1;
        r.port.device = answering(3000);
        byte_list room(8);
        exchange x{write_one, room, r.on.timing(), r.limits};
        for (int i = 0; i < begun; ++i, r.port.time += 100) r.on.step(x, r.gaps);
        exchange copy = x;
        for (int i = 0; i < 10'000; ++i, r.port.time += 100) {
            r.on.step(x, r.gaps);
            r.on.step(copy, r.gaps);
        }
        CHECK(r.port.bytes_sent() == 8);
    }
}

TEST_CASE("G15: an exchange that has begun on one line is not sent by another one") {
    rig<odd> a, b;
    a.settle();
    b.settle();
    byte_list room(8), other_room(7);
    exchange x{write_one, room, a.on.timing(), a.limits};
    exchange other{read_one, other_room, b.on.timing(), b.limits};
    while (!x.was_sent()) a.on.step(x, a.gaps);
    b.on.step(other, b.gaps); // has the number on its line that `x` has on the other one
    for (int i = 0; i < 10'000; ++i, b.port.time += 100) {
        b.on.step(x, b.gaps);
        b.on.step(other, b.gaps);
    }
    CHECK(b.port.count_of(6) == 0);
}

TEST_CASE("G1: a frame that was whole before the request can have left is no response, also if the port says "
          "too early that all has left") {
    rig<odd> r;
    r.settle();
    r.port.says_sent_early = true;
    r.port.device = [](scripted_port& p, const tests::sent_frame& f) {
        p.say_at(f.begin - 6 * 96, tests::read_response(1, {0xDEAD}));
    };
    CHECK(r.run(read_one).why.error() != errc::ok);
}

TEST_CASE("G32: a raw read with a function code that writes is refused") {
    tests::typed::rig<> r;
    std::array<u16, 3> words{};
    CHECK(r.drive.read_words(0x0100, words, modbus::function::write_single_register) == errc::bad_argument);
    CHECK(r.port.frames.empty());
    CHECK(r.file.words[0x0100] == 0);
}
