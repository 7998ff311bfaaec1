// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The probe of a C630S finds the switches of the simulated drive as they were set, in any combination; the one that
// does not always show stays open then.
#include <string>
#include <string_view>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/core/bytes.hpp>
#include <servobus/device/c630s/catalogue.hpp>
#include <servobus/modbus/server.hpp>
#include <servobus/sim/c630s.hpp>
#include <servobus/sim/faults.hpp>

#include <examples/servobus/interpretations/c630s_switches.hpp>
#include <examples/servobus/probe/c630s.hpp>

namespace probe_c630s_tests {
namespace {

using namespace servobus;
using tool::findings;
using tool::seen;

std::vector<std::uint8_t> content_of(std::span<const std::uint16_t> words) {
    std::vector<std::uint8_t> content;
    for (const std::uint16_t w : words) {
        content.push_back(static_cast<std::uint8_t>(w >> 8));
        content.push_back(static_cast<std::uint8_t>(w & 0xFFu));
    }
    return content;
}

class bench final : public tool::probe_bench {
  public:
    explicit bench(const sim::c630s_options& chosen) : model{chosen} { pass(milliseconds(1)); }

    sim::c630s model;
    bool consents = true;
    unsigned most_power_cycles = ~0u; // that the person does
    std::uint32_t lost_after = ~0u;   // requests
    std::uint32_t lost_for = 3;       // requests
    instant lost_at{};
    std::uint32_t requests = 0;
    std::uint32_t fastest = 0; // r/min
    unsigned power_cycles = 0;
    duration slowest{}; // response

    void wait_at_the_drive() { pass(milliseconds(3000)); }

  private:
    static constexpr duration per_request = milliseconds(4);

    void pass(duration d) {
        for (std::uint32_t us = 0; us < d.us; us += 1000) {
            now_ = now_ + milliseconds(1);
            model.advance(now_);
            const std::int64_t speed = model.speed();
            const auto r = static_cast<std::uint32_t>((speed < 0 ? -speed : speed) / 1'000'000);
            if (r > fastest) fastest = r;
        }
    }
    bool is_lost() {
        const instant sent = now_;
        slowest = longer_of(slowest, per_request + model.response_delay());
        pass(per_request + model.response_delay());
        if (per_request + model.response_delay() > response_limit()) return true; // it responds too late
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
        const std::vector<std::uint8_t> content = content_of(words);
        return model.write(address, words_view{bytes{content}}) == 0 ? written::yes : written::refused;
    }
    void wait_now(duration time) override { pass(time); }
    seen ask_now(const std::string&) override { return seen::unknown; }
    bool has_consent(const std::string&) override { return consents; }
    bool power_cycle() override {
        if (power_cycles == most_power_cycles) return false;
        CHECK(model.stands_still());
        CHECK_FALSE(model.enabled());
        ++power_cycles;
        model.power_cycle();
        pass(milliseconds(500));
        return true;
    }
    seen bad_crc_now() override { return seen::unknown; }
    seen look_at(std::uint8_t) override { return seen::unknown; }
    // As the drive's server responds on the wire.
    std::optional<std::uint16_t> count_now(std::uint16_t address, std::uint16_t word) override {
        const std::uint8_t pdu[] = {
            0x10, static_cast<std::uint8_t>(address >> 8), static_cast<std::uint8_t>(address & 0xFFu), 0, 1,
            2,    static_cast<std::uint8_t>(word >> 8),    static_cast<std::uint8_t>(word & 0xFFu)};
        std::uint8_t response[253]{};
        if (modbus::respond(model, bytes{pdu}, byte_buffer{response}, model.rules()) != 5)
            return std::nullopt;
        return load_word(bytes{response}, 3);
    }
    instant clock() const override { return now_; }
    duration response_limit() const override { return milliseconds(100); }

