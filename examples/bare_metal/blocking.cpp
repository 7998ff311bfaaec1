// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Drives both wheels by calls that return when a command is carried out. The core sleeps while it waits for a
// byte.
#include "job.hpp"
#include "mps2_an385.hpp"
#include "semihosting.hpp"
#include "stack.hpp"

using namespace servobus;
using namespace servobus::zlac8015d;
using semihosting::out;

namespace {

class program {
  public:
    bool turns_and_stops_the_wheels() {
        return does("take over", init{}) && does("watchdog 20 s", job::watchdog) &&
               does("enable, velocity mode", enable_in{operating_mode::velocity}) &&
               does("left 20 r/min, right -20 r/min", job::opposite_ways) && sees_both_turn() &&
               does("halt", halt{}) && does("disable", disable{}) && sees_both_stand();
    }

    /// Stops the drive after any failure. The library repeats the stop until it is acknowledged or the drive
    /// does not respond.
    void stop() {
        if (!wheels_.run(disable{})) out << "blocking: the stop was not confirmed\n";
    }

    bool may_begin_anew() const { return job::may_begin_anew(wheels_, wire_); }

  private:
    template <class Command> bool does(const char* what, const Command& command) {
        return has_ended_well(what, wheels_.run(command));
    }

    static bool has_ended_well(const char* what, const command_status& r) {
        out << "blocking: " << what << ": " << text(r.outcome());
        if (!r) out << ", " << text(r.error()) << " (step " << std::uint32_t{r.step()} << ")";
        out << "\n";
        return static_cast<bool>(r);
    }

    bool sees_both_turn() {
        const instant start = port_.now();
        while (since(start, port_.now()) < job::longest_ramp) {
            const result<feedback> seen = looks();
            if (!seen) return false;
            if (job::turns_as_commanded(*seen)) return shows(*seen);
        }
        out << "blocking: the wheels did not reach their speed\n";
        return false;
    }

    bool sees_both_stand() {
        const result<feedback> seen = looks();
        if (!seen) return false;
        if (!job::is_at_rest(*seen)) out << "blocking: the wheels are not at rest\n";
        return shows(*seen) && job::is_at_rest(*seen);
    }

    result<feedback> looks() {
        const result<feedback> seen = wheels_.read();
        if (!seen) out << "blocking: look: " << text(seen.error()) << "\n";
        if (!seen || !seen->has_fault()) return seen;
        out << "blocking: look: " << text(errc::faulted) << "\n";
        return errc::faulted;
    }

    static bool shows(const feedback& f) {
        out << "blocking: speeds in 0.1 r/min: " << std::int32_t{f.left_speed.count()} << " and "
            << std::int32_t{f.right_speed.count()} << "\n";
        return true;
    }

    mps2::rs485 port_{};
    line<mps2::rs485> wire_{port_, job::timing};
    drive<line<mps2::rs485>> wheels_{wire_, job::patient_node(), job::no_polling};
};

} // namespace

int main() {
    mps2::clock::start();
    mps2::rs485::start(job::baud);
    program wheels;

    bool is_done = wheels.turns_and_stops_the_wheels();
    for (int takeovers = 1; !is_done; ++takeovers) {
        wheels.stop();
        if (takeovers == job::most_takeovers || !wheels.may_begin_anew()) break;
        is_done = wheels.turns_and_stops_the_wheels();
    }
    out << "blocking: bytes lost " << std::uint32_t{mps2::rs485::overruns()} << ", stack "
        << static_cast<std::uint32_t>(stack_used()) << " bytes\n";
    out << (is_done ? "blocking: both wheels at rest\n" : "blocking: FAILED\n");
    return is_done ? 0 : 1;
}
