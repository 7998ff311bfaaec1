// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The parts of a drive's model that a drive may do without. A model defines each of them or names it here: so a part whose
// name is misspelt does not compile. device/README.md says what each is.
//
//     static constexpr model_parts leaves_out{model_part::slower, model_part::positions, model_part::is_fall};
//     static_assert(leaves_out.has(model_part::slower) && !leaves_out.has(model_part::permit));
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

namespace servobus {

enum class model_part : std::uint8_t {
    admit,
    permit,
    fail,
    watchdog,
    slower,
    positions,
    is_fall,
    sets_origin,
    stops_after_restart,
    disable_replaces_quick_stop,
    moves_when_enabled,
    grant,
    grant_at_most,
};

/// A set of parts: `model_parts leaves_out{model_part::permit, model_part::slower};`.
class model_parts {
  public:
    template <class... Part>
    consteval explicit model_parts(Part... parts) : bits_{(0u | ... | bit_of(parts))} {}

    constexpr bool has(model_part which) const { return (bits_ & bit_of(which)) != 0; }

  private:
    static constexpr std::uint32_t bit_of(model_part which) { return 1u << static_cast<unsigned>(which); }

    std::uint32_t bits_;
};

} // namespace servobus
