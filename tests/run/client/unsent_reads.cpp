// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Reads whose request the port does not take, or takes in part: what the result says of it.
#include <doctest/doctest.h>

#include <cstddef>
#include <utility>

#include <tests/support/client_rig.hpp>

namespace unsent_reads_tests {

using namespace servobus;
using namespace tests::typed;

namespace {

/// Takes some bytes of the next request and fails then.
struct fails_in_send : tests::waiting_scripted_port {
    std::size_t takes = 0;
    errc why = errc::ok; ///< how the next call fails

    transfer send(bytes out) {
        if (why == errc::ok) return scripted_port::send(out);
        if (takes != 0) return scripted_port::send(out.first(std::exchange(takes, 0)));
        return std::exchange(why, errc::ok);
    }
};

/// Checks how `read` ends on a port that takes `taken` bytes and fails by `send_failed`.
template <class Read> void judge(std::size_t taken, Read read) {
    rig<fixture::device, fails_in_send> r;
    r.port.takes = taken;
    r.port.why = errc::send_failed;
    const status how = read(r.drive);
    const bool is_untouched = taken == 0;
    CHECK(how.error() == (is_untouched ? errc::send_failed : errc::partial_send));
    CHECK(how.was_sent() == !is_untouched);
    CHECK(how.outcome() == (is_untouched ? outcome::not_sent : outcome::unknown));
    CHECK(r.port.bytes_sent() == taken); // it is not repeated
    // The line is in order for the next one.
    CHECK(read(r.drive));
}

} // namespace

TEST_CASE("G16: a read of which the port has taken nothing was not sent; one of which it has taken a part is "
          "unknown") {
    for (const std::size_t taken : {std::size_t{0}, std::size_t{1}, std::size_t{7}}) {
        CAPTURE(taken);
        judge(taken, [](auto& c) { return c.template read<fixture::time>().status(); });
        judge(taken, [](auto& c) { return c.template read<fixture::position>().status(); });
        judge(taken, [](auto& c) { return c.template read<fixture::time, fixture::current>().status(); });
        judge(taken, [](auto& c) { return c.template read<fixture::steps>(1).status(); });
        judge(taken, [](auto& c) {
            u16 words[2]{};
            return c.read_words(0x0100, words);
        });
    }
}

} // namespace unsent_reads_tests
