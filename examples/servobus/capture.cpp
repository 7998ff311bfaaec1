// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "capture.hpp"

namespace tool {
namespace {

using servobus::direction;

bool is_separator(char c) { return c == ' ' || c == '\t' || c == '\r' || c == ',' || c == ':'; }

// A frame without a direction that repeats the last request is most likely its response. A request that is not
// well-formed is one too if its CRC is right: the device responds to it.
bool is_new_request(const servobus::explanation& e, direction way, const frame_bytes& frame,
                    const frame_bytes& before) {
    if (way == direction::response) return false;
    if (way == direction::request) return bool{servobus::modbus::open_frame(frame)};
    return e.is_valid() && (e.way == direction::request || (e.way == direction::unknown && frame != before));
}

constexpr servobus::catalogue no_map{&any_device::facts, {}};

} // namespace

// Pairs of hex digits; blanks, commas or colons may part the bytes, and 0x may stand before each.
std::optional<captured> parse_captured(std::string_view line) {
    captured c;
    if (line.starts_with('>') || line.starts_with('<')) {
        c.way = line[0] == '>' ? direction::request : direction::response;
        line.remove_prefix(1);
    }
    while (!line.empty()) {
        if (is_separator(line[0])) {
            line.remove_prefix(1);
            continue;
        }
        if (line.starts_with("0x") || line.starts_with("0X")) line.remove_prefix(2);
        if (line.size() < 2) return std::nullopt;
        const std::uint8_t high = servobus::hex_digit(line[0]);
        const std::uint8_t low = servobus::hex_digit(line[1]);
        if (high > 15 || low > 15) return std::nullopt;
        c.frame.push_back(static_cast<std::uint8_t>(high << 4 | low));
        line.remove_prefix(2);
    }
    if (c.frame.empty()) return std::nullopt;
    return c;
}

std::string hex_text(servobus::bytes data) {
    constexpr char digits[] = "0123456789ABCDEF";
    std::string text;
    for (const std::uint8_t byte : data) {
        if (!text.empty()) text += ' ';
        text += digits[byte >> 4];
        text += digits[byte & 0xFu];
    }
    return text;
}

std::string line_of(const captured& c) {
    const char* arrow = c.way == direction::unknown ? "" : c.way == direction::request ? "> " : "< ";
    return arrow + hex_text(c.frame);
}

std::optional<line_devices> line_devices::parse(std::span<const std::string> words) {
    line_devices all;
    std::array<bool, 256> is_named{};
    bool has_others = false;
    const device* others = nullptr;
    for (const std::string& word : words) {
        const std::optional<target> one = parse_target(word);
        if (!one) return std::nullopt;
        if (&word == words.data()) all.first_ = *one;
        all.longest_response_ = longer_of(all.longest_response_, one->facts().limits.response);
        const bool has_node = word.find(':') != word.npos;
        if (has_node ? is_named[one->node] : has_others) {
            complain(usage, has_node ? "two devices at address " + std::to_string(one->node)
                                     : "two devices for the addresses that are not named");
            return std::nullopt;
        }
        if (has_node) {
            is_named[one->node] = true;
            all.by_address_[one->node] = one->kind;
        } else {
            has_others = true;
            others = one->kind;
        }
    }
    for (std::size_t i = 0; i < is_named.size(); ++i) {
        if (!is_named[i]) all.by_address_[i] = others;
    }
    if (!has_others) all.by_address_[servobus::modbus::broadcast] = all.first_.kind;
    return all;
}

const servobus::catalogue& line_devices::map_of(std::uint8_t node_address) const {
    const device* at = by_address_[node_address];
    return at != nullptr ? *at->map : no_map;
}

frame_explainer::explained frame_explainer::explain(const captured& c) {
    char text[16384]; // 125 registers with their names
    const std::uint8_t node_address = c.frame.empty() ? std::uint8_t{0} : c.frame[0];
    const servobus::explanation e =
        servobus::explain(devices_->map_of(node_address), c.way, c.frame, last_request_, text);
    if (is_new_request(e, c.way, c.frame, last_request_)) last_request_ = c.frame;
    return {std::string{text, e.size}, e.is_valid()};
}

} // namespace tool
