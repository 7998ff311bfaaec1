// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the facades of all drives share: one command at a time, run to its end or begun and stepped; stops
// that go before everything else; a command timeout. What a command means, and which settings are cached,
// is up to the device. The `drive.hpp` of each device includes it, and so does the author of a drive.
//
//     const errc refused = wheels.begin(zlac8015d::velocity{30 * r_per_min, 30 * r_per_min});
//     if (refused != errc::ok) return 1;
//     while (!wheels.is_idle()) wheels.step(); // in your loop, between your other work
//     if (!wheels.last()) std::puts(text(wheels.last().error()));
#pragma once

#include <cstdint>

#include <servobus/client/node.hpp>
#include <servobus/control/sequence.hpp>
#include <servobus/control/states.hpp>

namespace servobus {

/// A facade over one drive. `Command` is a class of the device:
///
///     routine steps;                 // empty only if refused
///     steps::given input() const     // arguments, shift, limit
///     errc refusal;                  // why it is refused here; nothing is sent then
///     stop_priority stop;                  // a stop goes out in any state and cuts another command short
///
/// `Self` derives from this and gives, for this base only:
///
///     Command plan(const Wanted&)          // a command of the application, made ready
///     errc admit(Command&)                 // a last look before it starts
///     void apply(const Command&)           // it was done
///     void fail(const Command&, routine_status)    // it was not
///     void forget()                      // nothing is known of the drive any more
///     bool takes_over(const Command&)      // stops the drive, and finds out what it is like
///     bool is_command(const Command&)      // counts as a sign of life of the application
///     bool leaves_doubt(const Command&)    // half done, the drive's state is open
///     bool is_powered()                  // believed to be enabled
///     Command watch_stop()                 // what stops it when the application falls silent
///     duration feeding_interval()        // between two readings that feed the drive's watchdog; 0: none
///     Command feeding()                    // such a reading
///     restarts_on_traffic                 // its watchdog's stop may end with any request; if so:
///     duration watchdog()                // how long the drive bears silence
///     Command first_stop()                 // what it hears first after that, in one try
///     steps::recheck recheck()           // if there is: what a restart would change
template <class Self, class Line, class Command> class drive_base {
  public:
    drive_base(const drive_base&) = delete;
    drive_base& operator=(const drive_base&) = delete;

    /// True if no command is under way, nor a stop that `watch_commands` gave.
    constexpr bool is_idle() const {
        return sequence_.is_idle() || (is_own_ && command_.stop == stop_priority::no_stop);
    }
    /// How the last command ended; meaningful when idle.
    constexpr const routine_status& last() const { return report_; }

    /// Runs a command to its end. Waits; bounded by the routine's limits. Errors: the command's own;
    /// `preempted` if a stop took its place meanwhile (`watch_commands`).
    template <class Wanted> routine_status run(const Wanted& wanted) {
        const errc refusal = begin(wanted);
        if (refusal != errc::ok) return routine_status{refusal};
        return wait();
    }

    /// Starts a command; `step()` moves it on. A stop cuts a less urgent command short and goes out behind
    /// the frame in flight. Errors: the command's own; `busy` if another command is under way; `needs_init`;
    /// `bad_argument` for a node address that the device cannot have. Nothing is sent then.
    template <class Wanted> [[nodiscard]] constexpr errc begin(const Wanted& wanted) {
        if (!is_valid_) return errc::bad_argument;
        forget_what_is_old();
        Command o = self().plan(wanted);
        if (const room has = make_room(o); has != room::enough) {
            if (has == room::none) return o.refusal;
            o = self().plan(wanted);
        }
        return take(o);
    }

    /// True while a stop is to go out and nothing of its frame has left.
    constexpr bool has_stop_to_send() const { return sequence_.has_stop_to_send(); }

    constexpr std::uint8_t address() const { return sequence_.address(); }

    /// True if a stop has to be the first that the drive hears: its own watchdog may have stopped it, and may
    /// let it go on with whatever request is valid.
    constexpr bool must_be_stopped_first() {
        mind_the_watchdog();
        return is_unheard_;
    }
    /// True while a routine is under way, the application's or not.
    constexpr bool is_under_way() const { return !sequence_.is_idle(); }
    /// Sends that stop, once; nothing is known of the drive then. False if a command is under way.
    constexpr bool stop_first() {
        if constexpr (Self::restarts_on_traffic) {
            if (!sequence_.is_idle()) return false;
            self().forget();
            start_first_stop();
        }
        return true;
    }
    /// True once after it was heard again.
    constexpr bool take_found() {
        const bool was_found = is_found_;
        is_found_ = false;
        return was_found;
    }
    /// From a bus: a read of the drive was answered, which began to leave at `sent`. If any request to the
    /// drive was not answered before, it may have restarted, which the facade looks for.
    constexpr void note_heard(instant sent) {
        if (!is_unheard_) sequence_.note_heard(sent);
        const std::uint16_t misses = sequence_.line().epoch(address()).misses;
        is_look_due_ = is_look_due_ || misses != noted_.misses;
        noted_.misses = misses;
    }
    /// Too many were not. A drive with a watchdog is believed in until that has passed.
    constexpr void note_absence() { is_absent_ = !Self::restarts_on_traffic; }

    /// Moves the command under way on, without waiting, and keeps the promises of `watch_commands`. Returns
    /// the time within which nothing happens unless a byte comes.
    constexpr duration step() {
        duration idle{};
        if (!gives_up_for_a_loss()) {
            mind_the_watchdog();
            mind_the_application();
            mind_the_stop();
            if (sequence_.is_idle()) return milliseconds(1);
            idle = sequence_.step();
            if (sequence_.take_lost()) self().forget();
            if (is_unheard_ && sequence_.last_heard() != heard_before_ && !is_overdue()) {
                is_unheard_ = false;
                is_found_ = true;
                self().forget(); // it has heard a stop, and nothing before that for too long
            }
        }
        if (sequence_.is_idle()) settle();
        if (is_lost() && sequence_.is_idle()) forget_what_is_old();
        return idle;
    }

    /// From now on `step()` stops the drive if the application gives no motion command for `limit`,
    /// whatever else it commands. Where the drive has a watchdog of its own, it is fed meanwhile by reading
    /// feedback when nothing else is under way. Without this nothing is sent that the application did not
    /// command, but what a bus needs: the stop before a read that a drive must not hear first, and a look
    /// behind one that it did not answer. A stop that ends without an answer is ordered again after as long.
    /// A limit of 0 ends it.
    constexpr void watch_commands(duration limit) {
        command_limit_ = limit;
        last_command_ = sequence_.line().now();
    }

    /// From now on `step()` commands a stop that was not confirmed again, `every` so often, until it is, or
    /// until another one takes its place, or an `init` or a motion that the application commands is done. 0:
    /// it does not.
    constexpr void repeat_stops(duration every) { stop_every_ = every; }

  protected:
    template <class Device>
    constexpr drive_base(Line& on, const servobus::node<Device>& at)
        : sequence_{on, at.address, at.limits, at.gaps, at.read_retries},
          is_unheard_{Self::restarts_on_traffic}, noted_{on.epoch(at.address)}, is_valid_{at.is_valid()} {}
    ~drive_base() = default;

    constexpr sequence<Line>& runner() { return sequence_; }
    constexpr const sequence<Line>& runner() const { return sequence_; }
    constexpr const Command& current() const { return command_; }

    /// Runs `o` behind a command of the application that has just ended, still as a part of it.
    constexpr void follow(const Command& o) {
        start(o);
        is_follow_up_ = true;
    }
    /// Changes how the application's command is reported.
    constexpr void report_as(const routine_status& r) { report_ = r; }
    /// A drive that was taken over or enabled has no command to watch yet.
    constexpr void await_first_command() { is_commanded_ = false; }

    // Errors of the transport or of a response: the drive's state is not known any more.
    static constexpr bool is_in_doubt(const routine_status& r) {
        if (r.error() == errc::faulted) return false;
        if (r.error() == errc::exception) return r.has_changed;
        const bool is_transport = r.error() >= errc::line_busy && r.error() <= errc::bad_gap;
        return is_transport || r.error() == errc::needs_init || r.outcome() == outcome::unknown;
    }

  private:
    constexpr Self& self() { return static_cast<Self&>(*this); }

    routine_status wait() {
        const std::uint8_t mine = number_;
        auto guard = sequence_.line().new_stall_detector();
        while (!is_idle()) {
            const duration idle = step();
            if (guard.has_failed(sequence_.line().now())) {
                sequence_.give_up(errc::clock_stopped);
                settle();
                break;
            }
            sequence_.line().sleep(idle);
        }
        return number_ == mine ? report_ : routine_status{status::sent(errc::preempted)};
    }

    // Whether a command can begin. It may cut another one short that leaves less known, and then a halt,
    // whose frames follow from what is known, is another one.
    enum class room : std::uint8_t { none, enough, enough_for_another };
    constexpr room make_room(Command& o) {
        if (o.refusal != errc::ok) return room::none;
        if (is_idle()) return room::enough;
        const bool is_less = is_own_ ? o.stop < command_.stop : o.stop <= command_.stop;
        if (o.stop == stop_priority::no_stop || is_less) {
            o.refusal = errc::busy;
            return room::none;
        }
        if (!self().leaves_doubt(command_)) return room::enough;
        self().forget(); // half done: what the drive is like now is open
        return o.stop == stop_priority::halt ? room::enough_for_another : room::enough;
    }
    constexpr errc take(Command& o) {
        if (const errc refusal = self().admit(o); refusal != errc::ok) return refusal;
        if (self().is_command(o)) {
            last_command_ = sequence_.line().now();
            is_commanded_ = true;
            is_own_stop_open_ = false;
        }
        tries_ = 0;
        ++number_;
        if (o.stop != stop_priority::no_stop) is_open_ = false;
        open_urgent_ = o.stop != stop_priority::no_stop ? steps::urgent_frames : again;
        start(o);
        return errc::ok;
    }

    constexpr void lose() {
        self().forget();
        if (Self::restarts_on_traffic) be_unheard();
    }
    constexpr void be_unheard() {
        is_unheard_ = true;
        heard_before_ = sequence_.last_heard();
    }
    // Whatever is believed, and whatever is under way.
    constexpr void mind_the_watchdog() {
        if (!is_unheard_ && is_overdue()) be_unheard();
    }
    // An answer that is looked at late is old too.
    constexpr bool is_overdue() {
        if constexpr (Self::restarts_on_traffic) {
            return since(sequence_.last_heard(), sequence_.line().now()) > self().watchdog();
        } else {
            return false;
        }
    }
    // The drive, by what a bus has seen, or the port, whoever met that.
    constexpr bool is_lost() const {
        return is_absent_ || noted_.losses != sequence_.line().epoch(address()).losses;
    }
    // After a loss, or too long a silence.
    constexpr void forget_what_is_old() {
        const bool was_lost = is_lost() && sequence_.is_idle();
        if (was_lost) {
            is_absent_ = false;
            noted_.losses = sequence_.line().epoch(address()).losses;
        }
        if (was_lost || sequence_.was_silent()) lose();
    }
    // True if a loss ends a command; a stop goes on.
    constexpr bool gives_up_for_a_loss() {
        if (!is_lost()) return false;
        if (sequence_.is_idle()) {
            forget_what_is_old();
        } else if (command_.stop == stop_priority::no_stop) {
            sequence_.give_up(is_absent_ ? errc::needs_init : errc::port_lost);
            return true;
        }
        return false;
    }

    constexpr void start(const Command& o, std::uint8_t urgent = steps::urgent_frames) {
        command_ = o;
        is_own_ = false;
        is_follow_up_ = false;
        is_first_stop_ = false;
        if constexpr (requires { self().recheck(); }) {
            sequence_.set_recheck(self().takes_over(o) ? steps::recheck{} : self().recheck());
        }
        sequence_.begin(o.steps, o.input(), urgent);
    }
    // Not the application's: its end is not reported, and any command may take its place.
    constexpr void start_own(const Command& o, std::uint8_t urgent = steps::urgent_frames) {
        start(o, urgent);
        is_own_ = true;
    }

    constexpr void start_first_stop() {
        sequence_.set_silence_limit({}); // it is what ends the silence
        start_own(self().first_stop());
        is_first_stop_ = true;
    }

    constexpr void settle() {
        const routine_status r = sequence_.last();
        // A stop that does not read back was answered by somebody's late response: once more.
        if (!is_follow_up_ && command_.stop != stop_priority::no_stop &&
            r.error() == errc::unexpected_value && ++tries_ < tries_of_a_stop) {
            const std::uint8_t urgent = sequence_.urgent_left();
            return is_own_ ? start_own(command_, urgent) : start(command_, urgent);
        }
        if (r) is_found_ = true;
        if (r && (self().takes_over(command_) || self().is_command(command_))) is_open_ = false;
        if (!is_own_ && !is_follow_up_) report_ = r;
        if (r && command_.stop >= stop_priority::disable) is_commanded_ = false;
        if (!r && is_own_ && command_.stop != stop_priority::no_stop) {
            is_commanded_ = true; // not confirmed: again
            is_own_stop_open_ = is_own_stop_open_ || r.outcome() != outcome::not_sent;
            last_command_ = sequence_.line().now();
        }
        if (command_.stop != stop_priority::no_stop && (!is_own_ || is_open_)) note_stop(r);
        if (is_first_stop_) { // it leaves no other stop open
            is_open_ = is_open_ && !r;
            stopped_ = sequence_.line().now();
        }
        is_own_ = false;
        is_follow_up_ = false;
        const Command done = command_;
        if (r) {
            self().apply(done);
        } else {
            self().fail(done, r);
        }
        if constexpr (requires { self().recheck(); }) {
            if (sequence_.is_idle()) sequence_.set_recheck(self().recheck());
        }
    }

    constexpr void note_stop(const routine_status& r) {
        is_open_ = !r;
        if (r.outcome() != outcome::not_sent) open_urgent_ = again;
        open_stop_ = command_;
        stopped_ = sequence_.line().now();
    }
    constexpr void mind_the_stop() {
        if (!is_open_ || stop_every_ == duration{} || !sequence_.is_idle()) return;
        if (since(stopped_, sequence_.line().now()) < stop_every_) return;
        tries_ = 0;
        if constexpr (Self::restarts_on_traffic) {
            if (is_unheard_) return start_first_stop();
        }
        start_own(open_stop_, open_urgent_);
    }
    constexpr void mind_the_application() {
        const bool is_watched = command_limit_ != duration{} && (is_commanded_ || self().is_powered());
        if (!is_watched && !is_look_due_) return;
        if (is_watched && sequence_.is_idle() && self().is_powered() && sequence_.was_silent()) return lose();
        const instant now = sequence_.line().now();
        const bool is_stopping = !sequence_.is_idle() && command_.stop != stop_priority::no_stop;
        // A command to a drive of which nothing is believed is one that takes it over: it begins with a stop.
        const bool may_cut = self().is_powered() || is_idle();
        if (is_watched && is_commanded_ && !is_stopping && may_cut &&
            since(last_command_, now) > command_limit_) {
            is_commanded_ = false;
            tries_ = 0;
            if (!is_idle()) {
                ++number_;
                report_ = routine_status{status::sent(errc::preempted)};
                if (self().leaves_doubt(command_)) self().forget();
            }
            return start_own(self().watch_stop(), is_own_stop_open_ ? again : steps::urgent_frames);
        }
        const duration keep_alive = self().keep_alive_interval();
        const bool is_keep_alive_due = is_watched && self().is_powered() && keep_alive != duration{} &&
                                       since(sequence_.last_heard(), now) > keep_alive;
        if (!sequence_.is_idle() || !(is_keep_alive_due || is_look_due_)) return;
        is_look_due_ = false;
        const Command look = self().keep_alive();
        if (look.refusal == errc::ok) start_own(look); // something is believed
    }

    static constexpr std::uint8_t tries_of_a_stop = 3;
    // A stop that is repeated is not urgent: the drives that answer must not miss their requests for it.
    static constexpr std::uint8_t again = 0;

    sequence<Line> sequence_;
    Command command_{};
    routine_status report_{};
    duration command_limit_{};
    instant last_command_{};
    std::uint8_t number_ = 0; // of the application's command
    std::uint8_t tries_ = 0;
    Command open_stop_{}; // the application's, not confirmed yet
    instant stopped_{};
    std::uint8_t open_urgent_ = 0; // frames of it, as long as none has left
    duration stop_every_{};
    bool is_open_ = false;
    bool is_own_ = false;
    bool is_follow_up_ = false;
    bool is_commanded_ = false;
    bool is_own_stop_open_ = false; // given and not confirmed
    instant heard_before_{};        // the last time, before it was unheard
    bool is_unheard_;
    bool is_first_stop_ = false; // is under way
    bool is_found_ = false;
    bool is_absent_ = false; // for a bus, and not forgotten yet
    epoch noted_; // misses: at the last read of a bus that got a response; losses: those that were handled
    bool is_look_due_ = false; // they were others before
    bool is_valid_;
};

} // namespace servobus
