// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// PDUs of function 2Bh with MEI type 0Eh, which reads a device's identification: its vendor, product, version and more,
// in one part or in several. Programs include it to build or parse these PDUs.
//
//     constexpr auto response = hex("2B 0E 01 01 00 00 01 00 02 41 42");
//     constexpr auto part = modbus::parse_identification_response({}, response); // asked for the basic objects
//     static_assert(part->count == 1 && (*part->begin()).value[0] == 'A');
//
// Source: Modbus Application Protocol V1.1b3, section 6.21.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/result.hpp>
#include <servobus/modbus/detail/response_checks.hpp>
#include <servobus/modbus/pdu.hpp>

namespace servobus::modbus {

/// The objects that a request for identification asks for ("read device ID code").
enum class identification : std::uint8_t {
    basic = 1,    ///< vendor name, product code, revision: objects 00..02
    regular = 2,  ///< also objects 03..7F, such as product name and model name
    extended = 3, ///< also objects 80..FF, which the device defines
    single = 4,   ///< one object
};

inline constexpr std::uint8_t mei_identification = 0x0E; ///< the MEI type of this function

namespace detail {
// Not constexpr on purpose, as in pdu.hpp: the error of a constant request names the rule.
inline void an_identification_is_basic_regular_extended_or_single() {}

constexpr bool is_identification(std::uint8_t code) { return code >= 1 && code <= 4; }
} // namespace detail

/// A request for identification: the objects of a kind from `object` on, or a single object.
struct identification_request {
    identification kind = identification::basic;
    std::uint8_t object = 0;
};

/// Builds a request of function 2Bh/0Eh into `out`. Returns its length, 4; 0 for a kind without a name, or if `out` is
/// too small.
constexpr std::size_t put_identification_request(byte_buffer out, identification_request asked) {
    if (!detail::is_identification(static_cast<std::uint8_t>(asked.kind))) {
        detail::an_identification_is_basic_regular_extended_or_single();
        return 0;
    }
    if (out.size() < 4) return 0;
    out[0] = static_cast<std::uint8_t>(function::encapsulated_interface);
    out[1] = mei_identification;
    out[2] = static_cast<std::uint8_t>(asked.kind);
    out[3] = asked.object;
    return 4;
}

/// Parses a request of function 2Bh/0Eh. Errors, in this order: `too_short` (empty), `wrong_function`, `too_short`,
/// `wrong_function` (another MEI type), `too_short`, `too_long`, `wrong_value` (a kind without a name).
constexpr result<identification_request> parse_identification_request(bytes pdu) {
    if (pdu.empty()) return errc::too_short;
    if (pdu[0] != static_cast<std::uint8_t>(function::encapsulated_interface)) return errc::wrong_function;
    if (pdu.size() < 2) return errc::too_short;
    if (pdu[1] != mei_identification) return errc::wrong_function;
    const errc wrong = detail::check_length(pdu, 4);
    if (wrong != errc::ok) return wrong;
    if (!detail::is_identification(pdu[2])) return errc::wrong_value;
    return identification_request{static_cast<identification>(pdu[2]), pdu[3]};
}

/// One object of a device's identification. Its value is text in ASCII unless the device defines otherwise.
struct identification_object {
    std::uint8_t id = 0;
    bytes value{};
};

/// A part of a device's identification: the objects of one response, `for (const auto object : part)`. It refers to the
/// response's bytes.
struct identification_part {
    std::uint8_t conformity = 0; ///< 1..3 as `identification`; plus 80h if single objects can be read
    std::uint8_t count = 0;      ///< objects
    std::uint8_t next = 0;       ///< the first object of the next part; 0: this is the last one
    bytes objects{};             ///< for each object its ID, its length and its value

    class iterator {
      public:
        constexpr explicit iterator(bytes left) : left_{left} {}
        constexpr identification_object operator*() const { return {left_[0], left_.subspan(2, left_[1])}; }
        constexpr iterator& operator++() {
            left_ = left_.subspan(2u + left_[1]);
            return *this;
        }
        friend constexpr bool operator==(const iterator& a, const iterator& b) {
            return a.left_.size() == b.left_.size();
        }

