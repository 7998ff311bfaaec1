// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the stepped calls of a client share, whatever register they are for: one copy of it in the program
// for each type of client.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/client/raw_client.hpp>

namespace servobus::detail {

/// One call at a time: requests of one node, stepped to their end. `Raw` is the client's base.
template <class Raw> class stepped_request {
    using line_type = typename Raw::line_type;
    static_assert(!line_type::is_small, "a blocking_line has blocking calls only: stepped calls need a line");

  public:
    // The line and the exchange keep its address while the call is under way.
    stepped_request(const stepped_request&) = delete;
    stepped_request& operator=(const stepped_request&) = delete;
    constexpr ~stepped_request() { cancel(); }

    /// True if no call is under way: it has ended, or none was begun yet.
    constexpr bool done() const { return stage_ == stage::ended; }
    /// How the last call ended; `busy` while one is under way, `bad_argument` before the first.
    constexpr servobus::status status() const { return done() ? status_ : servobus::status{errc::busy}; }

    /// Gives the call up. What has left is not called back: the status is then `timeout` (outcome unknown),
    /// else `busy` (nothing was sent), or `own_echo` where only the check of a write was left. The line stays
    /// in order, also if the object is destroyed.
    constexpr void cancel() {
        if (done()) return;
        raw_->line_->abandon(exchange_);
        if (stage_ == stage::checking) return end(servobus::status::sent(errc::own_echo));
        const servobus::status why = exchange_.status();
        if (stage_ == stage::writing) raw_->invalidate(invalidated_);
        end(stage_ == stage::asking_first ? servobus::status{errc::busy} : why);
    }

  protected:
    static constexpr bool has_tokens = Raw::has_tokens;

    constexpr explicit stepped_request(Raw& client) : raw_{&client} {}

    /// `response` has room for the whole response and remains until the end. Errors: `busy` while a call is
    /// under way, which goes on; `bad_argument`.
    constexpr errc begin_read(byte_buffer response, u16 address,
                              modbus::function code = modbus::function::read_holding_registers) {
        if (!done()) return errc::busy;
        const auto words = static_cast<u16>((response.size() - 5) / 2);
        const auto request = modbus::read_frame<crc>(raw_->node_.address, address, words, code);
        if (!raw_->node_.is_valid() || request.size == 0) return refused(errc::bad_argument);
        copy(request);
        response_ = response;
        attempts_ = 0;
        return begin(stage::reading, bytes{request_}, response_);
    }

    /// What a write depends on until it leaves.
    struct condition {
        word_order order = word_order::unknown; ///< of its 32-bit values
        servobus::ram_only token{};
        bool needs_token = false;
    };
    /// `request` is the whole frame and remains until the end; its memory takes the response too.
    /// `asks_first`: a response that may be an echo must be ruled out before it leaves, not after it.
    constexpr errc begin_write(byte_buffer request, const condition& on, bool asks_first) {
        if (!done()) return errc::busy;
        if (!raw_->node_.is_valid()) return refused(errc::bad_argument);
        if (const errc why = violated(on); why != errc::ok) return refused(why);
        condition_ = on;
        response_ = request;
        attempts_ = 0;
        if (asks_first && !raw_->line_->is_echo_ruled_out()) return ask(stage::asking_first);
        return begin_writing();
    }

    /// Reads a value of `Words` words, which `value_in` finds in the frame at the end.
    template <std::size_t Words> constexpr errc begin_value(byte_buffer frame, u16 address) {
        if (!done()) return errc::busy;
        if (const errc why = order_known_if(Words == 2); why != errc::ok) return refused(why);
        return begin_read(frame, address);
    }
    template <std::size_t Words> constexpr result<u32> value_in(bytes frame) const {
        if (!status()) return status();
        if constexpr (Words == 2) {
            if (order_ == word_order::unknown) return errc::needs_word_order;
            return join_words(load_word(frame, 3), load_word(frame, 5), order_);
        } else {
            return u32{load_word(frame, 3)};
        }
    }
    /// Writes a value of `Words` words: function 06, or 10h for two.
    template <std::size_t Words>
    constexpr errc begin_value(byte_buffer frame, u16 address, u32 bits, condition on, bool asks_first) {
        if (!done()) return errc::busy;
        if constexpr (Words == 2) {
            on.order = current_order();
            if (on.order == word_order::unknown) return refused(errc::needs_word_order);
            (void)store_value(frame, 7, bits, 2, on.order);
            return begin_block(frame, address, on, asks_first);
        } else {
            const auto request =
                modbus::write_frame<crc>(raw_->node_.address, address, static_cast<u16>(bits));
            for (std::size_t i = 0; i < request.size; ++i) frame[i] = request.data[i];
            return begin_write(frame.first(request.size), on, asks_first);
        }
    }
    /// Writes the words that lie in `frame` from its byte 7 on.
    constexpr errc begin_block(byte_buffer frame, u16 address, const condition& on, bool asks_first = false) {
        Raw::complete_block(raw_->node_.address, frame, address);
        return begin_write(frame, on, asks_first);
    }
    /// Stores a value of one or two words. Returns its bytes.
    static constexpr std::size_t store_value(byte_buffer frame, std::size_t at, u32 bits, std::size_t words,
                                             word_order order) {
        if (words == 2) {
            const word_pair pair = split_words(bits, order);
            store_word(frame, at, pair.first);
            store_word(frame, at + 2, pair.second);
        } else {
            store_word(frame, at, static_cast<u16>(bits));
        }
        return 2 * words;
    }
    constexpr word_order current_order() { return raw_->current_word_order(); }
    constexpr errc order_known_if(bool matters) {
        return matters && current_order() == word_order::unknown ? errc::needs_word_order : errc::ok;
    }
    /// The word order in which what was read is to be understood.
    constexpr word_order order_at_end() const { return order_; }

    /// The call is not begun.
    constexpr errc refused(errc why) {
        status_ = why;
        return why;
    }

    /// Moves the call on without waiting. Returns the time within which nothing happens unless a byte comes.
    constexpr duration move_on() {
        if (done()) return {};
        if (stage_ == stage::writing && exchange_.state() == modbus::exchange::phase::ready) {
            if (const errc why = violated(condition_); why != errc::ok) { // while it waited for the line
                raw_->line_->abandon(exchange_);
                end(why);
                return {};
            }
        }
        const duration idle = raw_->line_->step(exchange_, raw_->node_.gaps);
        if (!exchange_.done()) return idle;
        const servobus::status why = exchange_.status();
        switch (stage_) {
        case stage::reading:
            if (raw_->is_worth_a_retry(why) && attempts_++ < raw_->node_.read_retries)
                (void)begin(stage::reading, bytes{request_}, response_);
            else
                end(why);
            break;
        case stage::writing:
            raw_->invalidate(
                invalidated_); // it may have been learned anew while the write waited for the line
            attempts_ = 0;
            if (why && load_code() == 0x06 && !raw_->line_->is_echo_ruled_out())
                (void)ask(stage::checking);
            else
                end(why);
            break;
        default: // a read whose value is of no interest, but no echo can be its response
            if (raw_->line_->is_echo_ruled_out()) {
                if (stage_ == stage::asking_first) {
                    (void)begin_writing();
                } else {
                    end(servobus::status::sent(errc::ok));
                }
            } else if (attempts_++ < raw_->node_.read_retries) {
                (void)ask(stage_);
            } else {
                end(stage_ == stage::asking_first ? servobus::status{errc::own_echo}
                                                  : servobus::status::sent(errc::own_echo));
            }
        }
        return {};
    }

    Raw* raw_;

  private:
    using crc = typename line_type::crc;

    enum class stage : std::uint8_t {
        ended,
        reading,
        asking_first, ///< a read before a write of the line's settings
        writing,
        checking, ///< a read after a write whose response may have been its echo
    };

    constexpr void copy(const modbus::frame<8>& request) {
        for (std::size_t i = 0; i < sizeof request_; ++i) request_[i] = request.data[i];
    }
    constexpr std::uint8_t load_code() const { return response_[1]; }

    constexpr errc begin(stage next, bytes request, byte_buffer response) {
        stage_ = next;
        exchange_ = modbus::exchange::trusted(request, response, raw_->line_->timing(), raw_->node_.limits);
        return errc::ok;
    }
    constexpr errc begin_writing() {
        invalidated_ = Raw::invalidated_by(bytes{response_});
        raw_->invalidate(invalidated_);
        return begin(stage::writing, bytes{response_}, response_.first(8));
    }
    // Reads the register that is written; the response overwrites the request.
    constexpr errc ask(stage next) {
        copy(modbus::read_frame<crc>(raw_->node_.address, load_word(bytes{response_}, 2), 1));
        return begin(next, bytes{request_}, byte_buffer{request_}.first(7));
    }

    constexpr errc violated(const condition& on) {
        if (on.order != word_order::unknown && raw_->current_word_order() != on.order)
            return errc::needs_word_order;
        if constexpr (has_tokens) {
            if (on.needs_token && !raw_->is_good(on.token)) return errc::needs_init;
        }
        return errc::ok;
    }

    constexpr void end(servobus::status why) {
        order_ = current_order();
        status_ = why;
        stage_ = stage::ended;
    }

    modbus::exchange exchange_{};
    byte_buffer response_{}; // of a read; of a write the frame, whose memory takes the response
    servobus::status status_{errc::bad_argument};
    condition condition_{};
    typename Raw::invalidated invalidated_{};
    std::uint8_t request_[8]{};
    std::uint8_t attempts_ = 0;
    word_order order_ = word_order::unknown;
    stage stage_ = stage::ended;
};

} // namespace servobus::detail
