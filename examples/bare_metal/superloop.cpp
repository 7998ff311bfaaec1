// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The same job in a superloop that never waits: each loop iteration continues the drive's routine as far as
// possible and then runs everything else. The number of calls of the port in an iteration shows whether it
// waited: an iteration that waits calls the port again and again.
#include "bare_look.hpp"
#include "job.hpp"
#include "mps2_an385.hpp"
#include "semihosting.hpp"
#include "stack.hpp"

using namespace servobus;
using namespace servobus::zlac8015d;
using semihosting::out;

namespace {

/// The board's port without its `wait`; counts the calls.
struct counted_port {
    std::uint32_t asked = 0;

    transfer send(bytes frame) { return ++asked, mps2::rs485::send(frame); }
    bool sent() { return ++asked, mps2::rs485::sent(); }
    transfer receive(byte_buffer into) { return ++asked, mps2::rs485::receive(into); }
    instant now() { return ++asked, mps2::rs485::now(); }
};
static_assert(port<counted_port> && !waiting_port<counted_port>);

enum class stage : std::uint8_t { take_over, watchdog, enable, turn, look, halt, disable, rest, stop, over };

constexpr const char* text(stage s) {
    switch (s) {
    case stage::take_over: return "take over";
    case stage::watchdog: return "watchdog 20 s";
    case stage::enable: return "enable, velocity mode";
    case stage::turn: return "left 20 r/min, right -20 r/min";
    case stage::look: return "both wheels turn";
    case stage::halt: return "halt";
    case stage::disable: return "disable";
    case stage::rest: return "both wheels stand";
    case stage::stop: return "stop";
    case stage::over: break;
    }
    return "over";
}

class program {
  public:
    explicit program(counted_port& on) : port_{&on}, wire_{on, job::timing}, look_{on} {
        enter(stage::take_over);
    }

    void turn() {
        ++turns_;
        if (at_ == stage::rest) {
            look_.turn();
            if (look_.is_over()) judge_rest();
        } else {
            wheels_.step();
            if (wheels_.is_idle()) go_on();
        }
    }

    bool is_over() const { return at_ == stage::over; }
    bool has_failed() const { return has_failed_; }
    std::uint32_t fewest_turns() const { return fewest_turns_; }

  private:
    void enter(stage next) {
        at_ = next;
        entered_ = port_->now();
        turns_ = 0;
        begin();
    }

    void begin() {
        if (const command_status begun = begin_command(); !begun) fail(begun.error());
    }
    command_status begin_command() {
        switch (at_) {
        case stage::take_over: return wheels_.begin(init{});
        case stage::watchdog: return wheels_.begin(job::watchdog);
        case stage::enable: return wheels_.begin(enable_in{operating_mode::velocity});
        case stage::turn: return wheels_.begin(job::opposite_ways);
        case stage::look: return wheels_.begin(read_feedback{});
        case stage::halt: return wheels_.begin(halt{});
        case stage::disable:
        case stage::stop: return wheels_.begin(disable{});
        case stage::rest: look_.begin(duration{job::timing.t3_5}); break;
        case stage::over: break;
        }
        return {};
    }

    // The current command has ended.
    void go_on() {
        const errc why = wheels_.last().error();
        if (why != errc::ok) return fail(why);
        if (at_ == stage::look) {
            const auto seen = wheels_.feedback(milliseconds(1000));
            if (!seen) return fail(seen.error());
            if (seen->has_fault()) return fail(errc::faulted);
            if (!job::turns_as_commanded(*seen)) return look_again();
        }
        say("done");
        if (at_ == stage::stop) return leave();
        enter(static_cast<stage>(static_cast<std::uint8_t>(at_) + 1));
    }

    void look_again() {
        if (since(entered_, port_->now()) > job::longest_ramp) return fail(errc::not_reached);
        begin();
    }

    void judge_rest() {
        if (look_.error() != errc::ok && ++looks_ < 3) return look_.begin(job::timing.visible_gap());
        if (look_.error() != errc::ok) return fail(look_.error());
        if (!job::is_at_rest(look_.seen())) return fail(errc::unexpected_value);
        say("done");
        at_ = stage::over;
    }

    void say(const char* how) {
        out << "superloop: " << text(at_) << ": " << how << " in " << turns_ << " turns\n";
        if (turns_ < fewest_turns_) fewest_turns_ = turns_;
    }

    // Stops the drive after any failure.
    void fail(errc why) {
        has_failed_ = true;
        say(servobus::text(why));
        if (at_ != stage::stop) return enter(stage::stop);
        out << "superloop: the stop was not confirmed\n";
        leave();
    }

    // Ends the program, or starts the job again if it may.
    void leave() {
        at_ = stage::over;
        if (++takeovers_ == job::most_takeovers || !job::may_begin_anew(wheels_, wire_)) return;
        has_failed_ = false;
        enter(stage::take_over);
    }

    counted_port* port_;
    line<counted_port> wire_;
    drive<line<counted_port>> wheels_{wire_, job::patient_node(), job::no_polling};
    bare_look<counted_port> look_;
    instant entered_{};
    std::uint32_t turns_ = 0;
    std::uint32_t fewest_turns_ = 0xFFFF'FFFF;
    int takeovers_ = 0;
    int looks_ = 0;
    stage at_ = stage::take_over;
    bool has_failed_ = false;
};

/// Stands for everything else that the machine has to do.
std::uint32_t turns_of_the_others = 0;
void others_have_their_turn() { ++turns_of_the_others; }

} // namespace

int main() {
    mps2::clock::start();
    mps2::rs485::start(job::baud);
    counted_port port;
    program wheels{port};

    std::uint32_t most_asked = 0;
    while (!wheels.is_over()) {
        port.asked = 0;
        wheels.turn();
        if (port.asked > most_asked) most_asked = port.asked;
        others_have_their_turn();
    }

    constexpr std::uint32_t without_waiting = 32;
    const bool was_held_up = most_asked > without_waiting || wheels.fewest_turns() < 2;
    out << "superloop: " << turns_of_the_others << " turns, at least " << wheels.fewest_turns()
        << " a command; a turn asked the port at most " << most_asked
        << " times: " << (was_held_up ? "it WAS held up\n" : "never held up\n");
    out << "superloop: bytes lost " << std::uint32_t{mps2::rs485::overruns()} << ", stack "
        << static_cast<std::uint32_t>(stack_used()) << " bytes\n";
    const bool is_done = !wheels.has_failed() && !was_held_up;
    out << (is_done ? "superloop: both wheels at rest\n" : "superloop: FAILED\n");
    return is_done ? 0 : 1;
}
