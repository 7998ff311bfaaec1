// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Parses lines of hex as Modbus programs log them, and finds the frames in their bytes. Forms that are known:
//
//     > 01 03 00 00 00 02 C4 0B      010300000002C40B        0x1 0x3 0x0 0x0 0x0 0x2 0xc4 0xb
//     >>> 01:03:00:00:00:02:C4:0B    01.03.00.00.00.02.C4.0B (8)       01-03-00-00-00-02-C4-0B
//     [01][03][00][00][00][02][C4][0B]      <01><03><04>...      <Buffer 01 03 00 00 00 02 c4 0b>
//     Tx:000001-01 03 00 00 00 02 C4 0B      # a comment
//
// A time in front is skipped, a label if a whole frame follows it, and words after whole frames. A line may have
// several frames, and noise before and after a frame: what a serial port gave in one read. Bytes without an RTU frame
// may be frames of Modbus TCP (tcp_frames.hpp).
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include <servobus/explain/explain.hpp>

#include "frame_sizes.hpp"
#include "tcp_frames.hpp"

namespace tool {

using frame_bytes = std::vector<std::uint8_t>;

struct captured {
    servobus::direction way = servobus::direction::unknown;
    frame_bytes frame;
    /// The direction if a client has written the log: the mark says only "sent" or "received".
    servobus::direction of_client = servobus::direction::unknown;
};

/// A frame of a line, and the bytes before it that belong to none.
struct found_frame {
    frame_bytes noise;
    frame_bytes frame;
};

/// The frames of a line in their order, and the bytes after the last one.
struct found_frames {
    std::vector<found_frame> frames{};
    frame_bytes noise{};

