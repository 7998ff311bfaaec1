// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Prepares a task for an operation, and compares the results of the sides with the frames below, which are
// constants and not made by any side.
#include "operations.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <span>
#include <string_view>

namespace bench {
namespace {

using frame_view = std::span<const std::uint8_t>;

constexpr std::array<std::uint16_t, 10> values{0x0000, 0x0001, 0x7FFF, 0x8000, 0xFFFF,
                                               0x1234, 0x5678, 0x9ABC, 0xDEF0, 0x00FF};

// Node 1, registers from 20A0h on. The CRCs were computed with another program.
constexpr std::array<std::uint8_t, 8> write_frame{0x01, 0x06, 0x20, 0xA0, 0x12, 0x34, 0x8F, 0x5F};
constexpr std::array<std::uint8_t, 8> read_frame{0x01, 0x03, 0x20, 0xA0, 0x00, 0x0A, 0xCE, 0x2F};
constexpr std::array<std::uint8_t, 25> read_response{0x01, 0x03, 0x14, 0x00, 0x00, 0x00, 0x01, 0x7F, 0xFF,
                                                     0x80, 0x00, 0xFF, 0xFF, 0x12, 0x34, 0x56, 0x78, 0x9A,
                                                     0xBC, 0xDE, 0xF0, 0x00, 0xFF, 0x45, 0x10};
constexpr std::array<std::uint8_t, 29> many_frame{0x01, 0x10, 0x20, 0xA0, 0x00, 0x0A, 0x14, 0x00, 0x00, 0x00,
                                                  0x01, 0x7F, 0xFF, 0x80, 0x00, 0xFF, 0xFF, 0x12, 0x34, 0x56,
                                                  0x78, 0x9A, 0xBC, 0xDE, 0xF0, 0x00, 0xFF, 0xC3, 0x66};
constexpr std::array<std::uint8_t, 8> many_response{0x01, 0x10, 0x20, 0xA0, 0x00, 0x0A, 0x4B, 0xEC};

bool is(const operation& what, void (*side::*run)(task&)) { return what.run == run; }

frame_view request_of(const operation& what) {
    if (is(what, &side::build_write) || is(what, &side::write)) return write_frame;
    if (is(what, &side::build_read) || is(what, &side::read_many)) return read_frame;
    if (is(what, &side::build_write_many) || is(what, &side::write_many)) return many_frame;
    return {};
}

frame_view response_to(const operation& what) {
    if (is(what, &side::write)) return write_frame;
    if (is(what, &side::read_many) || is(what, &side::parse)) return read_response;
    if (is(what, &side::write_many)) return many_response;
    return {};
}

bool is_transaction(const operation& what) { return std::string_view{what.name}.starts_with("transaction"); }
bool reads(const operation& what) { return is(what, &side::parse) || is(what, &side::read_many); }

bool does(const side& who, const operation& what) {
    task t;
    prepare(t, who, what);
    (who.*what.run)(t);
    if (!t.ok) return false;
    const frame_view sent = is_transaction(what) ? frame_view{t.wire->request, t.wire->request_size}
                                                 : frame_view{t.frame.data(), t.frame_size};
    const frame_view wanted = is(what, &side::parse) ? response_to(what) : request_of(what);
    return std::ranges::equal(sent, wanted) && (!reads(what) || t.words == values);
}

// Inverts each bit of the response, one at a time: no such response may be accepted.
bool refuses_damage(const side& who, const operation& what) {
    const std::size_t bits = 8 * response_to(what).size();
    for (std::size_t bit = 0; bit < bits; ++bit) {
        task t;
        prepare(t, who, what);
        std::uint8_t& byte = is_transaction(what) ? t.wire->response[bit / 8] : t.frame[bit / 8];
        byte = static_cast<std::uint8_t>(byte ^ (1u << bit % 8));
        (who.*what.run)(t);
        if (t.ok) return false;
    }
    return true;
}

} // namespace

void prepare(task& t, const side& who, const operation& what) {
    t = task{};
    t.values = values;
    who.open(t);
    t.wire->clock += 1'000'000; // longer than any gap that a side keeps at its start
    const frame_view response = response_to(what);
    std::ranges::copy(response, t.wire->response);
    t.wire->response_size = response.size();
    // A side that only reads the bytes sends the request that is already in `frame`.
    const frame_view given = is(what, &side::parse) ? response : request_of(what);
    if (is_transaction(what) || is(what, &side::parse)) std::ranges::copy(given, t.frame.begin());
    if (is_transaction(what) || is(what, &side::parse)) t.frame_size = given.size();
}

bool works(const side& who) {
    bool all = true;
    for (const operation& what : operations) {
        if (who.*what.run == nullptr || does(who, what)) continue;
        std::fprintf(stderr, "%s: %s fails\n", who.name, what.name);
        all = false;
    }
    return all;
}

bool is_correct(const side& who) {
    bool all = works(who);
    for (const operation& what : operations) {
        if (who.*what.run == nullptr || refuses_damage(who, what)) continue;
        std::fprintf(stderr, "%s: %s accepts a damaged response\n", who.name, what.name);
        all = false;
    }
    return all;
}

} // namespace bench
