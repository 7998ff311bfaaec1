// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A register row: one constexpr object that describes a register like a line of the manual's table. Device
// headers include it; programs include it to describe the registers of a device of their own.
//
//     struct winch; // the device
//     constexpr reg<u16, access::rw, winch> ramp_time{0x0003, {10, 5000}, units::millisecond, 500, saved};
//     static_assert(ramp_time.limits.contains(5000) && ramp_time.words == 1);
//
// The type of a row has the value's type, the access and the device; address, range, unit, default and flags
// are data. Rows are used as reference template arguments (`read<bus_voltage>()`), so that they take no
// flash.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/registers/unit.hpp>
#include <servobus/registers/wire.hpp>

namespace servobus {

/// Access rights: read-only, read and write, write-only.
enum class access : std::uint8_t { ro, rw, wo };

/// Further properties of a register; they can be combined by `|`.
enum class flag : std::uint16_t {
    none = 0,
    saved = 1,               ///< kept over a power cycle after a command to save
    saved_on_write = 2,      ///< kept by each write, which wears the EEPROM
    when_stopped = 4,        ///< may be written only while the motor is stopped
    when_running = 8,        ///< may be written at any time
    trigger = 16,            ///< a write may start, enable, reset or save: the library repeats only stops
    scaled_elsewhere = 32,   ///< another register can change its scale at run time
    immediate = 64,          ///< a new value takes effect immediately
    at_stop = 128,           ///< a new value takes effect when the motor stops next
    after_power_cycle = 256, ///< a new value takes effect after the next power cycle
    communication = 512,     ///< address or baud rate: the response may already use the new setting
    motion = 1024,           ///< a target: a write moves an enabled motor
    position_mode = 2048,    ///< has an effect in position control
    speed_mode = 4096,       ///< has an effect in speed control
    torque_mode = 8192,      ///< has an effect in torque control
    every_mode = 16384,      ///< has an effect in every mode of control
    zero_by_name = 32768,    ///< 0 is in range without a stated meaning: written only as `undocumented_zero`
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

/// The four tables of the standard, in the order of the functions that read them, 01 .. 04.
enum class table : std::uint8_t { coils, discrete_inputs, holding_registers, input_registers };

/// The lowest and the highest raw value of a register.
struct range {
    std::int64_t low = 0;
    std::int64_t high = 0;
    bool is_stated = true; ///< false: the manual states no range, and the value's type is the limit

