// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Many drives on one line: the bus steps the facades of a plan and sends its cyclic reads. A stop goes before
// everything else, then the frame that has waited longest. Programs include it, or
// servobus.hpp. One `step` in each loop iteration never waits; `run` and `run_for` are blocking calls that
// loop over it.
//
//     auto all = make_bus<plan>(wire, wheels, lift); // wire: a scheduled_line
//     for (;;) {
//         all.step(); // the drives are stepped here and nowhere else
//         if (const auto seen = all.latest<zlac8015d::bus_voltage>(wheels_node, milliseconds(500))) show(*seen);
//     }
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include <servobus/bus/detail/cyclic_reads.hpp>
#include <servobus/bus/detail/planned_rows.hpp>
#include <servobus/bus/detail/step_beside.hpp>
#include <servobus/bus/plan.hpp>
#include <servobus/bus/scheduled_line.hpp>
#include <servobus/control/facade.hpp>
#include <servobus/control/motion_commands.hpp>
#include <servobus/line/line.hpp>

namespace servobus {

/// The drives and the cyclic reads of `Plan` on `Line`. It refers to the line and to the drives.
template <const auto& Plan, class Line, class... Drives>
class bus : detail::cyclic_reads<Plan, Line, Drives...> {
    using reads = detail::cyclic_reads<Plan, Line, Drives...>;
    using reads::drives_;
    using reads::line_;
    using plan_type = std::remove_cvref_t<decltype(Plan)>;
    static_assert(detail::is_scheduled<Line>, "a bus has a scheduled_line, not a line");
    static_assert(sizeof...(Drives) == Plan.drives,
                  "a bus has the controlled drives of its plan, in their order, and no others");

  public:
    static constexpr const auto& plan = Plan;
    static constexpr std::size_t size = Plan.size;

    /// The drives take their limits, gaps and supervision from the plan. A drive at another address than in the
    /// plan, or on another line, is not polled and refuses all commands but stops (`bad_argument`).
    constexpr explicit bus(Line& on, Drives&... drives) : reads{on, drives...} {
        check(std::make_index_sequence<sizeof...(Drives)>{});
        on.admit_ = &detail::step_beside<Plan, Line>;
        drives_.each([this](std::size_t i, auto& drive) { this->adopt(drive, Plan.controlled[i]); });
    }
    bus(const bus&) = delete; // an exchange refers to its buffers
    bus& operator=(const bus&) = delete;

