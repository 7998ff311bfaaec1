// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Windows' port and clock, on a line to peer.cpp and on one to a simulated ZLAC8015D.
//   port bytes PORT    against peer.cpp, which ends
//   port drive PORT    against the simulated drive
//   port look PORT     reads its bus voltage once
// Prints a line a check. A pseudo-terminal under wine has no wire and no adapter that could be pulled: the
// removal of a real device, RTS and the echo of a real adapter are not shown here.
#include <servobus/line/reconnecting.hpp>
#include <servobus/windows/serial.hpp>

#include <servobus/device/zlac8015d.hpp>
#include <servobus/servobus.hpp>

#include <array>
#include <cstdio>
#include <cstring>

using namespace servobus;
using namespace servobus::units;

static_assert(waiting_port<reconnecting<windows::serial>>);

namespace {

int failed = 0;

void check(bool holds, const char* what) {
    std::printf("%s %s\n", holds ? "ok     " : "FAILED ", what);
    std::fflush(stdout);
    if (!holds) ++failed;
}

template <class Do> duration time_of(Do act) {
    const instant start = windows::monotonic_now();
    act();
    return since(start, windows::monotonic_now());
}

// Waits until `size` bytes are there, at most two seconds; the number of bytes.
template <std::size_t Size> std::size_t collect(windows::serial& port, std::array<std::uint8_t, Size>& to) {
    std::size_t have = 0;
    const instant start = port.now();
    while (have < Size && since(start, port.now()) < milliseconds(2000)) {
        const transfer got = port.receive(byte_buffer{to}.subspan(have));
        if (!got) break;
        have += *got;
        if (*got == 0) port.wait(milliseconds(20));
    }
    return have;
}

void send_all(windows::serial& port, bytes all) {
    const instant start = port.now();
    while (!all.empty() && since(start, port.now()) < milliseconds(2000)) {
        const transfer took = port.send(all);
        if (!took) return;
        all = all.subspan(*took);
    }
}

void ask(windows::serial& port, char what) {
    send_all(port, std::array<std::uint8_t, 1>{static_cast<std::uint8_t>(what)});
}

void clock() {
    using windows::detail::microseconds_of;
    static_assert(microseconds_of(0, 10'000'000) == 0);
    static_assert(microseconds_of(15, 10'000'000) == 1);
    static_assert(microseconds_of(0xFFFF'FFFF'FFFF'FFFF, 3'000'000'000) == 6'148'914'691'236'517);
    static_assert(windows::detail::milliseconds_of(microseconds(1)) == 1);
    static_assert(windows::detail::milliseconds_of(milliseconds(7)) == 7);
    static_assert(windows::detail::milliseconds_of(servobus::duration{0xFFFF'FFFF}) == 4'294'968);
    const duration slept = time_of([] { windows::sleep_for(milliseconds(50)); });
    check(slept >= milliseconds(50), "a sleep does not end early");
    check(slept < milliseconds(2000), "a sleep ends");
    instant before = windows::monotonic_now();
    bool is_monotonic = true;
    for (int i = 0; i < 100'000; ++i) {
        const instant after = windows::monotonic_now();
        is_monotonic = is_monotonic && !went_back(before, after);
        before = after;
    }
    check(is_monotonic, "the clock does not go back");
}

void names() {
    using windows::detail::device_name;
    check(std::strcmp(device_name{"COM3"}.text(), R"(\\.\COM3)") == 0, "COM3 gets the prefix");
    check(std::strcmp(device_name{"COM12"}.text(), R"(\\.\COM12)") == 0, "COM12 gets the prefix");
    check(std::strcmp(device_name{R"(\\.\COM12)"}.text(), R"(\\.\COM12)") == 0, "a prefix is kept");
    check(std::strcmp(device_name{R"(\\?\usb#1)"}.text(), R"(\\?\usb#1)") == 0,
          "the prefix of a path is kept");
    std::array<char, 300> name{};
    name.fill('x');
    name[255] = '\0';
    check(std::strlen(device_name{name.data()}.text()) == 259, "the longest name fits");
    name[255] = 'x';
    name[256] = '\0';
    check(*device_name{name.data()}.text() == '\0', "a longer one is no name");
    check(*device_name{""}.text() == '\0', "an empty one is no name");
}

void refusals(const char* name) {
    windows::serial port;
    std::array<std::uint8_t, 4> room{};
    check(!port.is_open() && port.send(room).error() == errc::port_lost &&
              port.receive(room).error() == errc::port_lost && port.sent(),
          "a port that was never opened is lost");
    check(time_of([&] { port.wait(milliseconds(30)); }) >= milliseconds(30), "waiting for it sleeps");
    check(port.open("COM77") == errc::no_such_port && port.os_error() == ERROR_FILE_NOT_FOUND,
          "a port that does not exist is said");
    reconnecting<windows::serial> none{"COM77", windows::serial_settings{}};
    check(!none.is_open() && none.why() == errc::no_such_port &&
              none.receive(room).error() == errc::port_lost,
          "one that opens itself says why it is not open");
    check(port.open("") == errc::no_such_port && port.os_error() == ERROR_INVALID_NAME,
          "so is one without a name");
    check(port.open("NUL") == errc::bad_argument && !port.is_open(), "NUL is no serial device");
    check(port.open(name, {.baud = 0}) == errc::bad_argument && !port.is_open() &&
              port.os_error() == ERROR_INVALID_PARAMETER,
          "0 baud is refused");
    check(port.open(name, {.baud = 1'234'567}) == errc::bad_argument && !port.is_open(),
          "a baud rate that the driver does not have is refused");
    for (const std::uint32_t baud : {9600u, 19200u, 115200u})
        check(port.open(name, {.baud = baud}) == errc::ok, "a usual baud rate is accepted");
    // A pseudo-terminal ignores the parity that it is given, so these show that the settings are read back.
    using enum character_format;
    for (const character_format format : {n81, n82})
        check(port.open(name, {.baud = 19200, .format = format}) == errc::ok, "no parity is accepted");
    for (const character_format format : {e81, o81})
        check(port.open(name, {.baud = 19200, .format = format}) == errc::bad_argument && !port.is_open(),
              "a parity that the driver ignores is refused");
    check(port.open(name, {.rs485 = true}) == errc::bad_argument && !port.is_open(),
          "RTS that the driver cannot switch is refused");
}

// Wine lets two programs open the same device, unlike Windows. A file that is open shows the same error of
// Windows.
void taken_by_another() {
    char folder[MAX_PATH]{};
    char file[MAX_PATH]{};
    if (::GetTempPathA(MAX_PATH, folder) == 0 || ::GetTempFileNameA(folder, "bus", 0, file) == 0)
        return check(false, "a file could be made");
    const HANDLE other = ::CreateFileA(file, GENERIC_READ | GENERIC_WRITE, 0, nullptr, OPEN_EXISTING,
                                       FILE_FLAG_DELETE_ON_CLOSE, nullptr);
    windows::serial port;
    check(port.open(file) == errc::port_in_use && !port.is_open() &&
              port.os_error() == ERROR_SHARING_VIOLATION,
          "what another program has open is in use");
    (void)::CloseHandle(other);
    check(port.open(file) == errc::no_such_port, "what does not exist any more is no port");
}

// Wine lets the other port have the same device, for the request. A `c` that arrived would end the peer.
void only_receives(const char* name) {
    windows::serial listener;
    check(listener.open(name, {.receive_only = true}) == errc::ok, "it opens for receiving only");
    check(listener.send(std::array<std::uint8_t, 1>{'c'}).error() == errc::send_failed && listener.is_open(),
          "then it refuses to send");
    check(listener.sent(), "and has nothing to send");
    windows::serial client;
    std::array<std::uint8_t, 1> one{};
    if (client.open(name) == errc::ok) ask(client, 'l');
    check(collect(listener, one) == 1 && one[0] == 7, "it receives");
}

// The first bytes of the peer come while the request is still on the wire, as an echo does; the next ones 100
// ms later. At 600 baud t3.5 is 64 ms. If this program is delayed for longer, it may not discard: then it
// tries again.
void echo(const char* name) {
    windows::serial port;
    check(port.open(name, {.baud = 600}) == errc::ok, "it opens at 600 baud");
    const auto has_sent_late = [&port] {
        ask(port, 's');
        windows::sleep_for(milliseconds(300));
        for (int tries = 0; tries < 1000; ++tries) { // a read may be under way
            if (port.sent()) return true;
            windows::sleep_for(milliseconds(1));
        }
        return false;
    };
    std::array<std::uint8_t, 5> all{};
    check(has_sent_late(), "the request has been sent long ago");
    check(collect(port, all) == 5 && all[0] == 1 && all[4] == 5, "then nothing is discarded");
    bool is_discarded = false;
    for (int tries = 0; tries < 10 && !is_discarded; ++tries) {
        ask(port, 's');
        while (!port.sent()) port.wait(milliseconds(1));
        std::array<std::uint8_t, 2> next{};
        is_discarded = collect(port, next) == 2 && next[0] == 4 && next[1] == 5;
        std::array<std::uint8_t, 5> rest{};
        if (!is_discarded) (void)collect(port, rest);
    }
    check(is_discarded, "what comes before t3.5 after the request is discarded");
    check(has_sent_late(), "a request that has been sent long ago, at an adapter that echoes");
    std::array<std::uint8_t, 4> rest{};
    check(collect(port, rest) == 4 && rest[0] == 2 && rest[3] == 5,
          "G3: as many bytes as were sent are discarded, which may be an echo: what follows stays");
}

void every_byte(windows::serial& port) {
    std::array<std::uint8_t, 256> all{};
    std::array<std::uint8_t, 256> back{};
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint8_t>(i);
    ask(port, 'e');
    send_all(port, all);
    check(!port.sent(), "256 bytes take their time on the wire");
    check(collect(port, back) == 256 && back == all, "every byte value passes, both ways, unchanged");
    const instant start = port.now();
    while (!port.sent() && since(start, port.now()) < milliseconds(2000)) port.wait(milliseconds(1));
    check(port.sent(), "then they have been sent");
}

void in_parts(windows::serial& port) {
    std::array<std::uint8_t, 2> few{};
    ask(port, 's');
    check(collect(port, few) == 2 && few[0] == 1 && few[1] == 2, "a small buffer takes the first bytes");
    std::array<std::uint8_t, 3> rest{};
    check(collect(port, rest) == 3 && rest[0] == 3 && rest[1] == 4 && rest[2] == 5,
          "the rest comes later, in two parts");
    check(port.receive(rest).value_or(99) == 0, "then nothing comes");
    check(port.receive(byte_buffer{}).value_or(99) == 0, "no room is no error");
    check(port.send(bytes{}).value_or(99) == 0, "no bytes are no error");
}

void waiting(windows::serial& port) {
    check(time_of([&] { port.wait(milliseconds(50)); }) >= milliseconds(50),
          "without a byte, wait takes its time");
    check(time_of([&] { port.wait({}); }) < milliseconds(1000), "no time is no wait");
    ask(port, 'l');
    const duration waited = time_of([&] { port.wait(milliseconds(20'000)); });
    check(waited < milliseconds(10'000), "a byte ends wait");
    check(time_of([&] { port.wait(milliseconds(20'000)); }) < milliseconds(10'000),
          "so does a byte that has not been taken yet");
    std::array<std::uint8_t, 1> one{};
    check(port.receive(one).value_or(0) == 1 && one[0] == 7, "it is there");
}

void full(windows::serial& port) {
    ask(port, 'h');
    std::array<std::uint8_t, 256> all{};
    std::uint32_t taken = 0;
    bool took_less = false;
    duration longest{};
    const instant start = port.now();
    while (since(start, port.now()) < milliseconds(600)) {
        transfer took{errc::timeout};
        longest = longer_of(longest, time_of([&] { took = port.send(all); }));
        if (!took) break;
        took_less = took_less || *took < all.size();
        taken += *took;
    }
    std::printf("# %lu bytes taken, the longest send took %lu us\n", static_cast<unsigned long>(taken),
                static_cast<unsigned long>(longest.us));
    check(took_less, "a full line takes fewer bytes");
    check(longest < milliseconds(400), "send does not wait for a full line");
    check(!port.sent(), "what waits has not been sent");
    std::array<std::uint8_t, 3> count{};
    check(collect(port, count) == 3, "the peer receives again");
    check((std::uint32_t{count[0]} << 16 | std::uint32_t{count[1]} << 8 | count[2]) == taken,
          "no byte is lost and none is doubled");
}

void lost(windows::serial& port) {
    ask(port, 'c');
    const instant start = port.now();
    std::array<std::uint8_t, 8> room{};
    while (port.is_open() && since(start, port.now()) < milliseconds(5000)) {
        port.wait(milliseconds(20));
        (void)port.receive(room);
    }
    check(!port.is_open(), "a peer that goes away ends the port");
    for (int i = 0; i < 3; ++i) {
        check(port.receive(room).error() == errc::port_lost, "receive: port_lost");
        check(port.send(room).error() == errc::port_lost, "send: port_lost");
        check(port.receive(byte_buffer{}).error() == errc::port_lost, "receive without room: port_lost");
        check(time_of([&] { port.wait(milliseconds(30)); }) >= milliseconds(30), "wait sleeps");
    }
    check(port.sent(), "nothing is left to send");
    check(port.os_error() != 0, "the system's reason is kept");
    std::printf("# the system's reason: %lu\n", static_cast<unsigned long>(port.os_error()));
}

void bytes_of(const char* name) {
    clock();
    names();
    refusals(name);
    taken_by_another();
    only_receives(name);
    echo(name);
    windows::serial port;
    check(port.open(name, {.keeps_echo = true}) == errc::ok && port.is_open() && port.os_error() == 0,
          "it opens");
    every_byte(port);
    in_parts(port);
    waiting(port);
    full(port);
    lost(port);
}

using wire = line<windows::serial>;

void drive(const char* name) {
    windows::serial port;
    check(port.open(name, windows::settings_of(zlac8015d::device::facts)) == errc::ok, "it opens");
    wire on{port, modbus::timing_at(zlac8015d::device::facts.baud)};
    client wheels{on, node<zlac8015d::device>{1}};
    const auto voltage = wheels.read<zlac8015d::bus_voltage>();
    check(voltage && voltage->count() != 0, "a client reads the bus voltage (20A1h)");
    check(static_cast<bool>(wheels.write<zlac8015d::left_acceleration_time>(321)), "it writes a ramp");
    const auto ramp = wheels.read<zlac8015d::left_acceleration_time>();
    check(ramp && ramp->count() == 321, "the ramp reads back");

    zlac8015d::drive<wire> both{on, 1, {.command_timeout = milliseconds(1000)}};
    check(static_cast<bool>(both.run(init{})), "init");
    check(static_cast<bool>(both.run(enable{})), "enable");
    check(static_cast<bool>(both.run(velocity{30 * r_per_min, -20 * r_per_min})), "velocity");
    bool turns = false;
    const instant start = port.now();
    while (!turns && since(start, port.now()) < milliseconds(10'000)) {
        if (!both.run(velocity{30 * r_per_min, -20 * r_per_min})) break;
        const auto f = both.read();
        turns = f && f->left_speed.count() > 200 && f->right_speed.count() < -100;
        port.wait(milliseconds(20));
    }
    check(turns, "its feedback shows that the wheels turn");
    check(static_cast<bool>(both.run(disable{})), "disable");
}

int look(const char* name) {
    windows::serial port;
    const errc opened = port.open(name, windows::settings_of(zlac8015d::device::facts)).error();
    wire on{port, modbus::timing_at(zlac8015d::device::facts.baud)};
    client wheels{on, node<zlac8015d::device>{1}};
    check(opened == errc::ok && wheels.read<zlac8015d::bus_voltage>(), "it responds");
    return failed;
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 3) return 2;
    if (std::strcmp(argv[1], "look") == 0) return look(argv[2]);
    if (std::strcmp(argv[1], "bytes") == 0) {
        bytes_of(argv[2]);
    } else {
        drive(argv[2]);
    }
    return failed == 0 ? 0 : 1;
}
