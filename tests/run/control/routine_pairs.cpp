// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Steps with constants and bits of 32-bit rows, of devices of both word orders: the frames on the wire, and what the
// steps take for a match.
#include <doctest/doctest.h>

#include <cstdint>
#include <vector>

#include <servobus/servobus.hpp>

#include <tests/support/bare_drive.hpp>
#include <tests/support/scripted_port.hpp>

namespace {
// Devices of a program: outside the library's namespace, and without its names.
namespace crane {

using servobus::access, servobus::i32, servobus::u16, servobus::u32, servobus::step;
namespace steps = servobus::steps;

template <servobus::word_order Order> struct device {
    static constexpr servobus::profile facts{.name = "crane", .word_order = Order};
};
template <servobus::word_order Order> struct rows {
    template <class T> using rw = servobus::reg<T, access::rw, device<Order>>;
    static constexpr rw<i32> place{0x0100, servobus::full<i32>, servobus::no_unit, 0};
    static constexpr rw<i32> speed{0x0102, servobus::full<i32>, servobus::no_unit, 0, servobus::motion};
    static constexpr rw<u32> state{0x0104, servobus::full<u32>, servobus::no_unit, 0};
};
using high = rows<servobus::word_order::high_first>;
using low = rows<servobus::word_order::low_first>;
using open = rows<servobus::word_order::unknown>; // the drive can switch it

} // namespace crane
} // namespace

