// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The facade of a drive together with the simulated drive that it controls: the last command, the state
// that the simulated drive must then have, and which frames are stops and triggers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <utility>

#include <servobus/control/command_status.hpp>
#include <servobus/control/step.hpp>
#include <servobus/modbus/rtu.hpp>

#include "participant.hpp"
#include "world.hpp"

namespace trial {

using plain_line = line_on<servobus::unechoed>;

/// A command of the application.
struct errand {
    std::string name;
    bool is_init = false;
    bool is_stop = false;
    bool enables = false;                   ///< it may energise the motor once
    bool disables = false;                  ///< as a part of it, beside a stop
    bool moves = false;                     ///< it may begin a motion
    std::function<bool()> is_carried_out{}; ///< by the simulated drive; empty if it cannot be checked
    std::function<bool()> has_arrived{};    ///< of a wait for the end of a move: the motor is at its target
};

class facade {
  public:
    facade() = default;
    facade(const facade&) = delete;
    facade& operator=(const facade&) = delete;
    virtual ~facade() = default;

    virtual participant& place() = 0;
    /// Sets the drive up before the run, on a line without faults.
    virtual bool make_ready() { return true; }
    /// Begins any command, or a stop that is possible in any state.
    virtual servobus::errc begin_any(scene& on) = 0;
    virtual servobus::errc begin_stop(scene& on) = 0;
    /// Begins a move, a wait for its end, or what is needed before one.
    virtual servobus::errc begin_move_or_wait(scene& on) { return begin_any(on); }
    /// Begins a motion, or the next command that is needed before one.
    virtual servobus::errc begin_motion(scene& on) = 0;
    /// A stop that switches the power stage off, after which the drive must be at standstill.
    virtual servobus::errc begin_end() = 0;
    virtual servobus::duration step() = 0;
    virtual bool is_idle() const = 0;
    virtual servobus::command_status last() const = 0;
    virtual bool needs_init() const = 0;

    // The simulated drive
    virtual bool stands() = 0;
    virtual std::uint32_t starts() = 0;  ///< that the simulated drive carried out
    virtual std::uint32_t enables() = 0; ///< likewise
    /// Identifies the motion that the motor is commanded to do: a different number for each motion, 0 for
    /// none.
    virtual std::uint64_t motion() = 0;
    /// The drive's own watchdog has stopped it.
    virtual bool is_stopped_by_watchdog() { return false; }
    virtual bool has_watchdog() const { return false; }
    /// The facade reads what a restart changes after each request without a response.
    virtual bool has_witness() const { return has_watchdog(); }
    /// Each restart changes that: the next command finds it.
    virtual bool shows_restarts() const { return false; }
    /// The motion that the motor resumes if the stop by the watchdog ends.
    virtual std::uint64_t resumed_motion() { return motion(); }

    // What `truth_watch` compares
    virtual bool says_enabled() const = 0;
    virtual bool says_reached() const = 0;
    /// The motor has power, no fault and a free shaft, and no input keeps it stopped.
    virtual bool is_able() = 0;
    /// The feedback shows why it is not, by the interpretation of the manual.
    virtual bool shows_plight() { return true; }
    virtual bool shows_restart_while_enabled() const { return shows_restarts(); }
    /// Its level at an input enables the drive, at any time.
    virtual bool is_enabled_by_level() const { return false; }
    /// Targets set it going as soon as it is enabled.
    virtual bool has_targets() const { return true; }
    virtual bool has_goal() const = 0;
    virtual bool is_at_goal() = 0;
    virtual void note_start() = 0; ///< it begins to leave
    virtual void note_end(bool is_done) = 0;
    virtual bool is_feedback(servobus::bytes frame) const = 0;
    virtual bool is_enable(servobus::bytes frame) const = 0;
    virtual bool is_start(servobus::bytes frame) const = 0;
    virtual bool changes_mode(servobus::bytes) const { return false; }
    /// A fault or an input acts on the simulated drive, until it recovers.
    virtual void suffer(scene& on) = 0;
    virtual void recover() = 0;

    /// This frame stops the drive and may be repeated.
    virtual bool is_stop(servobus::bytes frame) const = 0;
    /// This frame starts something or changes the drive permanently.
    virtual bool is_trigger(servobus::bytes frame) const = 0;

    /// This frame sets a target that may be written again without harm, such as a speed. Without a response it is
    /// read back, and the drive needs no init if it did not receive it.
    virtual bool is_setpoint(servobus::bytes) const { return false; }

    /// The last command.
    const errand& wanted() const { return wanted_; }
    /// A commanded stop is not confirmed yet: the program has not received the response to a stop and, after it,
    /// one to a read at standstill.
    bool has_open_stop() const { return is_stop_open_; }
    /// The next frame of a stop may go before all others: at most three after a command of the application or a
    /// reading of the drive. The stops with which an `init` begins wait like any other frame.
    bool is_in_haste() const { return urgent_left_ != 0 && !is_taking_over_; }

