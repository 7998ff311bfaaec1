// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Advice about faults: every alarm and fault bit has one, in short ASCII text, with its source beside it. What the
// advice about a C630S alarm names (parameters, numbers, parts) is in the manual's text,
// tests/manuals/c630s_remedies.tsv, or in an erratum.
#include <doctest/doctest.h>

#include <cstddef>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <servobus/device/c630s/advice.hpp>
#include <servobus/device/yako/advice.hpp>
#include <servobus/device/zlac8015d/advice.hpp>
#include <servobus/device/zlac8015d/catalogue.hpp>

#include <tests/support/manual.hpp>

namespace advice_tests {

using namespace servobus;

// Whole texts, as programs show them.
static_assert(c630s::advice_for(0x0000).cause == no_fault_advice.cause);
static_assert(c630s::advice_for(0x0999).cause == not_in_manual);
static_assert(zlac8015d::advice_for(zlac8015d::faults{}).cause == no_fault_advice.cause);
static_assert(zlac8015d::advice_for(zlac8015d::faults{0x1000}).cause == not_in_manual);
static_assert(zlac8015d::advice_for(zlac8015d::faults{0x2804}).cause ==
              zlac8015d::advice_for(zlac8015d::fault::overcurrent).cause);
static_assert(yako::advice_for(0).cause == no_fault_advice.cause);
static_assert(yako::advice_for(yako::motion_status{}).cause == no_fault_advice.cause);

std::string device_file(const std::string& name) {
    const std::string here = __FILE__;
    std::ifstream file{here.substr(0, here.find_last_of('/') + 1) + "../../../include/servobus/device/" +
                       name};
    return {std::istreambuf_iterator<char>{file}, {}};
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

/// Runs of letters and digits, with the points and hyphens inside them: `P02-31`, `3.0`, `FunIN.34`.
std::vector<std::string> words_of(const std::string& text) {
    std::vector<std::string> words;
    std::string word;
    for (const char c : text + ' ') {
        if (is_letter(c) || is_digit(c) || ((c == '.' || c == '-') && !word.empty())) {
            word += c;
            continue;
        }
        while (!word.empty() && (word.back() == '.' || word.back() == '-')) word.pop_back();
        if (!word.empty()) words.push_back(word);
        word.clear();
    }
    return words;
}

void check_style(const char* text, std::size_t most_words) {
    REQUIRE(text != nullptr);
    const std::string all = text;
    CAPTURE(all);
    REQUIRE_FALSE(all.empty());
    for (const char c : all) {
        CHECK(c >= ' ');
        CHECK(c <= '~');
        CHECK(c != '"');
    }
    CHECK(words_of(all).size() <= most_words);
    CHECK(all.back() == '.');
    CHECK(all[0] >= 'A');
    CHECK(all[0] <= 'Z');
    CHECK(all.find("  ") == std::string::npos);
}

void check_style(const advice& a) {
    check_style(a.cause, 25);
    check_style(a.remedy, 25);
    check_style(a.reset, 30);
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// A part that the advice may name only where the manual names it, in one of two ways.
struct named {
    const char* english;
    const char* printed;
    const char* otherwise = printed;
};

constexpr named parts[] = {
    {"eplace the drive", "更换驱动器"},
    {"eplace the motor", "更换电机"},
    {"eplace motor", "更换电机"},
    {"elf-learning", "自学习"},
    {"P02-31", "初始化"},
    {"ncoder cable", "编码器线"},
    {"power off and on", "重新上电", "接通电源"},
    {"raking resist", "制动电阻"},
    {"hield", "屏蔽"},
    {"ground", "接地", "对地"},
    {"battery", "电池"},
    {"load", "负载", "空载"},
    {"without load", "空载"},
    {"ramps", "加减速"},
    {" gains", "增益"},
    {"stalled", "堵转"},
    {"nterference", "干扰"},
    {" brake", "抱闸"},
    {"service", "售后人员"},
    {"virtual", "VDI", "虚拟"},
    {"nalogue", "AI", "模拟"},
    {"EEPROM", "EEPROM"},
    {"MCU", "MCU"},
    {"U V W", "U V W", "UVW"},
    {"motor cable", "电机线", "电机动力线"},
    {"tabilise the", "稳压器"},
    {"ulti-turn", "多圈"},
    {"ome", "原点", "多"}, // home; some
    {"mains", "电网", "电源"},
    {"winding", "线圈"},
    {"encoder type", "编码器类型"},
    {"motor model", "电机型号"},
    {"DI", "DI"},
    {"DO", "DO"},
};

/// What the advice names and the manual's row does not: the errata say why.
struct exception_of_row {
    u16 code;
    const char* word;
    const char* erratum;
};
constexpr exception_of_row exceptions[] = {
    {0x610, "P0B-12", "C63"},
    {0x620, "P0B-12", "C63"}, // printed PB-02
    {0x920, "P02-21", "C65"},
    {0x920, "P02-27", "C60"}, // printed P2-27
};

bool is_excepted(u16 code, const std::string& word) {
    for (const exception_of_row& e : exceptions) {
        if (e.code == code && word == e.word) return true;
    }
    return word == "P02-31"; // 5.2.3; `parts` allows it where the row says "initialise"
}

TEST_CASE("C630S: the advice about each of the 58 alarms names what chapter 8 names, or an erratum") {
    std::vector<std::string> names;
    for (const std::string& line : tests::manual("c630s_alarms.tsv"))
        names.push_back(tests::split(line, '\t')[1]);
    const std::vector<std::string> rows = tests::manual("c630s_remedies.tsv");
    REQUIRE(rows.size() == std::size(c630s::alarms) + 1);
    REQUIRE(names.size() == rows.size());
    REQUIRE(std::size(c630s::detail::advice_table) == std::size(c630s::alarms));
    const std::string header = device_file("c630s/advice.hpp");
    unsigned unstated = 0;
    for (std::size_t i = 0; i < std::size(c630s::alarms); ++i) {
        const c630s::alarm& a = c630s::alarms[i];
        const std::vector<std::string> row = tests::split(rows[i + 1], '\t');
        const std::string& code = row[0];
        CAPTURE(code);
        REQUIRE(row.size() == 2);
        REQUIRE(std::stoul(code.substr(3), nullptr, 16) == a.code);
        REQUIRE(c630s::detail::advice_table[i].code == a.code);
        const advice what = c630s::advice_for(a.code);
        check_style(what);
        const std::string section = a.kind == c630s::alarm_class::fault ? "8.1.1" : "8.1.2";
        const std::string place = "{0x" + code.substr(3) + ", // " + section + " Er.";
        CHECK(has(header, place));
        CHECK(has(header.substr(header.find(place), 60), code));
        if (what.cause == not_in_manual || what.remedy == not_in_manual) ++unstated;

        const std::string printed = names[i + 1] + row[1];
        const std::string said = std::string{what.cause} + ' ' + what.remedy;
        for (const named& part : parts) {
            const std::string english = part.english;
            CAPTURE(english);
            if (has(said, part.english)) CHECK((has(printed, part.printed) || has(printed, part.otherwise)));
        }
        for (const std::string& word : words_of(said)) {
            bool has_number = false;
            for (const char c : word) has_number = has_number || is_digit(c);
            if (has_number && !is_excepted(a.code, word)) CHECK_MESSAGE(has(printed, word), word);
        }
    }
    CHECK(unstated == 4); // Er.111 has no cause; Er.922, Er.950 and Er.952 no remedy
    for (const exception_of_row& e : exceptions) {
        const advice what = c630s::advice_for(e.code);
        CHECK(has(std::string{what.cause} + what.remedy, e.word));
        CHECK(tests::has_erratum("errata_c630s.md", e.erratum));
    }
}

TEST_CASE("C630S: an alarm is reset as chapter 8 and 5.2.4 say, the encoder's by P0D-20 first") {
    std::set<u16> by_power;
    std::set<u16> by_encoder_reset;
    for (const c630s::alarm& a : c630s::alarms) {
        CAPTURE(a.code);
        const std::string reset = c630s::advice_for(a.code).reset;
        const std::size_t encoder = reset.find("P0D-20 to 2");
        const std::size_t fault = reset.find("P0D-01 to 1");
        if (encoder != std::string::npos) {
            by_encoder_reset.insert(a.code);
            CHECK(encoder < fault);
        }
        CHECK((fault != std::string::npos) == a.is_resettable);
        if (has(reset, "power off and on")) by_power.insert(a.code);
        const bool is_off_first = has(reset, "Switch the servo off");
        CHECK(is_off_first == (a.is_resettable && a.kind == c630s::alarm_class::fault));
    }
    CHECK(by_encoder_reset == std::set<u16>{0x731, 0x733, 0x735});
    CHECK(by_power.size() == 20); // 18 by power alone, and Er.733, Er.735
    CHECK(by_power.count(0x733) == 1);
    CHECK(by_power.count(0x735) == 1);
    CHECK(has(c630s::advice_for(0x601).remedy, "P05-35"));
    CHECK_FALSE(has(c630s::advice_for(0x601).remedy, "P05-34"));
}

TEST_CASE("ZLAC8015D: each of the 13 fault bits has its name, its advice, and the manual's words beside it") {
    using zlac8015d::fault;
    struct {
        unsigned bit;
        const char* printed;
    } const table[] = {
        {0x0001, "过压"},         {0x0002, "欠压"},         {0x0004, "过流"},
        {0x0008, "过载"},         {0x0010, "电流超差"},     {0x0020, "编码器超差"},
        {0x0040, "速度超差"},     {0x0080, "参考电压出错"}, {0x0100, "EEPROM 读写错误"},
        {0x0200, "霍尔出错"},     {0x0400, "电机温度过高"}, {0x0800, "编码器错误"},
        {0x2000, "速度给定错误"},
    };
    REQUIRE(std::size(zlac8015d::all_faults) == 13);
    REQUIRE(std::size(table) == 13);
    const std::string header = device_file("zlac8015d/advice.hpp");
    const entry& row = *zlac8015d::catalogue.find(0x20A5);
    std::set<std::string> names;
    for (std::size_t i = 0; i < 13; ++i) {
        const fault f = zlac8015d::all_faults[i];
        const auto bit = static_cast<u16>(table[i].bit);
        CAPTURE(table[i].bit);
        CHECK(static_cast<u16>(f) == bit);
        CHECK(zlac8015d::faults{bit}.first() == f);
        CHECK(zlac8015d::faults{static_cast<u16>(0xFFFFu - bit + 1u)}.first() == f);
        CHECK(names.insert(text(f)).second);
        bool is_named = false;
        for (const named_value& v : row.values)
            is_named = is_named || (v.mask == bit && v.name == std::string{text(f)});
        CHECK(is_named);
        const std::string source = "// 3.5 0x" + tests::in_hex(bit).substr(0, 4) + ' ' + table[i].printed;
        CHECK(has(header, source));
        const advice what = zlac8015d::advice_for(f);
        check_style(what);
        CHECK(what.cause == zlac8015d::detail::advice_table[i].cause);
        CHECK(what.cause != not_in_manual);
        CHECK(has(what.reset, "06h to 200Eh"));
        CHECK(has(what.remedy, f == fault::speed_command ? "rated speed" : "manual does not say"));
        for (const std::string& word : words_of(what.cause)) { // registers exist, and the comment names them
            if (word.size() != 5 || word[0] != '2' || word.back() != 'h') continue;
            CHECK(zlac8015d::catalogue.find(static_cast<u16>(tests::number(word).value())) != nullptr);
            CHECK(has(header.substr(header.find(source), 90), word));
        }
    }
    check_style(zlac8015d::advice_for(fault{0x1000}));
    CHECK(text(fault::none) == std::string{"none"});
    CHECK(text(fault{0x1000}) == std::string{"unlisted fault"});
}

TEST_CASE("YAKO: every error code and the alarm bit have the one advice that the manual gives") {
    for (unsigned code = 1; code <= 5; ++code) {
        const advice what = yako::advice_for(static_cast<u16>(code));
        check_style(what);
        CHECK(has(what.cause, "manual does not list"));
        CHECK(what.remedy == not_in_manual);
        CHECK(has(what.reset, "0021h to 002Dh"));
    }
    CHECK(std::string_view{yako::advice_for(yako::motion_status::from_word(0x0008)).cause} ==
          yako::advice_for(1).cause);
    CHECK(std::string_view{yako::advice_for(yako::motion_status::from_word(0xFFF7)).cause} ==
          no_fault_advice.cause);
    check_style(no_fault_advice);
    check_style(zlac8015d::advice_for(drive_state::needs_power_cycle));
    CHECK(std::string_view{zlac8015d::advice_for(drive_state::disabled).cause} == no_fault_advice.cause);
}

TEST_CASE("no fault needs no advice, an unknown one has none, and of several faults the first has it") {
    u16 none = 0, unknown = 0x0999;
    CHECK(std::string_view{c630s::advice_for(none).cause} == no_fault_advice.cause);
    CHECK(std::string_view{c630s::advice_for(unknown).cause} == not_in_manual);
    CHECK(std::string_view{yako::advice_for(none).cause} == no_fault_advice.cause);
    using zlac8015d::fault, zlac8015d::faults;
    CHECK(std::string_view{zlac8015d::advice_for(faults{none}).cause} == no_fault_advice.cause);
    CHECK(std::string_view{zlac8015d::advice_for(faults{0x2804}).cause} ==
          zlac8015d::advice_for(fault::overcurrent).cause);
}

TEST_CASE("every erratum that the advice refers to is in the list") {
    for (const char* device : {"c630s", "yako", "zlac8015d"}) {
        const std::string header = device_file(std::string{device} + "/advice.hpp");
        REQUIRE_FALSE(header.empty());
        const std::string list = device == std::string{"c630s"} ? "errata_c630s.md" : "errata.md";
        const std::string mark = "[errata ";
        for (std::size_t at = header.find(mark); at != std::string::npos; at = header.find(mark, at + 1)) {
            const std::size_t end = header.find(']', at);
            for (const std::string& number :
                 words_of(header.substr(at + mark.size(), end - at - mark.size()))) {
                CAPTURE(number);
                if (is_digit(number.back())) CHECK(tests::has_erratum(list, number));
            }
        }
    }
}

} // namespace advice_tests
