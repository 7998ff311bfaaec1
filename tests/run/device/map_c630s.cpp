// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The C630S's registers against chapter 7 of its manual (tests/manuals/c630s.tsv), row by row: address,
// words, sign, access, range, unit and scale, default, when it may be set, when it takes effect, control
// modes, and the values that have names. Where the library differs, the list below has the erratum. A
// difference that is not listed fails the test, and so does a listed difference that does not exist. Its
// alarms are compared with chapter 8.
#include <doctest/doctest.h>

#include <cstdint>
#include <fstream>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <servobus/device/c630s.hpp>
#include <servobus/device/c630s/catalogue.hpp>

#include <tests/support/manual.hpp>

namespace map_c630s_tests {

using namespace servobus;

namespace {

/// A property of a parameter in which the library differs from the printed table.
struct correction {
    const char* parameter;
    const char* what;
    const char* erratum;
};
// clang-format off
constexpr correction corrections[] = {
    {"P03-02", "default", "C19"}, {"P03-04", "default", "C19"}, {"P03-06", "default", "C19"},
    {"P03-10", "default", "C19"}, {"P03-12", "default", "C19"}, {"P03-14", "default", "C19"},
    {"P03-16", "default", "C19"},
    {"P03-52", "unit",    "C73"}, {"P08-24", "unit",    "C73"}, // decimals without a unit
    {"P05-15", "values",  "C31"},
    {"P05-35", "unit",    "C36"},
    {"P05-43", "unit",    "C8"},  {"P0C-14", "unit",    "C8"},  {"P0C-26", "unit",    "C8"}, // "1"
    {"P0C-30", "unit",    "C8"},
    {"P09-24", "range",   "C49"}, // 0..2 Hz
    {"P0A-10", "unit",    "C74"}, // two units
    {"P0B-02", "unit",    "C42"}, {"P0B-21", "unit",    "C42"}, {"P0B-22", "unit",    "C42"},
    {"P0B-24", "unit",    "C42"}, {"P0B-26", "unit",    "C42"}, {"P0B-38", "unit",    "C42"},
    {"P0B-39", "unit",    "C42"}, {"P0B-40", "unit",    "C43"},
    {"P0B-33", "values",  "C75"}, // 0, 1, 2 and 9
    {"P0B-55", "range",   "C46"}, {"P0B-55", "unit",    "C46"}, // "0.1rpm"
};
// clang-format on

struct printed_row {
    u16 address;
    std::string parameter, name, range, unit, initial, effective, when, modes;

    bool is_of(const char* group) const { return parameter.rfind(group, 0) == 0; }
    bool is_read_only() const { return when == "shown" || when == "comm_read_only"; }
};

const std::vector<printed_row>& printed_rows() {
    static const std::vector<printed_row> rows = [] {
        std::vector<printed_row> all;
        for (const std::string& line : tests::manual("c630s.tsv")) {
            if (line.rfind("address", 0) == 0) continue;
            const auto c = tests::split(line, '\t');
            REQUIRE(c.size() == 9);
            all.push_back({static_cast<u16>(std::stoul(c[0], nullptr, 16)), c[1], c[2], c[3], c[4], c[5],
                           c[6], c[7], c[8]});
        }
        return all;
    }();
    return rows;
}

const printed_row& printed(u16 address) {
    for (const printed_row& row : printed_rows()) {
        if (row.address == address) return row;
    }
    FAIL("no row of the manual has this address: " << address);
    return printed_rows().front();
}

/// A printed number as counts of its last digit: -500.0 is -5000 with one decimal.
struct decimal {
    std::int64_t digits;
    unsigned decimals;

