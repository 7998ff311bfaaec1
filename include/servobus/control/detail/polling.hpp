// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// When a facade reads the feedback of its drive, and what it read: the process image, with its slower blocks.
// A drive without a watchdog that does not respond is read less often.
//
//     present --three reads in a row without a response--> absent --a response--> present
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/control/image.hpp>
#include <servobus/control/supervision.hpp>
#include <servobus/core/time.hpp>

namespace servobus::detail {

/// Of a drive that is polled as long as its state is known, also while it does not respond. One with a watchdog is
/// not: its state is unknown as soon as the watchdog's time has passed.
template <bool BacksOff> class back_off_counter {
  public:
    static constexpr bool is_absent() { return false; }
    static constexpr bool is_early(instant, instant) { return false; }
    static constexpr void count(bool) {}
    static constexpr void set_period(duration) {}
};
template <> class back_off_counter<true> {
  public:
    constexpr bool is_absent() const { return misses_ >= misses_until_absent; }
    /// It is absent, and was read at `then`.
    constexpr bool is_early(instant then, instant now) const {
        return is_absent() && since(then, now) < retry_every_;
    }
    constexpr void count(bool has_response) {
        if (has_response) {
            misses_ = 0;
        } else if (!is_absent()) {
            ++misses_;
        }
    }
    constexpr void set_period(duration every) { retry_every_ = every; }

  private:
    static constexpr std::uint8_t misses_until_absent = 3;
    duration retry_every_ = milliseconds(1000);
    std::uint8_t misses_ = 0;
};

template <class Model> class polling {
  public:
    static constexpr bool has_slower = requires { Model::slower; };
    static constexpr bool has_watchdog = watchdog_of<Model>(Model::unknown) != duration{};
    static constexpr bool backs_off = !has_watchdog;

    /// 0: never.
    constexpr explicit polling(duration every) { set_period(every); }

    constexpr bool is_on() const { return every_ != never; }
    constexpr duration period() const { return every_; }
    constexpr void set_period(duration every) { every_ = every == duration{} ? never : every; }
    /// Of the steps of a routine that wait for a state.
    constexpr duration wait_period() const { return is_on() ? every_ : milliseconds(20); }
    /// When the image was read last, or was tried to be.
    constexpr instant refreshed() const { return refreshed_; }
    constexpr bool waited_too_little(instant now) const { return since(refreshed_, now) < wait_period(); }

    constexpr const process_image<Model::image.words>& image() const { return image_; }
    constexpr const slower_blocks<Model>& slower() const { return slower_; }
    constexpr const back_off_counter<backs_off>& absence() const { return absence_; }
    constexpr back_off_counter<backs_off>& absence() { return absence_; }

    constexpr bool is_image_due(instant now) const { return since(refreshed_, now) >= every_; }
    constexpr bool is_slower_due() const {
        if constexpr (has_slower) {
            return slower_.is_due();
        } else {
            return false;
        }
    }
    /// `is_kept_alive`: reads are to keep the drive's `watchdog` from expiring.
    constexpr bool is_due(instant now, bool is_kept_alive, duration watchdog) const {
        if (absence_.is_early(refreshed_, now)) return false;
        const duration age = since(refreshed_, now);
        if (age >= every_ || is_slower_due()) return true;
        return has_watchdog && is_kept_alive && age.us > watchdog.us >> 2 && is_on(); // four times within it
    }
    /// A step of the routine waits for a slower block that was read just now.
    template <class Run> constexpr bool is_early_for(const Run& run, instant now) const {
        return run.is_waiting() && since(slower_.taken(slower_.block_for(run)), now) < wait_period();
    }
    template <class Run> constexpr bool is_slower_for(const Run& run) const {
        return slower_.block_for(run) != slower_.none;
    }
    /// The block that the next frame reads. `is_image_first`: the image, if both are due.
    template <class Run> constexpr register_block choose(const Run& run, bool is_image_first) {
        if constexpr (has_slower) {
            return slower_.choose(run, is_image_first);
        } else {
            return Model::image;
        }
    }

    /// A frame that reads neither block ended.
    constexpr void postpone(instant now) { refreshed_ = now; }
    /// A step of the routine waits for a register outside of it. Where nothing is polled, its own reads keep the pace.
    constexpr void note_wait(instant now) {
        if (!is_on()) refreshed_ = now;
    }
    template <class Exchange> constexpr void take(const Exchange& x, instant began) {
        for (std::size_t i = 0; i < Model::image.words; ++i) image_.words[i] = x.words()[i];
        image_.taken = refreshed_ = began;
        image_.has_words = true;
        image_.is_old = false;
        if constexpr (has_slower) {
            if (is_on()) slower_.count_image();
        }
    }
    constexpr slower_blocks<Model>& slower() { return slower_; }
    /// What was read is that of another drive state, or of before a restart.
    constexpr void drop() {
        image_.has_words = false;
        if constexpr (has_slower) slower_.drop();
    }
    /// Before the clock wraps, so that an old image does not look like a new one.
    constexpr void note_age(instant now) {
        if constexpr (backs_off) image_.is_old = image_.is_old || since(image_.taken, now) >= oldest;
    }

  private:
    static constexpr duration oldest = milliseconds(1'800'000);
    static constexpr duration never{0xFFFF'FFFF}; // longer than any time that a clock of 32 bits can tell

    duration every_{};
    instant refreshed_{};
    process_image<Model::image.words> image_{};
    [[no_unique_address]] slower_blocks<Model> slower_{};
    [[no_unique_address]] back_off_counter<backs_off> absence_{};
};

} // namespace servobus::detail
