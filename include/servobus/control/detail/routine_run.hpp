// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A routine under way: which step is due, what its reads gave, and how it ended. It sends nothing itself: its
// owner sends the step, or reads the process image, and passes on how the frame ended.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/control/detail/stop_retry.hpp>
#include <servobus/control/image.hpp>
#include <servobus/control/routine_status.hpp>
#include <servobus/control/step.hpp>
#include <servobus/modbus/exchange.hpp>

namespace servobus::detail {

class routine_run {
  public:
    constexpr bool is_over() const { return size_ == 0; }
    /// Its responses may have been the echo of its requests: it has not succeeded.
    constexpr void note_possible_echo() {
        if (result_) result_.status.end(errc::own_echo);
    }
    /// Meaningful once it is over.
    constexpr const routine_status& result() const { return result_; }
    /// What the fetch steps read.
    constexpr slice<const std::uint16_t> words() const { return words_; }

    constexpr const servobus::step& current() const { return *current_; }
    constexpr bool is_at_stop() const { return !is_over() && current().is_repeatable; }
    /// The stops with which a routine begins go before all other traffic, as long as frames of that kind are left.
    constexpr bool is_urgent() const { return is_leading_ && urgent_left_ != 0; }
    constexpr std::uint8_t urgent_left() const { return urgent_left_; }
    /// The step waits for a state, and the last read did not show it.
    constexpr bool is_waiting() const { return is_waiting_; }

    /// `arguments` must outlive the run. `is_follow_up`: what the routine before has written counts.
    constexpr void begin(routine table, const steps::arguments& arguments, std::uint16_t shift,
                         duration limit, std::uint8_t urgent, bool is_follow_up, instant now) {
        current_ = table.data();
        size_ = static_cast<std::uint8_t>(table.size());
        arguments_ = &arguments;
        shift_ = shift;
        limit_ = limit;
        urgent_left_ = urgent;
        is_leading_ = true;
        has_written_ = has_written_ && is_follow_up;
        missed_ = {};
        at_ = 0;
        result_ = {};
        enter(now);
    }
    /// When the step under way began.
    constexpr instant entered() const { return entered_; }
    /// The drive was enabled: its targets are zero.
    constexpr void note_zero_targets() { last_ = {}; }
    constexpr void end(errc why, bool was_written) {
        has_written_ = has_written_ || was_written;
        end(status{why});
    }

    /// The step's request, which needs no check: the compiler has checked the step. Returns its length.
    constexpr std::size_t put_request(byte_buffer pdu) const {
        using modbus::function;
        const servobus::step& s = current();
        const auto address = static_cast<std::uint16_t>(s.address + (s.is_element ? shift_ : 0));
        const bool is_read = s.what != servobus::step::kind::write || check_ != check::none;
        const function code = is_read        ? function::read_holding_registers
                              : s.count == 1 ? function::write_single_register
                                             : function::write_multiple_registers;
        modbus::put_trusted_request(pdu, code, address,
                                    code == function::write_single_register ? word_for(0) : s.count);
        if (code != function::write_multiple_registers) return 5;
        pdu[5] = static_cast<std::uint8_t>(2 * s.count);
        for (std::size_t i = 0; i < s.count; ++i) store_word(pdu, 6 + 2 * i, word_for(i));
        return 6u + 2u * s.count;
    }

