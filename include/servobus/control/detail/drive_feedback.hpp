// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The feedback of a drive, what it shows, and the settings that were learned from it. Feedback that may be of another
// life of the drive is held back. Nothing here sends.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/control/detail/drive_link.hpp>
#include <servobus/control/detail/held_feedback.hpp>
#include <servobus/control/detail/last_motion.hpp>
#include <servobus/control/detail/polling.hpp>
#include <servobus/control/drive_model.hpp>
#include <servobus/control/states.hpp>
#include <servobus/control/step.hpp>

namespace servobus::detail {

template <class Model> class drive_feedback : public last_motion {
  public:
    using settings = typename Model::settings;
    using polls = detail::polling<Model>;

    /// Zero if the device cannot have it.
    constexpr std::uint8_t address() const { return address_; }
    constexpr drive_link<polls::has_watchdog>& link() { return link_; }
    constexpr const drive_link<polls::has_watchdog>& link() const { return link_; }
    /// The purpose of the last frame.
    constexpr flight last_frame() const { return last_frame_; }
    constexpr void set_last_frame(flight was) { last_frame_ = was; }

    constexpr const settings& cached() const { return settings_; }
    constexpr settings& cached() { return settings_; }
    constexpr Model& model() { return model_; }
    constexpr const Model& model() const { return model_; }
    constexpr bool is_known() const { return settings_.state != Model::unknown.state; }
    constexpr bool is_enabled() const { return settings_.state == drive_state::enabled; }
    constexpr polls& polling() { return polling_; }
    constexpr const polls& polling() const { return polling_; }
    constexpr held_feedback& held() { return held_; }
    constexpr const held_feedback& held() const { return held_; }
    constexpr const std::uint16_t* image() const { return polling_.image().words; }
    constexpr bool is_faulted() const {
        return polling_.image().has_words && Model::is_faulted(image(), settings_);
    }
    /// `faulted` if the last feedback shows a fault.
    constexpr drive_state state() const {
        return is_known() && is_faulted() ? drive_state::faulted : settings_.state;
    }
    constexpr bool is_young(duration oldest, instant now) const {
        const auto& read = polling_.image();
        return read.has_words && !read.is_old && since(read.taken, now) <= oldest;
    }
    /// Makes all feedback old, since the settings have changed. The image still says whether the drive has a fault.
    /// `is_taken_over`: the drive may be another one, or have restarted before.
    constexpr void drop_feedback(bool is_taken_over) {
        if (is_taken_over) {
            is_origin_new_ = false;
            ++epoch_of_positions_;
        }
        held_.drop();
        polling_.drop(true);
    }
    constexpr void forget_positions() {
        if constexpr (Model::blocks.positions() != 0) {
            held_.drop();
            polling_.slower().forget(Model::blocks.positions());
        }
    }
    /// A position in an image is nearer to zero than speed and time allow: a restart puts it to zero.
    constexpr bool has_fallen(const std::uint16_t* words) const {
        const auto& before = polling_.image();
        if (!is_known() || !before.has_words || is_origin_new_) return false;
        block_feedback r = feedback_of(0, words, polling_.refreshed());
        r.before = before.words;
        r.between = since(before.taken, r.taken);
        return model_.has_fallen(r, settings_);
    }
    constexpr void take_image(const std::uint16_t* words, instant now) {
        polling_.take(words);
        last_motion::note_image(now);
    }
    /// The model is told of an image that was taken. `is_origin_open`: the next one may be counted from elsewhere too.
    constexpr void note_image(bool is_origin_open) {
        note(0, image(), polling_.image().taken);
        is_origin_new_ = is_origin_new_ && is_origin_open;
    }
    constexpr void take_block(std::uint8_t block, const std::uint16_t* words, instant began) {
        polling_.slower().take(block, words, began);
        note(block, words, began);
    }
    /// A position in a block of its own is nearer to zero than before.
    constexpr bool has_fallen(std::uint8_t block, const std::uint16_t* words, instant began) const {
        const auto& slower = polling_.slower();
        if (is_origin_new_ || !slower.has_words(block)) return false;
        block_feedback r = feedback_of(block, words, began);
        r.before = slower.words(block);
        r.between = since(slower.taken(block), began);
        return model_.has_fallen(r, settings_);
    }
    /// The block that was held back counts from now on.
    constexpr void take_held_block(const std::uint8_t* response) {
        constexpr std::uint8_t block = Model::blocks.positions();
        if constexpr (block != 0) {
            if (!held_.is_block()) return;
            std::uint16_t words[steps::longest]; // NOLINT
            for (std::size_t i = 0; i < Model::blocks[block].words; ++i) words[i] = held_.words(response)[i];
            take_block(block, words, polling_.slower().held_at());
            held_.drop();
        }
    }

    /// From `from`, a moment ago, to the image.
    constexpr duration until_image(instant from) const {
        const instant taken = polling_.image().taken;
        return went_back(from, taken) ? duration{} : since(from, taken);
    }
    constexpr duration since_start() const { return last_motion::since_start(polling_.image().taken); }
    /// Positions may be counted from elsewhere since the image.
    constexpr void note_origin() { is_origin_new_ = true; }
    /// Another number: positions may be counted from elsewhere since.
    constexpr std::uint16_t epoch_of_positions() const { return epoch_of_positions_; }

  protected:
    constexpr drive_feedback(std::uint8_t node_address, duration feedback)
        : address_{node_address}, link_{Model::watchdog(Model::unknown)}, polling_{feedback} {}

    constexpr void forget_all() {
        is_origin_new_ = true;
        settings_ = Model::unknown;
        polling_.drop();
        held_.drop();
    }

  private:
    // While a command sets an origin each refresh may count from another one.
    constexpr void note(std::uint8_t block, const std::uint16_t* words, instant taken) {
        epoch_of_positions_ = static_cast<std::uint16_t>(epoch_of_positions_ + is_origin_new_);
        model_.note(feedback_of(block, words, taken), settings_);
    }
    constexpr block_feedback feedback_of(std::uint8_t block, const std::uint16_t* words,
                                         instant taken) const {
        return {.block = block, .words = words, .taken = taken, .epoch = epoch_of_positions_};
    }

    // The bytes first: short instructions of a small core reach no further.
    std::uint8_t address_;
    flight last_frame_ = flight::none;
    bool is_origin_new_ = false;
    held_feedback held_{};
    settings settings_ = Model::unknown;
    drive_link<polls::has_watchdog> link_;
    polls polling_;
    [[no_unique_address]] Model model_{};
    std::uint16_t epoch_of_positions_ = 0;
};

} // namespace servobus::detail
