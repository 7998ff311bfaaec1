// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A Modbus RTU server of libmodbus that has the values of values.hpp, as libmodbus' functions decode them, until it is
// killed. It prints each value that a request has changed.   libmodbus_values_server DEVICE
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include <modbus/modbus.h>

#include "registers.hpp"
#include "values.hpp"

#pragma GCC diagnostic ignored "-Wconversion" // of libmodbus' macros

namespace {
using interop::value_set;
using words = std::uint16_t*;

// libmodbus has functions for floats in all orders; those for integers have the high word first.
std::uint64_t joined(const std::uint16_t* at, unsigned count, bool is_high_first) {
    std::vector<std::uint16_t> in(at, at + count);
    if (!is_high_first) std::reverse(in.begin(), in.end());
    return count == 2 ? static_cast<std::uint32_t>(MODBUS_GET_INT32_FROM_INT16(in.data(), 0))
                      : static_cast<std::uint64_t>(MODBUS_GET_INT64_FROM_INT16(in.data(), 0));
}
void split(words at, unsigned count, std::uint64_t raw, bool is_high_first) {
    if (count == 2)
        MODBUS_SET_INT32_TO_INT16(at, 0, static_cast<std::int32_t>(raw));
    else
        MODBUS_SET_INT64_TO_INT16(at, 0, static_cast<std::int64_t>(raw));
    if (!is_high_first) std::reverse(at, at + count);
}

// The words of which `get` makes the value. The functions that set floats have wrong bytes in libmodbus 3.1.6.
void put_float(words at, float value, float (*get)(const std::uint16_t*)) {
    std::uint32_t raw = 0;
    std::memcpy(&raw, &value, sizeof raw);
    const auto high = static_cast<std::uint16_t>(raw >> 16), low = static_cast<std::uint16_t>(raw & 0xFFFF);
    const auto turned = [](std::uint16_t w) { return static_cast<std::uint16_t>(w << 8 | w >> 8); };
    const std::uint16_t ways[][2] = {
        {high, low}, {low, high}, {turned(high), turned(low)}, {turned(low), turned(high)}};
    for (const auto& way : ways) {
        if (get(way) == value) std::copy(way, way + 2, at);
    }
}

void fill(words at, const value_set& v, bool is_high_first) {
    using namespace interop;
    std::uint64_t raw = 0;
    std::memcpy(&raw, &v.f64, sizeof raw);
    put_float(at + f32_at, v.f32, is_high_first ? modbus_get_float_abcd : modbus_get_float_cdab);
    put_float(at + swapped_at, v.swapped, is_high_first ? modbus_get_float_badc : modbus_get_float_dcba);
    split(at + f64_at, 4, raw, is_high_first);
    split(at + u32_at, 2, v.u32, is_high_first);
    split(at + i32_at, 2, static_cast<std::uint32_t>(v.i32), is_high_first);
    split(at + u64_at, 4, v.u64, is_high_first);
    split(at + i64_at, 4, static_cast<std::uint64_t>(v.i64), is_high_first);
    std::vector<char> text(8);
    (void)std::snprintf(text.data(), text.size(), "%s", v.text);
    for (std::size_t i = 0; i < 4; ++i)
        at[text_at + i] = static_cast<std::uint16_t>(static_cast<unsigned char>(text[2 * i]) << 8 |
                                                     static_cast<unsigned char>(text[2 * i + 1]));
}

// A value as text, by the words from `at` on.
std::string shown(const std::string& what, const std::uint16_t* at, bool is_high_first) {
    using namespace interop;
    char text[40] = "";
    if (what == "f32") {
        const float v = (is_high_first ? modbus_get_float_abcd : modbus_get_float_cdab)(at + f32_at);
        (void)std::snprintf(text, sizeof text, "%.9g", static_cast<double>(v));
    } else if (what == "swapped") {
        const float v = (is_high_first ? modbus_get_float_badc : modbus_get_float_dcba)(at + swapped_at);
        (void)std::snprintf(text, sizeof text, "%.9g", static_cast<double>(v));
    } else if (what == "f64") {
        const std::uint64_t raw = joined(at + f64_at, 4, is_high_first);
        double v = 0;
        std::memcpy(&v, &raw, sizeof v);
        (void)std::snprintf(text, sizeof text, "%.17g", v);
    } else if (what == "text") {
        for (std::size_t i = 0; i < 8; ++i)
            text[i] = static_cast<char>(i % 2 == 0 ? at[text_at + i / 2] >> 8 : at[text_at + i / 2] & 0xFF);
    } else if (what == "u32") {
        return std::to_string(static_cast<std::uint32_t>(joined(at + u32_at, 2, is_high_first)));
    } else if (what == "i32") {
        return std::to_string(static_cast<std::int32_t>(joined(at + i32_at, 2, is_high_first)));
    } else if (what == "u64") {
        return std::to_string(joined(at + u64_at, 4, is_high_first));
    } else {
        return std::to_string(static_cast<std::int64_t>(joined(at + i64_at, 4, is_high_first)));
    }
    return text;
}
} // namespace

int main(int, char** arguments) {
    constexpr unsigned count = 0x0300;
    modbus_t* const server = modbus_new_rtu(arguments[1], interop::baud, 'N', 8, 1);
    modbus_mapping_t* const map = modbus_mapping_new(0, 0, count, count);
    if (server == nullptr || map == nullptr || modbus_set_slave(server, interop::node_address) != 0 ||
        modbus_connect(server) != 0) {
        (void)std::fprintf(stderr, "libmodbus_values_server: %s: %s\n", arguments[1], modbus_strerror(errno));
        return 1;
    }
    (void)modbus_set_byte_timeout(server, 0, 300'000); // on a busy machine a frame may arrive in pieces
    (void)modbus_set_error_recovery(server, MODBUS_ERROR_RECOVERY_PROTOCOL);
    const words all = map->tab_registers;
    fill(all + interop::high_first_block, interop::read_values, true);
    fill(all + interop::low_first_block, interop::read_values, false);
    std::vector<std::uint8_t> request(MODBUS_RTU_MAX_ADU_LENGTH);
    while (true) {
        const int size = modbus_receive(server, request.data());
        if (size < 0 && (errno == EIO || errno == EBADF)) return 1;
        if (size <= 0) continue;
        const std::vector<std::uint16_t> before(all, all + count);
        (void)modbus_reply(server, request.data(), size, map);
        for (const bool is_high_first : {true, false}) {
            const unsigned block = (is_high_first ? interop::high_first_block : interop::low_first_block) +
                                   interop::written_behind;
            for (const char* const what : {"f32", "f64", "u32", "i32", "u64", "i64", "swapped", "text"}) {
                const std::string now = shown(what, all + block, is_high_first);
                if (now != shown(what, before.data() + block, is_high_first))
                    std::printf("%s %s %s\n", is_high_first ? "high" : "low", what, now.c_str());
            }
        }
        (void)std::fflush(stdout);
    }
}