    /// The frame of the step has ended.
    constexpr void conclude(const modbus::exchange& x, const response_limits& limits, std::uint8_t retries,
                            instant now) {
        const bool is_write = current().what == servobus::step::kind::write;
        const bool had_written = has_written_;
        has_written_ = has_written_ || (is_write && x.was_sent());
        if (current().is_repeatable) return conclude_stop(x, had_written, now);
        if (check_ != check::none) return conclude_read_back(x, limits, retries);
        if (x.status().error() != errc::ok) {
            if (!is_write) return fail_read(x.status(), limits, retries);
            if (!current().is_setpoint || !x.was_sent() || !may_be_read_back(x.status().error()))
                return end(x.status(), had_written);
            check_ = check::due;
            write_failure_ = x.status();
            return;
        }
        if (is_write) return go_on(now);
        std::uint16_t got[steps::longest]; // NOLINT: as many as are used are filled
        const words_view words = x.words();
        for (std::size_t i = 0; i < current().count; ++i) got[i] = words[i];
        (void)use(got, now);
    }
    /// A read that the step depends on got no valid response: it is repeated, or ends the routine.
    constexpr void fail_read(const status& why, const response_limits& limits, std::uint8_t retries) {
        // An exception for a damaged request counts as no response.
        const bool came_damaged = why.exception() != 0 && why.exception() == limits.corrupted_request;
        const bool may_repeat = why.error() != errc::exception || came_damaged;
        if (!may_repeat || tries_ > retries || why.error() == errc::port_lost)
            return end(check_ != check::none ? write_failure_ : why, has_written_);
        ++tries_;
        if (check_ != check::none) check_ = check::due; // both reads are to be of one epoch
    }
    /// A setpoint got no response: it is to be read back, and the witness after it.
    constexpr bool is_read_back_due() const { return check_ == check::due; }
    /// For that, or for a step that asks for it.
    constexpr bool awaits_witness() const {
        return check_ == check::as_written || check_ == check::as_before || is_at_witness();
    }
    /// The witness shows that the drive has not restarted.
    constexpr void conclude_witness(instant now) {
        if (is_at_witness()) return go_on(now);
        if (check_ == check::none) return;
        if (check_ == check::as_before) return end(status::sent(errc::not_executed), true);
        check_ = check::none;
        go_on(now);
    }
    constexpr void note_valid_read() { tries_ = 1; }

    constexpr bool reads(const register_block& of) const {
        if (is_over() || current().what == servobus::step::kind::write) return false;
        if (is_at_witness()) return false;
        return asks_model() || (!current().is_element && of.contains(current().address, current().count));
    }
    constexpr bool is_at_permit() const {
        return !is_over() && current().what == servobus::step::kind::permit;
    }
    constexpr bool is_at_witness() const {
        return !is_over() && current().what == servobus::step::kind::witness;
    }
    /// The step is the drive's model's to decide, by the process image.
    constexpr bool asks_model() const {
        return is_at_permit() || (!is_over() && current().what == servobus::step::kind::confirm);
    }
    /// What the model says: ok, `busy` while it is still possible, or the error.
    constexpr void conclude_question(errc found, instant now) {
        tries_ = 1;
        if (found == errc::ok) return go_on(now);
        is_waiting_ = true;
        if (found != errc::busy || since(entered_, now) >= limit_of(current()))
            end(status{found == errc::busy && !is_at_permit() ? current().otherwise : found});
    }
    /// Nothing is left to do.
    constexpr void finish() { end(status{}); }
    constexpr bool has_written() const { return has_written_; }
    /// One read of the process image serves all adjacent steps that read from it.
    constexpr void use_image(const std::uint16_t* words, const register_block& of, instant now) {
        while (reads(of) && !asks_model()) {
            if (!use(words + (current().address - of.address), now)) return;
        }
    }

  private:
    // Whether a setpoint that got no response was carried out.
    enum class check : std::uint8_t { none, due, as_written, as_before };
    /// The last one that was.
    struct setpoint {
        std::uint16_t address = 0;
        std::uint16_t words[2]{}; // zero after an enable
    };

    static constexpr bool may_be_read_back(errc e) { return e >= errc::partial_send && e != errc::port_lost; }
    constexpr void conclude_read_back(const modbus::exchange& x, const response_limits& limits,
                                      std::uint8_t retries) {
        if (x.status().error() != errc::ok) return fail_read(x.status(), limits, retries);
        const bool is_known =
            current().count <= 2 && (last_.address == current().address || last_.address == 0);
        const words_view words = x.words();
        bool is_new = true;
        bool is_old = is_known;
        for (std::size_t i = 0; i < current().count; ++i) {
            is_new = is_new && words[i] == word_for(i);
            is_old = is_old && words[i] == last_.words[i & 1u];
        }
        if (!is_new && !is_old) return end(write_failure_, has_written_);
        check_ = is_new ? check::as_written : check::as_before;
    }

