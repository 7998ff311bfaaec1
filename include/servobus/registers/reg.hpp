// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A register row: one constexpr object that reads like a line of the manual's table. Its type carries the
// value's type, the access and the device; address, range, unit, default and flags are data. Rows are used as
// reference template arguments (`read<bus_voltage>()`), so that a row costs no flash.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/registers/unit.hpp>
#include <servobus/registers/wire.hpp>

namespace servobus {

enum class access : std::uint8_t { ro, rw, wo };

/// Facts of a row beside its value.
enum class flag : std::uint16_t {
    none = 0,
    saved = 1,               ///< kept over a power cycle once a save is ordered
    saved_on_write = 2,      ///< every write wears the EEPROM
    when_stopped = 4,        ///< may be written only while the motor stands
    when_running = 8,        ///< may be written at any time
    trigger = 16,            ///< a write may start, enable, reset or save: it is never repeated by itself
    scaled_elsewhere = 32,   ///< another register rescales it at run time
    immediate = 64,          ///< a new value takes effect at once,
    at_stop = 128,           ///< when the motor stops next,
    after_power_cycle = 256, ///< or when the drive is switched on next
    communication = 512,     ///< address, baud rate: the answer may come with the new setting
    motion = 1024,           ///< a target: it moves an enabled motor
    position_mode = 2048,    ///< matters in position control,
    speed_mode = 4096,       ///< in speed control,
    torque_mode = 8192,      ///< in torque control
    every_mode = 16384,      ///< always
    zero_by_name = 32768,    ///< 0 is in range, but of unknown meaning: written only as `undocumented_zero`
};

constexpr flag operator|(flag a, flag b) {
    return static_cast<flag>(static_cast<std::uint16_t>(a) | static_cast<std::uint16_t>(b));
}
constexpr bool has(flag set, flag one) {
    return (static_cast<std::uint16_t>(set) & static_cast<std::uint16_t>(one)) != 0;
}

inline constexpr flag saved = flag::saved;
inline constexpr flag saved_on_write = flag::saved_on_write;
inline constexpr flag when_stopped = flag::when_stopped;
inline constexpr flag when_running = flag::when_running;
inline constexpr flag trigger = flag::trigger;
inline constexpr flag scaled_elsewhere = flag::scaled_elsewhere;
inline constexpr flag immediate = flag::immediate;
inline constexpr flag at_stop = flag::at_stop;
inline constexpr flag after_power_cycle = flag::after_power_cycle;
inline constexpr flag communication = flag::communication;
inline constexpr flag motion = flag::motion;
inline constexpr flag position_mode = flag::position_mode;
inline constexpr flag speed_mode = flag::speed_mode;
inline constexpr flag torque_mode = flag::torque_mode;
inline constexpr flag every_mode = flag::every_mode;
inline constexpr flag zero_by_name = flag::zero_by_name;

/// Lowest and highest raw value.
struct range {
    std::int64_t low = 0;
    std::int64_t high = 0;
    bool is_stated = true; ///< false: the manual gives none, and the value's type is the bound

