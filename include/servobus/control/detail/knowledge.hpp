// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The knowledge of a drive: its settings, what was read of it and when, whether it responds and is still the one that the
// settings describe, why it stopped, and since when it moves. Nothing here sends, or begins a command.
#pragma once

#include <cstdint>

#include <servobus/control/detail/drive_link.hpp>
#include <servobus/control/detail/held_reading.hpp>
#include <servobus/control/detail/polling.hpp>
#include <servobus/control/drive_model.hpp>
#include <servobus/control/routine_status.hpp>
#include <servobus/control/states.hpp>
#include <servobus/control/step.hpp>
#include <servobus/control/supervision.hpp>

namespace servobus::detail {

template <class Model> class knowledge {
  public:
    using settings = typename Model::settings;
    using prepared_command = typename Model::prepared_command;
    using polls = detail::polling<Model>;

    constexpr knowledge(std::uint8_t node_address, duration feedback)
        : address_{node_address}, link_{Model::watchdog(Model::unknown)}, polling_{feedback} {}

    /// Zero if the device cannot have it.
    constexpr std::uint8_t address() const { return address_; }

    // --- Settings

    constexpr const settings& cached() const { return settings_; }
    constexpr settings& cached() { return settings_; }
    constexpr Model& model() { return model_; }
    constexpr const Model& model() const { return model_; }
    constexpr bool is_known() const { return settings_.state != Model::unknown.state; }
    constexpr bool is_enabled() const { return settings_.state == drive_state::enabled; }
    constexpr void invalidate() {
        is_origin_new_ = true;
        settings_ = Model::unknown;
        polling_.drop();
        held_.drop();
    }

    /// Invalidates the settings if a command's failure leaves them uncertain: an error of the transport or of a response.
    /// `is_judged`: the error is the model's judgement of an image.
    constexpr void note_failure(const routine_status& r, bool is_judged) {
        if (is_uncertain(r, is_judged)) invalidate();
    }

    // --- Readings

    constexpr polls& polling() { return polling_; }
    constexpr const polls& polling() const { return polling_; }
    constexpr held_reading& held() { return held_; }
    constexpr const held_reading& held() const { return held_; }
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
    /// Makes all readings old, since the settings have changed. They still say whether the drive has a fault.
    /// `is_taken_over`: the drive may be another one, or have restarted before.
    constexpr void drop_readings(bool is_taken_over) {
        epoch_of_positions_ = static_cast<std::uint8_t>(epoch_of_positions_ + is_taken_over);
        held_.drop();
        polling_.drop(true);
    }
    constexpr void forget_positions() {
        if constexpr (Model::blocks.positions() != 0) {
            held_.drop();
            polling_.slower().forget(Model::blocks.positions());
        }
    }
    [[gnu::noinline]] constexpr bool is_refresh_due(instant now) const {
        return is_known() && polling_.is_due(now, is_enabled(), link_.watchdog());
    }

    /// A position in an image is nearer to zero than speed and time allow: a restart puts it to zero.
    constexpr bool has_fallen(const std::uint16_t* words) const {
        const auto& before = polling_.image();
        if (!is_known() || !before.has_words || is_origin_new_) return false;
        block_reading r = reading_of(0, words, polling_.refreshed());
        r.before = before.words;
        r.between = since(before.taken, r.taken);
        return Model::has_fallen(r, settings_);
    }
    constexpr void take_image(const std::uint16_t* words, bool is_origin_new, instant now) {
        polling_.take(words);
        note(0, words, polling_.refreshed());
        is_image_of_motion_ = true;
        is_origin_new_ = is_origin_new_ && is_origin_new;
        if (since(moved_at_, now) > long_ago + long_ago) moved_at_ = instant{now.us - long_ago.us};
    }
    constexpr void take_block(std::uint8_t block, const std::uint16_t* words, instant began) {
        polling_.slower().take(block, words, began);
        note(block, words, began);
    }
    /// A position of an enabled drive counts once the image after it shows that the drive is still enabled. One of
    /// another drive counts immediately, unless it has fallen: then the witness is read first.
    constexpr bool withholds(std::uint8_t block, const std::uint16_t* words, bool may_ask_witness) {
        if (block != Model::blocks.positions() || !is_known()) return false;
        if (is_enabled()) return true;
        const auto& slower = polling_.slower();
        if (is_origin_new_ || !slower.has_words(block) || !may_ask_witness) return false;
        block_reading r = reading_of(block, words, {});
        r.before = slower.words(block);
        if (!Model::has_fallen(r, settings_)) return false;
        link_.require_check();
        return true;
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

    /// The purpose of the last frame.
    constexpr flight last_frame() const { return last_frame_; }
    constexpr void set_last_frame(flight was) { last_frame_ = was; }

    // --- The link and the witness

    constexpr drive_link<polls::has_watchdog>& link() { return link_; }
    constexpr const drive_link<polls::has_watchdog>& link() const { return link_; }
    constexpr bool is_absent() const {
        return polling_.absence().is_absent() || (link_.is_expired() && link_.has_missed());
    }
    constexpr bool is_verified(const epoch& at) const { return is_known() && link_.is_verified(at); }
    /// Returns the register that a restart would change, and its words, while `under_way` is.
    constexpr steps::recheck witness(const prepared_command& under_way) const {
        return model_.witness(settings_, under_way);
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
    constexpr void note_frame(bool has_response, bool was_sent, bool was_reading, instant began,
                              instant now) {
        if (has_response)
            link_.note_response(began, now);
        else if (was_sent)
            link_.note_miss();
        if (has_response || was_reading) polling_.absence().count(has_response);
    }

    // --- The motion

    constexpr stop_cause cause() const { return cause_; }
    constexpr void set_cause(stop_cause c) { cause_ = c; }
    /// The first cause counts.
    constexpr void note_cause(stop_cause c) {
        if (cause_ == stop_cause::unknown) cause_ = c;
    }
    constexpr void note_motion(instant now) {
        moved_at_ = now;
        is_image_of_motion_ = false;
    }
    /// From `from`, a moment ago, to the image.
    constexpr duration until_image(instant from) const {
        const instant taken = polling_.image().taken;
        return went_back(from, taken) ? duration{} : since(from, taken);
    }
    /// From the start of the last motion to the image; zero for an image that is older. It goes back from two minutes
    /// to one: times are not compared over a wrap of the clock.
    constexpr duration since_start() const {
        return is_image_of_motion_ ? until_image(moved_at_) : duration{};
    }
    /// Positions may be counted from elsewhere since the image.
    constexpr void note_origin() { is_origin_new_ = true; }
    /// Another number: positions may be counted from elsewhere since.
    constexpr std::uint8_t epoch_of_positions() const { return epoch_of_positions_; }

  private:
    // While a command sets an origin each reading may count from another one.
    constexpr void note(std::uint8_t block, const std::uint16_t* words, instant taken) {
        epoch_of_positions_ = static_cast<std::uint8_t>(epoch_of_positions_ + is_origin_new_);
        model_.note(reading_of(block, words, taken), settings_);
    }
    constexpr block_reading reading_of(std::uint8_t block, const std::uint16_t* words, instant taken) const {
        return {.block = block, .words = words, .taken = taken, .epoch = epoch_of_positions_};
    }
    static constexpr bool is_uncertain(const routine_status& r, bool is_judged) {
        if (r.error() == errc::faulted || r.error() == errc::not_executed) return false;
        if (r.error() == errc::exception) return r.has_changed;
        const bool is_transport = r.error() >= errc::line_busy && r.error() <= errc::bad_gap;
        return is_transport || r.error() == errc::needs_init ||
               (r.outcome() == outcome::unknown && !is_judged);
    }
    static constexpr duration long_ago = milliseconds(60'000);

    // The bytes first: short instructions of a small core reach no further.
    std::uint8_t address_;
    flight last_frame_ = flight::none;
    stop_cause cause_ = stop_cause::unknown;
    bool is_image_of_motion_ = false; // the image was read after the last motion command
    bool is_origin_new_ = false;
    std::uint8_t epoch_of_positions_ = 0;
    held_reading held_{};
    settings settings_ = Model::unknown;
    drive_link<polls::has_watchdog> link_;
    polls polling_;
    instant moved_at_{}; // when the last motion command ended
    [[no_unique_address]] Model model_{};
};

} // namespace servobus::detail
