// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The probe of a YAKOTEC stepper finds the switches of the simulated drive as they were set, in any combination; the
// few that do not show stay open.
#include <string>
#include <string_view>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/core/bytes.hpp>
#include <servobus/modbus/server.hpp>
#include <servobus/sim/faults.hpp>
#include <servobus/sim/yako.hpp>

#include <examples/servobus/interpretations/yako_switches.hpp>
#include <examples/servobus/probe/yako.hpp>

namespace probe_yako_tests {
namespace {

using namespace servobus;
using tool::findings;
using tool::seen;

template <class Model> class bench final : public tool::probe_bench {
  public:
    explicit bench(const sim::yako_options& chosen) : model{chosen} { pass(milliseconds(1)); }

    Model model;
    bool consents = true;
    unsigned most_power_cycles = ~0u; // that the person does
    std::uint32_t lost_after = ~0u;   // requests
    std::uint32_t lost_for = 3;       // requests
    instant lost_at{};
    std::uint32_t requests = 0;
    std::uint32_t fastest = 0; // r/min
    unsigned power_cycles = 0;

  private:
    static constexpr duration per_request = milliseconds(4);

    void pass(duration d) {
        for (std::uint32_t us = 0; us < d.us; us += 1000) {
            now_ = now_ + milliseconds(1);
            model.advance(now_);
            const std::int64_t speed = model.view().speed;
            const auto r = static_cast<std::uint32_t>((speed < 0 ? -speed : speed) / 1'000'000);
            if (r > fastest) fastest = r;
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
        std::vector<std::uint8_t> content;
        for (const std::uint16_t w : words) {
            content.push_back(static_cast<std::uint8_t>(w >> 8));
            content.push_back(static_cast<std::uint8_t>(w & 0xFFu));
        }
        return model.write(address, words_view{bytes{content}}) == 0 ? written::yes : written::refused;
    }
    void wait_now(duration time) override { pass(time); }
    seen ask_now(const std::string&) override { return seen::unknown; }
    bool has_consent(const std::string&) override { return consents; }
    bool power_cycle() override {
        if (power_cycles == most_power_cycles) return false;
        CHECK(model.view().speed == 0);
        ++power_cycles;
        model.power_cycle();
        pass(milliseconds(500));
        return true;
    }
    // As the drive's server responds to a frame on the wire.
    seen bad_crc_now() override {
        modbus::server<Model> server{model.address(), model, modbus::timing_at(model.baud())};
        const auto good = modbus::read_frame(model.address(), 0x0007, 1);
        const bytes sent = good;
        std::vector<std::uint8_t> frame{sent.begin(), sent.end()};
        frame.back() ^= 0x55u;
        server.feed(bytes{frame}, now_);
        pass(milliseconds(10));
        server.elapse(now_);
        return server.response(now_).empty() ? seen::no : seen::yes;
    }
    seen look_at(std::uint8_t node) override { return model.address() == node ? seen::yes : seen::no; }
    std::optional<std::uint16_t> count_now(std::uint16_t, std::uint16_t) override { return std::nullopt; }
    instant clock() const override { return now_; }
    duration response_limit() const override { return milliseconds(100); }

    instant now_{};
};

template <class Model> findings probed(bench<Model>& on) {
    findings found{tool::yako_interpretations};
    tool::yako_probe{on, found, std::is_same_v<Model, sim::yako_closed_loop>}.run();
    return found;
}

std::size_t index_of(std::string_view name) {
    std::size_t i = 0;
    while (tool::yako_interpretations[i].name != name) ++i;
    return i;
}
std::string_view way_of(std::string_view name, const std::vector<unsigned>& ways) {
    const std::size_t i = index_of(name);
    return tool::yako_interpretations[i].ways[ways[i]];
}

// The words of its parameters, without the two registers of commands.
template <class Model> std::vector<std::uint16_t> words_of(Model& model) {
    std::vector<std::uint16_t> words;
    for (std::uint16_t address = 0x0010; address < 0x010D; ++address) {
        if (address != 0x0027 && address != 0x002D) words.push_back(model.peek(address));
    }
    return words;
}

template <class Model> bool is_released(Model& model) {
    std::uint16_t word[1]{};
    REQUIRE(model.read(servobus::yako::status_word.address, word) == 0);
    return (word[0] & servobus::yako::motion_status::released_bit) != 0;
}

// Whether the readings of these drives can tell.
bool can_show(std::string_view name, const std::vector<unsigned>& ways, bool has_encoder,
              bool is_by_register) {
    if (name == "alarm" || name == "restores_eeprom") return false;
    if (name == "moves_address_immediately") return is_by_register;
    if (name == "rescales_feedback_only") return has_encoder;
    if (name == "saves_while_moving") return way_of("kept", ways) != "written";
    if (name == "in_position") return ways[index_of("in_position")] >= 2;
    return true;
}

template <class Model> void play(std::uint32_t runs, std::uint64_t seed) {
    constexpr bool has_encoder = std::is_same_v<Model, sim::yako_closed_loop>;
    sim::dice dice{seed};
    std::vector<std::vector<unsigned>> played;
    for (const tool::interpretation& i : tool::yako_interpretations) played.emplace_back(i.ways.size());
    for (std::uint32_t n = 0; n < runs; ++n) {
        CAPTURE(n);
        std::vector<unsigned> ways;
        for (const tool::interpretation& i : tool::yako_interpretations)
            ways.push_back(n == 0 ? 0 : dice.below(static_cast<std::uint32_t>(i.ways.size())));
        sim::yako_options chosen = tool::options_of(tool::yako_switches, ways);
        const bool is_by_register = n % 4 == 3;
        chosen.switches = is_by_register ? 0 : 1;
        bench<Model> on{chosen};
        if (is_by_register) { // as it was set up before
            constexpr std::uint8_t node[] = {0, 9}, save[] = {0, 0x42};
            REQUIRE(on.model.write(0x0013, words_view{node}) == 0);
            REQUIRE(on.model.write(0x002D, words_view{save}) == 0);
            on.model.power_cycle();
            REQUIRE(on.model.address() == 9);
        }
        const std::vector<std::uint16_t> before = words_of(on.model);
        const findings found = probed(on);
        CHECK(words_of(on.model) == before);
        for (std::size_t i = 0; i < ways.size(); ++i) {
            const tool::interpretation& what = tool::yako_interpretations[i];
            CAPTURE(std::string{what.name});
            CHECK(found.way(i).has_value() == can_show(what.name, ways, has_encoder, is_by_register));
            if (!found.way(i)) continue;
            CHECK(*found.way(i) == ways[i]);
            ++played[i][ways[i]];
        }
        CHECK_FALSE(on.has_failed());
        CHECK_FALSE(on.model.view().is_moving);
        CHECK(is_released(on.model));
        CHECK(on.fastest <= 20);
    }
    for (std::size_t i = 0; i < played.size(); ++i) {
        CAPTURE(std::string{tool::yako_interpretations[i].name});
        unsigned ways = 0;
        for (const unsigned count : played[i]) ways += count > 1;
        const std::string_view name = tool::yako_interpretations[i].name;
        const bool is_open = name == "alarm" || name == "restores_eeprom" ||
                             (name == "rescales_feedback_only" && !has_encoder);
        CHECK(ways == (is_open ? 0 : name == "in_position" ? 3 : played[i].size()));
    }
}

} // namespace

TEST_CASE("the probe of a closed loop finds the switches that show, in any combination") {
    play<sim::yako_closed_loop>(130, 11);
}
TEST_CASE("the probe of an open loop finds the switches that show, in any combination") {
    play<sim::yako_open_loop>(100, 12);
}

TEST_CASE(
    "the probe of a stepper moves nothing without consent, and saves nothing unless the power is switched") {
    bench<sim::yako_closed_loop> on{{}};
    on.consents = false;
    const findings found = probed(on);
    CHECK(on.model.starts() == 0);
    CHECK(on.fastest == 0);
    std::size_t settled = 0;
    for (std::size_t i = 0; i < found.all().size(); ++i) settled += found.way(i).has_value();
    CHECK(settled == 2); // a bad CRC, and what commands read
    bench<sim::yako_closed_loop> without{{}};
    without.most_power_cycles = 0;
    (void)probed(without);
    CHECK(without.model.saves() == 0);
}

TEST_CASE("a stepper that is not switched off again keeps its own words, whatever it saves") {
    for (unsigned kept = 0; kept < tool::yako_interpretations[index_of("kept")].ways.size(); ++kept) {
        for (const unsigned most : {0u, 1u, 2u}) {
            CAPTURE(kept);
            CAPTURE(most);
            std::vector<unsigned> ways(tool::yako_interpretations.size());
            ways[index_of("kept")] = kept;
            bench<sim::yako_closed_loop> on{tool::options_of(tool::yako_switches, ways)};
            on.most_power_cycles = most;
            const std::vector<std::uint16_t> before = words_of(on.model);
            (void)probed(on);
            CHECK(words_of(on.model) == before);
            on.model.power_cycle();
            CHECK(words_of(on.model) == before);
        }
    }
}

TEST_CASE("a line that is lost at any request ends the probe of a stepper, which gets its words back") {
    for (unsigned kept = 0; kept < tool::yako_interpretations[index_of("kept")].ways.size(); ++kept) {
        CAPTURE(kept);
        std::vector<unsigned> ways(tool::yako_interpretations.size());
        ways[index_of("kept")] = kept;
        const sim::yako_options chosen = tool::options_of(tool::yako_switches, ways);
        bench<sim::yako_closed_loop> whole{chosen};
        const std::vector<std::uint16_t> before = words_of(whole.model);
        const auto settled = [](const findings& of) {
            std::size_t n = 0;
            for (std::size_t i = 0; i < of.all().size(); ++i) n += of.way(i) ? 1u : 0u;
            return n;
        };
        const std::size_t most = settled(probed(whole));
        CHECK(whole.power_cycles == (way_of("kept", ways) == "written" ? 1 : 3));
        std::uint32_t failed = 0; // probes that have found less
        for (std::uint32_t n = 0; n < whole.requests; n += n < 40 || n + 40 > whole.requests ? 1 : 11) {
            CAPTURE(n);
            bench<sim::yako_closed_loop> on{chosen};
            on.lost_after = n;
            const findings found = probed(on);
            failed += settled(found) < most ? 1u : 0u;
            CHECK_FALSE(on.model.view().is_moving);
            CHECK(is_released(on.model));
            CHECK(words_of(on.model) == before);
            on.model.power_cycle();
            CHECK(words_of(on.model) == before);
            for (std::size_t i = 0; i < found.all().size(); ++i) {
                CAPTURE(std::string{found.all()[i].name});
                if (found.way(i)) CHECK(*found.way(i) == ways[i]);
            }
        }
        CHECK(failed > 60);
    }
}

TEST_CASE("a line that is lost for good ends the probe of a stepper after 20 s, and it says what is left") {
    for (unsigned kept = 0; kept < tool::yako_interpretations[index_of("kept")].ways.size(); ++kept) {
        CAPTURE(kept);
        std::vector<unsigned> ways(tool::yako_interpretations.size());
        ways[index_of("kept")] = kept;
        const sim::yako_options chosen = tool::options_of(tool::yako_switches, ways);
        bench<sim::yako_closed_loop> whole{chosen};
        const std::vector<std::uint16_t> before = words_of(whole.model);
        (void)probed(whole);
        CHECK(whole.not_put_back().empty());
        CHECK(whole.unsafe().empty());
        CHECK_FALSE(whole.has_saved());
        std::size_t most = 0;
        for (std::uint32_t n = 0; n < whole.requests; n += n < 40 || n + 40 > whole.requests ? 1 : 11) {
            CAPTURE(n);
            bench<sim::yako_closed_loop> on{chosen};
            on.lost_after = n;
            on.lost_for = ~0u;
            (void)probed(on);
            CHECK(on.has_failed());
            CHECK(since(on.lost_at, on.now()) <= milliseconds(20'000));
            const auto put = [&](std::uint16_t address, std::span<const std::uint16_t> words) {
                std::vector<std::uint8_t> content;
                for (const std::uint16_t w : words) {
                    content.push_back(static_cast<std::uint8_t>(w >> 8));
                    content.push_back(static_cast<std::uint8_t>(w & 0xFFu));
                }
                return on.model.write(address, words_view{bytes{content}}) == 0;
            };
            for (const tool::unsafe_word& u : on.unsafe()) CHECK(put(u.address, {&u.word, 1}));
            const auto left = on.not_put_back();
            most = left.size() > most ? left.size() : most;
            for (const tool::changed_register& c : left) {
                CAPTURE(c.address);
                CHECK(put(c.address, c.old));
            }
            CHECK(words_of(on.model) == before);
            constexpr std::uint16_t save[] = {0x42};
            if (on.has_saved()) CHECK(put(servobus::yako::auxiliary_command.address, save));
            on.model.power_cycle();
            CHECK(words_of(on.model) == before);
        }
        CHECK(most > 10);
    }
}

} // namespace probe_yako_tests
