// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a client refuses, and what it does when an exception reports a damaged request. Nothing that could go
// wrong is sent, and a call that fails leaves no value.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <vector>

#include <tests/support/line_and_client.hpp>

#include <tests/support/scripted_port.hpp>
#include <tests/support/worn_device.hpp>

namespace client_faults_tests {

using namespace servobus;
using tests::byte_list;
using tests::framed;

namespace {

namespace fixture {
using namespace servobus;

using device = tests::worn_device;
inline constexpr reg<u16, access::rw, device> kept{0x0200, {0, 1000}, no_unit, 0, saved_on_write};
inline constexpr reg<u16, access::rw, device> to_eeprom{0x0C0D, {0, 1}, no_unit, 1, saved_on_write};
inline constexpr reg<u16, access::rw, device> light{0x0300, {0, 1000}, no_unit, 0};
inline constexpr reg<i32, access::rw, device> place{0x0301, full<i32>, units::pulse, 0};
inline constexpr reg<u16, access::rw, device> lamp{0x0303, {0, 1000}, no_unit, 0};
inline constexpr reg<u16, access::ro, device> state{0x0320, full<u16>, no_unit, no_default};
inline constexpr reg<u16, access::rw, device> address{0x0400, {1, 99}, no_unit, 1, communication};
inline constexpr reg_array<reg<u16, access::rw, device>, 3> speeds{
    {0x0210, {0, 100}, no_unit, 0, saved_on_write}, 2};
inline constexpr reg_array<reg<u16, access::rw, device>, 3> gains{{0x0220, {0, 100}, no_unit, 0}, 2};
} // namespace fixture

struct rig {
    tests::waiting_scripted_port port;
    tests::register_file file;
    line<tests::waiting_scripted_port> on{port, modbus::timing_at(115200)};
    client<line<tests::waiting_scripted_port>, fixture::device> drive;
    bool is_mute = false;

