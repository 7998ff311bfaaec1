// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A stepped function 17h that reads a register of another device.
// EXPECT: this register belongs to another device
// MEND: servobus::stepped_write_then_read<some_basin, servobus::rows<basin::options>, basin::ramp> both{io};
#include "basin.hpp"

namespace stranger {
struct device {
    static constexpr servobus::profile facts{.name = "stranger"};
};
inline constexpr servobus::reg<servobus::u16, servobus::access::ro, device> level{
    0x0010, servobus::full<servobus::u16>, servobus::no_unit, 0};
} // namespace stranger

int main() {
    some_basin io;
    servobus::stepped_write_then_read<some_basin, servobus::rows<stranger::level>, basin::ramp> both{io};
    (void)both.begin(5); // wrong
}
