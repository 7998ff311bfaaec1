// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Describes any frame in one line of text: registers, values with their units, the device's meaning of an
// exception number, what is wrong with a frame. Programs include it for logs, captures and tools. It needs
// the device's catalogue and no heap.
//
//     constexpr auto line = [] {
//         std::array<char, 80> room{};
//         explain(zlac8015d::catalogue, direction::request, modbus::write_frame(1, 0x2080, 500), room);
//         return room; // "node 1: write left_acceleration_time (0x2080) = 500 ms"
//     }();
//
// Other lines:
//
//   node 1: response, left_actual_speed = 10.0 r/min, right_actual_speed = 10.0 r/min
//   node 1: response, exception 2 (illegal data address) to read unknown register (0x3000)
//   node 1: valid frame of function 05 (write single coil), data 00 01 FF 00
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>
#include <span>

#include <servobus/core/text.hpp>
#include <servobus/modbus/pdu.hpp>
#include <servobus/modbus/rtu.hpp>
#include <servobus/registers/catalogue.hpp>
#include <servobus/registers/format.hpp>

namespace servobus {

/// The direction of a frame.
enum class direction : std::uint8_t {
    unknown, ///< not known: the frame is parsed as both
    request,
    response,
};

/// The result of `explain` besides the text.
struct explanation {
    std::size_t size = 0; ///< number of characters written; truncated text ends in "..."
    /// `ok` for a well-formed frame; `why.exception` has the number of an exception response. Otherwise
    /// the error, see `explain`.
    status why{};
    /// Why the frame is not a response to the given request: `wrong_node`, `wrong_function`,
    /// `wrong_byte_count`, `wrong_address`, `wrong_value` or `wrong_quantity`. `ok` if it is one, or if no
    /// request was given.
    errc mismatch = errc::ok;
    /// The direction found. `unknown` if the frame is not well-formed, or if it was parsed as both directions
    /// and is valid in both: a write of one register equals its response. A frame of a function that is not
    /// explained keeps the direction that was given.
    direction way = direction::unknown;

    constexpr bool is_valid() const { return why.error() == errc::ok; }
};

namespace detail {

class explainer {
  public:
    constexpr explainer(const catalogue& map, word_order order, std::span<char> room)
        : map_{&map}, word_order_{order == word_order::unknown ? map.device->word_order : order}, out_{room} {
        if (word_order_ == word_order::unknown) assume_factory_word_order();
    }

    constexpr explanation explain(direction way, bytes frame, bytes before) {
        const result<modbus::opened> adu = modbus::open_frame(frame);
        if (!adu) {
            not_a_frame(frame, adu.error());
        } else {
            node_address(adu->address);
            pdu(way, *adu, frame, before);
        }
        found_.size = out_.size();
        return found_;
    }

  private:
    constexpr void assume_factory_word_order() {
        const u16 at = map_->device->word_order_register;
        const entry* e = at != 0 ? map_->find(at) : nullptr;
        if (e == nullptr || e->initial < 0 || e->initial > 1) return;
        word_order_ = e->initial == 0 ? word_order::high_first : word_order::low_first;
        is_factory_word_order_ = true;
    }

    constexpr void not_a_frame(bytes frame, errc why) {
        out_ << "invalid: " << text(why);
        if (why == errc::bad_crc) {
            const std::uint16_t crc = modbus::crc16(frame.first(frame.size() - 2));
            out_ << ", ends in ";
            out_.hex(frame[frame.size() - 2], 2) << ' ';
            out_.hex(frame[frame.size() - 1], 2) << ", should be ";
            out_.hex(crc & 0xFFu, 2) << ' ';
            out_.hex(crc >> 8, 2);
        } else {
            out_ << ", ";
            count(frame.size(), "byte");
        }
        found_.why = {why};
    }

    constexpr void node_address(std::uint8_t node_address) {
        if (node_address == modbus::broadcast) {
            out_ << "all nodes: ";
            return;
        }
        out_ << "node ";
        out_.number(node_address) << (modbus::is_node_address(node_address) ? ": " : " (reserved): ");
    }

