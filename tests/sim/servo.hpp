// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The facade of the C630S with random commands. Its drive is set up before.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <servobus/device/c630s.hpp>
#include <servobus/device/c630s/catalogue.hpp>
#include <servobus/sim/c630s.hpp>
#include <servobus/sim/line.hpp>

#include <tests/support/seen_machines.hpp>

#include "expected_end.hpp"
#include "facade.hpp"

namespace trial {

using servo_participant = participant_of<plain_line, servobus::c630s::device, servobus::sim::c630s>;

/// The settings that `set_up` writes. They are found once on a separate line, which saves a hundred frames
/// in each run.
struct c630s_setting {
    std::uint16_t address;
    std::vector<std::uint16_t> words;
};
inline const std::vector<c630s_setting>& prepared_c630s() {
    static const std::vector<c630s_setting> all = [] {
        servobus::sim::c630s fresh;
        servobus::sim::c630s model;
        servobus::sim::station at_the_drive{model};
        servobus::sim::virtual_line wire{model.baud()};
        (void)wire.attach(at_the_drive);
        servobus::line on{wire, servobus::modbus::timing_at(model.baud())};
        servobus::c630s::drive drive{on, 1};
        std::vector<c630s_setting> found;
        if (!drive.run(servobus::init{}) || !drive.run(servobus::c630s::set_up{})) return found;
        for (const servobus::entry& e : servobus::c630s::catalogue.entries) {
            std::vector<std::uint16_t> was(e.words());
            std::vector<std::uint16_t> is(e.words());
            // Without P0C-13, by which the drive stores all later writes.
            if (e.rights != servobus::access::rw || e.address == 0x0C0D || fresh.read(e.address, was) != 0)
                continue;
            if (model.read(e.address, is) == 0 && is != was) found.push_back({e.address, is});
        }
        return found;
    }();
    return all;
}

class servo final : public facade_of<servo_participant, servobus::c630s::drive<plain_line>> {
    using view = seen::servo;

  public:
    using facade_of::facade_of;

    bool make_ready() override {
        for (const auto& [address, words] : prepared_c630s()) (void)model().write(address, words_of(words));
        model().power_cycle();
        return carry_out(servobus::init{});
    }

