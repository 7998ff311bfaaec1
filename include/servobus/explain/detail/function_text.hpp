// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The content of requests and responses as text, for every function whose content is known. All PDUs are well-formed.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>

#include <servobus/explain/detail/bit_text.hpp>
#include <servobus/explain/detail/function_names.hpp>
#include <servobus/explain/detail/register_text.hpp>
#include <servobus/explain/table_catalogues.hpp>
#include <servobus/modbus/functions.hpp>

namespace servobus::detail {

class function_text {
  public:
    constexpr function_text(const table_catalogues& maps, register_text& registers, text_writer& out)
        : registers_{registers}, bits_{maps, out}, out_{out} {}

    /// Writes "read bus_voltage (0x20A1)" or "write coil 0x00AC = on".
    constexpr void put_request(bytes pdu) {
        using modbus::function;
        switch (static_cast<function>(pdu[0])) {
        case function::read_coils:
        case function::read_discrete_inputs:
        case function::write_single_coil:
        case function::write_multiple_coils: return bits_.put_request(pdu);
        case function::read_exception_status: out_ << "read exception status"; return;
        case function::get_event_counter: out_ << "read event counter"; return;
        case function::get_event_log: out_ << "read event log"; return;
        case function::report_server_id: out_ << "report server ID"; return;
        case function::diagnostics: return put_diagnostic_request(*modbus::parse_diagnostic_request(pdu));
        case function::mask_write_register:
            out_ << "mask write ";
            return put_mask_write(*modbus::parse_mask_write_request(pdu), register_text::kind::request);
        case function::read_write_registers: {
            const modbus::read_write r = *modbus::parse_read_write_request(pdu);
            out_ << "write ";
            registers_.put(r.write_address, static_cast<u16>(r.values.size()), r.values,
                           register_text::kind::request);
            out_ << ", then read ";
            return registers_.put(r.read_address, r.quantity, {}, register_text::kind::request);
        }
        case function::read_fifo_queue:
            out_ << "read FIFO queue";
            return put_address(out_, *modbus::parse_fifo_request(pdu));
        case function::encapsulated_interface:
            return put_identification_request(*modbus::parse_identification_request(pdu));
        default: return put_register_request(*modbus::parse_request(pdu));
        }
    }

    /// Writes the words after "response, ". `request` is the PDU to which it responds; empty if it is not known.
    constexpr void put_response(bytes pdu, bytes request) {
        using modbus::function;
        switch (static_cast<function>(pdu[0])) {
        case function::read_coils:
        case function::read_discrete_inputs: return bits_.put_read(pdu, request);
        case function::write_single_coil:
        case function::write_multiple_coils: return bits_.put_written(pdu);
        case function::read_exception_status:
            out_ << "exception status 0x";
            out_.hex(*modbus::parse_exception_status(pdu), 2);
            return;
        case function::diagnostics: return put_diagnostic_response(pdu);
        case function::get_event_counter: {
            const modbus::event_counter counter = *modbus::parse_event_counter(pdu);
            out_ << "event counter ";
            out_.number(counter.count);
            return put_busy(counter.is_busy);
        }
        case function::get_event_log: return put_event_log(*modbus::parse_event_log(pdu));
        case function::report_server_id:
            out_ << "server ID";
            return put_bytes(out_, *modbus::parse_server_id(pdu));
        case function::mask_write_register:
            put_mask_write(*modbus::parse_mask_write_request(pdu), register_text::kind::response);
            out_ << " written";
            return;
        case function::read_write_registers: {
            const words_view words{pdu.subspan(2)};
            if (request.empty()) return put_words(out_, words);
            return registers_.put(load_word(request, 1), load_word(request, 3), words,
                                  register_text::kind::values);
        }
        case function::read_fifo_queue:
            out_ << "FIFO queue";
            if (!request.empty()) put_address(out_, load_word(request, 1));
            out_ << ", ";
            return put_words(out_, *modbus::parse_fifo_response(pdu));
        case function::encapsulated_interface: return put_identification(pdu);
        default: return put_register_response(*modbus::parse_response(pdu), request);
        }
    }

