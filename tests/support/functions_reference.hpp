// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A second judge of requests, responses and their lengths, written from the standard and apart from the library. A
// request is a form in letters; a response is compared with what the request implies (Modbus Application Protocol
// V1.1b3, section 6).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace functions_reference {

using byte_list = std::vector<std::uint8_t>;

/// The fields of a request after its code, each a letter. Words: a, w addresses; q, r their quantities; v, x any; c a
/// coil's value; s a sub-function. Bytes: m the MEI type; k a kind; o any; n a count, and as many bytes. *: words to
/// the end, one at least.
inline const std::map<unsigned, std::string>& forms() {
    static const std::map<unsigned, std::string> all{
        {1, "aq"}, {2, "aq"},   {3, "aq"},     {4, "aq"}, {5, "ac"},   {6, "av"},
        {7, ""},   {8, "s*"},   {11, ""},      {12, ""},  {15, "aqn"}, {16, "aqn"},
        {17, ""},  {22, "avx"}, {23, "aqwrn"}, {24, "v"}, {43, "mko"},
    };
    return all;
}

using fields = std::map<char, unsigned>;

inline unsigned word(const byte_list& b, std::size_t at) { return b.at(at) * 256u + b.at(at + 1); }

/// The fields, or nothing if the bytes end too early or too late.
inline std::optional<fields> read(const std::string& form, const byte_list& pdu) {
    fields found;
    std::size_t at = 1;
    for (const char field : form) {
        const std::size_t left = pdu.size() - at;
        if (field == '*') {
            if (left < 2 || left % 2 != 0) return std::nullopt;
            found['*'] = static_cast<unsigned>(left / 2);
            at = pdu.size();
        } else if (std::string{"mkon"}.find(field) != std::string::npos) {
            if (left < 1) return std::nullopt;
            found[field] = pdu[at++];
            if (field == 'n') {
                if (pdu.size() - at != found['n']) return std::nullopt;
                at = pdu.size();
            }
        } else {
            if (left < 2) return std::nullopt;
            found[field] = word(pdu, at);
            at += 2;
        }
    }
    if (at != pdu.size()) return std::nullopt;
    return found;
}

inline bool is_one_of(unsigned value, std::initializer_list<unsigned> all) {
    return std::find(all.begin(), all.end(), value) != all.end();
}

/// Returns the exception of a server that has every row, or 0 if it accepts the request.
inline unsigned exception_of(const byte_list& pdu) {
    if (pdu.empty()) return 3;
    const unsigned code = pdu[0];
    const auto form = forms().find(code);
    if (form == forms().end()) return 1;
    if (code == 43 && pdu.size() > 1 && pdu[1] != 14) return 1;
    if (code == 8 && pdu.size() > 4) {
        const unsigned sub = word(pdu, 1);
        if (sub > 20 || (sub > 4 && sub < 10) || sub == 19) return 1;
    }
    if (pdu.size() > 253) return 3;
    const std::optional<fields> read_fields = read(form->second, pdu);
    if (!read_fields) return 3;
    fields f = *read_fields;
    if (code == 8 && f['s'] != 0) {
        if (f['*'] != 1) return 3;
        const unsigned data = word(pdu, 3);
        if (f['s'] == 1 ? data != 0 && data != 0xFF00 : f['s'] == 3 ? data % 256 != 0 : data != 0) return 3;
    }
    if (code == 5 && !is_one_of(f['c'], {0, 0xFF00})) return 3;
    if (code == 43 && !is_one_of(f['k'], {1, 2, 3, 4})) return 3;
    static const std::map<unsigned, unsigned> most{{1, 2000},  {2, 2000}, {3, 125}, {4, 125},
                                                   {15, 1968}, {16, 123}, {23, 125}};
    const auto limit = most.find(code);
    if (limit != most.end() && (f['q'] < 1 || f['q'] > limit->second)) return 3;
    if (code == 23 && (f['r'] < 1 || f['r'] > 121)) return 3;
    if (code == 15 && f['n'] * 8 - f['q'] > 7) return 3; // no bit is missing, and no byte has only padding
    if (code == 16 && f['n'] != f['q'] * 2) return 3;
    if (code == 23 && f['n'] != f['r'] * 2) return 3;
    return std::max(f['a'] + f['q'], f['w'] + f['r']) > 65536 ? 2 : 0;
}

enum class verdict : std::uint8_t { valid, exception, other_function, other_length, other_content };

inline bool begins_with(const byte_list& all, const byte_list& begin) {
    return all.size() >= begin.size() && std::equal(begin.begin(), begin.end(), all.begin());
}
inline byte_list first(const byte_list& from, std::size_t count) {
    return {from.begin(), from.begin() + static_cast<std::ptrdiff_t>(count)};
}

/// True if the bytes after the count of a list are its objects.
inline bool are_objects(const byte_list& pdu, std::vector<unsigned>& ids) {
    std::size_t at = 7;
    while (at < pdu.size()) {
        if (at + 1 == pdu.size()) return false;
        ids.push_back(pdu[at]);
        at += 2u + pdu[at + 1];
    }
    return at == pdu.size();
}

