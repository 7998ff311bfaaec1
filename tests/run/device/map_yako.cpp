// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The YAKOTEC steppers' registers against the manual's own two tables (tests/manuals/yako_closed_loop.tsv,
// yako_open_loop.tsv), row by row: address, type, access, range, unit and default. Where the library differs,
// the lists below have the erratum. A difference that is not listed fails the test, and so does a listed
// difference that does not exist. Further tests compare the two tables and check the values of registers.
#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <set>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include <servobus/device/yako.hpp>
#include <servobus/device/yako/closed_loop_catalogue.hpp>
#include <servobus/device/yako/open_loop_catalogue.hpp>
#include <servobus/registers/block.hpp>
#include <servobus/registers/format.hpp>
#include <servobus/registers/register_value.hpp>

#include <tests/support/manual.hpp>

namespace map_yako_tests {

using namespace servobus;
using tests::in_hex, tests::number, tests::printed_bounds, tests::printed_unit;

namespace {

/// A property of a register in which the library differs from the printed table. For a segment's register it
/// is given for the first segment.
struct correction {
    u16 address;
    const char* what;
    const char* erratum;
};
constexpr correction in_both[] = {
    {0x0006, "range", "A36"},                                                    // only in the description
    {0x000A, "type", "A51"},  {0x000B, "type", "A51"},  {0x000C, "type", "A51"}, // signed
    {0x000A, "unit", "A50"},  {0x000B, "unit", "A50"},  {0x000C, "unit", "A51"},
    {0x0024, "range", "A15"}, {0x0025, "range", "A15"}, {0x0024, "unit", "A50"},
    {0x0025, "unit", "A50"},  {0x0035, "range", "A15"}, {0x0036, "range", "A15"},
    {0x0035, "unit", "A50"},  {0x0036, "unit", "A50"},  {0x0037, "range", "A15"},
    {0x0038, "range", "A15"}, {0x0037, "unit", "A50"},  {0x0038, "unit", "A50"},
    {0x0039, "range", "A15"}, {0x003A, "range", "A15"}, {0x0039, "unit", "A50"},
    {0x003A, "unit", "A50"},  {0x0060, "range", "A15"}, {0x0061, "range", "A15"},
    {0x0060, "unit", "A50"},  {0x0061, "unit", "A50"},  {0x0031, "range", "A16"}, // 0..65535
};
constexpr correction in_closed_loop[] = {
    {0x0031, "type", "A16"},   // -4..-1
    {0x003B, "access", "A46"}, // none
    {0x003C, "access", "A46"},
    {0x003C, "unit", "A46"}, // percent, by the name
};

/// A variant: its catalogue, its table, and the differences between them.
struct variant {
    const catalogue* map;
    const char* table;
    std::size_t registers, addresses;
    std::span<const correction> own;
};
constexpr variant variants[] = {
    {&yako::closed_loop::catalogue, "yako_closed_loop.tsv", 204, 225, in_closed_loop},
    {&yako::open_loop::catalogue, "yako_open_loop.tsv", 208, 229, {}},
};

std::vector<correction> corrections_of(const variant& v) {
    std::vector<correction> all{std::begin(in_both), std::end(in_both)};
    all.insert(all.end(), v.own.begin(), v.own.end());
    return all;
}

struct printed_row {
    u16 address;
    std::string name, range, unit, access, initial, notes;
};
using printed_table = std::map<u16, printed_row>;

printed_table printed_rows(const variant& v) {
    printed_table rows;
    for (const std::string& line : tests::manual(v.table)) {
        if (line.rfind("address", 0) == 0) continue;
        const auto c = tests::split(line, '\t');
        REQUIRE(c.size() == 8);
        const auto address = static_cast<u16>(std::stoul(c[0], nullptr, 16));
        const std::string access = c[4] + (c[5].empty() ? "" : "/" + c[5]);
        CHECK(rows.insert({address, {address, c[1], c[2], c[3], access, c[6], c[7]}}).second);
    }
    return rows;
}

bool ends_in(const std::string& text, const std::string& end) {
    return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}
bool is_high_word(const printed_row& row) { return ends_in(row.name, "高位"); }
bool is_low_word(const printed_row& row) { return ends_in(row.name, "低位"); }

/// The row that describes the register. A row of a later segment refers to that of the first segment.
const printed_row& meant(const printed_table& rows, const printed_row& row) {
    const auto refers_to = [&](const char* segment) { return row.notes == std::string{"参考"} + segment; };
    if (refers_to("0x0060~0x0065")) return rows.at(static_cast<u16>(0x0060 + (row.address - 0x0060) % 6));
    if (refers_to("0x00C0~0x00C2")) return rows.at(static_cast<u16>(0x00C0 + (row.address - 0x00C0) % 3));
    return row;
}

/// The manual has no column for the type: high and low words make pairs, and a value that may be negative is
/// signed.
std::string printed_type(const printed_row& row) {
    const auto range = printed_bounds(row.range);
    const bool is_signed = row.range.rfind("0xFFFFFFFF", 0) == 0 || (range && range->low < 0);
    return std::string{is_signed ? "i" : "u"} + (is_high_word(row) || is_low_word(row) ? "32" : "16");
}

/// The default of a pair is printed at the high word for both, or at each word.
bool is_same_default(const printed_table& rows, const printed_row& row, const entry& e) {
    const printed_row& high = is_low_word(row) ? rows.at(static_cast<u16>(row.address - 1)) : row;
    std::string text = high.initial;
    std::int64_t upper = 0;
    if (is_high_word(high)) {
        const printed_row& low = rows.at(static_cast<u16>(high.address + 1));
        if (!low.initial.empty() && low.initial != "-") {
            upper = number(high.initial).value() * 0x1'0000;
            text = low.initial;
        }
    }
    if (text == "-") return e.initial == no_default;
    const auto value = number(text);
    return value && upper + *value == e.initial;
}

std::vector<std::string> differences(const printed_table& rows, const printed_row& row, const entry& e) {
    std::vector<std::string> found;
    if (printed_type(row) != text(e.kind)) found.push_back("type");
    const std::string access = e.rights == access::ro ? "RO" : has(e.flags, saved) ? "RW/S" : "RW";
    if (row.access != access) found.push_back("access");
    const auto range = printed_bounds(row.range);
    if (range ? !e.limits.is_stated || *range != tests::bounds{e.limits.low, e.limits.high}
              : e.limits.is_stated)
        found.push_back("range");
    if (printed_unit(row.unit) != e.unit_of_count) found.push_back("unit");
    if (!is_same_default(rows, row, e)) found.push_back("default");
    return found;
}

} // namespace

TEST_CASE("YAKO: every row of the manual's two tables is in its catalogue as printed, or its erratum is "
          "listed") {
    for (const variant& v : variants) {
        const std::string table = v.table;
        CAPTURE(table);
        std::set<std::string> listed;
        for (const correction& c : corrections_of(v))
            CHECK(listed.insert(in_hex(c.address) + " " + c.what).second);
        std::set<std::string> unused = listed;
        const printed_table rows = printed_rows(v);
        CHECK(rows.size() == v.addresses);
        for (const auto& pair : rows) {
            const u16 at = pair.first;
            const printed_row& row = pair.second;
            const entry* e = v.map->find(at);
            const std::string address = in_hex(at);
            CAPTURE(address);
            CAPTURE(row.name);
            REQUIRE(e != nullptr);
            const printed_row& says = meant(rows, row);
            CHECK(e->address == (is_low_word(says) ? at - 1 : at));
            for (const std::string& what : differences(rows, says, *e)) {
                const std::string difference = in_hex(says.address) + " " + what;
                CAPTURE(difference);
                CHECK_MESSAGE(listed.count(difference) == 1,
                              "this differs from the manual and is not listed");
                unused.erase(difference);
            }
        }
        for (const std::string& stale : unused) {
            CAPTURE(stale);
            CHECK_MESSAGE(false, "listed as differing from the manual, but it does not");
        }
    }
}

TEST_CASE("YAKO: every listed correction is an erratum in errata.md, which has A1 to A61 without gaps") {
    for (const variant& v : variants) {
        for (const correction& c : corrections_of(v)) {
            const std::string erratum = c.erratum;
            CAPTURE(erratum);
            CHECK(tests::has_erratum("errata.md", erratum));
        }
    }
    for (unsigned n = 1; n <= 61; ++n) {
        CAPTURE(n);
        CHECK(tests::has_erratum("errata.md", "A" + std::to_string(n)));
    }
}

TEST_CASE("YAKO: where a correction is listed, the value is that of its erratum") {
    for (const variant& v : variants) {
        const std::string table = v.table;
        CAPTURE(table);
        std::size_t pairs = 0;
        for (const entry& e : v.map->entries) {
            if (e.words() != 2) continue;
            const std::string address = in_hex(e.address);
            CAPTURE(address);
            ++pairs;
            const bool is_stated = e.rights == access::rw; // A15; A51
            CHECK(e.kind == value_kind::signed_pair);
            CHECK(e.limits == range{-0x8000'0000LL, 0x7FFF'FFFF, is_stated});
            CHECK(e.unit_of_count == unit{measure::pulse}); // A50
        }
        CHECK(pairs == 5 + 16);
        const entry& speed = *v.map->find(0x000C); // A51
        CHECK(speed.kind == value_kind::signed_word);
        CHECK(speed.limits == full<i16>);
        CHECK(speed.unit_of_count == unit{measure::r_per_min});
        const bool is_closed_loop = v.map == &yako::closed_loop::catalogue;
        const entry& method = *v.map->find(0x0031); // A16
        CHECK(method.kind == (is_closed_loop ? value_kind::signed_word : value_kind::unsigned_word));
        CHECK(method.limits == (is_closed_loop ? range{-4, 35} : range{17, 35}));
    }
    for (const variant& v : variants) { // A36
        const entry& error = *v.map->find(0x0006);
        CHECK(error.limits == range{0, 5});
        for (const u16 code : {u16{0}, u16{3}, u16{5}}) {
            char room[64]{};
            text_writer out{room};
            put_value(out, error, code);
            const std::string said{room, out.size()};
            CHECK(said == (code == 0   ? "none (0x0000)"
                           : code == 3 ? "error 3 (0x0003)"
                                       : "error 5 (0x0005)"));
        }
    }
    for (const u16 address : {u16{0x003B}, u16{0x003C}}) { // A46
        const entry& e = *yako::closed_loop::catalogue.find(address);
        CHECK(e.rights == access::rw);
        CHECK_FALSE(has(e.flags, saved));
        CHECK(e.unit_of_count == (address == 0x003C ? unit{measure::percent} : no_unit));
    }
}

TEST_CASE("YAKO: the catalogues have 225 and 229 addresses, in order, and none that is not in the manual") {
    for (const variant& v : variants) {
        const std::string table = v.table;
        CAPTURE(table);
        const printed_table rows = printed_rows(v);
        CHECK(v.map->entries.size() == v.registers);
        CHECK(is_in_order(v.map->entries));
        std::set<std::string> names;
        std::size_t words = 0;
        for (const entry& e : v.map->entries) {
            const std::string address = in_hex(e.address);
            CAPTURE(address);
            words += e.words();
            for (std::size_t i = 0; i < e.words(); ++i)
                CHECK(rows.count(static_cast<u16>(e.address + i)) == 1);
            CHECK(names.insert(std::string{e.name}).second);
        }
        CHECK(words == v.addresses);
    }
}

TEST_CASE("YAKO: the registers of all segments are equal, and the documented step apart") {
    struct group {
        u16 first;
        std::size_t registers, step;
        std::string name;
    };
    for (const variant& v : variants) {
        const std::string table = v.table;
        CAPTURE(table);
        std::vector<group> groups = {{0x0060, 5, 6, "position_segment_"}, {0x00C0, 3, 3, "speed_segment_"}};
        if (v.map == &yako::open_loop::catalogue) groups.push_back({0x0130, 1, 1, "segment_"});
        for (const group& g : groups) {
            std::size_t pairs = 0;
            const entry* const first = v.map->find(g.first);
            REQUIRE(first != nullptr);
            for (std::size_t i = 0; i < g.registers; ++i) {
                const entry& of_first = first[i];
                for (std::size_t segment = 1; segment <= 16; ++segment) {
                    const entry& e = first[i + (segment - 1) * g.registers];
                    const std::string address = in_hex(e.address);
                    CAPTURE(address);
                    const std::string before = g.name + std::to_string(segment) + "_";
                    const std::string before_first = g.name + "1_";
                    CHECK(e.address == of_first.address + (segment - 1) * g.step);
                    CHECK(std::string{e.name} ==
                          before + std::string{of_first.name}.substr(before_first.size()));
                    CHECK(e.kind == of_first.kind);
                    CHECK(e.rights == of_first.rights);
                    CHECK(e.limits == of_first.limits);
                    CHECK(e.initial == of_first.initial);
                    CHECK(e.unit_of_count == of_first.unit_of_count);
                    CHECK(e.flags == of_first.flags);
                    CHECK(e.names == of_first.names);
                    ++pairs;
                }
            }
            CHECK(pairs == 16 * g.registers);
        }
    }
}

namespace {

// All segments are equal, as the test above checks. So only the first one is compared.
unsigned in_first_segment(unsigned address) {
    if (address >= 0x0060 && address < 0x00C0) return 0x0060 + (address - 0x0060) % 6;
    if (address >= 0x00C0 && address < 0x00F0) return 0x00C0 + (address - 0x00C0) % 3;
    return address >= 0x0130 ? 0x0130 : address;
}

// Only the closed loop variant rescales speeds (A37). Another test checks it.
std::vector<std::string> differences(const entry& closed, const entry& open) {
    std::vector<std::string> found;
    const bool is_speed = open.unit_of_count.of == measure::r_per_min;
    if (closed.kind != open.kind) found.push_back("kind");
    if (closed.rights != open.rights) found.push_back("access");
    if (!(closed.limits == open.limits)) found.push_back("range");
    if (closed.initial != open.initial) found.push_back("default");
    if (closed.unit_of_count != open.unit_of_count) found.push_back("unit");
    if (closed.flags != (is_speed ? open.flags | scaled_elsewhere : open.flags)) found.push_back("flags");
    std::string of_closed, of_open;
    for (const named_value& n : closed.values) of_closed += std::to_string(n.value) + n.name + ';';
    for (const named_value& n : open.values) of_open += std::to_string(n.value) + n.name + ';';
    if (of_closed != of_open) found.push_back("names");
    return found;
}

} // namespace

TEST_CASE("YAKO: closed loop and open loop differ as errata A16, A17, A24, A25 and A48 state, and in nothing "
          "else") {
    // clang-format off
    const std::set<std::string> known = {
        // Terminals: A24, A25.
        "0008h names", "0009h names", "0040h names", "004Bh names", "004Fh names",
        // Methods: A16, A17.
        "0031h kind", "0031h range", "0031h names",
        // A48.
        "0020h default", "0063h default", "0064h default", "00C1h default", "00C2h default",
        "0102h range", "0106h default", "0107h range",
        "001Ah closed loop", "003Bh closed loop", "003Ch closed loop", "0100h closed loop",
        "0101h closed loop", "0103h closed loop", "010Ah closed loop", "010Bh closed loop",
        "0112h closed loop", "0113h closed loop", "0114h closed loop", "0115h closed loop",
        "0116h closed loop", "0117h closed loop", "0118h closed loop", "0119h closed loop",
        "0045h open loop", "0046h open loop", "0047h open loop", "004Eh open loop", "0130h open loop",
    };
    // clang-format on
    std::set<std::string> found;
    for (unsigned at = 0; at < 0x0200; ++at) {
        const std::string address = in_hex(in_first_segment(at));
        CAPTURE(address);
        const entry* closed = yako::closed_loop::catalogue.find(static_cast<u16>(at));
        const entry* open = yako::open_loop::catalogue.find(static_cast<u16>(at));
        if (closed != nullptr && open != nullptr) {
            CHECK(closed->address == open->address);
            CHECK(std::string{closed->name} == std::string{open->name});
            for (const std::string& what : differences(*closed, *open)) found.insert(address + " " + what);
        } else if (closed != nullptr) {
            found.insert(address + " closed loop");
        } else if (open != nullptr) {
            found.insert(address + " open loop");
        }
    }
    for (const std::string& difference : found) {
        CAPTURE(difference);
        CHECK_MESSAGE(known.count(difference) == 1, "closed loop and open loop differ without an erratum");
    }
    for (const std::string& difference : known) {
        CAPTURE(difference);
        CHECK_MESSAGE(found.count(difference) == 1, "closed loop and open loop do not differ in this");
    }
}

TEST_CASE("YAKO: registers are flagged as triggers, as motion or as communication where they are") {
    const std::set<u16> triggers{0x0027, 0x002D};
    const std::set<u16> line{0x0013, 0x0014, 0x0015, 0x0019};
    const std::set<u16> from_power_on{0x0014, 0x0015};
    for (const variant& v : variants) {
        const std::string table = v.table;
        CAPTURE(table);
        const bool is_closed_loop = v.map == &yako::closed_loop::catalogue;
        for (const entry& e : v.map->entries) {
            const std::string address = in_hex(e.address);
            CAPTURE(address);
            CHECK(has(e.flags, trigger) == (triggers.count(e.address) == 1));
            CHECK(has(e.flags, communication) == (line.count(e.address) == 1));
            CHECK(has(e.flags, after_power_cycle) == (from_power_on.count(e.address) == 1));
            CHECK(has(e.flags, motion) == (e.address == 0x0024));
            CHECK(has(e.flags, scaled_elsewhere) ==
                  (is_closed_loop && e.unit_of_count.of == measure::r_per_min));
            CHECK_FALSE(has(e.flags, saved_on_write));
        }
    }
}

TEST_CASE("YAKO: every value and every bit that the tables list has a name, and nothing else has one") {
    for (const variant& v : variants) {
        const std::string table = v.table;
        CAPTURE(table);
        const printed_table rows = printed_rows(v);
        for (const entry& e : v.map->entries) {
            if (e.names != naming::names || e.address == 0x0031) continue; // methods: see below
            const std::string address = in_hex(e.address);
            CAPTURE(address);
            std::set<std::int64_t> values, bits;
            for (const std::string& item : tests::split(meant(rows, rows.at(e.address)).notes, ';')) {
                const std::string what = item.substr(0, item.find(':'));
                if (what == "1~5") values.insert({1, 2, 3, 4, 5});
                if (const auto value = number(what)) values.insert(*value);
                if (what.rfind("Bit", 0) != 0 || ends_in(item, "保留")) continue;
                const std::size_t span = what.find("~Bit");
                const auto first = number(what.substr(3, span == what.npos ? span : span - 3));
                const auto last = span == what.npos ? first : number(what.substr(span + 4));
                REQUIRE((first && last));
                for (std::int64_t bit = *first; bit <= *last; ++bit) bits.insert(std::int64_t{1} << bit);
            }
            // The manual omits only Y2, erratum A28.
            if (v.map == &yako::open_loop::catalogue && e.address == 0x004F)
                CHECK(bits.insert(0x0004).second);
            std::set<std::int64_t> named;
            for (const named_value& n : e.values) {
                if (!bits.empty() && n.value == 0 && n.mask == 0xFFFF) continue; // "none" of several bits
                named.insert(bits.empty() ? n.value : n.mask);
            }
            CHECK(named == (bits.empty() ? values : bits));
        }
    }
}

TEST_CASE("YAKO: every name of a value is in its register's range and applies to its own value") {
    for (const variant& v : variants) {
        const std::string table = v.table;
        CAPTURE(table);
        for (const entry& e : v.map->entries) {
            const std::string address = in_hex(e.address);
            CAPTURE(address);
            CHECK((e.names == naming::names) == !e.values.empty());
            std::set<std::string> names;
            for (const named_value& n : e.values) {
                const std::string name = n.name;
                CAPTURE(name);
                CHECK(n.applies(n.value));
                CHECK((n.value & ~n.mask) == 0);
                CHECK(e.limits.contains(e.number(n.value)));
                CHECK(names.insert(name).second);
            }
        }
    }
}

// A variant is its family's device under its own name.

namespace {

constexpr bool is_like_the_family(const profile& p) {
    const profile& family = yako::device::facts;
    return p.max_read == 16 && family.max_read == 16 && p.max_write == family.max_write &&
           p.lowest_address == 1 && p.highest_address == 247 && p.word_order == word_order::unknown &&
           p.word_order_register == yako::pair_word_order.address && p.baud == 115200 &&
           p.format == character_format::n81 && p.exceptions.begin() == family.exceptions.begin() &&
           p.exceptions.end() == p.exceptions.begin() + 7;
}
static_assert(is_like_the_family(yako::device::facts));
static_assert(is_like_the_family(yako::closed_loop::device::facts));
static_assert(is_like_the_family(yako::open_loop::device::facts));

static_assert(belongs_to<yako::device, yako::closed_loop::device>);
static_assert(belongs_to<yako::device, yako::open_loop::device>);
static_assert(!belongs_to<yako::closed_loop::device, yako::device>);
static_assert(!belongs_to<yako::closed_loop::device, yako::open_loop::device>);

// The family's rows under a variant's name; rows of both in one read.
static_assert(is_register<yako::closed_loop::rs485_baud_rate> &&
              is_register<yako::open_loop::rs485_baud_rate>);
constexpr auto& status_and_feedback =
    read_plan<yako::closed_loop::status_word, yako::closed_loop::input_state, yako::closed_loop::output_state,
              yako::closed_loop::actual_position, yako::closed_loop::actual_speed>;
static_assert(status_and_feedback.count == 1 && status_and_feedback.words == 6);
static_assert(at<yako::closed_loop::position_segment_targets, 15>.address == 0x00BA);
static_assert(at<yako::open_loop::segment_start_speeds, 15>.address == 0x013F);

// Speeds are quantities on open loop and counts on closed loop, where another register sets their scale.
template <const auto& R> constexpr u32 bits_of(register_value<R> s) { return s.bits(); }
static_assert(bits_of<yako::open_loop::jog_speed>(-500 * units::r_per_min) == 0xFFFF'FE0C);
static_assert(bits_of<yako::closed_loop::jog_speed>(raw(-500)) == 0xFFFF'FE0C);
static_assert(
    std::is_same_v<reading<yako::open_loop::actual_speed>, quantity<unit{measure::r_per_min}, i16>>);
static_assert(std::is_same_v<reading<yako::closed_loop::actual_speed>, i16>);

// The words that the manual prints in sections 4 and 5.1.
static_assert(yako::motion_code::move(yako::positioning::relative).to_word() == 0x0001);
static_assert(yako::motion_code::move(yako::positioning::absolute).to_word() == 0x0005);
static_assert(yako::motion_code::move(yako::positioning::absolute, yako::while_moving::interrupt).to_word() ==
              0x000D);
static_assert(yako::motion_code::jog().to_word() == 0x0002);
static_assert(yako::motion_code::home().to_word() == 0x0010);
static_assert(yako::motion_code::stop().to_word() == 0x0100);
static_assert(yako::motion_code::emergency_stop().to_word() == 0x0200);
static_assert(bits_of<yako::motion_command>(yako::motion_code::emergency_stop()) == 0x0200);
static_assert(bits_of<yako::auxiliary_command>(yako::auxiliary::save_parameters) == 0x0042);
static_assert(bits_of<yako::closed_loop::homing_method>(number_of(yako::homing::mechanical_stop_4)) ==
              0xFFFF'FFFC);
static_assert(bits_of<yako::open_loop::homing_method>(number_of(yako::homing::home_24)) == 24);

// The motor is enabled while bit 4 is 0 (erratum A35). A default status is not enabled.
static_assert(yako::motion_status::from_word(0x0000).is_enabled());
static_assert(!yako::motion_status::from_word(0x0010).is_enabled());
static_assert(!yako::motion_status{}.is_enabled());

} // namespace

TEST_CASE("YAKO: each status bit has one query, and to_word restores every word") {
    using status = yako::motion_status;
    for (unsigned w = 0; w <= 0xFFFF; ++w) {
        const status s = status::from_word(static_cast<u16>(w));
        REQUIRE(s.to_word() == w);
        REQUIRE(s.is_in_position() == ((w & 0x01) != 0));
        REQUIRE(s.is_homed() == ((w & 0x02) != 0));
        REQUIRE(s.is_moving() == ((w & 0x04) != 0));
        REQUIRE(s.has_alarm() == ((w & 0x08) != 0));
        REQUIRE(s.is_enabled() == ((w & 0x10) == 0));
        REQUIRE(s.is_beyond_positive_limit() == ((w & 0x20) != 0));
        REQUIRE(s.is_beyond_negative_limit() == ((w & 0x40) != 0));
        const yako::motion_code c = yako::motion_code::from_word(static_cast<u16>(w));
        REQUIRE(c.to_word() == w);
        REQUIRE(c.is_start() == ((w & 0x0013) != 0));
        REQUIRE(c.is_stop() == ((w & 0x0300) != 0));
        REQUIRE(yako::switches::from_word(static_cast<u16>(w)).to_word() == w);
    }
    for (unsigned number = 1; number <= 7; ++number) {
        const auto one = static_cast<u16>(1u << (number - 1));
        for (unsigned other = 0; other <= 16; ++other)
            CHECK(yako::switches::from_word(one).is_on(other) == (other == number));
    }
}

TEST_CASE("YAKO: conversion to a word restores the terminals that the drive has") {
    for (unsigned w = 0; w <= 0xFFFF; ++w) {
        const auto word = static_cast<u16>(w);
        REQUIRE(yako::closed_loop::inputs::from_word(word).to_word() == (w & 0x0F));
        REQUIRE(yako::open_loop::inputs::from_word(word).to_word() == (w & 0x7F));
        REQUIRE(yako::closed_loop::outputs::from_word(word).to_word() == (w & 0x03));
        REQUIRE(yako::open_loop::outputs::from_word(word).to_word() == (w & 0x07));
    }
    CHECK(yako::closed_loop::inputs::from_word(0x0008).x3);
    CHECK(yako::open_loop::inputs::from_word(0x0040).x6);
    CHECK(yako::closed_loop::outputs::from_word(0x0002).y1);
    CHECK(yako::open_loop::outputs::from_word(0x0004).y2);
}

TEST_CASE("YAKO: a homing method is valid and has a name if the appendices list it") {
    for (int n = -300; n <= 300; ++n) {
        CAPTURE(n);
        const bool with_index = (n >= 1 && n <= 14) || n == 33 || n == 34;
        const bool without_index = (n >= 17 && n <= 30) || n == 35;
        const bool at_a_stop = n >= -4 && n <= -1;
        const auto method = yako::homing{static_cast<i16>(n)};
        CHECK(yako::closed_loop::is_valid(method) == (with_index || without_index || at_a_stop));
        CHECK(yako::open_loop::is_valid(method) == without_index);
        for (const variant& v : variants) {
            const entry& e = *v.map->find(0x0031);
            bool is_named = false;
            for (const named_value& name : e.values) is_named |= e.number(name.value) == n;
            CHECK(is_named == (v.map == &yako::closed_loop::catalogue ? yako::closed_loop::is_valid(method)
                                                                      : yako::open_loop::is_valid(method)));
        }
    }
}

TEST_CASE("YAKO: exceptions have the meaning of the manual, not of the standard") {
    for (const profile* p : {&yako::closed_loop::device::facts, &yako::open_loop::device::facts}) {
        CHECK(std::string{p->meaning(1)} == "CRC error");
        CHECK(std::string{p->meaning(2)} == "function code error");
        CHECK(std::string{p->meaning(3)} == "register address not allowed");
        CHECK(std::string{p->meaning(7)} == "value out of range");
        CHECK(std::string{p->meaning(8)} == "unknown exception");
    }
    CHECK(std::string{yako::closed_loop::device::facts.name} == "yako-closed-loop");
    CHECK(std::string{yako::open_loop::device::facts.name} == "yako-open-loop");
}

} // namespace map_yako_tests
