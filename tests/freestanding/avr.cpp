// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The protocol core on an ATmega328P, whose int has 16 bits: CRC, building and parsing frames, registers of
// 16 and 32 bits, and transactions of a client over a simulated port on which the library's server
// responds. It writes failed checks, and at the end the number of passed ones, to its UART; the simulator
// prints them.
#include <servobus/modbus/crc_tables.hpp>
#include <servobus/modbus/functions.hpp>
#include <servobus/modbus/growing_response.hpp>
#include <servobus/modbus/server.hpp>
#include <servobus/servobus.hpp>

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

using namespace servobus;
using namespace servobus::modbus;

namespace {

void put(char c) {
    while ((UCSR0A & _BV(UDRE0)) == 0) {}
    UDR0 = static_cast<std::uint8_t>(c);
}
void put(const char* text) {
    for (; *text != 0; ++text) put(*text);
}
void put(std::uint16_t number) {
    if (number >= 10) put(static_cast<std::uint16_t>(number / 10));
    put(static_cast<char>('0' + number % 10));
}

std::uint16_t passed = 0;
std::uint16_t failed = 0;

void check(bool holds, std::uint16_t at_line) {
    if (holds) {
        ++passed;
        return;
    }
    ++failed;
    put("failed: line ");
    put(at_line);
    put('\n');
}

// The other functions, evaluated by the compiler with this core's int.
static_assert(check_response(hex("02 00 C4 00 16"), hex("02 03 AC DB 35")));
static_assert(check_response(hex("02 00 C4 00 16"), hex("02 03 AC DB 75")) == errc::unexpected_value);
static_assert(check_request(hex("01 00 00 07 D0")) == errc::ok && bytes_of_bits(0xFFFF) == 0x2000);
static_assert(check_request(hex("01 FF FF 00 02")) == errc::wrong_address);
static_assert(check_request(hex("05 00 AC FF FF")) == errc::wrong_value);
static_assert(check_response(hex("0B"), hex("0B FF FF FF FF")));
static_assert(check_response(hex("18 04 DE"), hex("18 00 02 80 00")) == errc::wrong_quantity);
static_assert(check_response(hex("18 04 DE"), hex("18 FF FF 00 00")) == errc::wrong_byte_count);
static_assert(growing_response{hex("18 04 DE")}.least_length(hex("18 FF FF")) == 3);
static_assert(mask_write{0, 0x7FFF, 0x8000}.applied_to(0) == 0x8000);

struct device {
    static constexpr profile facts{.name = "node", .word_order = word_order::low_first};
};
constexpr reg<u16, access::rw, device> level{0x2000, full<u16>, no_unit, 0};
constexpr reg<i16, access::rw, device> speed{0x2001, {-3000, 3000}, units::r_per_min / 10, 0};
constexpr reg<i32, access::rw, device> place{0x2002, full<i32>, units::pulse, 0};

/// The registers 2000h .. 2003h.
struct store {
    std::uint16_t words[4] = {0xBEEF, 0, 0, 0};

    std::uint8_t read(std::uint16_t address, slice<std::uint16_t> to) {
        if (address < 0x2000 || to.size() + (address - 0x2000u) > 4) return 2;
        for (std::size_t i = 0; i < to.size(); ++i) to[i] = words[address - 0x2000u + i];
        return 0;
    }
    std::uint8_t write(std::uint16_t address, words_view from) {
        if (address < 0x2000 || from.size() + (address - 0x2000u) > 4) return 2;
        for (std::size_t i = 0; i < from.size(); ++i) words[address - 0x2000u + i] = from[i];
        return 0;
    }
};

/// A wire whose node responds to each valid request. The clock starts near its wrap.
struct fake_port {
    store node;
    std::uint8_t out[64]{};
    std::uint8_t pdu[max_pdu]{};
    std::uint8_t in[64]{};
    std::size_t in_size = 0, in_taken = 0;
    std::uint32_t clock = 0xFFFF'F000u;
    bool is_mute = false, is_damaged = false;

