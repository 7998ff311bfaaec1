// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Explains any bytes, with any bytes as the frame before them, with the catalogue of every device. The text
// stays in its buffer and is plain ASCII, a smaller buffer only cuts its end, and it is valid exactly where
// the reference finds the frame valid.
#include <array>
#include <cstdint>
#include <string_view>

#include <servobus/device/c630s/catalogue.hpp>
#include <servobus/device/yako/closed_loop_catalogue.hpp>
#include <servobus/device/yako/open_loop_catalogue.hpp>
#include <servobus/device/zlac8015d/catalogue.hpp>
#include <servobus/explain/explain.hpp>

#include "../tests/support/functions_reference.hpp"
#include "reference.hpp"
#include "support.hpp"

using namespace servobus;
using fuzz::require;

namespace {

constexpr std::array<const servobus::catalogue*, 4> maps{&zlac8015d::catalogue, &yako::closed_loop::catalogue,
                                                         &yako::open_loop::catalogue, &c630s::catalogue};

// Frames whose content is not explained: any data is valid.
bool is_of_unknown_function(const reference::byte_list& pdu) {
    const unsigned code = pdu[0];
    if (code == 0 || code >= 0x80) return false;
    if (code == 43) return pdu.size() > 1 && pdu[1] != 14;
    if (code == 8) {
        const unsigned sub = pdu.size() > 4 ? reference::word(pdu, 1) : 0;
        return sub > 20 || (sub > 4 && sub < 10) || sub == 19;
    }
    return functions_reference::forms().count(code) == 0;
}

// A response of a function beyond registers is valid if a request exists that it answers.
bool is_response_to_any(const fuzz::byte_list& pdu) {
    using fuzz::byte_list;
    const auto answers = [&](const byte_list& asked) {
        return functions_reference::exception_of(asked) == 0 &&
               functions_reference::judge(asked, pdu) == functions_reference::verdict::valid;
    };
    const std::uint8_t code = pdu[0];
    const auto second = static_cast<std::uint8_t>(pdu.size() > 1 ? pdu[1] : 0);
    switch (code) {
    case 1:
    case 2: {
        const unsigned bits = second * 8u;
        return answers({code, 0, 0, static_cast<std::uint8_t>(bits >> 8), static_cast<std::uint8_t>(bits)});
    }
    case 23: return answers({code, 0, 0, 0, static_cast<std::uint8_t>(second / 2), 0, 0, 0, 1, 2, 0, 0});
    case 5:
    case 22: return answers(pdu);
    case 8: {
        byte_list zero = pdu;
        if (zero.size() == 5) zero[3] = zero[4] = 0;
        return answers(pdu) || answers(zero);
    }
    case 15: {
        if (pdu.size() != 5) return false;
        byte_list asked = pdu;
        const unsigned count = (reference::word(pdu, 3) + 7) / 8;
        if (count > 246) return false;
        asked.push_back(static_cast<std::uint8_t>(count));
        asked.resize(6 + count);
        return answers(asked);
    }
    case 24: return answers({code, 0, 0});
    case 43: return pdu.size() > 7 && answers({code, 14, pdu[2], pdu[7]});
    default: return answers({code});
    }
}

bool is_valid(const reference::byte_list& f, direction way) {
    if (!reference::is_frame(f)) return false;
    const reference::byte_list pdu{f.begin() + 1, f.end() - 2};
    const fuzz::byte_list same{pdu.begin(), pdu.end()};
    if (is_of_unknown_function(pdu)) return true;
    const unsigned code = pdu[0];
    const bool is_of_registers = code == 3 || code == 4 || code == 6 || code == 16 || code >= 0x80;
    const bool writes_coil = code == 5 && pdu.size() == 5; // any value: there are relay modules that toggle
    const bool is_request = writes_coil       ? true
                            : is_of_registers ? reference::request(pdu).has_value()
                                              : functions_reference::exception_of(same) == 0;
    const bool is_response = writes_coil       ? true
                             : is_of_registers ? reference::is_response(pdu)
                                               : is_response_to_any(same);
    const bool asks = is_request && way != direction::response;
    const bool answers = is_response && way != direction::request && f[0] != 0;
    const bool may_be_broadcast =
        code == 5 || code == 6 || code == 8 || code == 15 || code == 16 || code == 22;
    return answers || (asks && (f[0] != 0 || may_be_broadcast));
}

reference::byte_list frame_of(fuzz::input& in, std::size_t most) {
    const bytes raw = in.take(most);
    const reference::byte_list f{raw.begin(), raw.end()};
    return f.size() % 8 == 7 || f.size() < 2 ? f : reference::framed(f); // mostly with a valid CRC
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::input in{data, size};
    const unsigned choice = in.byte();
    const auto way = static_cast<direction>(choice % 3);
    const auto order = static_cast<word_order>(choice / 4 % 3);
    const servobus::catalogue* const map = maps[choice / 16 % 4];
    const servobus::catalogue* const other =
        choice / 64 != 0 ? maps[choice / 64] : nullptr; // of the other tables
    const table_catalogues all{map, other, other, other};
    const std::size_t room = in.byte();
    const reference::byte_list before = frame_of(in, in.byte() % 64u);
    const reference::byte_list frame = frame_of(in, 300);

    std::vector<char> wide(1 << 16);
    const explanation found = explain(all, way, frame, before, wide, order);
    require(found.size > 0 && found.size < wide.size(),
            "G32 a frame is explained in a line of bounded length");
    const std::string_view said{wide.data(), found.size};
    for (const char c : said) require(c >= ' ' && c <= '~', "the line is plain text");
    require(found.is_valid() == is_valid(frame, way),
            "a frame is explained as valid exactly if the standard allows it");
    // A device's own text stands in quotes.
    require(found.is_valid() == (said.substr(0, said.find('"')).find("invalid") == said.npos),
            "exactly an invalid frame is called invalid");
    require(found.is_valid() || found.mismatch == errc::ok,
            "only a valid response has a mismatch with its request");

    std::vector<char> narrow(room); // a heap buffer of the exact size, so that a write beyond it is found
    const explanation cut = explain(all, way, frame, before, narrow, order);
    const std::string_view short_of{narrow.data(), cut.size};
    require(cut.size == std::min(room, found.size), "a line fills its buffer and no more");
    require(cut.why == found.why && cut.mismatch == found.mismatch && cut.way == found.way,
            "the size of the buffer changes no result");
    const bool is_cut = cut.size < found.size;
    const std::size_t kept = is_cut ? (cut.size < 3 ? 0 : cut.size - 3) : cut.size;
    require(short_of.substr(0, kept) == said.substr(0, kept), "the size of the buffer changes no words");
    if (is_cut)
        require(short_of.substr(kept).find_first_not_of('.') == short_of.npos, "a cut line ends in dots");
    return 0;
}
