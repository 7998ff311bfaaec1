// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the facades of all drives share. A facade keeps the drive's feedback as a process image, runs one
// command at a time, checks that the drive has not restarted, and stops it where the application or the line
// fails. The `drive.hpp` of each device derives from it and describes the drive by a model.
//
//     const errc refused = wheels.begin(zlac8015d::velocity{30 * r_per_min, 30 * r_per_min});
//     if (refused != errc::ok) return 1;
//     while (!wheels.is_idle()) wheels.step(); // in your loop, between your other work
//     if (!wheels.last()) std::puts(text(wheels.last().error()));
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/client/node.hpp>
#include <servobus/control/common_commands.hpp>
#include <servobus/control/detail/drive_link.hpp>
#include <servobus/control/detail/held_reading.hpp>
#include <servobus/control/detail/optional_functions.hpp>
#include <servobus/control/detail/polling.hpp>
#include <servobus/control/detail/routine_run.hpp>
#include <servobus/control/detail/supervisors.hpp>
#include <servobus/control/drive_traits.hpp>
#include <servobus/control/scheduling.hpp>
#include <servobus/control/states.hpp>
#include <servobus/control/supervision.hpp>
#include <servobus/line/line.hpp>

namespace servobus {

/// A facade of one drive on `Line`; nothing else sends to the drive. `Model` describes it (device/README.md).
template <class Model, class Line> class facade {
  public:
    using prepared_command = typename Model::prepared_command;
    using settings = typename Model::settings;
    /// In which respects the drive differs from others.
    static constexpr drive_traits traits = Model::traits;

    // An exchange refers to this object's buffers.
    facade(const facade&) = delete;
    facade& operator=(const facade&) = delete;

    /// True if no command is under way, nor a stop of a supervisor.
    constexpr bool is_idle() const { return owner_ == owner::none; }
    /// How the application's last command ended; meaningful when idle.
    constexpr const routine_status& last() const { return report_; }
    /// `faulted` if the last feedback shows a fault.
    constexpr drive_state state() const {
        return is_known() && is_faulted() ? Model::faulted : settings_.state;
    }
    /// What is known of the drive's settings.
    constexpr const settings& cached() const { return settings_; }
    /// Why the drive stopped following its last motion command; `unknown` while it follows.
    constexpr stop_cause cause() const { return cause_; }
    /// The drive does not respond. One with a watchdog has not for its time; any other has not to three readings in a
    /// row, and is then read once a second, on a bus once in the retry period of its plan.
    constexpr bool is_absent() const {
        return polling_.absence().is_absent() || (link_.is_expired() && link_.has_missed());
    }

    /// Runs a command to its end. Waits; bounded by the routine's limits. The command timeout begins again
    /// meanwhile. Errors: the command's own; `preempted` if a stop replaced it.
    template <class Wanted> routine_status run(const Wanted& wanted) {
        prepared_command next = commands::prepared(wanted, valid_settings());
        return run_planned(next);
    }

    /// Starts a command; `step` moves it on. A stop replaces a command of lower priority and is sent right
    /// after the frame in flight. Errors: the command's own; `busy` if another command is under way;
    /// `needs_init`; `faulted`; `bad_argument` for a node address that the device cannot have, a feedback period
    /// that is shorter than its frame and response, a drive that its bus refuses, or a plan with neither steps nor a
    /// refusal. Nothing is sent then.
    template <class Wanted> [[nodiscard]] constexpr errc begin(const Wanted& wanted) {
        prepared_command next = commands::prepared(wanted, valid_settings());
        return accept(next);
    }

    /// Moves on without waiting: the command under way, the feedback that is due, the checks of the
    /// supervisors. Returns a time during which no further step is needed unless a byte arrives.
    constexpr duration step() {
        const instant now = line_->now();
        check_link(now);
        supervise(now);
        if (flight_ == flight::none || is_waiting_to_send()) {
            const flight next = wanted(now);
            if (flight_ != next) {
                const bool has_waited = flight_ != flight::none;
                if (has_waited) line_->abandon(exchange_);
                flight_ = next;
                if (next == flight::none) return milliseconds(1);
                const std::uint16_t ticket = has_waited ? exchange_.ticket() : std::uint16_t{0};
                send();
                exchange_.set_ticket(ticket); // it keeps its place in the queue
            } else if (next == flight::none) {
                return milliseconds(1);
            }
        }
        const duration idle = line_->step(exchange_, gaps_);
        if (!exchange_.done()) return idle;
        conclude();
        return {};
    }

    /// After `limit` without a motion command or a blocking call a motion without an end is stopped. A speed, torque or
    /// jog that awaits its response counts until it ends: a program that hangs after `begin` is stopped at the latest
    /// `limit` and `longest_setpoint()` later. A stop that is not confirmed is repeated as often, unless `repeat_stops`
    /// has set another period.
    constexpr void set_command_timeout(command_timeout limit) {
        supervisors_.set_limit(limit.limit(), line_->now());
    }
    /// `step` repeats a stop that was not confirmed, `every` so often, until it is, or until a command that
    /// succeeds replaces it. 0: it does not. The default is the command timeout.
    constexpr void repeat_stops(duration every) { supervisors_.repeat_stops(every); }

    /// How long a speed or torque takes at most that gets no response and is read back, each frame at its bound.
    constexpr duration longest_setpoint() const {
        const duration lost = line_->bound(longest_write, 8, limits_, gaps_);
        return lost + line_->bound(8, 5 + 2 * steps::longest, limits_, gaps_) * 2;
    }
    /// True if one lost response takes longer than the command timeout. The drive is not stopped for that (G40), but a
    /// program that waits for the end of each command may command less often than its command timeout asks.
    constexpr bool is_command_timeout_short() const {
        const modbus::rtu_timing& timing = line_->timing();
        const duration frames = timing.wire_time(longest_write + 2 * (8 + 5 + 2 * steps::longest));
        const duration quarantine = longer_of(timing.visible_gap(), gaps_.quarantine);
        return supervisors_.is_shorter_than(limits_.response + quarantine + frames);
    }

    constexpr std::uint8_t address() const { return address_; }
    constexpr Line& line() const { return *line_; }

  protected:
    template <class Node>
    constexpr facade(Line& on, const Node& at, duration feedback, command_timeout limit)
        : address_{at.is_valid() ? at.address : std::uint8_t{0}}, read_retries_{at.read_retries}, line_{&on},
          link_{watchdog_of<Model>(Model::unknown)}, polling_{feedback},
          supervisors_{limit.limit()}, limits_{at.limits}, gaps_{at.gaps} {}
    ~facade() = default;

    constexpr const std::uint16_t* image() const { return polling_.image().words; }
    /// Errors of feedback that may be at most so old: `needs_init` where nothing is known of the drive, `busy` while a
    /// command changes settings, `timeout` if it is older or none was read since.
    constexpr errc check_feedback(duration oldest) const {
        if (!is_known()) return errc::needs_init;
        // It may change what values mean, or be that of a drive that has restarted.
        if (!is_idle() && (kind_ == command_kind::setting || kind_ == command_kind::take_over))
            return errc::busy;
        const auto& read = polling_.image();
        const bool is_young = !read.is_old && since(read.taken, line_->now()) <= oldest;
        return read.has_words && is_young ? errc::ok : errc::timeout;
    }
    /// What the last routine fetched.
    constexpr slice<const std::uint16_t> words() const { return run_.words(); }
    /// From the start of the last motion to the image; zero for an image that is older. It goes back from two minutes
    /// to one: times are not compared over a wrap of the clock.
    constexpr duration since_start() const {
        return is_image_of_motion_ ? until_image(moved_at_) : duration{};
    }
    /// A move that seems to be under way has been cut by a fault: its stop may be under way.
    constexpr bool is_ended_by_fault(arrival_state how) const {
        return how == arrival_state::under_way && cause_ == stop_cause::fault;
    }
    /// The settings are those of the drive as it is now: no request without a response since the last check.
    constexpr bool is_verified() const { return is_known() && link_.is_verified(line_->epoch(address_)); }
    constexpr const prepared_command& current() const { return command_; }
    constexpr bool is_faulted() const {
        return polling_.image().has_words && Model::is_faulted(image(), settings_);
    }
    /// The blocks of the feedback that are read less often.
    constexpr const slower_blocks<Model>& slower() const { return polling_.slower(); }

    Model model_{};

  private:
    friend struct scheduling;
    using polls = detail::polling<Model>;

    constexpr bool has_stop_to_send() const {
        return !is_idle() && run_.is_urgent() && (flight_ == flight::none || is_waiting_to_send());
    }
    // The request for the feedback and its response take longer on the wire than the period.
    constexpr bool is_period_too_short() const {
        const duration every = polling_.period();
        return polling_.is_on() && every != default_feedback &&
               every < line_->timing().wire_time(13 + 2 * Model::image.words);
    }
    // The cached settings, if they are still valid now.
    constexpr const settings& valid_settings() {
        check_link(line_->now());
        if (link_.is_expired()) invalidate();
        return settings_;
    }
    constexpr errc accept(prepared_command& next) {
        const bool is_refused = is_refused_ && next.stop == stop_priority::no_stop;
        if (address_ == 0 || is_refused || is_period_too_short()) return errc::bad_argument;
        if (next.refusal != errc::ok)
            return next.refusal == errc::wrong_state && is_faulted() ? errc::faulted : next.refusal;
        if (next.steps.empty()) return errc::bad_argument; // `no_steps` without a reason
        if (!is_idle()) {
            if (!replaces(next)) return is_stopped_for_fault(next) ? errc::faulted : errc::busy;
            if (leaves_unknown()) {
                invalidate();
                // The frames of a stop follow from what is known.
                if (next.stop != stop_priority::no_stop) next = Model::stop_for(next.stop, settings_, false);
            }
        }
        return take(next);
    }
    static constexpr command_kind kind_of(const prepared_command& c) { return Model::kinds[c.then]; }
    // A fault's stop is under way: what would move the drive, or waits for a move, is refused for the fault.
    constexpr bool is_stopped_for_fault(const prepared_command& next) const {
        return owner_ == owner::supervisor && cause_ == stop_cause::fault &&
               kind_of(next) != command_kind::refresh;
    }
    // Whether a command replaces the routine under way: a stop of a higher priority, and a take-over, which begins
    // with every kind of stop, one of a supervisor.
    constexpr bool replaces(const prepared_command& next) const {
        if (next.stop == stop_priority::no_stop)
            return owner_ == owner::supervisor && kind_of(next) == command_kind::take_over;
        if constexpr (requires { Model::disable_replaces_quick_stop; }) {
            if (Model::disable_replaces_quick_stop && next.stop == stop_priority::disable &&
                command_.stop == stop_priority::quick_stop)
                return true;
        }
        return owner_ == owner::supervisor ? next.stop >= command_.stop : next.stop > command_.stop;
    }
    constexpr errc take(prepared_command& next) {
        if constexpr (requires { model_.admit(next, limits_, gaps_); }) {
            if (const errc refusal = model_.admit(next, limits_, gaps_); refusal != errc::ok) return refusal;
        }
        std::uint8_t urgent = next.stop != stop_priority::no_stop ? steps::urgent_frames : std::uint8_t{0};
        if (next.stop == stop_priority::no_stop && is_stopping()) {
            // A supervisor's stop: the take-over is as urgent, and if it fails the stop is repeated.
            const bool was_sent = run_.has_written() || (flight_ == flight::step && exchange_.was_sent());
            urgent = run_.urgent_left();
            supervisors_.open_stop(command_.stop, urgent, was_sent, line_->now());
        }
        stop_tries_ = 0;
        ++number_;
        start(next, owner::application, urgent);
        if (kind_ == command_kind::endless_motion) supervisors_.watch(line_->now());
        if (kind_ == command_kind::move) supervisors_.end_watch();
        return errc::ok;
    }
    // `last` says why a command was refused, unless that of the command under way is due.
    constexpr errc note_refusal(errc refusal) {
        if (refusal != errc::ok && is_idle()) report_ = routine_status{refusal};
        return refusal;
    }
    // One copy for all commands.
    routine_status run_planned(prepared_command& next) {
        if (const errc refusal = note_refusal(accept(next)); refusal != errc::ok)
            return routine_status{refusal};
        const std::uint8_t mine = number_;
        auto guard = line_->new_stall_detector();
        while (!is_idle()) {
            supervisors_.note_command(line_->now());
            const duration idle = step();
            if (guard.has_failed(line_->now())) {
                give_up(errc::clock_stopped);
                break;
            }
            line_->sleep(idle);
        }
        return number_ == mine ? report_ : routine_status{status::sent(errc::preempted)};
    }

    // --- What is known of the drive

    constexpr void invalidate() {
        settings_ = Model::unknown;
        polling_.drop();
        held_.drop();
    }
    constexpr bool is_known() const { return settings_.state != Model::unknown.state; }
    constexpr bool is_enabled() const { return settings_.state == Model::enabled; }
    // Whether the command under way may have changed a setting already. A stop confirms the state in which it
    // leaves the drive.
    constexpr bool leaves_unknown() const {
        const bool is_writing =
            flight_ == flight::step && modbus::is_write(frame_[1]) && exchange_.was_sent();
        return changes_settings() && (run_.has_written() || is_writing);
    }
    constexpr bool changes_settings() const {
        if (command_.stop != stop_priority::no_stop) return false;
        return kind_ == command_kind::setting || kind_ == command_kind::power ||
               kind_ == command_kind::take_over;
    }
    // A lost port makes the settings invalid, and so does the drive's watchdog when its time has passed. A request
    // without a response makes the witness due.
    constexpr void check_link(instant now) {
        if (link_.take_loss(line_->epoch(address_))) {
            if (!is_stopping()) give_up(errc::port_lost);
            invalidate();
        }
        if (!link_.is_expired()) {
            if (!link_.is_overdue(now)) return;
            link_.expire();
            invalidate();
        }
        // Also in the middle of a frame: with its response the command would go on, although nothing is known.
        if (is_idle() || is_stopping() || run_.is_at_stop()) return;
        give_up(errc::needs_init);
    }
    // The witness: what a restart would change.
    constexpr steps::recheck witness() const { return model_.witness(settings_, command_); }
    constexpr bool has_witness() const { return witness().look != nullptr; }
    constexpr bool is_witness_due(instant now) const {
        return is_known() && has_witness() && link_.is_check_due(line_->epoch(address_), now);
    }

    // From `from`, a moment ago, to the image.
    constexpr duration until_image(instant from) const {
        const instant taken = polling_.image().taken;
        return went_back(from, taken) ? duration{} : since(from, taken);
    }
    constexpr void note_motion(instant now) {
        moved_at_ = now;
        is_image_of_motion_ = false;
    }
    constexpr void keep_motion_recent(instant now) {
        if (since(moved_at_, now) > long_ago + long_ago) moved_at_ = instant{now.us - long_ago.us};
    }

    // --- Which frame is next: decided here alone, anew in each step until its first byte leaves

    constexpr flight wanted(instant now) const {
        if (is_idle()) {
            if (link_.is_expired()) return flight::none;
            if (is_refresh_due(now)) return is_witness_due(now) ? flight::witness : flight::refresh;
            return link_.is_check_required() && is_witness_due(now) ? flight::witness : flight::none;
        }
        if (run_.is_at_stop()) return flight::step;
        if (run_.is_read_back_due()) return flight::step; // before the witness
        if (run_.awaits_witness() || is_witness_due(now)) return flight::witness;
        const bool is_too_early =
            run_.is_waiting() && polling_.waited_too_little(now) && !is_refresh_due(now);
        if (run_.reads(Model::image))
            return is_too_early && !polling_.is_slower_due() ? flight::none : flight::refresh;
        // A command's write is the frame after the read on which it relies: nothing may happen between.
        const bool relies_on_it = (previous_ == flight::step_read || previous_ == flight::witness) &&
                                  run_.current().what == step_type::kind::write;
        if (is_refresh_due(now) && previous_ != flight::refresh && !relies_on_it) return flight::refresh;
        if constexpr (polls::has_slower) {
            if (polling_.is_slower_for(run_))
                return polling_.is_early_for(run_, now) ? flight::none : flight::refresh;
        }
        return is_too_early ? flight::none : flight::step;
    }
    constexpr bool is_refresh_due(instant now) const {
        return is_known() && polling_.is_due(now, is_enabled(), link_.watchdog());
    }
    constexpr bool is_waiting_to_send() const {
        return flight_ != flight::none && exchange_.state() == Line::exchange::phase::ready;
    }

    constexpr void send() {
        frame_[0] = address_;
        const byte_buffer pdu = byte_buffer{frame_}.subspan(1);
        std::size_t size = 5;
        register_block block = Model::image;
        if (flight_ == flight::step) {
            size = run_.put_request(pdu);
            block.words = run_.current().count;
        } else {
            if (flight_ == flight::witness) {
                link_.begin_check(line_->epoch(address_));
                if (const step_type* look = witness().look; look != nullptr)
                    block = {look->address, look->count};
            } else {
                block = polling_.choose(run_,
                                        previous_ != flight::refresh && polling_.is_image_due(line_->now()));
            }
            constexpr auto read = modbus::function::read_holding_registers;
            modbus::put_trusted_request(pdu, read, block.address, block.words);
        }
        // The frame is the facade's own and needs no check.
        const std::size_t response = modbus::is_write(frame_[1]) ? 8u : 5u + 2u * block.words;
        const bytes request = modbus::close_trusted<typename Line::crc>(frame_, size);
        std::size_t at = held_.size(); // a reading that is held back stays where it is
        if (at + response > sizeof response_) {
            held_.drop();
            at = 0;
        }
        const priority how = flight_ == flight::step && run_.is_urgent() ? priority::stop : priority_;
        exchange_ = Line::exchange::trusted(request, byte_buffer{response_ + at, response}, line_->timing(),
                                            limits_, how);
    }

    // --- What a frame's end means

    constexpr void conclude() {
        const status got = exchange_.status();
        const instant now = line_->now();
        const flight was = flight_;
        flight_ = flight::none;
        previous_ = was;
        if (got.has_response())
            link_.note_response(line_->began_at(), now);
        else if (exchange_.was_sent())
            link_.note_miss();
        if (got.has_response() || was == flight::refresh || was == flight::witness)
            polling_.absence().count(got.has_response());
        switch (was) {
        case flight::step:
            run_.conclude(exchange_, limits_, read_retries_, now);
            if (run_.is_waiting() && !held_.is_any()) polling_.note_wait(now);
            if (!modbus::is_write(frame_[1]))
                previous_ = flight::step_read;
            else if (got.error() == errc::ok && is_motion(kind_))
                note_motion(now); // the last write is the start
            break;
        case flight::refresh: conclude_refresh(got, now); break;
        case flight::witness: conclude_witness(got, now); break;
        case flight::drained_write:
            if (!got.has_response()) invalidate();
            break;
        case flight::drained:
        case flight::step_read:
        case flight::none: break;
        }
        if (is_idle()) return;
        if (!run_.is_over()) {
            if (run_.is_urgent()) line_->announce_stop(); // also after a frame that could not be sent
            return;
        }
        settle();
        // What a stop, or a command that changes settings, has read counts when that has ended.
        if (previous_ == flight::refresh && polling_.image().has_words) react(judged(image()));
    }
    constexpr void conclude_refresh(const status& got, instant now) {
        if constexpr (polls::has_slower) {
            if (polling_.slower().is_in_flight()) return conclude_slower(got, now);
        }
        if (got.error() != errc::ok) {
            held_.drop();
            polling_.postpone(now);
            if (run_.reads(Model::image)) run_.fail_read(got, limits_, read_retries_);
            return;
        }
        polling_.note_reading(line_->began_at());
        conclude_reading(exchange_.words(), false, now);
    }
    // An image has come, or is no longer held back: `is_verified`, since the witness was read after it.
    constexpr void conclude_reading(words_view read, bool is_verified, instant now) {
        std::uint16_t words[Model::image.words]; // NOLINT: all are filled
        for (std::size_t i = 0; i < Model::image.words; ++i) words[i] = read[i];
        const bool is_fall = !is_verified && has_fallen(words);
        verdict found = judged(words);
        if (is_fall && found != verdict::disabled) found = verdict::uncertain;
        if (found == verdict::uncertain) {
            if (!is_verified && may_ask_witness()) {
                held_.hold_image(response_, exchange_.response());
                return link_.require_check();
            }
            if (is_verified || is_fall) found = verdict::as_expected; // a restart shows nowhere else
        }
        polling_.take(words);
        is_image_of_motion_ = true;
        is_origin_new_ = is_origin_new_ && !is_idle() && sets_origin(command_);
        keep_motion_recent(now);
        previous_ = flight::refresh;
        react(found);
        take_held_block();
        run_.use_image(image(), Model::image, now);
        if (run_.asks_model()) ask_model(now);
    }
    // A take-over finds out anew what the drive is.
    constexpr bool may_ask_witness() const {
        return is_known() && has_witness() && (is_idle() || kind_ != command_kind::take_over);
    }
    // A position that is nearer to zero than speed and time allow: a restart puts it to zero.
    constexpr bool has_fallen(const std::uint16_t* words) const {
        if constexpr (requires { Model::is_fall(words, words, duration{}, settings_); }) {
            const auto& before = polling_.image();
            return is_known() && before.has_words && !is_origin_new_ &&
                   Model::is_fall(before.words, words, since(before.taken, polling_.refreshed()), settings_);
        } else {
            return false;
        }
    }
    // The command changes where positions are counted from.
    static constexpr bool sets_origin(const prepared_command& c) {
        if constexpr (requires { Model::sets_origin(c); }) {
            return Model::sets_origin(c);
        } else {
            return false;
        }
    }
    constexpr void conclude_slower(const status& got, instant now) {
        auto& slower = polling_.slower();
        const std::uint8_t block = slower.block();
        const bool is_read_by_step = slower.block_for(run_) == block;
        slower.land();
        if (is_read_by_step) previous_ = flight::step_read;
        if (got.error() != errc::ok) {
            if (is_read_by_step) run_.fail_read(got, limits_, read_retries_);
            return;
        }
        std::uint16_t words[steps::longest]; // NOLINT: as many as the block has are filled
        for (std::size_t i = 0; i < Model::slower[block].words; ++i) words[i] = exchange_.words()[i];
        if (!holds_block(block, words)) slower.take(block, words, line_->began_at());
        run_.use_image(words, Model::slower[block], now);
    }
    // A position of an enabled drive counts once the image after it shows that the drive is still enabled. One of
    // another drive counts immediately, unless it has fallen: then the witness is read first.
    constexpr bool holds_block(std::uint8_t block, const std::uint16_t* words) {
        if constexpr (requires { Model::positions; }) {
            auto& slower = polling_.slower();
            if (block != Model::positions || !is_known()) return false;
            if (!is_enabled()) {
                const bool has_fallen = !is_origin_new_ && slower.has_words(block) &&
                                        Model::is_fall(slower.words(block), words, settings_);
                if (!has_fallen || !may_ask_witness()) return false;
                link_.require_check();
            }
            held_.hold_block(response_, exchange_.response());
            slower.note_held(line_->began_at());
            return true;
        } else {
            return false;
        }
    }
    // The block that was held back counts from now on.
    constexpr void take_held_block() {
        if constexpr (requires { Model::positions; }) {
            if (!held_.is_block()) return;
            auto& slower = polling_.slower();
            std::uint16_t words[steps::longest]; // NOLINT
            for (std::size_t i = 0; i < Model::slower[Model::positions].words; ++i)
                words[i] = held_.words(response_)[i];
            slower.take(Model::positions, words, slower.held_at());
            held_.drop();
        }
    }
    constexpr void ask_model(instant now) {
        if constexpr (requires { model_.permit(command_, image(), settings_); }) {
            if (run_.is_at_permit()) {
                const errc found = model_.permit(command_, image(), settings_);
                if (command_.steps.empty()) return run_.finish(); // nothing is left to do
                return run_.conclude_question(found, now);
            }
        }
        if constexpr (requires { model_.permit(command_, run_.words(), settings_); }) {
            if (run_.is_at_permit())
                return run_.conclude_question(model_.permit(command_, run_.words(), settings_), now);
        }
        // A motion counts from its start, which may have been another command's.
        const duration waited = kind_ == command_kind::power ? until_image(run_.entered()) : since_start();
        run_.conclude_question(model_.confirm(command_, image(), waited, settings_), now);
    }
    constexpr void conclude_witness(const status& got, instant now) {
        link_.end_check();
        if (got.error() != errc::ok) {
            held_.drop();
            polling_.postpone(now); // a drive that does not respond is not read in every step
            if (!is_idle()) run_.fail_read(got, limits_, read_retries_);
            return;
        }
        if (!is_known()) { // invalidated meanwhile
            if (run_.awaits_witness()) run_.end(errc::needs_init, false);
            return;
        }
        const steps::recheck w = witness();
        bool is_same = true; // also for a drive that has none in its state
        std::size_t i = w.look != nullptr ? w.look->count : 0;
        while (i-- != 0) is_same = is_same && exchange_.words()[i] == w.words[i];
        if (is_same) {
            link_.verify(now);
            take_held_block();
            if (held_.is_image()) {
                const words_view words = held_.words(response_);
                held_.drop();
                conclude_reading(words, true, now);
            }
            if (!is_idle()) run_.conclude_witness(now);
            return;
        }
        note_restart();
        if constexpr (stops_after_restart) return stop_because(errc::needs_init, false);
        if (!is_idle() && !is_stopping()) run_.end(errc::needs_init, false);
    }
    // The motor has no power any more, or stands: nothing is left for a command timeout to stop.
    constexpr void note_restart() {
        invalidate();
        supervisors_.end_watch();
        note_cause(stop_cause::restart);
    }
    // What an image says of a drive whose settings are known, while no command changes that.
    constexpr verdict judged(const std::uint16_t* words) {
        const bool is_changing = is_stopping() || (!is_idle() && changes_settings());
        return is_known() && !is_changing ? model_.judge(words, settings_) : verdict::as_expected;
    }
    constexpr void react(verdict found) {
        switch (found) {
        case verdict::as_expected: break;
        case verdict::uncertain: link_.require_check(); break;
        case verdict::held: note_cause(stop_cause::input); break;
        case verdict::disabled:
            note_restart();
            if constexpr (stops_after_restart) {
                stop_because(errc::needs_init, true);
            } else {
                end_unless_reading(errc::needs_init);
            }
            break;
        case verdict::tripped:
            cause_ = stop_cause::fault;
            end_unless_reading(errc::faulted);
            break;
        case verdict::faulted:
            if (cause_ == stop_cause::fault) break; // it was stopped for that
            cause_ = stop_cause::fault;
            stop_because(errc::faulted, true);
        }
    }
    constexpr void end_unless_reading(errc why) {
        if (!is_idle() && kind_ != command_kind::refresh) run_.end(why, false);
    }
    // Ends the command under way and stops all of the drive, for a fault of one motor too. `may_read`: a command
    // that reads the feedback has already succeeded.
    constexpr void stop_because(errc why, bool may_read) {
        const bool is_read = may_read && !is_idle() && kind_ == command_kind::refresh;
        if (is_read) {
            report_ = {};
        } else if (!is_idle() && command_.stop < Model::stop_at_fault) {
            run_.end(why, false);
            settle();
        }
        if (is_stopping()) return;
        start(Model::stop_for(Model::stop_at_fault, settings_, false),
              is_read ? owner::follow_up : owner::supervisor, steps::urgent_frames);
    }
    constexpr void note_cause(stop_cause c) {
        if (cause_ == stop_cause::unknown) cause_ = c;
    }

    // --- The routine under way

    [[gnu::noinline]] constexpr void start(const prepared_command& next, owner by, std::uint8_t urgent) {
        if (!is_idle() && kind_ >= command_kind::endless_motion && run_.has_written())
            model_.preempt(command_);
        command_ = next;
        is_origin_new_ = is_origin_new_ || sets_origin(command_);
        start(by, urgent);
    }
    // Starts `command_`.
    constexpr void start(owner by, std::uint8_t urgent) {
        if (is_waiting_to_send()) {
            line_->abandon(exchange_);
            flight_ = flight::none;
        } else if (flight_ == flight::step) {
            const bool is_trigger = modbus::is_write(frame_[1]) && !run_.is_at_stop();
            flight_ = is_trigger ? flight::drained_write : flight::drained;
        }
        std::uint16_t shift = 0;
        if constexpr (requires { command_.shift; }) shift = command_.shift;
        owner_ = by;
        kind_ = kind_of(command_);
        run_.begin(command_.steps, command_.arguments, shift, command_.limit, urgent, by == owner::follow_up,
                   line_->now());
        if (run_.is_urgent()) line_->announce_stop(); // whatever is stepped first
    }
    constexpr bool is_stopping() const { return !is_idle() && command_.stop != stop_priority::no_stop; }
    constexpr void give_up(errc why) {
        if (is_idle()) return;
        bool was_written = false;
        if (flight_ != flight::none) {
            line_->abandon(exchange_);
            was_written = flight_ == flight::step && modbus::is_write(frame_[1]) && exchange_.was_sent();
            flight_ = flight::none;
        }
        run_.end(why, was_written);
        settle();
    }

    constexpr void settle() {
        if (!line_->is_echo_ruled_out()) run_.note_possible_echo();
        const routine_status& r = run_.result();
        const owner by = owner_;
        if (is_setpoint_of_application()) supervisors_.note_command(line_->now());
        // A stop that does not read back was acknowledged by a late response to another write: once more.
        if (by != owner::follow_up && is_stopping() && r.error() == errc::unexpected_value &&
            ++stop_tries_ < tries_of_a_stop)
            return start(by, run_.urgent_left());
        if (by == owner::application || (by == owner::follow_up && !r && (is_stopping() || report_)))
            report_ = r;
        const bool was_stop = is_stopping();
        if (was_stop) note_stop(r);
        if constexpr (requires { Model::positions; }) {
            if (sets_origin(command_)) {
                polling_.slower().forget(Model::positions);
                held_.drop();
            }
        }
        owner_ = owner::none;
        const command_kind kind = kind_;
        const routine done = command_.steps;
        const bool is_judged = !r && done[r.step].what == step_type::kind::confirm;
        command_.steps = no_steps; // the model puts in what follows
        if (r) {
            conclude_command(kind);
        } else {
            if constexpr (requires {
                              model_.fail(command_, done, r, link_.is_expired(), settings_, link_.watchdog());
                          })
                model_.fail(command_, done, r, link_.is_expired(), settings_, link_.watchdog());
            if (is_in_doubt(r, is_judged)) invalidate();
            // A stop that goes on by other means ends as those do.
            const bool goes_on = !command_.steps.empty() && command_.stop != stop_priority::no_stop;
            if (was_stop && goes_on && by == owner::application) report_ = {};
        }
        // A stop that goes on keeps the urgent frames that it has left.
        if (!command_.steps.empty())
            start(owner::follow_up, was_stop ? run_.urgent_left() : steps::urgent_frames);
    }
    // The command is done.
    constexpr void conclude_command(command_kind kind) {
        if (kind >= command_kind::endless_motion) supervisors_.close_stop();
        if (is_motion(kind)) {
            note_motion(line_->now());
            cause_ = stop_cause::unknown;
        }
        const bool is_stop = command_.stop != stop_priority::no_stop;
        if (const errc found = model_.learn(command_, run_.words(), settings_); found != errc::ok)
            report_ = {status{found}.with_sent(run_.has_written()), 0, run_.has_written()};
        if (is_known()) link_.watchdog() = watchdog_of<Model>(settings_);
        if (kind == command_kind::setting || kind == command_kind::take_over) {
            held_.drop();
            polling_.drop(true);
        }
        if (kind == command_kind::take_over) supervisors_.end_watch(); // it begins with a stop
        if constexpr (requires { model_.grant(limits_); }) model_.grant(limits_);
        if (kind != command_kind::power && kind != command_kind::take_over) return;
        link_.verify(line_->epoch(address_), line_->now());
        if (is_enabled() && !is_stop) {
            run_.note_zero_targets();
            supervisors_.end_watch(); // until it is commanded to move
            if constexpr (requires { Model::moves_when_enabled(settings_); }) {
                if (Model::moves_when_enabled(settings_)) supervisors_.watch(line_->now());
            }
            cause_ = stop_cause::unknown;
        }
    }
    static constexpr bool is_motion(command_kind k) {
        return k == command_kind::endless_motion || k == command_kind::move;
    }
    constexpr void note_stop(const routine_status& r) {
        if (r && command_.stop >= stop_priority::disable) supervisors_.end_watch();
        note_cause(stop_cause::command);
        const stop_priority open = supervisors_.open_stop();
        if (r)
            supervisors_.close_stop();
        else
            supervisors_.open_stop(command_.stop < open ? open : command_.stop, run_.urgent_left(),
                                   r.outcome() != outcome::not_sent, line_->now());
    }
    // Errors of the transport or of a response: the drive's state is not known any more. `is_judged`: the
    // model says so, by the image.
    static constexpr bool is_in_doubt(const routine_status& r, bool is_judged) {
        if (r.error() == errc::faulted || r.error() == errc::not_executed) return false;
        if (r.error() == errc::exception) return r.has_changed;
        const bool is_transport = r.error() >= errc::line_busy && r.error() <= errc::bad_gap;
        return is_transport || r.error() == errc::needs_init ||
               (r.outcome() == outcome::unknown && !is_judged);
    }

    // --- Supervisors: a stop that was not confirmed, an application that has stopped commanding

    constexpr bool is_setpoint_of_application() const {
        return owner_ == owner::application && kind_ == command_kind::endless_motion;
    }
    constexpr void supervise(instant now) {
        polling_.note_age(now);
        if (supervisors_.is_stop_due(now) && is_idle()) {
            stop_tries_ = 0;
            start(Model::stop_for(supervisors_.open_stop(), settings_, link_.is_expired()), owner::supervisor,
                  supervisors_.urgent_left());
        }
        if (!supervisors_.has_run_out(now) || is_stopping()) return;
        // A setpoint that awaits its response shows that the program is alive: the time begins again at its end.
        if (is_setpoint_of_application()) return;
        if (!is_idle() && kind_ == command_kind::take_over) return; // it begins with a stop
        supervisors_.end_watch();
        stop_tries_ = 0;
        if (!is_idle()) {
            ++number_;
            report_ = routine_status{status::sent(errc::command_timeout)};
            if (leaves_unknown()) invalidate();
        }
        // While another stop is repeated, this one is no more urgent than it.
        const std::uint8_t urgent =
            supervisors_.is_stop_open() ? supervisors_.urgent_left() : steps::urgent_frames;
        start(Model::stop_for(stop_priority::halt, settings_, link_.is_expired()), owner::supervisor, urgent);
    }

    // A drive that may be energised after a restart is stopped when one is found.
    static constexpr bool stops_after_restart = [] {
        if constexpr (requires { Model::stops_after_restart; }) {
            return Model::stops_after_restart;
        } else {
            return false;
        }
    }();
    static_assert(Model::kinds.is_complete(),
                  "an effect has no kind: each is listed in the `kinds` of the model");
    static_assert(detail::optional_functions<Model>::admit(),
                  "`admit` of the model has another form than device/README.md");
    static_assert(detail::optional_functions<Model>::fail(),
                  "`fail` of the model has another form than device/README.md");
    static_assert(detail::optional_functions<Model>::permit(),
                  "`permit` of the model has another form than device/README.md");
    static_assert(detail::optional_functions<Model>::watchdog(),
                  "`watchdog` of the model has another form than device/README.md");
    static_assert(Model::image.words != 0, "the feedback of a model is at least one register");
    static_assert(Model::image.words <= steps::longest, "the feedback of a model is at most 11 registers");
    static constexpr std::uint8_t tries_of_a_stop = 3;
    static constexpr std::size_t longest_write = 9 + 2 * steps::max_arguments; // bytes
    static constexpr duration long_ago = milliseconds(60'000);
    using step_type = servobus::step;

    // The bytes first, then the words: short instructions of a small core reach no further.
    owner owner_ = owner::none;
    command_kind kind_ = command_kind::other; // of the command under way
    flight flight_ = flight::none;
    flight previous_ = flight::none;
    stop_cause cause_ = stop_cause::unknown;
    std::uint8_t address_; // 0: no valid one
    std::uint8_t read_retries_;
    std::uint8_t number_ = 0; // of the application's command
    std::uint8_t stop_tries_ = 0;
    bool is_refused_ : 1 = false;         // its bus has another drive in its place
    bool is_image_of_motion_ : 1 = false; // the image was read after the last motion command
    bool is_origin_new_ : 1 = false;      // positions may be counted from elsewhere since the image
    detail::held_reading held_{};         // at the beginning of `response_`
    settings settings_ = Model::unknown;
    prepared_command command_{.steps = no_steps};
    Line* line_;
    detail::drive_link<polls::has_watchdog> link_;
    polls polling_;
    detail::supervisors supervisors_;
    instant moved_at_{}; // when the last motion command ended
    routine_status report_{};
    response_limits limits_;
    bus_gaps gaps_;
    priority priority_ = priority::ordinary; // of all requests but stops
    typename Line::exchange exchange_{};
    detail::routine_run run_{};
    std::uint8_t frame_[24]{};
    std::uint8_t response_[detail::held_reading::room(Model::image.words)]{};
};

} // namespace servobus