    servobus::errc begin_any(scene& on) override {
        using namespace servobus::c630s;
        if (drive.state() == drive_state::needs_init && !on.one_in(4)) return initialise();
        switch (on.random.below(drive.state() == drive_state::enabled || needs_init() ? 10 : 5)) {
        case 0: return initialise();
        case 1: return begin_stop(on);
        case 2: return begin(servobus::read_feedback{}, {.name = "read feedback"});
        case 3:
            return begin(
                servobus::fault_reset{},
                {.name = "fault reset", .disables = true, .is_carried_out = [this] { return is_off(); }});
        case 4: return be_enabled_in(on);
        default: return move(on);
        }
    }
    servobus::errc begin_move_or_wait(scene& on) override {
        using namespace servobus::c630s;
        if (drive.state() != drive_state::enabled) return needs_init() ? begin_any(on) : enable_for_moves();
        if (drive.cached().mode != control_mode::position) return on.one_in(4) ? begin_end() : begin_any(on);
        if (on.one_in(12)) return begin_stop(on);
        if (on.one_in(2)) return move(on);
        if (on.one_in(3))
            return begin(servobus::wait_standstill{servobus::milliseconds(5'000)},
                         {.name = "wait for standstill", .has_arrived = [this] {
                              return stands() && (!expected_end_.is_certain() || is_at_goal());
                          }});
        return begin(servobus::wait_reached{servobus::milliseconds(5'000)},
                     {.name = "wait for arrival", .has_arrived = [this] {
                          return stands() && (!expected_end_.is_known() || is_at_goal());
                      }});
    }
    servobus::errc begin_motion(scene& on) override {
        using servobus::c630s::drive_state;
        if (needs_init()) return initialise();
        return drive.state() == drive_state::enabled ? move(on) : be_enabled_in(on);
    }
    servobus::errc begin_stop(scene& on) override {
        using namespace servobus::c630s;
        const std::uint32_t which = on.random.below(3);
        const bool has_halt =
            drive.state() != drive_state::enabled || drive.cached().mode != control_mode::position;
        if (which == 0 && has_halt) return stop("halt", servobus::halt{});
        if (which == 1) return stop("quick stop", servobus::quick_stop{});
        return begin_end();
    }
    servobus::errc begin_end() override {
        return begin(servobus::disable{}, {.name = "disable", .is_stop = true, .is_carried_out = [this] {
                                               return is_off() && stands();
                                           }});
    }

    bool stands() override { return view::is_slow(model()); }
    std::uint32_t starts() override { return view::starts(model()); }
    std::uint32_t enables() override { return model().enables(); }
    std::uint64_t motion() override {
        using namespace servobus::c630s;
        constexpr std::uint64_t jogging = std::uint64_t{1} << 33;
        const std::int64_t levels = model().peek(virtual_input_levels.address);
        if (levels != 0) is_marked_ = (levels & terminal::marker) != 0;
        if (!model().enabled()) return 0;
        const bool is_jogging =
            model().is_active(input_function::jog_forward) || model().is_active(input_function::jog_reverse);
        const std::uint64_t pace = bits_of(jog_speed.address);
        if (is_jogging) return pace == 0 ? 0 : jogging | pace;
        switch (static_cast<control_mode>(model().peek(mode_of_operation.address))) {
        case control_mode::speed: return bits_of(target_speed.address);
        case control_mode::torque: return bits_of(target_torque.address);
        default: return model().is_positioning() || model().is_homing() ? jogging + 1 + starts() : 0;
        }
    }

    /// By a level of P31-00 that a restart clears: the drive had it when it was seen last.
    bool has_witness() const override { return is_marked_; }
    bool shows_restarts() const override { return is_marked_; }

    bool is_able() override {
        return !shows_plight() && !is_blocked_ &&
               !model().is_active(servobus::c630s::input_function::emergency_stop);
    }
    // An enabled drive holds its position while that input is on, and obeys nothing.
    bool shows_plight() override { return !view::is_energised(model()) || view::has_fault(model()); }
    bool is_enabled_by_level() const override { return true; }
    bool has_goal() const override { return expected_end_.is_known(); }
    // A command that ended within 20 reference units of the target, and the motor within P05-21 of that.
    bool is_at_goal() override {
        const std::int64_t coin = model().in_force(servobus::c630s::positioning_completed_threshold.address);
        return expected_end_.is_end(model().position(), coin + counts_of(22));
    }
    void note_start() override { expected_end_.start(model().position(), 0); }
    void note_end(bool is_done) override { expected_end_.end(is_done); }
    bool is_feedback(servobus::bytes frame) const override {
        return is_read_of(frame, servobus::c630s::virtual_output_levels.address);
    }
    // Its level is held by many frames: the simulated drive says whether one has enabled it.
    bool is_enable(servobus::bytes) const override { return false; }
    bool is_start(servobus::bytes frame) const override {
        using namespace servobus::c630s;
        return (word_written(frame, virtual_input_levels.address, 0) & terminal::segment_start) != 0;
    }
    void suffer(scene& on) override {
        switch (on.random.below(3)) {
        case 0: return model().raise(0x620);
        case 1: return view::press_stop(model());
        default: return block(true);
        }
    }
    void recover() override {
        view::end_fault(model());
        view::release_stop(model());
        block(false);
    }

    bool is_stop(servobus::bytes frame) const override {
        using namespace servobus::c630s::routines;
        // P0C-13 = 0 goes with them, so that they wear nothing.
        static constexpr servobus::step stops[] = {stop_by_targets,  zero_torque,  servo_off,
                                                   servo_off_marked, stop_at_once, spare_first[0]};
        return is_one_of(stops, frame);
    }
    bool is_trigger(servobus::bytes frame) const override {
        using namespace servobus::c630s;
        constexpr auto edges = static_cast<std::uint16_t>(terminal::segment_start | terminal::step_start |
                                                          terminal::jog_forward | terminal::jog_reverse);
        return (word_written(frame, virtual_input_levels.address, 0) & edges) != 0 ||
               word_written(frame, alarm_reset.address, 0) != 0;
    }
    bool is_setpoint(servobus::bytes frame) const override { // P06-03, P07-03
        const unsigned first = servobus::load_word(frame, 2);
        return frame[1] == 0x06 && (first == 0x0603 || first == 0x0703);
    }

  private:
    static servobus::words_view words_of(const std::vector<std::uint16_t>& words) {
        static std::array<std::uint8_t, 8> raw;
        for (std::size_t i = 0; i < words.size(); ++i) servobus::store_word(raw, 2 * i, words[i]);
        return servobus::words_view{servobus::bytes{raw}.first(2 * words.size())};
    }
    using c630s_time = servobus::c630s::time;

    bool is_start_level() const { return chosen<servobus::sim::c630s_options>().segment_start_is_level; }

    // The factory's gear: 10000 reference units a revolution of 131072 encoder counts.
    static std::int64_t counts_of(std::int64_t reference_units) { return reference_units * 131'072 / 10'000; }
    bool is_off() { return !model().enabled(); }
    std::uint64_t bits_of(std::uint16_t address) {
        return static_cast<std::uint32_t>(static_cast<std::uint64_t>(model().peek(address)));
    }

    servobus::errc initialise() {
        expected_end_.forget();
        return begin(servobus::init{}, {.name = "init", .is_init = true, .is_carried_out = [this] {
                                            return is_off() && stands();
                                        }});
    }
    servobus::errc enable_for_moves() {
        expected_end_.forget();
        return begin(servobus::c630s::enable_in{servobus::c630s::control_mode::position},
                     {.name = "enable for moves", .enables = true, .is_carried_out = [this] {
                          return model().enabled();
                      }});
    }
    servobus::errc be_enabled_in(scene& on) {
        using servobus::c630s::control_mode;
        expected_end_.forget();
        static constexpr control_mode modes[] = {control_mode::speed, control_mode::torque,
                                                 control_mode::position};
        return begin(
            servobus::c630s::enable_in{modes[on.random.below(3)]},
            {.name = "enable", .enables = true, .is_carried_out = [this] { return model().enabled(); }});
    }
    servobus::errc move(scene& on) {
        using namespace servobus::c630s;
        using namespace servobus::units;
        const auto size = static_cast<std::int32_t>(on.between(20, 400));
        const std::int32_t wanted = on.one_in(2) ? size : -size;
        const bool is_jog = on.one_in(4);
        if (drive.cached().mode == control_mode::speed && is_jog)
            return begin(jog{wanted * r_per_min}, {.name = "jog", .moves = true});
        if (drive.cached().mode == control_mode::speed) {
            return begin(servobus::velocity{wanted * r_per_min},
                         {.name = "velocity", .moves = true, .is_carried_out = [this, wanted] {
                              return model().peek(target_speed.address) == wanted;
                          }});
        }
        if (drive.cached().mode == control_mode::torque) {
            return begin(torque{torque_share{wanted / 10}},
                         {.name = "torque", .moves = true, .is_carried_out = [this, wanted] {
                              return model().peek(target_torque.address) == wanted / 10;
                          }});
        }
        const std::uint32_t before = starts();
        if (is_jog)
            return begin(segment{1, 10 * wanted * reference_unit, 300 * r_per_min}, {.name = "segment"});
        const servobus::errc refusal = begin(
            start_segment{1}, {.name = "start segment", .moves = true, .is_carried_out = [this, before] {
                                   // Where the function is a level, nothing starts [errata C23].
                                   return starts() == before + !is_start_level();
                               }});
        constexpr auto way = position_segment_displacements[0];
        if (refusal == servobus::errc::ok) expected_end_.command(counts_of(model().in_force(way.address)));
        return refusal;
    }

    void block(bool is_blocked) {
        is_blocked_ = is_blocked;
        model().block_shaft(is_blocked);
    }

    expected_end expected_end_;
    bool is_marked_ = false;
    bool is_blocked_ = false; ///< its shaft
};

} // namespace trial
