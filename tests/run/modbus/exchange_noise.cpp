// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// One request and its response, without a port, when more than the response arrives or it arrives in pieces:
// bytes before and after it, gaps within it, more bytes than a frame has, and frames of other nodes.
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <vector>

#include <servobus/modbus/exchange.hpp>

#include <tests/support/exchange_runs.hpp>

namespace exchange_noise_tests {

using namespace servobus;
using namespace servobus::modbus;
using namespace tests::exchange_runs;
using tests::byte_list;
using tests::framed;
using tests::operator+;

TEST_CASE("G5: up to k leading bytes 00 or FF are skipped, one more is not") {
    for (const unsigned k : {0u, 1u, 4u, 9u}) {
        response_limits p;
        p.leading_bytes = static_cast<std::uint8_t>(k);
        for (unsigned n = 0; n <= 12; ++n) {
            for (const std::uint8_t value : std::array<std::uint8_t, 2>{0x00, 0xFF}) {
                CAPTURE(k);
                CAPTURE(n);
                CAPTURE(value);
                const byte_list lead(n, value);
                for (const pair& q : pairs()) {
                    const ended e = run(q.request, lead + q.response, p);
                    CHECK((e.why.error() == errc::ok) == (n <= k));
                    if (n > k) CHECK(e.why.error() == errc::timeout);
                }
            }
        }
    }
}

TEST_CASE("G5: any other byte before a response is not skipped, unless a gap follows it") {
    for (unsigned value = 1; value <= 254; ++value) {
        CAPTURE(value);
        const byte_list lead{static_cast<std::uint8_t>(value)};
        CHECK(run(read_one, lead + one_word).why.error() != errc::ok);
        if (value == 1) continue; // looks like the beginning of the response
        const ended apart = run(read_one, {{2000, lead}, {30'000, one_word}});
        CHECK(apart.why.error() == errc::ok);
        CHECK(apart.words == std::vector<std::uint16_t>{0x0960});
    }
}

TEST_CASE("G5: leading bytes make no response valid that is not") {
    for (std::size_t n = 0; n <= 4; ++n) {
        const byte_list lead(n, 0x00);
        for (std::size_t i = 0; i < one_word.size(); ++i) {
            for (unsigned wrong = 1; wrong <= 255; ++wrong) {
                byte_list response = one_word;
                response[i] = static_cast<std::uint8_t>(response[i] ^ wrong);
                const ended e = run(read_one, lead + response);
                REQUIRE(e.why.error() != errc::ok);
                REQUIRE(e.words.empty());
            }
        }
    }
}

TEST_CASE("G6: trailing bytes change no value, however many and whatever they are") {
    tests::dice random{6};
    for (const pair& p : pairs()) {
        const ended plain = run(p.request, p.response);
        for (const std::size_t n :
             {std::size_t{1}, std::size_t{2}, std::size_t{3}, std::size_t{64}, std::size_t{300}}) {
            byte_list zeros(n, 0x00);
            byte_list ones(n, 0xFF);
            byte_list noise(n);
            for (auto& b : noise) b = random.byte();
            for (const byte_list& tail : {zeros, ones, noise, p.response}) {
                const ended e = run(p.request, p.response + tail);
                CHECK(e.why.error() == errc::ok);
                CHECK(e.words == plain.words);
                CHECK(e.response == p.response);
            }
        }
    }
}

TEST_CASE("G6: a frame ends by its count, not where its CRC happens to fit") {
    // The words are such that the CRC already fits after the first word.
    const byte_list short_frame = framed({1, 3, 4, 0x12, 0x34});
    const auto crc = static_cast<std::uint16_t>(short_frame[5] << 8 | short_frame[6]);
    const byte_list whole = tests::read_response(1, {0x1234, crc});
    REQUIRE(tests::crc_of(part(whole, 0, 7)) == 0);
    CHECK(run(read_two, whole).words == std::vector<std::uint16_t>{0x1234, crc});
    CHECK(run(read_two, part(whole, 0, 7)).why.error() == errc::truncated_response);
}

TEST_CASE("G7: in host timing a response that is split anywhere, with pauses up to the limit, is the same "
          "response") {
    const auto limit = static_cast<std::uint32_t>(host.inter_byte.us);
    for (const pair& p : pairs()) {
        const ended whole = run(p.request, p.response);
        for (std::size_t cut = 1; cut < p.response.size(); ++cut) {
            for (const std::uint32_t pause : {1u, 1000u, 16'000u, limit - 50, limit}) {
                CAPTURE(p.name);
                CAPTURE(cut);
                CAPTURE(pause);
                const ended e = run(p.request, {{2000, part(p.response, 0, cut)},
                                                {2000 + pause, part(p.response, cut, p.response.size())}});
                CHECK(e.why == whole.why);
                CHECK(e.words == whole.words);
            }
            const ended too_long =
                run(p.request, {{2000, part(p.response, 0, cut)},
                                {2000 + limit + 200, part(p.response, cut, p.response.size())}});
            CHECK(too_long.why.error() == errc::truncated_response);
        }
        std::vector<burst> dribble;
        for (std::size_t i = 0; i < p.response.size(); ++i)
            dribble.push_back({99'000 + limit * static_cast<std::uint32_t>(i), {p.response[i]}});
        CHECK(run(p.request, dribble).why.error() == errc::ok);
    }
}

TEST_CASE("G7: in strict timing a gap above t1.5 rejects the frame, one up to t1.5 does not") {
    const std::uint32_t character = strict.character;
    const auto with_gap = [&](std::size_t at, std::uint32_t gap) {
        std::vector<burst> single;
        std::uint32_t time = 10'000;
        for (std::size_t i = 0; i < two_words.size(); ++i) {
            time += character + (i == at ? gap : 0);
            single.push_back({time, {two_words[i]}});
        }
        return run(read_two, single, strict).why.error();
    };
    CHECK(with_gap(0, 0) == errc::ok);
    for (std::size_t at = 1; at < two_words.size(); ++at) {
        CAPTURE(at);
        CHECK(with_gap(at, strict.t1_5) == errc::ok);
        CHECK(with_gap(at, strict.t1_5 + 1u) == errc::bad_gap);
        CHECK(with_gap(at, strict.t3_5) == errc::bad_gap);
        CHECK(with_gap(at, 50'000) == errc::bad_gap);
    }
}

TEST_CASE(
    "G10: input longer than any frame never writes outside the buffer and invalidates only that frame") {
    tests::dice random{10};
    for (const std::size_t room : {std::size_t{7}, std::size_t{8}, std::size_t{9}, std::size_t{256}}) {
        for (const std::uint8_t first : std::array<std::uint8_t, 4>{0x01, 0x02, 0x00, 0x55}) {
            byte_list flood(5000);
            for (auto& b : flood) b = random.byte();
            flood[0] = first;
            if (room < 8) {
                CHECK(run(read_one, std::vector<burst>{{2000, flood}}, host, usual, room).why.error() !=
                      errc::ok);
            } else {
                CHECK(run(write_one, std::vector<burst>{{2000, flood}}, host, usual, room).why.error() !=
                      errc::ok);
            }
        }
    }
    CHECK(run(read_one, {{2000, byte_list(5000, 0x55)}, {40'000, one_word}}).why.error() == errc::ok);
}

TEST_CASE(
    "G10: the response that is returned never exceeds its buffer, whatever frames of other nodes arrive") {
    byte_list memory(8);
    const response_limits brief{.response = milliseconds(10)};
    for (std::size_t n = 1; n <= 260; ++n) {
        byte_list foreign(n, 0x42);
        foreign[0] = 0x09;
        if (n > 1) foreign[1] = 0x03;
        if (n > 2) foreign[2] = 0xFF;
        exchange x{write_one, memory, host, brief};
        x.sent({0});
        x.feed(foreign, {5000});
        x.elapse({10'000}); // the time is over while the other frame is still arriving
        REQUIRE(x.done());
        REQUIRE(x.status().error() == errc::timeout);
        REQUIRE(x.response().size() == 0); // none of it was a response
    }
}

TEST_CASE("an exception to a function whose response is four bytes long does not overrun its buffer") {
    byte_list memory(4 + 8, 0xA5);
    const byte_list request = framed({1, 0x41});
    exchange x{request, byte_buffer{memory}.first(4), host, usual};
    if (!x.done()) {
        x.sent({0});
        x.feed(tests::exception_response(1, 0x41, 1), {1000});
        x.elapse({200'000});
    }
    CHECK(x.done());
    CHECK(x.response().size() <= 4);
    for (std::size_t i = 4; i < memory.size(); ++i) CHECK(memory[i] == 0xA5);
}

TEST_CASE("G11: another node's frame neither completes an exchange nor extends its wait") {
    const std::vector<byte_list> foreign{
        tests::read_response(2, {0x0960}), tests::read_response(247, std::vector<std::uint16_t>(125, 0x0103)),
        framed({2, 6, 0x20, 0x88, 0, 0x64}), framed({2, 0x10, 0x20, 0x88, 0, 2}),
        tests::exception_response(2, 3, 2)};
    for (const byte_list& f : foreign) {
        for (const std::uint32_t at : {100u, 2000u, 50'000u, 90'000u, 99'900u}) {
            const ended e = run(read_one, std::vector<burst>{{at, f}});
            CHECK(e.why.error() == errc::timeout);
            CHECK(e.words.empty());
            CHECK(e.at >= 100'000);
            CHECK(e.at <= 100'050);
        }
        CHECK(run(read_one, f + one_word).why.error() == errc::ok); // its end was found
    }
    const byte_list many = foreign[0] + foreign[2] + foreign[4] + foreign[1];
    CHECK(run(read_one, many).why.error() == errc::timeout);
    CHECK(run(read_one, many + one_word).why.error() == errc::ok);
}

TEST_CASE("G11: the response is accepted after another node's frame, immediately or after a gap, but only "
          "within the time limit") {
    const byte_list foreign = tests::read_response(2, {0x1111, 0x2222});
    for (const pair& p : pairs()) {
        CAPTURE(p.name);
        CHECK(run(p.request, foreign + p.response).why.error() == errc::ok);
        CHECK(run(p.request, foreign + foreign + p.response).why.error() == errc::ok);
        CHECK(run(p.request, {{2000, foreign}, {30'000, p.response}}).why.error() == errc::ok);
        CHECK(run(p.request, {{2000, foreign}, {150'000, p.response}}).why.error() == errc::timeout);
        CHECK(run(p.request, byte_list{0} + foreign + byte_list{0, 0xFF} + p.response).why.error() ==
              errc::ok);
    }
}

TEST_CASE("G11: a frame inside another node's frame is not accepted, even if it equals the response") {
    // The words of node 2 are the whole response.
    const byte_list ours = one_word + byte_list{0};
    std::vector<std::uint16_t> words;
    for (std::size_t i = 0; i + 1 < ours.size(); i += 2)
        words.push_back(static_cast<std::uint16_t>(ours[i] << 8 | ours[i + 1]));
    const byte_list nested = tests::read_response(2, words);
    CHECK(run(read_one, nested).why.error() == errc::timeout);
    CHECK(run(read_one, nested + one_word).why.error() == errc::ok);
    for (std::size_t cut = 1; cut < nested.size(); ++cut) {
        CAPTURE(cut);
        const ended e =
            run(read_one, {{2000, part(nested, 0, cut)}, {2000 + 15'000, part(nested, cut, nested.size())}});
        CHECK(e.why.error() == errc::timeout);
    }
    // Nor if the CRC of node 2's frame, or a byte before it, is wrong.
    for (std::size_t i = 1; i < nested.size(); ++i) {
        if (i >= 3 && i < 3 + one_word.size()) continue;
        byte_list bad = nested;
        bad[i] = static_cast<std::uint8_t>(bad[i] ^ 0x10u);
        CAPTURE(i);
        CHECK(run(read_one, bad).why.error() == errc::timeout);
    }
}

TEST_CASE("G11: after another node's frame with a wrong CRC, or of an unknown function, nothing is accepted "
          "before a gap") {
    byte_list bad = tests::read_response(2, {0x1111, 0x2222});
    bad[4] = static_cast<std::uint8_t>(bad[4] ^ 1u);
    for (const byte_list& f : {bad, framed({2, 0x2B, 1, 2, 3, 4, 5, 6})}) {
        CHECK(run(read_one, f + one_word).why.error() == errc::timeout);
        const ended e = run(read_one, {{2000, f}, {2000 + 21'000, one_word}});
        CHECK(e.why.error() == errc::ok);
        CHECK(e.words == std::vector<std::uint16_t>{0x0960});
    }
}

} // namespace exchange_noise_tests
