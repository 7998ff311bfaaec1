// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// One run of a command on a virtual line: the facade, the simulated drive, and up to two mishaps. It keeps what is seen
// of the drive from outside. The runs are made and judged by sim/conformance.hpp.
//
//     template <class Subject> bool can_be_enabled() {
//         sim::trial<Subject> t{0};
//         return t.run(init{}) && t.run(enable{}) && t.is_energised();
//     }
#pragma once

#include <cstdint>
#include <span>

#include <servobus/control/command_status.hpp>
#include <servobus/control/common_commands.hpp>
#include <servobus/control/states.hpp>
#include <servobus/control/supervision.hpp>
#include <servobus/line/line.hpp>
#include <servobus/sim/conformance/disturbed.hpp>
#include <servobus/sim/conformance/finding.hpp>
#include <servobus/sim/conformance/mishap.hpp>
#include <servobus/sim/conformance/mishap_plan.hpp>
#include <servobus/sim/conformance/wire_log.hpp>
#include <servobus/sim/line.hpp>
#include <servobus/sim/station.hpp>

namespace servobus::sim {

template <class Subject> class trial {
  public:
    using line_type = line<virtual_line>;
    using drive_type = typename Subject::template drive<line_type>;
    using machine_type = disturbed<typename Subject::machine, trial>;

    /// A motion without an end is stopped after it by the facade.
    static constexpr duration command_limit = milliseconds(400);
    static constexpr duration stall = milliseconds(3'000);

    explicit trial(unsigned interpretation)
        : machine_{*this, [&] { return Subject::make(interpretation); }},
          station_{machine_, Subject::address, Subject::baud, milliseconds(1), modbus::rules_of(machine_)},
          wire_{Subject::baud}, on_{wire_, modbus::timing_at(Subject::baud)},
          drive_{on_, Subject::address, supervision{.command_timeout = command_limit}} {
        wire_.attach(station_);
        wire_.set_hook(&trial::note, this);
        was_energised_ = is_energised();
    }
    trial(const trial&) = delete;
    trial& operator=(const trial&) = delete;

    drive_type& drive() { return drive_; }
    typename Subject::machine& machine() { return machine_.machine; }
    virtual_line& wire() { return wire_; }

    bool is_energised() const { return Subject::is_energised(machine_.machine); }
    bool is_turning() const { return Subject::is_turning(machine_.machine); }
    std::int64_t place() const { return Subject::place(machine_.machine); }

    /// From now on what is seen counts, and the mishaps happen at the requests that follow, counted from 0.
    void watch(planned_mishap first = {}, planned_mishap second = {}) {
        plan_ = {first, second};
        first_request_ = wire_.requests();
        struck_ = wire_.struck();
        log_.begin();
        energised_ = 0;
        begun_at_ = place();
        was_turning_ = is_turning();
        is_stop_refused_ = false;
        starts_ = starts();
        least_ = most_ = begun_at_;
        was_energised_ = is_energised();
        forget_views();
    }
    /// No more mishaps: the line and the drive are sound again.
    void heal() {
        plan_.end();
        wire_.faults() = {};
        Subject::end_fault(machine_.machine);
        Subject::release_stop(machine_.machine);
        was_energised_ = is_energised();
    }

    /// Steps until the command has ended, at most two minutes. Returns false if it has not.
    bool finish() {
        const std::uint64_t end = wire_.time_us() + 120'000'000;
        while (!drive_.is_idle()) {
            if (wire_.time_us() > end) return false;
            turn();
        }
        return true;
    }
    /// Steps for a time, without a command.
    void live(duration time) {
        const std::uint64_t end = wire_.time_us() + time.us;
        while (wire_.time_us() < end) turn();
    }
    template <class Command> command_status run(const Command& wanted) {
        if (const command_status begun = drive_.begin(wanted); !begun) return begun;
        if (!finish()) return errc::clock_stopped;
        return drive_.last();
    }

    // What was seen since `watch`

    /// Requests that began to leave, and those of them that write.
    unsigned requests() const { return wire_.requests() - first_request_; }
    unsigned writes() const { return log_.writes(); }
    /// Counts how often the motor was energised, other than by a restart of the drive.
    unsigned energised() const { return energised_; }
    /// True if a disable, begun while the command was under way, was refused.
    bool is_stop_refused() const { return is_stop_refused_; }
    /// True if the drive has carried out the start of a move.
    bool has_started() const { return starts() != starts_; }
    std::int64_t begun_at() const { return begun_at_; }
    bool was_turning() const { return was_turning_; }
    const wire_log& log() const { return log_; }
    std::int64_t least() const { return least_; }
    std::int64_t most() const { return most_; }
    bool has_happened(mishap m) const { return plan_.has_happened(m); }
    bool has_restarted() const { return plan_.has_restarted(); }
    bool has_restarted_in_a_change() const { return plan_.has_restarted_in_a_change(log_); }
    /// True if it held at some time since the last request but one arrived at the drive: a condition shows within two
    /// frames (G35).
    bool was_energised() const { return views_[0].energised || views_[1].energised || is_energised(); }
    bool was_off() const { return views_[0].off || views_[1].off || !is_energised(); }
    bool stood() const { return views_[0].stood || views_[1].stood || !is_turning(); }
    bool turned() const { return views_[0].turned || views_[1].turned || is_turning(); }
    bool was_at(std::int64_t goal) const {
        return is_near(place(), goal) || (views_[0].any && is_near(views_[0].place, goal)) ||
               (views_[1].any && is_near(views_[1].place, goal));
    }
    static constexpr bool is_near(std::int64_t place, std::int64_t goal) {
        const std::int64_t away = place - goal;
        return away <= Subject::tolerance && away >= -Subject::tolerance;
    }

    std::span<const traced_frame> trace() { return log_.trace(); }

    // For `disturbed`

    std::uint8_t before() {
        views_[1] = views_[0];
        views_[0] = {};
        view();
        if (happens(mishap::restart_before)) restart();
        if (happens(mishap::refused)) return 4;
        if (happens(mishap::busy)) return 6;
        return 0;
    }
    void after() {
        view();
        if (happens(mishap::restart_after)) restart();
        if (happens(mishap::fault)) Subject::have_fault(machine_.machine);
        if (happens(mishap::stop_input)) Subject::press_stop(machine_.machine);
        if (happens(mishap::foreign_write)) Subject::write_by_another(machine_.machine);
        sample();
    }

  private:
    struct views {
        bool any = false, energised = false, off = false, stood = false, turned = false;
        std::int64_t place = 0;
    };

    std::uint32_t starts() const { return Subject::starts(machine_.machine); }
    void forget_views() { views_[0] = views_[1] = {}; }
    void view() {
        views_[0].any = true;
        (is_energised() ? views_[0].energised : views_[0].off) = true;
        (is_turning() ? views_[0].turned : views_[0].stood) = true;
        views_[0].place = place();
    }
    void sample() {
        const bool now = is_energised();
        if (now && !was_energised_) ++energised_;
        was_energised_ = now;
        const std::int64_t at = place();
        least_ = at < least_ ? at : least_;
        most_ = at > most_ ? at : most_;
    }
    void restart() {
        Subject::restart(machine_.machine);
        was_energised_ = is_energised();
    }

    bool happens(mishap m) { return plan_.happens(m, requests()); }
    void set_faults() { plan_.set_faults(wire_.faults(), requests()); }
    void note_struck() {
        if (wire_.struck() == struck_) return;
        struck_ = wire_.struck();
        plan_.note_line_fault(requests());
    }
    void turn() {
        set_faults();
        const duration idle = drive_.step();
        set_faults();
        sample();
        note_struck();
        if (happens_now(mishap::program_stalls)) wire_.pass(stall);
        if (happens_now(mishap::program_halts)) (void)drive_.begin(halt{});
        if (happens_now(mishap::program_disables)) is_stop_refused_ = drive_.begin(disable{}) != errc::ok;
        constexpr duration longest = milliseconds(5); // the machine is looked at so often
        wire_.wait(idle == duration{} ? microseconds(20) : idle < longest ? idle : longest);
        sample();
    }
    bool happens_now(mishap m) { return !has_happened(m) && happens(m); }

    static void note(void* self, const wire_byte& b) { static_cast<trial*>(self)->note(b); }
    void note(const wire_byte& b) { log_.note(b, requests()); }

    mishap_plan plan_{};
    wire_log log_{};
    bool was_turning_ = false;
    bool is_stop_refused_ = false;
    std::uint32_t starts_ = 0;
    std::uint32_t first_request_ = 0;
    std::uint32_t struck_ = 0; // frames with a fault
    unsigned energised_ = 0;
    std::int64_t begun_at_ = 0;
    std::int64_t least_ = 0;
    std::int64_t most_ = 0;
    bool was_energised_ = false;
    views views_[2]{};
    machine_type machine_;
    station<machine_type> station_;
    virtual_line wire_;
    line_type on_;
    drive_type drive_;
};

} // namespace servobus::sim
