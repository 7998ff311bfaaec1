// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Random requests of all functions, many of them with a byte changed, lost or added: a server of rows responds as a
// plain model does that is written apart from the library, and has the same values after each.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>

#include <examples/own_device/hoist_server.hpp>
#include <tests/support/row_model.hpp>
#include <tests/support/served_rows.hpp>

namespace requests_random_tests {

using namespace servobus;
using row_model::byte_list;

namespace {

using hoist_values = hoist::values;
using hoist_executor = request_executor<hoist_values, with_mask_write>;

row_model::device description_of_hoist() {
    row_model::device d;
    d.rows = {{'h', 0, 1, "rw", 0, 2, 0},
              {'h', 1, 1, "rw", -600, 600, 0},
              {'h', 2, 1, "rw", 10, 5000, 500},
              {'h', 3, 2, "rw", -1'000'000, 1'000'000, 0},
              {'h', 5, 1, "rw", 0, 250, 100},
              {'h', 6, 1, "rw", 0, 65535, 0},
              {'h', 7, 1, "r", 0, 65535, 0},
              {'h', 8, 2, "r", -0x8000'0000LL, 0x7FFF'FFFF, 0},
              {'h', 10, 1, "r", 0, 65535, 0},
              {'h', 11, 1, "r", 0, 65535, 0},
              {'i', 0, 1, "r", -0x8000, 0x7FFF, 25},
              {'i', 1, 1, "r", 0, 65535, 2400},
              {'c', 0, 1, "rw", 0, 1, 0},
              {'c', 1, 1, "rw", 0, 1, 0},
              {'c', 2, 1, "rw", 0, 1, 0},
              {'c', 3, 1, "rw", 0, 1, 0}};
    d.room = hoist_executor::buffer_size;
    d.functions = "m";
    return d;
}

// A server whose buffer is exactly as long as it must be, on the heap, where sanitizers see its ends.
template <class Values, class Executor> struct bench {
    struct buffer {
        std::uint8_t bytes[Executor::buffer_size]{};
    };
    std::unique_ptr<Values> values = std::make_unique<Values>();
    Executor executor{*values};

    byte_list respond(const byte_list& pdu) {
        const auto b = std::make_unique<buffer>();
        std::fill_n(b->bytes, sizeof b->bytes, std::uint8_t{0xA5}); // what came before
        std::copy_n(pdu.begin(), std::min(pdu.size(), sizeof b->bytes), b->bytes);
        const std::size_t size = executor.execute(b->bytes, pdu.size());
        REQUIRE(size <= sizeof b->bytes);
        return {b->bytes, b->bytes + size};
    }
};

// A request for each row that can be read.
byte_list read_of(const row_model::row& r) {
    const unsigned code = r.table == 'c' ? 1 : r.table == 'd' ? 2 : r.table == 'h' ? 3 : 4;
    return {row_model::low_byte(code), row_model::low_byte(r.address >> 8), row_model::low_byte(r.address), 0,
            row_model::low_byte(r.words)};
}

template <class Values, class Executor>
void compare(const row_model::device& of, unsigned seed, unsigned requests) {
    bench<Values, Executor> served;
    row_model::model model{of};
    row_model::maker maker{of, seed};
    unsigned executed[128]{}, refused[128][4]{};
    for (unsigned i = 0; i < requests; ++i) {
        const byte_list pdu = maker.request();
        CAPTURE(i);
        CAPTURE(pdu);
        const byte_list expected = model.respond(pdu);
        REQUIRE(served.respond(pdu) == expected);
        if (expected.empty()) continue;
        if (expected[0] < 128) ++executed[expected[0]];
        if (expected[0] >= 128) ++refused[pdu[0]][expected[1]];
        for (const row_model::row& r : of.rows) {
            if (r.rights.find('r') == std::string::npos || (!maker.one_in(8) && i % 64 != 0)) continue;
            REQUIRE(served.respond(read_of(r)) == model.respond(read_of(r)));
        }
    }
    // The requests reach what they should.
    for (const unsigned code : {1u, 3u, 4u, 5u, 6u, 15u, 16u, 22u}) {
        CAPTURE(code);
        CHECK(executed[code] > 10);
        CHECK(refused[code][2] > 10);
        CHECK(refused[code][3] > 10);
    }
}

} // namespace

TEST_CASE("a server of rows responds to random requests as a plain model does, and has its values") {
    for (const unsigned seed : {1u, 2u}) {
        compare<served_rows::values, served_rows::executor>(served_rows::description(), seed, 6'000);
        compare<hoist_values, hoist_executor>(description_of_hoist(), seed, 6'000);
    }
}

} // namespace requests_random_tests
