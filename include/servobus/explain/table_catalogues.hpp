// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The catalogues of a device that has rows in several tables. explain/explain.hpp includes it; the headers that
// `servobus header` makes have the catalogues.
//
//     constexpr entry coils[] = {{0x0004, "pump", value_kind::unsigned_word, access::rw, {0, 1, false}, no_default,
//                                 no_unit, flag::none}};
//     constexpr catalogue of_coils{&zlac8015d::device::facts, coils};
//     constexpr table_catalogues maps{.holding_registers = &zlac8015d::catalogue, .coils = &of_coils};
#pragma once

#include <servobus/core/cxx20.hpp>

#include <servobus/registers/catalogue.hpp>

namespace servobus {

/// A catalogue for each table of a device. A table whose catalogue is null has no names.
struct table_catalogues {
    const catalogue* holding_registers; ///< never null: it has the device's profile
    const catalogue* coils = nullptr;
    const catalogue* discrete_inputs = nullptr;
    const catalogue* input_registers = nullptr; ///< null: they have the names of the holding registers
};

} // namespace servobus