    friend constexpr bool operator==(range, range) = default;
    constexpr bool contains(std::int64_t v) const { return v >= low && v <= high; }
};

/// The range of the value's type, for registers without a stated range.
template <class T> inline constexpr range full{detail::lowest<T>, detail::highest<T>, false};

/// The range of a packed word without a stated range.
inline constexpr range unstated{0, 0xFFFF, false};

/// The default of a register for which the manual states none.
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

template <class T> struct codec; // registers/values.hpp

/// The limits and the number of words of a value's type.
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

/// A register of `Device` that holds a `T`. A row is data only, to keep the compile time of a map with
/// hundreds of rows low. It is checked for contradictions where it is first used; a catalogue checks all rows
/// of a map.
template <class T, access Rights, class Device> struct reg {
    using value_type = T;
    using device = Device;
    static constexpr access rights = Rights;
    static constexpr std::size_t words = detail::words_in<T>;

    u16 address;          ///< of the first word
    range limits;         ///< of the raw value
    unit unit_of_count;   ///< what one count is worth
    std::int64_t initial; ///< factory default, raw, or `no_default`
    flag flags = flag::none;
};

namespace detail {
enum class row_fault : std::uint8_t {
    none,
    range_order,
    range_in_type,
    default_in_range,
    unit,
    last_address
};

/// The first contradiction of a row: the range must lie in the type, the default in the range.
template <class T, access Rights, class Device>
constexpr row_fault fault_of(const reg<T, Rights, Device>& row) {
    static_assert(wire_value<T> || has_codec<T>,
                  "a register holds an integer of 16 or 32 bits, a 16-bit enumeration or a "
                  "class that packs one word; servobus/any_value.hpp has other values");
    if constexpr (has_codec<T>) codec<T>::check();
    const shape of = shape_of<T>;
    const range within = row.limits;
    if (within.low > within.high) return row_fault::range_order;
    if ((within.low < of.low || within.high > of.high) && (within.is_stated || !has_codec<T>))
        return row_fault::range_in_type;
    if (row.initial != no_default && !within.contains(row.initial)) return row_fault::default_in_range;
    if (row.unit_of_count.of == measure::none && !row.unit_of_count.is_plain()) return row_fault::unit;
    if (row.address > 0x1'0000 - of.words) return row_fault::last_address;
    return row_fault::none;
}
/// Rejects a constant row that contradicts itself at compile time.
template <class T, access Rights, class Device> constexpr void check_row(const reg<T, Rights, Device>& row) {
    switch (fault_of(row)) {
    case row_fault::none: return;
    case row_fault::range_order: return a_register_range_is_low_to_high();
    case row_fault::range_in_type: return a_register_range_lies_inside_its_value_type();
    case row_fault::default_in_range: return a_register_default_lies_inside_its_range();
    case row_fault::unit: return a_scaled_register_has_a_unit();
    case row_fault::last_address: return a_two_word_register_ends_inside_the_address_space();
    }
}
} // namespace detail

namespace detail {
// The addresses that a row takes.
template <class Row> inline constexpr std::size_t addresses_in = Row::words;
} // namespace detail

/// `Count` rows that are equal except for their addresses, which are `stride` apart, such as the segments of
/// a positioning table or the coils of a relay module. `rows[i]` is a row by value; `at<rows, i>` is a row for use as a
/// template argument.
template <class Row, std::size_t Count> struct reg_array {
    using row = Row;
    using value_type = typename Row::value_type;
    using device = typename Row::device;
    static constexpr access rights = Row::rights;
    static constexpr std::size_t words = detail::addresses_in<Row>; ///< of a coil or an input: 1
    static constexpr std::size_t size = Count;

    Row first;
    u16 stride;

    /// Elements that overlap, or lie beyond the address space, do not compile.
    consteval reg_array(const Row& element_0, u16 step) : first{element_0}, stride{step} {
        if (step < words) detail::elements_of_an_array_do_not_overlap();
        if (element_0.address + (Count - 1) * step + words > 0x1'0000u)
            detail::an_array_ends_inside_the_address_space();
    }

    /// Row `i`, counted from 0; the index is not checked.
    constexpr Row operator[](std::size_t i) const {
        Row element = first;
        element.address = static_cast<u16>(first.address + i * stride);
        return element;
    }
};

namespace detail {
template <class T> struct is_row : std::false_type {};
template <class T, access A, class D> struct is_row<reg<T, A, D>> : std::true_type {};
template <class T> struct is_row_array : std::false_type {};
template <class R, std::size_t N> struct is_row_array<reg_array<R, N>> : std::true_type {};

template <class R, std::size_t N> consteval row_fault fault_of(const reg_array<R, N>& rows) {
    return fault_of(rows.first);
}
// An assertion's words are in the first line of the error. One instance serves for all rows without a fault.
template <row_fault Fault> consteval bool allows_row() {
    static_assert(Fault != row_fault::range_order, "a_register_range_is_low_to_high");
    static_assert(Fault != row_fault::range_in_type, "a_register_range_lies_inside_its_value_type");
    static_assert(Fault != row_fault::default_in_range, "a_register_default_lies_inside_its_range");
    static_assert(Fault != row_fault::unit, "a_scaled_register_has_a_unit");
    static_assert(Fault != row_fault::last_address, "a_two_word_register_ends_inside_the_address_space");
    return true;
}
// Each use of a row needs its type, so every row that is used is checked.
template <const auto& R> struct sound_row {
    static_assert(allows_row<fault_of(R)>());
    using type = std::remove_cvref_t<decltype(R)>;
};
} // namespace detail

/// The class of row `R`: its `value_type`, `words`, `rights`, `device`; of an array of rows also `size`. A
/// row that contradicts itself does not compile.
template <const auto& R> using row_type = typename detail::sound_row<R>::type;

/// True if `Device` has the registers of `Owner`: the two are the same device, or `Owner` is its family. A
/// family is a class with a profile from which the classes of its variants derive.
template <class Owner, class Device>
inline constexpr bool belongs_to = std::is_same_v<Owner, Device> || std::is_base_of_v<Owner, Device>;

namespace detail {
template <class Row> inline constexpr table table_of_row = table::holding_registers;
template <class Row, std::size_t N>
inline constexpr table table_of_row<reg_array<Row, N>> = table_of_row<Row>;
// True for a row whose codec takes words.
template <const auto& R>
concept needs_words = takes_words<typename std::remove_cvref_t<decltype(R)>::value_type>;
// The rows that the calls of any_device.hpp read: those of other tables, and those whose codec takes words.
template <const auto& R>
concept needs_table_calls = table_of_row<std::remove_cvref_t<decltype(R)>>
!= table::holding_registers || needs_words<R>;
// The device of a row or of an array of rows.
template <const auto& R>
concept has_bits = table_of_row<std::remove_cvref_t<decltype(R)>>
<= table::discrete_inputs;
} // namespace detail

/// The table of row `R`, or of an array of rows. A `reg` is a holding register; registers/tables.hpp has the others.
template <const auto& R>
inline constexpr table table_of = detail::table_of_row<std::remove_cvref_t<decltype(R)>>;

/// True if `R` is a row of registers.
template <const auto& R>
concept is_register = detail::is_row<std::remove_cvref_t<decltype(R)>>::value;
/// True if `R` is an array of rows, of any table.
template <const auto& R>
concept is_register_array = detail::is_row_array<std::remove_cvref_t<decltype(R)>>::value;
/// True if `R` is a coil or a discrete input.
template <const auto& R>
concept is_bit = detail::has_bits<R> && !is_register_array<R>;

/// Element `I` of an array of rows, counted from 0, as a row for use as a template argument.
template <const auto& Rows, std::size_t I>
requires is_register_array<Rows> &&(I < row_type<Rows>::size) inline constexpr
    typename row_type<Rows>::row at = Rows[I]; // not `auto`: g++ 12 cannot deduce it in an overload

} // namespace servobus
