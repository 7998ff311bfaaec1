// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Stepped calls for rows of all four tables, and for functions 16h and 17h. any_device.hpp includes it.
//
//     stepped_write<decltype(io), tank::valve> open{io}; // io: a client, tank::valve: a coil
//     if (open.begin(true) != errc::ok) return 1;
//     while (!open.done()) open.step(); // instead: step() in each iteration of your main loop
//     if (!open.status()) return 1;
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/client/detail/row_rules.hpp>
#include <servobus/client/detail/stepped_table_request.hpp>
#include <servobus/client/detail/table_calls.hpp>
#include <servobus/client/stepped_read.hpp>
#include <servobus/client/stepped_write.hpp>

namespace servobus {

namespace detail {
/// The base of a read of `R`, or of an element of an array that is like `R`.
template <class Client, const auto& R>
class stepped_read_one : public stepped_table_request<typename Client::link_type> {
    using base = stepped_table_request<typename Client::link_type>;
    using one = readings<R>;
    static_assert(belongs_to<typename row_type<R>::device, typename Client::device>,
                  "this register belongs to another device");

  public:
    constexpr duration step() {
        return base::template move_on<detail::call_of::tables>(frame_);
    } ///< as of a register
    /// The value that was read, or why there is none: the errors of `Client::read`.
    constexpr result<reading<R>> value() const {
        if (!base::status()) return base::status();
        const word_order order = base::order_at_end();
        if (one::has_pairs && order == word_order::unknown) return errc::needs_word_order;
        one read{order};
        if (!read.take(0, bytes{frame_}.subspan(3, one::plan.bytes))) return errc::unexpected_value;
        return read.template get<R>();
    }

  protected:
    // cppcheck-suppress uninitMemberVar ; a request fills it, and a small core has no memset
    constexpr explicit stepped_read_one(Client& of) : base{base::link_of(of)} {}

    constexpr errc begin_part(const table_extent& part) {
        if (const errc why = base::order_known_if(one::has_pairs); why != errc::ok) return base::refused(why);
        return base::begin_part(frame_, part);
    }

  private:
    std::uint8_t frame_[base::part_room(one::plan.longest_response)];
};
} // namespace detail

/// Reads one coil, discrete input or input register.
template <class Client, const auto& R>
requires(detail::needs_table_calls<R> && !is_register_array<R>) class stepped_read<Client, R>
    : public detail::stepped_read_one<Client, R> {
    using base = detail::stepped_read_one<Client, R>;

  public:
    constexpr explicit stepped_read(Client& of) : base{of} {}

    constexpr status begin() { ///< as of a register
        if (!base::done()) return errc::busy;
        return base::begin_part(readings<R>::plan.requests[0]);
    }
};

/// Reads one element of an array of coils, discrete inputs or input registers.
template <class Client, const auto& Rows>
requires(detail::needs_table_calls<Rows>&& is_register_array<Rows>) class stepped_read<Client, Rows>
    : public detail::stepped_read_one<Client, at<Rows, 0>> {
    using base = detail::stepped_read_one<Client, at<Rows, 0>>;

  public:
    constexpr explicit stepped_read(Client& of) : base{of} {}

    /// Begins to read element `index`. Errors: as of a register; `bad_argument` if there is none.
    constexpr status begin(std::size_t index) {
        if (!base::done()) return errc::busy;
        if (index >= row_type<Rows>::size) return base::refused(errc::bad_argument);
        table_extent part = readings<at<Rows, 0>>::plan.requests[0];
        part.address = Rows[index].address;
        return base::begin_part(part);
    }
};

/// Reads rows of several tables, or of one, in the fewest requests. If one request fails there is no value at all.
template <class Client, const auto&... Rs>
requires(sizeof...(Rs) > 1 && (detail::needs_table_calls<Rs> || ...)) class stepped_read<Client, Rs...>
    : public detail::stepped_table_request<typename Client::link_type> {
    using base = detail::stepped_table_request<typename Client::link_type>;
    using values = readings<Rs...>;
    static_assert((belongs_to<typename row_type<Rs>::device, typename Client::device> && ...),
                  "this register belongs to another device");
    static constexpr const auto& plan = values::plan;

  public:
    // cppcheck-suppress uninitMemberVar ; a request fills it, and a small core has no memset
    constexpr explicit stepped_read(Client& of) : base{base::link_of(of)} {}

    constexpr status begin() { ///< as of a register
        if (!base::done()) return errc::busy;
        if (const errc why = base::order_known_if(values::has_pairs); why != errc::ok)
            return base::refused(why);
        next_ = 0;
        return base::begin_part(frame_, plan.requests[0]);
    }
    constexpr duration step() { ///< as of a register
        if (base::done()) return {};
        const duration idle = base::template move_on<detail::call_of::tables>(frame_);
        if (!base::done() || !base::status()) return idle;
        const table_extent& part = plan.requests[next_];
        const word_order order = base::order_at_end();
        if (plan.has_echo_like_response && base::is_echo(part, frame_))
            (void)base::refused(errc::own_echo);
        else if (!values_.take(next_, bytes{frame_}.subspan(3, part.size())))
            (void)base::refused(errc::unexpected_value);
        else if (values::has_pairs && !Client::link_type::is_one_order(next_, order_, order))
            (void)base::refused(errc::needs_word_order);
        else if (++next_ < plan.count)
            (void)base::begin_part(frame_, plan.requests[next_]);
        order_ = order;
        return {};
    }
    /// The values that were read, or why there are none. A row's value is taken out by `get`.
    constexpr result<values> value() const {
        result<values> read{servobus::status{}};
        if (const auto why = base::status(); !why) {
            read.fail(why);
        } else if (values::has_pairs && order_ == word_order::unknown) {
            read.fail(errc::needs_word_order);
        } else {
            read = values_;
            read->set_word_order(order_);
        }
        return read;
    }

  private:
    values values_{};
    std::uint8_t next_ = 0; // request
    word_order order_ = word_order::unknown;
    std::uint8_t frame_[base::part_room(plan.longest_response)];
};

namespace detail {
template <class Client, bool Wears, const auto& R>
requires is_bit<R>
class stepped_put<Client, Wears, R> : public stepped_table_request<typename Client::link_type> {
    using base = stepped_table_request<typename Client::link_type>;

