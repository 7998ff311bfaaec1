// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a run of the judges records of the wire (sim/conformance/wire_log.hpp): frames and their kept bytes, requests,
// which of them repeat others, and the limits of all.
#include <cstddef>
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/core/bytes.hpp>
#include <servobus/sim/conformance/wire_log.hpp>

namespace wire_log_tests {

using namespace servobus;

namespace {

/// Notes frames, a millisecond a byte within a frame, ten between frames.
class recorder {
  public:
    void send(bytes frame) {
        ++requests;
        pass(frame, true);
    }
    void answer(bytes frame) { pass(frame, false); }

    sim::wire_log log{};
    unsigned requests = 0;

  private:
    void pass(bytes frame, bool is_from_client) {
        at_us_ += 10'000;
        for (const std::uint8_t b : frame)
            log.note({.at_us = at_us_ += 1'000, .value = b, .is_from_client = is_from_client}, requests);
    }
    std::uint64_t at_us_ = 0;
};

constexpr auto read_3 = hex("05 03 00 03 00 01 75 8E");
constexpr auto read_4 = hex("05 03 00 04 00 01 C4 4F");
constexpr auto write_3 = hex("05 06 00 03 00 03 38 4F");

} // namespace

TEST_CASE("a frame ends where the direction changes or a pause follows; its first 24 bytes are kept") {
    recorder r;
    r.send(read_3);
    r.answer(write_3);
    std::uint8_t longest[256];
    for (std::size_t i = 0; i < sizeof longest; ++i) longest[i] = static_cast<std::uint8_t>(i + 1);
    r.answer(longest);
    const auto trace = r.log.trace();
    REQUIRE(trace.size() == 3);
    CHECK(trace[0].is_request);
    CHECK(trace[0].size == 8);
    CHECK(same_bytes(trace[0].kept(), read_3));
    CHECK_FALSE(trace[1].is_request);
    CHECK(same_bytes(trace[1].kept(), write_3));
    CHECK(trace[2].size == 255); // it counts so far
    CHECK(same_bytes(trace[2].kept(), bytes{longest}.first(24)));
}
TEST_CASE("of reads that repeat themselves the first, the second and the last are not repeated") {
    recorder r;
    r.send(write_3);
    for (int i = 0; i < 4; ++i) r.send(read_4);
    r.send(write_3);
    r.send(read_4);
    CHECK(r.log.requests() == 7);
    CHECK(r.log.writes() == 2);
    const bool expected[] = {false, false, false, true, false, false, false};
    for (unsigned i = 0; i < 7; ++i) {
        CAPTURE(i);
        CHECK(r.log.is_repeated(i) == expected[i]);
    }
    const sim::chosen_requests chosen = r.log.chosen();
    CHECK(std::vector<unsigned>(chosen.begin(), chosen.end()) == std::vector<unsigned>{0, 1, 2, 4, 5, 6});
}
TEST_CASE("the first 200 requests that are not repeated are chosen") {
    recorder r;
    for (int i = 0; i < 201; ++i) r.send(write_3);
    const sim::chosen_requests chosen = r.log.chosen();
    CHECK(chosen.count == 200);
    CHECK(chosen.numbers.back() == 199);
    r.log.begin();
    CHECK(r.log.chosen().count == 0);
}
TEST_CASE("a write of the register that was read right before it") {
    recorder r;
    r.send(read_3);
    r.send(write_3); // of what was read
    r.send(write_3);
    r.send(read_4);
    r.send(write_3);
    const bool expected[] = {false, true, false, false, false};
    for (unsigned i = 0; i < 5; ++i) {
        CAPTURE(i);
        CHECK(r.log.writes_what_was_read(i) == expected[i]);
    }
    CHECK_FALSE(r.log.writes_what_was_read(5)); // there is none
    r.log.begin();
    CHECK(r.log.requests() == 0);
    CHECK_FALSE(r.log.writes_what_was_read(1));
    CHECK(r.log.trace().size() == 5);
}
TEST_CASE("the first 1000 requests and the last 40 frames are kept") {
    recorder r;
    for (int i = 0; i < 1'002; ++i) r.send(read_3);
    r.send(write_3);
    CHECK(r.log.requests() == 1'000);
    CHECK(r.log.writes() == 1);
    CHECK_FALSE(r.log.is_repeated(999)); // the last one that is known
    CHECK(r.log.is_repeated(998));
    CHECK(r.log.trace().size() == 40);
    CHECK(same_bytes(r.log.trace().back().kept(), write_3));
    CHECK(same_bytes(r.log.trace().front().kept(), read_3));
}

} // namespace wire_log_tests
