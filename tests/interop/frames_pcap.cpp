// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Writes frames that the library makes, requests, responses and exceptions of every function, as a capture
// for tshark. Each frame is a TCP segment of a separate connection, which the RTU dissector reads. Also
// writes what tshark must print for each frame, a line a frame, in tshark's fields.
//   frames_pcap CAPTURE EXPECTED PRINTED-FRAMES...
//   frames_pcap CAPTURE EXPECTED                     frames of all functions
#include <array>
#include <cstdio>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include <servobus/modbus/server.hpp>

using namespace servobus;

namespace {

constexpr std::uint16_t server_port = 1502;

struct store {
    std::uint8_t read(std::uint16_t address, std::span<std::uint16_t> to) const {
        if (address >= 0xF000) return 2;
        for (std::size_t i = 0; i < to.size(); ++i)
            to[i] = static_cast<std::uint16_t>(0x8001u * (i + 1) + address);
        return 0;
    }
    std::uint8_t write(std::uint16_t address, words_view) const { return address >= 0xF000 ? 2 : 0; }
};

class capture {
  public:
    capture(const char* file, const char* expected) : file_{file, std::ios::binary}, expected_{expected} {
        little32(0xA1B2C3D4);
        little16(2);
        little16(4);
        little32(0);
        little32(0);
        little32(65535);
        little32(101); // raw IP
    }

    bool is_good() const { return file_.good() && expected_.good(); }

    /// Adds a request and the response of the library's server.
    void transaction(bytes request) {
        add(request, true, request);
        std::array<std::uint8_t, modbus::max_frame> response{request[0]};
        store registers;
        const std::size_t size = respond(registers, request.subspan(1, request.size() - 3),
                                         byte_buffer{response}.subspan(1, modbus::max_pdu),
                                         modbus::server_rules{.reads_input_registers = true});
        add(bytes{response}.first(modbus::close_frame(response, size)), false, request);
        ++connection_;
    }
    /// Adds a frame that a manual prints, built again by the library. Ignores frames of other functions.
    /// Returns false if the library builds a different frame.
    bool printed(bytes frame, bool is_request) {
        const result<modbus::opened> f = modbus::open_frame(frame);
        if (f && is_request && !modbus::parse_request(f->pdu)) return true;
        if (f && !is_request && !modbus::parse_response(f->pdu)) return true;
        std::vector<std::uint8_t> again{frame.begin(), frame.end()};
        if (f && modbus::close_frame(again, f->pdu.size()) == 0) return false;
        add(again, is_request, again);
        ++connection_;
        return same_bytes(again, frame);
    }
    /// Adds a request and a response of any function, of which tshark must print the head and find nothing wrong.
    void exchanged(bytes request_pdu, bytes response_pdu) {
        only_heads_ = true;
        for (const bool is_request : {true, false}) {
            const bytes pdu = is_request ? request_pdu : response_pdu;
            std::array<std::uint8_t, modbus::max_frame> frame{17};
            for (std::size_t i = 0; i < pdu.size(); ++i) frame[i + 1] = pdu[i];
            add(bytes{frame}.first(modbus::close_frame(frame, pdu.size())), is_request,
                bytes{frame}.first(request_pdu.size() + 3));
        }
        only_heads_ = false;
        ++connection_;
    }
    /// Adds a request with a wrong bit: both tshark and the library must find a bad CRC.
    void spoilt(bytes request, std::size_t at) {
        std::vector<std::uint8_t> f{request.begin(), request.end()};
        f[at] ^= 0x40;
        add(f, true, request);
        ++connection_;
    }

  private:
    void byte(unsigned b) { file_.put(static_cast<char>(b & 0xFFu)); }
    void little16(unsigned w) { byte(w), byte(w >> 8); }
    void little32(unsigned w) { little16(w & 0xFFFFu), little16(w >> 16); }
    void big16(unsigned w) { byte(w >> 8), byte(w); }
    void big32(unsigned w) { big16(w >> 16), big16(w & 0xFFFFu); }

