// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What came on a line while it was asked: each byte with its time, and what these bytes are. Nothing that came is left
// out, and nothing else is concluded from.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include <servobus/core/time.hpp>
#include <servobus/modbus/pdu.hpp>

#include "frame_sizes.hpp"
#include "log_line.hpp"

namespace tool {

/// A byte, and how long after its request had left it came; after the begin of listening where nothing was asked.
struct overheard_byte {
    servobus::duration at{};
    std::uint8_t byte = 0;
};

/// A read that was sent as it is, and all that came until the line rested.
struct overheard {
    frame_bytes request{}; ///< empty: the line was listened to
    std::vector<overheard_byte> came{};
    servobus::duration listened{};
};

/// The size that a response to a read has if it begins as `from` does, whatever its CRC; 0 if none begins so.
inline std::size_t begun_response_size(servobus::bytes request, servobus::bytes from) {
    constexpr std::size_t head = 3;
    if (request.size() < min_frame || from.size() < head) return 0;
    if (from[0] != request[0] || from[1] != request[1]) return 0;
    const std::size_t count = servobus::load_word(request, 4);
    const std::size_t data = request[1] < 3 ? (count + 7) / 8 : 2 * count;
    return from[2] == data ? head + data + 2 : 0;
}

/// The size of a response to a read that begins with `from`; 0 if none does.
inline std::size_t response_size_to(servobus::bytes request, servobus::bytes from) {
    constexpr std::size_t of_exception = 5;
    if (request.size() < min_frame || from.size() < of_exception || from[0] != request[0]) return 0;
    if (from[1] == (request[1] | servobus::modbus::exception_flag))
        return is_whole(from, of_exception) ? of_exception : 0;
    const std::size_t size = begun_response_size(request, from);
    return size != 0 && is_whole(from, size) ? size : 0;
}

/// What the bytes of one read are.
struct parsed_read {
    bool is_echoed = false;                      ///< the request itself came first
    std::vector<servobus::duration> responses{}; ///< when each of them began
    servobus::duration pause{};                  ///< the longest inside a response
    std::uint8_t of_gateway = 0;                 ///< its exception number, 0Ah or 0Bh: it got no response
    bool differ = false;                         ///< two of the responses
    frame_bytes others{};                        ///< what is neither
    bool has_bad_crc = false;                    ///< of these: a response but for its CRC
    bool is_cut = false;                         ///< of these: the begin of a response, and no more
};

inline parsed_read parse_overheard(const overheard& of) {
    parsed_read parsed;
    frame_bytes all;
    for (const overheard_byte& b : of.came) all.push_back(b.byte);
    const servobus::bytes came{all};
    std::size_t i = 0;
    if (!of.request.empty() && all.size() >= of.request.size() &&
        std::equal(of.request.begin(), of.request.end(), all.begin())) {
        parsed.is_echoed = true;
        i = of.request.size();
    }
    frame_bytes first;
    while (i < all.size()) {
        const std::size_t size = response_size_to(of.request, came.subspan(i));
        if (size == 0) {
            parsed.others.push_back(all[i++]);
            continue;
        }
        const servobus::bytes response = came.subspan(i, size);
        for (std::size_t k = i + 1; k < i + size; ++k)
            parsed.pause = servobus::longer_of(parsed.pause, of.came[k].at - of.came[k - 1].at);
        if (response[1] != of.request[1] && (response[2] == 0x0A || response[2] == 0x0B)) {
            parsed.of_gateway = response[2];
            i += size;
            continue;
        }
        if (parsed.responses.empty()) first.assign(response.begin(), response.end());
        parsed.differ =
            parsed.differ || !std::equal(response.begin(), response.end(), first.begin(), first.end());
        parsed.responses.push_back(of.came[i].at);
        i += size;
    }
    const servobus::bytes others{parsed.others};
    for (std::size_t at = 0; parsed.responses.empty() && at < others.size(); ++at) {
        const std::size_t size = begun_response_size(of.request, others.subspan(at));
        if (size == 0) continue;
        (size <= others.size() - at ? parsed.has_bad_crc : parsed.is_cut) = true;
        break;
    }
    return parsed;
}

/// How often each thing was heard.
struct line_account {
    unsigned asked = 0;
    unsigned echoed = 0;
    unsigned answered = 0;                  ///< at least one response
    unsigned late = 0;                      ///< of these: it began after the limit
    unsigned doubled = 0;                   ///< more than one response
    unsigned differing = 0;                 ///< of these: two that are unlike
    unsigned damaged = 0;                   ///< bytes, and no response among them
    unsigned bad_crc = 0;                   ///< of these: a response but for its CRC
    unsigned cut = 0;                       ///< of these: the begin of a response
    unsigned of_gateway = 0;                ///< a gateway's exception in place of a response
    std::uint8_t gateway_exception = 0;     ///< its number
    unsigned paused = 0;                    ///< a response with a longer pause inside than the limit
    servobus::duration pause{};             ///< the longest one
    unsigned silent = 0;                    ///< not a byte but for an echo
    unsigned beside = 0;                    ///< bytes beside a response
    std::vector<servobus::duration> took{}; ///< until a response began, in order of length
    frame_bytes unasked{};                  ///< what came while nothing was asked
    servobus::duration listened{};          ///< so long
    frame_bytes strays{};                   ///< all that is no response to what was asked

    /// `limit`: how long a response may take to begin; `longest_pause`: inside it.
    void add(const overheard& of, servobus::duration limit,
             servobus::duration longest_pause = servobus::milliseconds(20)) {
        const parsed_read r = parse_overheard(of);
        const auto count = static_cast<std::size_t>(std::count_if(
            r.others.begin(), r.others.end(), [](std::uint8_t b) { return b != 0 && b != 0xFF; }));
        frame_bytes& kept = of.request.empty() ? unasked : strays;
        constexpr std::size_t most = 4096; // of a line that never rests
        if (count != 0 && kept.size() < most) kept.insert(kept.end(), r.others.begin(), r.others.end());
        if (of.request.empty()) {
            listened = listened + of.listened;
            return;
        }
        ++asked;
        echoed += r.is_echoed;
        answered += !r.responses.empty();
        doubled += r.responses.size() > 1;
        differing += r.differ;
        of_gateway += r.of_gateway != 0;
        if (r.of_gateway != 0) gateway_exception = r.of_gateway;
        paused += longest_pause < r.pause;
        pause = servobus::longer_of(pause, r.pause);
        silent += r.responses.empty() && r.others.empty() && r.of_gateway == 0;
        damaged += r.responses.empty() && !r.others.empty() && r.of_gateway == 0;
        bad_crc += r.has_bad_crc;
        cut += r.is_cut;
        if (!r.responses.empty()) {
            beside += static_cast<unsigned>(count);
            late += limit < r.responses[0];
            took.insert(std::upper_bound(took.begin(), took.end(), r.responses[0]), r.responses[0]);
        }
    }
    /// A response is that to its own request, as far as it was seen.
    bool is_reliable() const { return doubled == 0; }
    servobus::duration least() const { return took.empty() ? servobus::duration{} : took.front(); }
    servobus::duration median() const { return took.empty() ? servobus::duration{} : took[took.size() / 2]; }
    servobus::duration most() const { return took.empty() ? servobus::duration{} : took.back(); }
};

} // namespace tool