    constexpr void pdu(direction way, const modbus::opened& adu, bytes frame, bytes before) {
        const result<modbus::request> asked = modbus::parse_request(adu.pdu);
        const result<modbus::response> answered = modbus::parse_response(adu.pdu);
        const bool may_be_request = way != direction::response && asked;
        const bool may_be_response =
            way != direction::request && answered && adu.address != modbus::broadcast;
        if (may_be_request) {
            request(adu.address, *asked);
            if (may_be_response) {
                out_ << (same_bytes(frame, before) ? " (the request again, or the response that echoes it)"
                                                   : " (request, or the response that echoes it)");
            } else {
                found_.way = direction::request;
            }
        } else if (may_be_response) {
            response(adu.address, *answered, before);
            found_.way = direction::response;
        } else if (way != direction::request && answered) {
            invalid("invalid: response from address 0, which no device has", errc::wrong_node);
        } else {
            malformed(way, adu.pdu, asked.error(), answered.error());
        }
    }

    constexpr void invalid(const char* words, errc why) {
        out_ << words;
        found_.why = {why};
    }

    constexpr void malformed(direction way, bytes pdu, errc as_request, errc as_response) {
        const std::uint8_t code = pdu[0];
        const bool is_exception = (code & modbus::exception_flag) != 0;
        if (!is_exception && !modbus::is_read(code) && !modbus::is_write(code)) return other(way, pdu);
        if (way == direction::unknown) way = likely(pdu);
        out_ << (way == direction::request ? "invalid request of function "
                                           : "invalid response to function ");
        function(code & 0x7Fu);
        const errc why = way == direction::request ? as_request : as_response;
        out_ << ": ";
        if (why == errc::wrong_function) {
            out_ << "an exception is no request";
        } else if (why == errc::wrong_address) {
            out_ << "registers beyond 0xFFFF";
        } else if (why == errc::wrong_quantity) {
            out_ << "wrong quantity ";
            out_.number(load_word(pdu, 3));
        } else if (why == errc::wrong_byte_count) {
            const std::size_t at = way == direction::request ? 5 : 1;
            out_ << text(why) << ' ';
            out_.number(pdu[at]) << " with ";
            count(pdu.size() - at - 1, "data byte");
            if (way == direction::request) {
                out_ << " for ";
                count(load_word(pdu, 3), "register");
            }
        } else {
            out_ << text(why);
        }
        found_.why = {why};
    }

    // A frame of a function whose content is not explained.
    constexpr void other(direction way, bytes pdu) {
        if (pdu[0] == 0) return invalid("invalid: function 00, which does not exist", errc::wrong_function);
        const bool has_its_length = fits_function(pdu);
        out_ << (has_its_length ? "valid frame of function " : "invalid: frame of function ");
        function(pdu[0]);
        out_ << " (" << name_of(pdu[0]) << ')';
        if (!has_its_length) {
            out_ << " with ";
            count(pdu.size() - 1, "data byte");
            found_.why = {errc::wrong_byte_count};
            return;
        }
        out_ << (pdu.size() == 1 ? ", no data" : ", data");
        for (const std::uint8_t byte : pdu.subspan(1)) {
            out_ << ' ';
            out_.hex(byte, 2);
        }
        found_.way = way;
    }