    friend constexpr bool operator==(range, range) = default;
    constexpr bool contains(std::int64_t v) const { return v >= low && v <= high; }
};

/// The range of a value's type, where the manual prints none.
template <class T> inline constexpr range full{detail::lowest<T>, detail::highest<T>, false};

/// The range of a packed word for which the manual prints none.
inline constexpr range unstated{0, 0xFFFF, false};

/// Default of a row for which the manual gives none.
inline constexpr std::int64_t no_default = detail::lowest<std::int64_t>;

namespace detail {
// Not constexpr on purpose: a row that calls one does not compile, and the error names the rule.
inline void a_register_range_is_low_to_high() {}
inline void a_register_range_lies_inside_its_value_type() {}
inline void a_register_default_lies_inside_its_range() {}
inline void a_two_word_register_ends_inside_the_address_space() {}
inline void a_scaled_register_has_a_unit() {}
inline void elements_of_an_array_do_not_overlap() {}
inline void an_array_ends_inside_the_address_space() {}

/// What a value's type asks of its row.
struct shape {
    std::int64_t low;
    std::int64_t high;
    std::uint8_t words;
};
template <class T> inline constexpr shape shape_of{0, 0xFFFF, 1};
template <> inline constexpr shape shape_of<i16>{-0x8000l, 0x7FFF, 1};
template <> inline constexpr shape shape_of<u32>{0, 0xFFFF'FFFF, 2};
template <> inline constexpr shape shape_of<i32>{-0x8000'0000ll, 0x7FFF'FFFF, 2};
} // namespace detail

/// A register of `Device` that holds a `T`. It is data only, so that a map of hundreds costs the compiler
/// little; that it is sound is checked where it is used first, and for all rows of a map by its catalogue.
template <class T, access Rights, class Device> struct reg {
    using value_type = T;
    using device = Device;
    static constexpr access rights = Rights;
    static constexpr std::size_t words = detail::words_in<T>;

    u16 address;
    range limits;
    unit unit_of_count;
    std::int64_t initial; ///< raw default from the factory, or `no_default`
    flag flags = flag::none;
};

namespace detail {
/// A wrong row does not compile: the range must lie in the type, the default in the range.
template <class T, access Rights, class Device> constexpr bool is_sound(const reg<T, Rights, Device>& row) {
    static_assert(wire_value<T>, "a register holds an integer of 16 or 32 bits, a 16-bit enumeration or a "
                                 "class that packs one word");
    const shape of = shape_of<T>;
    const range within = row.limits;
    if (within.low > within.high) a_register_range_is_low_to_high();
    if (within.low < of.low || within.high > of.high) a_register_range_lies_inside_its_value_type();
    if (row.initial != no_default && !within.contains(row.initial))
        a_register_default_lies_inside_its_range();
    if (row.unit_of_count.of == measure::none && !row.unit_of_count.is_plain())
        a_scaled_register_has_a_unit();
    if (row.address > 0x1'0000 - of.words) a_two_word_register_ends_inside_the_address_space();
    return true;
}
} // namespace detail

/// `Count` equal rows, `stride` addresses apart: the segments of a positioning table. `row[i]` is a row of
/// its own, `at<rows, i>` one for use as a template argument.
template <class Row, std::size_t Count> struct reg_array {
    using value_type = typename Row::value_type;
    using device = typename Row::device;
    static constexpr access rights = Row::rights;
    static constexpr std::size_t words = Row::words;
    static constexpr std::size_t size = Count;

    Row first;
    u16 stride;

    /// Elements that overlap, or lie beyond the address space, do not compile.
    consteval reg_array(const Row& element_0, u16 step) : first{element_0}, stride{step} {
        if (step < words) detail::elements_of_an_array_do_not_overlap();
        if (element_0.address + (Count - 1) * step + words > 0x1'0000u)
            detail::an_array_ends_inside_the_address_space();
    }

    constexpr Row operator[](std::size_t i) const {
        Row row = first;
        row.address = static_cast<u16>(first.address + i * stride);
        return row;
    }
};

namespace detail {
template <class T> struct is_row : std::false_type {};
template <class T, access A, class D> struct is_row<reg<T, A, D>> : std::true_type {};
template <class T> struct is_row_array : std::false_type {};
template <class R, std::size_t N> struct is_row_array<reg_array<R, N>> : std::true_type {};

template <class R, std::size_t N> consteval bool is_sound(const reg_array<R, N>& rows) {
    return is_sound(rows.first);
}
// Every use of a row asks for its type, so that none is used unchecked.
template <const auto& R> struct sound_row {
    static_assert(is_sound(R));
    using type = std::remove_cvref_t<decltype(R)>;
};
} // namespace detail

/// The class of row `R`: its `value_type`, `words`, `rights`, `device`; of an array of rows also `size`. A row
/// that contradicts itself does not compile.
template <const auto& R> using row_type = typename detail::sound_row<R>::type;

/// A register of `Owner` is one of `Device` too: the same device, or the family that it belongs to. A family
/// is a class with a profile that its variants inherit.
template <class Owner, class Device>
inline constexpr bool belongs_to = std::is_same_v<Owner, Device> || std::is_base_of_v<Owner, Device>;

template <const auto& R>
concept is_register = detail::is_row<std::remove_cvref_t<decltype(R)>>::value;
template <const auto& R>
concept is_register_array = detail::is_row_array<std::remove_cvref_t<decltype(R)>>::value;

/// Element `I` of an array of rows, as a row with a name of its own.
template <const auto& Rows, std::size_t I>
requires is_register_array<Rows> &&(I < row_type<Rows>::size) inline constexpr auto at = Rows[I];

} // namespace servobus
