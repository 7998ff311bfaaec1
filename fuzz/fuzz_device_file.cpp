// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Any bytes as a file that describes a device, as the tool reads it. A file is refused with its line, in a line of
// plain text; or its registers are in order and do not contradict themselves, and its map as a file is the same map
// again.
#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "../examples/servobus/device_file/device_file.cpp"
#include "../examples/servobus/device_file/device_form.cpp"
#include "../examples/servobus/device_file/device_names.cpp"
#include "../examples/servobus/device_file/device_profile.cpp"
#include "../examples/servobus/device_file/device_range.cpp"
#include "../examples/servobus/device_file/device_row.cpp"
#include "../examples/servobus/device_file/device_unit.cpp"
#include "../examples/servobus/device_file/map_text.cpp"
#include "../examples/servobus/devices/device.hpp"
#include "../examples/servobus/words/csv.cpp"
#include "../examples/servobus/words/line_settings.cpp"
#include "../examples/servobus/words/nearest.cpp"
#include "../examples/servobus/words/numbers.cpp"
#include "refused_file.hpp"
#include "support.hpp"

using fuzz::require;

namespace {

std::string map_of(const tool::device_file& file) {
    std::string text = tool::profile_lines(*file.tables()[0].device) + tool::map_header(true) + '\n';
    for (const servobus::table t : tool::all_tables) {
        const servobus::catalogue& rows = file.tables()[static_cast<std::size_t>(t)];
        for (const servobus::entry& e : rows.entries) {
            const auto in = e.form != nullptr ? e.form->scale_table : t;
            const char* const by = tool::scaling_name(e, file.tables()[static_cast<std::size_t>(in)].entries);
            text += tool::map_row(e, *rows.device, rows.sentence(e), t, by) + '\n';
        }
    }
    return text;
}

void judge_row(const servobus::entry& e) {
    const servobus::range within = e.limits;
    require(within.low <= within.high, "a range is low to high");
    require(e.initial == servobus::no_default || within.contains(e.initial), "a default is in its range");
    require(e.address + e.words() <= 0x1'0000, "a pair ends inside the addresses");
    require(e.unit_of_count.numerator != 0 && e.unit_of_count.denominator != 0,
            "a scale is no division by 0");
    for (const servobus::named_value& v : e.values)
        require((v.is_whole() || (v.value & ~v.mask) == 0) && v.name[0] != '\0',
                "a name is of bits inside its mask");
    if (e.form == nullptr || e.form->scaled == servobus::scaling::none) return;
    require(!is_text(e) && !is_float(e), "a whole number is scaled");
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    // A buffer of the exact size, without a zero after it.
    const std::vector<char> bytes{data, data + size};
    const std::string_view text{bytes.data(), bytes.size()};
    const auto file = std::make_unique<tool::device_file>();
    const std::string why = file->parse("device.csv", text);
    if (!why.empty()) {
        fuzz::judge_refusal(why, text);
        return 0;
    }
    std::size_t count = 0;
    for (const servobus::catalogue& rows : file->tables()) {
        require(servobus::is_in_order(rows.entries), "rows are in order and do not overlap");
        require(rows.descriptions.empty() || servobus::is_described(rows.entries, rows.descriptions),
                "each row has its sentence");
        for (const servobus::entry& e : rows.entries) judge_row(e);
        count += rows.entries.size();
    }
    require(count != 0, "a device has a row");
    const std::string map = map_of(*file);
    const auto again = std::make_unique<tool::device_file>();
    const std::string why_not = again->parse("device.csv", map);
    require(why_not.empty(), "the map of a file is a file");
    require(map_of(*again) == map, "and its map is the same");
    return 0;
}
