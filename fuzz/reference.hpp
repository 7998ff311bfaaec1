// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A second implementation of Modbus, in another style and independent of the library, whose parsers and
// server are judged by it. It follows the flow charts of the standard (Modbus Application Protocol V1.1b3,
// section 6).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace reference {

using byte_list = std::vector<std::uint8_t>;

/// CRC-16/MODBUS, bit by bit.
inline unsigned crc(const std::uint8_t* data, std::size_t size) {
    unsigned crc = 0xFFFF;
    while (size-- != 0) {
        crc ^= *data++;
        for (int bit = 0; bit < 8; ++bit) crc = (crc & 1u) != 0 ? (crc >> 1) ^ 0xA001u : crc >> 1;
    }
    return crc;
}

inline byte_list framed(byte_list body) {
    const unsigned c = crc(body.data(), body.size());
    body.push_back(static_cast<std::uint8_t>(c & 0xFFu));
    body.push_back(static_cast<std::uint8_t>(c >> 8));
    return body;
}

/// True for 4..256 bytes that end with their CRC.
inline bool is_frame(const byte_list& f) {
    if (f.size() < 4 || f.size() > 256) return false;
    return crc(f.data(), f.size() - 2) == (f[f.size() - 2] | static_cast<unsigned>(f[f.size() - 1]) << 8);
}

inline unsigned word(const byte_list& b, std::size_t at) { return b[at] * 256u + b[at + 1]; }

/// A request for registers, as the standard defines it.
struct asked {
    unsigned code, first, count;
    std::vector<unsigned> values; ///< of a write
};

/// Nothing if the PDU is not exactly a request of function 03, 04, 06 or 10h.
inline std::optional<asked> request(const byte_list& pdu) {
    if (pdu.size() < 5) return std::nullopt;
    asked a{pdu[0], word(pdu, 1), 1, {}};
    switch (a.code) {
    case 3:
    case 4:
        a.count = word(pdu, 3);
        if (pdu.size() != 5 || a.count == 0 || a.count > 125) return std::nullopt;
        break;
    case 6:
        if (pdu.size() != 5) return std::nullopt;
        a.values = {word(pdu, 3)};
        break;
    case 16:
        a.count = word(pdu, 3);
        if (a.count == 0 || a.count > 123 || pdu.size() != 6 + 2 * a.count || pdu[5] != 2 * a.count)
            return std::nullopt;
        for (std::size_t i = 0; i < a.count; ++i) a.values.push_back(word(pdu, 6 + 2 * i));
        break;
    default: return std::nullopt;
    }
    if (a.first + a.count > 65536) return std::nullopt;
    return a;
}

/// Whether the PDU is exactly a response of one of these functions, or an exception.
inline bool is_response(const byte_list& pdu) {
    if (pdu.size() < 2) return false;
    if (pdu[0] >= 128) return pdu.size() == 2;
    if (pdu[0] == 3 || pdu[0] == 4)
        return pdu[1] >= 2 && pdu[1] <= 250 && pdu[1] % 2 == 0 && pdu.size() == 2u + pdu[1];
    if (pdu[0] == 6) return pdu.size() == 5;
    if (pdu[0] != 16 || pdu.size() != 5) return false;
    const unsigned count = word(pdu, 3);
    return count >= 1 && count <= 123 && word(pdu, 1) + count <= 65536;
}

/// The registers, at 0x0000..0x003F and 0xFFF0..0xFFFF.
class registers {
  public:
    registers() {
        for (unsigned i = 0; i < words_.size(); ++i) words_[i] = static_cast<std::uint16_t>(i * 259);
    }
    static bool has(unsigned address) { return address < 0x40 || (address >= 0xFFF0 && address <= 0xFFFF); }
    std::uint16_t& operator[](unsigned address) {
        return words_[address < 0x40 ? address : address - 0xFFF0 + 0x40];
    }
    friend bool operator==(const registers&, const registers&) = default;

  private:
    std::array<std::uint16_t, 0x50> words_{};
};

inline byte_list exception(unsigned code, unsigned number) {
    return {static_cast<std::uint8_t>(code | 0x80u), static_cast<std::uint8_t>(number)};
}

/// The response of a server with these registers to a PDU. It checks the function, then quantity and byte
/// count, then the address.
inline byte_list respond(registers& all, const byte_list& pdu, bool has_input_registers) {
    const unsigned code = pdu.empty() ? 0u : pdu[0];
    const bool is_known = code == 3 || code == 6 || code == 16 || (code == 4 && has_input_registers);
    if (!is_known) return exception(code, 1);
    const std::optional<asked> a = request(pdu);
    if (!a) {
        // The address is wrong (exception 2) only if the PDU would be a valid request with address 0.
        byte_list moved = pdu;
        if (moved.size() >= 3) moved[1] = moved[2] = 0;
        return exception(code, request(moved) ? 2 : 3);
    }
    for (unsigned i = 0; i < a->count; ++i) {
        if (!registers::has(a->first + i)) return exception(code, 2);
    }
    for (unsigned i = 0; i < a->values.size(); ++i)
        all[a->first + i] = static_cast<std::uint16_t>(a->values[i]);
    if (!a->values.empty()) return {pdu.begin(), pdu.begin() + 5};
    byte_list response{pdu[0], static_cast<std::uint8_t>(2 * a->count)};
    for (unsigned i = 0; i < a->count; ++i) {
        response.push_back(static_cast<std::uint8_t>(all[a->first + i] >> 8));
        response.push_back(static_cast<std::uint8_t>(all[a->first + i] & 0xFFu));
    }
    return response;
}

