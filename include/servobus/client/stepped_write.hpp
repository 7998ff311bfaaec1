// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Writes that never wait: begun once, stepped in each iteration of a program's loop, and their status taken
// at the end. Programs with a main loop of their own include it. Never sent twice.
//
//     stepped_store<decltype(servo), c630s::jog_speed> jog{servo}; // servo: a client
//     if (jog.begin(100 * r_per_min) != errc::ok) return 1;
//     while (!jog.done()) jog.step(); // instead: step() in each iteration of your main loop
//     if (!jog.status()) std::puts(text(jog.status().outcome()));
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/client/client.hpp>
#include <servobus/client/detail/stepped_request.hpp>

namespace servobus {

namespace detail {
/// The base of `stepped_write` and `stepped_store`. `Wears`: the device may keep each write in its EEPROM.
template <class Client, bool Wears, const auto&... Rs> class stepped_put {
    static_assert(sizeof(Client) == 0, "for coils include servobus/any_device.hpp");
};

template <class Client, bool Wears, const auto& R>
requires(is_register<R> && !needs_words<R>) class stepped_put<Client, Wears, R>
    : public stepped_request<typename Client::link_type> {
    using base = stepped_request<typename Client::link_type>;
    using row = row_type<R>;
    static_assert(belongs_to<typename row::device, typename Client::device>,
                  "this register belongs to another device");

  public:
    constexpr explicit stepped_put(Client& of) : base{base::link_of(of)} {}

    /// Begins to write. Errors: `busy` while a write is under way, which goes on; the value's own,
    /// `needs_word_order`, `bad_argument`.
    constexpr status begin(register_value<R> value) {
        static_assert(
            Wears || !has(R.flags, flag::saved_on_write),
            "every write of this register wears the drive's EEPROM: stepped_store it, or begin with "
            "what ram_only() gives");
        return begin(value, typename base::condition{});
    }
    /// As above, for a register that the device can keep in its EEPROM. `needs_init` if `token` is void, or becomes
    /// void before the write leaves.
    constexpr status begin(register_value<R> value, servobus::ram_only token) {
        static_assert(base::has_tokens, "this device keeps writes only when told to");
        return begin(value, base::needing(token));
    }
    /// Moves on without waiting. Returns the time within which nothing happens unless a byte comes.
    constexpr duration step() { return base::move_on_and_note(frame_, change_); }

  private:
    constexpr status begin(register_value<R> value, typename base::condition on) {
        if (!base::done()) return errc::busy;
        if (value.error() != errc::ok) return base::refused(value.error());
        change_ = base::template change_of<is_cached>(true);
        return base::template begin_value<row::words>(frame_, R.address, value.bits(), on,
                                                      has(R.flags, flag::communication));
    }

    static constexpr bool is_cached = Client::link_type::template are_cached<R>;
    [[no_unique_address]] change_note<is_cached> change_{};
    std::uint8_t frame_[base::write_room(row::words, has(R.flags, flag::communication))];
};

template <class Client, bool Wears, const auto& Rows>
requires(is_register_array<Rows> && !has_bits<Rows> &&
         !needs_words<Rows>) class stepped_put<Client, Wears, Rows>
    : public stepped_request<typename Client::link_type> {
    using base = stepped_request<typename Client::link_type>;
    using rows = row_type<Rows>;
    static_assert(belongs_to<typename rows::device, typename Client::device>,
                  "this register belongs to another device");

  public:
    constexpr explicit stepped_put(Client& of) : base{base::link_of(of)} {}

    /// Begins to write element `index`. Errors: as of one register; `bad_argument` if there is none.
    constexpr status begin(std::size_t index, register_value<at<Rows, 0>> value) {
        static_assert(
            Wears || !has(at<Rows, 0>.flags, flag::saved_on_write),
            "every write of this register wears the drive's EEPROM: stepped_store it, or begin with "
            "what ram_only() gives");
        return begin(index, value, typename base::condition{});
    }
    constexpr status begin(std::size_t index, register_value<at<Rows, 0>> value, servobus::ram_only token) {
        static_assert(base::has_tokens, "this device keeps writes only when told to");
        return begin(index, value, base::needing(token));
    }
    constexpr duration step() { return base::move_on_and_note(frame_, change_); } ///< as of one register

  private:
    constexpr status begin(std::size_t index, register_value<at<Rows, 0>> value,
                           typename base::condition on) {
        if (!base::done()) return errc::busy;
        if (index >= rows::size) return base::refused(errc::bad_argument);
        if (value.error() != errc::ok) return base::refused(value.error());
        if constexpr (is_cached) change_ = {Client::link_type::is_cached(Rows[index].address, rows::words)};
        return base::template begin_value<rows::words>(frame_, Rows[index].address, value.bits(), on, false);
    }

    static constexpr bool is_cached = Client::link_type::template has_cached_element<Rows>;
    [[no_unique_address]] change_note<is_cached> change_{};
    std::uint8_t frame_[base::write_room(rows::words, false)];
};

template <class Client, bool Wears, const auto&... Rs>
requires(sizeof...(Rs) > 1 &&
         !((is_bit<Rs> || needs_words<Rs>) || ...)) class stepped_put<Client, Wears, Rs...>
    : public stepped_request<typename Client::link_type> {
    using base = stepped_request<typename Client::link_type>;
    using plan = write_plan<Rs...>;
    static_assert((belongs_to<typename row_type<Rs>::device, typename Client::device> && ...),
                  "this register belongs to another device");

  public:
    constexpr explicit stepped_put(Client& of) : base{base::link_of(of)} { plan::check(); }

    /// Begins to write adjacent registers in one frame: all or nothing. Errors: as of one register.
    constexpr status begin(register_value<Rs>... values) {
        static_assert(Wears || !(has(Rs.flags, flag::saved_on_write) || ...),
                      "every write of this register wears the drive's EEPROM: stepped_store it");
        if (!base::done()) return errc::busy;
        typename base::condition on;
        word_order order = word_order::unknown;
        if constexpr (((row_type<Rs>::words == 2) || ...)) {
            order = base::current_order();
            if (order == word_order::unknown) return base::refused(errc::needs_word_order);
            on.use(order);
        }
        std::size_t used = 7;
        errc wrong = errc::ok;
        const auto put = [&](const auto& value, std::size_t words) {
            if (value.error() != errc::ok && wrong == errc::ok) wrong = value.error();
            used += base::store_value(frame_, used, value.bits(), words, order);
        };
        (put(values, row_type<Rs>::words), ...);
        if (wrong != errc::ok) return base::refused(wrong);
        change_ = base::template change_of<is_cached>(true);
        return base::begin_block(frame_, plan::words, plan::rows[0].address, on);
    }
    constexpr duration step() { return base::move_on_and_note(frame_, change_); } ///< as of one register

  private:
    static constexpr bool is_cached = Client::link_type::template are_cached<Rs...>;
    [[no_unique_address]] change_note<is_cached> change_{};
    std::uint8_t frame_[9 + 2 * plan::words];
};
} // namespace detail

/// A stepped `Client::write<Rs...>(values...)`: of one register, of an element of an array of registers, of adjacent
/// registers, of one coil, or of adjacent coils. The client must outlive it; an object that is destroyed gives its
/// write up: see `cancel`.
template <class Client, const auto&... Rs>
class stepped_write : public detail::stepped_put<Client, false, Rs...> {
    using detail::stepped_put<Client, false, Rs...>::stepped_put;
};
/// A stepped `Client::store<Rs...>(values...)`: for registers that the device keeps at every write.
template <class Client, const auto&... Rs>
class stepped_store : public detail::stepped_put<Client, true, Rs...> {
    using detail::stepped_put<Client, true, Rs...>::stepped_put;
};

/// Writes up to `Most` raw registers, for registers without a row.
template <class Client, std::size_t Most>
class stepped_write_words : public detail::stepped_request<typename Client::link_type> {
    using base = detail::stepped_request<typename Client::link_type>;
    static_assert(Most >= 1 && Most <= Client::device::facts.max_write,
                  "more registers than this device takes in one write");

