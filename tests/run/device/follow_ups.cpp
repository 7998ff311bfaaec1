// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A command fails at each of its frames: the response is lost, or the drive refuses it. Judged by the frames that
// follow, by whether the drive must be initialised, and by what is known of the motion.
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <servobus/device/c630s.hpp>
#include <servobus/device/c630s/single_parameters.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/sim/zlac8015d.hpp>
#include <tests/support/frames_of_commands.hpp>
#include <tests/support/simulated_c630s.hpp>
#include <tests/support/simulated_yako.hpp>

namespace follow_ups_tests {

using namespace servobus;
using namespace servobus::units;
using frames_of_commands::hex_of;

namespace {

/// A simulated drive that logs its requests and fails one of them.
template <class Model> struct struck : Model {
    using Model::Model;
    std::vector<std::string> log{};
    std::size_t at = ~std::size_t{0};
    bool is_refusing = false; ///< or its response is lost
    sim::fault_plan* faults = nullptr;

    std::uint8_t read(u16 address, slice<u16> to) {
        return strikes(hex_of(address)) ? refusal : Model::read(address, to);
    }
    std::uint8_t write(u16 address, words_view from) {
        std::string frame = hex_of(address);
        for (std::size_t i = 0; i < from.size(); ++i) frame += (i == 0 ? '=' : '.') + hex_of(from[i]);
        return strikes(frame) ? refusal : Model::write(address, from);
    }

  private:
    static constexpr std::uint8_t refusal = 4;

    bool strikes(const std::string& frame) {
        const bool is_struck = log.size() == at;
        log.push_back(frame);
        faults->lost_response = is_struck && !is_refusing ? 1000 : 0;
        return is_struck && is_refusing;
    }
};

/// A drive whose reads are not repeated.
template <class Model, class Options, std::uint32_t Baud, template <class> class Drive, class Device>
struct rig : simulated::simulated_model<struck<Model>, Options, Baud> {
    Drive<typename rig::line_type> drive{this->line, once(), unsupervised};
    rig() { this->model.faults = &this->wire.faults(); }
    static node<Device> once() {
        node<Device> n{1};
        n.read_retries = 0;
        return n;
    }
};
using axis = rig<sim::yako_closed_loop, sim::yako_options, 115200, yako::closed_loop::drive,
                 yako::closed_loop::device>;
using servo = rig<sim::c630s, sim::c630s_options, 57600, c630s::drive, c630s::device>;
using dual_servo = rig<sim::zlac8015d, sim::zlac8015d_options, 115200, zlac8015d::drive, zlac8015d::device>;

/// Such as `00BA 0006: known; 0027=0001: needs init, seen, 0006 00BA`. One of the frames before the colon failed. Then
/// follow what is known of the drive and of its motion, and which frames came after it. A frame that comes again, as in
/// a wait, is named once.
template <class Rig, class Prepare, class Command>
std::string follow_ups(Prepare prepare, const Command& wanted, bool is_refusing) {
    std::string all, group, before;
    for (std::size_t n = 0;; ++n) {
        Rig r;
        REQUIRE(prepare(r));
        r.model.log.clear();
        r.model.at = n;
        r.model.is_refusing = is_refusing;
        (void)r.drive.run(wanted);
        const auto& log = r.model.log;
        std::string after = r.drive.state() == drive_state::needs_init ? "needs init" : "known";
        if (r.drive.motion() != motion_check::not_asked) after += std::string{", "} + text(r.drive.motion());
        for (std::size_t i = n + 1; i < log.size(); ++i) {
            if (i == n + 1 || log[i] != log[i - 1]) after += (i == n + 1 ? ", " : " ") + log[i];
        }
        if (n != 0 && (log.size() <= n || after != before)) {
            all += (all.empty() ? "" : "; ") + group + ": " + before;
            group.clear();
        }
        if (log.size() <= n) return all;
        if ((" " + group + " ").find(" " + log[n] + " ") == std::string::npos)
            group += (group.empty() ? "" : " ") + log[n];
        before = after;
    }
}
/// `refused`: what follows where the drive refuses a frame, if it is anything else than where the response is lost.
template <class Rig, class Prepare, class Command>
void expect(Prepare prepare, const Command& wanted, const std::string& lost,
            const std::string& refused = {}) {
    CHECK(follow_ups<Rig>(prepare, wanted, false) == lost);
    CHECK(follow_ups<Rig>(prepare, wanted, true) == (refused.empty() ? lost : refused));
}

} // namespace

TEST_CASE("what follows a YAKO's command that fails at one of its frames") {
    using namespace servobus::yako;
    const auto ready = [](axis& a) {
        a.model.attach(simulated::yako_slide());
        return a.drive.run(init{}) && a.drive.run(enable{}) &&
               a.drive.run(set_homing_profile{90 * r_per_min, 20 * r_per_min});
    };
    const motion_profile slow{10 * r_per_min, 90 * millisecond, 80 * millisecond, 60 * r_per_min};
    expect<axis>(ready, closed_loop::home{homing::home_24},
                 "0032 00BA 0006 0030=0001.0018 0035=0000.0000: needs init; 0027=0010 00BA 0006: needs init, "
                 "unknown, 0027=0100 0006",
                 "0032 00BA 0006 0030=0001.0018: known; 0035=0000.0000 00BA 0027=0010: needs init; 00BA "
                 "0006: needs init, unknown, 0027=0100 0006");
    expect<axis>(ready, velocity{30 * r_per_min},
                 "00BA 0006 001D=001E.0064.0064: needs init; 0027=0002: needs init, seen, 0006 00BA; 00BA "
                 "0006: needs init, unknown",
                 "00BA 0006 001D=001E.0064.0064: known; 0027=0002 00BA 0006: needs init");
    expect<axis>(ready, move_by{100 * pulse, slow},
                 "00BA 0006 0020=000A.005A.0050.003C.0000.0064: needs init; 0027=0001: needs init, seen, "
                 "0006 00BA; 00BA 0006: needs init, unknown",
                 "00BA 0006 0020=000A.005A.0050.003C.0000.0064: known; 0027=0001 00BA 0006: needs init");
    expect<axis>(ready, move_by{100 * pulse},
                 "0020 00BA 0006 0024=0000.0064: needs init; 0027=0001: needs init, seen, 0006 00BA; 00BA "
                 "0006: needs init, unknown",
                 "0020 00BA 0006 0024=0000.0064: known; 0027=0001 00BA 0006: needs init");
    expect<axis>(ready, bounded_jog{100 * pulse},
                 "0020 00BA 0006 0024=0000.0064: needs init; 0027=0001: needs init, seen, 0006 00BA; 00BA "
                 "0006: needs init, unknown",
                 "0020 00BA 0006 0024=0000.0064: known; 0027=0001 00BA 0006: needs init");
    expect<axis>(ready, save{}, "0006 00BA 00BA=0000.0000 002D=0042 00BA=0000.0001: needs init",
                 "0006 00BA 00BA=0000.0000: known; 00BA 002D=0042 0006 00BA=0000.0001: needs init");
    expect<axis>(ready, disable{},
                 "0027=0100: known, 0027=0100 00BA 0006 002D=0011 0006; 0006: needs init; 002D=0011: known, "
                 "002D=0011 00BA 0006; 0006: needs init",
                 "0027=0100: known, 0027=0100 0006 002D=0011 0006; 0006: needs init; 002D=0011: known, "
                 "002D=0011 0006; 0006: needs init");
}

TEST_CASE("what follows a C630S's command that fails at one of its frames") {
    using namespace servobus::c630s;
    const std::string by_all_means = "0D05=0001 0603=0000.0000 0703=0000 3100 3100=8000 3100 0B00 1720";
    // A drive that may have restarted keeps each write in its EEPROM until P0C-13 is 0 again.
    const std::string sparingly = "0D05=0001 3100=0000 0C0D=0000 0603=0000.0000 0703=0000 3100 0B00 1720";
    servo made;
    REQUIRE(made.drive.run(init{}));
    REQUIRE(made.drive.run(set_up{}));
    made.model.power_cycle();
    const auto off = [&](servo& r) {
        sim::fault_plan* const faults = r.model.faults;
        r.model = made.model;
        r.model.faults = faults;
        return bool{r.drive.run(init{})};
    };
    const auto in = [&](const enable_in& how) {
        return [&, how](servo& r) { return off(r) && r.drive.run(how); };
    };
    expect<servo>(in({control_mode::position}), start_segment{1},
                  "0C0D 1720 0B00 0B07 0B35 110C 0B21 3100 3100=8001: needs init; 3100=8041 3100 3100=8001 "
                  "0500 0C0D: needs init, seen, 3100 0B00 0B07",
                  "0C0D 1720 0B00 0B07 0B35 110C 0B21 3100 3100=8001: known; 3100 3100=8041 3100=8001 0500 "
                  "0C0D: needs init");
    expect<servo>(in({control_mode::position}), c630s::home_electrically{10 * second},
                  "1720 0C0D 0B00 3100: needs init; 051E=0005 1720 0B00 051E=0000 051E 3100: needs init, " +
                      by_all_means,
                  "1720 0C0D 0B00 3100: known; 051E=0005: known, " + by_all_means +
                      " 0B00 0B07 0B35 0B21; 1720 0B00 051E=0000 051E 3100: needs init, " + by_all_means);
    expect<servo>(in({control_mode::speed}), velocity{10 * r_per_min},
                  "1720: needs init; 0603=000A: known, 0603 3100", "1720 0603=000A: known");
    expect<servo>(in({control_mode::speed}), c630s::jog{10 * r_per_min},
                  "0C0D 1720 0B00 0604=000A 0604 3100 3100=8201: needs init",
                  "0C0D 1720 0B00 0604=000A: known; 0604 3100 3100=8201 0C0D: needs init");
    expect<servo>(
        in({control_mode::speed}), disable{},
        "0603=0000.0000: known, 0603=0000.0000 3100 3100=8000 3100 0B00 1720; 3100 3100=8000: needs init, " +
            sparingly + "; 3100 0B00 1720: needs init");
    expect<servo>(in({control_mode::speed}), quick_stop{},
                  "0D05=0001: known, 0603=0000.0000 0703=0000 0D05=0001 0B00; 0603=0000.0000: known, "
                  "0703=0000 0603=0000.0000 0B00; 0703=0000: known, 0703=0000 0B00; 0B00: needs init");
    expect<servo>(off, enable{},
                  "0C0D 0C1A 3100 0B00 1720 0603=0000.0000 0703=0000 1100=0002 1100 1200=0002 1200 051E=0000 "
                  "051E 0D05=0000 0D05 0C0A 0300 0200=0000 0200 0600=0000 0600 0602=0000 0602 0603 0703: "
                  "needs init; 3100=8001 3100 0603 0703 0C0D 0200 1720: needs init, " +
                      by_all_means,
                  "0C0D 0C1A 3100 0B00 1720 0603=0000.0000: known; 0703=0000 1100=0002 1100 1200=0002 1200 "
                  "051E=0000 051E 0D05=0000 0D05 0C0A 0300 0200=0000 0200 0600=0000 0600 0602=0000 0602 1720 "
                  "0603 0703 3100: needs init; 3100=8001 3100 0603 0703 0C0D 0200 1720: needs init, " +
                      by_all_means);
    expect<servo>(off, set<max_speed>{1500}, "0C0D 0607=05DC 0607: needs init",
                  "0C0D 0607=05DC: known; 0607: needs init");
    expect<servo>(off, keep<max_speed>{1500}, "3100 0B00 0C0D=0001 0C0D 0607=05DC 0607 0C0D=0000: needs init",
                  "3100 0B00: known; 0C0D=0001: known, 0C0D=0000 0C0D; 0C0D 0607=05DC 0607 0C0D=0000: needs "
                  "init, 0C0D=0000 0C0D");
    expect<servo>(
        off, fault_reset{},
        "0603=0000.0000: known, 0603=0000.0000 3100 3100=8000 3100 0B00 1720 3100 0603=0000.0000 0703=0000 "
        "0D05=0000 0D01=0000 0D01=0001 1720 0D01=0000 3100 3100=8000; 3100 3100=8000: needs init, " +
            sparingly + "; 3100 0B00 1720: needs init, " + by_all_means +
            "; 3100: needs init; 0603=0000.0000: known, 0703=0000 0603=0000.0000 0D05=0000 0D01=0000 "
            "0D01=0001 1720 0D01=0000 3100 3100=8000; 0703=0000: known, 0703=0000 0D05=0000 0D01=0000 "
            "0D01=0001 1720 0D01=0000 3100 3100=8000; 0D05=0000 0D01=0000 0D01=0001 1720 3100: needs init; "
            "3100=8000: needs init, " +
            by_all_means);
}

TEST_CASE("what follows a ZLAC8015D's command that fails at one of its frames") {
    using namespace servobus::zlac8015d;
    const auto off = [](dual_servo& r) { return bool{r.drive.run(init{})}; };
    const auto in = [](operating_mode m) {
        return [=](dual_servo& r) { return r.drive.run(init{}) && r.drive.run(enable_in{checked(m)}); };
    };
    expect<dual_servo>(
        in(operating_mode::relative_position), move_by{40 * pulse, -50 * pulse},
        "200D 20A2 208A=0000.0028.FFFF.FFCE: needs init; 200E=0010 200D: needs init, seen, 20A2 200D",
        "200D 20A2 208A=0000.0028.FFFF.FFCE: known; 200E=0010 200D: needs init");
    expect<dual_servo>(in(operating_mode::velocity), velocity{10 * r_per_min, 10 * r_per_min},
                       "2088=000A.000A: known, 2088 200D", "2088=000A.000A: known");
    expect<dual_servo>(
        off, resolution{10}, "20A2 2022=000A 2022 200D=0000 200D 2010=0001 2010=0000 200D=0003: needs init",
        "20A2 2022=000A: known; 2022 200D=0000 200D 2010=0001 2010=0000 200D=0003: needs init");
    expect<dual_servo>(off, zlac8015d::watchdog{300 * millisecond}, "2000=012C 2000: needs init",
                       "2000=012C: known; 2000: needs init");
    expect<dual_servo>(
        off, enable{},
        "20A2 2088=0000.0000 2088 2090=0000.0000 2090 200D=0003 200D 2022 2000 200E=0008: needs init",
        "20A2 2088=0000.0000: known; 2088 2090=0000.0000 2090 200D=0003 200D 2022 2000 200E=0008 20A2: needs "
        "init");
    expect<dual_servo>(in(operating_mode::velocity), disable{},
                       "200E=0007: known, 200E=0007 200D 20A2; 20A2: needs init",
                       "200E=0007: known, 200E=0007 20A2; 20A2: needs init");
    expect<dual_servo>(in(operating_mode::velocity), quick_stop{},
                       "200E=0005: known, 200E=0005 200D 20A2; 20A2: needs init",
                       "200E=0005: known, 200E=0005 20A2; 20A2: needs init");
}

} // namespace follow_ups_tests
