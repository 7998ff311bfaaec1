// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Which drive a device is, whatever its variant. The simulation counts per drive kind.
#pragma once

#include <cstdint>
#include <string_view>

namespace trial {

enum class drive_kind : std::uint8_t { none, zlac8015d, yako, c630s, count_ };

constexpr const char* text(drive_kind k) {
    constexpr const char* names[] = {"others", "zlac8015d", "yako", "c630s"};
    return names[static_cast<unsigned>(k)];
}

constexpr drive_kind kind_of(std::string_view device) {
    if (device == "zlac8015d") return drive_kind::zlac8015d;
    if (device == "c630s") return drive_kind::c630s;
    return device.starts_with("yako") ? drive_kind::yako : drive_kind::none;
}

} // namespace trial
