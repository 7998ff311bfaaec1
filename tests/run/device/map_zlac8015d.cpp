// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The ZLAC8015D's registers against the manual's own table (tests/manuals/zlac8015d.tsv), row by row:
// address, type, access, range, unit and default. Where the library differs, the list below has the erratum.
// A difference that is not listed fails the test, and so does a listed difference that does not exist.
#include <doctest/doctest.h>

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include <servobus/device/zlac8015d/catalogue.hpp>

#include <tests/support/manual.hpp>

namespace map_zlac8015d_tests {

using namespace servobus;
using tests::in_hex, tests::number, tests::printed_bounds, tests::printed_unit;

namespace {

/// A property of a register in which the library differs from the printed table.
struct correction {
    u16 address;
    const char* what;
    const char* erratum;
};
constexpr correction corrections[] = {
    {0x2022, "range", "B21"},                              // 1..A is hexadecimal
    {0x2044, "unit", "B16"},                               // "/min"
    {0x2074, "unit", "B16"},   {0x2044, "default", "B16"}, // "lr/min"
    {0x2086, "default", "B6"},                             // "300ms" of a slope
    {0x2087, "default", "B6"}, {0x208A, "type", "B20"},    // two halves, each I16
    {0x208B, "type", "B20"},   {0x208C, "type", "B20"},    {0x208D, "type", "B20"},
    {0x20A7, "type", "B20"},   {0x20A8, "type", "B20"},    {0x20A9, "type", "B20"},
    {0x20AA, "type", "B20"},   {0x208A, "range", "B20"}, // 0x7FFFFFF
    {0x208B, "range", "B20"},  {0x208C, "range", "B20"},   {0x208D, "range", "B20"},
    {0x20A7, "range", "B20"},  {0x20A8, "range", "B20"},   {0x20A9, "range", "B20"},
    {0x20AA, "range", "B20"},  {0x208A, "unit", "B20"}, // none in section 4, pulses in section 3.2
    {0x208B, "unit", "B20"},   {0x208C, "unit", "B20"},    {0x208D, "unit", "B20"},
    {0x20A3, "range", "B9"},                             // the range of one half
    {0x20A4, "range", "B9"},   {0x20A5, "range", "B23"}, // a list of single bits, several of which may be set
    {0x20A6, "range", "B23"},  {0x20AF, "range", "B19"}, // "01", and nothing else
    {0x20AF, "type", "B19"},   {0x20AF, "access", "B19"},
};

struct printed_row {
    u16 address;
    std::string name, range, unit, type, access, initial;
};

std::vector<printed_row> printed_rows() {
    std::vector<printed_row> rows;
    for (const std::string& line : tests::manual("zlac8015d.tsv")) {
        if (line.rfind("address", 0) == 0) continue;
        const auto c = tests::split(line, '\t');
        REQUIRE(c.size() == 7);
        rows.push_back({static_cast<u16>(std::stoul(c[0], nullptr, 16)), c[1], c[2], c[3], c[4], c[5], c[6]});
    }
    return rows;
}

/// True if `initial`, as printed, is the entry's default: a number, perhaps followed by the row's unit.
bool is_same_default(const entry& e, const std::string& initial) {
    if (initial.empty() || initial == "_" || initial == "-") return e.initial == no_default;
    std::size_t digits = 0;
    while (digits < initial.size() && initial[digits] >= '0' && initial[digits] <= '9') ++digits;
    const auto value = number(initial.substr(0, digits));
    const std::string suffix = initial.substr(digits);
    const bool unit_fits = suffix.empty() || printed_unit(suffix) == e.unit_of_count;
    return value && unit_fits && *value == e.initial;
}

std::vector<std::string> differences(const printed_row& row, const entry& e) {
    std::vector<std::string> found;
    if (row.type != (e.kind == value_kind::signed_word     ? "I16"
                     : e.kind == value_kind::unsigned_word ? "U16"
                                                           : "32"))
        found.push_back("type");
    const bool is_saved = has(e.flags, saved);
    const std::string access = e.rights == access::ro ? "RO" : is_saved ? "RW/S" : "RW";
    if (row.access != access) found.push_back("access");
    const auto range = printed_bounds(row.range);
    if (range ? !e.limits.is_stated || *range != tests::bounds{e.limits.low, e.limits.high}
              : e.limits.is_stated)
        found.push_back("range");
    if (printed_unit(row.unit) != e.unit_of_count) found.push_back("unit");
    if (!is_same_default(e, row.initial)) found.push_back("default");
    return found;
}

} // namespace

TEST_CASE("ZLAC8015D: every row of the manual's table is in the catalogue as printed, or its erratum is "
          "listed") {
    const auto rows = printed_rows();
    REQUIRE(rows.size() == 120);
    std::set<std::string> unused;
    for (const correction& c : corrections) CHECK(unused.insert(in_hex(c.address) + " " + c.what).second);
    for (const printed_row& row : rows) {
        const entry* e = zlac8015d::catalogue.find(row.address);
        const std::string address = in_hex(row.address);
        CAPTURE(address);
        CAPTURE(row.name);
        REQUIRE(e != nullptr);
        for (const std::string& what : differences(row, *e)) {
            const std::string difference = address + " " + what;
            CAPTURE(difference);
            CHECK_MESSAGE(unused.erase(difference) == 1, "this differs from the manual and is not listed");
        }
    }
    for (const std::string& stale : unused) {
        CAPTURE(stale);
        CHECK_MESSAGE(false, "listed as differing from the manual, but it does not");
    }
}

TEST_CASE("ZLAC8015D: every listed correction is an erratum in errata.md") {
    for (const correction& c : corrections) {
        CAPTURE(c.erratum);
        CHECK(tests::has_erratum("errata.md", c.erratum));
    }
}

TEST_CASE(
    "ZLAC8015D: the catalogue has 116 registers at 120 addresses, in order, and none that is not in the "
    "manual") {
    const auto entries = zlac8015d::catalogue.entries;
    CHECK(entries.size() == 116);
    CHECK(is_in_order(entries));
    std::set<u16> printed;
    for (const printed_row& row : printed_rows()) printed.insert(row.address);
    CHECK(printed.size() == 120);
    std::set<std::string> names;
    std::size_t words = 0;
    for (const entry& e : entries) {
        const std::string address = in_hex(e.address);
        CAPTURE(address);
        words += e.words();
        for (std::size_t i = 0; i < e.words(); ++i)
            CHECK(printed.count(static_cast<u16>(e.address + i)) == 1);
        CHECK(names.insert(std::string{e.name}).second);
    }
    CHECK(words == 120);
}

TEST_CASE("ZLAC8015D: left and right rows are equal, and the documented step apart") {
    unsigned pairs = 0;
    for (const entry& left : zlac8015d::catalogue.entries) {
        const std::string name{left.name};
        if (name.rfind("left_", 0) != 0) continue;
        const bool is_of_a_motor = left.address >= 0x2030 && left.address <= 0x204A;
        const std::size_t step = is_of_a_motor ? 0x30 : left.words();
        CAPTURE(name);
        const entry* right = zlac8015d::catalogue.find(static_cast<u16>(left.address + step));
        REQUIRE(right != nullptr);
        ++pairs;
        CHECK(std::string{right->name} == "right_" + name.substr(5));
        CHECK(right->address == left.address + step);
        CHECK(right->kind == left.kind);
        CHECK(right->rights == left.rights);
        CHECK(right->limits == left.limits);
        CHECK(right->unit_of_count == left.unit_of_count);
        CHECK(right->flags == left.flags);
        CHECK(right->names == left.names);
        if (left.address != 0x2040) CHECK(right->initial == left.initial); // erratum B7
    }
    CHECK(pairs == 38);
    unsigned of_a_motor = 0;
    for (const entry& e : zlac8015d::catalogue.entries) {
        if (e.address < 0x2030 || e.address > 0x207A) continue;
        ++of_a_motor;
        CHECK(std::string{e.name}.rfind(e.address < 0x2060 ? "left_" : "right_", 0) == 0);
    }
    CHECK(of_a_motor == 50);
}

TEST_CASE("ZLAC8015D: registers that save, start, clear, reset or enable are triggers; targets are flagged "
          "as motion") {
    const std::set<u16> triggers{0x2005, 0x2006, 0x2009, 0x200E, 0x2010};
    const std::set<u16> targets{0x2088, 0x2089, 0x208A, 0x208C, 0x2090, 0x2091};
    for (const entry& e : zlac8015d::catalogue.entries) {
        const std::string address = in_hex(e.address);
        CAPTURE(address);
        CHECK(has(e.flags, trigger) == (triggers.count(e.address) == 1));
        CHECK(has(e.flags, motion) == (targets.count(e.address) == 1));
        CHECK(has(e.flags, scaled_elsewhere) == (e.address == 0x2088 || e.address == 0x2089));
    }
}

TEST_CASE("ZLAC8015D: every name of a value is in its register's range and applies to its own value") {
    for (const entry& e : zlac8015d::catalogue.entries) {
        const std::string address = in_hex(e.address);
        CAPTURE(address);
        CHECK((e.names == naming::names) == !e.values.empty());
        std::set<std::string> names;
        for (const named_value& v : e.values) {
            CAPTURE(v.name);
            CHECK(v.applies(v.value));
            CHECK((v.value & ~v.mask) == 0);
            CHECK(e.limits.contains(v.value));
            CHECK(names.insert(v.name).second);
        }
    }
}

} // namespace map_zlac8015d_tests