    std::int64_t scaled_to(unsigned more) const {
        std::int64_t v = digits;
        for (unsigned i = decimals; i < more; ++i) v *= 10;
        return v;
    }
};

/// A number, decimal or 0x…; none if the text has anything else in it.
std::optional<decimal> number(std::string_view text) {
    const bool is_negative = text.substr(0, 1) == "-";
    if (is_negative) text.remove_prefix(1);
    const bool is_hex = text.substr(0, 2) == "0x";
    if (is_hex) text.remove_prefix(2);
    decimal d{0, 0};
    bool has_point = false;
    if (text.empty()) return std::nullopt;
    for (const char c : text) {
        if (c == '.' && !is_hex && !has_point) {
            has_point = true;
            continue;
        }
        const int digit = c >= '0' && c <= '9' ? c - '0' : is_hex && c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
        if (digit < 0) return std::nullopt;
        d.digits = d.digits * (is_hex ? 16 : 10) + digit;
        if (has_point) ++d.decimals;
    }
    if (is_negative) d.digits = -d.digits;
    return d;
}

/// A printed range: a span `low..high`, or a list of values. A `see P03-03` after it is left out.
struct printed_range {
    std::vector<decimal> numbers;
    bool is_list = false;
    bool is_understood = true;
};

printed_range range_of(const std::string& text) {
    printed_range r;
    const auto take = [&](const std::string& item) {
        const auto n = number(item);
        if (n) r.numbers.push_back(*n);
        r.is_understood = r.is_understood && n.has_value();
    };
    const std::string values = text.substr(0, text.find(" see "));
    if (values.empty()) return r;
    if (const std::size_t dots = values.find(".."); dots != std::string::npos) {
        take(values.substr(0, dots));
        take(values.substr(dots + 2));
        return r;
    }
    r.is_list = true;
    for (const std::string& item : tests::split(values, ' ')) take(item);
    return r;
}

/// A default, perhaps followed by a unit: `3000rpm`.
std::optional<decimal> default_of(const std::string& text) {
    const std::size_t unit = text.rfind("rpm");
    return number(unit == std::string::npos ? text : text.substr(0, unit));
}

/// The largest number of decimals in a row's numbers. A count has this many.
unsigned decimals_of(const printed_row& row) {
    unsigned most = 0;
    const printed_range range = range_of(row.range);
    if (range.is_understood) {
        for (const decimal d : range.numbers) most = d.decimals > most ? d.decimals : most;
    }
    if (const auto d = default_of(row.initial)) most = d->decimals > most ? d->decimals : most;
    return most;
}

std::optional<unit> unit_of(const std::string& text) {
    struct {
        const char* text;
        unit of;
    } const known[] = {
        {"", {}},
        {"rpm", {measure::r_per_min}},
        {"1rpm", {measure::r_per_min}},
        {"ms", {measure::millisecond}},
        {"ms(s)", {measure::millisecond}},
        {"s", {measure::second}},
        {"S", {measure::second}},
        {"s(min)", {measure::second}},
        {"25ns", {measure::nanosecond, 25, 1}},
        {"%", {measure::percent}},
        {"0.1%", {measure::percent, 1, 10}},
        {"倍", {measure::times}},
        {"°", {measure::degree}},
        {"°C", {measure::degree_celsius}},
        {"V", {measure::volt}},
        {"mV", {measure::millivolt}},
        {"A", {measure::ampere}},
        {"W", {measure::watt}},
        {"Ω", {measure::ohm}},
        {"Hz", {measure::hertz}},
        {"kHz", {measure::kilohertz}},
        {"r", {measure::revolution}},
        {"P/r", {measure::pulse_per_revolution}},
        {"指令单位", {measure::reference_unit}},
        {"编码器单位", {measure::count}},
        {"根据切换条件", {}}, // set by the switching condition
    };
    for (const auto& k : known) {
        if (text == k.text) return k.of;
    }
    return std::nullopt;
}

/// The unit of a count, as printed; none if the text is no unit.
std::optional<unit> unit_of(const printed_row& row) {
    auto u = unit_of(row.unit);
    if (!u) return u;
    for (unsigned i = decimals_of(row); i > 0; --i) *u = *u / 10u;
    return u;
}

/// True if another parameter sets the unit.
bool is_scaled_elsewhere(const printed_row& row) {
    return row.unit == "ms(s)" || row.unit == "s(min)" || row.unit == "根据切换条件" ||
           row.unit == "通过P5-61设定" || row.unit == "编码器/指令单位";
}

/// Measured values have no printed range that would show their number of words and their sign.
constexpr std::string_view signed_words[] = {"P0B-00", "P0B-01", "P0B-02", "P0B-11", "P0B-21",
                                             "P0B-22", "P0B-27", "P0B-37", "P0B-38", "P0B-39"};
constexpr std::string_view unsigned_pairs[] = {"P0B-19", "P0B-35", "P0B-58", "P0B-71", "P0B-77", "P0B-81"};
constexpr std::string_view signed_pairs[] = {"P0B-07", "P0B-13", "P0B-15", "P0B-17", "P0B-53", "P0B-55",
                                             "P0B-60", "P0B-64", "P0B-79", "P0B-83", "P0B-85"};

value_kind kind_of(const printed_row& row) {
    for (const auto p : signed_words) {
        if (row.parameter == p) return value_kind::signed_word;
    }
    for (const auto p : unsigned_pairs) {
        if (row.parameter == p) return value_kind::unsigned_pair;
    }
    for (const auto p : signed_pairs) {
        if (row.parameter == p) return value_kind::signed_pair;
    }
    bool is_signed = false;
    bool is_pair = false;
    const unsigned decimals = decimals_of(row);
    for (const decimal d : range_of(row.range).numbers) {
        is_signed = is_signed || d.digits < 0;
        is_pair = is_pair || d.scaled_to(decimals) > 0xFFFF;
    }
    return is_pair     ? is_signed ? value_kind::signed_pair : value_kind::unsigned_pair
           : is_signed ? value_kind::signed_word
                       : value_kind::unsigned_word;
}

bool has_printed_range(const printed_row& row, const entry& e) {
    const printed_range range = range_of(row.range);
    if (!range.is_understood) return false;
    if (range.numbers.empty()) return !e.limits.is_stated;
    const unsigned decimals = decimals_of(row);
    std::int64_t low = range.numbers[0].scaled_to(decimals);
    std::int64_t high = low;
    for (const decimal d : range.numbers) {
        const std::int64_t v = d.scaled_to(decimals);
        low = v < low ? v : low;
        high = v > high ? v : high;
    }
    return e.limits == servobus::range{low, high, true};
}

bool has_printed_default(const printed_row& row, const entry& e) {
    if (row.initial.empty()) return e.initial == no_default;
    const auto d = default_of(row.initial);
    return d && d->scaled_to(decimals_of(row)) == e.initial;
}

/// True if a printed list of values is that of the names. A reserved parameter has a number.
bool has_printed_values(const printed_row& row, const entry& e) {
    const printed_range range = range_of(row.range);
    if (!range.is_list || !range.is_understood || e.names == naming::number)
        return e.names == naming::names || !range.is_list || range.numbers.size() <= 1 ||
               !range.is_understood;
    if (range.numbers.size() != e.values.size()) return false;
    for (std::size_t i = 0; i < e.values.size(); ++i) {
        if (e.values[i].mask != 0xFFFF || e.values[i].value != range.numbers[i].digits) return false;
    }
    return true;
}

const char* when_of(const entry& e) {
    REQUIRE_FALSE((has(e.flags, when_stopped) && has(e.flags, when_running)));
    return has(e.flags, when_stopped) ? "stopped" : has(e.flags, when_running) ? "running" : "";
}
const char* effective_of(const entry& e) {
    REQUIRE(has(e.flags, immediate) + has(e.flags, at_stop) + has(e.flags, after_power_cycle) <= 1);
    return has(e.flags, immediate)           ? "immediate"
           : has(e.flags, at_stop)           ? "at_stop"
           : has(e.flags, after_power_cycle) ? "power_cycle"
                                             : "";
}
std::string modes_of(const entry& e) {
    std::string letters;
    if (has(e.flags, position_mode)) letters += 'P';
    if (has(e.flags, speed_mode)) letters += 'S';
    if (has(e.flags, torque_mode)) letters += 'T';
    return letters + (has(e.flags, every_mode) ? "ALL" : "");
}

std::vector<std::string> differences(const printed_row& row, const entry& e) {
    std::vector<std::string> found;
    if (e.address != row.address) found.push_back("address");
    if (e.kind != kind_of(row)) found.push_back("type");
    if (e.rights != (row.is_read_only() ? access::ro : access::rw)) found.push_back("access");
    if (!has_printed_range(row, e)) found.push_back("range");
    if (unit_of(row) != e.unit_of_count) found.push_back("unit");
    if (!has_printed_default(row, e)) found.push_back("default");
    if (!has_printed_values(row, e)) found.push_back("values");
    if (when_of(e) != (row.is_read_only() ? "" : row.when)) found.push_back("when");
    if (effective_of(e) != row.effective) found.push_back("effective");
    if (modes_of(e) != row.modes) found.push_back("modes");
    const bool is_saved = !row.is_read_only() && !row.is_of("P0B") && !row.is_of("P0D");
    if (has(e.flags, saved_on_write) != is_saved || has(e.flags, saved)) found.push_back("saved");
    if (has(e.flags, scaled_elsewhere) != is_scaled_elsewhere(row)) found.push_back("scaled elsewhere");
    return found;
}

/// The text of a file in the folder of the device's headers.
std::string device_file(const std::string& name) {
    const std::string here = __FILE__;
    std::ifstream file{here.substr(0, here.find_last_of('/') + 1) + "../../../include/servobus/device/" +
                       name};
    std::string text;
    for (std::string line; std::getline(file, line);) text += line + '\n';
    return text;
}

constexpr const char* headers[] = {"alarms",
                                   "functions",
                                   "registers",
                                   "values",
                                   "registers/auxiliary",
                                   "registers/bus_signals",
                                   "registers/communication",
                                   "registers/control",
                                   "registers/gains",
                                   "registers/inputs",
                                   "registers/monitoring",
                                   "registers/outputs",
                                   "registers/position",
                                   "registers/position_segments",
                                   "registers/protection",
                                   "registers/row",
                                   "registers/speed",
                                   "registers/speed_segments",
                                   "registers/torque",
                                   "registers/tuning",
                                   "registers/virtual_terminals"};

} // namespace

using namespace c630s::literals;
static_assert("P0B-17"_p == 0x0B11);
static_assert("P12-20"_p == 0x1214);
static_assert("P11-12"_p == 0x110C);
static_assert("P30-00"_p == 0x3000);
static_assert("P31-04"_p == 0x3104);
static_assert(c630s::detail::parameter_address("P0b-17", 6) < 0);
static_assert(c630s::detail::parameter_address("P0B-1A", 6) < 0);
static_assert(c630s::detail::parameter_address("P0B-170", 7) < 0);

static_assert(c630s::virtual_inputs{}.with(1).with(16).to_word() == 0x8001);
static_assert(c630s::virtual_inputs::from_word(0x8001).without(1) == c630s::virtual_inputs{}.with(16));
static_assert(c630s::inputs{}.with(4).has(4) && !c630s::inputs{}.with(4).has(3));
static_assert(c630s::inputs{}.with(0).with(17) == c630s::inputs{});
static_assert(c630s::input_functions<1>{}.with(c630s::input_function::servo_on).to_word() == 1);
static_assert(c630s::input_functions<17>{}.with(c630s::input_function::servo_on).to_word() == 0);
static_assert(c630s::input_functions<17>{}.with(c630s::input_function::homing_start).to_word() == 0x8000);
static_assert(c630s::input_functions<33>::from_word(2).has(c630s::input_function::emergency_stop));
static_assert(c630s::output_functions<1>::from_word(0x10).has(c630s::output_function::positioning_completed));
static_assert(!c630s::input_functions<1>::from_word(0xFFFF).has(c630s::input_function::none));

static_assert(c630s::find_alarm(0xA33)->code == 0xA33 && !c630s::find_alarm(0xA33)->is_resettable);
static_assert(c630s::find_alarm(0x941)->kind == c630s::alarm_class::warning);
static_assert(c630s::find_alarm(0) == nullptr && c630s::find_alarm(0x103) == nullptr);

TEST_CASE("C630S: every row of chapter 7 is in the catalogue as printed, or its erratum is listed") {
    REQUIRE(printed_rows().size() == 463);
    std::set<std::string> unused;
    for (const correction& c : corrections)
        CHECK(unused.insert(std::string{c.parameter} + " " + c.what).second);
    for (const printed_row& row : printed_rows()) {
        CAPTURE(row.parameter);
        CAPTURE(row.name);
        CHECK(c630s::detail::parameter_address(row.parameter.c_str(), row.parameter.size()) == row.address);
        const entry* e = c630s::catalogue.find(row.address);
        REQUIRE(e != nullptr);
        for (const std::string& what : differences(row, *e)) {
            const std::string difference = row.parameter + " " + what;
            CAPTURE(difference);
            CHECK_MESSAGE(unused.erase(difference) == 1, "this differs from the manual and is not listed");
        }
    }
    for (const std::string& stale : unused) {
        CAPTURE(stale);
        CHECK_MESSAGE(false, "listed as differing from the manual, but it does not");
    }
}

TEST_CASE("C630S: where a correction is listed, the value is that of its erratum") {
    const auto entry_of = [](const char* parameter) -> const entry& {
        const entry* e =
            c630s::catalogue.find(static_cast<u16>(c630s::detail::parameter_address(parameter, 6)));
        REQUIRE(e != nullptr);
        return *e;
    };
    const std::int64_t functions[] = {1, 14, 15, 2, 26, 34, 31, 32};
    for (unsigned i = 0; i < 8; ++i)
        CHECK(c630s::catalogue.find(static_cast<u16>("P03-02"_p + 2 * i))->initial == functions[i]);
    CHECK(entry_of("P03-52").unit_of_count == unit{measure::times, 1, 100});
    CHECK(entry_of("P08-24").unit_of_count == unit{measure::times, 1, 10});
    CHECK(entry_of("P05-35").unit_of_count == unit{measure::millisecond});
    CHECK(entry_of("P0A-10").unit_of_count == unit{measure::count});
    CHECK(entry_of("P0B-02").unit_of_count == unit{measure::percent, 1, 10});
    for (const char* p : {"P0B-21", "P0B-22"})
        CHECK(entry_of(p).unit_of_count == unit{measure::volt, 1, 100});
    for (const char* p : {"P0B-26", "P0B-40"}) CHECK(entry_of(p).unit_of_count == unit{measure::volt, 1, 10});
    for (const char* p : {"P0B-24", "P0B-38", "P0B-39"})
        CHECK(entry_of(p).unit_of_count == unit{measure::ampere, 1, 100});
    CHECK(entry_of("P0B-55").unit_of_count == unit{measure::r_per_min, 1, 10});
    for (const char* p : {"P05-43", "P0C-14", "P0C-26", "P0C-30"})
        CHECK(entry_of(p).unit_of_count == no_unit);
    for (const char* p : {"P09-24", "P0B-55"}) CHECK_FALSE(entry_of(p).limits.is_stated);
    CHECK(entry_of("P05-15").values.size() == 5);
    CHECK(entry_of("P0B-33").values.size() == 10);
}

TEST_CASE("C630S: every erratum that the test or a header refers to is in errata_c630s.md") {
    const std::string errata = device_file("errata_c630s.md");
    REQUIRE_FALSE(errata.empty());
    const auto check = [&](const std::string& number_of_erratum) {
        CAPTURE(number_of_erratum);
        CHECK(errata.find("| " + number_of_erratum + " |") != std::string::npos);
    };
    for (const correction& c : corrections) check(c.erratum);
    for (const char* name : headers) {
        CAPTURE(name);
        const std::string text = device_file(std::string{"c630s/"} + name + ".hpp");
        REQUIRE_FALSE(text.empty());
        const std::string mark = "[errata ";
        for (std::size_t at = text.find(mark); at != std::string::npos; at = text.find(mark, at + 1)) {
            const std::size_t from = at + mark.size();
            const std::string list = text.substr(from, text.find(']', from) - from);
            for (std::string item : tests::split(list, ',')) {
                if (!item.empty() && item[0] == ' ') item = item.substr(1);
                if (item != "Cn") check(item);
            }
        }
    }
    for (unsigned i = 1; i <= 72; ++i) check("C" + std::to_string(i));
}

TEST_CASE("C630S: the catalogue has 463 registers, 40 of two words, in order, disjoint, each with its own "
          "name") {
    const auto entries = c630s::catalogue.entries;
    CHECK(entries.size() == 463);
    CHECK(is_in_order(entries));
    std::set<u16> firsts;
    for (const printed_row& row : printed_rows()) CHECK(firsts.insert(row.address).second);
    std::set<std::string> names;
    std::size_t pairs = 0;
    for (const entry& e : entries) {
        const std::string name{e.name};
        CAPTURE(name);
        CHECK(firsts.count(e.address) == 1);
        CHECK(names.insert(name).second);
        if (e.words() == 2) {
            ++pairs;
            CHECK(firsts.count(static_cast<u16>(e.address + 1)) == 0);
        }
    }
    CHECK(pairs == 40);
}

TEST_CASE("C630S: arrays are the numbered segments and virtual terminals of the manual, and have its steps") {
    const auto check = [](const auto& rows, unsigned step, const std::string& before,
                          const std::string& behind) {
        CHECK(rows.stride == step);
        CHECK(rows.size == 16);
        for (unsigned i = 0; i < 16; ++i) {
            const std::string name = before + std::to_string(i + 1) + behind;
            CAPTURE(name);
            CHECK(rows[i].address == rows.first.address + i * step);
            CHECK(printed(rows[i].address).name == name);
        }
    };
    check(c630s::position_segment_displacements, 5, "第", "段移动位移");
    check(c630s::position_segment_speeds, 5, "第", "段位移最大运行速度");
    check(c630s::position_segment_acceleration_times, 5, "第", "段位移加减速时间");
    check(c630s::position_segment_wait_times, 5, "第", "段位移完成后等待时间");
    check(c630s::speed_segment_speeds, 3, "第", "段速度指令");
    check(c630s::speed_segment_run_times, 3, "第", "段指令运行时间");
    check(c630s::speed_segment_ramps, 3, "第", "段加减速时间");
    check(c630s::virtual_input_functions, 2, "VDI", "端子功能选择");
    check(c630s::virtual_input_logics, 2, "VDI", "端子逻辑选择");
    check(c630s::virtual_output_functions, 2, "VDO", "端子功能选择");
    check(c630s::virtual_output_logics, 2, "VDO", "端子逻辑选择");
    CHECK(std::string{c630s::catalogue.find("P11-12"_p)->name} == "position_segment_1_displacement");
    CHECK(std::string{c630s::catalogue.find("P12-65"_p)->name} == "speed_segment_16_speed");
    CHECK(std::string{c630s::catalogue.find("P17-31"_p)->name} == "virtual_input_16_logic");
    CHECK(c630s::speed_segment_speeds.first.initial == c630s::speed_segment_defaults[0]);
}

TEST_CASE("C630S: registers are flagged as triggers, as motion or as communication where they are") {
    const std::set<u16> triggers{"P02-31"_p, "P05-30"_p, "P0D-00"_p, "P0D-01"_p, "P0D-02"_p,
                                 "P0D-03"_p, "P0D-05"_p, "P0D-11"_p, "P0D-17"_p, "P0D-18"_p,
                                 "P0D-19"_p, "P0D-20"_p, "P31-00"_p, "P31-04"_p};
    const std::set<u16> movers{"P05-05"_p, "P05-30"_p, "P06-03"_p, "P07-03"_p, "P0D-02"_p,
                               "P0D-03"_p, "P0D-11"_p, "P0D-17"_p, "P0D-18"_p, "P31-00"_p};
    const std::set<u16> line{"P0C-00"_p, "P0C-02"_p, "P0C-03"_p, "P0C-13"_p,
                             "P0C-25"_p, "P0C-26"_p, "P0C-30"_p};
    for (const entry& e : c630s::catalogue.entries) {
        const std::string name{e.name};
        CAPTURE(name);
        CHECK(has(e.flags, trigger) == (triggers.count(e.address) == 1));
        CHECK(has(e.flags, motion) == (movers.count(e.address) == 1));
        CHECK(has(e.flags, communication) == (line.count(e.address) == 1));
    }
}

TEST_CASE("C630S: every name of a value is in its register's range and applies to its own value") {
    for (const entry& e : c630s::catalogue.entries) {
        const std::string name{e.name};
        CAPTURE(name);
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

TEST_CASE("C630S: the profile has the factory settings of the registers") {
    const profile& facts = *c630s::catalogue.device;
    CHECK(std::string{facts.name} == "c630s");
    CHECK(facts.lowest_address == c630s::node_address.limits.low);
    CHECK(facts.highest_address == c630s::node_address.limits.high);
    CHECK(facts.word_order == word_order::unknown);
    CHECK(facts.word_order_register == c630s::pair_word_order.address);
    CHECK(facts.eeprom_switch == c630s::eeprom_update.address);
    CHECK(facts.baud == 57600);
    CHECK(facts.format == character_format::n82);
    CHECK(c630s::rs485_baud_rate.initial == static_cast<int>(c630s::baud_rate::baud_57600));
    CHECK(c630s::data_format.initial == static_cast<int>(c630s::serial_format::n82));
    CHECK(facts.limits.echoes_byte_count);
    CHECK(facts.limits.response > milliseconds(static_cast<std::uint32_t>(c630s::response_delay.initial)));
    CHECK(std::string{facts.meaning(4)} == "refused");
}

TEST_CASE("C630S: the alarms are the 58 of chapter 8, in its order, with its classes and resets") {
    std::vector<std::vector<std::string>> rows;
    for (const std::string& line : tests::manual("c630s_alarms.tsv")) {
        if (line.rfind("code", 0) != 0) rows.push_back(tests::split(line, '\t'));
    }
    REQUIRE(rows.size() == 58);
    REQUIRE(std::size(c630s::alarms) == 58);
    const std::string header = device_file("c630s/alarms.hpp");
    std::set<u16> codes;
    std::set<std::string> names;
    unsigned fixed = 0;
    unsigned faults = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const auto& row = rows[i];
        const c630s::alarm& a = c630s::alarms[i];
        REQUIRE(row.size() == 4);
        CAPTURE(row[0]);
        CHECK(std::stoul(row[0].substr(3), nullptr, 16) == a.code);
        CHECK(row[2] == text(a.kind));
        CHECK(row[3] == (a.is_resettable ? "yes" : "no"));
        CHECK(header.find("// " + row[0] + " " + row[1] + "\n") != std::string::npos);
        CHECK(c630s::find_alarm(a.code) == &a);
        CHECK(codes.insert(a.code).second);
        CHECK(names.insert(a.name).second);
        if (!a.is_resettable) ++fixed;
        if (a.kind == c630s::alarm_class::fault) ++faults;
    }
    CHECK(fixed == 18);
    CHECK(faults == 43);
    const entry& recorded = *c630s::catalogue.find("P0B-34"_p);
    REQUIRE(recorded.values.size() == 59);
    for (const named_value& v : recorded.values) {
        const c630s::alarm* a = c630s::find_alarm(static_cast<u16>(v.value));
        CHECK(std::string{v.name} == (a != nullptr ? a->name : "none"));
    }
}

TEST_CASE(
    "P03-03: an input is active at a low level, a high level, a rising, a falling edge, at both: 0..4") {
    using logic = c630s::input_logic;
    const logic as_printed[] = {logic::low_level, logic::high_level, logic::rising_edge, logic::falling_edge,
                                logic::both_edges};
    for (u16 code = 0; code < 5; ++code) CHECK(static_cast<u16>(as_printed[code]) == code);
    CHECK(static_cast<u16>(c630s::output_logic::low) == 0); // P04-01
    CHECK(static_cast<u16>(c630s::output_logic::high) == 1);
    CHECK(static_cast<u16>(c630s::virtual_input_logic::one) == 0); // P17-01
    CHECK(static_cast<u16>(c630s::virtual_input_logic::rising_edge) == 1);
}

} // namespace map_c630s_tests