    // False if the step is not done with it.
    constexpr bool use(const std::uint16_t* got, instant now) {
        const servobus::step& s = current();
        tries_ = 1;
        if (s.what == servobus::step::kind::fetch) {
            for (std::size_t i = 0; i < s.count; ++i) words_[s.slot + i] = got[i];
        } else if (!holds(got)) {
            is_waiting_ = true;
            if (missed_.error() != errc::ok) {
                end(missed_, true); // to be stopped again, not waited for
            } else if (s.what != servobus::step::kind::until || since(entered_, now) >= limit_of(s)) {
                end(status{s.otherwise});
            }
            return false;
        }
        go_on(now);
        return true;
    }

    constexpr void enter(instant now) {
        tries_ = 1;
        check_ = check::none;
        is_waiting_ = false;
        entered_ = now;
        if (current().is_repeatable) {
            stops_.begin(current_, at_, size_);
        } else {
            is_leading_ = false;
        }
    }
    constexpr void go_on(instant now) {
        if (current().is_setpoint && current().count <= 2)
            last_ = {current().address, {word_for(0), word_for(current().count - 1u)}};
        if (is_last() || is_barred(current_[1])) return end(status{});
        go_to(static_cast<std::uint8_t>(at_ + 1));
        enter(now);
    }
    constexpr bool is_last() const { return at_ + 1u == size_; }
    constexpr void go_to(std::uint8_t step) {
        current_ += step - at_;
        at_ = step;
    }
    // After a stop that got no response nothing is written but stops.
    constexpr bool is_barred(const servobus::step& s) const {
        return missed_.error() != errc::ok && s.what == servobus::step::kind::write && !s.is_repeatable;
    }

    constexpr void conclude_stop(const modbus::exchange& x, bool had_written, instant now) {
        const status& why = x.status();
        if (x.was_sent() && urgent_left_ != 0) --urgent_left_;
        if (why.error() == errc::port_lost) return end(why, had_written);
        if (why.error() != errc::ok) stop_failure_ = why;
        if (stops_.conclude(why.error() == errc::ok)) {
            go_to(stops_.at());
            return;
        }
        go_to(stops_.last());
        const bool is_last_stop = is_last() || !current_[1].is_repeatable;
        if (is_last_stop && !stops_.is_any_confirmed()) return end(why, had_written);
        if (stops_.is_any_missed() && missed_.error() == errc::ok) missed_ = stop_failure_;
        go_on(now);
    }

    constexpr void end(status why, bool has_changed = false) {
        if (why.error() == errc::ok && missed_.error() != errc::ok) {
            why = missed_;
            has_changed = true; // the stops after it
        }
        result_ = {why.with_sent(has_written_), at_, has_changed};
        check_ = check::none;
        size_ = 0;
    }

    constexpr std::uint16_t word_for(std::size_t i) const {
        const servobus::step& s = current();
        return s.slot == servobus::step::constant ? s.value : (*arguments_)[s.slot + i];
    }
    constexpr duration limit_of(const servobus::step& s) const {
        return s.limit_ms == servobus::step::commanded_limit ? limit_ : milliseconds(s.limit_ms);
    }
    constexpr bool holds(const std::uint16_t* got) const {
        for (std::size_t i = 0; i < current().count; ++i) {
            if (!holds(got[i], word_for(i))) return false;
        }
        return true;
    }
    constexpr bool holds(std::uint16_t got, std::uint16_t wanted) const {
        if (!current().is_within) return ((got ^ wanted) & current().mask) == 0;
        const auto value = static_cast<std::int16_t>(got);
        const auto most = static_cast<std::int32_t>(wanted);
        return value <= most && value >= -most;
    }

    // The bytes first: short instructions of a small core reach no further.
    std::uint8_t at_ = 0;
    std::uint8_t size_ = 0; // steps; 0 when it is over
    std::uint8_t tries_ = 0;
    std::uint8_t urgent_left_ = 0;
    check check_ = check::none;
    bool is_leading_ = false; // nothing but stops so far
    bool has_written_ = false;
    bool is_waiting_ = false;
    std::uint16_t shift_ = 0;
    const servobus::step* current_ = nullptr;
    const steps::arguments* arguments_ = nullptr;
    duration limit_{};
    instant entered_{};
    routine_status result_{};
    status stop_failure_{};
    status write_failure_{}; // of a setpoint that is read back
    status missed_{};        // a stop that got no response, while others did
    stop_retry stops_{};
    setpoint last_{};
    std::uint16_t words_[steps::max_words]{};
};

} // namespace servobus::detail
