// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The probe of a ZLAC8015D finds the switches of the simulated drive as they were set, in any combination.
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/core/bytes.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <examples/servobus/interpretations/zlac8015d_switches.hpp>
#include <examples/servobus/probe/zlac8015d.hpp>

namespace probe_zlac8015d_tests {
namespace {

using namespace servobus;
namespace z = servobus::zlac8015d;
using tool::findings;
using tool::seen;

std::vector<std::uint8_t> content_of(std::span<const std::uint16_t> words) {
    std::vector<std::uint8_t> content;
    for (const std::uint16_t word : words) {
        content.push_back(static_cast<std::uint8_t>(word >> 8));
        content.push_back(static_cast<std::uint8_t>(word & 0xFFu));
    }
    return content;
}

// A simulated drive, and a person who sees its brake.
class bench final : public tool::probe_bench {
  public:
    explicit bench(const sim::zlac8015d_options& chosen) : model{chosen} { pass(milliseconds(1)); }

    sim::zlac8015d model;
    bool consents = true;
    bool has_brake = true;
    bool switches = true;           // the person does
    std::uint32_t lost_after = ~0u; // requests
    std::uint32_t lost_for = 3;     // requests
    instant lost_at{};
    std::uint32_t requests = 0;
    std::uint32_t fastest = 0; // r/min
    std::vector<std::string> asked{};

    /// After what a person has sent to it.
    void come_to_rest() { pass(milliseconds(1000)); }

  private:
    static constexpr duration per_request = milliseconds(4);

    void pass(duration d) {
        for (std::uint32_t us = 0; us < d.us; us += 1000) {
            now_ = now_ + milliseconds(1);
            model.advance(now_);
            for (const std::int64_t speed : {model.left().speed, model.right().speed}) {
                const auto r = static_cast<std::uint32_t>((speed < 0 ? -speed : speed) / 1'000'000);
                if (r > fastest) fastest = r;
            }
        }
    }
    bool is_lost() {
        const instant sent = now_;
        pass(per_request);
        if (++requests <= lost_after || requests - lost_after > lost_for) return false;
        if (requests == lost_after + 1) lost_at = sent;
        pass(response_limit() + milliseconds(100)); // and the quarantine
        return true;
    }
    bool read_now(std::uint16_t address, std::span<std::uint16_t> words) override {
        return !is_lost() && model.read(address, words) == 0;
    }
    bool responds(std::uint16_t address) override {
        std::uint16_t word[1]{};
        return read_now(address, word);
    }
    written write_now(std::uint16_t address, std::span<const std::uint16_t> words) override {
        if (is_lost()) return written::unknown;
        return model.write(address, words_view{content_of(words)}) == 0 ? written::yes : written::refused;
    }
    void wait_now(duration time) override { pass(time); }
    seen ask_now(const std::string& question) override {
        asked.push_back(question);
        if (!has_brake) return seen::unknown;
        return model.left().is_brake_engaged ? seen::yes : seen::no;
    }
    bool has_consent(const std::string&) override { return consents; }
    bool power_cycle() override {
        if (!switches) return false;
        CHECK(model.stands_still());
        model.power_cycle();
        pass(milliseconds(500));
        return true;
    }

    seen bad_crc_now() override { return seen::unknown; }
    seen look_at(std::uint8_t) override { return seen::unknown; }
    std::optional<std::uint16_t> count_now(std::uint16_t, std::uint16_t) override { return std::nullopt; }
    instant clock() const override { return now_; }
    duration response_limit() const override { return milliseconds(100); }

