// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The machine of a drive: a state machine that chooses the drive's next frame and concludes what its end means. It is
// given the time, waits for nothing and touches no hardware. A facade moves its frames over a line; a test does so by
// hand, here on a line that answers at once. control/README.md draws it.
//
//     template <class Machine, class Line> void turn(Machine& drive, Line& on, instant now) {
//         if (drive.pass(now, on)) drive.notify(on);
//         drive.load(drive.next(now, on), now, on);
//         if (drive.purpose() != flight::none) on.answer(drive.exchange()), drive.conclude(now, now, false);
//     }
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/control/detail/command_life.hpp>
#include <servobus/control/detail/next_frame.hpp>
#include <servobus/control/states.hpp>
#include <servobus/core/bytes.hpp>
#include <servobus/modbus/pdu.hpp>
#include <servobus/modbus/rtu.hpp>

namespace servobus {

/// The machine of a drive that `Model` describes (device/README.md). `Exchange` is its line's. A `Line` gives the epoch
/// of a node, the node that was changed last, and the timing, gives an exchange up (`abandon`) and keeps itself free
/// (`announce_stop`).
template <class Model, class Exchange> class drive_machine : public detail::command_life<Model, Exchange> {
    using base = detail::command_life<Model, Exchange>;
    using base::exchange_, base::frame_, base::known_, base::slot_;
    using step_type = servobus::step;
    using polls = detail::polling<Model>;

  public:
    template <class Node>
    constexpr drive_machine(const Node& at, duration feedback, command_timeout limit)
        : base{at, feedback, limit} {}
    // The exchange refers to this object's buffers.
    drive_machine(const drive_machine&) = delete;
    drive_machine& operator=(const drive_machine&) = delete;

    // --- Its frame

    /// The purpose of the frame that waits for the line or is on it.
    constexpr flight purpose() const { return frame_.purpose(); }
    constexpr Exchange& exchange() { return exchange_; }
    /// True from the frame's first byte until `conclude`.
    constexpr bool is_on_the_wire() const { return frame_.is_on_the_wire(exchange_); }
    /// True while a stop that goes before all other traffic waits to be sent.
    constexpr bool wants_stop() const { return is_urgent() && !frame_.is_on_the_wire(exchange_); }
    /// True if the line is to keep itself free for a stop, which is the next frame.
    constexpr bool announces_stop() const { return is_urgent() && purpose() != flight::step; }
    /// Makes the line follow a command that has begun or ended: gives up a dropped frame, announces a stop.
    template <class Line> constexpr void notify(Line& on) {
        if (frame_.is_dropped(exchange_)) on.abandon(exchange_);
        if (announces_stop()) on.announce_stop();
    }
    /// The waiting frame's place in the line's queue: a lower one has waited longer. 0: no frame waits.
    constexpr std::uint16_t ticket() const {
        return frame_.is_waiting(exchange_) ? exchange_.ticket() : std::uint16_t{0};
    }
    /// The purpose of the frame to send, as long as none is on the wire.
    template <class Line> constexpr flight next(instant now, const Line& on) const {
        return detail::next_frame(known_, slot_, now, on);
    }
    /// Fills the exchange with the request for `what`. The exchange has ended, or waited and was abandoned.
    template <class Line> constexpr void load(flight what, instant now, const Line& on) {
        const bool has_waited = purpose() != flight::none;
        frame_.begin(what);
        if (what == flight::none) return;
        const std::uint16_t ticket = has_waited ? exchange_.ticket() : std::uint16_t{0};
        fill(now, on);
        exchange_.set_ticket(ticket); // it keeps its place in the queue
    }
    /// Concludes from an exchange that is done. `began`: when its first byte left. `is_echo_possible`: the response may
    /// be the request's echo.
    constexpr void conclude(instant now, instant began, bool is_echo_possible) {
        const status got = exchange_.status();
        const flight was = frame_.end();
        known_.set_last_frame(was);
        known_.note_frame(got.has_response(), exchange_.was_sent(),
                          was == flight::refresh || was == flight::witness, began, now);
        switch (was) {
        case flight::step:
            run().conclude(exchange_, this->limits_, this->read_retries_, now);
            if (run().is_waiting() && !known_.held().is_any()) known_.polling().note_wait(now);
            if constexpr (base::runs_without_line) note_sent_motion();
            if (!this->is_write())
                known_.set_last_frame(flight::step_read);
            else if (got.error() == errc::ok && detail::is_motion(slot_.kind()))
                known_.note_motion(now); // the last write is the start
            break;
        case flight::refresh: conclude_refresh(got, began, now); break;
        case flight::witness: conclude_witness(got, now); break;
        case flight::drained_write:
            if (!got.has_response()) known_.invalidate();
            this->unwatched_.note_sent(); // perhaps its routine moves
            break;
        case flight::drained:
        case flight::step_read:
        case flight::none: break;
        }
        if (slot_.is_idle() || !run().is_over()) return;
        if (is_echo_possible) run().note_possible_echo();
        this->settle(now);
        // The image that a stop or a change of settings has read is judged when that has ended.
        if (known_.last_frame() == flight::refresh && known_.polling().image().has_words)
            react(judged(known_.image()), now);
    }

  private:
    constexpr detail::routine_run& run() { return slot_.run(); }
    constexpr void note_sent_motion() {
        const bool is_motion = detail::is_motion(slot_.kind()) || Model::kinds.moves(slot_.command().then);
        if (is_motion && this->is_write() && exchange_.was_sent()) this->unwatched_.note_sent();
    }
    constexpr bool is_urgent() const { return slot_.run().is_urgent(); }

    template <class Line> [[gnu::noinline]] constexpr void fill(instant now, const Line& on) {
        known_.link().ask(on.epoch(this->address()));
        const byte_buffer pdu = byte_buffer{this->request_}.subspan(1);
        std::size_t size = 5;
        register_block block = image_block<Model>;
        if (purpose() == flight::step) {
            size = run().put_request(pdu);
            block.words = run().current().count;
        } else {
            if (purpose() == flight::witness) {
                if (const step_type* look = known_.witness(slot_.command()).look; look != nullptr)
                    block = {look->address, look->count};
            } else {
                const polls& polling = known_.polling();
                const bool is_image_first = known_.last_frame() != flight::refresh &&
                                            polling.is_image_due(now) && !polling.may_wait_for(slot_, now);
                block = known_.polling().choose(run(), is_image_first);
            }
            constexpr auto read = modbus::function::read_holding_registers;
            modbus::put_trusted_request(pdu, read, block.address, block.words);
        }
        // The machine's own frame needs no check.
        const std::size_t response = this->is_write() ? 8u : 5u + 2u * block.words;
        const bytes request = modbus::close_trusted<typename Exchange::crc>(this->request_, size);
        std::size_t at = known_.held().size(); // after feedback that is held back
        if (at + response > sizeof this->response_) {
            known_.held().drop();
            at = 0;
        }
        const priority how =
            purpose() == flight::step && run().is_urgent() ? priority::stop : this->priority_;
        exchange_ = Exchange::trusted(request, byte_buffer{this->response_ + at, response}, on.timing(),
                                      this->limits_, how);
    }

    // --- What a frame's end means

    constexpr void conclude_refresh(const status& got, instant began, instant now) {
        if constexpr (polls::has_slower) {
            if (known_.polling().slower().is_in_flight()) return conclude_slower(got, began, now);
        }
        if (got.error() != errc::ok) {
            known_.held().drop();
            known_.polling().postpone(now);
            if (run().reads(image_block<Model>)) run().fail_read(got, this->limits_, this->read_retries_);
            return;
        }
        known_.polling().note_refresh(began);
        conclude_image(exchange_.words(), false, now);
    }
    // Uses an image. `is_verified`: it was held back until the witness was read.
    constexpr void conclude_image(words_view read, bool is_verified, instant now) {
        std::uint16_t words[image_block<Model>.words]; // NOLINT: all are filled
        for (std::size_t i = 0; i < image_block<Model>.words; ++i) words[i] = read[i];
        const bool is_fall = !is_verified && known_.has_fallen(words);
        verdict found = judged(words);
        if (is_fall && found != verdict::disabled) found = verdict::uncertain;
        if (found == verdict::uncertain) {
            if (!is_verified && may_ask_witness()) {
                known_.held().hold_image(this->response_, exchange_.response());
                return known_.link().require_check();
            }
            if (is_fall) known_.note_origin();
            if (is_verified || is_fall) found = verdict::as_expected; // a restart shows nowhere else
        }
        known_.take_image(words, now);
        known_.set_last_frame(flight::refresh);
        react(found, now);
        known_.note_image(is_origin_open());
        known_.take_held_block(this->response_);
        run().use_image(known_.image(), image_block<Model>, now);
        if (run().asks_model()) ask_model(now);
    }
    // Positions may be counted from elsewhere after the next refresh too.
    constexpr bool is_origin_open() const { return slot_.is_setting_origin() || slot_.is_stopping(); }
    // During a take-over nothing raises a suspicion: positions count from a new origin, and an image is not judged
    // while settings change.
    constexpr bool may_ask_witness() const {
        if constexpr (polls::has_watchdog) // its witness takes little code
            return known_.is_known() && known_.witness(slot_.command()).look != nullptr;
        else
            return may_ask_other_witness();
    }
    [[gnu::noinline]] constexpr bool may_ask_other_witness() const {
        return known_.is_known() && known_.witness(slot_.command()).look != nullptr;
    }
    constexpr void conclude_slower(const status& got, instant began, instant now) {
        auto& slower = known_.polling().slower();
        const std::uint8_t block = slower.block();
        const bool is_read_by_step = slower.block_for(run()) == block;
        slower.land();
        if (is_read_by_step) known_.set_last_frame(flight::step_read);
        if (got.error() != errc::ok) {
            if (is_read_by_step) run().fail_read(got, this->limits_, this->read_retries_);
            return;
        }
        std::uint16_t words[steps::longest]; // NOLINT: as many as the block has are filled
        for (std::size_t i = 0; i < Model::blocks[block].words; ++i) words[i] = exchange_.words()[i];
        if (known_.withholds(block, words, began, may_ask_witness())) {
            known_.held().hold_block(this->response_, exchange_.response());
            slower.note_held(began);
        } else {
            known_.take_block(block, words, began);
        }
        run().use_image(words, Model::blocks[block], now);
    }
    constexpr void ask_model(instant now) {
        // A motion counts from its start, which may have been another command's.
        const duration waited =
            slot_.kind() == command_kind::power ? known_.until_image(run().entered()) : known_.since_start();
        const situation seen{.image = known_.image(), .words = run().words(), .waited = waited};
        auto& model = known_.model();
        errc found = errc::ok;
        if (run().current().what == step_type::kind::permit) {
            found = model.permit(slot_.command(), seen, known_.cached());
            if (slot_.command().steps.empty()) return run().finish(); // nothing is left to do
        } else {
            found = model.confirm(slot_.command(), seen, known_.cached());
        }
        run().conclude_question(found, now);
    }
    constexpr void conclude_witness(const status& got, instant now) {
        known_.link().end_check();
        if (got.error() != errc::ok) {
            known_.held().drop();
            known_.polling().postpone(now); // a drive that does not respond is not read in every step
            if (!slot_.is_idle()) run().fail_read(got, this->limits_, this->read_retries_);
            return;
        }
        if (!known_.is_known()) { // invalidated meanwhile
            if (run().awaits_witness()) run().end(errc::needs_init, false);
            return;
        }
        if (known_.is_same(exchange_.words(), slot_.command())) {
            known_.link().verify(now);
            known_.take_held_block(this->response_);
            if (known_.held().is_image()) {
                const words_view words = known_.held().words(this->response_);
                known_.held().drop();
                conclude_image(words, true, now);
            }
            if (!slot_.is_idle()) run().conclude_witness(now);
            return;
        }
        note_restart();
        if constexpr (Model::stops.after_restart) return this->stop_because(errc::needs_init, false, now);
        if (!slot_.is_idle() && !slot_.is_stopping()) run().end(errc::needs_init, false);
    }
    // Forgets the settings. The motor has no power any more, or stands: no command timeout is to stop it.
    [[gnu::noinline]] constexpr void note_restart() {
        known_.invalidate();
        slot_.supervisors().end_watch();
        known_.note_cause(stop_cause::restart);
    }
    // Judges an image of a drive whose settings are known, while no command changes them.
    constexpr verdict judged(const std::uint16_t* words) {
        return known_.is_known() && !slot_.is_changing() ? known_.model().judge(words, known_.cached())
                                                         : verdict::as_expected;
    }
    constexpr void react(verdict found, instant now) {
        switch (found) {
        case verdict::as_expected: break;
        case verdict::uncertain: known_.link().require_check(); break;
        case verdict::held:
            known_.note_cause(stop_cause::input);
            known_.link().require_check(); // a restart may look like that
            break;
        case verdict::disabled:
            note_restart();
            if constexpr (Model::stops.after_restart) {
                this->stop_because(errc::needs_init, true, now);
            } else {
                slot_.end_unless_reading(errc::needs_init);
            }
            break;
        case verdict::tripped:
            known_.set_cause(stop_cause::fault);
            slot_.end_unless_reading(errc::faulted);
            break;
        case verdict::faulted:
            if (known_.cause() == stop_cause::fault) break; // it was stopped for that
            known_.set_cause(stop_cause::fault);
            this->stop_because(errc::faulted, true, now);
        }
    }
};

} // namespace servobus
