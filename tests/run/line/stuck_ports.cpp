// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Ports that are stuck, or never empty, end each call in its time.
#include <doctest/doctest.h>

#include <servobus/line/line.hpp>

#include <tests/support/line_rig.hpp>

namespace stuck_ports_tests {

using namespace servobus;
using namespace tests::whole_line;
using tests::scripted_port;

namespace {

struct odd : scripted_port {
    std::size_t takes_in_all = 1000; ///< bytes, and then none
    std::uint64_t never_empty_from = ~std::uint64_t{};

    transfer send(bytes out) {
        const transfer took = scripted_port::send(out.size() < takes_in_all ? out : out.first(takes_in_all));
        if (took) takes_in_all -= *took;
        return took;
    }
    transfer receive(byte_buffer in) {
        const transfer came = scripted_port::receive(in);
        if (time < never_empty_from || ran_away) return came;
        in[0] = 0x55;
        return std::uint16_t{1};
    }
};

} // namespace

TEST_CASE("G29: a port that takes some bytes of a request and then no more ends the call of a line in time") {
    rig<odd> r;
    r.settle();
    r.port.most_calls = 4'000'000;
    r.port.takes_in_all = 3;
    const std::uint64_t begun = r.port.time;
    CHECK(r.run(write_one).why == status::sent(errc::partial_send));
    CHECK(r.port.time - begun <= r.bound(write_one, 8) + 200);
}

TEST_CASE("G29: a port that is never empty once a request has left ends the call of a line in time") {
    rig<odd> r;
    r.settle();
    r.port.most_calls = 4'000'000;
    r.port.device = [&](scripted_port&, const tests::sent_frame& f) { r.port.never_empty_from = f.end; };
    const std::uint64_t begun = r.port.time;
    CHECK(r.run(read_one).why == status::sent(errc::timeout));
    CHECK(r.port.time - begun <= r.bound(read_one, 7) + 200);
}

TEST_CASE("G29: a port that is never empty ends the call of a line in time, and nothing is sent") {
    rig<odd> r;
    r.settle();
    r.port.most_calls = 4'000'000;
    r.port.never_empty_from = 0;
    const std::uint64_t begun = r.port.time;
    CHECK(r.run(read_one).why == status{errc::line_busy});
    CHECK(r.port.time - begun <= r.bound(read_one, 7) + 200);
}

} // namespace stuck_ports_tests