    instant now_{};
};

// A number for each switch, from a number for all of them.
std::vector<unsigned> ways_of(std::uint32_t combination) {
    std::vector<unsigned> ways;
    for (const tool::interpretation& i : tool::zlac8015d_interpretations) {
        ways.push_back(combination % static_cast<unsigned>(i.ways.size()));
        combination /= static_cast<unsigned>(i.ways.size());
    }
    return ways;
}
constexpr std::uint32_t combinations = [] {
    std::uint32_t n = 1;
    for (const tool::interpretation& i : tool::zlac8015d_interpretations)
        n *= static_cast<unsigned>(i.ways.size());
    return n;
}();
static_assert(combinations == 196608);

findings probed(bench& on) {
    findings found{tool::zlac8015d_interpretations};
    tool::zlac8015d_probe{on, found}.run();
    return found;
}

std::uint16_t status_of(sim::zlac8015d& model) {
    std::uint16_t word[1]{};
    REQUIRE(model.read(z::status_word.address, word) == 0);
    return word[0];
}

// The words that a power cycle would not bring back.
std::vector<std::uint16_t> words_of(sim::zlac8015d& model) {
    std::vector<std::uint16_t> words;
    for (std::uint16_t address = 0x2000; address < 0x20A0; ++address) {
        if (address != z::control_word.address) words.push_back(model.peek(address));
    }
    return words;
}

} // namespace

TEST_CASE("the probe of a ZLAC8015D finds each switch in any combination, and leaves the drive as it was") {
    // A step that shares no factor with the ways, so that each is played with each other.
    for (std::uint32_t n = 0; n < combinations; n += 397) {
        CAPTURE(n);
        const std::vector<unsigned> ways = ways_of(n);
        bench on{tool::options_of(tool::zlac8015d_switches, ways)};
        const std::vector<std::uint16_t> before = words_of(on.model);
        const findings found = probed(on);
        for (std::size_t i = 0; i < ways.size(); ++i) {
            CAPTURE(std::string{tool::zlac8015d_interpretations[i].name});
            REQUIRE(found.way(i));
            CHECK(*found.way(i) == ways[i]);
        }
        CHECK_FALSE(on.has_failed());
        CHECK_FALSE(on.model.enabled());
        CHECK(on.model.stands_still());
        CHECK(words_of(on.model) == before);
        CHECK(on.fastest <= 6);
    }
}

TEST_CASE("a probe without consent moves nothing, and leaves open what it did not see") {
    bench on{{}};
    on.consents = false;
    on.switches = false;
    const std::vector<std::uint16_t> before = words_of(on.model);
    const findings found = probed(on);
    CHECK(on.model.enables() == 0);
    CHECK(on.fastest == 0);
    CHECK(on.asked.empty());
    std::size_t open = 0;
    for (std::size_t i = 0; i < found.all().size(); ++i) open += !found.way(i);
    CHECK(open == 15); // all but the code of a fault and what 2014h takes
    CHECK(words_of(on.model) == before);
}

TEST_CASE("a ZLAC8015D that is not switched off after a save keeps its own words, whatever it saves") {
    for (const unsigned save : {0u, 1u}) {
        CAPTURE(save);
        std::vector<unsigned> ways = ways_of(0);
        ways[1] = save;
        bench on{tool::options_of(tool::zlac8015d_switches, ways)};
        on.switches = false;
        const std::vector<std::uint16_t> before = words_of(on.model);
        CHECK_FALSE(probed(on).way(1));
        CHECK(words_of(on.model) == before);
        on.model.power_cycle();
        CHECK(words_of(on.model) == before);
    }
}

TEST_CASE("a ZLAC8015D in alarm is not probed, and that is said") {
    bench on{{}};
    on.model.raise(z::fault::none, z::fault::overload);
    const findings found = probed(on);
    CHECK(on.trouble() == "a wheel is in alarm: reset its fault, and probe again");
    CHECK(on.asked.empty());
    CHECK(on.model.writes() == 0);
    for (std::size_t i = 0; i < found.all().size(); ++i) CHECK_FALSE(found.way(i));
}

TEST_CASE("a ZLAC8015D whose 2022h is not in force yet is not probed, in whichever resolution it is") {
    for (std::uint16_t in_force = 1; in_force <= 10; ++in_force) {
        for (std::uint16_t written = 1; written <= 10; ++written) {
            CAPTURE(in_force);
            CAPTURE(written);
            bench on{{}};
            on.model.store(z::speed_resolution.address, in_force);
            on.model.power_cycle();
            REQUIRE(on.model.write(z::speed_resolution.address, words_view{content_of({{written}})}) == 0);
            const std::vector<std::uint16_t> before = words_of(on.model);
            const findings found = probed(on);
            CHECK(on.fastest <= 12);
            CHECK(words_of(on.model) == before);
            CHECK_FALSE(on.model.enabled());
            CHECK_FALSE(on.has_failed()); // it has its words back
            const bool differs_much = 10 * in_force > 16 * written || 16 * in_force < 10 * written;
            if (differs_much) CHECK_FALSE(on.trouble().empty());
            if (differs_much) CHECK(on.fastest <= 5);
            if (in_force != written) continue;
            CHECK(on.trouble().empty());
            CHECK(found.way(16) == 0u);
        }
    }
}

TEST_CASE("a person who does not know leaves it open") {
    bench on{{}};
    on.has_brake = false;
    const findings found = probed(on);
    CHECK(on.asked.size() == 1);
    CHECK_FALSE(found.way(9));
    CHECK(found.way(0));
}

TEST_CASE(
    "a line that is lost at any request ends the probe of a ZLAC8015D at rest, and it gets its words back") {
    for (const unsigned save : {0u, 1u}) {
        std::vector<unsigned> ways = ways_of(0);
        ways[1] = save; // the marked rows, or all
        const sim::zlac8015d_options chosen = tool::options_of(tool::zlac8015d_switches, ways);
        bench whole{chosen};
        const std::vector<std::uint16_t> before = words_of(whole.model);
        const std::uint16_t at_rest = status_of(whole.model);
        const auto settled = [](const findings& of) {
            std::size_t n = 0;
            for (std::size_t i = 0; i < of.all().size(); ++i) n += of.way(i) ? 1u : 0u;
            return n;
        };
        const std::size_t most = settled(probed(whole));
        std::uint32_t failed = 0; // probes that have found less
        for (std::uint32_t n = 0; n < whole.requests; n += n < 40 || n + 40 > whole.requests ? 1 : 11) {
            CAPTURE(save);
            CAPTURE(n);
            bench on{chosen};
            on.lost_after = n;
            const findings found = probed(on);
            failed += settled(found) < most ? 1u : 0u;
            CHECK(on.trouble().empty()); // nothing is concluded from what was not read
            CHECK_FALSE(on.model.enabled());
            CHECK(on.model.stands_still());
            CHECK(status_of(on.model) == at_rest);
            CHECK(words_of(on.model) == before);
            on.model.power_cycle();
            CHECK(words_of(on.model) == before);
            for (std::size_t i = 0; i < found.all().size(); ++i) {
                CAPTURE(found.all()[i].name);
                if (found.way(i)) CHECK(*found.way(i) == ways[i]);
            }
        }
        CHECK(failed > 60);
    }
}

TEST_CASE("a line that is lost for good ends the probe of a ZLAC8015D after 20 s, and it says what is left") {
    for (const unsigned save : {0u, 1u}) {
        std::vector<unsigned> ways = ways_of(0);
        ways[1] = save; // the marked rows, or all
        const sim::zlac8015d_options chosen = tool::options_of(tool::zlac8015d_switches, ways);
        bench whole{chosen};
        const std::vector<std::uint16_t> before = words_of(whole.model);
        (void)probed(whole);
        CHECK(whole.not_put_back().empty());
        CHECK(whole.unsafe().empty());
        CHECK_FALSE(whole.has_saved());
        std::size_t most = 0;
        for (std::uint32_t n = 0; n < whole.requests; n += n < 40 || n + 40 > whole.requests ? 1 : 11) {
            CAPTURE(save);
            CAPTURE(n);
            bench on{chosen};
            on.lost_after = n;
            on.lost_for = ~0u;
            (void)probed(on);
            CHECK(on.has_failed());
            CHECK(since(on.lost_at, on.now()) <= milliseconds(20'000));
            const auto put = [&](std::uint16_t address, const std::vector<std::uint16_t>& words) {
                return on.model.write(address, words_view{content_of(words)}) == 0;
            };
            for (const tool::unsafe_word& u : on.unsafe()) CHECK(put(u.address, {u.word}));
            on.come_to_rest(); // a mode is not taken before
            const auto left = on.not_put_back();
            most = left.size() > most ? left.size() : most;
            for (const tool::changed_register& c : left) {
                CAPTURE(c.address);
                CHECK((!c.is_certain || on.model.peek(c.address) == c.now[0]));
                CHECK(put(c.address, c.old));
            }
            CHECK(words_of(on.model) == before);
            if (!on.has_saved()) continue;
            CHECK(put(z::mode_of_operation.address, {0}));
            CHECK(put(z::save_parameters.address, {1}));
        }
        CHECK(most > 7);
    }
}

} // namespace probe_zlac8015d_tests
