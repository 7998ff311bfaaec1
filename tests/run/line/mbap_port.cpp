// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Modbus TCP as a port, over a scripted stream: what leaves and arrives byte by byte, late responses, and what is no
// frame. The frames are written out here, from 3.1.3 of the implementation guide and its example in annex 4.
#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/client/client.hpp>
#include <servobus/client/peer_node.hpp>
#include <servobus/line/line.hpp>
#include <servobus/line/mbap_port.hpp>

namespace mbap_port_tests {

using namespace servobus;

namespace {

using byte_list = std::vector<std::uint8_t>;

/// A stream whose peer answers by a function of the bytes that it has got.
struct script {
    std::size_t takes = 1000;                   // bytes of one `send`
    std::size_t gives = 1000;                   // of one `receive`
    byte_list taken;                            // all that has left
    std::deque<std::uint8_t> coming;            // what is to be received
    errc lost = errc::ok;                       // what every call returns from now on
    std::size_t breaks_after = ~std::size_t{0}; // so many bytes the connection takes, then it is lost
    bool is_draining = false;                   // what was taken has not left yet
    bool ends = false;                          // the peer closes the connection once it has sent all
    bool has_given = false;                     // bytes were received
    std::uint32_t us = 0;
    std::size_t answered = 0; // of `taken`
    std::function<byte_list(const byte_list&)> answers = nullptr;
};

struct stream {
    script* of = nullptr;
    bool is_closed = false;

    errc open(script* with) {
        of = with;
        is_closed = false;
        return errc::ok;
    }
    void close() { is_closed = true; }
    transfer send(bytes out) {
        if (of->lost != errc::ok) return of->lost;
        if (of->taken.size() >= of->breaks_after) return of->lost = errc::port_lost;
        std::size_t n = out.size() < of->takes ? out.size() : of->takes;
        if (n > of->breaks_after - of->taken.size()) n = of->breaks_after - of->taken.size();
        of->taken.insert(of->taken.end(), out.begin(), out.begin() + static_cast<std::ptrdiff_t>(n));
        return static_cast<std::uint16_t>(n);
    }
    bool sent() { return !of->is_draining; }
    transfer receive(byte_buffer in) {
        if (of->lost != errc::ok) return of->lost;
        answer();
        if (of->ends && of->has_given && of->coming.empty()) return errc::port_lost;
        std::uint16_t n = 0;
        while (n < in.size() && n < of->gives && !of->coming.empty()) {
            in[n++] = of->coming.front();
            of->coming.pop_front();
        }
        of->has_given = of->has_given || n != 0;
        return n;
    }
    instant now() const { return {of->us += 10}; }
    void wait(duration d) { of->us += of->coming.empty() ? d.us : 1; }

  private:
    void answer() {
        if (of->answers == nullptr) return;
        const byte_list rest(of->taken.begin() + static_cast<std::ptrdiff_t>(of->answered), of->taken.end());
        if (rest.size() < 6 || rest.size() < 6u + rest[5]) return;
        of->answered += 6u + rest[5];
        for (const std::uint8_t b : of->answers(rest)) of->coming.push_back(b);
    }
};

using port_type = mbap_port<stream>;
static_assert(waiting_port<port_type>);

// Node 17 gives 555Ah for each register that is asked for.
byte_list answer_of_17(const byte_list& request) {
    const std::uint8_t words = request[11];
    byte_list r{request[0], request[1], 0,
                0,          0,          static_cast<std::uint8_t>(3 + 2 * words),
                17,         request[7], static_cast<std::uint8_t>(2 * words)};
    for (unsigned i = 0; i < words; ++i) r.insert(r.end(), {0x55, 0x5A});
    return r;
}

// The response to request 1, which is late, and then the right one.
byte_list late_and_right(const byte_list& request) {
    byte_list both{0, 1, 0, 0, 0, 5, 17, 3, 2, 0xDE, 0xAD};
    const byte_list right = answer_of_17(request);
    both.insert(both.end(), right.begin(), right.end());
    return both;
}

struct scene {
    script peer;
    port_type port;
    line<port_type, counters> wire{port, modbus::timing_at(115200)};

