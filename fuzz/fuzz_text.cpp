// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Text that users type: lists of faults, parameter numbers.
#include <cstdint>
#include <cstring>
#include <string>

#include <servobus/device/c630s/registers/parameter_number.hpp>
#include <servobus/sim/faults.hpp>

#include "support.hpp"

using namespace servobus;
using fuzz::require;

namespace {

bool is_same(const sim::fault_plan& a, const sim::fault_plan& b) {
    return a.lost_request == b.lost_request && a.corrupted_request == b.corrupted_request &&
           a.lost_response == b.lost_response && a.late_response == b.late_response &&
           a.doubled_response == b.doubled_response && a.cut_response == b.cut_response &&
           a.noise_before == b.noise_before && a.noise_after == b.noise_after &&
           a.corrupted_response == b.corrupted_response && a.late_by == b.late_by &&
           a.doubled_after == b.doubled_after && a.is_unplugged == b.is_unplugged;
}

// A list is its names, each known, with commas between.
bool is_list(const std::string& text) {
    constexpr const char* names[] = {"none", "late", "lossy", "noisy", "doubled", "cut", "unplugged"};
    std::size_t at = 0;
    while (true) {
        const std::size_t comma = text.find(',', at);
        const std::string name = text.substr(at, comma == text.npos ? comma : comma - at);
        bool is_known = false;
        for (const char* known : names) is_known = is_known || name == known;
        if (!is_known) return false;
        if (comma == text.npos) return true;
        at = comma + 1;
    }
}

void faults(const std::string& text) {
    const sim::fault_plan before{};
    sim::fault_plan plan = before;
    const bool is_good = sim::parse_faults(text.c_str(), plan);
    require(is_good == is_list(text.c_str()), "a list of faults has known names with commas between");
    if (!is_good) require(is_same(plan, before), "a bad list of faults changes nothing");
    sim::fault_plan again = plan;
    require(!is_good || (sim::parse_faults(text.c_str(), again) && is_same(plan, again)),
            "the same list of faults gives the same plan twice");
    constexpr std::uint8_t frame[] = {1, 6, 0x20, 0x0E, 0, 8, 0xE2, 0x0F};
    std::vector<std::uint8_t> out(sizeof frame + 8);
    sim::fault_source source{text.size(), plan};
    require(sim::spoil(source.decide(), frame, out) <= out.size(), "a fault adds at most eight bytes");
}

void parameter_number(const bytes given) {
    // A buffer of the exact size, without a zero after it.
    const std::vector<char> text{given.begin(), given.end()};
    const int address = c630s::detail::parameter_address(text.data(), text.size());
    require(address >= -1 && address <= 0xFFFF, "a parameter number is an address or nothing");
    if (address < 0) return;
    char again[16];
    (void)std::snprintf(again, sizeof again, "P%02X-%02d", static_cast<unsigned>(address) >> 8,
                        address & 0xFF);
    require(text.size() == 6 && std::memcmp(again, text.data(), 6) == 0,
            "an address has one parameter number");
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    faults({data, data + size});
    parameter_number({data, size});
    return 0;
}
