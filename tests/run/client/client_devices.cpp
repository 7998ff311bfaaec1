// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a device's profile changes for its client: a family's registers at its variants, a word order that is
// read and never guessed (G22), and writes that wear an EEPROM (G17, G18).
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <type_traits>

#include <servobus/client/stepped_write.hpp>
#include <tests/support/line_and_client.hpp>

#include <tests/support/scripted_port.hpp>

namespace client_devices_tests {

using namespace servobus;
using tests::byte_list;
using tests::framed;

namespace {

namespace fixture {
using namespace servobus;

struct family {
    static constexpr profile facts{
        .name = "family", .word_order = word_order::unknown, .word_order_register = 0x0019};
};
struct large : family {
    static constexpr profile facts{
        .name = "large", .max_read = 4, .word_order = word_order::unknown, .word_order_register = 0x0019};
};
struct small : family {
    static constexpr profile facts{.name = "small",
                                   .word_order = word_order::unknown,
                                   .word_order_register = 0x0019,
                                   .eeprom_switch = 0x0C0D};
};

inline constexpr reg<u16, access::rw, family> shared{0x0100, {0, 100}, no_unit, 0};
inline constexpr reg<i32, access::rw, family> place{0x0102, full<i32>, units::pulse, 0};
inline constexpr reg<u16, access::rw, large> own{0x0101, {0, 100}, no_unit, 0};

inline constexpr reg<u16, access::rw, small> kept{0x0200, {0, 1000}, no_unit, 0, saved_on_write};
inline constexpr reg<u16, access::rw, small> kept_too{0x0201, {0, 1000}, no_unit, 0, saved_on_write};
inline constexpr reg<u16, access::rw, small> to_eeprom{0x0C0D, {0, 1}, no_unit, 1, saved_on_write};
inline constexpr reg<u16, access::rw, small> to_eeprom_unflagged{0x0C0D, {0, 1}, no_unit, 1};
inline constexpr reg<u16, access::rw, small> light{0x0300, {0, 1000}, no_unit, 0};
inline constexpr reg_array<reg<u16, access::rw, small>, 3> speeds{
    {0x0210, {0, 100}, no_unit, 0, saved_on_write}, 2};
} // namespace fixture

template <class Device> struct rig {
    tests::waiting_scripted_port port;
    tests::register_file file;
    line<tests::waiting_scripted_port> on{port, modbus::timing_at(115200)};
    client<line<tests::waiting_scripted_port>, Device> drive;
    bool is_mute = false;

    explicit rig(const node<Device>& at = node<Device>{1}) : drive{on, at} {
        for (const unsigned from : {0x0018u, 0x0100u, 0x0200u, 0x0210u, 0x0300u, 0x0C0Du}) {
            for (unsigned i = 0; i < 8; ++i) file.words[static_cast<std::uint16_t>(from + i)] = 0;
        }
        port.device = [this](tests::scripted_port& p, const tests::sent_frame& f) {
            if (!is_mute) file(p, f);
        };
    }
    rig(const rig&) = delete;
    std::size_t frames() const { return port.frames.size(); }
    byte_list last() const { return port.frames.back().data; }
};

static_assert(fixture::family::facts.word_order_register == fixture::large::facts.word_order_register);
static_assert(belongs_to<fixture::family, fixture::large> && belongs_to<fixture::large, fixture::large>);
static_assert(!belongs_to<fixture::large, fixture::family> && !belongs_to<fixture::large, fixture::small>);
// The variant's limits apply, whichever of its family's rows comes first.
static_assert(std::is_same_v<detail::same_device<fixture::shared, fixture::own>::device, fixture::large>);
static_assert(std::is_same_v<detail::same_device<fixture::own, fixture::shared>::device, fixture::large>);
static_assert(!detail::same_device<fixture::own, fixture::shared, fixture::kept>::value);

} // namespace

TEST_CASE("a variant has the registers of its family, alone and in one frame with its own") {
    rig<fixture::large> r;
    r.file.words[0x0100] = 7;
    r.file.words[0x0101] = 8;
    CHECK(*r.drive.read<fixture::shared>() == 7);
    const auto both = r.drive.read<fixture::own, fixture::shared>();
    REQUIRE(both);
    CHECK(both->get<fixture::shared>() == 7);
    CHECK(both->get<fixture::own>() == 8);
    CHECK(r.last() == framed({1, 3, 0x01, 0x00, 0, 2}));
    CHECK(r.drive.write<fixture::shared, fixture::own>(1, 2));
    CHECK(r.file.words[0x0101] == 2);
}

TEST_CASE(
    "G22: a switchable word order is read from the drive, and no 32-bit value is read or written before") {
    rig<fixture::large> r;
    r.file.words[0x0102] = 0x0001;
    r.file.words[0x0103] = 0x86A0;
    CHECK(r.drive.read<fixture::place>().error() == errc::needs_word_order);
    CHECK(r.drive.write<fixture::place>(5).error() == errc::needs_word_order);
    CHECK(r.frames() == 0);
    CHECK(r.drive.learn_word_order().error() == errc::ok);
    CHECK(r.last() == framed({1, 3, 0x00, 0x19, 0, 1}));
    CHECK(r.drive.read<fixture::place>()->count() == 100'000);
    r.file.words[0x0019] = 1;
    CHECK(r.drive.learn_word_order().error() == errc::ok);
    CHECK(r.drive.read<fixture::place>()->count() == static_cast<std::int32_t>(0x86A0'0001));
    SUBCASE("a value that the manual does not list leaves it unknown") {
        r.file.words[0x0019] = 2;
        CHECK(r.drive.learn_word_order().error() == errc::unexpected_value);
    }
    SUBCASE("a timeout leaves it unknown") {
        r.is_mute = true;
        CHECK(r.drive.learn_word_order().error() == errc::timeout);
    }
    if (r.file.words[0x0019] == 2 || r.is_mute) {
        r.is_mute = false;
        CHECK(r.drive.read<fixture::place>().error() == errc::needs_word_order);
    }
}

TEST_CASE("G21, S6: a timeout, an unknown outcome or a write of its register invalidates the word order") {
    rig<fixture::large> r;
    REQUIRE(r.drive.learn_word_order().error() == errc::ok);
    REQUIRE(r.drive.read<fixture::place>());
    SUBCASE("a read without a response") {
        r.is_mute = true;
        CHECK(r.drive.read<fixture::shared>().error() == errc::timeout);
    }
    SUBCASE("a write without a response") {
        r.is_mute = true;
        CHECK(r.drive.write<fixture::shared>(5).outcome() == outcome::unknown);
    }
    SUBCASE("a lost port") {
        r.port.lost_from_call = 1;
        CHECK(r.drive.read<fixture::shared>().error() == errc::port_lost);
        r.port.lost_from_call = 0;
    }
    SUBCASE("its register is written") { CHECK(r.drive.write_word(0x0019, 1)); }
    SUBCASE("its register is written among others") {
        const std::array<u16, 3> words{0, 1, 0};
        CHECK(r.drive.write_words(0x0018, words));
    }
    SUBCASE("its register is written by a PDU of the program") {
        std::array<std::uint8_t, 5> response{};
        CHECK(r.drive.transact(std::array<std::uint8_t, 5>{6, 0x00, 0x19, 0, 1}, response));
    }
    SUBCASE("a PDU of the program gets no response") {
        r.is_mute = true;
        std::array<std::uint8_t, 4> response{};
        CHECK(r.drive.transact(std::array<std::uint8_t, 5>{3, 0x01, 0x00, 0, 1}, response).error() ==
              errc::timeout);
    }
    r.is_mute = false;
    const std::size_t frames = r.frames();
    CHECK(r.drive.write<fixture::place>(5).error() == errc::needs_word_order);
    CHECK(r.drive.read<fixture::place>().error() == errc::needs_word_order);
    CHECK(r.frames() == frames);
    REQUIRE(r.drive.learn_word_order().error() == errc::ok);
    CHECK(r.drive.read<fixture::place>());
}

TEST_CASE("G22: a word order that the program has set stays valid after a timeout, but not after a write of "
          "its register") {
    node<fixture::large> at{1};
    at.word_order = word_order::low_first;
    rig<fixture::large> r{at};
    REQUIRE(r.drive.read<fixture::place>());
    r.is_mute = true;
    CHECK(r.drive.read<fixture::shared>().error() == errc::timeout);
    r.is_mute = false;
    CHECK(r.drive.node().word_order == word_order::low_first);
    CHECK(r.drive.write_word(0x0018, 1)); // the registers next to it do not matter
    CHECK(r.drive.write_word(0x001A, 1));
    CHECK(r.drive.node().word_order == word_order::low_first);
    std::array<std::uint8_t, 4> response{};
    CHECK(r.drive.transact(std::array<std::uint8_t, 5>{3, 0x01, 0x00, 0, 1}, response));
    CHECK(r.drive.node().word_order == word_order::low_first);
    r.port.lost_from_call = 1; // nothing is sent
    std::array<std::uint8_t, 5> echoed{};
    const status unsent = r.drive.transact(std::array<std::uint8_t, 5>{6, 0x00, 0x19, 0, 1}, echoed);
    CHECK(unsent == errc::port_lost);
    CHECK(unsent.outcome() == outcome::not_sent);
    r.port.lost_from_call = 0;
    CHECK(r.drive.node().word_order == word_order::low_first);
    CHECK(r.drive.write_word(0x0019, 0));
    CHECK(r.drive.node().word_order == word_order::unknown);
}

TEST_CASE("G22: a write of its register by one client invalidates the word order that another one learned") {
    rig<fixture::large> r;
    client other{r.on, node<fixture::large>{1}};
    REQUIRE(r.drive.learn_word_order().error() == errc::ok);
    REQUIRE(other.learn_word_order().error() == errc::ok);
    SUBCASE("blocking") { CHECK(other.write_word(0x0019, 1)); }
    SUBCASE("by a PDU of the program") {
        std::array<std::uint8_t, 5> response{};
        CHECK(other.transact(std::array<std::uint8_t, 5>{6, 0x00, 0x19, 0, 1}, response));
    }
    SUBCASE("stepped, after the order was learned again") {
        stepped_write_words<decltype(other), 1> put{other};
        REQUIRE(put.begin(0x0019, u16{1}) == errc::ok);
        REQUIRE(r.drive.learn_word_order().error() == errc::ok);
        while (!put.done()) r.port.wait(put.step());
        CHECK(put.status());
    }
    REQUIRE(r.file.words[0x0019] == 1);
    const std::size_t before = r.frames();
    CHECK(r.drive.read<fixture::place>().error() == errc::needs_word_order);
    CHECK(r.drive.write<fixture::place>(5).error() == errc::needs_word_order);
    CHECK(r.frames() == before);
    REQUIRE(r.drive.learn_word_order().error() == errc::ok);
    CHECK(r.drive.node().word_order == word_order::low_first);
    CHECK(r.drive.read<fixture::place>());
}

TEST_CASE("G22: a word order that the program sets after a timeout is not taken for the one before it") {
    rig<fixture::large> r;
    REQUIRE(r.drive.learn_word_order().error() == errc::ok);
    r.is_mute = true;
    CHECK(r.drive.read<fixture::shared>().error() == errc::timeout);
    r.is_mute = false;
    r.drive.node().word_order = word_order::low_first;
    CHECK(r.drive.read<fixture::place>());
    CHECK(r.drive.node().word_order == word_order::low_first);
}

TEST_CASE("G18: a PDU of the program that may write invalidates a `ram_only` token") {
    rig<fixture::small> r;
    const auto proof = r.drive.ram_only();
    REQUIRE(proof);
    std::array<std::uint8_t, 5> response{};
    const std::array<std::uint8_t, 5> switches_on{6, 0x0C, 0x0D, 0, 1};
    SUBCASE("that was done") { CHECK(r.drive.transact(switches_on, response)); }
    SUBCASE("that the drive has accepted and goes on with (exception 5)") {
        r.port.device = [&](tests::scripted_port& p, const tests::sent_frame& f) {
            p.say(500, tests::exception_response(1, f.data[1], 5));
        };
        CHECK(r.drive.transact(switches_on, response).outcome() == outcome::unknown);
    }
    const std::size_t before = r.frames();
    CHECK(r.drive.write<fixture::kept>(5, *proof).error() == errc::needs_init);
    CHECK(r.frames() == before);
}

TEST_CASE("G17: a register that wears the EEPROM is stored by name, or written with a `ram_only` token") {
    rig<fixture::small> r;
    CHECK(r.drive.read<fixture::light>());
    CHECK(r.drive.store<fixture::kept>(5));
    CHECK(r.last() == framed({1, 6, 0x02, 0x00, 0, 5}));
    CHECK(r.drive.store<fixture::kept, fixture::kept_too>(6, 7));
    CHECK(r.drive.store<fixture::speeds>(2, 9));
    CHECK(r.file.words[0x0214] == 9);
    CHECK(r.drive.write<fixture::light>(5)); // not kept in the EEPROM: needs no token

    r.file.words[0x0C0D] = 1;
    CHECK(r.drive.ram_only().error() == errc::wrong_state);
    r.file.words[0x0C0D] = 0;
    const auto proof = r.drive.ram_only();
    REQUIRE(proof);
    CHECK(r.last() == framed({1, 3, 0x0C, 0x0D, 0, 1}));
    const std::size_t before = r.frames();
    CHECK(r.drive.write<fixture::kept>(77, *proof));
    CHECK(r.drive.write<fixture::speeds>(1, 50, *proof));
    CHECK(r.frames() == before + 2);
    CHECK(r.file.words[0x0200] == 77);
    CHECK(r.file.words[0x0212] == 50);
}

TEST_CASE("G18: a `ram_only` token is invalid from the start, after a lost response, and after a write of "
          "the switch") {
    rig<fixture::small> r;
    const auto refused = [&](ram_only with) {
        const std::size_t before = r.frames();
        const status w = r.drive.write<fixture::kept>(1, with);
        return w.outcome() == outcome::not_sent && w.error() == errc::needs_init && r.frames() == before;
    };
    CHECK(refused({}));
    const auto first = r.drive.ram_only();
    REQUIRE(first);
    CHECK_FALSE(refused(*first));
    int asked = 0;
    SUBCASE("a lost response to a write") {
        r.is_mute = true;
        CHECK(r.drive.write<fixture::light>(1).outcome() == outcome::unknown);
        r.is_mute = false;
    }
    SUBCASE("a read whose first response was lost, and whose second arrived") {
        r.port.device = [&](tests::scripted_port& p, const tests::sent_frame& f) {
            if (++asked > 1) r.file(p, f);
        };
        CHECK(r.drive.read<fixture::light>());
    }
    SUBCASE("a write of the switch") { CHECK(r.drive.store<fixture::to_eeprom>(1)); }
    SUBCASE("a write of the switch by its address") { CHECK(r.drive.write_word(0x0C0D, 1)); }
    SUBCASE("a write of the switch inside a block") {
        const u16 words[] = {0, 0, 1};
        r.file.words[0x0C0B] = r.file.words[0x0C0C] = 0;
        CHECK(r.drive.write_words(0x0C0B, words));
    }
    CHECK(refused(*first));
    r.file.words[0x0C0D] = 0;
    const auto second = r.drive.ram_only();
    REQUIRE(second);
    CHECK_FALSE(refused(*second));
    CHECK(refused(*first)); // the old one stays invalid
}

TEST_CASE("G18: a token that was read from another node is refused") {
    rig<fixture::small> r;
    const auto proof = r.drive.ram_only();
    REQUIRE(proof);
    client other{r.on, node<fixture::small>{2}};
    const std::size_t before = r.frames();
    CHECK(other.write<fixture::kept>(1, *proof) == errc::needs_init);
    CHECK(r.frames() == before);
    CHECK(r.drive.write<fixture::kept>(1, *proof));
}

TEST_CASE(
    "G18: a broadcast of the switch invalidates the token of every node, and no number of them makes it "
    "valid again") {
    rig<fixture::small> r;
    client other{r.on, node<fixture::small>{2}};
    const auto proof = r.drive.ram_only();
    REQUIRE(proof);
    for (int i = 0; i < 600; ++i) { // more than a byte counts, twice
        REQUIRE(other.broadcast<fixture::to_eeprom_unflagged>(0));
        const std::size_t before = r.frames();
        REQUIRE(r.drive.write<fixture::kept>(1, *proof) == errc::needs_init);
        REQUIRE(r.frames() == before);
    }
}

TEST_CASE(
    "G18, G21: on a blocking line, too, a missed response of one client invalidates what another learned") {
    rig<fixture::small> r;
    blocking_line<tests::waiting_scripted_port, modbus::timing_at(115200)> on{r.port};
    client drive{on, node<fixture::small>{1}};
    client other{on, node<fixture::small>{1}};
    REQUIRE(drive.learn_word_order().error() == errc::ok);
    const auto proof = drive.ram_only();
    REQUIRE(proof);
    REQUIRE(drive.read<fixture::place>());
    CHECK(drive.write<fixture::kept>(1, *proof));
    SUBCASE("a read") {
        r.is_mute = true;
        CHECK(other.read<fixture::light>().error() == errc::timeout);
    }
    SUBCASE("a lost port, however often it is tried") {
        for (int tries = 0; tries < 256; ++tries) { // as many as a byte counts
            r.port.lost_from_call = r.port.calls + 1;
            CHECK(other.read<fixture::light>().error() == errc::port_lost);
        }
        r.port.lost_from_call = 0;
    }
    r.is_mute = false;
    const std::size_t before = r.frames();
    CHECK(drive.write<fixture::kept>(1, *proof) == errc::needs_init);
    CHECK(drive.read<fixture::place>().error() == errc::needs_word_order);
    CHECK(r.frames() == before);
}

TEST_CASE("G18: an exception from the drive does not invalidate a token") {
    rig<fixture::small> r;
    const auto proof = r.drive.ram_only();
    REQUIRE(proof);
    r.file.words.erase(0x0300);
    CHECK(r.drive.read<fixture::light>().error() == errc::exception);
    CHECK(r.drive.write<fixture::kept>(1, *proof).outcome() == outcome::done);
}

TEST_CASE("G17, G18, G21: a request without a response invalidates what was read of a drive, whichever "
          "program sent it") {
    rig<fixture::small> r;
    REQUIRE(r.drive.learn_word_order().error() == errc::ok);
    const auto proof = r.drive.ram_only();
    REQUIRE(proof);
    REQUIRE(r.drive.read<fixture::place>());
    client other{r.on, node<fixture::small>{1}};
    const response_limits limits;
    const byte_list read_one = framed({1, 3, 0x03, 0x00, 0, 1});
    std::array<std::uint8_t, 8> room{};
    modbus::exchange x{read_one, room, r.on.timing(), limits};
    const auto step_until = [&](modbus::exchange::phase wanted) {
        while (x.state() != wanted) r.port.wait(r.on.step(x, {}));
    };
    r.is_mute = true;
    SUBCASE("another client of the drive, by a read") {
        CHECK(other.read<fixture::light>().error() == errc::timeout);
    }
    SUBCASE("another client of the drive, by a write") {
        CHECK(other.write<fixture::light>(1).outcome() == outcome::unknown);
    }
    SUBCASE("another client of the drive, whose second attempt got a response") {
        int asked = 0;
        r.port.device = [&, asked](tests::scripted_port& p, const tests::sent_frame& f) mutable {
            if (++asked > 1) r.file(p, f);
        };
        CHECK(other.read<fixture::light>());
    }
    SUBCASE("a damaged response") {
        r.port.device = [](tests::scripted_port& p, const tests::sent_frame&) {
            p.say(500, {1, 3, 2, 0, 0, 0x12, 0x34});
        };
        r.on.run(x, {});
        CHECK(x.status().error() == errc::bad_crc);
    }
    SUBCASE("a stepped exchange, like that of a bus") { step_until(modbus::exchange::phase::done); }
    SUBCASE("an exchange that is abandoned") {
        step_until(modbus::exchange::phase::awaiting);
        r.on.abandon(x);
    }
    SUBCASE("an exchange that is not stepped any more") {
        step_until(modbus::exchange::phase::awaiting);
        r.port.time += 1'000'000;
    }
    r.is_mute = false;
    r.port.device = [&](tests::scripted_port& p, const tests::sent_frame& f) { r.file(p, f); };
    const std::size_t before = r.frames();
    CHECK(r.drive.write<fixture::kept>(1, *proof).error() == errc::needs_init);
    CHECK(r.drive.read<fixture::place>().error() == errc::needs_word_order);
    CHECK(r.drive.write<fixture::place>(5).error() == errc::needs_word_order);
    CHECK(r.frames() == before);
    REQUIRE(r.drive.learn_word_order().error() == errc::ok);
    CHECK(r.drive.read<fixture::place>());
    const auto fresh = r.drive.ram_only();
    REQUIRE(fresh);
    CHECK(r.drive.write<fixture::kept>(1, *fresh));
    CHECK(r.drive.write<fixture::kept>(2, *fresh));
}

TEST_CASE(
    "G18, G21: a word order or a token that was read at the second attempt, after a timeout, is valid") {
    rig<fixture::small> r;
    int asked = 0;
    r.port.device = [&](tests::scripted_port& p, const tests::sent_frame& f) {
        if (++asked % 2 == 0) r.file(p, f);
    };
    REQUIRE(r.drive.learn_word_order().error() == errc::ok);
    CHECK(r.drive.node().word_order == word_order::high_first);
    const auto proof = r.drive.ram_only();
    REQUIRE(proof);
    r.port.device = [&](tests::scripted_port& p, const tests::sent_frame& f) { r.file(p, f); };
    CHECK(r.drive.write<fixture::kept>(1, *proof));
    CHECK(r.drive.read<fixture::place>().error() ==
          errc::needs_word_order); // by the timeout of the token's read
}

TEST_CASE("G18, G21: the timeout of another drive, an exception, a broadcast and a request not sent "
          "invalidate nothing") {
    rig<fixture::small> r;
    REQUIRE(r.drive.learn_word_order().error() == errc::ok);
    const auto proof = r.drive.ram_only();
    REQUIRE(proof);
    client same{r.on, node<fixture::small>{1}};
    SUBCASE("another drive") {
        client other{r.on, node<fixture::small>{2}};
        CHECK(other.read<fixture::light>().error() == errc::timeout);
    }
    SUBCASE("an exception") {
        r.file.words.erase(0x0300);
        CHECK(same.read<fixture::light>().error() == errc::exception);
    }
    SUBCASE("a broadcast") { CHECK(same.broadcast<fixture::light>(1)); }
    SUBCASE("a request that was not sent") {
        r.port.noisy_until = r.port.time + 1'000'000;
        CHECK(same.read<fixture::light>().error() == errc::line_busy);
    }
    r.port.noisy_until = 0;
    CHECK(r.drive.read<fixture::place>());
    CHECK(r.drive.write<fixture::kept>(1, *proof));
}

TEST_CASE("G17: a write-if-different sends nothing if the register already has the value") {
    rig<fixture::small> r;
    r.file.words[0x0200] = 5;
    CHECK(r.drive.store_if_different<fixture::kept>(5).outcome() == outcome::done);
    CHECK(r.frames() == 1); // the read
    CHECK(r.drive.store_if_different<fixture::kept>(6));
    CHECK(r.frames() == 3);
    CHECK(r.file.words[0x0200] == 6);
    CHECK(r.drive.write_if_different<fixture::light>(checked(4000)).error() == errc::out_of_range);
    CHECK(r.frames() == 3);
    r.is_mute = true;
    const status w = r.drive.write_if_different<fixture::light>(1);
    CHECK(w.outcome() == outcome::not_sent); // only reads were sent
    CHECK(w.error() == errc::timeout);
}

TEST_CASE("G17: both words of a value are compared before it is written, in either word order") {
    for (const word_order order : {word_order::high_first, word_order::low_first}) {
        rig<fixture::large> r;
        r.drive.node().word_order = order;
        const auto hold = [&](u16 high, u16 low) {
            r.file.words[order == word_order::high_first ? 0x0102 : 0x0103] = high;
            r.file.words[order == word_order::high_first ? 0x0103 : 0x0102] = low;
            r.port.frames.clear();
        };
        const auto writes = [&](i32 value) {
            CHECK(r.drive.write_if_different<fixture::place>(checked(value)).outcome() == outcome::done);
            CHECK(r.port.count_of(0x03) == 1);
            return r.port.count_of(0x10);
        };
        hold(0x0001, 0x2345);
        CHECK(writes(0x0001'2345) == 0);
        for (const i32 other : {0x0002'2345, 0x0001'2346, -0x7FFE'DCBB, 0x2345'0001}) {
            CAPTURE(other);
            hold(0x0001, 0x2345);
            CHECK(writes(other) == 1);
            r.port.frames.clear();
            CHECK(writes(other) == 0); // it has that value now
        }
    }
}

TEST_CASE("a node that responds promptly keeps all but its limit and its quarantine") {
    node<fixture::large> at{7};
    at.read_retries = 1;
    at.gaps.gap = milliseconds(3);
    const auto soon = responds_within(at, milliseconds(30));
    CHECK(soon.address == 7);
    CHECK(soon.read_retries == 1);
    CHECK(soon.limits.response == milliseconds(30));
    CHECK(soon.gaps.quarantine == milliseconds(40));
    CHECK(soon.gaps.gap == at.gaps.gap);
    CHECK(soon.limits.corrupted_request == at.limits.corrupted_request);
    CHECK(responds_within(at, milliseconds(8)).gaps.quarantine == milliseconds(18));
    at.gaps.gap = milliseconds(50);
    CHECK(responds_within(at, milliseconds(30)).gaps.quarantine == milliseconds(50));
}

} // namespace client_devices_tests
