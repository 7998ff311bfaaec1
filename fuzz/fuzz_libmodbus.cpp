// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Sends the same request to this library's server and to that of libmodbus (modbus_reply, whose RTU back
// end sends into a pair of sockets here). Both must give the same response and leave the same registers,
// except for what `differs_by_name` lists.
#include <array>
#include <cstdint>
#include <cstring>
#include <span>

#include <modbus/modbus.h>
#include <sys/socket.h>
#include <unistd.h>

#include <servobus/modbus/server.hpp>

#include "reference.hpp"
#include "support.hpp"

using namespace servobus;
using fuzz::require;

namespace {

constexpr std::uint8_t node_address = 5;
constexpr int first = 0x0100;
constexpr int count = 200;

/// The server of libmodbus, with holding and input registers at the same addresses.
struct theirs {
    modbus_t* server = modbus_new_rtu("/dev/null", 115200, 'N', 8, 1);
    modbus_mapping_t* map = modbus_mapping_new_start_address(0, 0, 0, 0, first, count, first, count);
    int ends[2] = {-1, -1};

    theirs() {
        require(server != nullptr && map != nullptr && ::socketpair(AF_UNIX, SOCK_STREAM, 0, ends) == 0,
                "libmodbus has its server");
        (void)modbus_set_slave(server, node_address);
        (void)modbus_set_socket(server, ends[0]);
        (void)modbus_set_response_timeout(server, 0, 1); // it sleeps for this time before each exception
    }
    theirs(const theirs&) = delete;
    theirs& operator=(const theirs&) = delete;

    // Copies the request into a larger buffer, since libmodbus reads beyond the length that it receives.
    reference::byte_list response_to(const reference::byte_list& frame) {
        std::array<std::uint8_t, 600> request{};
        std::memcpy(request.data(), frame.data(), frame.size());
        (void)modbus_reply(server, request.data(), static_cast<int>(frame.size()), map);
        std::array<std::uint8_t, 300> got{};
        const ssize_t n = ::recv(ends[1], got.data(), got.size(), MSG_DONTWAIT);
        return n <= 0 ? reference::byte_list{} : reference::byte_list(got.begin(), got.begin() + n);
    }
};

/// The registers of this library's server.
struct store {
    std::array<std::uint16_t, count> words{};

    static bool has(std::uint16_t address, std::size_t size) {
        return address >= first && address - first + static_cast<int>(size) <= count;
    }
    std::uint8_t read(std::uint16_t address, std::span<std::uint16_t> to) {
        if (!has(address, to.size())) return 2;
        for (std::size_t i = 0; i < to.size(); ++i) to[i] = words[address - unsigned{first} + i];
        return 0;
    }
    std::uint8_t write(std::uint16_t address, words_view from) {
        if (!has(address, from.size())) return 2;
        for (std::size_t i = 0; i < from.size(); ++i) words[address - unsigned{first} + i] = from[i];
        return 0;
    }
};

/// Requests to which libmodbus responds differently from the standard, and its functions other than 03, 04,
/// 06 and 10h.
bool differs_by_name(const reference::byte_list& pdu) {
    const unsigned code = pdu[0];
    if (code == 1 || code == 2 || code == 5 || code == 15) return true; // coils and inputs
    if (code == 7 || code == 17 || code == 22 || code == 23)
        return true;     // status, identity, mask write, read and write
    return code >= 0x80; // no valid request: libmodbus responds without the exception flag
}

// Cuts a request as the receiver of libmodbus would: it computes the length from function and byte count.
reference::byte_list cut_as_received(reference::byte_list pdu) {
    if (pdu[0] == 16) {
        pdu.resize(std::max<std::size_t>(pdu.size(), 6));
        pdu.resize(6u + pdu[5]);
        if (pdu.size() > 253) pdu.resize(253);
    } else {
        pdu.resize(5);
    }
    return pdu;
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static theirs other;
    static store own;
    for (unsigned i = 0; i < count; ++i)
        own.words[i] = other.map->tab_registers[i] = other.map->tab_input_registers[i] =
            static_cast<std::uint16_t>(i * 771);
    fuzz::input in{data, size};
    for (int i = 0; i < 8 && !in.empty(); ++i) {
        const unsigned how = in.byte();
        const bytes raw = in.take(1u + in.byte());
        if (raw.empty()) break;
        reference::byte_list pdu{raw.begin(), raw.end()};
        if ((how & 1u) != 0) pdu[0] = how / 2 % 3 == 0 ? 3 : how / 2 % 3 == 1 ? 16 : 6;
        pdu = cut_as_received(pdu);
        if ((how & 0x80u) != 0) pdu[1] = 1; // an address where registers are
        if (differs_by_name(pdu)) continue;
        reference::byte_list body{node_address};
        body.insert(body.end(), pdu.begin(), pdu.end());

        std::array<std::uint8_t, modbus::max_frame> response{node_address};
        const std::size_t length = respond(own, pdu, byte_buffer{response}.subspan(1, modbus::max_pdu),
                                           modbus::server_rules{.reads_input_registers = true});
        const bytes ours{response.data(), modbus::close_frame(response, length)};
        require(same_bytes(other.response_to(reference::framed(body)), ours),
                "both servers give the same response");
        // In libmodbus, input registers and holding registers are separate.
        for (unsigned k = 0; k < count; ++k) other.map->tab_input_registers[k] = other.map->tab_registers[k];
        require(std::memcmp(own.words.data(), other.map->tab_registers, 2 * count) == 0,
                "both servers have the same registers afterwards");
    }
    return 0;
}
