// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Any bytes as a machine file, and as a file of findings, as the tool reads them. A file is refused with its line, in a
// line of plain text, and the readers themselves print nothing; or what it says is of its drives' maps and ranges,
// without a contradiction, and the same file written plainly says the same.
#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <servobus/device/c630s/catalogue.hpp>
#include <servobus/device/c630s/registers.hpp>
#include <servobus/device/yako/closed_loop.hpp>
#include <servobus/device/yako/closed_loop_catalogue.hpp>

#include "../examples/servobus/device_file/map_text.cpp"
#include "../examples/servobus/devices/row_words.cpp"
#include "../examples/servobus/interpretations/findings_file.cpp"
#include "../examples/servobus/machine/machine_file.cpp"
#include "../examples/servobus/registers/chosen.cpp"
#include "../examples/servobus/registers/raw.cpp"
#include "../examples/servobus/registers/written_value.cpp"
#include "../examples/servobus/words/csv.cpp"
#include "../examples/servobus/words/line_settings.cpp"
#include "../examples/servobus/words/nearest.cpp"
#include "../examples/servobus/words/numbers.cpp"
#include "refused_file.hpp"
#include "support.hpp"

using fuzz::require;

namespace {

// Two drives as the tool has them. Two inputs of the stepper may not have one function.
bool excludes(std::uint16_t one, std::uint16_t other) {
    return one >= 0x0041 && one <= 0x0044 && other >= 0x0041 && other <= 0x0044;
}
const tool::device drives[] = {
    {.map = &servobus::yako::closed_loop::catalogue,
     .excludes = excludes,
     .on_line = &servobus::yako::device::on_line,
     .node_register = servobus::yako::closed_loop::node_address.address},
    {.map = &servobus::c630s::catalogue,
     .on_line = &servobus::c630s::device::on_line,
     .node_register = servobus::c630s::node_address.address},
};
constexpr const char* ways[] = {"no", "yes", "marked"};
constexpr tool::interpretation open_places[] = {{"save", ways, "section 3"},
                                                {"by_fault", std::span{ways}.first<2>(), "section 5.2"}};

} // namespace

// What the tool's programs give to the readers.
namespace tool {
const device* find_device(std::string_view word, std::string& why) {
    for (const device& d : drives) {
        if (word == d.facts().name) return &d;
    }
    why = "unknown device " + csv::shown(word);
    return nullptr;
}
int complain(int, const std::string&) {
    require(false, "a reader of files prints nothing");
    return 0;
}
} // namespace tool

namespace {

// The same file without comments, units and names.
std::string plain(const tool::machine_file& file) {
    std::string text = "servobus-machine format=1\n";
    for (const tool::machine_section& s : file.sections()) {
        text += '[' + s.name + "] device=" + s.kind->facts().name + " node=" + std::to_string(s.node);
        if (s.says_rate)
            text += " baud=" + std::to_string(s.baud) + " character_format=" + servobus::text(s.format);
        text += '\n';
        for (const tool::machine_line& l : s.lines) {
            const auto bits = static_cast<std::uint32_t>(bits_of_words(*l.row, l.words));
            char hex[16];
            (void)std::snprintf(hex, sizeof hex, l.row->words() == 1 ? "0x%04X" : "0x%08X",
                                static_cast<unsigned>(l.row->words() == 1 ? bits & 0xFFFFu : bits));
            text += std::string{l.is_required ? "require " : ""} + static_cast<const char*>(l.row->name) +
                    '=' + hex + '\n';
        }
    }
    return text;
}

void judge_section(const tool::machine_section& s, const tool::machine_file& file) {
    const servobus::profile& facts = s.kind->facts();
    require(s.node >= facts.lowest_address && s.node <= facts.highest_address, "a node is one of its drive");
    require(s.baud >= 600 && s.baud <= 4'000'000, "a rate is in its range");
    for (const tool::machine_section& other : file.sections()) {
        if (&other == &s) continue;
        require(other.node != s.node && other.name != s.name, "a node and a name are there once");
        require(other.baud == s.baud && other.format == s.format, "drives of one line share its setting");
    }
    for (const tool::machine_line& l : s.lines) {
        const auto& rows = s.kind->map->entries;
        require(l.row >= &rows.front() && l.row <= &rows.back(), "a row is one of its drive");
        require(l.row->limits.contains(tool::number_of(*l.row, l.words)),
                "a value is in the range of its row");
        require(l.row->rights != servobus::access::wo, "what cannot be read is no parameter");
        require(l.is_required || l.row->rights == servobus::access::rw, "what is set can be written");
        require(!has(l.row->flags, servobus::flag::trigger) && !has(l.row->flags, servobus::flag::motion),
                "a parameter does not act");
        require(std::ranges::count(s.lines, l.row, &tool::machine_line::row) == 1, "a row is there once");
        for (const tool::machine_line& other : s.lines)
            require(&other == &l || s.kind->excludes == nullptr || tool::number_of(*l.row, l.words) == 0 ||
                        l.words != other.words || !excludes(l.row->address, other.row->address),
                    "a function is at one input");
    }
}

bool is_same(const tool::machine_file& a, const tool::machine_file& b) {
    const auto same_line = [](const tool::machine_line& x, const tool::machine_line& y) {
        return x.row == y.row && x.words == y.words && x.is_required == y.is_required;
    };
    return std::ranges::equal(a.sections(), b.sections(), [&](const auto& x, const auto& y) {
        return x.name == y.name && x.kind == y.kind && x.node == y.node && x.baud == y.baud &&
               x.format == y.format && std::ranges::equal(x.lines, y.lines, same_line);
    });
}

void judge_machine(std::string_view text) {
    tool::machine_file file;
    const std::string why = file.parse("machines/press.txt", text);
    if (!why.empty()) return fuzz::judge_refusal(why, text);
    require(!file.sections().empty(), "a machine has a drive");
    for (const tool::machine_section& s : file.sections()) judge_section(s, file);
    tool::machine_file again;
    require(again.parse("machines/press.txt", plain(file)).empty(), "the plain file is a file");
    require(is_same(file, again), "and it says the same");
}

void judge_findings(std::string_view text) {
    tool::findings found{open_places};
    const std::string why = tool::parse_findings(found, "zlac8015d", text);
    if (!why.empty()) return fuzz::judge_refusal(why, text);
    tool::findings again{open_places};
    const std::string written = tool::findings_head(found, "zlac8015d") + tool::finding_lines(found);
    require(tool::parse_findings(again, "zlac8015d", written).empty(), "written findings are a file");
    require(again.firmware == found.firmware, "and have the same firmware");
    for (std::size_t i = 0; i < std::size(open_places); ++i) {
        require(again.way(i) == found.way(i), "and the same ways");
        require(!found.way(i) || *found.way(i) < open_places[i].ways.size(), "a way is one of its place");
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    // A buffer of the exact size, without a zero after it.
    const std::vector<char> bytes{data, data + size};
    const std::string_view text{bytes.data(), bytes.size()};
    judge_machine(text);
    judge_findings(text);
    return 0;
}
