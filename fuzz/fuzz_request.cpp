// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Parses the input as a request PDU. The parser agrees with the reference and returns only data inside the
// PDU. An accepted request can be built again byte for byte. Then the same bytes are checked as a frame.
#include <array>
#include <cstdint>
#include <span>

#include <servobus/modbus/rtu.hpp>
#include <servobus/modbus/server.hpp>

#include "reference.hpp"
#include "support.hpp"

using namespace servobus;
using fuzz::require;

namespace {

bool is_inside(bytes part, bytes whole) {
    return part.empty() ||
           (part.data() >= whole.data() && part.data() + part.size() <= whole.data() + whole.size());
}

std::size_t made_again(const modbus::request& r, byte_buffer out) {
    const words_view values = r.values();
    if (modbus::is_read(r.code))
        return modbus::put_read_request(out, static_cast<modbus::function>(r.code), r.address, r.quantity);
    if (r.code == 0x06) return modbus::put_write_request(out, r.address, values[0]);
    std::array<std::uint16_t, modbus::max_write> words{};
    const auto used = std::span<std::uint16_t>{words}.first(values.size());
    values.copy_to(used);
    return modbus::put_write_request(out, r.address, used);
}

void as_pdu(bytes pdu) {
    const reference::byte_list copy{pdu.begin(), pdu.end()};
    const result<modbus::request> r = modbus::parse_request(pdu);
    const std::optional<reference::asked> expected = reference::request(copy);
    require(static_cast<bool>(r) == expected.has_value(),
            "parse_request accepts exactly the requests of the standard");
    if (!r) return;
    require(r->code == expected->code && r->address == expected->first && r->quantity == expected->count,
            "function, address and quantity are the request's own");
    require(is_inside(r->payload, pdu), "the payload lies inside the request");
    require(r->values().size() == expected->values.size(),
            "a write has as many values as its quantity states");
    for (std::size_t i = 0; i < expected->values.size(); ++i)
        require(r->values()[i] == expected->values[i], "the values are the request's own");
    std::array<std::uint8_t, modbus::max_pdu> again{};
    require(same_bytes(bytes{again}.first(made_again(*r, again)), pdu),
            "an accepted request is built again byte for byte");
}

void as_frame(bytes frame) {
    const reference::byte_list copy{frame.begin(), frame.end()};
    const result<modbus::opened> f = modbus::open_frame(frame);
    require(static_cast<bool>(f) == reference::is_frame(copy), "G10 a frame has 4..256 bytes and its CRC");
    require(modbus::crc16(frame) == reference::crc(frame.data(), frame.size()),
            "the CRC is that of the standard");
    if (!f) return;
    require(f->address == frame[0] && is_inside(f->pdu, frame), "a frame gives its own address and PDU");
    if (modbus::parse_request(f->pdu))
        require(modbus::request_length(frame) == frame.size(),
                "G6 the length of a request follows from its bytes");
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const bytes given{data, size};
    as_pdu(given);
    as_frame(given);
    // The fuzzer cannot guess a CRC.
    if (size < modbus::min_frame - 2 || size > modbus::max_frame - 2) return 0;
    const reference::byte_list framed = reference::framed({given.begin(), given.end()});
    as_frame(framed);
    as_pdu(bytes{framed}.subspan(1, framed.size() - 3));
    reference::byte_list closed{given.begin(), given.end()};
    closed.resize(size + 2);
    require(modbus::close_frame(closed, size - 1) == size + 2 && closed == framed,
            "a frame is closed by its CRC");
    return 0;
}
