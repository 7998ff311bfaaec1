// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The library's client with another server that has the registers of registers.hpp, on a serial device. It
// notes what it writes in a file, a register a line, which is compared with the output of the server.
//   own_client DEVICE FILE
#include <array>
#include <cstdio>
#include <vector>

#include <servobus/client/client.hpp>
#include <servobus/posix/serial.hpp>

#include "registers.hpp"
#include "report.hpp"

using namespace servobus;
using interop::check;

namespace {

// Only what the standard has. The time limit is long, since the server may respond late on a busy machine.
struct plain {
    static constexpr profile facts{.name = "plain",
                                   .baud = interop::baud,
                                   .limits = {.response = milliseconds(5000)},
                                   .exceptions = standard_exceptions};
};

class session {
  public:
    session(const char* device, const char* notes)
        : opened_{port_.open(device, {.baud = interop::baud})}, notes_{std::fopen(notes, "w")} {}
    ~session() {
        if (notes_ != nullptr) (void)std::fclose(notes_);
    }
    session(const session&) = delete;
    session& operator=(const session&) = delete;

    bool is_ready() {
        if (opened_ != errc::ok || notes_ == nullptr) return false;
        // The other end is ready once it has responded to a request.
        std::array<u16, 1> one{};
        for (int tries = 0; tries < 20; ++tries) {
            if (server_.read_words(interop::first, one).error() == errc::ok) return true;
        }
        return false;
    }

    void read(u16 address, std::size_t n, modbus::function code) {
        std::vector<u16> words(n);
        const status why = server_.read_words(address, words, code);
        bool is_same = why.error() == errc::ok;
        for (std::size_t i = 0; i < n; ++i)
            is_same = is_same && words[i] == interop::initial(address + static_cast<unsigned>(i));
        check(is_same,
              name(code == modbus::function::read_holding_registers ? "03 reads" : "04 reads", n, why));
    }

    void write_and_read_back(u16 address, std::size_t n, bool single) {
        std::vector<u16> words;
        for (std::size_t i = 0; i < n; ++i) words.push_back(static_cast<u16>(0xA500u + 7 * i + n));
        const status w = single ? server_.write_word(address, words[0]) : server_.write_words(address, words);
        check(static_cast<bool>(w), name(single ? "06 writes" : "10h writes", n, w));
        for (std::size_t i = 0; i < n; ++i)
            (void)std::fprintf(notes_, "%04X=%04X\n", address + static_cast<unsigned>(i), unsigned{words[i]});
        std::vector<u16> held(n);
        const status why = server_.read_words(address, held);
        check(why.error() == errc::ok && held == words, name("reads back", n, why));
    }

    void exceptions() {
        std::array<u16, 4> words{1, 2, 3, 4};
        const status none = server_.read_words(0x3000, words);
        check(none == status::sent(errc::exception, 2) && words[0] == 1,
              "03 of a register that does not exist: exception 2");
        const status half = server_.read_words(interop::first + interop::count - 2, words);
        check(half == status::sent(errc::exception, 2), "03 across the last register: exception 2");
        const status single = server_.write_word(0x3000, 1);
        check(single.outcome() == outcome::refused && single.exception() == 2,
              "06 elsewhere: refused, exception 2");
        const status many = server_.write_words(interop::first + interop::count - 2, words);
        check(many.outcome() == outcome::refused && many.exception() == 2,
              "10h across the last: refused, exception 2");
        std::array<std::uint8_t, 2> room{};
        const status unknown = server_.transact(hex("2B"), room);
        check(unknown.outcome() == outcome::refused && unknown.exception() == 1,
              "a function that the server does not have: exception 1");
        std::array<std::uint8_t, 2> response{};
        const status nothing = server_.transact(hex("17 20 00 00 00 20 00 00 01 02 00 00"), response);
        check(nothing.outcome() == outcome::not_sent && nothing.error() == errc::bad_argument,
              "17h with a quantity of 0: not sent");
    }

    // Another function, 17h: writes one register and reads two in one request.
    void raw() {
        std::array<std::uint8_t, 6> response{};
        const status w = server_.transact(hex("17 20 00 00 02 20 02 00 01 02 BE EF"), response);
        const u16 a = interop::initial(interop::first);
        const u16 b = interop::initial(interop::first + 1);
        check(w && response[0] == 0x17 && response[1] == 4 && load_word(response, 2) == a &&
                  load_word(response, 4) == b,
              "17h, raw: the response as it came");
        (void)std::fprintf(notes_, "2002=BEEF\n");
        std::array<u16, 1> held{};
        check(server_.read_words(0x2002, held).error() == errc::ok && held[0] == 0xBEEF, "17h, raw: written");
    }

    void an_absent_node() {
        node<plain> at{99};
        at.limits.response = milliseconds(50);
        at.read_retries = 0;
        client<decltype(line_), plain> nobody{line_, at};
        std::array<u16, 1> word{};
        check(nobody.read_words(interop::first, word).error() == errc::timeout,
              "an absent node: no response");
        read(interop::first + 10, 1, modbus::function::read_holding_registers);
    }

    void the_counters() {
        const counters& seen = line_.observer();
        check(seen.crc_errors == 0 && seen.malformed == 0 && seen.transport_errors == 0,
              "no malformed frame came");
    }

  private:
    static std::string name(const char* what, std::size_t n, const status& why) {
        std::string words = std::string{what} + " " + std::to_string(n);
        if (why.error() != errc::ok) words += std::string{" ("} + text(why.error()) + ")";
        return words;
    }

    posix::serial port_;
    status opened_;
    std::FILE* notes_;
    line<posix::serial> line_{port_, modbus::timing_at(interop::baud)};
    client<decltype(line_), plain> server_{line_, node<plain>{interop::node_address}};
};

} // namespace

int main(int, char** words) {
    session s{words[1], words[2]};
    check(s.is_ready(), "the other server responds to the library's client");
    if (interop::failed != 0) return 1;
    for (const std::size_t n : {1u, 2u, 125u}) {
        s.read(interop::first, n, modbus::function::read_holding_registers);
        s.read(static_cast<u16>(interop::first + interop::count - n), n,
               modbus::function::read_input_registers);
    }
    s.exceptions();
    s.raw();
    s.an_absent_node();
    s.write_and_read_back(interop::first + 20, 1, true);
    s.write_and_read_back(interop::first + 21, 1, false);
    s.write_and_read_back(interop::first + 30, 123, false);
    s.the_counters();
    return interop::failed == 0 ? 0 : 1;
}
