// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A device with four tables, as a model of the standard that shares nothing with the library: what it has is in maps,
// and a request that it cannot execute gets its exception.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include <tests/support/scripted_port.hpp>

namespace tests {

struct plain_tables {
    std::map<unsigned, bool> coils{};
    std::map<unsigned, bool> discrete_inputs{};
    std::map<unsigned, unsigned> holding_registers{};
    std::map<unsigned, unsigned> input_registers{};
    std::vector<byte_list> requests{}; ///< PDUs
    bool takes_blocks_only = false;    ///< refuses functions 05 and 06
    unsigned toggle = 0;               ///< the word of function 05 that changes a coil to its other state

    /// The response PDU.
    byte_list answer(const byte_list& pdu) {
        requests.push_back(pdu);
        const unsigned code = pdu.at(0);
        const auto word = [&](std::size_t at) { return pdu.at(at) * 256u + pdu.at(at + 1); };
        const auto refused = [&](unsigned why) { return byte_list{low_byte(code + 128), low_byte(why)}; };
        switch (code) {
        case 1: return bits(code, coils, word(1), word(3));
        case 2: return bits(code, discrete_inputs, word(1), word(3));
        case 3: return words(code, holding_registers, word(1), word(3));
        case 4: return words(code, input_registers, word(1), word(3));
        case 5:
            if (takes_blocks_only) return refused(1);
            if (toggle != 0 && word(3) == toggle && has(coils, word(1), 1)) {
                coils[word(1)] = !coils[word(1)];
                return pdu;
            }
            if (word(3) != 0xFF00 && word(3) != 0) return refused(3);
            if (!has(coils, word(1), 1)) return refused(2);
            coils[word(1)] = word(3) != 0;
            return pdu;
        case 6:
            if (takes_blocks_only) return refused(1);
            if (!has(holding_registers, word(1), 1)) return refused(2);
            holding_registers[word(1)] = word(3);
            return pdu;
        case 15:
            if (pdu.at(5) != (word(3) + 7) / 8 || pdu.size() != 6u + pdu.at(5)) return refused(3);
            if (!has(coils, word(1), word(3))) return refused(2);
            for (unsigned i = 0; i < word(3); ++i)
                coils[word(1) + i] = pdu.at(6 + i / 8) / (1u << i % 8) % 2 != 0;
            return {pdu.begin(), pdu.begin() + 5};
        case 16:
            if (pdu.at(5) != 2 * word(3) || pdu.size() != 6u + pdu.at(5)) return refused(3);
            if (!has(holding_registers, word(1), word(3))) return refused(2);
            for (unsigned i = 0; i < word(3); ++i)
                holding_registers[word(1) + i] = word(6 + std::size_t{2} * i);
            return {pdu.begin(), pdu.begin() + 5};
        case 22:
            if (!has(holding_registers, word(1), 1)) return refused(2);
            holding_registers[word(1)] =
                (holding_registers[word(1)] & word(3)) | (word(5) & (0xFFFFu - word(3)));
            return pdu;
        case 23:
            if (pdu.at(9) != 2 * word(7) || pdu.size() != 10u + pdu.at(9)) return refused(3);
            if (!has(holding_registers, word(1), word(3)) || !has(holding_registers, word(5), word(7)))
                return refused(2);
            for (unsigned i = 0; i < word(7); ++i)
                holding_registers[word(5) + i] = word(10 + std::size_t{2} * i);
            return words(code, holding_registers, word(1), word(3));
        }
        return refused(1);
    }

    /// The device at `node_address` on a scripted port.
    void operator()(scripted_port& port, const sent_frame& f, std::uint8_t node_address) {
        const byte_list& frame = f.data;
        if (frame.size() < 4 || framed({frame.begin(), frame.end() - 2}) != frame) return;
        if (frame[0] != node_address && frame[0] != 0) return;
        const byte_list response = answer({frame.begin() + 1, frame.end() - 2});
        if (frame[0] == node_address) port.say(500, framed(byte_list{node_address} + response));
    }

  private:
    template <class Table> static bool has(const Table& table, unsigned address, unsigned count) {
        for (unsigned i = 0; i < count; ++i) {
            if (table.count(address + i) == 0) return false;
        }
        return count != 0;
    }
    static byte_list bits(unsigned code, const std::map<unsigned, bool>& table, unsigned address,
                          unsigned count) {
        if (!has(table, address, count)) return {low_byte(code + 128), 2};
        byte_list response(2 + (count + 7) / 8);
        response[0] = low_byte(code);
        response[1] = low_byte((count + 7) / 8);
        for (unsigned i = 0; i < count; ++i) {
            if (table.at(address + i)) response[2 + i / 8] = low_byte(response[2 + i / 8] + (1u << i % 8));
        }
        return response;
    }
    static byte_list words(unsigned code, const std::map<unsigned, unsigned>& table, unsigned address,
                           unsigned count) {
        if (!has(table, address, count)) return {low_byte(code + 128), 2};
        byte_list response{low_byte(code), low_byte(2 * count)};
        for (unsigned i = 0; i < count; ++i) {
            response.push_back(high_byte(table.at(address + i)));
            response.push_back(low_byte(table.at(address + i)));
        }
        return response;
    }
};

} // namespace tests
