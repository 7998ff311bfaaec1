// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Random requests and responses of all functions of the standard, as PDUs: valid ones, and what becomes of them when a
// byte changes, or some are added or lost.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <random>
#include <vector>

#include <tests/support/functions_reference.hpp>

namespace tests::random_functions {

using functions_reference::byte_list;

inline byte_list operator+(const byte_list& a, const byte_list& b) {
    byte_list both(a.size() + b.size());
    std::copy(b.begin(), b.end(), std::copy(a.begin(), a.end(), both.begin()));
    return both;
}

class maker {
  public:
    explicit maker(unsigned seed) : engine_{seed} {}

    unsigned below(unsigned end) { return static_cast<unsigned>(engine_() % end); }
    bool one_in(unsigned count) { return below(count) == 0; }

    /// A request that is valid but for one in eight, whose quantity or address is wrong.
    byte_list request() {
        static constexpr unsigned codes[]{1, 2, 3, 4, 5, 6, 7, 8, 8, 11, 12, 15, 16, 17, 22, 23, 24, 43, 43};
        const unsigned code = codes[below(std::size(codes))];
        byte_list pdu{low(code)};
        const unsigned most = code < 3 ? 2000 : code < 5 || code == 23 ? 125 : code == 15 ? 1968 : 123;
        const unsigned quantity = one_in(8)    ? most + below(2)
                                  : one_in(40) ? 0
                                               : 1 + below(one_in(2) ? 20 : most);
        const unsigned address = one_in(8) ? 65536 - quantity + below(2) : below(65536);
        if (code < 5 || code == 15 || code == 16 || code == 23) pdu = pdu + word(address) + word(quantity);
        if (code == 15) pdu = pdu + list((quantity + 7) / 8);
        if (code == 16) pdu = pdu + list(2 * quantity);
        if (code == 23) {
            const unsigned written = one_in(8) ? 121 + below(2) : below(20);
            pdu = pdu + word(one_in(8) ? 65536 - written + below(2) : below(65536)) + word(written);
            pdu = pdu + list(2 * written);
        }
        if (code == 5) pdu = pdu + word(below(65536)) + word(one_in(2) ? 0xFF00 : 0);
        if (code == 6) pdu = pdu + word(below(65536)) + word(below(65536));
        if (code == 8) {
            const unsigned sub = one_in(3) ? 0 : below(23);
            pdu = pdu + word(sub) + word(sub == 0 ? below(65536) : sub == 1 && one_in(2) ? 0xFF00 : 0);
            if (sub == 0) pdu = pdu + some(2 * below(one_in(4) ? 125 : 3));
        }
        if (code == 22) pdu = pdu + some(6);
        if (code == 24) pdu = pdu + some(2);
        if (code == 43) pdu = pdu + byte_list{14, low(1 + below(4)), low(below(256))};
        return pdu;
    }

    /// A valid response to a valid request.
    byte_list response(const byte_list& asked) {
        const unsigned code = asked[0];
        if (one_in(12)) return {low(code + 128), low(below(256))};
        byte_list pdu{low(code)};
        if (code < 3) {
            const unsigned quantity = functions_reference::word(asked, 3);
            byte_list packed = list((quantity + 7) / 8);
            if (quantity % 8 != 0) packed.back() = low(packed.back() % (1u << quantity % 8));
            return pdu + packed;
        }
        if (code < 5 || code == 23) return pdu + list(2 * functions_reference::word(asked, 3));
        if (code == 7) return pdu + some(1);
        if (code == 8) {
            const unsigned sub = functions_reference::word(asked, 1);
            const bool is_counter = sub == 2 || (sub > 10 && sub < 19);
            return is_counter ? pdu + word(sub) + some(2) : asked;
        }
        if (code == 11) return pdu + word(one_in(2) ? 0xFFFF : 0) + some(2);
        if (code == 12) {
            byte_list log = list(6 + below(65));
            log[1] = log[2] = one_in(2) ? 255 : 0;
            return pdu + log;
        }
        if (code == 17) return pdu + list(1 + below(one_in(3) ? 251 : 20));
        if (code == 24) {
            const unsigned words = below(32);
            return pdu + word(2 + 2 * words) + word(words) + some(2 * words);
        }
        if (code == 43) return identification(asked);
        return {asked.begin(), asked.begin() + (code == 22 ? 7 : 5)}; // 05, 06, 0F, 10, 16h
    }

    /// The same with a byte changed, some bytes more, or some less.
    byte_list mutated(byte_list pdu) {
        switch (below(pdu.empty() ? 1 : 4)) {
        case 0: return pdu + some(1 + below(one_in(8) ? 300 : 3));
        case 1: pdu.resize(below(static_cast<unsigned>(pdu.size()))); return pdu;
        case 2: { // by one bit, near the head mostly
            std::uint8_t& byte = pdu[below(
                static_cast<unsigned>(one_in(2) ? std::min<std::size_t>(pdu.size(), 10) : pdu.size()))];
            byte = low(byte ^ 1u << below(8));
            return pdu;
        }
        default: pdu[below(static_cast<unsigned>(pdu.size()))] = low(below(256)); return pdu;
        }
    }

    byte_list some(std::size_t count) {
        byte_list all(count);
        for (std::uint8_t& byte : all) byte = low(below(256));
        return all;
    }

  private:
    static std::uint8_t low(unsigned value) { return static_cast<std::uint8_t>(value & 0xFFu); }
    static byte_list word(unsigned value) { return {low(value >> 8), low(value)}; }
    byte_list list(unsigned count) {
        const byte_list data = some(count);
        return byte_list{low(count)} + data;
    }

    byte_list identification(const byte_list& asked) {
        byte_list objects;
        unsigned count = 0;
        unsigned id = asked[2] == 4 ? asked[3] : below(6);
        const unsigned wanted = asked[2] == 4 ? 1 : 1 + below(one_in(8) ? 60 : 8);
        unsigned last = id;
        for (; count < wanted && id < 255; id += 1 + below(5)) {
            const unsigned size = below(one_in(20) ? 200 : 6);
            if (7 + objects.size() + 2 + size > 253 && count != 0) break;
            last = id;
            objects = objects + byte_list{low(id)} + list(size);
            ++count;
        }
        if (count == 0) objects = byte_list{low(last), 0}, count = 1;
        const bool goes_on = asked[2] != 4 && last < 255 && one_in(2);
        const unsigned next = goes_on ? last + 1 + below(255 - last) : 0;
        const byte_list head{
            43,        14,        asked[2], low(1 + below(3) + (one_in(2) ? 128 : 0)), low(goes_on ? 255 : 0),
            low(next), low(count)};
        return head + objects;
    }

    std::mt19937 engine_;
};

} // namespace tests::random_functions