inline verdict identification(const byte_list& asked, const byte_list& pdu) {
    if (pdu.size() < 7 || pdu.size() > 253) return verdict::other_length;
    if (pdu[1] != 14) return verdict::other_function;
    std::vector<unsigned> ids;
    if (!are_objects(pdu, ids) || ids.size() != pdu[6] || ids.empty()) return verdict::other_content;
    if (std::adjacent_find(ids.begin(), ids.end(), [](unsigned a, unsigned b) { return a >= b; }) !=
        ids.end())
        return verdict::other_content;
    const bool is_last = pdu[4] == 0 && pdu[5] == 0;
    const bool goes_on = pdu[4] == 255 && pdu[5] > ids.back() && asked[2] != 4;
    const bool is_asked_one = asked[2] != 4 || ids == std::vector<unsigned>{asked[3]};
    const bool has_level = is_one_of(pdu[3], {1, 2, 3, 0x81, 0x82, 0x83});
    return pdu[2] == asked[2] && has_level && (is_last || goes_on) && is_asked_one ? verdict::valid
                                                                                   : verdict::other_content;
}

/// A response to a valid request. Identification has its length judged as content.
inline verdict judge(const byte_list& asked, const byte_list& pdu) {
    if (pdu.size() < 2) return verdict::other_length;
    if (pdu[0] == asked[0] + 128) return pdu.size() == 2 ? verdict::exception : verdict::other_length;
    if (pdu[0] != asked[0]) return verdict::other_function;
    const unsigned code = pdu[0];
    const auto content = [](bool is) { return is ? verdict::valid : verdict::other_content; };
    const bool counts_itself = pdu.size() == 2u + pdu[1];
    if (is_one_of(code, {1, 2})) {
        const unsigned quantity = word(asked, 3);
        if (!counts_itself || pdu[1] != (quantity + 7) / 8) return verdict::other_length;
        unsigned padding = 0;
        for (unsigned bit = quantity; bit < pdu[1] * 8u; ++bit) padding += pdu[2 + bit / 8] & 1u << bit % 8;
        return content(padding == 0);
    }
    if (is_one_of(code, {3, 4, 23}))
        return counts_itself && pdu[1] == 2 * word(asked, 3) ? verdict::valid : verdict::other_length;
    if (is_one_of(code, {5, 6, 15, 16}))
        return pdu.size() == 5 ? content(begins_with(asked, pdu)) : verdict::other_length;
    if (code == 7) return pdu.size() == 2 ? verdict::valid : verdict::other_length;
    if (code == 8) {
        if (pdu.size() != asked.size()) return verdict::other_length;
        if (!begins_with(pdu, first(asked, 3))) return verdict::other_function;
        const unsigned sub = word(asked, 1);
        const bool is_counter = sub == 2 || (sub > 10 && sub < 19);
        return content(sub != 4 && (is_counter || pdu == asked));
    }
    const auto is_state = [&](std::size_t at) { return is_one_of(word(pdu, at), {0, 65535}); };
    if (code == 11) return pdu.size() == 5 ? content(is_state(1)) : verdict::other_length;
    if (code == 12)
        return counts_itself && pdu[1] >= 6 && pdu[1] <= 70 ? content(is_state(2)) : verdict::other_length;
    if (code == 17)
        return counts_itself && pdu[1] > 0 && pdu[1] < 252 ? verdict::valid : verdict::other_length;
    if (code == 22) return pdu.size() == 7 ? content(pdu == asked) : verdict::other_length;
    if (code == 24) {
        if (pdu.size() < 5 || word(pdu, 1) + 3 != pdu.size()) return verdict::other_length;
        return content(word(pdu, 3) < 32 && pdu.size() == 5 + 2 * word(pdu, 3));
    }
    return identification(asked, pdu);
}

/// How many bytes a response to `asked` has at least, from those that have come.
inline std::size_t least(const byte_list& asked, const byte_list& begun) {
    if (begun.size() < 2 || asked.empty() || begun[0] != asked[0]) return 2;
    const auto capped = [](std::size_t length, std::size_t known) { return length > 253 ? known : length; };
    const unsigned code = begun[0];
    if (is_one_of(code, {1, 2, 3, 4, 12, 17, 23})) return capped(2u + begun[1], 2);
    if (is_one_of(code, {5, 6, 11, 15, 16})) return 5;
    if (code == 22) return 7;
    if (code == 8) {
        const bool is_return_query_data =
            asked.size() >= 5 && asked.size() <= 253 && asked[1] == 0 && asked[2] == 0;
        return is_return_query_data ? asked.size() : 5;
    }
    if (code == 24) return begun.size() < 3 ? 3 : capped(3 + word(begun, 1), 3);
    if (code != 43) return 2;
    if (begun.size() < 7) return 7;
    std::size_t known = 7;
    std::size_t value_end = 7;
    for (unsigned left = begun[6]; left != 0; --left) {
        if (value_end + 2 > 253) return known;
        known = value_end + 2;
        if (begun.size() < known) return known;
        value_end = known + begun[known - 1];
    }
    return capped(value_end, known);
}

} // namespace functions_reference