      private:
        bytes left_;
    };
    constexpr iterator begin() const { return iterator{objects}; }
    constexpr iterator end() const { return iterator{objects.last(0)}; }
};

namespace detail {
/// Checks the objects of a part, which fill its bytes and ascend. Returns the last one's ID.
constexpr result<std::uint8_t> check_objects(bytes objects, std::uint8_t count) {
    std::uint8_t last = 0;
    for (std::uint8_t i = 0; i < count; ++i) {
        if (objects.size() < 2 || objects.size() - 2 < objects[1]) return errc::too_short;
        if (i != 0 && objects[0] <= last) return errc::unexpected_value;
        last = objects[0];
        objects = objects.subspan(2u + objects[1]);
    }
    return objects.empty() ? result<std::uint8_t>{last} : errc::too_long;
}
} // namespace detail

/// Parses a response of function 2Bh/0Eh.
/// Errors, in this order: `too_short`, `exception`, `wrong_function`, `too_long` (an exception, or more than a PDU
/// has), `too_short`, `wrong_function` (another MEI type), `wrong_value` (another kind than requested),
/// `unexpected_value` (a conformity level or a "more follows" that the standard does not have, or a next object
/// although none follows), `wrong_quantity` (no object, or not one for a single one), `too_short` and `too_long` (the
/// objects do not fill the PDU), `unexpected_value` (the objects do not ascend, or the next is not after them),
/// `wrong_address` (another single object).
constexpr result<identification_part> parse_identification_response(identification_request asked, bytes pdu) {
    const status head = detail::check_head(function::encapsulated_interface, pdu);
    if (!head) return head;
    if (pdu.size() > max_pdu) return errc::too_long;
    if (pdu.size() < 7) return errc::too_short;
    if (pdu[1] != mei_identification) return errc::wrong_function;
    if (pdu[2] != static_cast<std::uint8_t>(asked.kind)) return errc::wrong_value;
    const bool is_single = asked.kind == identification::single;
    const std::uint8_t level = pdu[3] & 0x7Fu;
    const bool has_more = pdu[4] == 0xFF;
    if (level == 0 || level > 3) return errc::unexpected_value;
    if (has_more ? is_single : pdu[4] != 0 || pdu[5] != 0) return errc::unexpected_value;
    if (pdu[6] == 0 || (is_single && pdu[6] != 1)) return errc::wrong_quantity;
    const identification_part part{pdu[3], pdu[6], pdu[5], pdu.subspan(7)};
    const result<std::uint8_t> last = detail::check_objects(part.objects, part.count);
    if (!last) return last.error();
    if (has_more && part.next <= *last) return errc::unexpected_value;
    return !is_single || *last == asked.object ? result<identification_part>{part} : errc::wrong_address;
}

/// The requests that read a whole identification, part by part: send `request()`, then `take` its response, until
/// `is_done()`. Each part begins after the one before, so there are at most 256.
class identification_parts {
  public:
    constexpr explicit identification_parts(identification kind) : asked_{kind, 0} {}

    constexpr bool is_done() const { return is_done_; }
    constexpr identification_request request() const { return asked_; }

    /// Takes the response to `request()`. After an error the same request may be sent again.
    /// Errors: those of `parse_identification_response`; `unexpected_value` also if the device begins again.
    constexpr result<identification_part> take(bytes pdu) {
        const result<identification_part> part = parse_identification_response(asked_, pdu);
        if (!part) return part;
        if ((*part->begin()).id < asked_.object) return errc::unexpected_value;
        is_done_ = part->next == 0;
        if (!is_done_) asked_.object = part->next;
        return part;
    }

  private:
    identification_request asked_;
    bool is_done_ = false;
};

} // namespace servobus::modbus
