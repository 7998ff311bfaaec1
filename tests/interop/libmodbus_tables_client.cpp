// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A client of libmodbus with the library's server of rows, on a serial device: all functions that libmodbus has. It
// notes what it changes in a file, a register or a coil a line.   libmodbus_tables_client DEVICE FILE
#include <cerrno>
#include <cstdio>
#include <vector>

#include <modbus/modbus.h>

#include "registers.hpp"
#include "report.hpp"

using interop::check;

namespace {

constexpr int first = interop::first;
constexpr int coil = interop::first_coil;
constexpr int input = interop::first_input;

void reads(modbus_t* own) {
    for (const int n : {1, 8, 9, 17}) {
        std::vector<std::uint8_t> bits(static_cast<std::size_t>(n));
        bool is_same = modbus_read_bits(own, coil, n, bits.data()) == n;
        for (int i = 0; i < n; ++i)
            is_same = is_same && (bits[static_cast<std::size_t>(i)] != 0) ==
                                     interop::initial_bit(static_cast<unsigned>(coil + i));
        check(is_same, "libmodbus reads by 01 " + std::to_string(n));
    }
    for (const int n : {1, 8, 11}) {
        std::vector<std::uint8_t> bits(static_cast<std::size_t>(n));
        bool is_same = modbus_read_input_bits(own, input, n, bits.data()) == n;
        for (int i = 0; i < n; ++i)
            is_same = is_same && (bits[static_cast<std::size_t>(i)] != 0) ==
                                     interop::initial_bit(static_cast<unsigned>(input + i));
        check(is_same, "libmodbus reads by 02 " + std::to_string(n));
    }
    for (const bool is_input : {false, true}) {
        std::vector<std::uint16_t> words(125);
        bool is_same = (is_input ? modbus_read_input_registers(own, first, 125, words.data())
                                 : modbus_read_registers(own, first, 125, words.data())) == 125;
        for (unsigned i = 0; i < 125; ++i)
            is_same = is_same && words[i] == interop::initial(interop::first + i);
        check(is_same, std::string{"libmodbus reads by "} + (is_input ? "04" : "03") + " 125");
    }
}

void exceptions(modbus_t* own) {
    std::uint8_t bits[2]{};
    std::uint16_t word = 0;
    check(modbus_read_bits(own, coil + 17, 1, bits) == -1 && errno == EMBXILADD, "01: exception 2");
    check(modbus_read_input_bits(own, input + 10, 2, bits) == -1 && errno == EMBXILADD, "02: exception 2");
    check(modbus_write_bit(own, 0, 1) == -1 && errno == EMBXILADD, "05: exception 2");
    check(modbus_write_bits(own, coil + 16, 2, bits) == -1 && errno == EMBXILADD, "0F: exception 2");
    check(modbus_mask_write_register(own, 0x3000, 0, 0) == -1 && errno == EMBXILADD, "16h: exception 2");
    check(modbus_write_and_read_registers(own, 0x3000, 1, &word, first, 1, &word) == -1 && errno == EMBXILADD,
          "17h: exception 2");
}

void writes(modbus_t* own, std::FILE* notes) {
    std::uint8_t one = 0;
    check(modbus_write_bit(own, coil, 1) == 1 && modbus_read_bits(own, coil, 1, &one) == 1 && one == 1,
          "libmodbus writes by 05, on");
    check(modbus_write_bit(own, coil, 0) == 1 && modbus_read_bits(own, coil, 1, &one) == 1 && one == 0,
          "libmodbus writes by 05, off");
    (void)std::fprintf(notes, "coil %04X=1\ncoil %04X=0\n", interop::first_coil, interop::first_coil);
    std::vector<std::uint8_t> all(interop::coils), held(interop::coils);
    for (unsigned i = 0; i < interop::coils; ++i) {
        all[i] = i % 2 == 1 ? 1 : 0;
        if ((all[i] != 0) != interop::initial_bit(interop::first_coil + i))
            (void)std::fprintf(notes, "coil %04X=%d\n", interop::first_coil + i, int{all[i]});
    }
    constexpr int n = interop::coils;
    check(modbus_write_bits(own, coil, n, all.data()) == n &&
              modbus_read_bits(own, coil, n, held.data()) == n && held == all,
          "libmodbus writes by 0F, 17");
    std::uint16_t word = 0;
    check(modbus_write_register(own, first + 20, 0x5A14) == 1 &&
              modbus_read_registers(own, first + 20, 1, &word) == 1 && word == 0x5A14,
          "libmodbus writes by 06");
    (void)std::fprintf(notes, "2014=5A14\n");
    std::vector<std::uint16_t> many(123), back(123);
    for (unsigned i = 0; i < 123; ++i) {
        many[i] = static_cast<std::uint16_t>(0x3C00 + i);
        (void)std::fprintf(notes, "%04X=%04X\n", interop::first + 60 + i, unsigned{many[i]});
    }
    check(modbus_write_registers(own, first + 60, 123, many.data()) == 123 &&
              modbus_read_registers(own, first + 60, 123, back.data()) == 123 && back == many,
          "libmodbus writes by 10h, 123");
    const unsigned masked = (interop::initial(interop::first + 30) & 0xF0FFu) | 0x0500u;
    check(modbus_mask_write_register(own, first + 30, 0xF0FF, 0x0500) == 1 &&
              modbus_read_registers(own, first + 30, 1, &word) == 1 && word == masked,
          "libmodbus changes bits by 16h");
    (void)std::fprintf(notes, "201E=%04X\n", masked);
    const std::uint16_t beef = 0xBEEF;
    std::uint16_t two[2]{};
    check(modbus_write_and_read_registers(own, first + 41, 1, &beef, first + 40, 2, two) == 2 &&
              two[0] == interop::initial(interop::first + 40) && two[1] == 0xBEEF,
          "libmodbus writes and reads by 17h");
    (void)std::fprintf(notes, "2029=BEEF\n");
}

void server_id(modbus_t* own) {
    std::uint8_t id[64]{};
    const int size = modbus_report_slave_id(own, sizeof id, id);
    const bool is_whole = size == 14;
    check(is_whole && std::string(id, id + 6) == "tables" && id[6] == 0xFF, "libmodbus reads the ID by 11h");
    check(is_whole && std::string(id + 7, id + 14) == "T17 1.0",
          "libmodbus reads the additional data by 11h");
}

} // namespace

int main(int, char** args) {
    modbus_t* const own = modbus_new_rtu(args[1], interop::baud, 'N', 8, 1);
    std::FILE* const notes = std::fopen(args[2], "w");
    if (own == nullptr || notes == nullptr || modbus_set_slave(own, interop::node_address) != 0 ||
        modbus_connect(own) != 0) {
        check(false, std::string{"libmodbus opens "} + args[1] + ": " + modbus_strerror(errno));
        return 1;
    }
    (void)modbus_set_response_timeout(own, 5, 0); // on a busy machine the server may respond late
    (void)modbus_set_byte_timeout(own, 5, 0);
    reads(own);
    exceptions(own);
    writes(own, notes);
    server_id(own);
    (void)std::fclose(notes);
    modbus_free(own);
    return interop::failed == 0 ? 0 : 1;
}
