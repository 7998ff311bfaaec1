// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A frame as text: its address, its direction, whether it belongs to the request before it, what is wrong with it.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>
#include <span>

#include <servobus/explain/detail/flaw_text.hpp>
#include <servobus/explain/detail/function_text.hpp>
#include <servobus/explain/detail/register_text.hpp>
#include <servobus/explain/explanation.hpp>
#include <servobus/explain/table_catalogues.hpp>
#include <servobus/modbus/functions.hpp>
#include <servobus/modbus/rtu.hpp>

namespace servobus::detail {

class explainer {
  public:
    constexpr explainer(const table_catalogues& maps, word_order order, std::span<char> room)
        : out_{room}, registers_{maps, order, out_}, functions_{maps, registers_, out_} {}

    constexpr explanation explain(direction way, bytes frame, bytes before) {
        const result<modbus::opened> adu = modbus::open_frame(frame);
        if (!adu) {
            not_a_frame(frame, adu.error());
        } else {
            note_request(before);
            node_address(adu->address);
            pdu(way, *adu, same_bytes(frame, before));
        }
        found_.size = out_.size();
        return found_;
    }

  private:
    constexpr void not_a_frame(bytes frame, errc why) {
        out_ << "invalid: " << text(why);
        if (why == errc::bad_crc) {
            const std::uint16_t crc = modbus::crc16(frame.first(frame.size() - 2));
            out_ << ", ends in";
            put_bytes(out_, frame.last(2));
            out_ << ", should be ";
            out_.hex(crc & 0xFFu, 2) << ' ';
            out_.hex(crc >> 8, 2);
        } else {
            out_ << ", ";
            put_number_of(out_, frame.size(), "byte");
        }
        found_.why = {why};
    }

    // An invalid request is not used.
    constexpr void note_request(bytes before) {
        const result<modbus::opened> adu =
            before.empty() ? result<modbus::opened>{errc::too_short} : modbus::open_frame(before);
        if (adu && is_request(adu->pdu)) request_ = *adu;
    }

    constexpr void node_address(std::uint8_t node_address) {
        if (node_address == modbus::broadcast) {
            out_ << "all nodes: ";
            return;
        }
        out_ << "node ";
        out_.number(node_address) << (modbus::is_node_address(node_address) ? ": " : " (reserved): ");
    }

    constexpr void pdu(direction way, const modbus::opened& adu, bool is_repeated) {
        const bool is_exception = (adu.pdu[0] & modbus::exception_flag) != 0;
        if (!is_exception && !is_of_known_function(adu.pdu)) return other(way, adu.pdu);
        const bool answers = is_response(adu.pdu);
        bool may_be_request = way != direction::response && is_request(adu.pdu);
        bool may_be_response = way != direction::request && answers && adu.address != modbus::broadcast;
        if (may_be_request && may_be_response && !has_equal_response(adu.pdu[0])) {
            may_be_response = mismatch(adu) == errc::ok && !request_.pdu.empty();
            may_be_request = !may_be_response;
        }
        if (may_be_request) {
            request(adu);
            if (may_be_response) {
                out_ << (is_repeated ? " (the request again, or the response that echoes it)"
                                     : " (request, or the response that echoes it)");
            } else {
                found_.way = direction::request;
            }
        } else if (may_be_response) {
            response(adu);
            found_.way = direction::response;
        } else if (way != direction::request && answers) {
            invalid("invalid: response from address 0, which no device has", errc::wrong_node);
        } else {
            malformed(way, adu.pdu);
        }
    }

    // A function whose response repeats its request.
    static constexpr bool has_equal_response(std::uint8_t code) {
        return code == 0x05 || code == 0x06 || code == 0x08 || code == 0x16;
    }

    constexpr void invalid(const char* words, errc why) {
        out_ << words;
        found_.why = {why};
    }

    constexpr void malformed(direction way, bytes pdu) {
        if (way == direction::unknown) way = likely_direction(pdu);
        const bool is_of_client = way == direction::request;
        out_ << (is_of_client ? "invalid request of function " : "invalid response to function ");
        put_function(out_, pdu[0] & 0x7Fu);
        out_ << ": ";
        found_.why = {is_of_client ? modbus::check_request(pdu).error() : check_lone_response(pdu)};
        flaw_text{way, pdu, out_}.put(found_.why.error());
    }

    // A frame of a function whose content is not known.
    constexpr void other(direction way, bytes pdu) {
        if (pdu[0] == 0) return invalid("invalid: function 00, which does not exist", errc::wrong_function);
        out_ << "valid frame of function ";
        put_function(out_, pdu[0]);
        out_ << (pdu.size() == 1 ? ", no data" : ", data");
        put_bytes(out_, pdu.subspan(1));
        found_.way = way;
    }

    constexpr void request(const modbus::opened& adu) {
        functions_.put_request(adu.pdu);
        const bool is_executed =
            modbus::is_write(adu.pdu[0]) || adu.pdu[0] == 0x0F || has_equal_response(adu.pdu[0]);
        if (adu.address == modbus::broadcast && !is_executed)
            invalid(" (invalid: a broadcast read gets no response)", errc::bad_argument);
    }

    constexpr void response(const modbus::opened& adu) {
        const bool has_request = !request_.pdu.empty();
        if (has_request) found_.mismatch = mismatch(adu);
        const bool fits = has_request && found_.mismatch == errc::ok;
        out_ << "response, ";
        if ((adu.pdu[0] & modbus::exception_flag) != 0) {
            exception(adu.pdu, fits);
        } else {
            functions_.put_response(adu.pdu, fits ? request_.pdu : bytes{});
        }
        if (!has_request || fits) return;
        out_ << " (no response to the request before it: ";
        flaw_text::put_reason(out_, found_.mismatch);
        out_ << ')';
    }

    constexpr void exception(bytes pdu, bool fits) {
        found_.why.set_exception(pdu[1]);
        out_ << "exception ";
        out_.number(pdu[1]) << " (" << registers_.device().meaning(pdu[1]) << ") to ";
        if (fits) return functions_.put_request(request_.pdu);
        out_ << "function ";
        put_function(out_, pdu[0] & 0x7Fu);
    }

    // Why a well-formed response does not belong to the request.
    constexpr errc mismatch(const modbus::opened& adu) const {
        if (request_.pdu.empty()) return errc::ok;
        if (adu.address != request_.address) return errc::wrong_node;
        const status why = check_seen_response(request_.pdu, adu.pdu);
        if (why.error() == errc::exception) return errc::ok;
        // Deviation of a device: the byte count in place of the quantity.
        const bool has_byte_count = why.error() == errc::wrong_quantity && adu.pdu[0] == 0x10 &&
                                    load_word(adu.pdu, 3) == 2u * load_word(request_.pdu, 3);
        return has_byte_count && registers_.device().limits.echoes_byte_count ? errc::ok : why.error();
    }

    text_writer out_;
    register_text registers_;
    function_text functions_;
    modbus::opened request_{}; // to which the frame may respond; without a PDU if there is none
    explanation found_{};
};

} // namespace servobus::detail
