// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A command that fails tells the register of the step at which it ended. Judged by the frame on the wire that the drive
// has refused.
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include <doctest/doctest.h>

#include <servobus/control/command_text.hpp>
#include <servobus/servobus.hpp>

#include <examples/own_device/own_subject.hpp>
#include <tests/support/conformance_subjects.hpp>
#include <tests/support/driven_zlac8015d.hpp>

namespace where_commands_end_tests {

using namespace servobus;

namespace {

struct count {
    unsigned with_register = 0;
    unsigned without = 0;
};

/// A drive of which one of the stops does nothing.
struct refuses_control_word : sim::zlac8015d {
    std::uint8_t write(std::uint16_t address, words_view from) {
        return address == 0x200E ? std::uint8_t{4} : sim::zlac8015d::write(address, from);
    }
};

/// The address and the number of registers of the last request.
template <class Trial> std::pair<unsigned, unsigned> last_request(Trial& t) {
    std::pair<unsigned, unsigned> last{};
    for (const sim::traced_frame& f : t.trace()) {
        if (!f.is_request) continue;
        const unsigned registers = f.data[1] == 6 ? 1u : f.data[4] * 256u + f.data[5];
        last = {f.data[2] * 256u + f.data[3], registers};
    }
    REQUIRE(last.second != 0);
    return last;
}

template <class Subject, class Enable, class Command>
void refuse_each_request(const char* name, const Enable& enabled_by, const Command& wanted, count& seen) {
    for (unsigned r = 0; r < 40; ++r) {
        sim::trial<Subject> t{0};
        REQUIRE(Subject::take_over(t.drive(), t.machine()));
        REQUIRE(t.run(disable{}));
        if constexpr (!std::is_same_v<Enable, disable>) REQUIRE(t.run(enabled_by));
        t.watch({sim::mishap::refused, r});
        REQUIRE(t.drive().begin(wanted) == errc::ok);
        while (!t.drive().is_idle() && !t.has_happened(sim::mishap::refused)) t.live(microseconds(20));
        if (!t.has_happened(sim::mishap::refused)) break;
        const auto [address, registers] = last_request(t);
        REQUIRE(t.finish());
        const command_status ended = t.drive().last();
        if (ended.error() != errc::exception) continue; // a read that was not the command's own
        const std::string where = std::string{name} + ", request " + std::to_string(r);
        CAPTURE(where);
        if (!ended.has_register()) {
            ++seen.without;
            continue;
        }
        ++seen.with_register;
        CHECK(ended.register_address() >= address);
        CHECK(ended.register_address() < address + registers);
    }
}
template <class Subject> count refuse_all() {
    count seen;
    Subject::commands(
        [&](const char* name, const auto& enabled_by, const auto& wanted, const sim::expected&) {
            refuse_each_request<Subject>(name, enabled_by, wanted, seen);
        });
    refuse_each_request<Subject>("init", disable{}, init{}, seen);
    refuse_each_request<Subject>("enable", disable{}, enable{}, seen);
    return seen;
}

} // namespace

TEST_CASE("the register at which a command ended is that of the request which the drive refused") {
    CHECK(refuse_all<winch::subject>().with_register >= 10);
    CHECK(refuse_all<subjects::wheels<>>().with_register >= 30);
    const count axis = refuse_all<subjects::closed_axis<>>();
    CHECK(axis.with_register >= 15);
    CHECK(axis.without >= 5); // questions to the feedback, and the marker
    CHECK(refuse_all<subjects::servo<>>().with_register >= 30);
}

TEST_CASE("a command whose stops get no response ends at the register of one that was sent") {
    simulated::driven_zlac8015d r{};
    r.wire.faults().lost_response = 1000;             // of 1000
    const command_status ended = r.drive.run(init{}); // its last stop, 2090h, waits for a response to another
    CHECK(ended.error() == errc::timeout);
    REQUIRE(ended.has_register());
    REQUIRE_FALSE(r.log.frames.empty());
    CHECK(ended.register_address() == load_word(r.log.frames.back(), 2));
}

TEST_CASE("a stop that is refused, while others are done, leaves no register of a later step") {
    refuses_control_word model{};
    sim::station<refuses_control_word> station{model};
    sim::virtual_line wire{115200, 1};
    wire.attach(station);
    line on{wire, modbus::timing_at(115200)};
    zlac8015d::drive wheels{on, 1, unsupervised};
    const command_status ended = wheels.run(init{});
    CHECK(ended.error() == errc::exception);
    CHECK_FALSE(ended.has_register());
}

TEST_CASE("a command that is refused before anything is sent, or that is done at once, names no register") {
    sim::trial<winch::subject> t{0};
    CHECK_FALSE(t.run(enable{}).has_register());
    CHECK_FALSE(command_status{}.has_register());
    CHECK_FALSE(command_status{errc::out_of_range}.has_register());
}

TEST_CASE("commands and steps have names") {
    CHECK(std::string_view{command_text<zlac8015d::wheel_ways>} == "move_by");
    CHECK(std::string_view{command_text<init>} == "init");
    CHECK(std::string_view{command_text<yako::position_declaration>} == "declare_position");
    CHECK(std::string_view{command_text<winch::turn>} == "turn");
    CHECK(std::string_view{command_text<yako::closed_loop::home>} == "basic_home");
    for (unsigned k = 0; k <= static_cast<unsigned>(step::kind::witness); ++k) {
        CHECK(std::string_view{text(static_cast<step::kind>(k))} != "unknown");
        for (unsigned other = 0; other < k; ++other)
            CHECK(std::string_view{text(static_cast<step::kind>(k))} != text(static_cast<step::kind>(other)));
    }
}

} // namespace where_commands_end_tests
