// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The knowledge of a drive: its settings, its feedback, its last motion, and whether it responds. The witness shows
// whether it is still the drive that the settings describe. Nothing here sends, or begins a command.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/control/command_status.hpp>
#include <servobus/control/detail/drive_feedback.hpp>
#include <servobus/control/detail/drive_link.hpp>
#include <servobus/control/detail/last_motion.hpp>
#include <servobus/control/detail/unwatched_motion.hpp>
#include <servobus/control/states.hpp>
#include <servobus/control/step.hpp>

namespace servobus::detail {

template <class Model> class knowledge {
  public:
    using prepared_command = typename Model::prepared_command;
    using settings = typename Model::settings;
    using polls = detail::polling<Model>;

    constexpr knowledge(std::uint8_t node_address, duration every)
        : address_{node_address}, link_{Model::watchdog(Model::unknown)}, feedback_{every} {}

    /// Zero if the device cannot have it.
    constexpr std::uint8_t address() const { return address_; }

    // --- Its parts

    constexpr drive_link<polls::has_watchdog>& link() { return link_; }
    constexpr const drive_link<polls::has_watchdog>& link() const { return link_; }
    constexpr drive_feedback<Model>& feedback() { return feedback_; }
    constexpr const drive_feedback<Model>& feedback() const { return feedback_; }
    constexpr last_motion& motion() { return motion_; }
    constexpr const last_motion& motion() const { return motion_; }
    constexpr unwatched_motion<polls::has_watchdog>& unwatched() { return unwatched_; }
    constexpr Model& model() { return model_; }
    constexpr const Model& model() const { return model_; }
    constexpr polls& polling() { return feedback_.polling(); }
    constexpr const polls& polling() const { return feedback_.polling(); }

    // --- The settings

    constexpr const settings& cached() const { return settings_; }
    constexpr settings& cached() { return settings_; }
    constexpr bool is_known() const { return settings_.state != Model::unknown.state; }
    constexpr bool is_enabled() const { return settings_.state == drive_state::enabled; }
    constexpr bool is_faulted() const {
        return feedback_.has_image() && Model::is_faulted(feedback_.image(), settings_);
    }
    /// `faulted` if the last feedback shows a fault.
    constexpr drive_state state() const {
        return is_known() && is_faulted() ? drive_state::faulted : settings_.state;
    }
    [[gnu::noinline]] constexpr void invalidate() {
        settings_ = Model::unknown;
        feedback_.forget();
    }
    /// Invalidates the settings if a command's failure leaves them uncertain: an error of the transport or of a
    /// response. `is_judged`: the error is the model's judgement of an image.
    constexpr void note_failure(const command_status& r, bool is_judged) {
        if (is_uncertain(r, is_judged)) invalidate();
    }

    // --- Whether it is still that drive

    constexpr bool is_absent() const {
        return polling().absence().is_absent() || (link_.is_expired() && link_.has_missed());
    }
    constexpr bool is_verified(const epoch& at) const { return is_known() && link_.is_verified(at); }
    /// Returns the register that a restart would change, and its words, while `under_way` is.
    constexpr steps::recheck witness(const prepared_command& under_way) const {
        return Model::witness(settings_, under_way);
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
               link_.is_check_due(on.epoch(address_), now);
    }
    [[gnu::noinline]] constexpr bool is_refresh_due(instant now) const {
        return is_known() && polling().is_due(now, is_enabled(), link_.watchdog());
    }

    // --- What has come

    constexpr void note_frame(bool has_response, bool was_sent, bool was_reading, instant began,
                              instant now) {
        if (has_response)
            link_.note_response(began, now);
        else if (was_sent)
            link_.note_miss();
        if (has_response || was_reading) polling().absence().count(has_response);
    }
    /// A position in an image is nearer to zero than speed and time allow: a restart puts it to zero.
    constexpr bool has_fallen(const std::uint16_t* words) const {
        if (!is_known() || !feedback_.has_image() || feedback_.is_origin_new()) return false;
        block_feedback r = feedback_.block_of(0, words, polling().refreshed());
        r.before = feedback_.image();
        r.between = since(feedback_.taken(), r.taken);
        return model_.has_fallen(r, settings_);
    }
    constexpr void take_image(const std::uint16_t* words, instant now) {
        polling().take(words);
        motion_.note_image(now);
    }
    /// Gives the model an image that was taken. `is_origin_open`: the next one may be counted from elsewhere too.
    constexpr void note_image(bool is_origin_open) {
        note(0, feedback_.image(), feedback_.taken());
        feedback_.end_image(is_origin_open);
    }
    /// A position of an enabled drive counts once the image after it shows that the drive is still enabled. One of
    /// another drive counts immediately, unless it has fallen: then the witness is read first.
    constexpr bool withholds(std::uint8_t block, const std::uint16_t* words, instant began,
                             bool may_ask_witness) {
        if (block != Model::blocks.positions() || !is_known()) return false;
        if (is_enabled()) return true;
        if (!may_ask_witness || !has_block_fallen(block, words, began)) return false;
        link_.require_check();
        return true;
    }
    constexpr void take_block(std::uint8_t block, const std::uint16_t* words, instant began) {
        polling().slower().take(block, words, began);
        note(block, words, began);
    }
    /// The block that was held back counts from now on.
    constexpr void take_held_block(const std::uint8_t* response) {
        constexpr std::uint8_t block = Model::blocks.positions();
        if constexpr (block != 0) {
            held_feedback& held = feedback_.held();
            if (!held.is_block()) return;
            std::uint16_t words[steps::longest]; // NOLINT
            for (std::size_t i = 0; i < Model::blocks[block].words; ++i) words[i] = held.words(response)[i];
            take_block(block, words, polling().slower().held_at());
            held.drop();
        }
    }
    constexpr duration since_start() const { return motion_.since_start(feedback_.taken()); }
    constexpr servobus::last_frame last_frame() const { return last_; }
    constexpr void set_last_frame(servobus::last_frame was) { last_ = was; }

  private:
    constexpr void note(std::uint8_t block, const std::uint16_t* words, instant taken) {
        model_.note(feedback_.next_block(block, words, taken), settings_);
    }
    // A position in a block of its own is nearer to zero than before.
    constexpr bool has_block_fallen(std::uint8_t block, const std::uint16_t* words, instant began) const {
        const auto& slower = polling().slower();
        if (feedback_.is_origin_new() || !slower.has_words(block)) return false;
        block_feedback r = feedback_.block_of(block, words, began);
        r.before = slower.words(block);
        r.between = since(slower.taken(block), began);
        return model_.has_fallen(r, settings_);
    }
    static constexpr bool is_uncertain(const command_status& r, bool is_judged) {
        if (r.error() == errc::faulted || r.error() == errc::not_executed) return false;
        if (r.error() == errc::exception) return r.has_changed();
        const bool is_transport = r.error() >= errc::line_busy && r.error() <= errc::bad_gap;
        return is_transport || r.error() == errc::needs_init ||
               (r.outcome() == outcome::unknown && !is_judged);
    }

    // The bytes first: short instructions of a small core reach no further.
    [[no_unique_address]] last_motion motion_{}; // two bytes are left in it
    std::uint8_t address_;
    servobus::last_frame last_ = servobus::last_frame::other;
    settings settings_ = Model::unknown;
    [[no_unique_address]] drive_link<polls::has_watchdog> link_;
    [[no_unique_address]] drive_feedback<Model> feedback_;
    [[no_unique_address]] Model model_{};
    [[no_unique_address]] unwatched_motion<polls::has_watchdog> unwatched_{};
};

} // namespace servobus::detail