  private:
    static constexpr table table_of(std::uint8_t code) {
        return code == 0x04 ? table::input_registers : table::holding_registers;
    }
    constexpr void put_register_request(const modbus::request& r) {
        out_ << (modbus::is_read(r.code) ? "read " : "write ");
        registers_.put(r.address, r.quantity, modbus::is_write(r.code) ? r.values() : words_view{},
                       register_text::kind::request, table_of(r.code));
        if (r.code == 0x04) out_ << " as input registers";
    }
    constexpr void put_register_response(const modbus::response& r, bytes request) {
        if (modbus::is_write(r.code)) {
            const u16 quantity = request.empty() ? r.quantity : modbus::parse_request(request)->quantity;
            registers_.put(r.address, quantity, r.values(), register_text::kind::response);
            out_ << " written";
        } else if (request.empty()) {
            put_words(out_, r.values());
        } else {
            registers_.put(load_word(request, 1), load_word(request, 3), r.values(),
                           register_text::kind::values, table_of(r.code));
        }
    }
    constexpr void put_mask_write(const modbus::mask_write& change, register_text::kind how) {
        registers_.put(change.address, 1, {}, how);
        out_ << ", and ";
        out_.hex_word(change.and_mask) << ", or ";
        out_.hex_word(change.or_mask);
    }

    /// True for the sub-functions that read a counter or the diagnostic register.
    static constexpr bool is_read(modbus::diagnostic what) {
        const auto number = static_cast<u16>(what);
        return number == 0x02 || (number >= 0x0B && number <= 0x12);
    }
    constexpr void put_diagnostic_request(const modbus::diagnostic_request& r) {
        if (is_read(r.what)) out_ << "read ";
        out_ << name_of_diagnostic(r.what);
        if (r.what == modbus::diagnostic::return_query_data) put_data(r.data);
        if (r.what == modbus::diagnostic::change_delimiter) {
            out_ << " to 0x";
            out_.hex(r.data[0] >> 8u, 2);
        }
        if (r.what == modbus::diagnostic::restart_communications && r.data[0] != 0)
            out_ << " and clear the event log";
    }
    constexpr void put_diagnostic_response(bytes pdu) {
        const auto what = static_cast<modbus::diagnostic>(load_word(pdu, 1));
        const words_view data{pdu.subspan(3)};
        if (what == modbus::diagnostic::diagnostic_register) {
            out_ << name_of_diagnostic(what);
            put_data(data);
        } else if (is_read(what)) {
            out_ << name_of_diagnostic(what) << ' ';
            out_.number(data[0]);
        } else {
            put_diagnostic_request({what, data});
            if (what != modbus::diagnostic::return_query_data) out_ << ", done";
        }
    }
    constexpr void put_data(words_view data) {
        for (std::size_t i = 0; i < data.size(); ++i) {
            out_ << ' ';
            out_.hex_word(data[i]);
        }
    }
    constexpr void put_busy(bool is_busy) {
        if (is_busy) out_ << ", busy";
    }
    constexpr void put_event_log(const modbus::event_log& log) {
        out_ << "event log of ";
        put_number_of(out_, log.event_count, "event");
        out_ << " and ";
        put_number_of(out_, log.message_count, "message");
        if (!log.events.empty()) out_ << ", newest first:";
        put_bytes(out_, log.events);
        put_busy(log.is_busy);
    }

    constexpr void put_object(std::uint8_t id) {
        if (const char* name = name_of_object(id)) {
            out_ << name;
            return;
        }
        out_ << "object 0x";
        out_.hex(id, 2);
    }
    constexpr void put_identification_request(const modbus::identification_request& r) {
        constexpr const char* kinds[] = {"", "basic ", "regular ", "extended ", ""};
        out_ << "read " << kinds[static_cast<unsigned>(r.kind)] << "identification";
        if (r.kind != modbus::identification::single && r.object == 0) return;
        out_ << (r.kind == modbus::identification::single ? ", " : ", from ");
        put_object(r.object);
        if (r.kind != modbus::identification::single) out_ << " on";
    }
    constexpr void put_identification(bytes pdu) {
        const modbus::identification_request asked{static_cast<modbus::identification>(pdu[2]), pdu[7]};
        const modbus::identification_part part = *modbus::parse_identification_response(asked, pdu);
        out_ << "identification";
        for (const modbus::identification_object object : part) {
            out_ << ", ";
            put_object(object.id);
            out_ << ' ';
            put_quoted(out_, object.value);
        }
        if (part.next == 0) return;
        out_ << ", more from ";
        put_object(part.next);
        out_ << " on";
    }

    register_text& registers_;
    bit_text bits_;
    text_writer& out_;
};

} // namespace servobus::detail