    instant now_{};
};

findings probed(bench& on) {
    findings found{tool::c630s_interpretations};
    tool::c630s_probe{on, found}.run();
    return found;
}

// The words of its parameters: what is in force, and what the EEPROM holds.
std::vector<std::int64_t> words_of(sim::c630s& model) {
    std::vector<std::int64_t> words; // address, in force, stored
    for (const entry& e : c630s::catalogue.entries) {
        if (e.rights != access::rw || e.address >= 0x3100 || (e.address >> 8) == 0x0D) continue;
        words.push_back(e.address);
        words.push_back(model.peek(e.address));
        words.push_back(model.stored(e.address));
    }
    return words;
}

std::size_t index_of(std::string_view name) {
    std::size_t i = 0;
    while (tool::c630s_interpretations[i].name != name) ++i;
    return i;
}

// The first parameter that differs; 0 if none does.
std::int64_t difference(const std::vector<std::int64_t>& a, const std::vector<std::int64_t>& b) {
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (a[i] != b[i]) return a[i - i % 3];
    }
    return 0;
}

// A drive that answers at once has no time of its own to add. A homing command would move its owner's home, and S-ON
// changes its terminal at a power cycle either way.
bool can_show(std::string_view name, unsigned way) {
    if (name == "delay_is_additional") return way == 1;
    return name != "homing_command_ends" && name != "servo_on_waits_for_power_on";
}

} // namespace

TEST_CASE("the probe of a C630S finds the switches that show, in any combination, and leaves it as it was") {
    sim::dice dice{5};
    std::vector<std::vector<unsigned>> played;
    for (const tool::interpretation& i : tool::c630s_interpretations) played.emplace_back(i.ways.size());
    for (std::uint32_t n = 0; n < 90; ++n) {
        CAPTURE(n);
        std::vector<unsigned> ways;
        for (const tool::interpretation& i : tool::c630s_interpretations)
            ways.push_back(n == 0 ? 0 : dice.below(static_cast<std::uint32_t>(i.ways.size())));
        bench on{tool::options_of(tool::c630s_switches, ways)};
        const std::vector<std::int64_t> before = words_of(on.model);
        const findings found = probed(on);
        for (std::size_t i = 0; i < ways.size(); ++i) {
            const tool::interpretation& what = tool::c630s_interpretations[i];
            CAPTURE(std::string{what.name});
            CHECK(found.way(i).has_value() == can_show(what.name, ways[i]));
            if (!found.way(i)) continue;
            CHECK(*found.way(i) == ways[i]);
            ++played[i][ways[i]];
        }
        CHECK_FALSE(on.has_failed());
        CHECK_FALSE(on.model.enabled());
        CHECK(on.power_cycles == 2);
        CHECK(difference(words_of(on.model), before) == 0);
        CHECK(on.fastest <= 21);
        CHECK(on.model.eeprom_writes() < 60);
    }
    for (std::size_t i = 0; i < played.size(); ++i) {
        CAPTURE(std::string{tool::c630s_interpretations[i].name});
        for (std::size_t way = 0; way < played[i].size(); ++way) {
            CHECK((played[i][way] >= 3) ==
                  can_show(tool::c630s_interpretations[i].name, static_cast<unsigned>(way)));
        }
    }
}

TEST_CASE("the probe of a C630S moves nothing and keeps nothing without consent") {
    bench on{{}};
    on.consents = false;
    const std::vector<std::int64_t> before = words_of(on.model);
    const findings found = probed(on);
    CHECK(on.model.enables() == 0);
    CHECK(on.fastest == 0);
    CHECK(on.power_cycles == 0);
    CHECK(difference(words_of(on.model), before) == 0);
    CHECK(on.model.eeprom_writes() <= 2); // P0C-13 itself
    std::size_t settled = 0;
    for (std::size_t i = 0; i < found.all().size(); ++i) settled += found.way(i).has_value();
    CHECK(settled == 6);
}

TEST_CASE("nothing is left of the probe of a C630S whose person does not switch it off and on") {
    for (const unsigned most : {0u, 1u}) {
        CAPTURE(most);
        bench on{{}};
        on.most_power_cycles = most;
        const std::vector<std::int64_t> before = words_of(on.model);
        (void)probed(on);
        CHECK((on.model.enables() == 0) == (most == 0));
        CHECK(difference(words_of(on.model), before) == 0);
        on.model.power_cycle();
        CHECK(difference(words_of(on.model), before) == 0);
    }
}

