// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A client of libmodbus with the library's server, on a serial device. It notes what it writes in a file, a
// register a line.   libmodbus_client DEVICE FILE
#include <cerrno>
#include <cstdio>
#include <vector>

#include <modbus/modbus.h>

#include "registers.hpp"
#include "report.hpp"

using interop::check;

namespace {

constexpr int first = interop::first;
constexpr int count = interop::count;

void reads(modbus_t* own, int n, int address, bool input) {
    std::vector<std::uint16_t> words(static_cast<std::size_t>(n));
    const int got = input ? modbus_read_input_registers(own, address, n, words.data())
                          : modbus_read_registers(own, address, n, words.data());
    bool is_same = got == n;
    for (int i = 0; i < n; ++i)
        is_same = is_same &&
                  words[static_cast<std::size_t>(i)] == interop::initial(static_cast<unsigned>(address + i));
    check(is_same, std::string{"libmodbus reads by "} + (input ? "04 " : "03 ") + std::to_string(n));
}

void writes(modbus_t* own, int n, int address, bool single, std::FILE* notes) {
    std::vector<std::uint16_t> words;
    for (int i = 0; i < n; ++i) words.push_back(static_cast<std::uint16_t>(0x5A00 + 11 * i + n));
    const int got = single ? modbus_write_register(own, address, words[0])
                           : modbus_write_registers(own, address, n, words.data());
    check(got == n, std::string{"libmodbus writes by "} + (single ? "06 " : "10h ") + std::to_string(n));
    for (int i = 0; i < n; ++i)
        (void)std::fprintf(notes, "%04X=%04X\n", static_cast<unsigned>(address + i),
                           unsigned{words[static_cast<std::size_t>(i)]});
    std::vector<std::uint16_t> held(words.size());
    check(modbus_read_registers(own, address, n, held.data()) == n && held == words,
          "libmodbus reads back " + std::to_string(n));
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
    std::uint16_t word = 0;
    bool answers = false;
    for (int tries = 0; tries < 20 && !answers; ++tries)
        answers = modbus_read_registers(own, first, 1, &word) == 1;
    check(answers, "the library's server responds to libmodbus");
    if (!answers) return 1;
    for (const int n : {1, 2, 125}) {
        reads(own, n, first, false);
        reads(own, n, first + count - n, true);
    }
    check(modbus_read_registers(own, 0x3000, 1, &word) == -1 && errno == EMBXILADD,
          "libmodbus receives an exception: no such register");
    check(modbus_write_register(own, 0x3000, 1) == -1 && errno == EMBXILADD,
          "libmodbus receives an exception: no such register to write");
    std::uint16_t two[2] = {};
    check(modbus_write_registers(own, first + count - 1, 2, two) == -1 && errno == EMBXILADD,
          "libmodbus receives an exception: one of two registers does not exist");
    std::uint8_t bits[1] = {};
    check(modbus_read_bits(own, 0, 1, bits) == -1 && errno == EMBXILFUN,
          "libmodbus receives an exception: no coils");
    writes(own, 1, first + 20, true, notes);
    writes(own, 1, first + 21, false, notes);
    writes(own, 123, first + 30, false, notes);
    (void)std::fclose(notes);
    modbus_free(own);
    return interop::failed == 0 ? 0 : 1;
}
