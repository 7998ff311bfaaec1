// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Drives two wheels on a serial port for a control loop that must not wait. It knows nothing of ROS: the hardware
// interface (servobus_zlac8015d_system.hpp) calls it, and tests call it over a simulated line. Functions return what is
// wrong in one sentence, or an empty string.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <system_error>

#include <servobus/control/take_over.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <servobus/device/zlac8015d/shaped_speeds.hpp>
#include <servobus/posix/serial.hpp>
#include <servobus/servobus.hpp>

#include "parameters.hpp"
#include "trouble.hpp"
#include "wheel_drive.hpp"

namespace servobus_ros2_control {

/// `Port` has what posix::serial has.
template <class Port> class robot_hardware {
    using line_type = servobus::line<Port>;
    using drive_type = wheel_drive<line_type>;
    using duration = servobus::duration;

  public:
    robot_hardware() = default;
    robot_hardware(const robot_hardware&) = delete; // the line refers to the port
    robot_hardware& operator=(const robot_hardware&) = delete;

    /// Opens the port. Nothing is sent. The positions go on from their last values.
    std::string open(const parameters& wanted) {
        close();
        chosen_ = wanted;
        wheels_[0] = {wanted.left_counts_per_turn, wanted.left_mirrored};
        wheels_[1] = {wanted.right_counts_per_turn, wanted.right_mirrored};
        servobus::posix::serial_settings how =
            servobus::posix::settings_of(servobus::zlac8015d::device::facts);
        how.baud = wanted.baud;
        how.rs485 = wanted.rs485;
        if (const servobus::status opened = port_.open(wanted.port.c_str(), how); !opened)
            return "cannot open " + wanted.port + ": " + open_error(opened.error());
        line_.emplace(port_, servobus::modbus::timing_at(wanted.baud));
        drive_.emplace(
            *line_, node(),
            servobus::supervision{.feedback = servobus::milliseconds(wanted.feedback_ms),
                                  .command_timeout = servobus::milliseconds(wanted.command_timeout_ms)});
        drive_->go_on_from(followed_);
        return {};
    }
    /// Closes the port. A drive that is still enabled is stopped by its watchdog.
    void close() {
        if (drive_) followed_ = drive_->followed();
        drive_.reset();
        line_.reset();
        port_.close();
        is_taken_over_ = false;
        velocity_[0] = velocity_[1] = 0; // they are not known any more
    }
    bool is_open() const { return drive_.has_value(); }

    /// Takes the drive over and energises it; nothing moves. A port that was lost is opened again. Waits, up to the
    /// drive's ramps and the time of a few lost frames.
    std::string activate() {
        is_taken_over_ = false;
        std::string error;
        if (!drive_ || !port_.is_open()) error = open(parameters{chosen_});
        if (!error.empty()) return error;
        error = take_over();
        if (error.empty()) error = check_counts();
        if (error.empty()) error = enable();
        publish();
        if (!error.empty()) return error;
        is_taken_over_ = true;
        is_due_ = true;
        return {};
    }
    /// Stops the wheels and takes their power; both stand if no error is returned. Waits, at most for the ramp and 3 s.
    std::string deactivate() {
        if (!drive_) return "the port is not open";
        if (drive_->state() == servobus::drive_state::enabled) (void)run(servobus::halt{});
        const std::string error =
            run(servobus::disable{}); // stops by itself, too, and waits until both wheels stand
        publish();
        return error;
    }

    /// Moves on without waiting and takes the newest feedback.
    void read() {
        if (!drive_) return;
        step();
        publish();
    }
    /// Sets the latest command in rad/s. Without waiting: it is sent when nothing else is under way.
    std::string write(double left, double right) {
        if (!drive_) return "the port is not open";
        if (!std::isfinite(left) || !std::isfinite(right))
            return "a command is no finite number: " + std::to_string(left) + ", " + std::to_string(right);
        is_due_ = is_due_ || left != left_ || right != right_;
        left_ = left;
        right_ = right;
        step();
        const servobus::instant now = line_->now();
        const duration third = servobus::milliseconds(chosen_.command_timeout_ms / 3);
        if (!drive_->is_idle() || (!is_due_ && servobus::since(begun_, now) < third)) return {};
        const servobus::zlac8015d::shaped_setpoint next = shaped(now);
        const std::string refusal = begin(next);
        if (!refusal.empty()) return refusal;
        shaped_.begin(next);
        begun_ = now;
        is_due_ = shaped_.is_changing();
        step();
        return {};
    }

    /// What keeps an activated drive from following its commands.
    std::string trouble() {
        if (!drive_ || !is_taken_over_) return {};
        return trouble_of(*drive_, port_.is_open() ? std::string{} : system_error(), chosen_.watchdog_ms);
    }
    /// True once if a drive that was taken over has been lost since.
    bool take_loss() {
        const bool is_lost = is_taken_over_ && drive_ && drive_->state() == servobus::drive_state::needs_init;
        if (is_lost) is_taken_over_ = false;
        return is_lost;
    }

    double position(std::size_t wheel) const { return position_[wheel]; }
    double velocity(std::size_t wheel) const { return velocity_[wheel]; }
    bool has_fault() const { return drive_ && drive_->state() == servobus::drive_state::faulted; }
    std::uint32_t gaps() const { return drive_ ? drive_->followed().gaps() : followed_.gaps(); }
    const Port& port() const { return port_; }

  private:
    // A call ends after so many steps, whatever the drive does.
    static constexpr int most_steps = 8;

    servobus::node<servobus::zlac8015d::device> node() const {
        const servobus::node<servobus::zlac8015d::device> at{static_cast<std::uint8_t>(chosen_.node)};
        return responds_within(at, servobus::milliseconds(chosen_.response_ms));
    }
    std::string open_error(servobus::errc why) const {
        using enum servobus::errc;
        const bool is_system = why == bad_argument || why == port_lost;
        return is_system ? system_error() : servobus::text(why);
    }
    std::string system_error() const { return std::generic_category().message(port_.os_error()); }

    // The setpoint on the way to the latest command. Where the drive has not followed the one before, the way begins at
    // the speeds that it shows.
    servobus::zlac8015d::shaped_setpoint shaped(servobus::instant now) {
        if (drive_->cause() != servobus::stop_cause::unknown || !drive_->last()) shaped_.forget();
        const servobus::zlac8015d::cached_settings known = drive_->cached();
        const std::int32_t parts = 2520 / known.resolution; // of a speed in a count
        const auto wanted = velocity_of(wheels_, left_, right_).within(known);
        const auto seen = drive_->feedback(servobus::milliseconds(500)).value_or({});
        return shaped_.towards({wanted.left.count() / parts, wanted.right.count() / parts},
                               {static_cast<std::int16_t>(seen.left_speed.count()),
                                static_cast<std::int16_t>(seen.right_speed.count())},
                               known.resolution, now);
    }
    std::string begin(const servobus::zlac8015d::shaped_setpoint& next) {
        using servobus::zlac8015d::speed;
        const std::int32_t parts = 2520 / drive_->cached().resolution;
        const auto speed_of = [&](std::uint16_t word) {
            return speed{static_cast<std::int16_t>(word) * parts};
        };
        const servobus::command_status begun =
            drive_->begin(servobus::velocity{speed_of(next.left_word()), speed_of(next.right_word())});
        return begun ? std::string{} : std::string{"a velocity is refused: "} + text(begun.error());
    }
    void step() {
        for (int i = 0; i < most_steps && drive_->step() == duration{}; ++i) {}
    }
    void publish() {
        for (std::size_t i = 0; i < 2; ++i) position_[i] = wheels_[i].rad_of(drive_->followed().counts(i));
        const auto seen = drive_->feedback(servobus::milliseconds(32'000));
        if (!seen) return;
        velocity_[0] = wheels_[0].rad_per_s_of(seen->left_speed.count());
        velocity_[1] = wheels_[1].rad_per_s_of(seen->right_speed.count());
    }

    // --- Activation

    std::string take_over() {
        using namespace servobus;
        const zlac8015d::resolution fine{10}; // speeds count 0.1 r/min
        const zlac8015d::watchdog watchdog{time_of(chosen_.watchdog_ms)};
        // The ramps follow the setpoints, which are shaped here; the drive stops by itself in a time of its own.
        const zlac8015d::ramps ramps{time_of(10), time_of(10)};
        const zlac8015d::quick_stop_ramp stop{time_of(chosen_.stop_ms)};
        const zlac8015d::quick_stop_by by{zlac8015d::quick_stop_option::fast_deceleration};
        shaped_ = {};
        shaped_.set_limits({.acceleration = tenths_of(chosen_.acceleration),
                            .deceleration = tenths_of(chosen_.deceleration)});
        const command_status ready =
            chosen_.reset_faults
                ? drive_->run(servobus::take_over{with_fault_reset{}, fine, watchdog, ramps, stop, by})
                : drive_->run(servobus::take_over{fine, watchdog, ramps, stop, by});
        if (drive_->state() == drive_state::faulted)
            return faults_of(*drive_) + "; parameter reset_faults lets an activation reset them";
        if (ready) return {};
        if (ready.part() == take_over_part::power_cycle)
            return "the drive has a new resolution of speeds (2022h): switch it off and on, then activate "
                   "again";
        constexpr const char* settings[] = {"",         " (resolution)", " (watchdog_ms)",
                                            " (ramps)", " (stop_ms)",    " (2011h)"};
        return std::string{"the drive is not taken over: "} + text(ready.part()) + settings[ready.setting()] +
               ": " + text(ready.error());
    }
    // From rad/s in a second to 0.1 r/min in a second.
    static std::uint16_t tenths_of(std::uint32_t rad_per_s2) {
        return static_cast<std::uint16_t>(std::lround(600 / rad_per_turn * rad_per_s2));
    }
    static servobus::zlac8015d::time time_of(std::uint32_t ms) {
        return servobus::zlac8015d::time{static_cast<std::int32_t>(ms)};
    }

    // The drive is stopped and without power: a client may read beside it.
    std::string check_counts() {
        servobus::client<line_type, servobus::zlac8015d::device> registers{*line_, node()};
        const auto left = registers.template read<servobus::zlac8015d::left_encoder_lines>();
        const auto right = registers.template read<servobus::zlac8015d::right_encoder_lines>();
        if (!left || !right)
            return std::string{"the encoder's lines cannot be read: "} +
                   text(left ? right.error() : left.error());
        std::string error = compare("left", "2030h", *left, wheels_[0]);
        if (error.empty()) error = compare("right", "2060h", *right, wheels_[1]);
        return error;
    }
    static std::string compare(const char* side, const char* where, std::uint32_t lines,
                               const wheel& stated) {
        const std::uint32_t counts = 4 * (lines == 0 ? 1024 : lines); // the drive counts 0 as the factory's
        if (counts == stated.counts_per_turn) return {};
        return std::string{side} + "_counts_per_turn is " + std::to_string(stated.counts_per_turn) +
               ", but the drive counts " + std::to_string(counts) + ": its encoder lines, " + where +
               ", are " + std::to_string(lines);
    }

    std::string enable() {
        const servobus::command_status energised = drive_->run(servobus::enable{});
        if (energised && drive_->state() == servobus::drive_state::enabled) return {};
        const std::string why =
            std::string{"the drive is not enabled: "} + text(energised.error()) + "; is a wired stop active?";
        (void)run(servobus::disable{});
        return why;
    }

    // Runs a stop for as long as a ramp may take, since an error of the framework's loop is handled in that loop.
    template <class Stop> std::string run(const Stop& stop) {
        if (const servobus::command_status halted = drive_->begin(stop); !halted)
            return std::string{"a stop is refused: "} + text(halted.error());
        const servobus::instant begun = line_->now();
        const duration limit = servobus::milliseconds(chosen_.stop_ms + 3000);
        while (!drive_->is_idle()) {
            if (servobus::since(begun, line_->now()) > limit)
                return "the wheels did not stand in time; the drive's watchdog must stop it";
            line_->sleep(drive_->step());
        }
        if (drive_->last()) return {};
        return std::string{"a stop is not confirmed: "} + text(drive_->last().error()) +
               "; the drive's watchdog must stop it";
    }

    Port port_{};
    std::optional<line_type> line_{};
    std::optional<drive_type> drive_{};
    parameters chosen_{};
    wheel wheels_[2]{};
    wheels_model followed_{}; // the counts while the port is closed
    double position_[2]{};
    double velocity_[2]{};
    servobus::zlac8015d::shaped_speeds shaped_{};
    double left_ = 0; // rad/s
    double right_ = 0;
    servobus::instant begun_{}; // the last command
    bool is_due_ = false;       // a command that was not begun yet
    bool is_taken_over_ = false;
};

} // namespace servobus_ros2_control
