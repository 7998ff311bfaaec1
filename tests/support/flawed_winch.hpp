// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The winch of the example with one flaw: of the motor, of what its registers show, of its model or of its subject,
// both of which are in flawed_winch_subject.hpp.
#pragma once

#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/slice.hpp>
#include <servobus/core/time.hpp>

#include <examples/own_device/own_simulator.hpp>

namespace flawed_winch {

using namespace servobus;

enum class flaw : unsigned {
    none,
    // The motor does otherwise than its registers show.
    slips,              ///< it goes a tenth farther
    jerks_ahead,        ///< it moves when it is energised
    jerks_back,         ///< likewise
    stands,             ///< it does not turn
    twitches_at_odd,    ///< it turns for a moment, at each second read of the feedback
    twitches_at_even,   ///< at the others
    turns_on,           ///< after a move
    turns_after_stop,   ///< after it was seen to stand
    jumps_off,          ///< after it was seen at its target
    turns_if_restarted, ///< until it restarts once more; its registers show it
    wakes,              ///< energises itself after a disable of a turning motor; its registers show it
    never_off,          ///< stays energised
    off_late,           ///< is off after the register was read that shows it
    off_shortly,        ///< is off for a moment after a disable; its register shows nothing else
    energised_late,     ///< 100 ms after the register shows it
    energised_if_seen,  ///< after the register was read that shows it
    energised_shortly,  ///< is not energised, which the register shows after 30 ms
    // It does not do what it should.
    never_energised,
    energised_unseen, ///< and stays so; the subject says that no enable can be confirmed
    off_once,         ///< after it was taken over twice its register shows energised for ever
    still_turning,    ///< after a halt its register shows that it turns, for ever
    keeps_fault,
    resets_any_fault,
    mute_after_reset, ///< its feedback cannot be read; the reset does not wait for it
    // The model, the facade or the subject is wrong.
    init_forgets,       ///< the second one
    sees_no_restart,    ///< neither a witness nor the feedback
    reads_beyond,       ///< the feedback reads beyond the image
    disable_is_no_stop, ///< of the others
    refusal_sends,
    taken_over_once,
    enable_denied,  ///< the subject says that no enable can be confirmed
    cannot_turn,    ///< the subject says that `turn` cannot be confirmed
    wrong_enable,   ///< a command is refused that should enable another one
    foreign_enable, ///< another client energises the motor
    // None is wrong, but the subject has other commands.
    waits_without_move,
    long_routine,
    end
};
inline flaw present = flaw::none; ///< of the newest simulated winch
inline unsigned takes_over = 0;

class simulated : public winch::simulated {
    using base = winch::simulated;