/// A receiver that cannot measure t3.5. It keeps every possible division of the bytes into frames, each
/// with the bytes of its last frame. It executes a frame to its address only if no other division is left:
/// immediately, or after a gap has shown that the frames of the other divisions are incomplete.
class listener {
  public:
    explicit listener(unsigned node_address) : unit_{node_address} {}

    /// Receives a byte. Returns the frame that must be executed now, if any.
    std::optional<byte_list> receive(std::uint8_t byte) {
        std::vector<account> next;
        for (account a : accounts_) {
            // A complete request to this address that was not executed because other divisions were possible.
            if (is_own(a.under_way) && a.under_way.size() == as_request(a.under_way)) a.under_way.clear();
            a.under_way.push_back(byte);
            const byte_list& f = a.under_way;
            if (f.size() > 256) continue;
            const std::size_t q = as_request(f);
            const std::size_t r = is_own(f) ? 0 : as_response(f);
            const bool can_go_on = (q == 0 && r == 0) || f.size() < q || f.size() < r;
            const bool is_end = (f.size() == q || f.size() == r) && is_frame(f);
            if (is_own(f) ? is_end || can_go_on : is_end ? can_go_on && is_credible(a) : can_go_on)
                tell(next, a);
            if (is_end && !is_own(f)) tell(next, {{}, outstanding_after(f)});
        }
        accounts_ =
            next.size() > 4 ? std::vector<account>{} : next; // too many divisions: wait for the next gap
        if (accounts_.size() != 1) return std::nullopt;
        const byte_list f = accounts_[0].under_way;
        if (!is_own(f) || f.size() != as_request(f)) return std::nullopt;
        return executed(f, accounts_[0].outstanding);
    }

    /// The line has a visible gap. Returns the frame that must be executed now, if the gap is noticed in
    /// time; otherwise the frame is lost.
    std::optional<byte_list> silence(bool is_noticed) {
        std::vector<account> complete;
        for (const account& a : accounts_) {
            const byte_list& f = a.under_way;
            const bool has_no_length = as_request(f) == 0;
            const bool is_request = is_own(f) && f.size() == as_request(f);
            if (f.empty() || (is_frame(f) && (has_no_length || is_request))) complete.push_back(a);
        }
        accounts_ = {{{}, anything}};
        if (complete.size() != 1) return std::nullopt;
        const account& a = complete[0];
        if (a.under_way.empty()) accounts_[0].outstanding = a.outstanding;
        if (!is_own(a.under_way) || !is_noticed) return std::nullopt;
        if (a.under_way[0] == 0 && as_request(a.under_way) == 0) return std::nullopt;
        return executed(a.under_way, a.outstanding);
    }

  private:
    // The outstanding response to a read: its address and byte count, or one of these.
    static constexpr unsigned nothing = 0;
    static constexpr unsigned anything = ~0u;
    struct account {
        byte_list under_way;
        unsigned outstanding;
    };

    bool is_own(const byte_list& f) const { return !f.empty() && (f[0] == unit_ || f[0] == 0); }

    // The length of a frame as a request or as a response, 0 if it is not yet determined.
    static std::size_t as_request(const byte_list& f) {
        if (f.size() < 2) return 0;
        if (f[1] == 3 || f[1] == 4 || f[1] == 6) return 8;
        return f[1] == 16 && f.size() > 6 ? 9u + f[6] : 0u;
    }
    static std::size_t as_response(const byte_list& f) {
        if (f.size() < 3) return 0;
        if (f[1] == 3 || f[1] == 4) return 5u + f[2];
        if (f[1] == 6 || f[1] == 16) return 8;
        return f[1] >= 128 ? 5 : 0;
    }

    // Whether the frame, which may end here, may also continue.
    static bool is_credible(const account& a) {
        const byte_list& f = a.under_way;
        if (f.size() < 8) return true; // as a read request
        if (f[1] == 16) return f[6] == 2 * word(f, 4);
        if (a.outstanding == anything) return f[2] % 2 == 0 && f[2] <= 250;
        return a.outstanding == word({f[0], f[2]}, 0);
    }
    static unsigned outstanding_after(const byte_list& f) {
        if ((f[1] != 3 && f[1] != 4) || f.size() != 8) return nothing;
        const unsigned count = word(f, 4);
        return count <= 125 ? f[0] * 256u + 2 * count : nothing;
    }

    // Merges two divisions whose last frame is the same. If their outstanding responses differ, any
    // response may come.
    static void tell(std::vector<account>& all, const account& a) {
        for (account& other : all) {
            if (other.under_way.size() != a.under_way.size()) continue;
            if (other.outstanding != a.outstanding) other.outstanding = anything;
            return;
        }
        all.push_back(a);
    }

    // A request to this address shows that no earlier response is still to come.
    std::optional<byte_list> executed(const byte_list& f, unsigned outstanding) {
        accounts_ = {{{}, outstanding == anything ? nothing : outstanding}};
        return f;
    }

    std::vector<account> accounts_{{{}, anything}};
    unsigned unit_;
};

} // namespace reference
