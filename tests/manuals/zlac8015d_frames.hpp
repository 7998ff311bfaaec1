// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Every frame that the ZLAC8015D's manual prints (RS485 manual V1.07, sections 2 and 3), for the compiler.
// Made by frames.sh from zlac8015d_frames.csv; the tests compare the two.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>

namespace tests {

struct printed_frame {
    bool is_request;
    std::array<std::uint8_t, 17> data;
    std::size_t size;
    const char* meaning;

    constexpr servobus::bytes frame() const { return servobus::bytes{data.data(), size}; }
};

template <std::size_t Chars>
constexpr printed_frame printed(bool is_request, servobus::hex_text<Chars> text, const char* meaning) {
    printed_frame f{is_request, {}, text.size, meaning};
    for (std::size_t i = 0; i < text.size; ++i) f.data[i] = text.data[i];
    return f;
}

using servobus::hex;

// clang-format off
inline constexpr printed_frame zlac8015d_frames[] = {
    printed(true,  hex("01 03 20 AB 00 02 BE 2B"), "read 2 registers from 0x20AB: actual speed left and right"),
    printed(false, hex("01 03 04 00 64 00 64 BA 07"), "left 100, right 100 counts of 0.1 r/min: 10.0 r/min each"),
    printed(true,  hex("01 06 20 88 00 64 03 CB"), "write 0x2088 left target speed = 100 r/min"),
    printed(true,  hex("01 10 20 30 00 02 04 04 00 00 00 68 4A"), "write 0x2030 left encoder lines = 1024, 0x2031 Hall offset = 0"),
    printed(false, hex("01 10 20 30 00 02 4A 07"), "2 registers from 0x2030 written"),
    printed(true,  hex("01 06 20 0D 00 03 53 C8"), "write 0x200D operating mode = 3 (speed)"),
    printed(false, hex("01 06 20 0D 00 03 53 C8"), "echo of write 0x200D operating mode = 3 (speed)"),
    printed(true,  hex("01 06 20 80 01 F4 83 F5"), "write 0x2080 left S-curve acceleration time = 500 ms"),
    printed(false, hex("01 06 20 80 01 F4 83 F5"), "echo of write 0x2080 left S-curve acceleration time = 500 ms"),
    printed(true,  hex("01 06 20 81 01 F4 D2 35"), "write 0x2081 right S-curve acceleration time = 500 ms"),
    printed(false, hex("01 06 20 81 01 F4 D2 35"), "echo of write 0x2081 right S-curve acceleration time = 500 ms"),
    printed(true,  hex("01 06 20 82 01 F4 22 35"), "write 0x2082 left S-curve deceleration time = 500 ms"),
    printed(false, hex("01 06 20 82 01 F4 22 35"), "echo of write 0x2082 left S-curve deceleration time = 500 ms"),
    printed(true,  hex("01 06 20 83 01 F4 73 F5"), "write 0x2083 right S-curve deceleration time = 500 ms"),
    printed(false, hex("01 06 20 83 01 F4 73 F5"), "echo of write 0x2083 right S-curve deceleration time = 500 ms"),
    printed(true,  hex("01 06 20 0E 00 08 E2 0F"), "write 0x200E control word = 8: enable"),
    printed(false, hex("01 06 20 0E 00 08 E2 0F"), "echo of write 0x200E control word = 8: enable"),
    printed(true,  hex("01 06 20 88 00 64 03 CB"), "write 0x2088 left target speed = 100 r/min"),
    printed(false, hex("01 06 20 88 00 64 03 CB"), "echo of write 0x2088 left target speed = 100 r/min"),
    printed(true,  hex("01 06 20 88 FF 9C 43 B9"), "write 0x2088 left target speed = -100 r/min"),
    printed(false, hex("01 06 20 88 FF 9C 43 B9"), "echo of write 0x2088 left target speed = -100 r/min"),
    printed(true,  hex("01 06 20 0E 00 07 A2 0B"), "write 0x200E control word = 7: stop"),
    printed(false, hex("01 06 20 0E 00 07 A2 0B"), "echo of write 0x200E control word = 7: stop"),
    printed(true,  hex("01 06 20 89 00 64 52 0B"), "write 0x2089 right target speed = 100 r/min"),
    printed(false, hex("01 06 20 89 00 64 52 0B"), "echo of write 0x2089 right target speed = 100 r/min"),
    printed(true,  hex("01 06 20 89 FF 9C 12 79"), "write 0x2089 right target speed = -100 r/min"),
    printed(false, hex("01 06 20 89 FF 9C 12 79"), "echo of write 0x2089 right target speed = -100 r/min"),
    printed(true,  hex("01 06 20 0E 00 07 A2 0B"), "write 0x200E control word = 7: stop"),
    printed(false, hex("01 06 20 0E 00 07 A2 0B"), "echo of write 0x200E control word = 7: stop"),
    printed(true,  hex("01 10 20 88 00 02 04 00 64 00 64 23 9C"), "write 0x2088 left target speed = 100 r/min, 0x2089 right target speed = 100 r/min"),
    printed(false, hex("01 10 20 88 00 02 CA 22"), "2 registers from 0x2088 written"),
    printed(true,  hex("01 10 20 88 00 02 04 FF 9C FF 9C D2 0B"), "write 0x2088 left target speed = -100 r/min, 0x2089 right target speed = -100 r/min"),
    printed(false, hex("01 10 20 88 00 02 CA 22"), "2 registers from 0x2088 written"),
    printed(true,  hex("01 06 20 0E 00 07 A2 0B"), "write 0x200E control word = 7: stop"),
    printed(false, hex("01 06 20 0E 00 07 A2 0B"), "echo of write 0x200E control word = 7: stop"),
    printed(true,  hex("01 06 20 0F 00 00 B2 09"), "write 0x200F synchronous flag = 0 (asynchronous)"),
    printed(false, hex("01 06 20 0F 00 00 B2 09"), "echo of write 0x200F synchronous flag = 0 (asynchronous)"),
    printed(true,  hex("01 06 20 0D 00 01 D2 09"), "write 0x200D operating mode = 1 (relative position)"),
    printed(false, hex("01 06 20 0D 00 01 D2 09"), "echo of write 0x200D operating mode = 1 (relative position)"),
    printed(true,  hex("01 06 20 80 01 F4 83 F5"), "write 0x2080 left S-curve acceleration time = 500 ms"),
    printed(false, hex("01 06 20 80 01 F4 83 F5"), "echo of write 0x2080 left S-curve acceleration time = 500 ms"),
    printed(true,  hex("01 06 20 81 01 F4 D2 35"), "write 0x2081 right S-curve acceleration time = 500 ms"),
    printed(false, hex("01 06 20 81 01 F4 D2 35"), "echo of write 0x2081 right S-curve acceleration time = 500 ms"),
    printed(true,  hex("01 06 20 82 01 F4 22 35"), "write 0x2082 left S-curve deceleration time = 500 ms"),
    printed(false, hex("01 06 20 82 01 F4 22 35"), "echo of write 0x2082 left S-curve deceleration time = 500 ms"),
    printed(true,  hex("01 06 20 83 01 F4 73 F5"), "write 0x2083 right S-curve deceleration time = 500 ms"),
    printed(false, hex("01 06 20 83 01 F4 73 F5"), "echo of write 0x2083 right S-curve deceleration time = 500 ms"),
    printed(true,  hex("01 06 20 8E 00 32 63 F4"), "write 0x208E left maximum speed = 50 r/min"),
    printed(false, hex("01 06 20 8E 00 32 63 F4"), "echo of write 0x208E left maximum speed = 50 r/min"),
    printed(true,  hex("01 06 20 8F 00 32 32 34"), "write 0x208F right maximum speed = 50 r/min"),
    printed(false, hex("01 06 20 8F 00 32 32 34"), "echo of write 0x208F right maximum speed = 50 r/min"),
    printed(true,  hex("01 06 20 0E 00 08 E2 0F"), "write 0x200E control word = 8: enable"),
    printed(false, hex("01 06 20 0E 00 08 E2 0F"), "echo of write 0x200E control word = 8: enable"),
    printed(true,  hex("01 10 20 8A 00 02 04 00 00 50 00 DE 71"), "write 0x208A left target position = 20480 pulses"),
    printed(false, hex("01 10 20 8A 00 02 6B E2"), "2 registers from 0x208A written"),
    printed(true,  hex("01 06 20 0E 00 11 23 C5"), "write 0x200E control word = 17: start left"),
    printed(false, hex("01 06 20 0E 00 11 23 C5"), "echo of write 0x200E control word = 17: start left"),
    printed(true,  hex("01 10 20 8A 00 02 04 FF FF B0 00 97 95"), "write 0x208A left target position = -20480 pulses"),
    printed(false, hex("01 10 20 8A 00 02 6B E2"), "2 registers from 0x208A written"),
    printed(true,  hex("01 06 20 0E 00 11 23 C5"), "write 0x200E control word = 17: start left"),
    printed(false, hex("01 06 20 0E 00 11 23 C5"), "echo of write 0x200E control word = 17: start left"),
    printed(true,  hex("01 06 20 0E 00 07 A2 0B"), "write 0x200E control word = 7: stop"),
    printed(false, hex("01 06 20 0E 00 07 A2 0B"), "echo of write 0x200E control word = 7: stop"),
    printed(true,  hex("01 10 20 8C 00 02 04 00 00 50 00 5E 5B"), "write 0x208C right target position = 20480 pulses"),
    printed(false, hex("01 10 20 8C 00 02 8B E3"), "2 registers from 0x208C written"),
    printed(true,  hex("01 06 20 0E 00 12 63 C4"), "write 0x200E control word = 18: start right"),
    printed(false, hex("01 06 20 0E 00 12 63 C4"), "echo of write 0x200E control word = 18: start right"),
    printed(true,  hex("01 10 20 8C 00 02 04 FF FF B0 00 17 BF"), "write 0x208C right target position = -20480 pulses"),
    printed(false, hex("01 10 20 8C 00 02 8B E3"), "2 registers from 0x208C written"),
    printed(true,  hex("01 06 20 0E 00 12 63 C4"), "write 0x200E control word = 18: start right"),
    printed(false, hex("01 06 20 0E 00 12 63 C4"), "echo of write 0x200E control word = 18: start right"),
    printed(true,  hex("01 06 20 0E 00 07 A2 0B"), "write 0x200E control word = 7: stop"),
    printed(false, hex("01 06 20 0E 00 07 A2 0B"), "echo of write 0x200E control word = 7: stop"),
    printed(true,  hex("01 06 20 0F 00 01 73 C9"), "write 0x200F synchronous flag = 1 (synchronous)"),
    printed(false, hex("01 06 20 0F 00 01 73 C9"), "echo of write 0x200F synchronous flag = 1 (synchronous)"),
    printed(true,  hex("01 06 20 0D 00 01 D2 09"), "write 0x200D operating mode = 1 (relative position)"),
    printed(false, hex("01 06 20 0D 00 01 D2 09"), "echo of write 0x200D operating mode = 1 (relative position)"),
    printed(true,  hex("01 06 20 80 01 F4 83 F5"), "write 0x2080 left S-curve acceleration time = 500 ms"),
    printed(false, hex("01 06 20 80 01 F4 83 F5"), "echo of write 0x2080 left S-curve acceleration time = 500 ms"),
    printed(true,  hex("01 06 20 81 01 F4 D2 35"), "write 0x2081 right S-curve acceleration time = 500 ms"),
    printed(false, hex("01 06 20 81 01 F4 D2 35"), "echo of write 0x2081 right S-curve acceleration time = 500 ms"),
    printed(true,  hex("01 06 20 82 01 F4 22 35"), "write 0x2082 left S-curve deceleration time = 500 ms"),
    printed(false, hex("01 06 20 82 01 F4 22 35"), "echo of write 0x2082 left S-curve deceleration time = 500 ms"),
    printed(true,  hex("01 06 20 83 01 F4 73 F5"), "write 0x2083 right S-curve deceleration time = 500 ms"),
    printed(false, hex("01 06 20 83 01 F4 73 F5"), "echo of write 0x2083 right S-curve deceleration time = 500 ms"),
    printed(true,  hex("01 06 20 8E 00 32 63 F4"), "write 0x208E left maximum speed = 50 r/min"),
    printed(false, hex("01 06 20 8E 00 32 63 F4"), "echo of write 0x208E left maximum speed = 50 r/min"),
    printed(true,  hex("01 06 20 8F 00 32 32 34"), "write 0x208F right maximum speed = 50 r/min"),
    printed(false, hex("01 06 20 8F 00 32 32 34"), "echo of write 0x208F right maximum speed = 50 r/min"),
    printed(true,  hex("01 06 20 0E 00 08 E2 0F"), "write 0x200E control word = 8: enable"),
    printed(false, hex("01 06 20 0E 00 08 E2 0F"), "echo of write 0x200E control word = 8: enable"),
    printed(true,  hex("01 10 20 8A 00 04 08 00 00 50 00 00 00 50 00 E3 2C"), "write 0x208A left target position = 20480 pulses, 0x208C right target position = 20480 pulses"),
    printed(false, hex("01 10 20 8A 00 04 EB E0"), "4 registers from 0x208A written"),
    printed(true,  hex("01 06 20 0E 00 10 E2 05"), "write 0x200E control word = 16: start both"),
    printed(false, hex("01 06 20 0E 00 10 E2 05"), "echo of write 0x200E control word = 16: start both"),
    printed(true,  hex("01 10 20 8A 00 04 08 FF FF B0 00 FF FF B0 00 FC A3"), "write 0x208A left target position = -20480 pulses, 0x208C right target position = -20480 pulses"),
    printed(false, hex("01 10 20 8A 00 04 EB E0"), "4 registers from 0x208A written"),
    printed(true,  hex("01 06 20 0E 00 10 E2 05"), "write 0x200E control word = 16: start both"),
    printed(false, hex("01 06 20 0E 00 10 E2 05"), "echo of write 0x200E control word = 16: start both"),
    printed(true,  hex("01 06 20 0E 00 07 A2 0B"), "write 0x200E control word = 7: stop"),
    printed(false, hex("01 06 20 0E 00 07 A2 0B"), "echo of write 0x200E control word = 7: stop"),
    printed(true,  hex("01 06 20 0D 00 04 12 0A"), "write 0x200D operating mode = 4 (torque)"),
    printed(false, hex("01 06 20 0D 00 04 12 0A"), "echo of write 0x200D operating mode = 4 (torque)"),
    printed(true,  hex("01 06 20 86 01 F4 63 F4"), "write 0x2086 left torque slope = 500 mA/s"),
    printed(false, hex("01 06 20 86 01 F4 63 F4"), "echo of write 0x2086 left torque slope = 500 mA/s"),
    printed(true,  hex("01 06 20 87 01 F4 32 34"), "write 0x2087 right torque slope = 500 mA/s"),
    printed(false, hex("01 06 20 87 01 F4 32 34"), "echo of write 0x2087 right torque slope = 500 mA/s"),
    printed(true,  hex("01 06 20 0E 00 08 E2 0F"), "write 0x200E control word = 8: enable"),
    printed(false, hex("01 06 20 0E 00 08 E2 0F"), "echo of write 0x200E control word = 8: enable"),
    printed(true,  hex("01 06 20 90 07 D0 81 8B"), "write 0x2090 left target torque = 2000 mA"),
    printed(false, hex("01 06 20 90 07 D0 81 8B"), "echo of write 0x2090 left target torque = 2000 mA"),
    printed(true,  hex("01 06 20 90 F8 30 C1 F3"), "write 0x2090 left target torque = -2000 mA"),
    printed(false, hex("01 06 20 90 F8 30 C1 F3"), "echo of write 0x2090 left target torque = -2000 mA"),
    printed(true,  hex("01 06 20 0E 00 07 A2 0B"), "write 0x200E control word = 7: stop"),
    printed(false, hex("01 06 20 0E 00 07 A2 0B"), "echo of write 0x200E control word = 7: stop"),
    printed(true,  hex("01 06 20 91 07 D0 D0 4B"), "write 0x2091 right target torque = 2000 mA"),
    printed(false, hex("01 06 20 91 07 D0 D0 4B"), "echo of write 0x2091 right target torque = 2000 mA"),
    printed(true,  hex("01 06 20 91 F8 30 90 33"), "write 0x2091 right target torque = -2000 mA"),
    printed(false, hex("01 06 20 91 F8 30 90 33"), "echo of write 0x2091 right target torque = -2000 mA"),
    printed(true,  hex("01 06 20 0E 00 07 A2 0B"), "write 0x200E control word = 7: stop"),
    printed(false, hex("01 06 20 0E 00 07 A2 0B"), "echo of write 0x200E control word = 7: stop"),
    printed(true,  hex("01 10 20 90 00 02 04 07 D0 07 D0 60 23"), "write 0x2090 left target torque = 2000 mA, 0x2091 right target torque = 2000 mA"),
    printed(false, hex("01 10 20 90 00 02 4A 25"), "2 registers from 0x2090 written"),
    printed(true,  hex("01 10 20 90 00 02 04 F8 30 F8 30 11 B9"), "write 0x2090 left target torque = -2000 mA, 0x2091 right target torque = -2000 mA"),
    printed(false, hex("01 10 20 90 00 02 4A 25"), "2 registers from 0x2090 written"),
    printed(true,  hex("01 06 20 0E 00 07 A2 0B"), "write 0x200E control word = 7: stop"),
    printed(false, hex("01 06 20 0E 00 07 A2 0B"), "echo of write 0x200E control word = 7: stop"),
    printed(true,  hex("01 06 20 0E 00 05 23 CA"), "write 0x200E control word = 5: quick stop"),
    printed(false, hex("01 06 20 0E 00 05 23 CA"), "echo of write 0x200E control word = 5: quick stop"),
    printed(true,  hex("01 06 20 0E 00 06 63 CB"), "write 0x200E control word = 6: clear fault"),
    printed(false, hex("01 06 20 0E 00 06 63 CB"), "echo of write 0x200E control word = 6: clear fault"),
    printed(true,  hex("01 06 20 1A 00 01 62 0D"), "write 0x201A output B0 function = 1 (close left brake)"),
    printed(false, hex("01 06 20 1A 00 01 62 0D"), "echo of write 0x201A output B0 function = 1 (close left brake)"),
};
// clang-format on

} // namespace tests