  public:
    std::uint8_t read(std::uint16_t address, slice<std::uint16_t> to) {
        using winch::status_bits;
        if (is_mute_ && address == winch::load.address) return 4;
        const std::uint8_t refusal = base::read(address, to);
        const unsigned place = winch::status_word.address - address;
        if (address > winch::status_word.address || place >= to.size()) return refusal;
        std::uint16_t& status = to[place];
        const auto show = [&](bool is, std::uint16_t bit) {
            status = static_cast<std::uint16_t>(is ? status | bit : status & ~bit);
        };
        if (present == flaw::turns_if_restarted) show(is_turning(), status_bits::turning);
        if (present == flaw::still_turning && is_halted_) show(true, status_bits::turning);
        if (present == flaw::energised_shortly) show(on_us_ != 0 && on_us_ < 30'000, status_bits::energised);
        if (present == flaw::energised_unseen) show(false, status_bits::energised);
        if (present == flaw::off_once && sessions_ > 1) show(true, status_bits::energised);
        const bool is_seen_to_stand = starts() != 0 && !base::is_turning();
        if (is_seen_to_stand && present == flaw::turns_after_stop) turns_soon_ = true;
        if (is_seen_to_stand && present == flaw::jumps_off && shift_ == 0) jumps_soon_ = true;
        seen_ = base::is_energised() ? seen::on : seen::off;
        ++reads_;
        if (present == flaw::twitches_at_odd) twitches_ = reads_ % 2 == 1;
        if (present == flaw::twitches_at_even) twitches_ = reads_ % 2 == 0;
        return refusal;
    }
    std::uint8_t write(std::uint16_t address, words_view from) {
        if (address == winch::host_word.address) ++sessions_;
        return address == winch::control_word.address
                   ? command(static_cast<winch::control_code>(from[0]), from)
                   : base::write(address, from);
    }
    void advance(instant now) {
        const std::uint32_t passed = since(now_, now).us;
        now_ = now;
        twitches_ = false;
        const bool was_turning = base::is_turning();
        base::advance(now);
        if (on_us_ != 0) on_us_ += passed;
        if (seen_ == seen::off && present == flaw::off_late) stays_on_ = false;
        if (seen_ == seen::on) is_on_ = true;
        seen_ = seen::nothing;
        if (off_shortly_) stays_on_ = true;
        off_shortly_ = false;
        if (turns_soon_ || (present == flaw::turns_on && was_turning && !base::is_turning()))
            turns_on_ = true;
        if (jumps_soon_) shift_ = 7;
        turns_soon_ = jumps_soon_ = false;
        if (wakes_in_us_ != 0 && (wakes_in_us_ -= passed < wakes_in_us_ ? passed : wakes_in_us_) == 0)
            control(winch::control_code::hold);
    }

    void power_cycle() {
        base::power_cycle();
        turns_on_ = present == flaw::turns_if_restarted && !turns_on_;
        stays_on_ = is_halted_ = off_shortly_ = false;
        on_us_ = 0;
        ++restarts;
    }
    void end_fault_cause() {
        if (present != flaw::keeps_fault) base::end_fault_cause();
    }
    std::int64_t place() const {
        return (present == flaw::slips ? base::place() * 11 / 10 : base::place()) + shift_;
    }
    bool is_energised() const {
        if (present == flaw::energised_late) return on_us_ > 100'000;
        if (present == flaw::energised_if_seen) return is_on_ && base::is_energised();
        return present != flaw::energised_shortly && (stays_on_ || base::is_energised());
    }
    bool is_turning() const { return base::is_turning() || turns_on_ || twitches_; }
    void control(winch::control_code code) {
        const std::uint8_t word[]{0, static_cast<std::uint8_t>(code)};
        (void)base::write(winch::control_word.address, words_view{word});
    }

    unsigned restarts = 0;

  private:
    std::uint8_t command(winch::control_code code, words_view from) {
        using winch::control_code;
        const bool was_turning = base::is_turning(), was_on = base::is_energised();
        if (code == control_code::hold && !was_on) {
            if (present == flaw::never_energised) return 0;
            if (present == flaw::jerks_ahead) shift_ += 50;
            if (present == flaw::jerks_back) shift_ -= 50;
            stays_on_ =
                present == flaw::never_off || present == flaw::energised_unseen || present == flaw::off_late;
            on_us_ = 1;
            is_on_ = false;
        }
        if (code == control_code::hold && was_turning) is_halted_ = true;
        if (code == control_code::turn && present == flaw::stands) return 0;
        if (code == control_code::turn &&
            (present == flaw::twitches_at_odd || present == flaw::twitches_at_even))
            return 0;
        if (code == control_code::off) {
            if (present == flaw::wakes && was_turning) wakes_in_us_ = 300'000;
            if (present != flaw::turns_if_restarted) turns_on_ = false;
            on_us_ = 0;
            off_shortly_ = present == flaw::off_shortly && was_on;
        }
        if (code == control_code::clear_fault) {
            if (present == flaw::resets_any_fault) base::end_fault_cause();
            is_mute_ = present == flaw::mute_after_reset;
        }
        return base::write(winch::control_word.address, from);
    }

    instant now_{};
    std::int64_t shift_ = 0;
    std::uint32_t on_us_ = 0; // since it was energised
    std::uint32_t wakes_in_us_ = 0;
    unsigned sessions_ = 0, reads_ = 0;
    bool turns_on_ = false, turns_soon_ = false, jumps_soon_ = false, twitches_ = false;
    enum class seen : std::uint8_t { nothing, off, on };
    seen seen_ = seen::nothing;
    bool is_on_ = false, off_shortly_ = false;
    bool stays_on_ = false, is_halted_ = false, is_mute_ = false;
};

} // namespace flawed_winch