// 0 and 10000h stop it; their low words are equal, and so is that of 20000h, which starts it.
template <>
inline constexpr auto servobus::stop_words<crane::high::speed> = servobus::words_that_stop(0, 0x1'0000);

namespace routine_pairs_tests {

using namespace servobus;
using tests::byte_list;
using tests::sent_frame;

namespace {

static_assert(sizeof(step) == 12);
static_assert(stop_words<crane::high::speed>.contains(0x1'0000));
static_assert(!stop_words<crane::high::speed>.contains(0x2'0000));
static_assert(steps::repeatable(steps::write<crane::high::speed>(0x1'0000)).is_repeatable);

struct rig {
    tests::waiting_scripted_port port;
    tests::register_file file;
    using line_type = line<tests::waiting_scripted_port>;
    line_type on{port, modbus::timing_at(115200)};
    bare::drive<line_type> drive;

    template <class Device> explicit rig(Device) : drive{on, node<Device>{1}} {
        for (std::uint16_t a = 0x0100; a < 0x0120; ++a) file.words[a] = 0;
        port.device = [this](tests::scripted_port& at, const sent_frame& f) { file(at, f); };
        static constexpr step look[] = {steps::fetch<crane::high::state>()};
        REQUIRE(drive.run(bare::command{.steps = look})); // no response is an echo after it
        port.frames.clear();
    }
    rig(const rig&) = delete;

    void hold(std::uint16_t address, std::uint16_t first, std::uint16_t second) {
        file.words[address] = first;
        file.words[static_cast<std::uint16_t>(address + 1)] = second;
    }
    errc run(routine table) {
        port.frames.clear();
        return drive.run(bare::command{.steps = table}).error();
    }
    /// The only frame of the last routine, without its address and CRC.
    byte_list sent() const {
        REQUIRE(port.frames.size() == 1);
        const byte_list& all = port.frames[0].data;
        return {all.begin() + 1, all.end() - 2};
    }
    /// The address and the count of the last read.
    std::uint32_t asked() const {
        const byte_list& f = port.frames.back().data;
        REQUIRE(f[1] == 0x03);
        return (f[2] * 256u + f[3]) * 0x1'0000u + f[4] * 256u + f[5];
    }
};

template <const auto& R, std::int64_t Value> inline constexpr step put[] = {steps::write<R>(Value)};
template <const auto& R, std::int64_t Value>
inline constexpr step want[] = {steps::expect<R>(Value, errc::wrong_state)};
template <const auto& R, std::uint32_t Mask, std::uint32_t Value>
inline constexpr step bits[] = {steps::expect_bits<R>(Mask, Value, errc::wrong_state)};
template <const auto& R, std::uint32_t Mask, std::uint32_t Value>
inline constexpr step until[] = {steps::until_bits<R>(Mask, Value, 20)};

} // namespace

TEST_CASE("a constant of a 32-bit row is sent as a pair in the word order of the device") {
    rig h{crane::device<word_order::high_first>{}};
    CHECK(h.run(put<crane::high::place, 1>) == errc::ok);
    CHECK(h.sent() == byte_list{0x10, 0x01, 0x00, 0, 2, 4, 0x00, 0x00, 0x00, 0x01});
    CHECK(h.run(put<crane::high::place, 0x1234'5678>) == errc::ok);
    CHECK(h.sent() == byte_list{0x10, 0x01, 0x00, 0, 2, 4, 0x12, 0x34, 0x56, 0x78});
    CHECK(h.run(put<crane::high::place, -2>) == errc::ok);
    CHECK(h.sent() == byte_list{0x10, 0x01, 0x00, 0, 2, 4, 0xFF, 0xFF, 0xFF, 0xFE});
    CHECK(h.run(put<crane::high::place, -1>) == errc::ok);
    CHECK(h.sent() == byte_list{0x10, 0x01, 0x00, 0, 2, 4, 0xFF, 0xFF, 0xFF, 0xFF});
    CHECK(h.run(put<crane::high::speed, 0xFFFF>) == errc::ok);
    CHECK(h.sent() == byte_list{0x10, 0x01, 0x02, 0, 2, 4, 0x00, 0x00, 0xFF, 0xFF});
    rig l{crane::device<word_order::low_first>{}};
    CHECK(l.run(put<crane::low::place, 1>) == errc::ok);
    CHECK(l.sent() == byte_list{0x10, 0x01, 0x00, 0, 2, 4, 0x00, 0x01, 0x00, 0x00});
    CHECK(l.run(put<crane::low::place, 0x1234'5678>) == errc::ok);
    CHECK(l.sent() == byte_list{0x10, 0x01, 0x00, 0, 2, 4, 0x56, 0x78, 0x12, 0x34});
}

TEST_CASE("two equal words need no word order") {
    rig r{crane::device<word_order::unknown>{}};
    CHECK(r.run(put<crane::open::place, 0>) == errc::ok);
    CHECK(r.sent() == byte_list{0x10, 0x01, 0x00, 0, 2, 4, 0, 0, 0, 0});
    CHECK(r.run(put<crane::open::place, 0x0102'0102>) == errc::ok);
    CHECK(r.sent() == byte_list{0x10, 0x01, 0x00, 0, 2, 4, 1, 2, 1, 2});
    CHECK(r.run(want<crane::open::place, 0x0102'0102>) == errc::ok);
    CHECK(r.run(want<crane::open::place, 0>) == errc::wrong_state);
    CHECK(r.run(bits<crane::open::state, 0xFFFF'FFFF, 0>) == errc::ok);
    r.hold(0x0104, 0, 1);
    CHECK(r.run(bits<crane::open::state, 0xFFFF'FFFF, 0>) == errc::wrong_state);
    r.hold(0x0104, 1, 0);
    CHECK(r.run(bits<crane::open::state, 0xFFFF'FFFF, 0>) == errc::wrong_state);
}

TEST_CASE("an expected constant of a 32-bit row is compared with both words") {
    rig h{crane::device<word_order::high_first>{}};
    rig l{crane::device<word_order::low_first>{}};
    const auto both = [&](std::uint16_t first, std::uint16_t second) {
        h.hold(0x0100, first, second);
        l.hold(0x0100, second, first);
        const errc found = h.run(want<crane::high::place, 0x2'0001>);
        CHECK(h.asked() == 0x0100'0002u);
        CHECK(l.run(want<crane::low::place, 0x2'0001>) == found);
        CHECK(l.asked() == 0x0100'0002u);
        return found;
    };
    CHECK(both(2, 1) == errc::ok);
    CHECK(both(1, 2) == errc::wrong_state);
    CHECK(both(1, 1) == errc::wrong_state);
    CHECK(both(2, 2) == errc::wrong_state);
    CHECK(both(0, 1) == errc::wrong_state);
    CHECK(both(2, 0) == errc::wrong_state);
}

TEST_CASE("bits of a 32-bit row are read in the word that has them") {
    rig h{crane::device<word_order::high_first>{}};
    rig l{crane::device<word_order::low_first>{}};
    h.hold(0x0104, 0x0080, 0x0001);
    l.hold(0x0104, 0x0001, 0x0080);
    CHECK(h.run(bits<crane::high::state, 0x0080'0000, 0x0080'0000>) == errc::ok);
    CHECK(h.asked() == 0x0104'0001u);
    CHECK(l.run(bits<crane::low::state, 0x0080'0000, 0x0080'0000>) == errc::ok);
    CHECK(l.asked() == 0x0105'0001u);
    CHECK(h.run(bits<crane::high::state, 0x0003, 0x0001>) == errc::ok);
    CHECK(h.asked() == 0x0105'0001u);
    CHECK(l.run(bits<crane::low::state, 0x0003, 0x0001>) == errc::ok);
    CHECK(l.asked() == 0x0104'0001u);
    CHECK(h.run(bits<crane::high::state, 0x0080'0000, 0>) == errc::wrong_state);
    CHECK(l.run(bits<crane::low::state, 0x0080'0000, 0>) == errc::wrong_state);
    CHECK(h.run(bits<crane::high::state, 0x0002, 0x0002>) == errc::wrong_state);
    CHECK(l.run(bits<crane::low::state, 0x0002, 0x0002>) == errc::wrong_state);
}

TEST_CASE("a wait for bits of a 32-bit row ends by its limit if only the other word has them") {
    rig h{crane::device<word_order::high_first>{}};
    h.hold(0x0104, 0x0000, 0x8000);
    CHECK(h.run(until<crane::high::state, 0x8000'0000, 0x8000'0000>) == errc::not_reached);
    CHECK(h.port.frames.size() > 1);
    h.hold(0x0104, 0x8000, 0x0000);
    CHECK(h.run(until<crane::high::state, 0x8000'0000, 0x8000'0000>) == errc::ok);
    CHECK(h.port.frames.size() == 1);
    CHECK(h.run(until<crane::high::state, 0xFFFF'FFFF, 0>) == errc::not_reached);
    h.hold(0x0104, 0, 0);
    CHECK(h.run(until<crane::high::state, 0xFFFF'FFFF, 0>) == errc::ok);
}

TEST_CASE("G26: a stop that is a pair is repeated as it was sent") {
    static constexpr step stop[] = {steps::repeatable(steps::write<crane::high::speed>(0x1'0000))};
    rig r{crane::device<word_order::high_first>{}};
    unsigned mute = 2;
    r.port.device = [&](tests::scripted_port& at, const sent_frame& f) {
        if (mute == 0) return r.file(at, f);
        --mute;
    };
    CHECK(r.drive.run(bare::command{.steps = stop, .stop = stop_priority::halt}).error() == errc::ok);
    REQUIRE(r.port.frames.size() == 3);
    for (const sent_frame& f : r.port.frames)
        CHECK(byte_list{f.data.begin() + 1, f.data.end() - 2} ==
              byte_list{0x10, 0x01, 0x02, 0, 2, 4, 0x00, 0x01, 0x00, 0x00});
}

} // namespace routine_pairs_tests
