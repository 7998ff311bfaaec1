// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The measures of units: their symbols, and how they follow from each other. unit.hpp includes it.
//
//     static_assert(symbol(measure::millimetre_per_second)[0] == 'm'); // "mm/s"
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

namespace servobus {

/// The units of measure that the manuals use, those of a machine, and those of meters and sensors beside it. Only units
/// that manuals print have a prefix; others have a multiple: `multiple<1000>(units::var)` is 1 kvar.
enum class measure : std::uint8_t {
    none,
    r_per_min,
    second,
    millisecond,
    nanosecond,
    ampere,
    milliampere,
    milliampere_per_second,
    volt,
    millivolt,
    ohm,
    watt,
    kilohertz,
    hertz,
    percent,
    times, ///< a ratio to something else
    degree_celsius,
    degree,
    revolution,
    pulse,
    pulse_per_revolution,
    reference_unit, ///< pulses after the scaling of an electronic gear
    count,
    microsecond,
    micrometre,
    millimetre,
    metre,
    micrometre_per_second,
    millimetre_per_second,
    metre_per_second,
    microradian,
    milliradian,
    radian,
    microradian_per_second,
    milliradian_per_second,
    radian_per_second,
    minute,
    hour,
    kilowatt,
    volt_ampere,
    var, ///< of reactive power
    watt_hour,
    kilowatt_hour,
    var_hour,
    kilogram,
    newton,
    newton_metre,
    pascals, ///< `pascal` is a macro of <windows.h>
    bar,
    litre,
    cubic_metre,
    litre_per_minute,
    cubic_metre_per_hour,
    device_unit, ///< of the device's own: it converts to nothing but itself, and its symbol is not here
};

/// The symbol of a measure in ASCII, as the tool `servobus map` prints it.
constexpr const char* symbol(measure m) {
    switch (m) {
    case measure::none: return "";
    case measure::r_per_min: return "r/min";
    case measure::second: return "s";
    case measure::millisecond: return "ms";
    case measure::nanosecond: return "ns";
    case measure::ampere: return "A";
    case measure::milliampere: return "mA";
    case measure::milliampere_per_second: return "mA/s";
    case measure::volt: return "V";
    case measure::millivolt: return "mV";
    case measure::ohm: return "ohm";
    case measure::watt: return "W";
    case measure::kilohertz: return "kHz";
    case measure::hertz: return "Hz";
    case measure::percent: return "%";
    case measure::times: return "times";
    case measure::degree_celsius: return "degC";
    case measure::degree: return "deg";
    case measure::revolution: return "r";
    case measure::pulse: return "pulse";
    case measure::pulse_per_revolution: return "pulse/r";
    case measure::reference_unit: return "ref_unit";
    case measure::count: return "counts";
    case measure::microsecond: return "us";
    case measure::micrometre: return "um";
    case measure::millimetre: return "mm";
    case measure::metre: return "m";
    case measure::micrometre_per_second: return "um/s";
    case measure::millimetre_per_second: return "mm/s";
    case measure::metre_per_second: return "m/s";
    case measure::microradian: return "urad";
    case measure::milliradian: return "mrad";
    case measure::radian: return "rad";
    case measure::microradian_per_second: return "urad/s";
    case measure::milliradian_per_second: return "mrad/s";
    case measure::radian_per_second: return "rad/s";
    case measure::minute: return "min";
    case measure::hour: return "h";
    case measure::kilowatt: return "kW";
    case measure::volt_ampere: return "VA";
    case measure::var: return "var";
    case measure::watt_hour: return "Wh";
    case measure::kilowatt_hour: return "kWh";
    case measure::var_hour: return "varh";
    case measure::kilogram: return "kg";
    case measure::newton: return "N";
    case measure::newton_metre: return "Nm";
    case measure::pascals: return "Pa";
    case measure::bar: return "bar";
    case measure::litre: return "l";
    case measure::cubic_metre: return "m3";
    case measure::litre_per_minute: return "l/min";
    case measure::cubic_metre_per_hour: return "m3/h";
    case measure::device_unit: return "";
    }
    return "";
}

namespace detail {
// Measures of one kind have a common base, such as s for times and A for currents; each is 1/n of the base, or n of it.
constexpr measure base_of(measure m) {
    switch (m) {
    case measure::millisecond:
    case measure::microsecond:
    case measure::nanosecond:
    case measure::minute:
    case measure::hour: return measure::second;
    case measure::milliampere: return measure::ampere;
    case measure::millivolt: return measure::volt;
    case measure::hertz: return measure::kilohertz;
    case measure::degree: return measure::revolution;
    case measure::micrometre:
    case measure::millimetre: return measure::metre;
    case measure::micrometre_per_second:
    case measure::millimetre_per_second: return measure::metre_per_second;
    case measure::microradian:
    case measure::milliradian: return measure::radian;
    case measure::microradian_per_second:
    case measure::milliradian_per_second: return measure::radian_per_second;
    case measure::watt: return measure::kilowatt;
    case measure::watt_hour: return measure::kilowatt_hour;
    case measure::pascals: return measure::bar;
    case measure::litre: return measure::cubic_metre;
    default: return m;
    }
}
constexpr std::int64_t parts_of_base(measure m) {
    switch (m) {
    case measure::nanosecond: return 1'000'000'000;
    case measure::microsecond:
    case measure::micrometre:
    case measure::micrometre_per_second:
    case measure::microradian:
    case measure::microradian_per_second: return 1'000'000;
    case measure::degree: return 360;
    case measure::pascals: return 100'000;
    case measure::minute:
    case measure::hour: return 1;
    default: return m == base_of(m) ? 1 : 1000;
    }
}
constexpr std::int64_t bases_in(measure m) {
    return m == measure::hour ? 3600 : m == measure::minute ? 60 : 1;
}
} // namespace detail

} // namespace servobus
