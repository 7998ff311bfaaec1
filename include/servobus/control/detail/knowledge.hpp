// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The knowledge of a drive: what was read of it, whether it responds, and whether it is still the one that its settings
// describe, which the witness shows. Nothing here sends, or begins a command.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/control/detail/drive_feedback.hpp>
#include <servobus/control/routine_status.hpp>
#include <servobus/control/states.hpp>
#include <servobus/control/step.hpp>

namespace servobus::detail {

template <class Model> class knowledge : public drive_feedback<Model> {
    using base = drive_feedback<Model>;

  public:
    using prepared_command = typename Model::prepared_command;
    using polls = typename base::polls;
    using base::is_known, base::link, base::address, base::polling;

    constexpr knowledge(std::uint8_t node_address, duration feedback) : base{node_address, feedback} {}

    [[gnu::noinline]] constexpr void invalidate() { this->forget_all(); }
    /// Invalidates the settings if a command's failure leaves them uncertain: an error of the transport or of a
    /// response. `is_judged`: the error is the model's judgement of an image.
    constexpr void note_failure(const routine_status& r, bool is_judged) {
        if (is_uncertain(r, is_judged)) invalidate();
    }

    [[gnu::noinline]] constexpr bool is_refresh_due(instant now) const {
        return is_known() && polling().is_due(now, this->is_enabled(), link().watchdog());
    }

    constexpr bool is_absent() const {
        return polling().absence().is_absent() || (link().is_expired() && link().has_missed());
    }
    constexpr bool is_verified(const epoch& at) const { return is_known() && link().is_verified(at); }
    /// Returns the register that a restart would change, and its words, while `under_way` is.
    constexpr steps::recheck witness(const prepared_command& under_way) const {
        return Model::witness(this->cached(), under_way);
    }
    /// The witness holds what it should, or the drive has none in its state.
    constexpr bool is_same(words_view read, const prepared_command& under_way) const {
        const steps::recheck w = witness(under_way);
        bool is = true;
        std::size_t i = w.look != nullptr ? w.look->count : 0;
        while (i-- != 0) is = is && read[i] == w.words[i];
        return is;
    }
    template <class Line>
    [[gnu::noinline]] constexpr bool is_witness_due(const prepared_command& under_way, instant now,
                                                    const Line& on) const {
        return is_known() && witness(under_way).look != nullptr &&
               link().is_check_due(on.epoch(address()), now);
    }
    /// A position of an enabled drive counts once the image after it shows that the drive is still enabled. One of
    /// another drive counts immediately, unless it has fallen: then the witness is read first.
    constexpr bool withholds(std::uint8_t block, const std::uint16_t* words, instant began,
                             bool may_ask_witness) {
        if (block != Model::blocks.positions() || !is_known()) return false;
        if (this->is_enabled()) return true;
        if (!may_ask_witness || !this->has_fallen(block, words, began)) return false;
        link().require_check();
        return true;
    }
    constexpr void note_frame(bool has_response, bool was_sent, bool was_reading, instant began,
                              instant now) {
        if (has_response)
            link().note_response(began, now);
        else if (was_sent)
            link().note_miss();
        if (has_response || was_reading) polling().absence().count(has_response);
    }

  private:
    static constexpr bool is_uncertain(const routine_status& r, bool is_judged) {
        if (r.error() == errc::faulted || r.error() == errc::not_executed) return false;
        if (r.error() == errc::exception) return r.has_changed;
        const bool is_transport = r.error() >= errc::line_busy && r.error() <= errc::bad_gap;
        return is_transport || r.error() == errc::needs_init ||
               (r.outcome() == outcome::unknown && !is_judged);
    }
};

} // namespace servobus::detail