    /// Moves the drives and the reads on as far as they go without waiting. The drives are stepped here and nowhere
    /// else. Returns the time within which nothing happens unless a byte arrives.
    constexpr duration step() {
        this->drop_values_of_lost_drives();
        this->drop_old_values();
        duration idle = reads::longest_idle;
        const auto note = [&idle](duration own) { idle = shorter_of(idle, own); };
        // Stops are stepped before another frame begins to leave.
        drives_.each([&](std::size_t, auto& drive) {
            if (drive.machine().wants_stop()) note(step_of(drive));
        });
        // Frames on the wire are stepped before the line counts as free: the program may have stalled since. Twice: a
        // request that is found to have left only now may have its response already.
        for (int twice = 0; twice < 2; ++twice) {
            drives_.each([&](std::size_t, auto& drive) {
                if (drive.machine().is_on_the_wire()) note(step_of(drive));
            });
            if (this->is_read_on_the_wire()) note(this->step_reads());
        }
        const std::size_t oldest = line_->is_free() ? longest_waiting() : nothing;
        if (oldest == others_number) return {}; // the program's own request is stepped next
        drives_.each([&](std::size_t i, auto& drive) {
            if (i == oldest) note(step_of(drive));
        });
        if (oldest == reads_number) note(this->step_reads());
        drives_.each([&](std::size_t i, auto& drive) {
            if (i != oldest && !drive.machine().is_on_the_wire()) note(step_of(drive));
        });
        if (oldest != reads_number && !this->is_read_on_the_wire()) note(this->step_reads());
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
    template <class Drive, class Wanted> command_status run(Drive& drive, const Wanted& wanted) {
        static_assert((std::is_same_v<Drive, Drives> || ...), "a bus runs commands of its own drives");
        bool is_own = false;
        drives_.each([&](std::size_t, const auto& own) {
            is_own = is_own || static_cast<const void*>(&own) == static_cast<const void*>(&drive);
        });
        if (!is_own) return errc::bad_argument;
        if constexpr (requires { requires Drive::template repeats<Wanted>; }) {
            for (;;) {
                const instant begun = line_->now();
                const command_status how = run_once(drive, wanted);
                if (!how || !drive.is_changing_speed()) return how;
                const bool is_due = run_while([&] {
                    drive.machine().supervisors().note_command(line_->now());
                    return since(begun, line_->now()) < milliseconds(20);
                });
                if (!is_due) return errc::clock_stopped;
            }
        } else {
            return run_once(drive, wanted);
        }
    }
    /// Blocking: runs a command that is made of others, such as `take_over`. Returns which of them failed, and how.
    template <class Drive, commands::made_of_commands Wanted>
    command_status run(Drive& drive, const Wanted& wanted) {
        return wanted.run_by(drive, [&](const auto& part) { return this->run(drive, part); });
    }
    /// Blocking: runs a move of one drive and waits for its end. Returns what `drive.run(move, end)` does.
    template <class Drive, class Move, class End>
    auto run(Drive& drive, const Move& move, const End& end) -> decltype(drive.arrival(end)) {
        commands::check_target<Move>();
        if (!run(drive, move)) return {};
        (void)run(drive, end);
        return drive.arrival(end);
    }

    /// A drive of the bus by whose `run` a program for one drive runs its commands while the bus goes on.
    template <class Drive> class blocking_drive {
      public:
        auto run(const auto&... what) { return all_->run(*drive_, what...); }
        const Drive& drive() const { return *drive_; }

      private:
        friend bus;
        blocking_drive(bus& all, Drive& drive) : all_{&all}, drive_{&drive} {}

        bus* all_;
        Drive* drive_;
    };
    template <class Drive> blocking_drive<Drive> blocking(Drive& drive) { return {*this, drive}; }

    /// The last value of row `R` that a cyclic read of the plan brought from the node, a constant of the program. If
    /// several reads of the node have the row, the one with the shortest period counts. Errors:
    /// - the reason why the last attempt failed, if the value is older than `oldest`, or there is none
    /// - `timeout`: no read has ended yet, or none since the word order is known
    /// - `needs_word_order`: a 32-bit value of a node whose word order is not known
    /// - `needs_init`: nothing is known of the controlled drive
    ///
    /// A row that the plan does not read of this node does not compile.
    template <const auto& R>
    constexpr result<reading<R>> latest(detail::row_that_the_plan_reads_of_this_node<Plan, R> of,
                                        duration oldest) const {
        return this->template latest_row<R>(of.place, oldest);
    }
    /// Likewise, from the only node of the plan that has the row. With two such nodes it does not compile.
    template <const auto& R> constexpr result<reading<R>> latest(duration oldest) const {
        return this->template latest_row<R>(detail::place_at_the_only_node<Plan, R>(), oldest);
    }
    /// The last values of several rows, which are of one moment: only rows of one cyclic read of the plan compile.
    /// `get` returns the value of each. Errors: likewise.
    template <const auto& R, const auto& Second, const auto&... Others>
    constexpr result<readings<R, Second, Others...>> latest(
        std::type_identity_t<detail::rows_that_one_cyclic_read_has_of_this_node<Plan, R, Second, Others...>>
            of,
        duration oldest) const {
        return this->template latest_rows<R, Second, Others...>(of.place, oldest);
    }
    template <const auto& R, const auto& Second, const auto&... Others>
    constexpr result<readings<R, Second, Others...>> latest(duration oldest) const {
        return this->template latest_rows<R, Second, Others...>(
            detail::place_at_the_only_node<Plan, R, Second, Others...>(), oldest);
    }
    /// Never compiles: a read has no number, and the order of a plan's entries means nothing.
    template <std::size_t I> constexpr auto latest(duration) const {
        static_assert(sizeof(std::size_t[I + 1]) == 0,
                      "a cyclic value is asked for by its row and node: latest<row>(node, oldest)");
    }
    /// Sets the word order of all cyclic reads of a node without a facade, as `client::learn_word_order` found it. It
    /// becomes invalid when a request of any client to the node gets no response, or writes the register of the word
    /// order (`line::epoch`).
    constexpr void set_word_order(std::uint8_t node_address, word_order order) {
        for (std::size_t i = 0; i < size; ++i) {
            if (Plan.polls[i].node_address == node_address) this->use_word_order(i, order);
        }
    }
    /// The number of good responses to read `i`; it wraps.
    constexpr std::uint32_t count(std::size_t i) const { return this->responses(i); }
    /// True while a node does not respond and is read less often; of a controlled drive, `drive.is_absent()`.
    constexpr bool is_absent(std::uint8_t node_address) const {
        bool is = this->is_asked_less(node_address);
        drives_.each([&](std::size_t, const auto& drive) {
            if (drive.address() == node_address) is = drive.is_absent();
        });
        return is;
    }

  private:
    template <class Drive, class Wanted> command_status run_once(Drive& drive, const Wanted& wanted) {
        const errc refusal = drive.machine().note_refusal(drive.begin(wanted).error());
        if (refusal != errc::ok) return refusal;
        const bool has_ended = run_while([&] {
            drive.machine().supervisors().note_command(line_->now());
            return !drive.is_idle();
        });
        if (!has_ended) {
            drive.machine().give_up(errc::clock_stopped, line_->now());
            drive.machine().notify(*line_);
        }
        return drive.last();
    }
    // The parties that wait for the line: the drives by their numbers, then the cyclic reads together.
    static constexpr std::size_t reads_number = Plan.drives;
    static constexpr std::size_t others_number = Plan.drives + 1; // the program's own requests
    static constexpr std::size_t nothing = Plan.drives + 2;

    // A drive of a plan may have a model that derives from the device's, such as an axis.
    template <class Model, class Drive>
    static constexpr bool is_drive_of = std::is_base_of_v<facade<typename Drive::model_type, Line>, Drive>&&
        std::is_base_of_v<Model, typename Drive::model_type>;
    template <std::size_t... I> static constexpr void check(std::index_sequence<I...>) {
        static_assert((is_drive_of<typename plan_type::template model<I>, Drives> && ...),
                      "a bus has the controlled drives of its plan, in their order, and no others");
    }

    template <class Drive> constexpr void adopt(Drive& drive, const supervised_node& as) {
        auto& machine = drive.machine();
        const bool is_here = &drive.line() == line_;
        if (is_here) machine.terms().follow_plan(); // also a refused one: its stops are read back
        if (!is_here || drive.address() != as.address) return machine.refuse();
        machine.adopt(as, Plan.rules().stop_every, Plan.retry_period(), Plan.longest_response(),
                      line_->now());
    }

    // --- The next frame

    // A drive may say that it responds later than the plan counts with: it is not waited for so long.
    template <class Drive> static constexpr duration step_of(Drive& drive) {
        const duration idle = drive.step();
        drive.machine().terms().bound_response(Plan.longest_response());
        return idle;
    }
    constexpr std::size_t longest_waiting() {
        std::size_t oldest = nothing;
        std::uint16_t lowest = 0;
        const auto look = [&](std::size_t party, std::uint16_t ticket) {
            const bool is_older = oldest == nothing || static_cast<std::int16_t>(ticket - lowest) < 0;
            if (ticket == 0 || !is_older) return; // tickets wrap
            oldest = party;
            lowest = ticket;
        };
        drives_.each([&](std::size_t i, const auto& drive) { look(i, drive.machine().ticket()); });
        if (this->is_read_waiting()) look(reads_number, this->read_ticket());
        if constexpr (Plan.requested != 0) look(others_number, line_->others_.take_waiting());
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
                if (!drive.machine().is_on_the_wire()) return;
                is_any = true;
                idle = step_of(drive);
            });
            if (this->is_read_on_the_wire()) {
                is_any = true;
                idle = this->step_reads();
            }
            if (!is_any) return true;
            if (!pause(idle)) return true;
        }
    }
};

/// A bus of a plan, with the drives that the plan controls in their order.
template <const auto& Plan, class Line, class... Drives>
constexpr bus<Plan, Line, Drives...> make_bus(Line& on, Drives&... drives) {
    return bus<Plan, Line, Drives...>{on, drives...};
}

} // namespace servobus
