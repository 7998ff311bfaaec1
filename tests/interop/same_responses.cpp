// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Sends the same requests, valid and malformed, to the library's server and to that of libmodbus, each on
// its serial device. Both must respond with the same bytes. Where the standard leaves the response open, or
// libmodbus departs from it, the request is listed here with both responses.
//   same_responses OUR-DEVICE THEIR-DEVICE
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include <servobus/modbus/rtu.hpp>
#include <servobus/posix/serial.hpp>

#include "registers.hpp"
#include "report.hpp"

using namespace servobus;
using interop::check;

namespace {

using byte_list = std::vector<std::uint8_t>;

byte_list bytes_of(const std::string& hex) {
    byte_list all;
    for (std::size_t at = 0; at + 1 < hex.size(); at += 3)
        all.push_back(static_cast<std::uint8_t>(std::stoul(hex.substr(at, 2), nullptr, 16)));
    return all;
}
byte_list framed(byte_list body) {
    const std::uint16_t crc = modbus::crc16(body);
    body.push_back(static_cast<std::uint8_t>(crc & 0xFF));
    body.push_back(static_cast<std::uint8_t>(crc >> 8));
    return body;
}
std::string text_of(const byte_list& data) {
    std::string text;
    for (const std::uint8_t b : data) text += interop::hex(b).substr(2) + ' ';
    return text.empty() ? "no response" : text;
}

/// A server that receives requests as bytes.
class asked {
  public:
    explicit asked(const char* device) : is_open_{port_.open(device, {.baud = interop::baud}) == errc::ok} {}

    bool is_open() const { return is_open_; }

    /// Its response to this request, complete or none. To show that there is none, a valid request follows,
    /// and no byte may come before its response.
    byte_list response_to(const byte_list& request, bool has_response) {
        send(request);
        if (has_response) return until_whole();
        byte_list got;
        for (int probes = 0; probes < 5; ++probes) {
            posix::sleep_for(
                milliseconds(400)); // a gap between the frames, longer than the 300 ms of libmodbus
            send(probe_);
            // Waits a minute, in case the server takes the probe for the rest of the request before.
            for (int looks = 0; looks < 600; ++looks) {
                listen(got);
                const auto at =
                    std::search(got.begin(), got.end(), probe_response_.begin(), probe_response_.end());
                if (at == got.end()) continue;
                got.erase(at, at + static_cast<long>(probe_response_.size()));
                return got;
            }
        }
        return bytes_of("DE AD");
    }

    /// Whether it responds to a first valid request.
    bool is_there() { return is_open_ && response_to({}, false).empty(); }

  private:
    void send(const byte_list& data) {
        bytes left = data;
        while (!left.empty()) {
            const transfer took = port_.send(left);
            if (!took) return;
            left = left.subspan(*took);
            if (!left.empty()) posix::sleep_for(milliseconds(1)); // until the other end has read some
        }
    }
    // Receives what comes within a tenth of a second.
    void listen(byte_list& got) {
        port_.wait(milliseconds(100));
        std::uint8_t chunk[256];
        const transfer came = port_.receive(chunk);
        if (came) got.insert(got.end(), chunk, chunk + *came);
    }
    byte_list until_whole() {
        byte_list got;
        for (int looks = 0; looks < 600; ++looks) {
            listen(got);
            const std::size_t whole = got.size() >= 3 ? modbus::response_length(got[1], got[2]) : 0;
            if (whole != 0 && got.size() >= whole) break;
        }
        return got;
    }

