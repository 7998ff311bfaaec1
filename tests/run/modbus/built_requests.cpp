// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The builders of requests beyond registers, with values that the compiler does not know: each writes the PDU as the
// standard prints it into a buffer of exactly its length, and nothing into a shorter one.
#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <servobus/modbus/functions.hpp>

namespace built_requests_tests {

using namespace servobus;
using namespace servobus::modbus;

namespace {

using byte_list = std::vector<std::uint8_t>;

/// Builds into every buffer that is too short, into one of the right length, and into a longer one.
template <class Build> void check_built(const byte_list& expected, Build build) {
    CAPTURE(expected);
    const std::size_t length = expected.size();
    for (std::size_t size = 0; size <= length + 2; ++size) {
        CAPTURE(size);
        byte_list room(size, 0x99);
        byte_list wanted = room;
        if (size >= length) {
            for (std::size_t i = 0; i < length; ++i) wanted[i] = expected[i];
        }
        CHECK(build(byte_buffer{room}) == (size < length ? 0 : length));
        CHECK(room == wanted);
    }
    CHECK(check_request(expected) == errc::ok);
}

// The bytes of a word.
constexpr std::uint8_t high(std::uint16_t word) { return static_cast<std::uint8_t>(word / 256); }
constexpr std::uint8_t low(std::uint16_t word) { return static_cast<std::uint8_t>(word % 256); }

constexpr std::uint16_t addresses[]{0, 1, 0x00AC, 0x1234, 0xFF00, 0xFFFF};

} // namespace

TEST_CASE("a read of bits is built with its function, address and quantity") {
    for (const std::uint8_t code : byte_list{0x01, 0x02}) {
        check_built({code, 0x00, 0x13, 0x00, 0x13}, [&](byte_buffer out) {
            return put_read_bits_request(out, static_cast<function>(code), 0x13, 0x13);
        });
        check_built({code, 0xF8, 0x30, 0x07, 0xD0}, [&](byte_buffer out) {
            return put_read_bits_request(out, static_cast<function>(code), 0xF830, 2000);
        });
    }
}

TEST_CASE("a write of a coil is built with FF00h for on and 0 for off") {
    for (const std::uint16_t address : addresses) {
        for (const bool is_on : {true, false}) {
            const std::uint8_t value = is_on ? 0xFF : 0;
            check_built({0x05, high(address), low(address), value, 0},
                        [&](byte_buffer out) { return put_write_coil_request(out, address, is_on); });
        }
    }
}

TEST_CASE("a write of coils is built from a bool for each, the first in the lowest bit") {
    const std::array<bool, 10> printed{true, false, true, true, false, false, true, true, true, false};
    check_built({0x0F, 0x00, 0x13, 0x00, 0x0A, 0x02, 0xCD, 0x01}, [&](byte_buffer out) {
        return put_write_coils_request(out, 0x13, slice<const bool>{printed});
    });
    for (std::size_t on = 0; on < 9; ++on) {
        std::array<bool, 9> one{};
        one[on] = true;
        byte_list expected{0x0F, 0xFF, 0x00, 0x00, 0x09, 0x02, 0x00, 0x00};
        expected[6 + on / 8] = static_cast<std::uint8_t>(1u << on % 8);
        check_built(expected, [&](byte_buffer out) {
            return put_write_coils_request(out, 0xFF00, slice<const bool>{one});
        });
    }
}

TEST_CASE("a request without data is built as its function alone") {
    for (const std::uint8_t code : byte_list{0x07, 0x0B, 0x0C, 0x11})
        check_built({code},
                    [&](byte_buffer out) { return put_bare_request(out, static_cast<function>(code)); });
}

TEST_CASE("a read of a queue is built with its address") {
    for (const std::uint16_t address : addresses)
        check_built({0x18, high(address), low(address)},
                    [&](byte_buffer out) { return put_fifo_request(out, address); });
}

TEST_CASE("a request for identification is built with its kind and its first object") {
    for (std::uint8_t kind = 1; kind <= 4; ++kind) {
        for (const std::uint8_t object : byte_list{0x00, 0x02, 0x80, 0xFF})
            check_built({0x2B, 0x0E, kind, object}, [&](byte_buffer out) {
                return put_identification_request(out, {static_cast<identification>(kind), object});
            });
    }
}

TEST_CASE("a change of some bits is built with its address and both masks") {
    check_built({0x16, 0x00, 0x04, 0x00, 0xF2, 0x00, 0x25}, [](byte_buffer out) {
        return put_mask_write_request(out, {4, 0xF2, 0x25});
    });
    check_built({0x16, 0xFE, 0xDC, 0xBA, 0x98, 0x76, 0x54}, [](byte_buffer out) {
        return put_mask_write_request(out, {0xFEDC, 0xBA98, 0x7654});
    });
}

TEST_CASE("a change of some bits keeps each bit of its first mask, and takes the others from the second") {
    for (unsigned row = 0; row < 8; ++row) {
        const bool is_kept = (row & 4u) != 0;
        const bool is_set = (row & 2u) != 0;
        const bool was = (row & 1u) != 0;
        for (unsigned bit = 0; bit < 16; ++bit) {
            const auto mask = [&](bool is) { return static_cast<std::uint16_t>(is ? 1u << bit : 0u); };
            const mask_write change{0x1234, mask(is_kept), mask(is_set)};
            CHECK(change.applied_to(mask(was)) == mask(is_kept ? was : is_set));
        }
    }
}

TEST_CASE("changes are equal if their addresses and both masks are") {
    const std::array<std::uint16_t, 2> either{0x0102, 0x0201};
    for (unsigned a = 0; a < 8; ++a) {
        for (unsigned b = 0; b < 8; ++b) {
            const auto of = [&](unsigned n) {
                return mask_write{either[n & 1u], either[n >> 1 & 1u], either[n >> 2]};
            };
            CHECK((of(a) == of(b)) == (a == b));
        }
    }
}

} // namespace built_requests_tests
