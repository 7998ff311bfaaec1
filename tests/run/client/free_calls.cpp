// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The free functions for a client's calls: they send the same frames and refuse the same as the members.
#include <doctest/doctest.h>

#include <cstdint>
#include <utility>
#include <vector>

#include <servobus/client/free_calls.hpp>
#include <tests/support/line_and_client.hpp>

#include <tests/support/scripted_port.hpp>

namespace free_calls_tests {

using namespace servobus;
using tests::byte_list;

namespace {

namespace fixture {
struct device {
    static constexpr profile facts{.name = "fixture", .eeprom_switch = 0x0C0D};
};
template <wire_value T> using rw = reg<T, access::rw, device>;

inline constexpr rw<u16> time{0x0100, {0, 5000}, units::millisecond, 10};
inline constexpr rw<i16> speed{0x0101, {-300, 300}, units::r_per_min, 0};
inline constexpr rw<u16> kept{0x0110, {0, 100}, no_unit, 0, saved_on_write};
inline constexpr rw<u16> kept_too{0x0111, {0, 100}, no_unit, 0, saved_on_write};
inline constexpr reg_array<rw<i16>, 4> steps{{0x0120, {-100, 100}, units::r_per_min, 0}, 2};
inline constexpr reg_array<rw<u16>, 4> places{{0x0130, {0, 100}, no_unit, 0, saved_on_write}, 2};
} // namespace fixture

using fixture::kept, fixture::kept_too, fixture::places, fixture::speed, fixture::steps, fixture::time;

struct rig {
    using wire = line<tests::waiting_scripted_port>;

    tests::waiting_scripted_port port;
    tests::register_file file;
    wire on{port, modbus::timing_at(115200)};
    client<wire, fixture::device> drive{on, node<fixture::device>{1}};

    rig() {
        for (std::uint16_t a = 0x0100; a < 0x0140; ++a) file.words[a] = static_cast<u16>(a & 0x3Fu);
        file.words[0x0C0D] = 0;
        port.device = [this](tests::scripted_port& p, const tests::sent_frame& f) { file(p, f); };
    }
    rig(const rig&) = delete;
};

// The outcomes and the values of the calls.
struct said {
    std::vector<int> values;

    template <class T> void value(const result<T>& r) { values.push_back(r ? int{r->count()} : -1); }
    void end(const status& w) {
        values.push_back(static_cast<int>(w.outcome()));
        values.push_back(static_cast<int>(w.error()));
    }
    friend bool operator==(const said&, const said&) = default;
};

template <class Client> said by_members(Client& c) {
    said s;
    s.value(c.template read<speed>());
    const auto two = c.template read<time, speed>();
    s.values.push_back(two->template get<time>().count());
    s.value(c.template read<steps>(3));
    s.value(c.template read<steps>(4));
    s.end(c.template write<speed>(7));
    s.end(c.template write<speed>(checked(301)));
    s.end(c.template write<time, speed>(1000, -2));
    s.end(c.template write<steps>(2, -5));
    const ram_only proof = *c.ram_only();
    s.end(c.template write<kept>(1, proof));
    s.end(c.template write<kept>(1, ram_only{}));
    s.end(c.template write<places>(1, 8, proof));
    s.end(c.template store<kept>(2));
    s.end(c.template store<kept, kept_too>(3, 4));
    s.end(c.template store<places>(2, 9));
    s.end(c.template write_if_different<speed>(-2));
    s.end(c.template write_if_different<speed>(3));
    s.end(c.template store_if_different<kept>(3));
    s.end(c.template store_if_different<kept>(5));
    s.end(c.template broadcast<speed>(6));
    return s;
}

template <class Client> said by_twins(Client& c) {
    said s;
    s.value(read<speed>(c));
    const auto two = read<time, speed>(c);
    s.values.push_back(get<time>(*two).count());
    s.value(read<steps>(c, 3));
    s.value(read<steps>(c, 4));
    s.end(write<speed>(c, 7));
    s.end(write<speed>(c, checked(301)));
    s.end(write<time, speed>(c, 1000, -2));
    s.end(write<steps>(c, 2, -5));
    const ram_only proof = *c.ram_only();
    s.end(write<kept>(c, 1, proof));
    s.end(write<kept>(c, 1, ram_only{}));
    s.end(write<places>(c, 1, 8, proof));
    s.end(store<kept>(c, 2));
    s.end(store<kept, kept_too>(c, 3, 4));
    s.end(store<places>(c, 2, 9));
    s.end(write_if_different<speed>(c, -2));
    s.end(write_if_different<speed>(c, 3));
    s.end(store_if_different<kept>(c, 3));
    s.end(store_if_different<kept>(c, 5));
    s.end(broadcast<speed>(c, 6));
    return s;
}

} // namespace

TEST_CASE("generic code that calls the free functions sends the same frames and gets the same results as the "
          "members") {
    rig own, twin;
    const said expected = by_members(own.drive);
    CHECK(by_twins(twin.drive) == expected);
    REQUIRE(own.port.frames.size() == twin.port.frames.size());
    for (std::size_t i = 0; i < own.port.frames.size(); ++i)
        CHECK(own.port.frames[i].data == twin.port.frames[i].data);
    CHECK(own.port.frames.size() >= 18);
    CHECK(twin.file.words == own.file.words);
}

} // namespace free_calls_tests
