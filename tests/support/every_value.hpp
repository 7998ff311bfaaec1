// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A device with a row of each type of value and each option, in both word orders, and its model in memory. The model's
// words are made here, from the standards of the encodings.
#pragma once

#include <cstdint>
#include <cstring>
#include <vector>

#include <servobus/any_value.hpp>
#include <tests/support/plain_tables.hpp>

namespace tests::every_value {

using namespace servobus;
using namespace servobus::units;

template <word_order Order, bool Blocks = false> struct device {
    static constexpr profile facts{.name = "every_value",
                                   .word_order = Order,
                                   .baud = 115200,
                                   .writes_blocks_only = Blocks ? block_writes::all : block_writes::none};
};
enum class phase : std::uint32_t { idle = 1, heating = 0x0001'0002 };
enum class mode : std::uint16_t { off, on, automatic };

template <class Device> struct rows {
    template <class T> using ro = reg<T, access::ro, Device>;
    template <class T> using rw = reg<T, access::rw, Device>;
    template <class T> using input = input_reg<T, Device>;

    static constexpr input<f32> voltage{0x0000, full<f32>, volt, no_default};
    static constexpr input<f64> flow{0x0002, full<f64>, litre_per_minute, no_default};
    static constexpr input<u64> counter{0x0006, full<u64>, no_unit, no_default};
    static constexpr reg_array<input<u64>, 3> counters{{0x0010, full<u64>, no_unit, no_default}, 4};
    static constexpr reg_array<input<f32>, 2> currents{{0x0020, full<f32>, ampere, no_default}, 2};

    static constexpr rw<f32> target{0x0010, {-20, 400}, degree_celsius, 21};
    static constexpr rw<f32> gain{0x0012, full<f32>, no_unit, no_default};
    static constexpr rw<f64> ratio{0x0014, full<f64>, no_unit, no_default};
    static constexpr rw<u64> energy{0x0020, full<u64>, watt_hour, no_default};
    static constexpr rw<u16> after_energy{0x0024, full<u16>, no_unit, no_default};
    static constexpr rw<i64> balance{0x0025, full<i64>, watt_hour, no_default};
    static constexpr rw<u64> serial_code{0x0029, full<u64>, no_unit, no_default};
    static constexpr rw<text_of<4>> name{0x0030, full<text_of<4>>, no_unit, no_default};
    static constexpr rw<with<text_of<3>, low_byte_first>> model{0x0034, full<text_of<3>>, no_unit,
                                                                no_default};
    static constexpr rw<with<u16, bits<0, 3>>> selector{0x0040, full<u16>, no_unit, no_default};
    static constexpr rw<with<u16, bits<4, 15>>> level{0x0040, {0, 1000}, percent / 10, no_default};
    static constexpr ro<with<i16, servobus::high_byte>> inside{0x0041, full<i16>, degree_celsius, no_default};
    static constexpr ro<with<i16, servobus::low_byte>> outside{0x0041, full<i16>, degree_celsius, no_default};
    static constexpr rw<bcd<1>> hour{0x0042, full<bcd<1>>, no_unit, no_default};
    static constexpr rw<bcd<2>> date{0x0043, full<bcd<2>>, no_unit, no_default};
    static constexpr rw<sign_magnitude<1>> torque{0x0045, full<sign_magnitude<1>>, percent, no_default};
    static constexpr rw<sign_magnitude<2>> current{0x0046, full<sign_magnitude<2>>, ampere / 1000,
                                                   no_default};
    static constexpr rw<with<u16, offset<-1000>>> battery{
        0x0048, {-400, 800}, degree_celsius / 10, no_default};
    static constexpr ro<with<i32, or_none<-0x8000'0000ll>>> ac_power{0x0049, full<i32>, watt, no_default};
    static constexpr rw<with<u32, low_word_first>> low_word{0x004B, full<u32>, kilowatt_hour, no_default};
    static constexpr rw<with<u32, high_word_first>> high_word{0x004D, full<u32>, kilowatt_hour, no_default};
    static constexpr rw<with<f32, low_byte_first>> swapped{0x004F, full<f32>, volt, no_default};
    static constexpr rw<phase> now{0x0051, {0, 0x0001'0002}, no_unit, no_default};
    static constexpr rw<with<mode, bits<14, 15>>> operation{0x0053, {0, 2}, no_unit, no_default};
    static constexpr ro<i16> exponent{0x0054, full<i16>, no_unit, no_default};
    static constexpr ro<with<i16, or_none<-0x8000>, ten_to<exponent>>> power{0x0055, full<i16>, watt,
                                                                             no_default};
    static constexpr ro<with<u64, ten_to<exponent>>> total{0x0056, full<u64>, watt_hour, no_default};
    static constexpr rw<u16> ct_ratio{0x005A, {1, 1000}, times, 1};
    static constexpr ro<with<u16, times_row<ct_ratio>>> primary{0x005B, full<u16>, ampere / 1000, no_default};

    static constexpr ro<with<i16, or_none<-0x8000>>> own_exponent{0x005C, full<i16>, no_unit, no_default};
    static constexpr ro<with<u16, ten_to<own_exponent>>> own_power{0x005D, full<u16>, watt, no_default};
    static constexpr ro<with<u16, or_none<0>>> own_ratio{0x005E, full<u16>, no_unit, no_default};
    static constexpr ro<with<u16, times_row<own_ratio>>> own_current{0x005F, full<u16>, ampere / 1000,
                                                                     no_default};

    static constexpr coil<access::rw, Device> relay{0x0000};
    static constexpr coil<access::rw, Device> lamp{0x0001};
};

/// The words of an IEEE number or an integer.
template <class T> std::vector<unsigned> words_of(T value, word_order order) {
    std::uint64_t raw = 0;
    if constexpr (sizeof(T) == 4) {
        std::uint32_t half = 0;
        std::memcpy(&half, &value, 4);
        raw = half;
    } else {
        std::memcpy(&raw, &value, 8);
    }
    std::vector<unsigned> words;
    for (unsigned at = 8 * sizeof(T); at != 0;)
        words.push_back(static_cast<unsigned>(raw >> (at -= 16) & 0xFFFF));
    if (order == word_order::low_first) words = {words.rbegin(), words.rend()};
    return words;
}
inline void put(std::map<unsigned, unsigned>& registers, unsigned address,
                const std::vector<unsigned>& words) {
    for (const unsigned w : words) registers[address++] = w;
}

/// The device's memory.
inline plain_tables model(word_order order) {
    plain_tables t;
    for (unsigned a = 0; a < 0x40; ++a) t.input_registers[a] = 0;
    for (unsigned a = 0; a < 0x60; ++a) t.holding_registers[a] = 0;
    t.coils = {{0, false}, {1, false}};
    put(t.input_registers, 0x00, words_of(230.1f, order));
    put(t.input_registers, 0x02, words_of(-12.5, order));
    put(t.input_registers, 0x06, words_of(std::uint64_t{0xFFFF'FFFF'FFFF'FFFE}, order));
    put(t.input_registers, 0x18, words_of(std::uint64_t{7}, order));
    put(t.input_registers, 0x22, words_of(1.5f, order));
    put(t.holding_registers, 0x10, words_of(21.5f, order));
    put(t.holding_registers, 0x14, words_of(1e-300, order));
    put(t.holding_registers, 0x20, words_of(std::uint64_t{4'294'967'298}, order));
    t.holding_registers[0x24] = 9;
    put(t.holding_registers, 0x25, words_of(std::int64_t{-5}, order));
    put(t.holding_registers, 0x30, {0x4B50, 0x4537, 0x4200, 0x5858}); // a zero ends it
    put(t.holding_registers, 0x34, {0x4548, 0x5441, 0x2031});         // "HEAT1 "
    put(t.holding_registers, 0x40, {0x0641, 0x15FB, 0x0023});
    put(t.holding_registers, 0x43, words_of(std::uint32_t{0x2026'1201}, order));
    t.holding_registers[0x45] = 0x8003;
    put(t.holding_registers, 0x46, words_of(std::uint32_t{0x8000'0BB8}, order));
    t.holding_registers[0x48] = 1253;
    put(t.holding_registers, 0x49, words_of(std::uint32_t{0x8000'0000}, order));
    put(t.holding_registers, 0x4B, {0x01D0, 0x0001, 0x0001, 0x01D0});
    put(t.holding_registers, 0x4F,
        order == word_order::low_first ? std::vector<unsigned>{0x9A19, 0x6643}
                                       : std::vector<unsigned>{0x6643, 0x9A19});
    put(t.holding_registers, 0x51, words_of(std::uint32_t{0x0001'0002}, order));
    put(t.holding_registers, 0x53, {0x8001, 0xFFFE, 0x04D2});
    put(t.holding_registers, 0x56, words_of(std::uint64_t{123'456}, order));
    put(t.holding_registers, 0x5A, {100, 40});
    return t;
}

} // namespace tests::every_value