    void add(bytes frame, bool is_request, bytes request) {
        const auto size = static_cast<unsigned>(40 + frame.size());
        little32(1'000'000'000u + number_);
        little32(0);
        little32(size);
        little32(size);
        byte(0x45), byte(0), big16(size), big16(number_), big16(0), byte(64), byte(6), big16(0);
        big32(is_request ? 0x0A000001u : 0x0A000002u);
        big32(is_request ? 0x0A000002u : 0x0A000001u);
        const unsigned client_port = 40000u + connection_;
        big16(is_request ? client_port : server_port);
        big16(is_request ? server_port : client_port);
        big32(is_request ? 1u : 1000u);                                        // sequence
        big32(is_request ? 1000u : static_cast<unsigned>(1 + request.size())); // acknowledged
        byte(0x50), byte(0x18), big16(8192), big16(0), big16(0);
        for (const std::uint8_t b : frame) byte(b);
        ++number_;
        expect(frame, is_request);
    }

    // As tshark prints its fields: CRC good, address of the node, function, exception, register address,
    // quantity, byte count, values; the value of function 06 as data, in hex; no expert warning; request or
    // response.
    void expect(bytes frame, bool is_request) {
        const result<modbus::opened> f = modbus::open_frame(frame);
        if (!f) {
            expected_ << "bad CRC\n";
            return;
        }
        std::string line = "1," + std::to_string(f->address) + ',';
        if (only_heads_ &&
            frame.size() < 5) { // tshark takes none so short for a frame, such as a request of 11h
            expected_ << "too short\n";
            return;
        }
        if (only_heads_) {
            const unsigned code = f->pdu[0];
            expected_ << line << (code & 0x7Fu) << ',' << (code > 0x80 ? std::to_string(f->pdu[1]) : "")
                      << (is_request ? ",,Query:\n" : ",,Response:\n");
            return;
        }
        if (is_request) {
            const auto r = modbus::parse_request(f->pdu);
            const unsigned byte_count = r->code == 0x10 ? 2u * r->quantity : 0u;
            line += std::to_string(r->code) + ",," + fields(r->code, r->address, r->quantity, byte_count);
            line += payload(r->code, r->values()) + ",,Query:";
        } else {
            const auto r = modbus::parse_response(f->pdu);
            line += std::to_string(r->code) + ',';
            if (r->is_exception)
                line += std::to_string(r->exception) + ",,,,,";
            else if (modbus::is_read(r->code))
                line += ",,," + std::to_string(2 * r->quantity) + ',' + payload(r->code, r->values());
            else
                line += "," + fields(r->code, r->address, r->quantity, 0) + payload(r->code, r->values());
            line += ",,Response:";
        }
        expected_ << line << '\n';
    }

    static std::string fields(unsigned code, unsigned address, unsigned quantity, unsigned byte_count) {
        return std::to_string(address) + ',' + (code != 0x06 ? std::to_string(quantity) : "") + ',' +
               (byte_count != 0 ? std::to_string(byte_count) : "") + ',';
    }
    static std::string payload(unsigned code, words_view words) {
        if (code == 0x06) {
            char text[8];
            (void)std::snprintf(text, sizeof text, ",%04x", unsigned{words[0]});
            return text;
        }
        std::string all;
        for (std::size_t i = 0; i < words.size(); ++i) all += (i != 0 ? " " : "") + std::to_string(words[i]);
        return all + ',';
    }

    std::ofstream file_;
    std::ofstream expected_;
    bool only_heads_ = false;
    unsigned number_ = 0;
    unsigned connection_ = 0;
};

// Adds the frames of a manual: each line has the direction and the bytes in hex.
bool printed_frames(capture& to, const char* file) {
    std::ifstream in{file};
    bool is_good = in.good();
    for (std::string line; std::getline(in, line);) {
        const std::size_t comma = line.find(',');
        const bool is_request = line.rfind("request,", 0) == 0;
        if (comma == line.npos || (!is_request && line.rfind("response,", 0) != 0)) continue;
        const std::string hex = line.substr(comma + 1, line.find(',', comma + 1) - comma - 1);
        std::vector<std::uint8_t> frame;
        for (std::size_t at = 0; at + 1 < hex.size(); at += 3)
            frame.push_back(static_cast<std::uint8_t>(std::stoul(hex.substr(at, 2), nullptr, 16)));
        is_good = is_good && to.printed(frame, is_request);
    }
    return is_good;
}

} // namespace

// Requests and responses of all functions, most of them the examples of the standard.
bool all_functions(capture& to) {
    to.exchanged(hex("01 00 13 00 13"), hex("01 03 CD 6B 05"));
    to.exchanged(hex("02 00 C4 00 16"), hex("02 03 AC DB 35"));
    to.exchanged(hex("03 00 6B 00 03"), hex("03 06 02 2B 00 00 00 64"));
    to.exchanged(hex("04 00 08 00 01"), hex("04 02 00 0A"));
    to.exchanged(hex("05 00 AC FF 00"), hex("05 00 AC FF 00"));
    to.exchanged(hex("06 00 01 00 03"), hex("06 00 01 00 03"));
    to.exchanged(hex("08 00 00 A5 37"), hex("08 00 00 A5 37"));
    to.exchanged(hex("0F 00 13 00 0A 02 CD 01"), hex("0F 00 13 00 0A"));
    to.exchanged(hex("10 00 01 00 02 04 00 0A 01 02"), hex("10 00 01 00 02"));
    to.exchanged(hex("11"), hex("11 07 74 61 62 6C 65 73 FF"));
    to.exchanged(hex("16 00 04 00 F2 00 25"), hex("16 00 04 00 F2 00 25"));
    to.exchanged(hex("17 00 03 00 02 00 0E 00 01 02 00 FF"), hex("17 04 00 FE 0A CD"));
    to.exchanged(hex("2B 0E 01 00"), hex("2B 0E 01 81 00 00 03 00 02 41 42 01 01 43 02 01 31"));
    to.exchanged(hex("01 00 13 00 13"), hex("81 02"));
    to.exchanged(hex("16 00 04 00 F2 00 25"), hex("96 02"));
    to.exchanged(hex("17 00 03 00 02 00 0E 00 01 02 00 FF"), hex("97 02"));
    return to.is_good();
}

int main(int count, char** files) {
    if (count == 3) {
        capture functions{files[1], files[2]};
        return all_functions(functions) ? 0 : 1;
    }
    capture to{files[1], files[2]};
    for (const std::uint8_t node_address : std::array<std::uint8_t, 3>{1, 17, 247}) {
        for (const std::uint16_t n : std::array<std::uint16_t, 4>{1, 2, 16, 125}) {
            to.transaction(modbus::read_frame(node_address, 0x2000, n));
            to.transaction(
                modbus::read_frame(node_address, 0x20AB, n, modbus::function::read_input_registers));
        }
        to.transaction(modbus::write_frame(node_address, 0x200E, 0x0008));
        to.transaction(modbus::write_frame(node_address, std::uint16_t{0}, std::uint16_t{0xFFFF}));
        to.transaction(modbus::write_frame(node_address, 0x2088, std::array<std::uint16_t, 1>{100}));
        to.transaction(modbus::write_frame(node_address, 0x2088, std::array<std::uint16_t, 2>{100, 0xFF9C}));
        std::array<std::uint16_t, 123> most{};
        for (std::size_t i = 0; i < most.size(); ++i) most[i] = static_cast<std::uint16_t>(i * 517);
        to.transaction(modbus::write_frame(node_address, 0x0100, most));
        to.transaction(modbus::read_frame(node_address, 0xF000, 2));
        to.transaction(modbus::read_frame(node_address, 0xF000, 2, modbus::function::read_input_registers));
        to.transaction(modbus::write_frame(node_address, 0xF000, 1));
        to.transaction(modbus::write_frame(node_address, 0xF000, most));
    }
    for (int i = 3; i < count; ++i) {
        if (!printed_frames(to, files[i])) return 1;
    }
    const modbus::frame<8> good = modbus::write_frame(17, 0x200E, 0x0008);
    for (std::size_t at = 2; at < good.size; ++at) to.spoilt(good, at);
    return to.is_good() ? 0 : 1;
}