    transfer send(bytes frame) {
        for (std::size_t i = 0; i < frame.size(); ++i) out[i] = frame[i];
        const auto opened = open_frame(frame);
        in_size = in_taken = 0;
        if (opened && !is_mute) {
            const std::size_t size = respond(node, opened->pdu, pdu, server_rules{});
            in[0] = opened->address;
            for (std::size_t i = 0; i < size; ++i) in[i + 1] = pdu[i];
            in_size = close_frame(in, size);
            if (is_damaged) in[3] ^= 1u;
        }
        return static_cast<std::uint16_t>(frame.size());
    }
    bool sent() { return true; }
    transfer receive(byte_buffer to) { // three bytes at a time
        std::uint16_t n = 0;
        while (n < 3 && n < to.size() && in_taken < in_size) to[n++] = in[in_taken++];
        return n;
    }
    instant now() { return {clock += 200}; }
};

void check_bytes() {
    static constexpr std::uint8_t text[] = {'1', '2', '3', '4', '5', '6', '7', '8', '9'};
    check(crc16<default_crc>(text) == 0x4B37, __LINE__);
    check(crc16<crc_bitwise>(text) == 0x4B37, __LINE__);
    check(crc16<crc_table16>(text) == 0x4B37, __LINE__);
    check(crc16<crc_table256>(text) == 0x4B37, __LINE__);
    check(crc16<crc_trinomial<8>>(text) == 0x4B37, __LINE__);
    check(crc16<crc_trinomial<16>>(text) == 0x4B37, __LINE__);
    check(crc16<crc_trinomial<32>>(text) == 0x4B37, __LINE__);
    check(crc16<crc_trinomial<64>>(text) == 0x4B37, __LINE__);

    volatile std::uint16_t address = 0x200E; // not known to the compiler
    check(same_bytes(write_frame(1, address, 8), hex("01 06 20 0E 00 08 E2 0F")), __LINE__);
    address = 0x20AB;
    const frame<8> read = read_frame(1, address, 2);
    check(read.size == 8 && crc16<crc_bitwise>(read) == 0, __LINE__);
    const auto opened = open_frame(read);
    check(opened && opened->address == 1 && opened->pdu.size() == 5, __LINE__);
    check(load_word(opened->pdu, 1) == 0x20AB, __LINE__);
    frame<8> bad = read;
    bad.data[2] ^= 0x80u;
    check(open_frame(bad).error() == errc::bad_crc, __LINE__);
    const auto both = write_frame(1, 0x2088, {0x8001, 0xFFFE});
    check(both.size == 13 && open_frame(both), __LINE__);

    volatile std::uint32_t baud = 9600;
    check(timing_at(baud).t3_5 == 4011, __LINE__);
    baud = 600;
    check(timing_at(baud).t3_5 == 64167, __LINE__);
    baud = 115200;
    check(timing_at(baud).t1_5 == 750, __LINE__);
    check(timing_at(baud).wire_time(512).us == 512ul * 96, __LINE__);
    check(went_back({5}, {0xFFFF'FFFFu}) && !went_back({0xFFFF'FFFFu}, {5}), __LINE__);
}

void check_transactions() {
    static fake_port port;
    line wire{port, timing_at(115200)};
    client<decltype(wire), device> node_1{wire, node<device>{1}};

    const auto first = node_1.read<level>();
    check(first && *first == 0xBEEF, __LINE__);
    check(static_cast<bool>(node_1.write<level>(0x8000)), __LINE__);
    check(port.node.words[0] == 0x8000, __LINE__);

    volatile std::int16_t wanted = -3000;
    check(static_cast<bool>(node_1.write<speed>(checked(raw(std::int16_t{wanted})))), __LINE__);
    check(port.node.words[1] == 0xF448, __LINE__);
    const auto turned = node_1.read<speed>();
    check(turned && *turned == -300 * units::r_per_min, __LINE__);
    wanted = -3001;
    check(node_1.write<speed>(checked(raw(std::int16_t{wanted}))).error() == errc::out_of_range, __LINE__);

    volatile std::int32_t far = -1'234'567;
    check(static_cast<bool>(node_1.write<place>(checked(std::int32_t{far} * units::pulse))), __LINE__);
    check(port.node.words[2] == 0x2979 && port.node.words[3] == 0xFFED, __LINE__);
    const auto reached = node_1.read<place>();
    check(reached && reached->count() == far, __LINE__);

    const auto all = node_1.read<level, speed, place>();
    check(all && get<level>(*all) == 0x8000, __LINE__);
    u16 word = 0;
    check(node_1.read_words(0x3000, {&word, 1}) == status::sent(errc::exception, 2), __LINE__);

    port.is_damaged = true;
    check(!node_1.read<level>(), __LINE__);
    port.is_damaged = false;
    port.is_mute = true;
    check(node_1.write<level>(1).outcome() == outcome::unknown, __LINE__);
    port.is_mute = false;
    check(static_cast<bool>(node_1.read<level>()), __LINE__);
}

} // namespace

extern "C" int main() { // freestanding: a function without special linkage
    UCSR0B = _BV(TXEN0);
    check_bytes();
    check_transactions();
    put("avr: ");
    put(passed);
    put(" passed, ");
    put(failed);
    put(" failed.\n");
    cli();
    sleep_enable();
    for (;;) sleep_cpu(); // without interrupts this ends the simulation
}