    // The names in the standard, section 6.
    static constexpr const char* name_of(std::uint8_t code) {
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

    // True if the PDU has a length that its function allows; true for functions whose lengths vary.
    static constexpr bool fits_function(bytes pdu) {
        const std::size_t size = pdu.size();
        const auto is_counted_at = [&](std::size_t at) { return size > at && size == at + 1 + pdu[at]; };
        switch (pdu[0]) {
        case 0x01:
        case 0x02: return size == 5 || is_counted_at(1);
        case 0x05: return size == 5;
        case 0x0F: return size == 5 || is_counted_at(5);
        case 0x11: return size == 1 || is_counted_at(1);
        case 0x16: return size == 7;
        case 0x17: return is_counted_at(1) || is_counted_at(9);
        default: return true;
        }
    }

    // The likely direction of a malformed frame, judged by its function code and length.
    static constexpr direction likely(bytes pdu) {
        if ((pdu[0] & modbus::exception_flag) != 0) return direction::response;
        if (modbus::is_read(pdu[0])) return pdu.size() == 5 ? direction::request : direction::response;
        return pdu[0] == 0x10 && pdu.size() <= 5 ? direction::response : direction::request;
    }

    constexpr void request(std::uint8_t node_address, const modbus::request& r) {
        what(r);
        if (node_address == modbus::broadcast && modbus::is_read(r.code))
            invalid(" (invalid: a broadcast read gets no response)", errc::bad_argument);
    }

    // Writes "read bus_voltage (0x20A1)" or "write control_word (0x200E) = enable (0x0008)".
    constexpr void what(const modbus::request& r) {
        out_ << (modbus::is_read(r.code) ? "read " : "write ");
        registers(r.address, r.quantity, modbus::is_write(r.code) ? r.values() : words_view{}, kind::request);
        if (r.code == 0x04) out_ << " as input registers";
    }

    constexpr void response(std::uint8_t node_address, const modbus::response& r, bytes before) {
        const result<modbus::opened> adu =
            before.empty() ? result<modbus::opened>{errc::too_short} : modbus::open_frame(before);
        const result<modbus::request> asked =
            adu ? modbus::parse_request(adu->pdu) : result<modbus::request>{errc::too_short};
        if (asked) found_.mismatch = mismatch(node_address, r, adu->address, *asked);
        const bool fits = asked && found_.mismatch == errc::ok;
        out_ << "response, ";
        if (r.is_exception) {
            found_.why.set_exception(r.exception);
            out_ << "exception ";
            out_.number(r.exception) << " (" << map_->device->meaning(r.exception) << ") to ";
            if (fits) {
                what(*asked);
            } else {
                out_ << "function ";
                function(r.code);
            }
        } else if (modbus::is_write(r.code)) {
            registers(r.address, fits ? asked->quantity : r.quantity, r.values(), kind::response);
            out_ << " written";
        } else if (fits) {
            registers(asked->address, asked->quantity, r.values(), kind::values);
        } else {
            count(r.quantity, "word");
            for (std::size_t i = 0; i < r.quantity; ++i) {
                out_ << ' ';
                out_.hex_word(r.values()[i]);
            }
        }
        if (asked && !fits)
            out_ << " (no response to the request before it: " << text(found_.mismatch) << ')';
    }

    constexpr errc mismatch(std::uint8_t node_address, const modbus::response& r, std::uint8_t asked_node,
                            const modbus::request& asked) const {
        if (node_address != asked_node) return errc::wrong_node;
        if (r.code != asked.code) return errc::wrong_function;
        if (r.is_exception) return errc::ok;
        if (modbus::is_read(r.code)) return r.quantity == asked.quantity ? errc::ok : errc::wrong_byte_count;
        if (r.address != asked.address) return errc::wrong_address;
        if (r.code == 0x06) return same_bytes(r.payload, asked.payload) ? errc::ok : errc::wrong_value;
        const bool is_byte_count =
            map_->device->limits.echoes_byte_count && r.quantity == 2 * std::uint32_t{asked.quantity};
        return r.quantity == asked.quantity || is_byte_count ? errc::ok : errc::wrong_quantity;
    }

    enum class kind : std::uint8_t { request, response, values };

    // Writes the names of registers and, if `words` is not empty, their values: "name (0x2080) = 500 ms, …".
    constexpr void registers(u16 address, u16 quantity, words_view words, kind how) {
        bool is_rescalable = false;
        bool is_reorderable = false;
        for (u16 i = 0; i < quantity;) {
            if (i != 0) out_ << ", ";
            const auto at = static_cast<u16>(address + i);
            const entry* e = map_->find(at);
            if (e == nullptr) {
                i = static_cast<u16>(i + unknown(at, static_cast<u16>(quantity - i), words, i));
                continue;
            }
            const std::size_t size = e->words();
            const bool is_whole = at == e->address && i + size <= quantity;
            if (!is_whole) out_ << half_of_pair(at == e->address);
            out_ << e->name;
            if (how != kind::values) put_address(at);
            if (i < words.size()) {
                out_ << " = ";
                if (is_whole) {
                    value(*e, words, i, how);
                    is_reorderable = is_reorderable || (is_factory_word_order_ && size == 2);
                } else {
                    out_.hex_word(words[i]);
                }
            }
            if (how == kind::request && words.size() != 0 && e->rights == access::ro) out_ << " (read-only)";
            is_rescalable = is_rescalable || (i < words.size() && has(e->flags, flag::scaled_elsewhere));
            i = static_cast<u16>(i + (is_whole ? size : 1u));
        }
        if (is_reorderable) out_ << " (in the factory's word order)";
        if (is_rescalable) out_ << factory_scale_note;
    }

    constexpr void value(const entry& e, words_view words, std::size_t i, kind how) {
        u32 bits = words[i];
        if (e.words() == 2) {
            if (word_order_ == word_order::unknown) {
                out_.hex_word(words[i]) << ' ';
                out_.hex_word(words[i + 1]) << " (word order unknown)";
                return;
            }
            bits = join_words(words[i], words[i + 1], word_order_);
        }
        put_value(out_, e, bits);
        if (how == kind::request && !e.limits.contains(e.number(bits))) {
            out_ << " (outside ";
            put_count(out_, e.limits.low, e.unit_of_count);
            out_ << "..";
            put_count(out_, e.limits.high, e.unit_of_count);
            out_ << ')';
        }
    }

    constexpr const char* half_of_pair(bool is_first) const {
        if (word_order_ == word_order::unknown || is_factory_word_order_)
            return is_first ? "first word of " : "second word of ";
        return is_first == (word_order_ == word_order::high_first) ? "high word of " : "low word of ";
    }

    // Writes consecutive addresses that the catalogue does not have. Returns how many there are.
    constexpr u16 unknown(u16 at, u16 most, words_view words, u16 i) {
        u16 n = 1;
        while (n < most && map_->find(static_cast<u16>(at + n)) == nullptr) ++n;
        out_ << (n == 1 ? "unknown register (" : "unknown registers (");
        out_.hex_word(at);
        if (n > 1) {
            out_ << "..";
            out_.hex_word(static_cast<u16>(at + n - 1));
        }
        out_ << ')';
        for (std::size_t k = i; k < words.size() && k < std::size_t{i} + n; ++k) {
            out_ << (k == i ? " = " : " ");
            out_.hex_word(words[k]);
        }
        return n;
    }

    constexpr void put_address(u16 address) {
        out_ << " (";
        out_.hex_word(address) << ')';
    }

    // Writes a function code as the standard does: 03, 06, 10h.
    constexpr void function(std::uint8_t code) {
        out_.hex(code, 2);
        if (code > 9) out_ << 'h';
    }

    constexpr void count(std::size_t n, const char* thing) {
        out_.number(static_cast<std::int64_t>(n)) << ' ' << thing;
        if (n != 1) out_ << 's';
    }

    const catalogue* map_;
    word_order word_order_;
    bool is_factory_word_order_ = false; // `order_` is assumed; the text says so
    text_writer out_;
    explanation found_{};
};

} // namespace detail

/// Describes `frame` in one line of text, which it writes into `out` without a terminating zero. `request` is
/// the frame to which a response may belong; a read response has register names only with its request.
/// `order` is the word order of 32-bit values; `unknown` selects that of the profile or, if the drive
/// can switch it, the factory setting; the text then has a note. A frame of another function than 03, 04, 06
/// and 10h is valid if its CRC and its length are; the text has its data in hex.
/// Errors, in `why`: `too_short`, `too_long`, `bad_crc`, `wrong_function` (00, or a request with the flag of an
/// exception), `wrong_byte_count`, `wrong_quantity`, `wrong_address` (beyond 0xFFFF), `wrong_node` (a response
/// from address 0), `bad_argument` (a broadcast read).
constexpr explanation explain(const catalogue& map, direction way, bytes frame, bytes request,
                              std::span<char> out, word_order order = word_order::unknown) {
    return detail::explainer{map, order, out}.explain(way, frame, request);
}

/// The same without a request.
constexpr explanation explain(const catalogue& map, direction way, bytes frame, std::span<char> out) {
    return explain(map, way, frame, bytes{}, out);
}

} // namespace servobus
