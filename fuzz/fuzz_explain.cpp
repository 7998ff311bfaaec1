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

#include "reference.hpp"
#include "support.hpp"

using namespace servobus;
using fuzz::require;

namespace {

constexpr std::array<const servobus::catalogue*, 4> maps{&zlac8015d::catalogue, &yako::closed_loop::catalogue,
                                                         &yako::open_loop::catalogue, &c630s::catalogue};

// The lengths that the standard gives some functions, with their counts of bytes. Others have any.
bool is_of_other_function(const reference::byte_list& pdu) {
    const std::size_t size = pdu.size();
    const auto counts = [&](std::size_t before) { return size > before && pdu[before] == size - before - 1; };
    switch (pdu[0]) {
    case 0:
    case 3:
    case 4:
    case 6:
    case 16: return false;
    case 1:
    case 2: return size == 5 || counts(1);
    case 5: return size == 5;
    case 15: return size == 5 || counts(5);
    case 17: return size == 1 || counts(1);
    case 22: return size == 7;
    case 23: return counts(1) || counts(9);
    default: return pdu[0] < 0x80;
    }
}

bool is_valid(const reference::byte_list& f, direction way) {
    if (!reference::is_frame(f)) return false;
    const reference::byte_list pdu{f.begin() + 1, f.end() - 2};
    if (is_of_other_function(pdu)) return true;
    const bool asks = reference::request(pdu).has_value() && way != direction::response;
    const bool answers = reference::is_response(pdu) && way != direction::request && f[0] != 0;
    if (asks && f[0] == 0 && (pdu[0] == 3 || pdu[0] == 4)) return false;
    const bool is_known =
        (pdu[0] & 0x7F) == 3 || (pdu[0] & 0x7F) == 4 || (pdu[0] & 0x7F) == 6 || (pdu[0] & 0x7F) == 16;
    return (asks || answers) && (is_known || pdu[0] >= 0x80);
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
    const servobus::catalogue& map = *maps[choice / 16 % 4];
    const std::size_t room = in.byte();
    const reference::byte_list before = frame_of(in, in.byte() % 64u);
    const reference::byte_list frame = frame_of(in, 300);

    std::vector<char> wide(1 << 16);
    const explanation found = explain(map, way, frame, before, wide, order);
    require(found.size > 0 && found.size < wide.size(),
            "G32 a frame is explained in a line of bounded length");
    const std::string_view said{wide.data(), found.size};
    for (const char c : said) require(c >= ' ' && c <= '~', "the line is plain text");
    require(found.is_valid() == is_valid(frame, way),
            "a frame is explained as valid exactly if the standard allows it");
    require(found.is_valid() == (said.find("invalid") == said.npos),
            "exactly an invalid frame is called invalid");
    require(found.is_valid() || found.mismatch == errc::ok,
            "only a valid response has a mismatch with its request");

    std::vector<char> narrow(room); // a heap buffer of the exact size, so that a write beyond it is found
    const explanation cut = explain(map, way, frame, before, narrow, order);
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
