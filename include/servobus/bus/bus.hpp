// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Many drives on one line: the bus steps the facades of a plan and sends its cyclic reads. A stop goes before
// everything else, and of the other frames the one that has waited longest. Programs include it, or
// servobus.hpp. One `step` in each loop iteration never waits; `run` and `run_for` are blocking calls that
// loop over it.
//
//     auto all = make_bus<plan>(wire, wheels, lift);
//     for (;;) {
//         all.step(); // the drives are stepped here and nowhere else
//         if (const auto seen = all.latest<0>(milliseconds(500))) show(seen->get<zlac8015d::bus_voltage>());
//     }
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include <servobus/bus/detail/drive_list.hpp>
#include <servobus/bus/detail/read_order.hpp>
#include <servobus/bus/detail/step_beside.hpp>
#include <servobus/bus/plan.hpp>
#include <servobus/control/facade.hpp>
#include <servobus/line/line.hpp>

namespace servobus {

/// The drives and the cyclic reads of `Plan` on `Line`. It refers to the line and to the drives.
template <const auto& Plan, class Line, class... Drives> class bus {
    using plan_type = std::remove_cvref_t<decltype(Plan)>;
    static_assert(sizeof...(Drives) == Plan.drives,
                  "a bus has the controlled drives of its plan, in their order, and no others");

  public:
    static constexpr const auto& plan = Plan;
    static constexpr std::size_t size = Plan.size;

    /// The drives take their limits, gaps and supervision from the plan. One that is at another address than in the
    /// plan, or on another line, is not polled and refuses all commands but stops (`bad_argument`).
    constexpr explicit bus(Line& on, Drives&... drives) : line_{&on}, drives_{drives...} {
        check(std::make_index_sequence<sizeof...(Drives)>{});
        on.follow(&detail::step_beside<Plan, Line>);
        const instant now = on.now();
        last_retry_ = now;
        for (std::size_t i = 0; i < size; ++i) {
            states_[i].due = now;
            use_word_order(i, Plan.polls[i].word_order);
        }
        drives_.each([&on](std::size_t i, auto& drive) {
            scheduling::adopt(drive, on, Plan.controlled[i], Plan.rules().stop_every, Plan.retry_period(),
                              Plan.longest_response());
        });
    }
    bus(const bus&) = delete; // an exchange refers to its buffers
    bus& operator=(const bus&) = delete;

    /// Moves the drives and the reads on as far as they go without waiting. The drives are stepped here and nowhere
    /// else. Returns the time within which nothing happens unless a byte arrives.
    constexpr duration step() {
        drop_values_of_lost_drives();
        drop_old_values();
        duration idle = longest_idle;
        const auto note = [&idle](duration own) { idle = shorter_of(idle, own); };
        // Before another frame begins to leave.
        drives_.each([&](std::size_t, auto& drive) {
            if (scheduling::has_stop(drive)) note(drive.step());
        });
        // Frames on the wire come before the line is taken to be free: the program may have been stopped since. A
        // request that is found to have left only now may have its response already.
        for (int twice = 0; twice < 2; ++twice) {
            drives_.each([&](std::size_t, auto& drive) {
                if (scheduling::is_on_the_wire(drive)) note(drive.step());
            });
            if (is_on_the_wire()) note(step_reads());
        }
        const std::size_t oldest = line_->is_free() ? longest_waiting() : nothing;
        if (oldest == others_number) return {}; // the program's own request is stepped next
        drives_.each([&](std::size_t i, auto& drive) {
            if (i == oldest) note(drive.step());
        });
        if (oldest == reads_number) note(step_reads());
        drives_.each([&](std::size_t i, auto& drive) {
            if (i != oldest && !scheduling::is_on_the_wire(drive)) note(drive.step());
        });
        if (oldest != reads_number && !is_on_the_wire()) note(step_reads());
        return idle;
    }

    /// Blocking: steps for `time`, and until no frame is on the wire.
    void run_for(duration time) {
        const instant start = line_->now();
        (void)run_while([&] { return since(start, line_->now()) < time; });
    }
    /// Blocking: runs a command of one drive to its end while the reads and the other drives go on. The command
    /// timeout of that drive begins again meanwhile. Errors: the command's own; `bad_argument` for a drive that is
    /// not on this bus.
    template <class Drive, class Wanted> routine_status run(Drive& drive, const Wanted& wanted) {
        static_assert((std::is_same_v<Drive, Drives> || ...), "a bus runs commands of its own drives");
        bool is_own = false;
        drives_.each([&](std::size_t, const auto& own) {
            is_own = is_own || static_cast<const void*>(&own) == static_cast<const void*>(&drive);
        });
        if (!is_own) return routine_status{errc::bad_argument};
        const errc refusal = scheduling::begin_to_wait(drive, wanted);
        if (refusal != errc::ok) return routine_status{refusal};
        const bool has_ended = run_while([&] {
            scheduling::note_wait(drive);
            return !drive.is_idle();
        });
        if (!has_ended) scheduling::give_up(drive, errc::clock_stopped);
        return drive.last();
    }
    /// Blocking: runs a move of one drive and waits for its end. Returns how that was, as `drive.run(move, end)` does.
    template <class Drive, class Move, class End>
    auto run(Drive& drive, const Move& move, const End& end) -> decltype(drive.arrival(end)) {
        if (!run(drive, move)) return {};
        (void)run(drive, end);
        return drive.arrival(end);
    }

    /// The last values of cyclic read number `I` of the plan. Errors:
    /// - the reason why the last attempt failed, if the values are older than `oldest`, or there are none
    /// - `timeout`: no read has ended yet, or none since the word order is known
    /// - `needs_word_order`: 32-bit values of a node whose word order is not known
    /// - `needs_init`: nothing is known of the controlled drive
    template <std::size_t I>
    constexpr result<typename plan_type::template values<I>> latest(duration oldest) const {
        return latest_of<typename plan_type::template values<I>>(I, plan_type::offsets.words_before[I],
                                                                 oldest);
    }
    /// The word order of 32-bit values, as `client::learn_word_order` found it, for all cyclic reads of a node without a
    /// facade; a controlled drive has its own. It is invalid as soon as a request to the node got no response, also one
    /// of another client (`line::epoch`): the node may have restarted.
    constexpr void set_word_order(std::uint8_t node_address, word_order order) {
        for (std::size_t i = 0; i < size; ++i) {
            if (Plan.polls[i].node_address == node_address) use_word_order(i, order);
        }
    }
    /// Good responses to read number `i` since the start; it wraps.
    constexpr std::uint32_t count(std::size_t i) const { return states_[i].count; }
    /// True while a node does not respond and is read less often; of a controlled drive, `drive.is_absent()`.
    constexpr bool is_absent(std::uint8_t node_address) const {
        const instant now = line_->now();
        bool is = false;
        for (std::size_t i = 0; i < size; ++i)
            is = is || (Plan.polls[i].node_address == node_address && is_asked_less(i, now));
        drives_.each([&](std::size_t, const auto& drive) {
            if (drive.address() == node_address) is = drive.is_absent();
        });
        return is;
    }

  private:
    static constexpr std::size_t none = size;
    // The parties that wait for the line: the drives by their numbers, then the cyclic reads together.
    static constexpr std::size_t reads_number = Plan.drives;
    static constexpr std::size_t others_number = Plan.drives + 1; // the program's own requests
    static constexpr std::size_t nothing = Plan.drives + 2;
    static constexpr duration longest_idle = milliseconds(5);
    static constexpr duration longest_pause = milliseconds(1000); // between searches through all reads

    struct state {
        instant due{};
        instant taken{};
        std::uint32_t count = 0;
        status why{};
        std::uint8_t failures = 0;
        bool has_values = false;
        [[no_unique_address]] detail::read_order<Plan.has_pairs> order;
    };

    // The drives that have cyclic reads.
    struct flags {
        bool of[Plan.drives + 1]{};
    };
    static constexpr flags has_reads = [] {
        flags has{};
        for (std::size_t i = 0; i < size; ++i) has.of[Plan.drive_at(Plan.polls[i].node_address)] = true;
        return has;
    }();

    template <std::size_t... I> static constexpr void check(std::index_sequence<I...>) {
        static_assert((std::is_base_of_v<facade<typename plan_type::template model<I>, Line>, Drives> && ...),
                      "a bus has the controlled drives of its plan, in their order, and no others");
    }

    // --- The next frame

    constexpr std::size_t longest_waiting() {
        std::size_t oldest = nothing;
        std::uint16_t lowest = 0;
        const auto look = [&](std::size_t party, std::uint16_t ticket) {
            const bool is_older = oldest == nothing || static_cast<std::int16_t>(ticket - lowest) < 0;
            if (ticket == 0 || !is_older) return; // tickets wrap
            oldest = party;
            lowest = ticket;
        };
        drives_.each([&](std::size_t i, const auto& drive) { look(i, scheduling::ticket(drive)); });
        if (is_waiting()) look(reads_number, exchange_.ticket());
        if constexpr (Plan.requested != 0) look(others_number, line_->others().take_waiting());
        return oldest;
    }
    // False if the clock has stopped.
    template <class More> bool run_while(More&& more) {
        auto guard = line_->new_stall_detector();
        const auto pause = [&](duration idle) {
            if (guard.has_failed(line_->now())) return false;
            line_->sleep(idle);
            return true;
        };
        while (more()) {
            if (!pause(step())) return false;
        }
        for (;;) { // the frame on the wire
            bool is_any = false;
            duration idle{};
            drives_.each([&](std::size_t, auto& drive) {
                if (!scheduling::is_on_the_wire(drive)) return;
                is_any = true;
                idle = drive.step();
            });
            if (is_on_the_wire()) {
                is_any = true;
                idle = step_reads();
            }
            if (!is_any) return true;
            if (!pause(idle)) return true;
        }
    }

    // --- Knowledge of a node

    // Ok, or the reason why a read has no values that are young enough.
    constexpr status why_not(std::size_t i, duration oldest, [[maybe_unused]] bool is_of_pairs) const {
        const state& s = states_[i];
        if (!is_known(i)) return errc::needs_init;
        const instant now = line_->now();
        if (!has_values(s, now) || since(s.taken, now) > oldest)
            return s.why.error() == errc::ok ? status{errc::timeout} : s.why;
        if constexpr (Plan.has_pairs) {
            if (is_of_pairs && order_of(i) == word_order::unknown) return errc::needs_word_order;
            if (is_of_pairs && order_of(i) != s.order.taken_in) return errc::timeout;
        }
        return {};
    }
    template <class Values>
    constexpr result<Values> latest_of(std::size_t i, std::size_t offset, duration oldest) const {
        if (const status why = why_not(i, oldest, Values::has_pairs); !why) return why;
        Values v{taken_in(i)};
        const auto words = v.words();
        for (std::size_t k = 0; k < words.size(); ++k) words[k] = words_[offset + k];
        return v;
    }

    // Calls `call(drive)` with the facade of read number `i`'s node, if it has one.
    template <class Call> constexpr void with_drive_of(std::size_t i, Call&& call) const {
        const std::size_t own = Plan.drive_at(Plan.polls[i].node_address);
        drives_.each([&](std::size_t k, auto& drive) {
            if (k == own) call(drive);
        });
    }
    // True if the node may be read: it has no facade, or one that knows of no restart.
    constexpr bool may_be_read(std::size_t i) {
        bool may = true;
        with_drive_of(i, [&](auto& drive) { may = scheduling::may_be_read(drive); });
        return may;
    }
    constexpr bool is_known(std::size_t i) const {
        bool is = true;
        with_drive_of(i, [&](const auto& drive) { is = scheduling::is_known(drive); });
        return is;
    }
    constexpr void use_word_order([[maybe_unused]] std::size_t i, [[maybe_unused]] word_order order) {
        if constexpr (Plan.has_pairs)
            states_[i].order.learned = {order, line_->epoch(Plan.polls[i].node_address)};
    }
    // The word order of a read's values; without 32-bit values there is none.
    constexpr word_order taken_in([[maybe_unused]] std::size_t i) const {
        if constexpr (Plan.has_pairs)
            return states_[i].order.taken_in;
        else
            return word_order::high_first;
    }
    // The word order of the node's facade. Without one: the learned one, or the one that the node was made with if the
    // node may have restarted since.
    constexpr word_order order_of(std::size_t i) const {
        const verified<word_order>& learned = states_[i].order.learned;
        const bool holds = learned.holds(line_->epoch(Plan.polls[i].node_address));
        word_order order = holds ? learned.value : Plan.polls[i].word_order;
        with_drive_of(i, [&](const auto& drive) {
            if constexpr (requires { drive.current_word_order(); }) order = drive.current_word_order();
        });
        return order;
    }
    // Drops the values of reads whose drive is not known any more. Such a read is due as soon as it is known again.
    constexpr void drop_values_of_lost_drives() {
        if constexpr (Plan.drives != 0) {
            drives_.each([this](std::size_t k, auto& drive) {
                if (!has_reads.of[k] || scheduling::may_be_read(drive)) return;
                for (std::size_t i = 0; i < size; ++i) {
                    if (Plan.polls[i].node_address != Plan.controlled[k].address) continue;
                    states_[i].has_values = false;
                    states_[i].failures = 0;
                }
                pause_ = {};
            });
        }
    }
    // Drops values so old that the clock may wrap: they would seem new then.
    constexpr void drop_old_values() {
        const instant now = line_->now();
        if (since(dropped_at_, now) < longest_pause) return;
        dropped_at_ = now;
        for (state& s : states_) s.has_values = has_values(s, now);
    }
    constexpr bool has_values(const state& s, instant now) const {
        return s.has_values && since(s.taken, now) <= longest_period;
    }
    // A keep-alive read does not back off until the node's own watchdog has passed: the node may still receive it.
    constexpr bool is_asked_less(std::size_t i, instant now) const {
        const state& s = states_[i];
        const duration alive = Plan.polls[i].keep_alive;
        return s.failures >= Plan.rules().failures &&
               (alive == duration{} || !has_values(s, now) || since(s.taken, now) > alive);
    }

    // --- The cyclic reads

    constexpr bool is_on_the_wire() const { return reading_ != none && !is_waiting(); }
    constexpr bool is_waiting() const {
        return reading_ != none && exchange_.state() == modbus::exchange::phase::ready;
    }
    constexpr duration step_reads() {
        if constexpr (size == 0) {
            return longest_idle;
        } else {
            // The program may have been stopped since it was begun.
            if (is_waiting() && !may_be_read(reading_)) {
                line_->abandon(exchange_);
                reading_ = none;
            }
            if (reading_ == none) {
                const duration idle = begin_due();
                if (reading_ == none) return idle;
            }
            const duration idle = line_->step(exchange_, Plan.polls[reading_].gaps);
            if (!exchange_.done()) return idle;
            conclude();
            return {};
        }
    }
    // Begins the read that has waited longest. Returns the time to the next one. A search that finds none is not
    // repeated before the first is due: a step costs the same, however many reads there are.
    constexpr duration begin_due() {
        const instant now = line_->now();
        if (const duration passed = since(searched_at_, now); passed < pause_)
            return shorter_of(pause_ - passed, longest_idle);
        std::size_t best = none;
        duration waited{};
        duration next = longest_pause;
        bool is_any_lost = false; // such a read is due as soon as its drive is known
        for (std::size_t i = 0; i < size; ++i) {
            const state& s = states_[i];
            const duration ahead = since(now, s.due); // beyond a period the clock has jumped or wrapped
            if (went_back(s.due, now) && ahead <= Plan.polls[i].period) {
                next = shorter_of(next, ahead);
            } else if (is_asked_less(i, now) && since(last_retry_, now) < Plan.rules().retry_every) {
                next = shorter_of(next, Plan.rules().retry_every - since(last_retry_, now));
            } else if (!may_be_read(i)) {
                is_any_lost = true;
            } else if (best == none || since(s.due, now) > waited) {
                best = i;
                waited = since(s.due, now);
            }
        }
        searched_at_ = now;
        pause_ = best == none && !is_any_lost ? next : duration{};
        if (best == none) return shorter_of(next, longest_idle);
        schedule(best, now);
        begin(best);
        return {};
    }
    constexpr void schedule(std::size_t i, instant now) {
        const poll& p = Plan.polls[i];
        state& s = states_[i];
        if (is_asked_less(i, now)) last_retry_ = now;
        // A read that came late is not sent twice: the next one is due a period after this one.
        s.due = since(s.due, now) < p.period ? s.due + p.period : now + p.period;
    }
    constexpr void begin(std::size_t i) {
        const poll& p = Plan.polls[i];
        request_[0] = p.node_address;
        const std::size_t pdu = modbus::put_read_request(
            byte_buffer{request_}.subspan(1), modbus::function::read_holding_registers, p.address, p.words);
        exchange_ =
            modbus::exchange{bytes{request_}.first(modbus::close_frame<modbus::exchange::crc>(request_, pdu)),
                             response_, line_->timing(), p.limits, priority::planned};
        reading_ = i;
    }
    constexpr void conclude() {
        state& s = states_[reading_];
        s.why = exchange_.status();
        if (s.why.error() == errc::ok) {
            const std::size_t at = Plan.offset_of(reading_);
            for (std::size_t i = 0; i < exchange_.words().size(); ++i) words_[at + i] = exchange_.words()[i];
            s.taken = line_->began_at();
            if constexpr (Plan.has_pairs) s.order.taken_in = order_of(reading_);
            s.has_values = true;
            ++s.count;
        }
        if (s.why.has_response()) {
            s.failures = 0;
        } else if (s.failures < Plan.rules().failures) {
            ++s.failures;
        }
        // A read that took longer than its period goes after those that became due meanwhile.
        if (const instant now = line_->now(); !went_back(s.due, now)) s.due = now;
        reading_ = none;
    }

    static constexpr std::size_t at_least_one(std::size_t n) { return n == 0 ? 1 : n; }

    Line* line_;
    [[no_unique_address]] detail::drive_list<Drives...> drives_;
    state states_[at_least_one(size)]{};
    std::uint16_t words_[at_least_one(Plan.words)]{};
    std::uint8_t response_[Plan.response_room]{};
    std::uint8_t request_[8]{};
    modbus::exchange exchange_{};
    instant last_retry_{};
    instant searched_at_{}; // for a read that is due
    duration pause_{};      // after that, within which none becomes due
    instant dropped_at_{};  // old values
    std::size_t reading_ = none;
};

/// A bus of a plan, with the drives that the plan controls in their order.
template <const auto& Plan, class Line, class... Drives>
constexpr bus<Plan, Line, Drives...> make_bus(Line& on, Drives&... drives) {
    return bus<Plan, Line, Drives...>{on, drives...};
}

} // namespace servobus
