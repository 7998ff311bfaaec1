// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A port that opens itself again, over a scripted one in virtual time. Checks who finds the loss, when attempts are
// made, and that no frame crosses a loss.
#include <array>
#include <cstdint>
#include <deque>
#include <string>
#include <type_traits>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/client/client.hpp>
#include <servobus/line/blocking_line.hpp>
#include <servobus/line/line.hpp>
#include <servobus/line/mbap_port.hpp>
#include <servobus/line/reconnecting.hpp>

#include <tests/support/loop_bound.hpp>

namespace reconnecting_tests {

using namespace servobus;

namespace {

using byte_list = std::vector<std::uint8_t>;
constexpr std::array<std::uint8_t, 8> eight{17, 3, 1, 0, 0, 1, 0x86, 0xA6};

/// A computer with one socket for an adapter.
struct computer {
    errc opens = errc::ok;  // how the next attempts end
    bool is_plugged = true; // false: what is open is lost in the next call
    duration opening{};     // how long an attempt takes
    std::uint64_t us = 0;
    std::vector<std::uint64_t> attempts{}; // when they ended
    std::vector<std::string> names{};      // of the attempts
    byte_list taken{};                     // all that has left
    std::deque<std::uint8_t> coming{};
    unsigned expected = 0;
    unsigned closed = 0;
    unsigned aborted = 0;
};

template <bool IsNetwork> class adapter {
  public:
    static constexpr bool is_network = IsNetwork;
    struct endpoint {
        computer* in = nullptr;
        const char* name = "adapter";
        int settings = 5;
    };

    status open(const endpoint& at) {
        CHECK(at.settings == 5);
        in_ = at.in;
        in_->us += in_->opening.us;
        in_->attempts.push_back(in_->us);
        in_->names.push_back(at.name);
        is_open_ = in_->opens == errc::ok && in_->is_plugged;
        in_->coming.clear();
        return in_->opens != errc::ok ? in_->opens : is_open_ ? errc::ok : errc::no_such_port;
    }
    void close() {
        is_open_ = false;
        ++in_->closed;
    }
    void abort() requires IsNetwork {
        is_open_ = false;
        ++in_->aborted;
    }
    bool is_open() const { return is_open_; }
    unsigned attempts() const { return static_cast<unsigned>(in_->attempts.size()); }

    transfer send(bytes out) {
        if (!lives()) return errc::port_lost;
        in_->taken.insert(in_->taken.end(), out.begin(), out.end());
        return static_cast<std::uint16_t>(out.size());
    }
    bool sent() { return is_open_; } // a closed one of this kind never says so
    transfer receive(byte_buffer to) {
        if (!lives()) return errc::port_lost;
        std::uint16_t n = 0;
        for (; n < to.size() && !in_->coming.empty(); in_->coming.pop_front()) to[n++] = in_->coming.front();
        return n;
    }
    instant now() const { return {static_cast<std::uint32_t>(in_->us += 2)}; }
    void wait(duration d) {
        in_->us += d.us;
        (void)lives();
    }
    void expect(std::uint16_t missing) requires(!IsNetwork) { in_->expected = missing; }

  private:
    bool lives() { return is_open_ = is_open_ && in_->is_plugged; }

    computer* in_ = nullptr;
    bool is_open_ = false;
};

struct unlisted {
    static constexpr profile facts{
        .name = "unlisted", .limits = {.response = milliseconds(50)}, .read_retries = 0};
};

using device = adapter<false>;
using connection = adapter<true>;

static_assert(reopenable_port<device> && reopenable_port<connection>);
static_assert(!reopenable_port<reconnecting<device>>);
static_assert(expecting_port<reconnecting<device>>);
static_assert(waiting_port<reconnecting<connection>> && !expecting_port<reconnecting<connection>>);
static_assert(!has_gateway<reconnecting<connection>> && has_gateway<reconnecting<mbap_port<connection>>>);
static_assert(!std::is_copy_constructible_v<reconnecting<device>>);

template <class Port> struct scene {
    computer at{};
    reconnecting<Port> port{&at};

    transfer send() { return port.send(eight); }
    transfer receive() {
        std::array<std::uint8_t, 16> room{};
        return port.receive(room);
    }
    void pass(std::uint32_t ms) { at.us += std::uint64_t{ms} * 1000u; }
    // Calls the closed port each 100 us until it is open. No call before that may succeed.
    void call_until_open() {
        const std::size_t before = at.taken.size();
        for (tests::loop_bound left{"the port is open again"}; !port.is_open(); left.use()) {
            CHECK(send().error() == errc::port_lost);
            at.us += 100;
        }
        CHECK(at.taken.size() == before);
    }
    // The pauses before each of the last attempts, in ms, rounded down.
    std::vector<unsigned> pauses(std::uint64_t from) const {
        std::vector<unsigned> all;
        for (const std::uint64_t end : at.attempts) {
            if (end <= from) continue;
            all.push_back(static_cast<unsigned>((end - at.opening.us - from) / 1000));
            from = end;
        }
        return all;
    }
};

} // namespace

TEST_CASE_TEMPLATE("G47: the constructor makes the first attempt, and a port that fails it is tried again", P,
                   device, connection) {
    scene<P> s;
    CHECK(s.at.attempts.size() == 1);
    CHECK(s.port.is_open());
    CHECK(s.port.why());
    CHECK(s.port.take_change());
    CHECK_FALSE(s.port.take_change());
    CHECK(s.send().value_or(0) == 8); // it was opened before the line asked anything of it
    for (const errc why : {errc::no_such_port, errc::no_permission, errc::port_in_use, errc::bad_argument}) {
        computer at;
        at.opens = why;
        reconnecting<P> port{&at};
        CHECK_FALSE(port.is_open());
        CHECK(port.why() == why);
        CHECK(port.take_change()); // a failure of the first attempt is a change too
        CHECK_FALSE(port.take_change());
        at.opens = errc::ok;
        CHECK(port.send(eight).error() == errc::port_lost); // its pause has not passed
        at.us += 500'000;
        CHECK(port.send(eight).error() == errc::port_lost); // it opens the port
        CHECK(port.is_open());
        CHECK(port.take_change());
        CHECK(at.taken.empty());
        CHECK(port.send(eight).value_or(0) == 8);
        CHECK(at.taken.size() == 8);
    }
}

TEST_CASE("G47: a loss is reported by the call that finds it, and by the one that opens the port again") {
    for (const int finds : {0, 1, 2, 3}) {
        CAPTURE(finds);
        scene<device> s;
        (void)s.port.take_change();
        REQUIRE(s.send().value_or(0) == 8);
        s.at.is_plugged = false;
        if (finds == 0) CHECK(s.send().error() == errc::port_lost);
        if (finds == 1) CHECK(s.receive().error() == errc::port_lost);
        if (finds == 2) s.port.wait(milliseconds(1));
        if (finds == 3) s.port.drop();
        const std::uint64_t lost = s.at.us;
        CHECK_FALSE(s.port.is_open());
        CHECK(s.port.why() == errc::port_lost);
        CHECK(s.port.sent()); // nothing is left to send
        CHECK(s.port.take_change());
        CHECK_FALSE(s.port.take_change());
        s.at.is_plugged = true;
        s.pass(400);
        CHECK(s.at.attempts.size() == 1);
        s.call_until_open();
        CHECK(s.at.attempts.size() == 2);
        CHECK(s.pauses(lost).back() == 500);
        CHECK(s.port.why());
        CHECK(s.port.take_change());
        CHECK_FALSE(s.port.take_change());
        CHECK(s.send().value_or(0) == 8);
        CHECK(s.receive().value_or(9) == 0);
        CHECK(s.at.taken.size() == 16);
    }
}

TEST_CASE("G47: a loss that `wait` has found is reported also if the pause has passed since") {
    scene<device> s;
    s.at.is_plugged = false;
    s.port.wait(milliseconds(1));
    CHECK(s.port.take_change());
    s.at.is_plugged = true;
    s.pass(60'000);
    CHECK(s.receive().error() == errc::port_lost); // the first call, which opens it
    CHECK(s.port.is_open());
    CHECK(s.receive().value_or(9) == 0);
}

TEST_CASE(
    "G47: a device is tried every 500 ms, also where an attempt takes long, and `why` follows the attempts") {
    for (const std::uint32_t opening : {0u, 700u}) {
        CAPTURE(opening);
        scene<device> s;
        s.at.us = 0xFFFF'FFFFu - 1'000'000u; // the clock wraps meanwhile
        s.at.opening = milliseconds(opening);
        s.at.is_plugged = false;
        (void)s.send();
        (void)s.port.take_change();
        const std::uint64_t lost = s.at.us;
        const std::array<errc, 4> reasons{errc::no_such_port, errc::no_such_port, errc::no_permission,
                                          errc::port_in_use};
        for (const errc why : reasons) {
            s.at.opens = why;
            const std::size_t before = s.at.attempts.size();
            for (tests::loop_bound left{"an attempt"}; s.at.attempts.size() == before; left.use()) {
                CHECK(s.receive().error() == errc::port_lost);
                s.at.us += 100;
            }
            CHECK(s.port.why() == why);
            CHECK_FALSE(s.port.take_change()); // another reason is no change
        }
        s.at.opens = errc::ok;
        s.at.is_plugged = true;
        s.call_until_open();
        CHECK(s.pauses(lost) == std::vector<unsigned>{500, 500, 500, 500, 500});
        CHECK(s.port.take_change());
    }
}

TEST_CASE("G47: attempts to connect become rarer until a byte comes") {
    scene<connection> s;
    s.at.coming.push_back(1);
    CHECK(s.receive().value_or(0) == 1);
    s.at.opens = errc::timeout;
    s.at.opening = milliseconds(300);
    s.at.is_plugged = false;
    (void)s.send();
    std::uint64_t from = s.at.us;
    for (tests::loop_bound left{"eight attempts"}; s.at.attempts.size() < 9; left.use()) {
        (void)s.send();
        s.at.us += 100;
    }
    CHECK(s.pauses(from) == std::vector<unsigned>{100, 200, 400, 800, 1600, 3200, 3200, 3200});
    // A peer that accepts and closes has sent no byte.
    s.at.opens = errc::ok;
    for (int i = 0; i < 2; ++i) {
        s.at.is_plugged = true;
        from = s.at.us;
        s.call_until_open();
        CHECK(s.pauses(from).front() >= 3199);
        s.at.is_plugged = false;
        CHECK(s.receive().error() == errc::port_lost);
    }
    s.at.is_plugged = true;
    s.call_until_open();
    CHECK(s.receive().value_or(9) == 0); // no byte
    s.at.coming.push_back(1);
    CHECK(s.receive().value_or(9) == 1);
    s.port.drop();
    CHECK(s.at.aborted == 1); // what had not left is not sent any more
    CHECK(s.at.closed == 0);
    from = s.at.us;
    s.call_until_open();
    CHECK(s.pauses(from) == std::vector<unsigned>{100});
}

TEST_CASE("G47: a device that is lost again right after it was opened costs one attempt each 500 ms") {
    scene<device> s;
    const std::uint64_t start = s.at.us;
    for (tests::loop_bound left{"twenty attempts"}; s.at.attempts.size() < 21; left.use()) {
        s.at.is_plugged = s.port.is_open() ? false : true;
        CHECK(s.send().error() == errc::port_lost);
        s.at.us += 100;
    }
    CHECK(s.at.us - start >= 20u * 500'000u);
    CHECK(s.at.taken.empty());
}

TEST_CASE("G47: the endpoint may change, and counts from the next attempt on") {
    scene<device> s;
    s.port.set_endpoint({&s.at, "the other socket"});
    CHECK(s.send().value_or(0) == 8);
    CHECK(s.at.names == std::vector<std::string>{"adapter"});
    s.at.is_plugged = false;
    (void)s.send();
    s.at.is_plugged = true;
    s.call_until_open();
    CHECK(s.at.names == std::vector<std::string>{"adapter", "the other socket"});
    CHECK(s.port.port().attempts() == 2);
    s.port.drop();
    CHECK(s.at.closed == 1);
    s.port.drop(); // nothing is open
    s.call_until_open();
}

TEST_CASE("it passes on to its port what a line asks of it") {
    scene<device> s;
    const instant before = s.port.now();
    s.port.wait(milliseconds(3));
    CHECK(since(before, s.port.now()) >= milliseconds(3));
    s.port.expect(7);
    CHECK(s.at.expected == 7);
    CHECK(s.port.sent());
}

TEST_CASE("G47: a line sees each loss, and a request that the loss has cut is unknown") {
    scene<device> s;
    line<reconnecting<device>> wire{s.port, modbus::timing_at(115200)};
    client at{wire, node<unlisted>{17}};
    std::array<std::uint16_t, 1> word{};
    const auto read = [&] { return at.read_words(0x0100, word); };
    CHECK(read() == errc::timeout);
    const epoch first = wire.epoch(17);
    // It is lost while the response is awaited.
    s.at.is_plugged = false;
    CHECK(read() == errc::port_lost);
    CHECK(read().outcome() == outcome::not_sent);
    const epoch lost = wire.epoch(17);
    CHECK_FALSE(lost == first);
    s.at.is_plugged = true;
    s.pass(500);
    const std::size_t before = s.at.taken.size();
    CHECK(read() == errc::port_lost); // it opens the port
    CHECK(s.port.is_open());
    CHECK(s.at.taken.size() == before);
    CHECK(read() == errc::timeout);
    CHECK(s.at.taken.size() == before + 8);
}

TEST_CASE("Modbus TCP is opened again as a connection, with its peer's unit") {
    using modbus_tcp = mbap_port<connection>;
    computer at;
    reconnecting<modbus_tcp> port{&at};
    port.set_peer_unit(0);
    std::array<std::uint8_t, 8> to_peer{255, 3, 1, 0, 0, 1, 0, 0};
    CHECK(port.send(to_peer).value_or(0) == 8);
    CHECK(at.taken == byte_list{0, 1, 0, 0, 0, 6, 0, 3, 1, 0, 0, 1});
    for (const std::uint8_t b : byte_list{1, 3, 2, 0, 1, 0, 0, 9})
        at.coming.push_back(b); // no frame of Modbus TCP
    std::array<std::uint8_t, 16> room{};
    CHECK(port.receive(room).error() == errc::port_lost);
    CHECK(port.port().is_foreign());
    CHECK_FALSE(port.is_open());
    CHECK(port.sent());
    at.us += 100'000;
    CHECK(port.receive(room).error() == errc::port_lost);
    CHECK(port.is_open());
    CHECK_FALSE(port.port().is_foreign());
    at.taken.clear();
    CHECK(port.send(to_peer).value_or(0) == 8);
    CHECK(at.taken == byte_list{0, 2, 0, 0, 0, 6, 0, 3, 1, 0, 0, 1});
    port.drop();
    CHECK(at.aborted == 1);
    CHECK_FALSE(port.is_open());
    CHECK_FALSE(port.port().is_open());
    modbus_tcp closed;
    CHECK(closed.open(connection::endpoint{&at}) == errc::ok);
    CHECK(closed.is_open());
    closed.close();
    CHECK_FALSE(closed.is_open());
    CHECK(closed.receive(room).error() == errc::port_lost);
}

} // namespace reconnecting_tests
