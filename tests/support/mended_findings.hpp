// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The commands that `servobus doctor` names: each writes registers that exist and values that they take, and the drive
// has the finding no more once they are written.
#pragma once

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <doctest/doctest.h>

#include <tests/support/driven_doctored.hpp>

namespace doctored {

using tool::diagnosis::new_value;

/// `REG=VALUE` of a table, where VALUE is a code's name or a number in the register's unit.
inline new_value parse_write(std::string_view text, const servobus::catalogue& map) {
    const std::string write{text};
    CAPTURE(write);
    const std::size_t equals = text.find('=');
    REQUIRE(equals != text.npos);
    const servobus::entry* row = nullptr;
    for (const servobus::entry& e : map.entries) {
        if (text.substr(0, equals) == std::string_view{e.name}) row = &e;
    }
    REQUIRE(row != nullptr);
    const std::string value{text.substr(equals + 1)};
    for (const servobus::named_value& v : row->values) {
        std::string name{v.name};
        for (char& c : name) c = c == ' ' ? '_' : c;
        if (name == value) return {row->address, v.value};
    }
    CHECK(value.find("0x") == value.npos); // a name, where there is one
    const double counts = std::stod(value) * row->unit_of_count.denominator / row->unit_of_count.numerator;
    return {row->address, static_cast<servobus::u32>(static_cast<std::int64_t>(counts))};
}

/// The writes of the command that a finding names, in its order.
inline std::vector<new_value> writes_of(const check& c, const held_registers& held,
                                        const servobus::catalogue& map) {
    if (c.by.compose != nullptr) return c.by.compose(held, c);
    std::vector<new_value> all;
    std::string_view rest{c.by.write};
    while (!rest.empty()) {
        const std::size_t blank = rest.find(' ');
        all.push_back(parse_write(rest.substr(0, blank), map));
        rest = blank == rest.npos ? std::string_view{} : rest.substr(blank + 1);
    }
    return all;
}

/// Writes as the tool does. Returns false if the drive refuses it.
template <class Bench> bool write(Bench& b, const new_value& wanted, const servobus::catalogue& map) {
    const servobus::entry* const row = map.find(wanted.address);
    REQUIRE(row != nullptr);
    CAPTURE(std::string{row->name});
    CAPTURE(wanted.bits);
    CHECK(row->address == wanted.address);
    CHECK(row->rights != servobus::access::ro);
    CHECK(row->limits.contains(row->number(wanted.bits)));
    const auto low = static_cast<u16>(wanted.bits & 0xFFFFu);
    if (row->words() == 1) return b.model.put(wanted.address, {low});
    const auto high = static_cast<u16>(wanted.bits >> 16);
    const u16 order = map.device->word_order_register;
    const bool is_low_first = order != 0 && b.model.peek(order) == 1;
    return is_low_first ? b.model.put(wanted.address, {low, high}) : b.model.put(wanted.address, {high, low});
}

/// Carries out the command of each finding that a state adds, and of each finding of the first state: the finding is
/// gone then, unless a condition is in front of its command. Adds to `mended` why those that are gone had mattered.
template <class Bench, std::size_t Count, class Make>
void expect_mended(const state<Bench> (&states)[Count], const check_list& list,
                   const servobus::catalogue& map, Make make, std::set<std::string>& mended) {
    const auto is_found = [&](Bench& b, const check* c) {
        const auto found = tool::diagnosis::find(list, read_of(b.model, list, map));
        return std::find(found.begin(), found.end(), c) != found.end();
    };
    for (const auto& s : states) {
        CAPTURE(std::string{s.name});
        const std::unique_ptr<Bench> before = make();
        if (s.exists != nullptr && !s.exists(*before)) continue;
        const std::unique_ptr<Bench> entered = make();
        REQUIRE(s.enter(*entered));
        for (const check* c : tool::diagnosis::find(list, read_of(entered->model, list, map))) {
            if (&s != states && is_found(*before, c)) continue;
            CAPTURE(first_of(*c, map));
            CAPTURE(std::string{c->why});
            const std::unique_ptr<Bench> b = make();
            REQUIRE(s.enter(*b));
            const auto writes = writes_of(*c, read_of(b->model, list, map), map);
            if (writes.empty()) continue;
            bool is_taken = true;
            for (const new_value& one : writes) is_taken = write(*b, one, map) && is_taken;
            b->pass(600);
            const bool is_mended = is_taken && !is_found(*b, c);
            if (is_mended) mended.insert(c->why);
            CHECK((is_mended || *c->by.act != '\0'));
        }
    }
}

/// Each row that names a command was mended by it in a state, other than those of `left_out`.
inline void expect_all_mended(const check_list& list, const std::set<std::string>& mended,
                              std::initializer_list<std::string_view> left_out = {}) {
    for (const check& c : list.checks) {
        if (c.by.compose == nullptr && *c.by.write == '\0') continue;
        CAPTURE(std::string{c.why});
        const bool is_left_out = std::find(left_out.begin(), left_out.end(), c.why) != left_out.end();
        CHECK(mended.contains(c.why) != is_left_out);
    }
}

} // namespace doctored
