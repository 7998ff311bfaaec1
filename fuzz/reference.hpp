// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Modbus once more, in another style and without a line of the library: what its parsers and its server are
// judged by. It is written from the standard's flow charts (Modbus Application Protocol V1.1b3, section 6).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace reference {

using byte_list = std::vector<std::uint8_t>;

/// CRC-16/MODBUS, a bit at a time.
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

/// What the registers hold that exist here: 0x0000..0x003F and 0xFFF0..0xFFFF.
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

/// What a server with these registers answers to a PDU: function, then quantity and byte count, then address.
inline byte_list respond(registers& all, const byte_list& pdu, bool has_input_registers) {
    const unsigned code = pdu.empty() ? 0u : pdu[0];
    const bool is_known = code == 3 || code == 6 || code == 16 || (code == 4 && has_input_registers);
    if (!is_known) return exception(code, 1);
    const std::optional<asked> a = request(pdu);
    if (!a) {
        // Only a range beyond the last address is a matter of the address: 0 for it would be a request.
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
    byte_list reply{pdu[0], static_cast<std::uint8_t>(2 * a->count)};
    for (unsigned i = 0; i < a->count; ++i) {
        reply.push_back(static_cast<std::uint8_t>(all[a->first + i] >> 8));
        reply.push_back(static_cast<std::uint8_t>(all[a->first + i] & 0xFFu));
    }
    return reply;
}

} // namespace reference
