// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// When a server's hooks are called: the first one before anything is stored, the second one when all is.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include <tests/support/served_rows.hpp>

namespace write_hooks_tests {

using namespace servobus;
using byte_list = std::vector<std::uint8_t>;

namespace {

/// The values of `served_rows`.
struct content {
    std::uint16_t selected = 0;
    int travel = 0;
    int second_low = 0;
    bool valve = false;
    bool pump = false;

    explicit content(const served_rows::values& of)
        : selected{static_cast<std::uint16_t>(of.get<served_rows::selected>())},
          travel{of.get<served_rows::travel>().count()}, second_low{of.get<served_rows::lows>(1).count()},
          valve{of.get<served_rows::valve>()}, pump{of.get<served_rows::pump>()} {}
    content() = default;
    friend bool operator==(const content&, const content&) = default;
};

struct watcher {
    const served_rows::values& rows;
    content before{}, after{};
    unsigned calls = 0;
    std::uint8_t refusal = 0;

    std::uint8_t before_write(const changes<served_rows::values>&) {
        before = content{rows};
        ++calls;
        return refusal;
    }
    void after_write(const changes<served_rows::values>&) {
        after = content{rows};
        ++calls;
    }
};

struct hooked {
    served_rows::values values;
    watcher hooks{values};
    request_executor<served_rows::values, with_hooks<watcher>, with_mask_write, with_read_write> executor{
        values, hooks};

    byte_list respond(const byte_list& request) {
        std::uint8_t pdu[decltype(executor)::buffer_size]{};
        std::copy_n(request.begin(), std::min(request.size(), sizeof pdu), pdu);
        const std::size_t size = executor.execute(pdu, request.size());
        return {pdu, pdu + size};
    }
};

/// A request of each function that writes.
const byte_list writes[]{
    {0x05, 0, 1, 0xFF, 0},                                  // pump on
    {0x0F, 0, 0, 0, 2, 1, 2},                               // valve off, pump on
    {0x06, 0, 0x10, 0, 2},                                  // selected
    {0x10, 0, 0x10, 0, 4, 8, 0, 2, 0, 9, 0x11, 0x70, 0, 1}, // selected, command, travel
    {0x16, 0, 0x19, 0, 0, 0, 6},                            // the second of lows
    {0x17, 0, 0x10, 0, 1, 0, 0x10, 0, 1, 2, 0, 2},          // selected
};

} // namespace

TEST_CASE("before_write finds the rows as they were, and after_write as they are") {
    for (const byte_list& write : writes) {
        CAPTURE(static_cast<int>(write[0]));
        hooked d;
        const content was{d.values};
        CHECK(d.respond(write)[0] == write[0]);
        const content is{d.values};
        CHECK_FALSE(is == was);
        CHECK(d.hooks.calls == 2);
        CHECK(d.hooks.before == was);
        CHECK(d.hooks.after == is);
    }
}

TEST_CASE("a write that is refused calls no after_write, and stores nothing") {
    for (const byte_list& write : writes) {
        CAPTURE(static_cast<int>(write[0]));
        hooked d;
        d.hooks.refusal = 0x42;
        const content was{d.values};
        CHECK(d.respond(write) == byte_list{static_cast<std::uint8_t>(write[0] | 0x80u), 0x42});
        CHECK(content{d.values} == was);
        CHECK(d.hooks.calls == 1);
    }
}

} // namespace write_hooks_tests
