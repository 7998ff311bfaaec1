// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// States which baud rates and frame formats a device can have, the registers that set them, and when they take effect.
// Device classes have it as `on_line`; client/settings_on_one_line.hpp finds what several devices share.
//
//     struct winch {
//         static constexpr profile facts{.name = "winch", .baud = 9600};
//         static constexpr rate_choice rates[] = {{9600, 0}, {19200, 1}};
//         static constexpr line_choices on_line{.rates = rates, .rate_register = 0x0002, .needs_power_cycle = true};
//     };
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>

#include <servobus/registers/profile.hpp>

namespace servobus {

/// A baud rate that a device can have, and the code for it in its register.
struct rate_choice {
    std::uint32_t baud; ///< bits a second
    std::uint16_t code;
};

/// A frame format that a device can have, and the code for it in its register.
struct format_choice {
    character_format format;
    std::uint16_t code;
};

/// A view of what a device can have, an array of static lifetime.
template <class Choice> class choice_table {
  public:
    constexpr choice_table() = default;
    template <unsigned N>
    constexpr choice_table(const Choice (&table)[N]) // NOLINT: an array is a table
        : begin_{table}, end_{table + N} {}

    constexpr const Choice* begin() const { return begin_; }
    constexpr const Choice* end() const { return end_; }
    constexpr bool is_empty() const { return begin_ == end_; }

  private:
    const Choice* begin_ = nullptr;
    const Choice* end_ = nullptr;
};

/// What can be set of a device's line. A device class has it as `static constexpr line_choices on_line`; one without it
/// has the rate and the format of its profile only.
struct line_choices {
    choice_table<rate_choice> rates{};     ///< none: the profile's only
    choice_table<format_choice> formats{}; ///< none: the profile's only
    std::uint16_t rate_register = 0;
    std::uint16_t format_register = 0;
    bool needs_save = false; ///< a written code is lost with the power unless the device's `save` follows
    bool needs_power_cycle =
        false; ///< a code takes effect at the next power-on, or the manual does not say when
};

} // namespace servobus