    /// The number of bytes that belong to no frame.
    std::size_t left_over() const {
        std::size_t sum = noise.size();
        for (const found_frame& f : frames) sum += f.noise.size();
        return sum;
    }
};

namespace log_line {

using servobus::direction;

inline bool is_hex(char c) { return servobus::hex_digit(c) <= 15; }
inline bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
inline bool is_digit(char c) { return c >= '0' && c <= '9'; }
inline bool is_separator(char c) {
    return std::string_view{" \t\r,;:.-_=|[](){}<>\"'"}.find(c) != std::string_view::npos;
}

inline std::string_view trimmed(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(" \t\r");
    return begin == text.npos ? std::string_view{}
                              : text.substr(begin, text.find_last_not_of(" \t\r") + 1 - begin);
}

/// Bytes in hex between separators, each with two digits, or with one or two after 0x or \x: those before the first
/// word that is no hex. `is_all`: there is none.
struct hex_run {
    frame_bytes bytes{};
    bool is_all = true;
};
inline hex_run hex_run_of(std::string_view text) {
    frame_bytes all;
    std::size_t whole_words = 0; // bytes of words that are hex to their ends
    const auto ended_by_other = [&]() -> hex_run {
        all.resize(whole_words);
        return {std::move(all), false};
    };
    while (!text.empty()) {
        if (is_separator(text[0])) {
            whole_words = all.size();
            text.remove_prefix(1);
            continue;
        }
        const bool has_prefix = text.starts_with("0x") || text.starts_with("0X") || text.starts_with("\\x");
        if (has_prefix) text.remove_prefix(2);
        if (text.empty() || !is_hex(text[0])) return ended_by_other();
        const bool has_two = text.size() >= 2 && is_hex(text[1]);
        if (!has_two && !has_prefix) return ended_by_other();
        const unsigned high = has_two ? servobus::hex_digit(text[0]) : 0u;
        const unsigned low = servobus::hex_digit(text[has_two ? 1 : 0]);
        all.push_back(static_cast<std::uint8_t>(high << 4 | low));
        text.remove_prefix(has_two ? 2 : 1);
        const bool ends = text.empty() || is_separator(text[0]) || text[0] == '\\' || is_hex(text[0]);
        if (!ends) return ended_by_other();
    }
    return {std::move(all), true};
}

/// `(8)`, the number of bytes, at the end of a line.
inline std::string_view without_count(std::string_view text) {
    const std::size_t open = text.rfind('(');
    if (open == text.npos || !text.ends_with(')')) return text;
    const std::string_view digits = text.substr(open + 1, text.size() - open - 2);
    return !digits.empty() && std::ranges::all_of(digits, is_digit) ? trimmed(text.substr(0, open)) : text;
}

/// `Tx:000001-`, `RX: `: sent or received, with a number.
inline std::string_view without_label(std::string_view text, captured& c) {
    const auto has = [&](char first) {
        return text.size() > 2 && (text[0] | 0x20) == first && (text[1] | 0x20) == 'x' && !is_hex(text[2]) &&
               !is_letter(text[2]);
    };
    if (!has('t') && !has('r')) return text;
    c.of_client = has('t') ? direction::request : direction::response;
    text = text.substr(std::min(text.find_first_not_of(" :", 2), text.size()));
    const std::size_t digits = std::min(text.find_first_not_of("0123456789"), text.size());
    return digits < text.size() && digits > 2 && text[digits] == '-' ? text.substr(digits + 1) : text;
}

/// The marks of a direction in front of the bytes.
inline std::string_view without_mark(std::string_view text, captured& c) {
    text.remove_prefix(std::min(text.find_first_not_of(" \t-=|:]"), text.size()));
    if (text.starts_with("<Buffer")) return text.substr(7);
    const bool is_in_brackets = text.size() >= 4 && is_hex(text[1]) && is_hex(text[2]);
    if (is_in_brackets && text[0] == '[' && text[3] == ']') c.of_client = direction::request;
    if (is_in_brackets && text[0] == '<' && text[3] == '>') {
        c.of_client = direction::response;
        return text;
    }
    if (text.starts_with('>') || text.starts_with('<')) {
        const std::size_t arrows = std::min(text.find_first_not_of(text[0]), text.size());
        const direction way = text[0] == '>' ? direction::request : direction::response;
        (arrows == 1 ? c.way : c.of_client) = way;
        return text.substr(arrows);
    }
    return without_label(text, c);
}

/// `2026-01-02T03:04:05.678Z`, `[03:04:05]`: a time in front of the bytes.
inline std::string_view without_time(std::string_view text) {
    const auto matches = [](std::string_view s, std::string_view form) {
        return s.size() >= form.size() && std::equal(form.begin(), form.end(), s.begin(), [](char f, char c) {
                   return f == '0' ? is_digit(c) : f == c;
               });
    };
    std::string_view rest = text.substr(text.starts_with('[') ? 1 : 0);
    if (matches(rest, "0000-00-00T") || matches(rest, "0000-00-00 ")) rest.remove_prefix(11);
    if (!matches(rest, "00:00:00")) return text;
    rest.remove_prefix(8);
    if (rest.starts_with('.') || rest.starts_with(','))
        rest.remove_prefix(std::min(rest.find_first_not_of("0123456789", 1), rest.size()));
    if (rest.starts_with('Z')) rest.remove_prefix(1);
    if (rest.starts_with(']')) return trimmed(rest.substr(1));
    return rest.starts_with(' ') || rest.starts_with('\t') ? trimmed(rest) : text;
}

/// The line without its comment.
inline std::string_view without_comment(std::string_view line) {
    return trimmed(line.substr(0, line.find('#')));
}

/// The bytes with which `text` begins, after the marks of a direction.
struct parsed_run {
    captured line{};
    bool is_all = false;
};
inline std::optional<parsed_run> parse_bytes(std::string_view text) {
    parsed_run p;
    hex_run run = hex_run_of(without_mark(text, p.line));
    if (run.bytes.empty()) return std::nullopt;
    p.line.frame = std::move(run.bytes);
    p.is_all = run.is_all;
    return p;
}

/// The length of the frame that begins with `from`, of a function with known lengths; 0 if none begins there.
inline std::size_t size_at(servobus::bytes from, servobus::bytes request) {
    if (from.size() < min_frame) return 0;
    std::size_t asks = request_size(from);
    std::size_t answers = response_size(from);
    if (!is_whole(from, asks) || !servobus::is_request(pdu_of(from, asks))) asks = 0;
    const bool is_broadcast = from[0] == servobus::modbus::broadcast;
    if (!is_whole(from, answers) || is_broadcast || !servobus::is_response(pdu_of(from, answers)))
        answers = 0;
    if (asks == 0 || answers == 0) return std::max(asks, answers);
    if (request.size() >= min_frame && from[0] == request[0] && from[1] == request[1]) return answers;
    // Zeros after a frame keep its CRC right.
    const std::size_t shorter = std::min(asks, answers);
    const std::size_t longer = std::max(asks, answers);
    const servobus::bytes more = from.subspan(shorter, longer - shorter);
    return std::all_of(more.begin(), more.end(), [](std::uint8_t b) { return b == 0; }) ? shorter : longer;
}

/// True for bytes that a line gives while no driver is enabled.
inline bool is_idle_line(servobus::bytes some) {
    return std::all_of(some.begin(), some.end(), [](std::uint8_t b) { return b == 0 || b == 0xFF; });
}

/// True if bytes with a right CRC begin there.
inline bool may_begin_frame(servobus::bytes from) {
    for (std::size_t size = min_frame; size <= from.size() && size <= max_frame; ++size) {
        if (is_whole(from, size)) return true;
    }
    return false;
}

/// The same for a function without a known length: its CRC is right, and after it the bytes end, another frame may
/// begin, or the line is idle.
inline std::size_t unknown_size_at(servobus::bytes from) {
    if (from.size() < min_frame || from[1] == 0) return 0;
    if (is_whole(from, from.size())) return from.size();
    if (request_size(from) != 0 || (from[1] & servobus::modbus::exception_flag) != 0) return 0;
    for (std::size_t size = min_frame; size < from.size() && size <= max_frame; ++size) {
        if (!is_whole(from, size)) continue;
        const servobus::bytes rest = from.subspan(size);
        if (is_idle_line(rest) || may_begin_frame(rest)) return size;
    }
    return 0;
}

/// The frames in `all`. `request`: the one before them, to which the first may be a response.
inline found_frames find_frames(servobus::bytes all, servobus::bytes request = {}) {
    found_frames found;
    servobus::bytes noise = all.first(0);
    while (!all.empty()) {
        std::size_t size = size_at(all, request);
        if (size == 0 && is_idle_line(noise)) size = unknown_size_at(all); // which follows no other noise
        if (size == 0) {
            noise = servobus::bytes{noise.data(), noise.size() + 1};
            all = all.subspan(1);
            continue;
        }
        const servobus::bytes frame = all.first(size);
        found.frames.push_back({{noise.begin(), noise.end()}, {frame.begin(), frame.end()}});
        request = frame;
        all = all.subspan(size);
        noise = all.first(0);
    }
    found.noise.assign(noise.begin(), noise.end());
    return found;
}

/// True if the bytes are frames and nothing else.
inline bool are_frames(servobus::bytes all) {
    const found_frames found = find_frames(all);
    return found.frames.empty() ? !tcp_frames_of(all).empty() : found.left_over() == 0;
}

} // namespace log_line

/// Parses a line. Nothing for one that has no bytes in hex.
inline std::optional<captured> parse_captured(std::string_view line) {
    const std::string_view text =
        log_line::without_time(log_line::without_count(log_line::without_comment(line)));
    std::optional<log_line::parsed_run> first = log_line::parse_bytes(text);
    if (first && (first->is_all || log_line::are_frames(first->line.frame))) return first->line;
    // A label may be in front, and more words behind. It ends at a separator, and a whole frame follows it.
    constexpr std::size_t longest_label = 64;
    for (std::size_t i = 1; i < text.size() && i < longest_label; ++i) {
        if (!log_line::is_separator(text[i - 1])) continue;
        const std::optional<log_line::parsed_run> p = log_line::parse_bytes(text.substr(i));
        if (!p) continue;
        const bool has_frame = p->is_all && !log_line::find_frames(p->line.frame).frames.empty();
        if (has_frame || log_line::are_frames(p->line.frame)) return p->line;
    }
    return std::nullopt;
}

} // namespace tool
