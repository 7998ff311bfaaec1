// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "cpp_profile.hpp"

#include "../words/numbers.hpp"
#include "cpp_names.hpp"

namespace tool::cpp {
namespace {

std::string duration_text(servobus::duration d) {
    if (d.us % 1000 == 0) return "servobus::milliseconds(" + std::to_string(d.us / 1000) + ")";
    return "servobus::duration{" + std::to_string(d.us) + "}";
}

std::string limits_text(const servobus::response_limits& limits) {
    const servobus::response_limits usual{};
    std::string all;
    const auto put = [&](bool is_usual, const std::string& text) {
        if (!is_usual) all += (all.empty() ? "" : ", ") + text;
    };
    put(limits.response.us == usual.response.us, ".response = " + duration_text(limits.response));
    put(limits.turnaround.us == usual.turnaround.us, ".turnaround = " + duration_text(limits.turnaround));
    put(limits.leading_bytes == usual.leading_bytes,
        ".leading_bytes = " + std::to_string(limits.leading_bytes));
    put(limits.corrupted_request == usual.corrupted_request,
        ".corrupted_request = " + std::to_string(limits.corrupted_request));
    put(limits.acknowledge == usual.acknowledge, ".acknowledge = " + std::to_string(limits.acknowledge));
    put(limits.echoes_byte_count == usual.echoes_byte_count, ".echoes_byte_count = true");
    return all;
}

} // namespace

std::string device_class(const servobus::profile& facts) {
    const servobus::profile usual{.name = ""};
    const std::string inside = "\n                                             ";
    std::string all = ".name = " + literal(facts.name);
    const auto put = [&](bool is_usual, const std::string& text) {
        if (!is_usual) all += "," + inside + text;
    };
    const auto number = [&](const char* name, unsigned long value, unsigned long usual_value) {
        put(value == usual_value, std::string{name} + " = " + std::to_string(value));
    };
    number(".max_read", facts.max_read, usual.max_read);
    number(".max_write", facts.max_write, usual.max_write);
    number(".lowest_address", facts.lowest_address, usual.lowest_address);
    number(".highest_address", facts.highest_address, usual.highest_address);
    put(facts.word_order == usual.word_order,
        std::string{".word_order = servobus::word_order::"} +
            (facts.word_order == servobus::word_order::unknown ? "unknown" : "low_first"));
    put(facts.word_order_register == 0, ".word_order_register = " + hex_word(facts.word_order_register));
    put(facts.eeprom_switch == 0, ".eeprom_switch = " + hex_word(facts.eeprom_switch));
    number(".baud", facts.baud, usual.baud);
    constexpr const char* formats[] = {"n81", "n82", "e81", "o81"};
    put(facts.format == usual.format,
        std::string{".format = servobus::character_format::"} + formats[static_cast<unsigned>(facts.format)]);
    const std::string limits = limits_text(facts.limits);
    put(limits.empty(), ".limits = {" + limits + "}");
    put(facts.quarantine.us == usual.quarantine.us, ".quarantine = " + duration_text(facts.quarantine));
    put(facts.gap.us == usual.gap.us, ".gap = " + duration_text(facts.gap));
    number(".read_retries", facts.read_retries, usual.read_retries);
    const bool has_exceptions = facts.exceptions.begin() != facts.exceptions.end();
    put(!has_exceptions, ".exceptions = exceptions");
    constexpr const char* blocks[] = {"none", "registers", "coils", "all"};
    put(facts.writes_blocks_only == usual.writes_blocks_only,
        std::string{".writes_blocks_only = servobus::block_writes::"} +
            blocks[static_cast<unsigned>(facts.writes_blocks_only)]);
    std::string out = "struct device {\n";
    if (has_exceptions) {
        out += "    static constexpr servobus::exception_meaning exceptions[] = {\n";
        for (const servobus::exception_meaning& e : facts.exceptions)
            out += "        {" + std::to_string(e.number) + ", " + literal(e.words) + "},\n";
        out += "    };\n";
    }
    return out + "    static constexpr servobus::profile facts{" + all + "};\n};\n";
}

} // namespace tool::cpp
