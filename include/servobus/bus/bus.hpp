// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Many drives on one line: the bus sends the cyclic reads of a plan at their rates, the commands of the
// drives' facades between them, and a stop before everything else. It polls drives that do not respond
// less often. Programs include it, or servobus.hpp. One `step` in each loop iteration never waits; `run`
// and `run_for` are blocking calls that loop over it.
//
//     bus<plan, line<posix::serial>> all{wire};
//     for (;;) {
//         all.step(wheels, lift); // the facades are stepped here and nowhere else
//         if (const auto speeds = all.latest<0>(milliseconds(60))) show(speeds->get<left_actual_speed>());
//     }
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/bus/plan.hpp>
#include <servobus/control/routine_status.hpp>
#include <servobus/line/line.hpp>

namespace servobus {

/// The reads of `Plan` over `Line`, with a facade's commands between them. It refers to the line.
template <const auto& Plan, class Line> class bus {
  public:
    static constexpr const auto& plan = Plan;
    static constexpr std::size_t size = Plan.size;

    constexpr explicit bus(Line& on, back_off rules = {}) : line_{&on}, rules_{rules} {
        const instant now = on.now();
        last_retry_ = now;
        for (std::size_t i = 0; i < size; ++i) {
            states_[i].due = now;
            use_word_order(i, Plan.polls[i].word_order);
        }
    }
    bus(const bus&) = delete; // an exchange refers to its buffers
    bus& operator=(const bus&) = delete;

    /// Moves the reads and the drives' commands on as far as they go without waiting. All facades on this
    /// line, one a drive, are stepped here and nowhere else; a call without one of them does not compile. A
    /// drive that its own watchdog may have stopped, since it was not heard for so long or never yet, hears a
    /// stop of its facade before it is read again, and its shafts are free then; without a facade here a read
    /// may let it go on. Returns the time within which nothing happens unless a byte comes.
    template <class... Drives> constexpr duration step(Drives&... drives) {
        static_assert(sizeof...(Drives) == Plan.facades,
                      "all controlled_drives of the plan are stepped here, and no others");
        forget_what_is_old();
        (drives.repeat_stops(rules_.stop_every), ...);
        (welcome(drives), ...);
        (synchronise_word_order(drives), ...);
        (grant(drives), ...);
        duration idle = longest_idle;
        // Before a read that is about to leave: it was begun before the stop was ordered.
        ((drives.has_stop_to_send() ? void(idle = shorter_of(idle, drives.step())) : void()), ...);
        if (reading_ != none) idle = shorter_of(idle, go_on(drives...));
        const bool reads_first = turn_ == turn::reads && reading_ == none;
        if (reads_first) idle = shorter_of(idle, begin_due(drives...));
        const bool was_free = line_->is_free();
        idle = shorter_of(idle, step_commands(drives...));
        if (was_free && !line_->is_free()) turn_ = turn::reads;
        if (!reads_first && reading_ == none) idle = shorter_of(idle, begin_due(drives...));
        return idle;
    }

    /// Blocking: steps for `time`, and ends with the read in flight.
    template <class... Drives> void run_for(duration time, Drives&... drives) {
        const instant start = line_->now();
        run_while([&] { return since(start, line_->now()) < time; }, drives...);
    }
    /// Blocking: runs a command of one drive to its end while the reads and the other drives go on.
    /// Errors: the command's own.
    template <class Drive, class Wanted, class... Others>
    routine_status run(Drive& drive, const Wanted& wanted, Others&... others) {
        const errc refusal = drive.begin(wanted);
        if (refusal != errc::ok) return routine_status{refusal};
        run_while([&] { return !drive.is_idle(); }, drive, others...);
        return drive.is_idle() ? drive.last() : routine_status{status::sent(errc::clock_stopped)};
    }

    /// What read number `I` of the plan gave last. Errors: the reason why its last attempt failed, if the
    /// values are older than `most` (or there are none); `timeout` if none has ended yet, or none since the
    /// order of words was told; `needs_word_order` for 32-bit values of a drive whose word order was not.
    template <std::size_t I>
    constexpr result<typename std::remove_cvref_t<decltype(Plan)>::template values<I>>
    latest(duration most) const {
        using values = typename std::remove_cvref_t<decltype(Plan)>::template values<I>;
        const state& s = states_[I];
        if (!s.has_values || since(s.taken, line_->now()) > most)
            return s.why.error() == errc::ok ? status{errc::timeout} : s.why;
        if constexpr (values::has_pairs) {
            if (order_of(I) == word_order::unknown) return errc::needs_word_order;
            if (order_of(I) != s.taken_in) return errc::timeout;
        }
        values v{s.taken_in};
        const auto words = v.words();
        for (std::size_t i = 0; i < words.size(); ++i) words[i] = words_[Plan.offset_of(I) + i];
        return v;
    }
    /// The order of the words of 32-bit values, as `client::learn_word_order` found it, for all reads of a
    /// node. It is invalid as soon as the node has not answered any request on this line, also another
    /// client's (`line::epoch`): the drive may have restarted. Where the node has a facade here, the facade
    /// says it: from `init` on, until something makes it void there.
    constexpr void set_word_order(std::uint8_t node_address, word_order order) {
        for (std::size_t i = 0; i < size; ++i) {
            if (Plan.polls[i].node_address == node_address) use_word_order(i, order);
        }
    }
    /// Good responses to read number `i` since the start; it wraps.
    constexpr std::uint32_t count(std::size_t i) const { return states_[i].count; }
    /// True while a node does not answer and is asked less often.
    constexpr bool is_absent(std::uint8_t node_address) const {
        const instant now = line_->now();
        for (std::size_t i = 0; i < size; ++i) {
            if (Plan.polls[i].node_address == node_address && is_asked_less(i, now)) return true;
        }
        return false;
    }

  private:
    enum class turn : std::uint8_t { reads, commands }; ///< whose frame goes first when the line is free
    static constexpr std::size_t none = size;
    static constexpr duration longest_idle = milliseconds(5);

    struct state {
        instant due{};
        instant taken{};
        std::uint32_t count = 0;
        status why{};
        std::uint8_t failures = 0;
        bool has_values = false;
        bool is_told_by_facade = false; // the word order
        verified<word_order> order{word_order::high_first, {}};
        word_order taken_in = word_order::high_first;
    };

    // What keeps a drive alive goes on until the drive has stopped by itself: perhaps it hears.
    constexpr bool is_asked_less(std::size_t i, instant now) const {
        const state& s = states_[i];
        const duration alive = Plan.polls[i].keep_alive;
        return s.failures >= rules_.failures &&
               (alive == duration{} || !s.has_values || since(s.taken, now) > alive);
    }

    constexpr void use_word_order(std::size_t i, word_order order) {
        states_[i].order = {order, line_->epoch(Plan.polls[i].node_address)};
    }
    // What the node was made with, if it may have restarted since its word order was learned.
    constexpr word_order order_of(std::size_t i) const {
        const bool holds = states_[i].order.holds(line_->epoch(Plan.polls[i].node_address));
        return holds ? states_[i].order.value : Plan.polls[i].word_order;
    }

    // What the end of read `i` means for a facade.
    template <class Drive> constexpr void tell(std::size_t i, Drive& drive) {
        const state& s = states_[i];
        if (drive.address() != Plan.polls[i].node_address) return;
        if (s.why.has_response()) return drive.note_heard(line_->began_at());
        if (s.failures == rules_.failures) drive.note_absence();
    }
    // A drive that its facade has found is read as often as any other.
    template <class Drive> constexpr void welcome(Drive& drive) {
        if (!drive.take_found()) return;
        for (std::size_t i = 0; i < size; ++i) {
            if (Plan.polls[i].node_address == drive.address()) states_[i].failures = 0;
        }
    }
    // The plan's times hold for no more, whatever delay a drive is set to.
    template <class Drive> static constexpr void grant(Drive& drive) {
        if constexpr (requires { drive.grant_at_most(duration{}); })
            drive.grant_at_most(Plan.longest_response());
    }
    template <class Drive> constexpr void synchronise_word_order(const Drive& drive) {
        if constexpr (requires { drive.current_word_order(); }) {
            const word_order known = drive.current_word_order();
            for (std::size_t i = 0; i < size; ++i) {
                state& s = states_[i];
                if (Plan.polls[i].node_address != drive.address()) continue;
                if (known != word_order::unknown) {
                    use_word_order(i, known);
                } else if (s.is_told_by_facade) {
                    use_word_order(i, Plan.polls[i].word_order);
                }
                s.is_told_by_facade = known != word_order::unknown;
            }
        }
    }
    template <class More, class... Drives> void run_while(More&& more, Drives&... drives) {
        auto guard = line_->new_stall_detector();
        while (more()) {
            const duration idle = step(drives...);
            if (guard.has_failed(line_->now())) return;
            line_->sleep(idle);
        }
        while (reading_ != none) { // the read in flight, or behind the commands that hold the line
            duration idle = step_commands(drives...);
            idle = shorter_of(idle, go_on(drives...));
            if (guard.has_failed(line_->now())) return;
            line_->sleep(idle);
        }
    }

    // Each in turn, and behind a frame that has ended the reads: between two of them goes one frame only.
    template <class... Drives> constexpr duration step_commands(Drives&... drives) {
        duration idle = longest_idle;
        const std::size_t first = next_drive_;
        bool is_over = false;
        for (const bool is_before_first : {false, true}) {
            std::size_t i = 0;
            [[maybe_unused]] const auto step_one = [&](auto& drive) {
                const std::size_t own = i++;
                if (is_over || (own < first) != is_before_first) return;
                const bool was_free = line_->is_free();
                idle = shorter_of(idle, drive.step());
                is_over = !was_free && line_->is_free();
                if (is_over) next_drive_ = own + 1;
            };
            (step_one(drives), ...);
        }
        return idle;
    }

    template <class... Drives> constexpr duration go_on(Drives&... drives) {
        const std::size_t i = reading_;
        const bool is_waiting = exchange_.state() == modbus::exchange::phase::ready;
        if (is_waiting && (goes_behind_a_stop(i, drives) || ...)) { // the program stood still meanwhile
            line_->abandon(exchange_);
            reading_ = none;
            return {};
        }
        const duration idle = line_->step(exchange_, Plan.polls[i].gaps);
        if (!exchange_.done()) return idle;
        conclude();
        (tell(i, drives), ...);
        return {};
    }

    // Starts the read that has waited longest, if the line is free for it. Returns the time to the next one.
    template <class... Drives> constexpr duration begin_due(Drives&... drives) {
        if (!line_->is_free()) return Plan.timing().wire_time(1);
        const instant now = line_->now();
        std::size_t best = none;
        duration waited{};
        duration next = longest_idle;
        for (std::size_t i = 0; i < size; ++i) {
            const state& s = states_[i];
            const duration ahead = since(now, s.due); // beyond a period the clock has jumped or wrapped
            if (went_back(s.due, now) && ahead <= Plan.polls[i].period) {
                next = shorter_of(next, ahead);
            } else if ((awaits_a_stop(i, drives) || ...)) {
                continue;
            } else if (is_asked_less(i, now) && since(last_retry_, now) < rules_.retry_every) {
                next = shorter_of(next, rules_.retry_every - since(last_retry_, now));
            } else if (best == none || since(s.due, now) > waited) {
                best = i;
                waited = since(s.due, now);
            }
        }
        if (best == none) return next;
        schedule(best, now);
        if ((goes_behind_a_stop(best, drives) || ...)) return {};
        begin(best);
        return go_on(drives...);
    }

    constexpr void schedule(std::size_t i, instant now) {
        const poll& p = Plan.polls[i];
        state& s = states_[i];
        if (is_asked_less(i, now)) last_retry_ = now;
        // A read that came late is not made up for: the next one is due a period after this one.
        s.due = since(s.due, now) < p.period ? s.due + p.period : now + p.period;
    }

    // The stop that has to go first waits for the end of a command.
    template <class Drive> constexpr bool awaits_a_stop(std::size_t i, Drive& drive) {
        return drive.address() == Plan.polls[i].node_address && drive.must_be_stopped_first() &&
               drive.is_under_way();
    }

    // A stop takes the turn of a read that must not be the first frame its drive hears.
    template <class Drive> constexpr bool goes_behind_a_stop(std::size_t i, Drive& drive) {
        if (drive.address() != Plan.polls[i].node_address || !drive.must_be_stopped_first()) return false;
        if (drive.stop_first()) {
            turn_ = turn::commands;
            if (states_[i].failures < rules_.failures) ++states_[i].failures;
        }
        return true;
    }

    constexpr void begin(std::size_t i) {
        const poll& p = Plan.polls[i];
        request_[0] = p.node_address;
        const std::size_t pdu = modbus::put_read_request(
            byte_buffer{request_}.subspan(1), modbus::function::read_holding_registers, p.address, p.words);
        exchange_ =
            modbus::exchange{bytes{request_}.first(modbus::close_frame<modbus::exchange::crc>(request_, pdu)),
                             response_, line_->timing(), p.limits};
        reading_ = i;
        turn_ = turn::commands;
    }

    constexpr void conclude() {
        state& s = states_[reading_];
        s.why = exchange_.status();
        if (s.why.error() == errc::ok) {
            const std::size_t at = Plan.offset_of(reading_);
            for (std::size_t i = 0; i < exchange_.words().size(); ++i) words_[at + i] = exchange_.words()[i];
            s.taken = line_->began_at();
            s.has_values = true;
            s.taken_in = order_of(reading_);
            s.failures = 0;
            ++s.count;
        } else if (s.why.error() == errc::exception) {
            s.failures = 0; // it is there
        } else {
            if (s.failures < rules_.failures) ++s.failures;
        }
        // A read that took longer than its period goes behind those that became due meanwhile.
        if (const instant now = line_->now(); !went_back(s.due, now)) s.due = now;
        reading_ = none;
    }

    // Before the clock wraps.
    constexpr void forget_what_is_old() {
        const instant now = line_->now();
        for (state& s : states_) {
            if (since(s.taken, now) > longest_period) s.has_values = false;
        }
    }

    Line* line_;
    back_off rules_;
    state states_[size]{};
    std::uint16_t words_[Plan.words]{};
    std::uint8_t response_[Plan.response_room]{};
    std::uint8_t request_[8]{};
    modbus::exchange exchange_{};
    instant last_retry_{};
    std::size_t reading_ = none;
    std::size_t next_drive_ = 0;
    turn turn_ = turn::reads;
};

} // namespace servobus
