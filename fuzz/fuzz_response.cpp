// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Parses the input as a response PDU, without its request. The parser agrees with the reference and returns
// only data inside the PDU. The first three bytes determine the length of every response.
#include <cstdint>

#include <servobus/modbus/rtu.hpp>

#include "reference.hpp"
#include "support.hpp"

using namespace servobus;
using fuzz::require;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const bytes pdu{data, size};
    const reference::byte_list copy{pdu.begin(), pdu.end()};
    const result<modbus::response> r = modbus::parse_response(pdu);
    require(static_cast<bool>(r) == reference::is_response(copy),
            "parse_response accepts exactly the responses of the standard");
    if (!r) return 0;
    require(r->is_exception == (data[0] >= 0x80), "an exception is recognised by its flag");
    require(r->code == (data[0] & 0x7F), "the function is the response's own");
    const std::size_t length = size + 3;
    const bool is_known = r->is_exception || modbus::is_read(r->code) || modbus::is_write(r->code);
    require(is_known && modbus::response_length(data[0], data[1]) == length,
            "G6 the length of a response follows from its function and counts");
    if (r->is_exception) {
        require(r->exception == data[1], "G12 every exception number is returned unchanged");
    } else if (modbus::is_read(r->code)) {
        require(r->payload.data() == data + 2 && r->payload.size() == size - 2, "a read gives its words");
        require(r->quantity == r->values().size(), "a read has as many words as its byte count states");
    } else {
        require(r->address == reference::word(copy, 1), "the response to a write has its address");
        const unsigned second = reference::word(copy, 3);
        require(r->code == 0x06 ? r->quantity == 1 && r->values()[0] == second : r->quantity == second,
                "the response to a write has the value or the quantity");
    }
    return 0;
}