  public:
    constexpr explicit stepped_put(Client& of) : base{base::link_of(of)} {}

    /// Begins to write a coil. Errors: `busy` while a write is under way, which goes on; `bad_argument`.
    constexpr status begin(register_value<R> value) {
        check_coils<typename Client::device, Wears, R>();
        return base::begin_coil(frame_, R.address, value.bits() != 0);
    }
    /// Begins to send another word than on and off. Errors: likewise.
    constexpr status begin(coil_word word) {
        check_coils<typename Client::device, Wears, R>();
        return base::begin_coil_word(frame_, R.address, word.value);
    }
    constexpr duration step() {
        return base::template move_on<call_of::tables>(frame_);
    } ///< as of one register

  private:
    std::uint8_t frame_[base::coil_room];
};

template <class Client, bool Wears, const auto& Rows>
requires(is_register_array<Rows>&& has_bits<Rows>) class stepped_put<Client, Wears, Rows>
    : public stepped_table_request<typename Client::link_type> {
    using base = stepped_table_request<typename Client::link_type>;

  public:
    constexpr explicit stepped_put(Client& of) : base{base::link_of(of)} {}

    /// Begins to write element `index`. Errors: as of one coil; `bad_argument` if there is none.
    constexpr status begin(std::size_t index, register_value<at<Rows, 0>> value) {
        check_coils<typename Client::device, Wears, at<Rows, 0>>();
        if (!base::done()) return errc::busy;
        if (index >= row_type<Rows>::size) return base::refused(errc::bad_argument);
        return base::begin_coil(frame_, Rows[index].address, value.bits() != 0);
    }
    constexpr duration step() {
        return base::template move_on<call_of::tables>(frame_);
    } ///< as of one register

  private:
    std::uint8_t frame_[base::coil_room];
};

/// A value whose words the codec makes.
template <class Client, bool Wears, const auto& R>
requires(is_register<R>&& needs_words<R>) class stepped_put<Client, Wears, R>
    : public stepped_table_request<typename Client::link_type> {
    using base = stepped_table_request<typename Client::link_type>;
    using row = row_type<R>;
    static_assert(belongs_to<typename row::device, typename Client::device>,
                  "this register belongs to another device");
    static constexpr bool asks_first = has(R.flags, flag::communication);

  public:
    // cppcheck-suppress uninitMemberVar ; a request fills it, and a small core has no memset
    constexpr explicit stepped_put(Client& of) : base{base::link_of(of)} {}

    constexpr status begin(register_value<R> value) { ///< as of one register
        static_assert(Wears || !has(R.flags, flag::saved_on_write),
                      "every write of this register wears the drive's EEPROM: stepped_store it");
        check_whole<register_value<R>>();
        if (!base::done()) return errc::busy;
        if (value.error() != errc::ok) return base::refused(value.error());
        change_ = base::template change_of<is_cached>(true);
        return base::template begin_words<row::words>(frame_, R.address, value, {}, asks_first);
    }
    constexpr duration step() { return base::move_on_and_note(frame_, change_); } ///< as of one register

  private:
    static constexpr bool is_cached = Client::link_type::template are_cached<R>;
    [[no_unique_address]] change_note<is_cached> change_{};
    std::uint8_t frame_[base::write_room(row::words, asks_first)];
};

template <class Client, bool Wears, const auto& Rows>
requires(is_register_array<Rows>&& needs_words<Rows>) class stepped_put<Client, Wears, Rows>
    : public stepped_table_request<typename Client::link_type> {
    using base = stepped_table_request<typename Client::link_type>;
    using rows = row_type<Rows>;
    static_assert(belongs_to<typename rows::device, typename Client::device>,
                  "this register belongs to another device");

  public:
    // cppcheck-suppress uninitMemberVar ; a request fills it, and a small core has no memset
    constexpr explicit stepped_put(Client& of) : base{base::link_of(of)} {}

    /// Begins to write element `index`. Errors: as of one register; `bad_argument` if there is none.
    constexpr status begin(std::size_t index, register_value<at<Rows, 0>> value) {
        static_assert(Wears || !has(at<Rows, 0>.flags, flag::saved_on_write),
                      "every write of this register wears the drive's EEPROM: stepped_store it");
        check_whole<register_value<at<Rows, 0>>>();
        if (!base::done()) return errc::busy;
        if (index >= rows::size) return base::refused(errc::bad_argument);
        if (value.error() != errc::ok) return base::refused(value.error());
        if constexpr (is_cached) change_ = {Client::link_type::is_cached(Rows[index].address, rows::words)};
        return base::template begin_words<rows::words>(frame_, Rows[index].address, value, {}, false);
    }
    constexpr duration step() { return base::move_on_and_note(frame_, change_); } ///< as of one register

  private:
    static constexpr bool is_cached = Client::link_type::template has_cached_element<Rows>;
    [[no_unique_address]] change_note<is_cached> change_{};
    std::uint8_t frame_[base::write_room(rows::words, false)];
};

/// Adjacent registers with such a value among them.
template <class Client, bool Wears, const auto&... Rs>
requires(sizeof...(Rs) > 1 && !(is_bit<Rs> || ...) &&
         (needs_words<Rs> || ...)) class stepped_put<Client, Wears, Rs...>
    : public stepped_table_request<typename Client::link_type> {
    using base = stepped_table_request<typename Client::link_type>;
    using plan = write_plan<Rs...>;
    static_assert((belongs_to<typename row_type<Rs>::device, typename Client::device> && ...),
                  "this register belongs to another device");

  public:
    // cppcheck-suppress uninitMemberVar ; a request fills it, and a small core has no memset
    constexpr explicit stepped_put(Client& of) : base{base::link_of(of)} { plan::check(); }

    /// Begins to write adjacent registers in one frame: all or nothing. Errors: as of one register.
    constexpr status begin(register_value<Rs>... values) {
        static_assert(Wears || !(has(Rs.flags, flag::saved_on_write) || ...),
                      "every write of this register wears the drive's EEPROM: stepped_store it");
        if (!base::done()) return errc::busy;
        typename base::condition on;
        word_order order = word_order::high_first;
        if constexpr ((needs_word_order<Rs>() || ...)) {
            order = base::current_order();
            if (order == word_order::unknown) return base::refused(errc::needs_word_order);
            on.use(order);
        }
        std::size_t used = 7;
        errc wrong = errc::ok;
        const auto put = [&](const auto& value, std::size_t words) {
            if (value.error() != errc::ok && wrong == errc::ok) wrong = value.error();
            if constexpr (stores_words<decltype(value)>) {
                check_whole<std::remove_cvref_t<decltype(value)>>();
                value.store({frame_, sizeof frame_}, used, order);
                used += 2 * words;
            } else {
                used += base::store_value({frame_, sizeof frame_}, used, value.bits(), words, order);
            }
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

template <class Client, bool Wears, const auto&... Rs>
requires(sizeof...(Rs) > 1 && (is_bit<Rs> || ...)) class stepped_put<Client, Wears, Rs...>
    : public stepped_table_request<typename Client::link_type> {
    using base = stepped_table_request<typename Client::link_type>;
    using plan = coils_plan<typename Client::device, Rs...>;

  public:
    // cppcheck-suppress uninitMemberVar ; a request fills it, and a small core has no memset
    constexpr explicit stepped_put(Client& of) : base{base::link_of(of)} {}

    /// Begins to write adjacent coils in one frame: all or nothing. Errors: as of one coil.
    constexpr status begin(register_value<Rs>... values) {
        check_coils<typename Client::device, Wears, Rs...>();
        if (!base::done()) return errc::busy;
        plan::put(frame_, values...);
        return base::begin_coils(frame_, plan::rows[0].address, plan::count);
    }
    constexpr duration step() {
        return base::template move_on<call_of::tables>(frame_);
    } ///< as of one register

  private:
    std::uint8_t frame_[plan::room];
};
} // namespace detail

/// Changes bits of a register: a stepped `Client::change_bits<R, Mask>(value)`; of a part of a register, without a
/// mask, `Client::change_bits<R>(value)`.
template <class Client, const auto& R, u16 Mask = detail::part_mask<R>()>
class stepped_change_bits : public detail::stepped_table_request<typename Client::link_type> {
    using base = detail::stepped_table_request<typename Client::link_type>;
    static constexpr bool is_part = detail::is_part<typename row_type<R>::value_type>;

  public:
    // cppcheck-suppress uninitMemberVar ; a request fills it, and a small core has no memset
    constexpr explicit stepped_change_bits(Client& of) : base{base::link_of(of)} {}

    /// Begins to set the bits of `Mask` to those of `value`. Errors: `busy`, `bad_argument`.
    constexpr status begin(u16 value) requires(!is_part) {
        detail::check_mask<typename Client::device, R, Mask>();
        return begin_change(value);
    }
    /// Begins to set the part to `value`. Errors: likewise, and the value's own.
    constexpr status begin(register_value<R> value) requires is_part {
        detail::check_part<typename Client::device, R>();
        if (!base::done()) return errc::busy;
        if (value.error() != errc::ok) return base::refused(value.error());
        return begin_change(static_cast<u16>(value.bits()));
    }
    constexpr duration step() {
        return base::template move_on_and_note<detail::call_of::masked>(frame_, change_);
    } ///< as of a write

  private:
    constexpr status begin_change(u16 value) {
        if (!base::done()) return errc::busy;
        change_ = base::template change_of<is_cached>(true);
        return base::begin_masked(frame_, R.address, static_cast<u16>(~Mask), static_cast<u16>(value & Mask));
    }

    static constexpr bool is_cached = Client::link_type::template are_cached<R>;
    [[no_unique_address]] detail::change_note<is_cached> change_{};
    std::uint8_t frame_[10];
};

/// A stepped `Client::write_then_read<Reads, Ws...>(values...)`: writes, then reads, in one transaction.
template <class Client, class Reads, const auto&... Ws>
class stepped_write_then_read : public detail::stepped_table_request<typename Client::link_type> {
    using base = detail::stepped_table_request<typename Client::link_type>;
    using plan = detail::both_plan<typename Client::device, Reads, Ws...>;
    using result_type = result<typename plan::values>;

  public:
    // cppcheck-suppress uninitMemberVar ; a request fills it, and a small core has no memset
    constexpr explicit stepped_write_then_read(Client& of) : base{base::link_of(of)} {
        write_plan<Ws...>::check();
    }

    /// Begins to write the registers `Ws`, and to read those of `Reads` after that. Errors: as of a write.
    constexpr status begin(register_value<Ws>... values) {
        plan::check();
        if (!base::done()) return errc::busy;
        typename base::condition on;
        word_order order = word_order::high_first;
        if constexpr (plan::has_pairs) {
            order = base::current_order();
            if (order == word_order::unknown) return base::refused(errc::needs_word_order);
            on.use(order);
        }
        if (const errc wrong = plan::put(frame_, order, values...); wrong != errc::ok)
            return base::refused(wrong);
        change_ = base::template change_of<is_cached>(true);
        return base::begin_both(frame_, plan::extents, on);
    }
    constexpr duration step() {
        return base::template move_on_and_note<detail::call_of::both>(frame_, change_);
    } ///< as of a write
    /// The values that were read after the write, or why there are none.
    constexpr result_type value() const {
        result_type read{servobus::status{}};
        const word_order order = base::order_at_end();
        if (const auto why = base::status(); !why) {
            read.fail(why);
        } else if (plan::values::has_pairs && order == word_order::unknown) {
            read.fail(errc::needs_word_order);
        } else {
            plan::take(read, bytes{frame_}.subspan(3, std::size_t{2} * plan::read.words), order);
        }
        return read;
    }

  private:
    static constexpr bool is_cached = Client::link_type::template are_cached<Ws...>;
    [[no_unique_address]] detail::change_note<is_cached> change_{};
    std::uint8_t frame_[plan::room];
};

} // namespace servobus
