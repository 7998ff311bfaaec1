// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The other end of the line for port.cpp, on Linux: a pseudo-terminal at LINK that does what the first byte
// of a message asks for.   peer LINK
//   'e'  sends the 256 bytes that follow back
//   's'  sends 3 bytes, and 100 ms later 2 more
//   'l'  sends 1 byte after 300 ms
//   'h'  receives nothing for 1 s, then counts the bytes until there are none for 300 ms, and sends the count
//   'c'  closes the pseudo-terminal after 300 ms, and ends
#include <array>
#include <cstdint>
#include <cstdio>

#include <servobus/posix/pseudo_terminal.hpp>

using namespace servobus;

namespace {

posix::pseudo_terminal line_end;

// One byte, or -1 if none comes within `time`.
int next(duration time) {
    const instant start = line_end.now();
    std::array<std::uint8_t, 1> one{};
    for (;;) {
        const transfer got = line_end.receive(one);
        if (got && *got == 1) return one[0];
        if (since(start, line_end.now()) >= time) return -1;
        line_end.wait(milliseconds(10));
    }
}

void send(bytes all) {
    while (!all.empty()) {
        const transfer took = line_end.send(all);
        if (!took) return;
        all = all.subspan(*took);
    }
}

void echo_every_byte() {
    std::array<std::uint8_t, 256> all{};
    for (std::uint8_t& byte : all) byte = static_cast<std::uint8_t>(next(milliseconds(2000)));
    send(all);
}

void count_late() {
    posix::sleep_for(milliseconds(1000));
    std::uint32_t count = 0;
    while (next(milliseconds(300)) >= 0) ++count;
    send(std::array<std::uint8_t, 3>{static_cast<std::uint8_t>(count >> 16),
                                     static_cast<std::uint8_t>(count >> 8),
                                     static_cast<std::uint8_t>(count)});
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 2 || line_end.open(argv[1]) != errc::ok) return 1;
    for (;;) {
        switch (next(milliseconds(1000))) {
        case 'e': echo_every_byte(); break;
        case 's':
            send(std::array<std::uint8_t, 3>{1, 2, 3});
            posix::sleep_for(milliseconds(100));
            send(std::array<std::uint8_t, 2>{4, 5});
            break;
        case 'l':
            posix::sleep_for(milliseconds(300));
            send(std::array<std::uint8_t, 1>{7});
            break;
        case 'h': count_late(); break;
        case 'c': posix::sleep_for(milliseconds(300)); return 0;
        default: break;
        }
    }
}