    scene() { REQUIRE(port.open(&peer) == errc::ok); }
    status read(std::uint16_t* words, std::size_t count) {
        client at{wire, node<unlisted>{17}};
        return at.read_words(0x0100, slice<std::uint16_t>{words, count});
    }
    struct unlisted {
        static constexpr profile facts{
            .name = "unlisted", .limits = {.response = milliseconds(50)}, .read_retries = 0};
    };
};

} // namespace

TEST_CASE("Modbus TCP: a request leaves with number, length and unit, and without a CRC") {
    scene s;
    s.peer.answers = answer_of_17;
    std::uint16_t word = 0;
    REQUIRE(s.read(&word, 1).error() == errc::ok);
    CHECK(word == 0x555A);
    CHECK(s.peer.taken == byte_list{0, 1, 0, 0, 0, 6, 17, 3, 1, 0, 0, 1});
    REQUIRE(s.read(&word, 1).error() == errc::ok);
    CHECK(s.peer.taken.size() == 24);
    CHECK(s.peer.taken[13] == 2); // the next number
}

TEST_CASE("Modbus TCP: frames in pieces of any size are whole frames") {
    for (std::size_t takes = 1; takes <= 12; ++takes) {
        for (std::size_t gives = 1; gives <= 260; gives += gives < 16 ? 1 : 61) {
            scene s;
            s.peer.takes = takes;
            s.peer.gives = gives;
            s.peer.answers = answer_of_17;
            std::array<std::uint16_t, 125> words{};
            REQUIRE(s.read(words.data(), words.size()).error() == errc::ok);
            for (const std::uint16_t w : words) REQUIRE(w == 0x555A);
        }
    }
}

TEST_CASE("G2: a late Modbus TCP response is dropped by its number, however late it is") {
    scene s;
    std::uint16_t word = 0;
    CHECK(s.read(&word, 1).error() == errc::timeout);
    s.peer.us += 1'000'000; // long after the quarantine
    // The first request's response arrives right after the second request has left.
    s.peer.answered = s.peer.taken.size();
    s.peer.answers = late_and_right;
    REQUIRE(s.read(&word, 1).error() == errc::ok);
    CHECK(word == 0x555A);
}

TEST_CASE("G2: a Modbus TCP response that is late by 256 requests is dropped too") {
    scene s;
    std::uint16_t word = 0;
    for (int i = 0; i < 256; ++i) CHECK(s.read(&word, 1).error() == errc::timeout);
    s.peer.us += 1'000'000;
    s.peer.answered = s.peer.taken.size();
    s.peer.answers = late_and_right;
    REQUIRE(s.read(&word, 1).error() == errc::ok);
    CHECK(word == 0x555A);
}

TEST_CASE("Modbus TCP: a response after a late one is given, although the peer has closed") {
    scene s;
    std::uint16_t word = 0;
    CHECK(s.read(&word, 1).error() == errc::timeout);
    s.peer.us += 1'000'000;
    s.peer.answered = s.peer.taken.size();
    s.peer.answers = late_and_right;
    s.peer.ends = true;
    REQUIRE(s.read(&word, 1).error() == errc::ok);
    CHECK(word == 0x555A);
    CHECK(s.read(&word, 1).error() == errc::port_lost);
}

TEST_CASE("G2: a Modbus TCP response that arrives twice counts once") {
    scene s;
    s.peer.answers = [](const byte_list& request) {
        byte_list both = answer_of_17(request);
        const byte_list once = both;
        both.insert(both.end(), once.begin(), once.end());
        return both;
    };
    std::uint16_t word = 0;
    for (int i = 0; i < 5; ++i) REQUIRE(s.read(&word, 1).error() == errc::ok);

    const byte_list request{17, 3, 1, 0, 0, 1, 0, 0};
    REQUIRE(s.port.send(request));
    std::array<std::uint8_t, 64> got{};
    const transfer response = s.port.receive(got);
    REQUIRE(response);
    CHECK(*response == 7);
    for (int i = 0; i < 5; ++i) {
        const transfer more = s.port.receive(got); // to the line it would be noise, and start a quarantine
        REQUIRE(more);
        CHECK(*more == 0);
    }
}

TEST_CASE(
    "G16, G33: a write is unknown if its connection is lost after any byte of it has left, and is not sent "
    "again") {
    for (std::size_t left = 0; left <= 12; ++left) {
        CAPTURE(left);
        scene s;
        s.peer.breaks_after = left;
        client at{s.wire, node<scene::unlisted>{17}};
        const status first = at.write_word(0x0100, 1);
        CHECK(first.error() == (left < 12 ? errc::port_lost : errc::timeout)); // 12 are all of it
        CHECK(first.outcome() == (left == 0 ? outcome::not_sent : outcome::unknown));
        CHECK(at.write_word(0x0100, 1).outcome() == outcome::not_sent); // the port is gone
        CHECK(s.peer.taken.size() == left);
    }
}

TEST_CASE("Modbus TCP: what is no frame ends the connection, and none of its bytes is used") {
    const byte_list wrong[] = {
        {0, 1, 0, 1, 0, 5, 17, 3, 2, 0x55, 0x5A},       // another protocol
        {0, 1, 1, 0, 0, 5, 17, 3, 2, 0x55, 0x5A},       // the same by its high byte
        {0, 1, 0, 0, 0, 1, 17},                         // too short
        {0, 1, 0, 0, 1, 0, 17, 3, 2, 0x55, 0x5A},       // too long
        {0, 1, 0, 0, 0xFF, 0xFF, 17, 3, 2, 0x55, 0x5A}, // no length
    };
    for (const byte_list& w : wrong) {
        scene s;
        s.peer.answers = nullptr;
        std::uint16_t word = 0;
        for (const std::uint8_t b : w) s.peer.coming.push_back(b);
        (void)s.port.send(byte_list{17, 3, 1, 0, 0, 1, 0, 0});
        std::array<std::uint8_t, 16> got{};
        CHECK(s.port.receive(got).error() == errc::port_lost);
        CHECK(s.port.send(byte_list{17, 3, 1, 0, 0, 1, 0, 0}).error() == errc::port_lost);
        CHECK(s.read(&word, 1).error() == errc::port_lost);
        CHECK(s.port.stream().is_closed);
        CHECK(s.port.is_foreign());
        REQUIRE(s.port.open(&s.peer) == errc::ok); // a new connection
        s.peer.coming.clear();
        s.peer.answered = s.peer.taken.size();
        s.peer.answers = answer_of_17;
        CHECK(s.read(&word, 1).error() == errc::ok);
        CHECK_FALSE(s.port.is_foreign());
    }
}

TEST_CASE("Modbus TCP: a connection that is lost is reported in each call") {
    scene s;
    s.peer.answers = [](const byte_list& request) {
        byte_list half = answer_of_17(request);
        half.resize(half.size() / 2);
        return half;
    };
    std::uint16_t word = 0;
    CHECK(s.read(&word, 1).error() == errc::timeout);
    s.peer.lost = errc::port_lost; // in the middle of the response
    CHECK(s.read(&word, 1).error() == errc::port_lost);
    CHECK_FALSE(s.port.is_foreign());
    s.peer.lost = errc::ok; // a stream that answers again is another one, and not asked
    CHECK(s.read(&word, 1).error() == errc::port_lost);
}

TEST_CASE("G33: a request of which a part has left leaves completely, and nothing before it has") {
    scene s;
    s.peer.takes = 1;
    const byte_list first{17, 6, 1, 0, 0, 1, 0, 0};
    const byte_list second{17, 6, 1, 0, 0, 2, 0, 0};
    auto n = s.port.send(first);
    REQUIRE(n);
    CHECK(*n == first.size());
    while (!s.port.sent()) {}
    CHECK(s.peer.taken == byte_list{0, 1, 0, 0, 0, 6, 17, 6, 1, 0, 0, 1});

    s.peer.takes = 0; // the network is full: the frame waits here, and the line gives its exchange up
    n = s.port.send(second);
    REQUIRE(n);
    CHECK_FALSE(s.port.sent());
    n = s.port.send(first);
    REQUIRE(n);
    CHECK(*n == 0);
    s.peer.takes = 5;
    while (!s.port.sent()) {}
    CHECK(s.peer.taken.size() == 24);
    CHECK(byte_list(s.peer.taken.begin() + 12, s.peer.taken.end()) ==
          byte_list{0, 2, 0, 0, 0, 6, 17, 6, 1, 0, 0, 2});
}

TEST_CASE("Modbus TCP: a connection that is lost while a request waits to leave takes no other") {
    scene s;
    s.peer.takes = 0;
    REQUIRE(s.port.send(byte_list{17, 6, 1, 0, 0, 1, 0, 0}));
    s.peer.lost = errc::send_failed;
    CHECK(s.port.send(byte_list{17, 6, 1, 0, 0, 2, 0, 0}).error() == errc::send_failed);
    s.peer.lost = errc::ok;
    s.peer.takes = 1000;
    CHECK(s.port.send(byte_list{17, 6, 1, 0, 0, 2, 0, 0}).error() == errc::port_lost);
    CHECK(s.port.sent()); // nothing more will leave
    CHECK(s.peer.taken.empty());
}

TEST_CASE("Modbus TCP: a request has left once the stream has sent it") {
    scene s;
    s.peer.is_draining = true;
    REQUIRE(s.port.send(byte_list{17, 3, 1, 0, 0, 1, 0, 0}));
    CHECK(s.peer.taken.size() == 12);
    CHECK_FALSE(s.port.sent());
    s.peer.is_draining = false;
    CHECK(s.port.sent());
}

TEST_CASE("Modbus TCP: a wait ends at once while bytes of a response are left to take") {
    scene s;
    s.peer.answers = answer_of_17;
    REQUIRE(s.port.send(byte_list{17, 3, 1, 0, 0, 1, 0, 0}));
    std::array<std::uint8_t, 6> most{};
    const transfer first = s.port.receive(most);
    REQUIRE(first);
    CHECK(*first == 6); // of 7
    const std::uint32_t began = s.peer.us;
    s.port.wait(milliseconds(5));
    CHECK(s.peer.us == began);
    const transfer last = s.port.receive(most);
    REQUIRE(last);
    CHECK(*last == 1);
    s.port.wait(milliseconds(5)); // for the next frame
    CHECK(s.peer.us == began + 5000);
}

TEST_CASE("G2: a Modbus TCP response that comes before any request is dropped, whatever its number") {
    for (const std::uint8_t number : {std::uint8_t{0}, std::uint8_t{1}}) {
        CAPTURE(number);
        scene s;
        for (const std::uint8_t b : byte_list{0, number, 0, 0, 0, 5, 17, 3, 2, 0xDE, 0xAD})
            s.peer.coming.push_back(b);
        std::array<std::uint8_t, 16> got{};
        const transfer nothing = s.port.receive(got);
        REQUIRE(nothing);
        CHECK(*nothing == 0);
        s.peer.answers = answer_of_17;
        std::uint16_t word = 0;
        REQUIRE(s.read(&word, 1).error() == errc::ok);
        CHECK(word == 0x555A);
    }
}

TEST_CASE("G32: what is no RTU frame is not sent") {
    scene s;
    CHECK(s.port.send(byte_list{17, 3, 0}).error() == errc::send_failed);
    CHECK(s.port.send(byte_list(257)).error() == errc::send_failed);
    CHECK(s.peer.taken.empty());
}

TEST_CASE("Modbus TCP: units 255 and 0 are the device at the other end, and its response is awaited") {
    for (const std::uint8_t unit : {std::uint8_t{255}, std::uint8_t{0}}) {
        CAPTURE(unit);
        scene s;
        if (unit != 255) s.port.set_peer_unit(unit);
        bool is_silent = false;
        s.peer.answers = [&](const byte_list& request) {
            if (is_silent) return byte_list{};
            byte_list r{request[0], request[1], 0, 0, 0, 6, request[6]};
            r.insert(r.end(), request.begin() + 7, request.begin() + 12); // a write is repeated
            if (request[7] == 3) r = {request[0], request[1], 0, 0, 0, 5, request[6], 3, 2, 0x12, 0x34};
            return r;
        };
        client peer{s.wire, peer_node<scene::unlisted>{}};
        std::uint16_t word[1]{};
        REQUIRE(peer.read_words(7, word).error() == errc::ok);
        CHECK(word[0] == 0x1234);
        CHECK(s.peer.taken == byte_list{0, 1, 0, 0, 0, 6, unit, 3, 0, 7, 0, 1});
        CHECK(peer.write_word(8, 5));
        std::array<std::uint8_t, 5> response{};
        CHECK(peer.transact(byte_list{6, 0, 8, 0, 5}, response));
        is_silent = true;
        const status lost = peer.write_word(8, 5); // no broadcast: it is not done without a response
        CHECK(lost.error() == errc::timeout);
        CHECK(lost.was_sent());
        peer.node().address = 17; // then it is no peer any more
        CHECK(peer.write_word(8, 5).error() == errc::bad_argument);
    }
}

TEST_CASE("Modbus TCP: a response of another unit is not the peer's, and a broadcast stays one") {
    scene s;
    s.port.set_peer_unit(0);
    s.peer.answers = [&](const byte_list& request) {
        byte_list r{request[0], request[1], 0, 0, 0, 5, 17, 3, 2, 0x12, 0x34};
        return request[7] == 3 ? r : byte_list{request[0], request[1], 0, 0, 0, 3, request[6], 0x86, 0x0A};
    };
    client peer{s.wire, peer_node<scene::unlisted>{}};
    std::uint16_t word[1]{};
    CHECK(peer.read_words(7, word).error() == errc::timeout);
    client all{s.wire, node<scene::unlisted>{17}};
    static constexpr reg<u16, access::rw, scene::unlisted> row{8, full<u16>, no_unit, 0};
    CHECK(all.broadcast<row>(5).error() == errc::gateway_exception);
    s.peer.answers = nullptr;
    CHECK(all.broadcast<row>(5)); // nobody refuses it
}

} // namespace mbap_port_tests