    posix::serial port_;
    bool is_open_;
    // The last register is used only by the probe.
    byte_list probe_ = framed(bytes_of("11 03 20 C7 00 01"));
    byte_list probe_response_ =
        framed({interop::node_address, 3, 2, static_cast<std::uint8_t>(interop::initial(0x20C7) >> 8),
                static_cast<std::uint8_t>(interop::initial(0x20C7) & 0xFF)});
};

struct question {
    const char* name;
    byte_list request;
    bool has_response = true;
    const char* ours = nullptr;   ///< a difference: the response of the library, without address and CRC
    const char* theirs = nullptr; ///< a difference: the response of libmodbus, null for none
};

byte_list many(unsigned quantity, unsigned byte_count, unsigned sent) {
    byte_list body = bytes_of("11 10 20 40 00");
    body.push_back(static_cast<std::uint8_t>(quantity));
    body.push_back(static_cast<std::uint8_t>(byte_count));
    for (unsigned i = 0; i < sent; ++i) body.push_back(static_cast<std::uint8_t>(0x30 + i));
    return body;
}
byte_list asks(const char* hex) { return framed(bytes_of(hex)); }
byte_list spoilt(const char* hex) {
    byte_list f = asks(hex);
    f.back() ^= 0x01;
    return f;
}

std::vector<question> questions() {
    return {
        {"03, 1 register", asks("11 03 20 00 00 01")},
        {"03, 2 registers", asks("11 03 20 00 00 02")},
        {"03, 125 registers", asks("11 03 20 00 00 7D")},
        {"03, the last register", asks("11 03 20 C7 00 01")},
        {"03, 126 registers", asks("11 03 20 00 00 7E")},
        {"03, no register", asks("11 03 20 00 00 00")},
        {"03, 256 registers, 0 in the low byte", asks("11 03 20 00 01 00")},
        {"03, 65535 registers", asks("11 03 20 00 FF FF")},
        {"03, across the last register", asks("11 03 20 C7 00 02")},
        {"03, before the first register", asks("11 03 1F FF 00 02")},
        {"03, outside the registers", asks("11 03 00 00 00 01")},
        {"03, 0xFFFF and beyond", asks("11 03 FF FF 00 02")},
        {"03, no register, outside the registers: the quantity is checked first", asks("11 03 00 00 00 00")},
        {"04, 1 register", asks("11 04 20 05 00 01")},
        {"04, 125 registers", asks("11 04 20 00 00 7D")},
        {"04, 126 registers", asks("11 04 20 00 00 7E")},
        {"04, outside the registers", asks("11 04 00 00 00 01")},
        {"06, a value", asks("11 06 20 01 12 34")},
        {"06, read back", asks("11 03 20 01 00 01")},
        {"06, outside the registers", asks("11 06 00 01 12 34")},
        {"06, 0xFFFF", asks("11 06 FF FF 12 34")},
        {"10h, 1 register", framed(many(1, 2, 2))},
        {"10h, 2 registers", framed(many(2, 4, 4))},
        {"10h, 123 registers", framed(many(123, 246, 246))},
        {"10h, read back", asks("11 03 20 40 00 7B")},
        {"10h, outside the registers", asks("11 10 00 00 00 01 02 AA AA")},
        {"10h, across the last register", asks("11 10 20 C7 00 02 04 AA AA BB BB")},
        {"10h across the last register has written nothing", asks("11 03 20 C7 00 01")},
        {"10h, no register", framed(many(0, 0, 0))},
        {"10h with fewer bytes than registers", framed(many(2, 2, 2))},
        {"10h with more bytes than registers", framed(many(1, 4, 4))},
        {"10h with an odd byte count", framed(many(2, 3, 3))},
        {"10h: none of these has written anything", asks("11 03 20 40 00 02")},
        {"a function that neither server has", asks("11 2B")},
        {"a bad CRC, 03", spoilt("11 03 20 00 00 01"), false},
        {"a bad CRC, 06", spoilt("11 06 20 02 55 55"), false},
        {"a bad CRC, and nothing is written", asks("11 03 20 02 00 01")},
        {"another node", asks("12 03 20 00 00 01"), false},
        {"another node's write", asks("12 06 20 02 66 66"), false},
        {"a truncated request", bytes_of("11 03 20"), false},
        {"noise", bytes_of("55 AA 55"), false},
        {"the server responds after these", asks("11 03 20 02 00 02")},
        // What the standard leaves open, or what libmodbus does differently.
        {"coils: libmodbus has the function, and no coil", asks("11 01 00 00 00 01"), true, "81 01", "81 02"},
        {"inputs: libmodbus has the function, and no input", asks("11 02 00 00 00 01"), true, "82 01",
         "82 02"},
        {"a coil: libmodbus has the function, and no coil", asks("11 05 00 00 FF 00"), true, "85 01",
         "85 02"},
        {"a function that neither server has, with data: libmodbus does not find the end of the frame",
         asks("11 2B 0E 01 00"), true, "AB 01", nullptr},
    };
}

byte_list response_of(const char* pdu) {
    if (pdu == nullptr) return {};
    byte_list body = bytes_of(pdu);
    body.insert(body.begin(), interop::node_address);
    return framed(body);
}

} // namespace

int main(int, char** devices) {
    asked ours{devices[1]};
    asked theirs{devices[2]};
    check(ours.is_there(), "the library's server responds to raw bytes");
    check(theirs.is_there(), "the server of libmodbus responds to raw bytes");
    if (interop::failed != 0) return 1;
    for (const question& q : questions()) {
        const int before = interop::failed;
        const byte_list a = ours.response_to(q.request, q.has_response);
        const bool is_difference = q.ours != nullptr;
        const byte_list b =
            theirs.response_to(q.request, q.has_response && !(is_difference && q.theirs == nullptr));
        if (is_difference) {
            check(a == response_of(q.ours) && b == response_of(q.theirs),
                  std::string{"a listed difference: "} + q.name);
        } else {
            check(a == b && a.empty() == !q.has_response,
                  std::string{"the same response from both: "} + q.name);
        }
        if (interop::failed != before)
            std::printf("# ours %s, theirs %s\n", text_of(a).c_str(), text_of(b).c_str());
    }
    return interop::failed == 0 ? 0 : 1;
}
