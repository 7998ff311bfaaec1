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
#include <utility>
#include <vector>

#include "arena.hpp"

namespace reference {

template <class T> using list = std::vector<T, fuzz::allocator<T>>;
using byte_list = list<std::uint8_t>;

/// A table of CRC-16/MODBUS by byte, computed bit by bit.
inline constexpr std::array<std::uint16_t, 256> crc_of_byte = [] {
    std::array<std::uint16_t, 256> all{};
    for (unsigned byte = 0; byte < 256; ++byte) {
        unsigned crc = byte;
        for (int bit = 0; bit < 8; ++bit) crc = (crc & 1u) != 0 ? (crc >> 1) ^ 0xA001u : crc >> 1;
        all[byte] = static_cast<std::uint16_t>(crc);
    }
    return all;
}();
inline constexpr unsigned crc_of_nothing = 0xFFFF;
inline unsigned crc_with(unsigned crc, std::uint8_t byte) {
    return crc >> 8 ^ crc_of_byte[(crc ^ byte) & 0xFFu];
}
inline unsigned crc(const std::uint8_t* data, std::size_t size) {
    unsigned crc = crc_of_nothing;
    while (size-- != 0) crc = crc_with(crc, *data++);
    return crc;
}

template <class List = byte_list> List framed(List body) {
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

template <class List> unsigned word(const List& b, std::size_t at) { return b[at] * 256u + b[at + 1]; }

/// A request for registers, as the standard defines it.
struct asked {
    unsigned code, first, count;
    list<unsigned> values; ///< of a write
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

/// A frame of which one byte after the other arrives.
class growing_frame {
  public:
    void add(std::uint8_t byte) {
        if (all_.empty()) all_.reserve(48);
        all_.push_back(byte);
        crc_ = crc_with(crc_, byte);
    }
    void clear() { *this = {}; }
    const byte_list& bytes() const { return all_; }
    bool empty() const { return all_.empty(); }
    std::size_t size() const { return all_.size(); }
    std::uint8_t operator[](std::size_t at) const { return all_[at]; }
    /// As of the bytes: the CRC of a frame with its CRC is 0.
    friend bool is_frame(const growing_frame& f) { return f.size() >= 4 && f.size() <= 256 && f.crc_ == 0; }

  private:
    byte_list all_;
    unsigned crc_ = crc_of_nothing;
};

/// A receiver that cannot measure t3.5 between bytes that come together. It keeps every possible division of
/// the bytes into frames, each with the bytes of its last frame. It executes a frame to its address only if
/// no other division is left: immediately, or after a gap has shown that the frames of the other divisions
/// are incomplete. At the beginning of a burst some bytes 00 or FF may belong to no frame. A division that
/// leaves such a byte out is late: it does not delay the frame of the only division that is not.
class listener {
  public:
    /// `executes_standard`: it executes all functions that have a length, not only those of registers.
    listener(unsigned node_address, unsigned leading_bytes, bool executes_standard = false)
        : address_{node_address}, leading_{leading_bytes}, executes_standard_{executes_standard} {}

    /// Receives a byte. Returns the frame that must be executed now, if any.
    std::optional<byte_list> receive(std::uint8_t byte) {
        const bool may_be_left_out = is_noise(byte) && left_out_ < leading_;
        left_out_ = may_be_left_out ? left_out_ + 1 : leading_;
        const bool has_rivals = accounts_.size() > 1;
        list<account>& next = next_;
        next.clear();
        for (account& a : accounts_) {
            if (!has_rivals) a.is_late = false;
            // A complete request to this address that was not executed because other divisions were possible.
            if (is_own(a.under_way) && is_frame(a.under_way) && a.under_way.size() == as_request(a.under_way))
                a.under_way.clear();
            a.under_way.add(byte);
            if (a.under_way.size() > 256) continue;
            if (a.under_way.size() == 1) {
                const unsigned outstanding = a.outstanding;
                tell(next, std::move(a));
                if (may_be_left_out) tell(next, {{}, outstanding, true});
            } else if (!has_rivals || !is_nonsense(a.under_way)) {
                go_on(next, a, has_rivals);
            }
        }
        if (next.size() > 4) next.clear(); // too many divisions: wait for the next gap
        accounts_.swap(next);
        const account* only = nullptr;
        for (const account& a : accounts_) {
            if (a.is_late && accounts_.size() != 1) continue;
            if (only != nullptr) return std::nullopt;
            only = &a;
        }
        if (only == nullptr) return std::nullopt;
        const growing_frame& f = only->under_way;
        if (!is_own(f) || f.size() != as_request(f) || !is_frame(f)) return std::nullopt;
        return executed(f.bytes(), only->outstanding);
    }

    /// No byte came for t3.5, and this is no visible gap yet.
    void pause() {
        left_out_ = 0;
        bool is_after_frame = false;
        for (account& a : accounts_) {
            const growing_frame& f = a.under_way;
            if (is_frame(f) && f[0] != address_ && form_of(f[1]) == form::unknown)
                a = {{}, nothing, a.is_late};
            is_after_frame = is_after_frame || a.under_way.empty();
        }
        if (!is_after_frame) return;
        list<account> left;
        for (account& a : accounts_) {
            const growing_frame& f = a.under_way;
            if (f.size() < 2 || form_of(f[1]) != form::unknown || is_frame(f)) tell(left, std::move(a));
        }
        accounts_ = std::move(left);
    }

    /// The line has a visible gap. Returns the frame that must be executed now, if the gap is noticed in
    /// time; otherwise the frame is lost.
    std::optional<byte_list> silence(bool is_noticed) {
        left_out_ = 0;
        list<account> complete;
        for (account& a : accounts_) {
            const growing_frame& f = a.under_way;
            const bool has_any_length = f.size() > 1 && (is_own(f) ? !is_executed(f[1]) || as_request(f) == 0
                                                                   : form_of(f[1]) == form::unknown);
            const bool is_request = is_own(f) && f.size() == as_request(f);
            if (f.empty() || (is_frame(f) && (has_any_length || is_request)))
                complete.push_back(std::move(a));
        }
        accounts_.clear();
        accounts_.push_back({{}, anything, false});
        if (complete.size() != 1) return std::nullopt;
        const account& a = complete[0];
        if (a.under_way.empty()) accounts_[0].outstanding = a.outstanding;
        if (!is_own(a.under_way) || !is_noticed) return std::nullopt;
        if (a.under_way[0] == 0 && as_request(a.under_way) == 0) return std::nullopt;
        return executed(a.under_way.bytes(), a.outstanding);
    }

    /// Its own response has left.
    void responded() { left_out_ = leading_; }

  private:
    // The outstanding response to a read: its address and byte count, or one of these.
    static constexpr unsigned nothing = 0;
    static constexpr unsigned anything = ~0u;
    struct account {
        growing_frame under_way;
        unsigned outstanding;
        bool is_late;
    };

    bool is_own(const growing_frame& f) const { return !f.empty() && (f[0] == address_ || f[0] == 0); }
    bool is_noise(std::uint8_t byte) const { return byte != address_ && (byte == 0 || byte == 255); }
    bool is_nonsense(const growing_frame& f) const {
        return f.size() == 2 && is_noise(f[0]) && (f[1] == 0 || f[1] > 127);
    }

    // Functions by what is known of their frames: those of registers, which are executed; others of the
    // standard; exceptions; the rest.
    enum class form : std::uint8_t { unknown, registers, standard, exception };
    static form form_of(unsigned code) {
        switch (code) {
        case 3:
        case 4:
        case 6:
        case 16: return form::registers;
        case 1:
        case 2:
        case 5:
        case 15:
        case 22:
        case 23: return form::standard;
        default: return code > 127 ? form::exception : form::unknown;
        }
    }

    bool is_executed(unsigned code) const {
        const form kind = form_of(code);
        return kind == form::registers || (executes_standard_ && kind == form::standard);
    }

    // The length of a frame as a request or as a response, 0 if it is not yet determined.
    static std::size_t as_request(const growing_frame& f) {
        if (f.size() < 2) return 0;
        switch (f[1]) {
        case 1:
        case 2:
        case 3:
        case 4:
        case 5:
        case 6: return 8;
        case 15:
        case 16: return f.size() > 6 ? 9u + f[6] : 0u;
        case 22: return 10;
        case 23: return f.size() > 10 ? 13u + f[10] : 0u;
        default: return 0;
        }
    }
    static std::size_t as_response(const growing_frame& f) {
        if (f.size() < 3) return 0;
        switch (f[1]) {
        case 1:
        case 2:
        case 3:
        case 4:
        case 23: return 5u + f[2];
        case 5:
        case 6:
        case 15:
        case 16: return 8;
        case 22: return 10;
        default: return f[1] > 127 ? 5 : 0;
        }
    }

    // A frame of at least two bytes has grown by one.
    void go_on(list<account>& next, account& a, bool has_rivals) const {
        const growing_frame& f = a.under_way;
        const std::size_t q = as_request(f);
        if (is_own(f)) {
            const bool is_wrong = f.size() == q && !is_frame(f);
            if (!is_wrong || (!has_rivals && !is_executed(f[1]))) tell(next, std::move(a));
            return;
        }
        const std::size_t r = as_response(f);
        const form kind = form_of(f[1]);
        const bool may_grow =
            kind == form::exception ? f.size() < 5 : f.size() < 3 || q == 0 || f.size() < q || f.size() < r;
        if (!is_frame(f) || (f.size() != q && f.size() != r)) {
            if (may_grow) tell(next, std::move(a));
            return;
        }
        const unsigned outstanding = f.size() == q ? outstanding_after(f) : nothing;
        const bool is_late = a.is_late;
        if (may_grow && (f.size() == q ? is_credible_response(a) : is_credible_request(f)))
            tell(next, std::move(a));
        tell(next, {{}, outstanding, is_late});
    }

    // Whether a request that may end here may also continue as a response.
    static bool is_credible_response(const account& a) {
        const growing_frame& f = a.under_way;
        if (a.outstanding != anything) return a.outstanding == f[0] * 256u + f[2];
        return f[2] <= 250 && (f[1] < 3 || f[2] % 2 == 0);
    }
    // Whether a response that may end here may also continue as a request.
    static bool is_credible_request(const growing_frame& f) {
        switch (f[1]) {
        case 15: return f[6] == (word(f, 4) + 7) / 8;
        case 16: return f[6] == 2 * word(f, 4);
        case 23:
            if (f.size() > 5 && (word(f, 4) < 1 || word(f, 4) > 125)) return false;
            return f.size() < 11 || f[10] == 2 * word(f, 8);
        default: return true;
        }
    }
    static unsigned outstanding_after(const growing_frame& f) {
        if (f[1] > 4 && f[1] != 23) return nothing;
        const unsigned count = f[1] < 3 ? (word(f, 4) + 7) / 8 : 2 * word(f, 4);
        return count <= 250 ? f[0] * 256u + count : nothing;
    }

    // Merges two divisions whose last frame is the same. If their outstanding responses differ, any
    // response may come.
    static void tell(list<account>& all, account&& a) {
        for (account& other : all) {
            if (other.under_way.size() != a.under_way.size()) continue;
            if (other.outstanding != a.outstanding) other.outstanding = anything;
            other.is_late = other.is_late && a.is_late;
            return;
        }
        all.push_back(std::move(a));
    }

    // A request to this address shows that no earlier response is still to come.
    std::optional<byte_list> executed(byte_list f, unsigned outstanding) {
        accounts_.clear();
        accounts_.push_back({{}, outstanding == anything ? nothing : outstanding, false});
        return f;
    }

    list<account> accounts_{{{}, anything, false}};
    list<account> next_; // keeps its memory
    unsigned address_;
    unsigned leading_;
    bool executes_standard_;
    unsigned left_out_ = 0; ///< since the last gap; all of them inside a burst
};

} // namespace reference