  public:
    // cppcheck-suppress uninitMemberVar ; a request fills it, and a small core has no memset
    constexpr explicit stepped_write_words(Client& of) : base{base::link_of(of)} {}

    /// Begins to write `words` from `address` on, function 10h. Errors: `busy`, `bad_argument`.
    constexpr status begin(u16 address, slice<const u16> words) {
        if (!base::done()) return errc::busy;
        if (words.empty() || words.size() > Most ||
            !modbus::fits_address_space(address, static_cast<u16>(words.size())))
            return base::refused(errc::bad_argument);
        for (std::size_t i = 0; i < words.size(); ++i) store_word(frame_, 7 + 2 * i, words[i]);
        change_ = base::template change_of<is_cached>(Client::link_type::is_cached(address, words.size()));
        return base::begin_block(frame_, words.size(), address, {});
    }
    /// Begins to write one register, function 06. Errors: as above.
    constexpr status begin(u16 address, u16 word) {
        if (!base::done()) return errc::busy;
        change_ = base::template change_of<is_cached>(Client::link_type::is_cached(address, 1));
        return base::template begin_value<1>(frame_, address, word, {}, false);
    }
    constexpr duration step() { return base::move_on_and_note(frame_, change_); } ///< as of one register

  private:
    static constexpr bool is_cached = Client::link_type::may_have_facade;
    [[no_unique_address]] detail::change_note<is_cached> change_{};
    std::uint8_t frame_[9 + 2 * Most];
};

} // namespace servobus
