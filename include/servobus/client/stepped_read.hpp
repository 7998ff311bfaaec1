// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Reads that never wait: begun once, stepped in each iteration of a program's loop, and their value taken at
// the end. Programs with a main loop of their own include it. Several may be under way on one line; the line
// runs one exchange at a time, and a stop goes first.
//
//     stepped_read<decltype(servo), c630s::actual_speed> speed{servo}; // servo: a client
//     if (!speed.begin()) return 1;
//     while (!speed.done()) speed.step(); // instead: step() in each iteration of your main loop
//     if (const auto now = speed.value(); !now || *now > 300 * r_per_min) return 1;
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/client/client.hpp>
#include <servobus/client/detail/stepped_request.hpp>

namespace servobus {

/// A stepped `Client::read<Rs...>()`: of one register, of an element of an array of registers, or of several
/// registers. Reads are retried as often as the node says. The client must outlive it. An object that
/// is destroyed gives its read up: see `cancel`.
template <class Client, const auto&... Rs> class stepped_read {
    static_assert(sizeof(Client) == 0, "for coils and inputs include servobus/any_device.hpp");
};

/// Reads one register.
template <class Client, const auto& R>
requires(is_register<R> && !detail::needs_table_calls<R>) class stepped_read<Client, R>
    : public detail::stepped_request<typename Client::link_type> {
    using base = detail::stepped_request<typename Client::link_type>;
    using row = row_type<R>;
    static_assert(belongs_to<typename row::device, typename Client::device>,
                  "this register belongs to another device");
    static_assert(row::rights != access::wo, "this register is write-only");

  public:
    constexpr explicit stepped_read(Client& of) : base{base::link_of(of)} {}

    /// Begins to read. Errors: `busy` while a read is under way, which goes on; `needs_word_order`;
    /// `bad_argument`.
    constexpr status begin() { return base::template begin_value<row::words>(frame_, R.address); }
    /// Moves on without waiting. Returns the time within which nothing happens unless a byte comes.
    constexpr duration step() { return base::move_on(frame_); }
    /// The value that was read, or why there is none: the errors of `Client::read`, `busy` while the read is
    /// under way.
    constexpr result<reading<R>> value() const {
        const result<u32> bits = base::template value_in<row::words>(frame_);
        if (!bits) return bits.status();
        return reading_of<R>(*bits);
    }

  private:
    std::uint8_t frame_[base::read_room(row::words)];
};

/// Reads one element of an array of registers.
template <class Client, const auto& Rows>
requires(is_register_array<Rows> && !detail::needs_table_calls<Rows>) class stepped_read<Client, Rows>
    : public detail::stepped_request<typename Client::link_type> {
    using base = detail::stepped_request<typename Client::link_type>;
    using rows = row_type<Rows>;
    static_assert(belongs_to<typename rows::device, typename Client::device>,
                  "this register belongs to another device");
    static_assert(rows::rights != access::wo, "this register is write-only");

  public:
    constexpr explicit stepped_read(Client& of) : base{base::link_of(of)} {}

    /// Begins to read element `index`. Errors: as of one register; `bad_argument` if there is none.
    constexpr status begin(std::size_t index) {
        if (!base::done()) return errc::busy;
        if (index >= rows::size) return base::refused(errc::bad_argument);
        return base::template begin_value<rows::words>(frame_, Rows[index].address);
    }
    constexpr duration step() { return base::move_on(frame_); } ///< as of one register
    constexpr result<reading<at<Rows, 0>>> value() const {      ///< as of one register
        const result<u32> bits = base::template value_in<rows::words>(frame_);
        if (!bits) return bits.status();
        return reading_of<at<Rows, 0>>(*bits);
    }

  private:
    std::uint8_t frame_[base::read_room(rows::words)];
};

/// Reads several registers in the fewest requests. If one request fails there is no value at all.
template <class Client, const auto&... Rs>
requires(sizeof...(Rs) > 1 && !(detail::needs_table_calls<Rs> || ...)) class stepped_read<Client, Rs...>
    : public detail::stepped_request<typename Client::link_type> {
    using base = detail::stepped_request<typename Client::link_type>;
    static_assert((belongs_to<typename row_type<Rs>::device, typename Client::device> && ...),
                  "this register belongs to another device");
    static constexpr const auto& plan = readings<Rs...>::plan;
    static constexpr bool is_one = plan.count == 1; // then the words stay in the frame until `value`

  public:
    constexpr explicit stepped_read(Client& of) : base{base::link_of(of)} {}

    constexpr status begin() { ///< as of one register
        if (!base::done()) return errc::busy;
        if (const errc why = base::order_known_if(readings<Rs...>::has_pairs); why != errc::ok)
            return base::refused(why);
        if constexpr (is_one) {
            return base::begin_read(frame_, plan.requests[0].address, plan.words);
        } else {
            parts_.next = 0;
            parts_.offset = 0;
            return begin_part();
        }
    }
    constexpr duration step() { ///< as of one register
        if constexpr (is_one) {
            return base::move_on(frame_);
        } else {
            if (base::done()) return {};
            const duration idle = base::move_on(frame_);
            if (!base::done() || !base::status()) return idle;
            const word_order order = base::order_at_end();
            if (readings<Rs...>::has_pairs &&
                !Client::link_type::is_one_order(parts_.next, parts_.order, order)) {
                (void)base::refused(errc::needs_word_order);
                return {};
            }
            parts_.order = order;
            const u16 words = plan.requests[parts_.next].words;
            words_view{bytes{frame_}.subspan(3, std::size_t{2} * words)}.copy_to(
                parts_.values.words().subspan(parts_.offset, words));
            parts_.values.set_word_order(order);
            parts_.offset = static_cast<u16>(parts_.offset + words);
            if (++parts_.next < plan.count) (void)begin_part();
            return {};
        }
    }
    /// The values that were read, or why there are none. A register is taken out by `get<R>`.
    constexpr result<readings<Rs...>> value() const {
        result<readings<Rs...>> values{servobus::status{}};
        const word_order order = base::order_at_end();
        if (const auto why = base::status(); !why) {
            values.fail(why);
        } else if (readings<Rs...>::has_pairs && order == word_order::unknown) {
            values.fail(errc::needs_word_order);
        } else if constexpr (is_one) {
            words_view{bytes{frame_}.subspan(3, std::size_t{2} * plan.words)}.copy_to(values->words());
            values->set_word_order(order);
        } else {
            values = parts_.values;
        }
        return values;
    }

  private:
    constexpr errc begin_part() {
        const extent& part = plan.requests[parts_.next];
        return base::begin_read(frame_, part.address, part.words);
    }

    struct several {
        readings<Rs...> values{};
        u16 offset = 0;
        std::uint8_t next = 0;
        word_order order = word_order::unknown; // of the parts read so far
    };
    struct one {};
    [[no_unique_address]] std::conditional_t<is_one, one, several> parts_{};
    std::uint8_t frame_[base::read_room(plan.words)];
};

/// Reads up to `Most` raw registers, for registers without a row.
template <class Client, std::size_t Most>
class stepped_read_words : public detail::stepped_request<typename Client::link_type> {
    using base = detail::stepped_request<typename Client::link_type>;
    static_assert(Most >= 1 && Most <= Client::device::facts.max_read,
                  "more registers than this device gives in one read");

  public:
    // cppcheck-suppress uninitMemberVar ; a request fills it, and a small core has no memset
    constexpr explicit stepped_read_words(Client& of) : base{base::link_of(of)} {}

    /// Begins to read `count` registers from `address` on, function 03 or 04. Errors: `busy`, `bad_argument`.
    constexpr status begin(u16 address, std::size_t count = Most,
                           modbus::function code = modbus::function::read_holding_registers) {
        if (!base::done()) return errc::busy;
        if (count == 0 || count > Most) return base::refused(errc::bad_argument);
        count_ = static_cast<u16>(count);
        return base::begin_read(frame_, address, count, code);
    }
    constexpr duration step() { return base::move_on(frame_); } ///< as of one register
    /// The words that were read; none unless `status()` is ok. Valid until the next `begin`.
    constexpr words_view words() const {
        return base::status() ? words_view{bytes{frame_}.subspan(3, std::size_t{2} * count_)} : words_view{};
    }

  private:
    u16 count_ = 0;
    std::uint8_t frame_[base::read_room(Most)];
};

} // namespace servobus
