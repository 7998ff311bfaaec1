// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Takes the input as a request and a response to it, of any function: a byte with the request's length, the request,
// and the response. The checks agree with a judge that is written apart from the library, a response's length is known
// at each of its bytes as the judge knows it, and an accepted request can be built again byte for byte.
#include <array>
#include <cstdint>
#include <vector>

#include <servobus/modbus/functions.hpp>
#include <servobus/modbus/growing_response.hpp>

#include "../tests/support/functions_reference.hpp"
#include "support.hpp"

using namespace servobus;
using functions_reference::verdict;
using fuzz::byte_list;
using fuzz::require;

namespace {

std::vector<std::uint16_t> words_of(words_view view) {
    std::vector<std::uint16_t> words(view.size());
    view.copy_to(words);
    return words;
}

/// Builds bits again. The padding of a request may have been anything.
std::size_t bits_again(bytes pdu, byte_buffer out) {
    const modbus::bits_request r = *modbus::parse_bits_request(pdu);
    if (r.is_read()) return modbus::put_read_bits_request(out, r.code, r.address, r.quantity);
    if (r.code == modbus::function::write_single_coil)
        return modbus::put_write_coil_request(out, r.address, r.coils()[0]);
    const std::size_t size = modbus::put_write_coils_request(out, r.address, r.coils());
    out[size - 1] = pdu[size - 1];
    return size;
}

std::size_t made_again(bytes pdu, byte_buffer out) {
    using modbus::function;
    const auto code = static_cast<function>(pdu[0]);
    if (modbus::parse_bits_request(pdu)) return bits_again(pdu, out);
    if (modbus::parse_bare_request(pdu)) return modbus::put_bare_request(out, code);
    if (const auto r = modbus::parse_mask_write_request(pdu)) return modbus::put_mask_write_request(out, *r);
    if (const auto r = modbus::parse_fifo_request(pdu)) return modbus::put_fifo_request(out, *r);
    if (const auto r = modbus::parse_identification_request(pdu))
        return modbus::put_identification_request(out, *r);
    if (const auto r = modbus::parse_read_write_request(pdu))
        return modbus::put_read_write_request(out, r->read_address, r->quantity, r->write_address,
                                              words_of(r->values));
    if (const auto r = modbus::parse_diagnostic_request(pdu)) {
        if (r->what == modbus::diagnostic::return_query_data)
            return modbus::put_return_query_data_request(out, words_of(r->data));
        return modbus::put_diagnostic_request(out, r->what);
    }
    return 0; // registers, which fuzz_request.cpp has
}

void as_request(const byte_list& pdu) {
    const errc found = modbus::check_request(pdu).error();
    const unsigned number = functions_reference::exception_of(pdu);
    require((found == errc::ok) == (number == 0), "a request is valid if the judge says so");
    if (number != 0) {
        const unsigned said = found == errc::wrong_function ? 1 : found == errc::wrong_address ? 2 : 3;
        require(said == number,
                "function comes before quantity, count and value, and these before the address");
        return;
    }
    std::array<std::uint8_t, modbus::max_pdu> again{};
    const std::size_t size = made_again(pdu, again);
    require(size == 0 || same_bytes(bytes{again}.first(size), pdu),
            "a valid request is built again byte for byte");
}

void as_response(const byte_list& asked, const byte_list& pdu) {
    const status found = modbus::check_response(asked, pdu);
    if (functions_reference::exception_of(asked) != 0) {
        require(found == errc::bad_argument, "a wrong request has no valid response");
        return;
    }
    const verdict judged = functions_reference::judge(asked, pdu);
    require((found == errc::ok) == (judged == verdict::valid), "a response is valid if the judge says so");
    require((found == errc::exception) == (judged == verdict::exception),
            "an exception has its function and two bytes");
    require((found == errc::wrong_function) == (judged == verdict::other_function),
            "a function is judged alike");
    require(found != errc::exception || found.exception() == pdu[1], "an exception keeps its number");
    if (judged == verdict::valid || judged == verdict::exception)
        require(modbus::growing_response{asked}.least_length(pdu) == pdu.size(), "a valid response is whole");
}

void as_length(const byte_list& asked, const byte_list& pdu) {
    modbus::growing_response growing{asked};
    std::size_t before = 0;
    for (std::size_t have = 0; have <= pdu.size(); ++have) {
        const byte_list begun{pdu.begin(), pdu.begin() + static_cast<std::ptrdiff_t>(have)};
        const std::size_t least = growing.least_length(begun);
        require(least == functions_reference::least(asked, begun),
                "a length is known at each byte as the judge knows it");
        require(least >= before && least <= modbus::max_pdu, "a length only grows, and never beyond a PDU");
        before = least;
    }
}

/// Reads an identification from a device that responds to each request with the same bytes.
void as_identification(bytes pdu) {
    modbus::identification_parts all{modbus::identification::extended};
    unsigned requests = 0;
    while (!all.is_done() && all.take(pdu)) require(++requests <= 256, "an identification ends");
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::input in{data, size};
    const bytes request = in.take(in.byte());
    const bytes response = in.take(300);
    const byte_list asked{request.begin(), request.end()};
    const byte_list pdu{response.begin(), response.end()};
    as_request(asked);
    as_response(asked, pdu);
    as_length(asked, pdu);
    as_identification(response);
    return 0;
}
