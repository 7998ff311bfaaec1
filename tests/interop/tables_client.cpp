// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The library's client, by rows of all four tables, with another server that has what registers.hpp describes. It notes
// what it writes in a file, a register or a coil a line, which is compared with the output of the server.
//   tables_client DEVICE FILE FUNCTIONS...    of 16, 17, 11, 2B: functions that the server has
#include <array>
#include <cstdio>
#include <string>
#include <vector>

#include <servobus/any_device.hpp>
#include <servobus/client/identification.hpp>
#include <servobus/modbus/diagnostics.hpp>
#include <servobus/posix/serial.hpp>
#include <servobus/servobus.hpp>

#include "report.hpp"
#include "tables.hpp"

using namespace servobus;
using interop::check;

namespace {

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
        for (int tries = 0; tries < 20; ++tries) {
            if (io_.read<interop::word<0>>()) return true;
        }
        return false;
    }

    void reads() {
        reads_words(std::make_integer_sequence<unsigned, 125>{});
        reads_coils(std::make_integer_sequence<unsigned, interop::coils>{});
        reads_coils(std::make_integer_sequence<unsigned, 8>{});
        reads_inputs(std::make_integer_sequence<unsigned, interop::inputs>{});
        const auto one = io_.read<interop::input<2>>();
        check(one && *one == interop::initial_bit(interop::first_input + 2), "02 reads 1 discrete input");
    }

    void writes() {
        const status coil = io_.write<interop::coil<0>>(true);
        check(coil && *io_.read<interop::coil<0>>(), name("05 writes a coil on", coil));
        note_coil(0, true);
        const status off = io_.write<interop::coil<0>>(false);
        check(off && !*io_.read<interop::coil<0>>(), name("05 writes a coil off", off));
        note_coil(0, false);
        const status three =
            io_.write<interop::coil<3>, interop::coil<4>, interop::coil<5>>(true, true, false);
        const auto held = io_.read<interop::coil<3>, interop::coil<4>, interop::coil<5>>();
        check(three && held && held->get<interop::coil<3>>() && held->get<interop::coil<4>>() &&
                  !held->get<interop::coil<5>>(),
              name("0F writes 3 coils", three));
        note_coil(3, true), note_coil(4, true), note_coil(5, false);
        writes_coils(std::make_integer_sequence<unsigned, interop::coils>{});
        const status single = io_.write<interop::word<20>>(0xA514);
        check(single && *io_.read<interop::word<20>>() == 0xA514, name("06 writes", single));
        note_word(20, 0xA514);
        const status two = io_.write<interop::word<21>, interop::word<22>>(0x5A15, 0x5A16);
        check(two && *io_.read<interop::word<22>>() == 0x5A16, name("10h writes 2", two));
        note_word(21, 0x5A15), note_word(22, 0x5A16);
    }

    void masks() {
        const u16 before = interop::initial(interop::first + 30);
        const u16 after = static_cast<u16>((before & 0xF0FFu) | 0x0500u);
        const status changed = io_.change_bits<interop::word<30>, 0x0F00>(0x0500);
        check(changed && *io_.read<interop::word<30>>() == after, name("16h changes bits", changed));
        note_word(30, after);
        std::array<std::uint8_t, 7> response{};
        const status none = io_.transact(hex("16 30 00 00 FF 00 00"), response);
        check(none == status::sent(errc::exception, 2),
              name("16h of a register that does not exist: exception 2", none));
    }

    void reads_and_writes() {
        // The write comes first: a register in both parts is read as written.
        const auto both =
            io_.write_then_read<rows<interop::word<40>, interop::word<41>>, interop::word<41>>(0xBEEF);
        check(both && both->get<interop::word<40>>() == interop::initial(interop::first + 40) &&
                  both->get<interop::word<41>>() == 0xBEEF,
              name("17h writes, then reads", both.status()));
        note_word(41, 0xBEEF);
    }

    void server_id() {
        std::array<std::uint8_t, 253> room{};
        const auto response = io_.transact(hex("11"), room, modbus::length_rule::of_function());
        const auto id = response ? modbus::parse_server_id(*response) : result<bytes>{response.status()};
        check(id && id->size() > 2, name("11h reads the server's ID", id.status()));
        if (id) std::printf("# server ID: %s\n", printable(*id).c_str());
    }

    void identifies() {
        std::string seen;
        const auto take = [&seen](const modbus::identification_object& o) {
            seen += std::to_string(o.id) + "=" + printable(o.value) + ";";
        };
        const status basic = read_identification(io_, modbus::identification::basic, take);
        // Some servers return all that they have.
        check(basic && seen.rfind("0=Interop works;1=T-17;2=1.0;", 0) == 0,
              name("2Bh/0Eh, basic: " + seen, basic));
        seen.clear();
        const status regular = read_identification(io_, modbus::identification::regular, take);
        check(regular && seen.find("4=Four tables;") != seen.npos,
              name("2Bh/0Eh, regular: " + seen, regular));
    }

    void exceptions() {
        std::array<std::uint8_t, 3> response{};
        const status coils = io_.transact(hex("01 30 00 00 01"), response);
        check(coils == status::sent(errc::exception, 2),
              name("01 of a coil that does not exist: exception 2", coils));
        const status across = io_.transact(hex("02 00 4A 00 02"), response);
        check(across == status::sent(errc::exception, 2),
              name("02 across the last input: exception 2", across));
    }

    void the_counters() {
        const counters& seen = line_.observer();
        check(seen.crc_errors == 0 && seen.malformed == 0 && seen.transport_errors == 0,
              "no malformed frame came");
    }

  private:
    template <unsigned... I> void reads_words(std::integer_sequence<unsigned, I...>) {
        const auto inputs = io_.read<interop::input_word<I>...>();
        check(inputs &&
                  ((inputs->template get<interop::input_word<I>>() == interop::initial(interop::first + I)) &&
                   ...),
              name("04 reads " + std::to_string(sizeof...(I)), inputs.status()));
        const auto words = io_.read<interop::word<I>...>();
        check(words &&
                  ((words->template get<interop::word<I>>() == interop::initial(interop::first + I)) && ...),
              name("03 reads " + std::to_string(sizeof...(I)), words.status()));
    }
    template <unsigned... I> void reads_coils(std::integer_sequence<unsigned, I...>) {
        const auto coils = io_.read<interop::coil<I>...>();
        check(coils && ((coils->template get<interop::coil<I>>() ==
                         interop::initial_bit(interop::first_coil + I)) &&
                        ...),
              name("01 reads " + std::to_string(sizeof...(I)) + " coils", coils.status()));
    }
    template <unsigned... I> void reads_inputs(std::integer_sequence<unsigned, I...>) {
        const auto inputs = io_.read<interop::input<I>...>();
        check(inputs && ((inputs->template get<interop::input<I>>() ==
                          interop::initial_bit(interop::first_input + I)) &&
                         ...),
              name("02 reads " + std::to_string(sizeof...(I)) + " discrete inputs", inputs.status()));
    }
    template <unsigned... I> void writes_coils(std::integer_sequence<unsigned, I...>) {
        const status all = io_.write<interop::coil<I>...>((I % 2 == 1)...);
        const auto held = io_.read<interop::coil<I>...>();
        check(all && held && ((held->template get<interop::coil<I>>() == (I % 2 == 1)) && ...),
              name("0F writes " + std::to_string(sizeof...(I)) + " coils", all));
        (note_coil(I, I % 2 == 1), ...);
    }

    // Servers print what has changed.
    void note_coil(unsigned i, bool is_on) {
        if (coils_.at(i) == is_on) return;
        coils_.at(i) = is_on;
        (void)std::fprintf(notes_, "coil %04X=%d\n", interop::first_coil + i, is_on ? 1 : 0);
    }
    void note_word(unsigned i, unsigned value) {
        (void)std::fprintf(notes_, "%04X=%04X\n", interop::first + i, value);
    }
    static std::string printable(bytes text) {
        std::string all;
        for (const std::uint8_t b : text)
            all += b >= 0x20 && b < 0x7F ? std::string(1, static_cast<char>(b)) : "<" + interop::hex(b) + ">";
        return all;
    }
    static std::string name(const std::string& what, const status& why) {
        return why ? what : what + " (" + text(why.error()) + ")";
    }

    posix::serial port_;
    status opened_;
    std::FILE* notes_;
    std::array<bool, interop::coils> coils_ = [] {
        std::array<bool, interop::coils> all{};
        for (unsigned i = 0; i < interop::coils; ++i)
            all.at(i) = interop::initial_bit(interop::first_coil + i);
        return all;
    }();
    line<posix::serial, counters, unechoed, modbus::open_lengths> line_{port_,
                                                                        modbus::timing_at(interop::baud)};
    client<decltype(line_), interop::device> io_{line_, node<interop::device>{interop::node_address}};
};

} // namespace

int main(int count, char** words) {
    session s{words[1], words[2]};
    check(s.is_ready(), "the other server responds to the library's client");
    if (interop::failed != 0) return 1;
    s.reads();
    s.exceptions();
    s.writes();
    for (int i = 3; i < count; ++i) {
        const std::string function = words[i];
        if (function == "16") s.masks();
        if (function == "17") s.reads_and_writes();
        if (function == "11") s.server_id();
        if (function == "2B") s.identifies();
    }
    s.the_counters();
    return interop::failed == 0 ? 0 : 1;
}
