// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The names of functions, of the sub-functions of 08 and of the objects of an identification, as the standard has them
// (Modbus Application Protocol V1.1b3, section 6); and numbers and bytes of a frame as text.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/text.hpp>
#include <servobus/modbus/diagnostics.hpp>
#include <servobus/modbus/pdu.hpp>

namespace servobus::detail {

/// A function beyond 03, 04, 06 and 10h, whose codes say enough.
constexpr const char* name_of_function(std::uint8_t code) {
    switch (code) {
    case 0x01: return "read coils";
    case 0x02: return "read discrete inputs";
    case 0x05: return "write single coil";
    case 0x07: return "read exception status";
    case 0x08: return "diagnostics";
    case 0x0B: return "get event counter";
    case 0x0C: return "get event log";
    case 0x0F: return "write multiple coils";
    case 0x11: return "report server ID";
    case 0x14: return "read file record";
    case 0x15: return "write file record";
    case 0x16: return "mask write register";
    case 0x17: return "read and write registers";
    case 0x18: return "read FIFO queue";
    case 0x2B: return "encapsulated interface";
    default: break;
    }
    const bool is_user_defined = (code >= 65 && code <= 72) || (code >= 100 && code <= 110);
    return is_user_defined ? "user-defined" : "not in the standard";
}

/// A sub-function of 08: what it reads, or what it does.
constexpr const char* name_of_diagnostic(modbus::diagnostic what) {
    switch (what) {
    case modbus::diagnostic::return_query_data: return "return query data";
    case modbus::diagnostic::restart_communications: return "restart communications";
    case modbus::diagnostic::diagnostic_register: return "diagnostic register";
    case modbus::diagnostic::change_delimiter: return "change ASCII delimiter";
    case modbus::diagnostic::listen_only: return "force listen-only mode";
    case modbus::diagnostic::clear_counters: return "clear counters and diagnostic register";
    case modbus::diagnostic::bus_messages: return "bus message count";
    case modbus::diagnostic::bus_communication_errors: return "bus communication error count";
    case modbus::diagnostic::bus_exceptions: return "bus exception count";
    case modbus::diagnostic::server_messages: return "server message count";
    case modbus::diagnostic::server_no_responses: return "server no response count";
    case modbus::diagnostic::server_negative_acknowledgements: return "server negative acknowledgement count";
    case modbus::diagnostic::server_busy: return "server busy count";
    case modbus::diagnostic::bus_character_overruns: return "bus character overrun count";
    case modbus::diagnostic::clear_overrun_counter: return "clear overrun counter";
    }
    return "reserved";
}

/// An object of an identification; null for those without a name.
constexpr const char* name_of_object(std::uint8_t id) {
    constexpr const char* names[] = {"vendor name",          "product code", "revision",
                                     "vendor URL",           "product name", "model name",
                                     "user application name"};
    return id < sizeof names / sizeof *names ? names[id] : nullptr;
}

/// Writes a function code as the standard does: 03, 06, 10h.
constexpr void put_code(text_writer& out, std::uint8_t code) {
    out.hex(code, 2);
    if (code > 9) out << 'h';
}
/// The same with the name of a function beyond registers: 02 (read discrete inputs).
constexpr void put_function(text_writer& out, std::uint8_t code) {
    put_code(out, code);
    if (!modbus::is_read(code) && !modbus::is_write(code)) out << " (" << name_of_function(code) << ')';
}

/// Writes "1 word", "2 words".
constexpr void put_number_of(text_writer& out, std::size_t n, const char* thing) {
    out.number(static_cast<std::int64_t>(n)) << ' ' << thing;
    if (n != 1) out << 's';
}

constexpr void put_bytes(text_writer& out, bytes all) {
    for (const std::uint8_t byte : all) {
        out << ' ';
        out.hex(byte, 2);
    }
}

/// Writes "2 words 0x0064 0x0064".
constexpr void put_words(text_writer& out, words_view words) {
    put_number_of(out, words.size(), "word");
    for (std::size_t i = 0; i < words.size(); ++i) {
        out << ' ';
        out.hex_word(words[i]);
    }
}

/// Writes text of a device in quotes; what a line of plain text cannot have as \x0A.
constexpr void put_quoted(text_writer& out, bytes text) {
    out << '"';
    for (const std::uint8_t byte : text) {
        if (byte >= ' ' && byte <= '~' && byte != '"' && byte != '\\') {
            out << static_cast<char>(byte);
        } else {
            out << "\\x";
            out.hex(byte, 2);
        }
    }
    out << '"';
}

} // namespace servobus::detail