    explicit rig(std::uint8_t node_address = 1) : drive{on, node<fixture::device>{node_address}} {
        for (const unsigned from : {0x0019u, 0x0200u, 0x0210u, 0x0220u, 0x0300u, 0x0320u, 0x0400u, 0x0C0Du}) {
            for (unsigned i = 0; i < 8; ++i) file.words[static_cast<std::uint16_t>(from + i)] = 0;
        }
        port.device = [this](tests::scripted_port& p, const tests::sent_frame& f) {
            if (!is_mute) file(p, f);
        };
    }
    rig(const rig&) = delete;
    std::size_t frames() const { return port.frames.size(); }
    /// The first `times` responses are this exception.
    void refuse(std::uint8_t number, unsigned times) {
        port.device = [this, number, times](tests::scripted_port& p, const tests::sent_frame& f) {
            if (frames() <= times) {
                p.say(500, tests::exception_response(1, f.data[1], number));
            } else {
                file(p, f);
            }
        };
    }
};

bool is_refused(const rig& r, std::size_t before, const status& w, errc why) {
    return w.outcome() == outcome::not_sent && w.error() == why && r.frames() == before;
}

} // namespace

TEST_CASE("G18: there is no valid token if the switch cannot be read or has another value") {
    rig r;
    r.is_mute = true;
    const auto silent = r.drive.ram_only();
    CHECK(silent.error() == errc::timeout);
    r.is_mute = false;
    CHECK(is_refused(r, r.frames(), r.drive.write<fixture::kept>(1, *silent), errc::needs_init));
    r.file.words.erase(0x0C0D);
    const auto refused = r.drive.ram_only();
    CHECK(refused.error() == errc::exception);
    CHECK(refused.exception() == 2);
    CHECK(is_refused(r, r.frames(), r.drive.write<fixture::kept>(1, *refused), errc::needs_init));
    for (const u16 kept : std::array<u16, 3>{1, 2, 0xFFFF}) {
        r.file.words[0x0C0D] = kept;
        const auto wears = r.drive.ram_only();
        CHECK(wears.error() == errc::wrong_state);
        CHECK(is_refused(r, r.frames(), r.drive.write<fixture::kept>(1, *wears), errc::needs_init));
    }
}

TEST_CASE("G18: an invalid token is also refused for an element of an array") {
    rig r;
    CHECK(is_refused(r, 0, r.drive.write<fixture::speeds>(1, 50, ram_only{}), errc::needs_init));
    const auto proof = r.drive.ram_only();
    REQUIRE(proof);
    CHECK(r.drive.write<fixture::speeds>(1, 50, *proof));
    CHECK(r.file.words[0x0212] == 50);
    CHECK(is_refused(r, r.frames(), r.drive.write<fixture::speeds>(3, 50, *proof), errc::bad_argument));
    CHECK(is_refused(r, r.frames(), r.drive.write<fixture::speeds>(1, checked(101), *proof),
                     errc::out_of_range));
    CHECK(r.drive.store<fixture::to_eeprom>(0));
    CHECK(is_refused(r, r.frames(), r.drive.write<fixture::speeds>(1, 50, *proof), errc::needs_init));
}

TEST_CASE("G18: a token that is invalid from the start stays so when the count of invalidations wraps") {
    rig r;
    r.file.delay = 0;
    const auto first = r.drive.ram_only();
    REQUIRE(first);
    for (unsigned i = 0; i < 65'534; ++i) {
        REQUIRE(r.drive.store<fixture::to_eeprom>(0));
        r.port.frames.clear();
    }
    // The next one wraps the count.
    CHECK(is_refused(r, 0, r.drive.write<fixture::kept>(1, ram_only{}), errc::needs_init));
    CHECK(is_refused(r, 0, r.drive.write<fixture::kept>(1, *first), errc::needs_init));
    CHECK(r.drive.write<fixture::kept>(1, *r.drive.ram_only()));
    REQUIRE(r.drive.store<fixture::to_eeprom>(0));
    r.port.frames.clear();
    CHECK(is_refused(r, 0, r.drive.write<fixture::kept>(1, ram_only{}), errc::needs_init));
}

TEST_CASE("a write of several values is not sent if one does not fit, or if its word order is unknown") {
    rig r;
    const auto write = [&](int a, int b) {
        return r.drive.write<fixture::light, fixture::place, fixture::lamp>(checked(a), 70'000, checked(b));
    };
    CHECK(is_refused(r, 0, write(1, 2), errc::needs_word_order));
    CHECK(is_refused(r, 0, write(1, 1001), errc::needs_word_order)); // the first error is reported
    CHECK(is_refused(r, 0, write(1001, 2), errc::out_of_range));
    CHECK(is_refused(r, 0, write(1001, 1002), errc::out_of_range));
    r.drive.node().word_order = word_order::low_first;
    CHECK(is_refused(r, 0, write(1, 1001), errc::out_of_range));
    CHECK(is_refused(r, 0, write(1001, 1002), errc::out_of_range));
    CHECK(write(1, 2));
    CHECK(r.port.frames.back().data ==
          framed({1, 0x10, 0x03, 0x00, 0, 4, 8, 0, 1, 0x11, 0x70, 0x00, 0x01, 0, 2}));
}

TEST_CASE("if the second of two requests fails, the values of the first are dropped too") {
    rig r;
    r.file.words[0x0300] = 77;
    r.file.words[0x0320] = 88;
    const auto good = r.drive.read<fixture::light, fixture::state>();
    REQUIRE(good);
    CHECK(good->get<fixture::light>() == 77);
    CHECK(r.frames() == 2);
    r.file.words.erase(0x0320);
    const auto bad = r.drive.read<fixture::light, fixture::state>();
    CHECK(bad.status() == status::sent(errc::exception, 2));
    CHECK(bad.value().get<fixture::light>() == 0);
    CHECK(bad.value().get<fixture::state>() == 0);
    CHECK(r.frames() == 4);
}

TEST_CASE("a read is repeated when the drive reports that the request was damaged; a write is not") {
    SUBCASE("once") {
        rig r;
        r.file.words[0x0300] = 77;
        r.refuse(1, 1);
        CHECK(r.drive.read<fixture::light>().value_or({}) == 77);
        CHECK(r.frames() == 2);
    }
    SUBCASE("always") {
        rig r;
        r.refuse(1, 100);
        CHECK(r.drive.read<fixture::light>().status() == status::sent(errc::exception, 1));
        CHECK(r.frames() == 3);
    }
    SUBCASE("another exception") {
        rig r;
        r.refuse(2, 100);
        CHECK(r.drive.read<fixture::light>().status() == status::sent(errc::exception, 2));
        CHECK(r.frames() == 1);
    }
    SUBCASE("a write") {
        rig r;
        r.refuse(1, 1);
        const status w = r.drive.write<fixture::light>(5);
        CHECK(w.outcome() == outcome::refused);
        CHECK(w.exception() == 1);
        CHECK(r.port.count_of(0x06) == 1);
    }
}

TEST_CASE("an error that is none of a port's is passed on, and nothing is tried again for it") {
    struct odd_port : tests::waiting_scripted_port {
        unsigned asked = 0;
        transfer receive(byte_buffer) {
            ++asked;
            return errc::preempted;
        }
    };
    odd_port port;
    line on{port, modbus::timing_at(115200)};
    client drive{on, node<fixture::device>{1}};
    CHECK(drive.read<fixture::light>().error() == errc::preempted);
    CHECK(port.asked == 1);
    CHECK(port.frames.empty());
}

TEST_CASE("G24, G3: an address is not changed on a line where the only response so far may be an echo") {
    rig r;
    r.is_mute = true;
    const status w = r.drive.write<fixture::address>(9);
    CHECK(w.outcome() == outcome::not_sent);
    CHECK(w.error() == errc::own_echo);
    CHECK(r.port.count_of(0x06) == 0);
    CHECK(r.port.count_of(0x03) == 3);
    r.is_mute = false;
    CHECK(r.drive.write<fixture::address>(9));
    CHECK(r.port.frames[3].data[1] == 0x03); // rules out an echo: the next response may be the last
    CHECK(r.port.frames[4].data == framed({1, 0x06, 0x04, 0x00, 0, 9}));
    CHECK(r.frames() == 5);
    CHECK(r.drive.write<fixture::address>(8));
    CHECK(r.frames() == 6);
}

TEST_CASE("G30: a broadcast does not depend on the node's own address") {
    rig r{100}; // an address that this kind of device cannot have
    CHECK(r.drive.write<fixture::light>(5).error() == errc::bad_argument);
    CHECK(r.frames() == 0);
    CHECK(r.drive.broadcast<fixture::light>(5).outcome() == outcome::done);
    CHECK(r.port.frames.back().data == framed({0, 0x06, 0x03, 0x00, 0, 5}));
    CHECK(r.frames() == 1);
    rig nobody{0}; // a client of address 0 is refused: a write would go to all
    CHECK(is_refused(nobody, 0, nobody.drive.write<fixture::light>(5), errc::bad_argument));
}

TEST_CASE("a broadcast is not sent if its value does not fit, or if the word order is unknown") {
    rig r;
    CHECK(is_refused(r, 0, r.drive.broadcast<fixture::light>(checked(1001)), errc::out_of_range));
    CHECK(is_refused(r, 0, r.drive.broadcast<fixture::place>(1), errc::needs_word_order));
}

TEST_CASE(
    "an element that does not exist, or a value that does not fit, is refused before anything is sent") {
    rig r;
    for (const std::size_t i : {std::size_t{3}, std::size_t{4}, ~std::size_t{0}}) {
        CHECK(is_refused(r, 0, r.drive.write<fixture::gains>(i, 1), errc::bad_argument));
        CHECK(is_refused(r, 0, r.drive.store<fixture::speeds>(i, 1), errc::bad_argument));
        CHECK(r.drive.read<fixture::gains>(i).error() == errc::bad_argument);
    }
    CHECK(is_refused(r, 0, r.drive.write<fixture::gains>(2, checked(101)), errc::out_of_range));
    CHECK(is_refused(r, 0, r.drive.store<fixture::speeds>(2, checked(-1)), errc::out_of_range));
    CHECK(r.drive.write<fixture::gains>(2, checked(100)));
    CHECK(r.file.words[0x0224] == 100);
    r.is_mute = true;
    CHECK(r.drive.read<fixture::gains>(2).error() == errc::timeout);
}

TEST_CASE(
    "G22: words that arrive after a timeout are not joined in the word order that was cached before it") {
    rig r;
    r.file.words[0x0301] = 1; // 65536, if its high word goes first
    int lost = 0; // this request gets no response: the drive restarted then, with its other word order
    int asked = 0;
    bool is_mute = false;
    r.port.device = [&](tests::scripted_port& p, const tests::sent_frame& f) {
        if (!is_mute && ++asked != lost) r.file(p, f);
    };
    const auto lose = [&](int which) {
        asked = 0;
        lost = which;
    };
    SUBCASE("a word order that was read from the drive must be read again") {
        REQUIRE(r.drive.learn_word_order().error() == errc::ok);
        REQUIRE(r.drive.read<fixture::place>()->count() == 65536);
        int requests = 2; // the lost one and its retry
        SUBCASE("a value") {
            lose(1);
            CHECK(r.drive.read<fixture::place>().error() == errc::needs_word_order);
        }
        SUBCASE("a block") {
            lose(1);
            const auto both = r.drive.read<fixture::light, fixture::place>();
            CHECK(both.error() == errc::needs_word_order);
            CHECK(both->get<fixture::place>().count() == 0);
        }
        SUBCASE("a block without any response") {
            lose(0);
            requests = 0;
            is_mute = true;
            const auto both = r.drive.read<fixture::light, fixture::place>();
            CHECK(both.error() == errc::timeout);
            CHECK(both->get<fixture::place>().count() == 0);
            is_mute = false;
        }
        SUBCASE("a block of two frames, of which the second was lost") {
            lose(2);
            requests = 3;
            const auto both = r.drive.read<fixture::place, fixture::state>();
            CHECK(both.error() == errc::needs_word_order);
            CHECK(both->get<fixture::place>().count() == 0);
        }
        SUBCASE("a write-if-different, which writes nothing") {
            lose(1);
            const status w =
                r.drive.write_if_different<fixture::place>(65536); // the value that it seems to have already
            CHECK(w.outcome() == outcome::not_sent);
            CHECK(w.error() == errc::needs_word_order);
            CHECK(r.port.count_of(0x10) == 0);
        }
        CHECK(asked == requests);
        CHECK(r.drive.read<fixture::place>().error() == errc::needs_word_order);
        CHECK(asked == requests); // nothing is sent while it is unknown
        lose(1);
        CHECK(r.drive.read<fixture::light, fixture::lamp>()); // no 32-bit value
        REQUIRE(r.drive.learn_word_order().error() == errc::ok);
        CHECK(r.drive.read<fixture::light, fixture::place>()->get<fixture::place>().count() == 65536);
    }
    SUBCASE("a word order that the program has set stays valid") {
        node<fixture::device> stated{1};
        stated.word_order = word_order::low_first;
        client drive{r.on, stated};
        lose(1);
        CHECK(drive.read<fixture::place>()->count() == 1);
        lose(1);
        CHECK(drive.read<fixture::light, fixture::place>()->get<fixture::place>().count() == 1);
        lose(1);
        CHECK(drive.write_if_different<fixture::place>(5));
        CHECK(r.port.count_of(0x10) == 1);
    }
}

} // namespace client_faults_tests