TEST_CASE("a line that is lost at any request ends the probe of a C630S, which gets its words back") {
    bench whole{{}};
    const std::vector<std::int64_t> before = words_of(whole.model);
    const auto settled = [](const findings& of) {
        std::size_t n = 0;
        for (std::size_t i = 0; i < of.all().size(); ++i) n += of.way(i) ? 1u : 0u;
        return n;
    };
    const std::size_t most = settled(probed(whole));
    std::uint32_t failed = 0; // probes that have found less
    for (std::uint32_t n = 0; n < whole.requests; n += n < 80 || n + 80 > whole.requests ? 1 : 41) {
        CAPTURE(n);
        bench on{{}};
        on.lost_after = n;
        const findings found = probed(on);
        failed += settled(found) < most ? 1u : 0u;
        CHECK_FALSE(on.model.enabled());
        CHECK(on.model.stands_still());
        on.model.power_cycle();
        CHECK(difference(words_of(on.model), before) == 0);
        for (std::size_t i = 0; i < found.all().size(); ++i) {
            CAPTURE(std::string{found.all()[i].name});
            if (found.way(i)) CHECK(*found.way(i) == 0);
        }
    }
    CHECK(failed > 15);
}

TEST_CASE("a line that is lost for good ends the probe of a C630S after 20 s, and it says what is left") {
    bench whole{{}};
    const std::vector<std::int64_t> before = words_of(whole.model);
    (void)probed(whole);
    CHECK(whole.not_put_back().empty());
    CHECK(whole.unsafe().empty());
    CHECK_FALSE(whole.has_saved());
    std::size_t most = 0;
    for (std::uint32_t n = 0; n < whole.requests; n += n < 80 || n + 80 > whole.requests ? 1 : 41) {
        CAPTURE(n);
        bench on{{}};
        on.lost_after = n;
        on.lost_for = ~0u;
        (void)probed(on);
        CHECK(on.has_failed());
        CHECK(since(on.lost_at, on.now()) <= milliseconds(20'000));
        const auto put = [&](std::uint16_t address, std::span<const std::uint16_t> words) {
            const std::vector<std::uint8_t> content = content_of(words);
            return on.model.write(address, words_view{bytes{content}}) == 0;
        };
        for (const tool::unsafe_word& u : on.unsafe()) CHECK(put(u.address, {&u.word, 1}));
        on.wait_at_the_drive(); // for its standstill
        // As the command has them: the EEPROM's switch is on before words that are stored, and before its own word.
        constexpr std::uint16_t keep[] = {1};
        if (on.has_saved()) CHECK(put(c630s::eeprom_update.address, keep));
        const auto left = on.not_put_back();
        most = left.size() > most ? left.size() : most;
        for (const tool::changed_register& c : left) {
            CAPTURE(c.address);
            if (c.address == c630s::eeprom_update.address) CHECK(put(c.address, keep));
            CHECK(put(c.address, c.old));
        }
        CHECK(difference(words_of(on.model), before) == 0);
    }
    CHECK(most > 15);
}

TEST_CASE(
    "the probe of a C630S keeps its owner's way of homing, and leaves no command to be carried out again") {
    for (const bool consents : {false, true}) {
        for (unsigned homing = 0; homing < 9; homing += homing == 3 ? 5 : 1) {
            CAPTURE(consents);
            CAPTURE(homing);
            bench on{{}};
            on.consents = consents;
            const std::uint8_t content[] = {0, static_cast<std::uint8_t>(homing)};
            REQUIRE(on.model.write(c630s::homing_control.address, words_view{content}) == 0);
            const std::vector<std::int64_t> before = words_of(on.model);
            (void)probed(on);
            CHECK(difference(words_of(on.model), before) == 0);
        }
    }
}

TEST_CASE("the probe of a C630S makes no drive slower than it waits for") {
    for (const std::uint32_t own : {40u, 0u}) {
        sim::c630s_options chosen;
        chosen.delay_is_additional = own != 0;
        bench on{chosen};
        on.consents = false;
        const findings found = probed(on);
        CHECK_FALSE(on.has_failed());
        CHECK(on.slowest <= milliseconds(100));
        CHECK((found.way(index_of("delay_is_additional")) == std::optional<unsigned>{1}) == (own != 0));
    }
}

} // namespace probe_c630s_tests
