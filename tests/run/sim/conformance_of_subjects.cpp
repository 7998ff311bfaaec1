// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the judges for everybody (sim/conformance.hpp) make of a simulated drive or a subject that is not right: a
// sentence, few findings, and an end.
#include <cstdint>
#include <string>
#include <string_view>

#include <doctest/doctest.h>

#include <servobus/sim/conformance.hpp>

#include <examples/own_device/own_subject.hpp>

namespace conformance_of_subjects_tests {

using namespace servobus;

namespace {

struct told {
    std::string first;
    unsigned findings = 0;
};
void tell(void* to, const sim::finding& f) {
    auto& all = *static_cast<told*>(to);
    if (all.findings++ == 0) all.first = std::string{f.promise} + ": " + f.what;
}

/// Plays all that the kit can play.
template <class Subject> told judged(std::uint32_t most_runs) {
    told all;
    sim::conformance<Subject> kit{&tell, &all};
    CHECK(kit.singles().findings == all.findings);
    (void)kit.every_pair(0, {0, 1000});
    (void)kit.pairs(1, 100);
    const sim::played played = kit.pairs(2, 100);
    CHECK(played.findings >= all.findings);
    CHECK(played.runs <= most_runs);
    return all;
}
bool says(const told& all, std::string_view words) {
    INFO(all.first);
    CHECK(all.first.find(words) != std::string::npos);
    return all.first.find(words) != std::string::npos;
}

struct elsewhere : winch::subject {
    static constexpr std::uint8_t address = 5;
    struct machine : winch::simulated {
        static std::uint8_t address() { return 6; }
        static std::uint32_t baud() { return 19200; }
    };
    static machine make(unsigned) { return machine{}; }
};
struct without_witness : winch::model {
    static constexpr steps::recheck witness(const settings&, const winch::prepared_command&) { return {}; }
};
template <class Line> class blind_drive : public facade<without_witness, Line> {
    using base = facade<without_witness, Line>;

  public:
    blind_drive(Line& on, std::uint8_t at, const supervision& by)
        : base{on, node<winch::device>{at}, by.feedback, by.command_timeout} {}
    winch::arrival arrival() const { return {}; }
    result<winch::feedback> feedback(duration oldest) const {
        if (const errc why = this->check_feedback(oldest); why != errc::ok) return why;
        return winch::feedback::from_words(this->image());
    }
    result<winch::feedback> read() { return base::run(read_feedback{}).status; }
};
struct has_no_witness : winch::subject {
    template <class Line> using drive = blind_drive<Line>;
};
/// It is energised at power-on, and nothing shows that it has been off.
struct restarts_unseen : winch::subject {
    template <class Line> using drive = blind_drive<Line>;
    static void restart(machine& m) {
        const std::uint8_t on[]{0, static_cast<std::uint8_t>(winch::control_code::hold)};
        m.power_cycle();
        (void)m.write(winch::control_word.address, words_view{on});
    }
};
struct forgets_restart : winch::subject {
    static void restart(machine&) {}
};
/// It does not know the register of the target.
struct lacks_target : winch::simulated {
    std::uint8_t write(std::uint16_t address, words_view from) {
        return address <= winch::target.address && address + from.size() > winch::target.address
                   ? std::uint8_t{2}
                   : winch::simulated::write(address, from);
    }
};
template <class Machine> struct subject_with : winch::subject {
    using machine = Machine;
    static machine make(unsigned) { return machine{}; }
};
/// It knows no function at all.
struct knows_nothing : winch::simulated {
    static std::uint8_t read(std::uint16_t, slice<std::uint16_t>) { return 1; }
    static std::uint8_t write(std::uint16_t, words_view) { return 1; }
};
/// It is always busy, but while it is taken over.
struct soon_busy : winch::simulated {
    std::uint8_t read(std::uint16_t address, slice<std::uint16_t> to) {
        return ++requests_ > 40 ? std::uint8_t{6} : winch::simulated::read(address, to);
    }
    unsigned requests_ = 0;
};
/// It turns on for ever, and is never seen to stop.
struct runs_on : winch::subject {
    static bool is_turning(const machine&) { return true; }
};
struct never_energised : winch::subject {
    static bool is_energised(const machine&) { return false; }
};
struct refuses_to_be_taken_over : winch::subject {
    template <class Drive> static bool take_over(Drive& drum, machine&) {
        return drum.run(init{}) && drum.run(enable{}) && drum.run(enable{}) && false;
    }
};

} // namespace

TEST_CASE("a simulated drive that never answers: one sentence, and nothing is played") {
    const told all = judged<elsewhere>(0);
    CHECK(all.findings == 1);
    CHECK(says(all, "kit: the simulated drive has not responded"));
}
TEST_CASE("a restart that does nothing") {
    const told all = judged<forgets_restart>(0);
    CHECK(all.findings == 1);
    CHECK(says(all, "kit: restart(machine) changes nothing"));
}
TEST_CASE("a model without a witness") {
    const told all = judged<has_no_witness>(2000);
    CHECK(all.findings < 40);
    CHECK(says(all, "G21: the drive has restarted, and the state is enabled as before"));
}
TEST_CASE("a model without a witness, of a drive whose restart changes nothing else") {
    const told all = judged<restarts_unseen>(0);
    CHECK(all.findings == 1);
    CHECK(says(all, "kit: restart(machine) changes nothing that shows"));
}
TEST_CASE("a command of which the simulated drive does not know a register") {
    const told all = judged<subject_with<lacks_target>>(2000);
    CHECK(all.findings < 40);
    CHECK(says(all, "kit: "));
}
TEST_CASE("a simulated drive that refuses everything") {
    const told all = judged<subject_with<knows_nothing>>(0);
    CHECK(all.findings == 1);
    CHECK(says(all, "kit: the simulated drive refuses a request of take_over"));
}
TEST_CASE("a simulated drive that is soon busy for ever") {
    const told all = judged<subject_with<soon_busy>>(2000);
    CHECK(all.findings <= 101);
}
TEST_CASE(
    "a motor that is never seen to stop, one that is never energised, a subject that takes nothing over") {
    CHECK(judged<runs_on>(200).findings <= 101);
    CHECK(judged<never_energised>(2000).findings <= 101);
    CHECK(says(judged<refuses_to_be_taken_over>(0), "kit: take_over fails"));
}

} // namespace conformance_of_subjects_tests