    /// A frame begins to leave, after the quarantine of the line or before its end. True if it may go before all
    /// others. A stop that the application did not command uses up its priority only where it did not wait.
    bool sends_urgently(servobus::bytes frame, bool has_waited, std::uint64_t now) {
        // An init that waited for a busy line may have given up, and a supervisor's stop may have followed before the
        // program could see that.
        if (!has_begun_ && now - ordered_at_ > shortest_wait_us) is_taking_over_ = false;
        has_begun_ = true;
        if (!is_stop(frame)) {
            is_taking_over_ = false;
            return false;
        }
        // Likewise after the third round of its first stop has got no response.
        if (unanswered_ == 3) is_taking_over_ = false;
        ++unanswered_;
        if (!is_in_haste()) return false;
        if (wanted_.is_stop || !has_waited) --urgent_left_;
        return true;
    }
    /// The last command was reported to have ended.
    void end_take_over() { is_taking_over_ = false; }
    /// Called once in each iteration of the program's loop.
    void note_turn(std::uint64_t now) {
        if (is_new_) ordered_at_ = now;
        is_new_ = false;
    }
    /// The program's port has returned. A drive without a watchdog is stopped as another time (G45).
    void note_port_back() {
        if (!has_watchdog()) urgent_left_ = 3;
    }
    /// The program has received a valid response to this request.
    void answered(servobus::bytes request) {
        unanswered_ = 0;
        if (servobus::modbus::is_write(request[1])) {
            is_stop_answered_ = is_stop_answered_ || is_stop(request);
            return;
        }
        urgent_left_ = 3; // the next stop is another one
        if (is_stop_answered_ && stands()) is_stop_open_ = false;
    }

  protected:
    void ordered(errand e) {
        if (e.is_stop) {
            is_stop_open_ = true;
            is_stop_answered_ = false;
        }
        is_taking_over_ = e.is_init;
        is_new_ = true;
        has_begun_ = false;
        unanswered_ = 0;
        urgent_left_ = 3;
        wanted_ = std::move(e);
    }

  private:
    // A line gives up to wait after two frames and two quarantines.
    static constexpr std::uint64_t shortest_wait_us = 45'000;

    errand wanted_;
    std::uint64_t ordered_at_ = 0;
    bool is_new_ = false;    // the last command, in this iteration
    bool has_begun_ = false; // a frame has been sent since
    bool is_stop_open_ = false;
    bool is_stop_answered_ = false; // since it was commanded
    bool is_taking_over_ = false;   // an `init` has sent nothing but stops yet
    unsigned urgent_left_ = 0;
    unsigned unanswered_ = 0; // stops in a row since the command
};

/// The word that a frame writes to this register, or `otherwise`.
inline std::uint16_t word_written(servobus::bytes frame, std::uint16_t address, std::uint16_t otherwise) {
    if (!servobus::modbus::is_write(frame[1])) return otherwise;
    const unsigned first = servobus::load_word(frame, 2);
    const unsigned count = frame[1] == 0x06 ? 1u : servobus::load_word(frame, 4);
    if (address < first || address >= first + count) return otherwise;
    return servobus::load_word(frame, frame[1] == 0x06 ? 4u : 7u + 2u * (address - first));
}

inline bool is_read_of(servobus::bytes frame, std::uint16_t address) {
    return frame[1] == 0x03 && servobus::load_word(frame, 2) == address;
}

/// The frame is what one of these repeatable steps sends: a constant in each of its registers.
inline bool is_one_of(std::span<const servobus::step> stops, servobus::bytes frame) {
    if (!servobus::modbus::is_write(frame[1])) return false;
    const unsigned count = frame[1] == 0x06 ? 1u : servobus::load_word(frame, 4);
    for (const servobus::step& s : stops) {
        if (s.address != servobus::load_word(frame, 2) || s.count != count) continue;
        bool is_same = true;
        for (unsigned i = 0; i < count; ++i) {
            const auto at = static_cast<std::uint16_t>(s.address + i);
            is_same = is_same && word_written(frame, at, static_cast<std::uint16_t>(~s.value)) == s.value;
        }
        if (is_same) return true;
    }
    return false;
}

template <class Seat, class Drive> class facade_of : public facade {
  public:
    template <class... Supervision>
    facade_of(Seat& at, plain_line& on, const Supervision&... by)
        : drive{on, at.client.node(), by...}, at_{&at} {}

    participant& place() override { return *at_; }
    servobus::duration step() override { return drive.step(); }
    bool is_idle() const override { return drive.is_idle(); }
    servobus::command_status last() const override { return drive.last(); }
    bool needs_init() const override { return drive.state() == decltype(drive.state())::needs_init; }

    bool says_enabled() const override { return drive.state() == decltype(drive.state())::enabled; }
    bool says_reached() const override { return drive.arrival().how == servobus::arrival_state::reached; }

    Drive drive;

  protected:
    auto& model() { return at_->model(); }
    /// The interpretations of the manual that the simulated drive follows.
    template <class Options> Options chosen() const { return options_at<Options>(at_->positions()); }
    template <class Command> servobus::errc begin(const Command& o, errand e) {
        const servobus::errc refusal = drive.begin(o).error();
        if (refusal == servobus::errc::ok) ordered(std::move(e));
        return refusal;
    }
    /// Carries the command out and waits for its end.
    template <class Command> bool carry_out(const Command& o) {
        ordered({});
        return static_cast<bool>(drive.run(o));
    }
    template <class Command> servobus::errc stop(const char* name, const Command& o) {
        return begin(o, {.name = name, .is_stop = true, .is_carried_out = [this] { return stands(); }});
    }

  private:
    Seat* at_;
};

} // namespace trial
