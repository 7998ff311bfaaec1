// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S: advice about each alarm, 11 KB of flash where it is called. Programs that show it to a person include
// this header; c630s.hpp does not. Source: manual V24.111, sections 5.2.3, 5.2.4, 8.1.1 and 8.1.2; [errata Cn] are in
// device/errata_c630s.md.
//
// The comment of a row names its place in the manual and the items that the manual numbers there. P02-31 = 1
// initialises the parameters, those of the line among them [errata C39].
//
//     constexpr advice what = c630s::advice_for(0x601); // Er.601, homing failed; or seen->alarm_code
//     const result<c630s::feedback> seen = servo.read();
//     if (seen && seen->alarm_code != 0) std::puts(c630s::advice_for(seen->alarm_code).remedy);
#pragma once

#include <servobus/control/advice.hpp>
#include <servobus/device/c630s/alarms.hpp>

namespace servobus::c630s {

namespace detail {
struct alarm_advice {
    u16 code;
    const char* cause;
    const char* remedy;
};

// clang-format off
inline constexpr alarm_advice advice_table[] = {
    {0x101, // 8.1.1 Er.101, 1..4
     "A parameter of P02 or a later group is out of range; the power failed during a write; the EEPROM is broken.",
     "Initialise the parameters (P02-31), or write them again. Set motor and drive model again. Broken EEPROM: replace the drive."},
    {0x102, // 8.1.1 Er.102
     "Hardware of the controller (MCU) is damaged.", "Replace the drive."},
    {0x104, // 8.1.1 Er.104
     "Hardware of the controller (MCU) is damaged.", "Replace the drive."},
    {0x105, // 8.1.1 Er.105, 1..3
     "The number of parameters in the EEPROM, or the range of a parameter, is wrong.",
     "Initialise the parameters (P02-31) and switch the power off and on. If the fault stays, replace the drive."},
    {0x108, // 8.1.1 Er.108, 1 and 2
     "A parameter could not be written to the EEPROM.",
     "Initialise the parameters (P02-31) and switch the power off and on. If the fault stays, replace the drive."},
    {0x111, // 8.1.1 Er.111
     not_in_manual,
     "Initialise the parameters (P02-31) and switch the power off and on. If the fault stays, replace the drive."},
    {0x120, // 8.1.1 Er.120
     "The motor model does not match the drive model.", "Check the motor model. Contact the maker's service."},
    {0x121, // 8.1.1 Er.121
     "The inputs (DI) are configured wrongly.", "Check the functions of the inputs (DI) and virtual inputs (VDI)."},
    {0x122, // 8.1.1 Er.122
     "The motor's absolute encoder does not match, or the motor model is set wrongly.",
     "Check the motor model. Contact the maker's service."},
    {0x130, // 8.1.1 Er.130
     "One function is assigned to several inputs (DI).",
     "Check the functions of the inputs (DI) and virtual inputs (VDI), or initialise the parameters (P02-31)."},
    {0x131, // 8.1.1 Er.131
     "The function number of an output (DO) does not exist.",
     "Check the functions of the outputs (DO), or initialise the parameters (P02-31)."},
    {0x136, // 8.1.1 Er.136, 1..3
     "The encoder's ROM has no parameters, or others than agreed.",
     "Check motor and drive model. Check the encoder cable and its plugs. Against interference, lay the encoder cable anew."},
    {0x201, // 8.1.1 Er.201, 1..8
     "U V W miswired, shorted or leaking to the case; encoder contact bad; load too heavy; ramps too short; gains too high; braking resistor faulty.",
     "Check motor and encoder cables. Test without load, with longer ramps, lower gains and the internal braking resistor. Last, replace the drive."},
    {0x207, // 8.1.1 Er.207
     "The current feedback is wrong: a register in the drive overflows.", "Replace the drive."},
    {0x208, // 8.1.1 Er.208, 1..6
     "A timeout of the MCU, of the encoder, of the current sampling or of the analogue conversion.",
     "Check the encoder cable. Shield the analogue inputs. Against interference, add an isolating transformer and rewire. Last, replace motor or drive."},
    {0x210, // 8.1.1 Er.210, 1..3
     "Found at power-on: U V W shorted to ground, a winding shorted to the motor's case, or a faulty drive.",
     "Check the motor cable. If the winding is shorted, replace the motor. Faulty drive: replace the drive."},
    {0x220, // 8.1.1 Er.220, 1 and 2
     "The encoder's electrical angle does not match, or U V W are in the wrong order.",
     "Set the motor parameters again and run self-learning. Check the motor cable."},
    {0x234, // 8.1.1 Er.234, 1..4
     "The motor turns against its command: U V W in the wrong order; rotor phase misread through interference; encoder wrong or miswired.",
     "Check the motor cable and the wiring. Switch the power off and on. Replace motor or encoder cable. Last, replace the drive."},
    {0x400, // 8.1.1 Er.400, 1..5 [errata C65, C66]
     "Bus voltage above 420 V: mains too high or unstable; braking resistor broken or too large; ramps too short.",
     "Power off, measure the braking resistor; fit 40 or 50 ohm. Lengthen the ramps. Stabilise the mains: 220 V give 310 V in P0B-26."},
    {0x410, // 8.1.1 Er.410, 1 and 2
     "Bus voltage below 200 V: the mains are unstable or lost.",
     "Check the wiring; stabilise the mains. Compare P0B-26 with the mains: 220 V give 310 V. If they differ much, replace the drive."},
    {0x420, // 8.1.1 Er.420
     "The drive is faulty.", "Replace the drive."},
    {0x430, // 8.1.1 Er.430
     "The drive is faulty.", "Replace the drive."},
    {0x500, // 8.1.1 Er.500, 1..5
     "The motor is faster than the limit: U V W in the wrong order; motor parameters wrong; command too high; overshoot by unsuitable gains.",
     "Check the motor cable. Set the motor parameters, run self-learning. Test with initialised parameters (P02-31). Last, replace the drive."},
    {0x510, // 8.1.1 Er.510
     "The pulse output is faster than the hardware allows.",
     "Lower P05-17 (encoder pulses per turn) until the output stays below its limit."},
    {0x602, // 8.1.1 Er.602
     "Self-learning of the motor failed.", "Check the encoder cable and the encoder type."},
    {0x610, // 8.1.1 Er.610 and Er.620, 1..7 [errata C63]
     "Model set wrongly; load too heavy; motor stalled; gains too high; ramps too short; U V W in the wrong order; drive damaged.",
     "Watch the load (P0B-12). Free the motor, or test it without load. Lengthen the ramps. Check the motor cable. Initialise the parameters (P02-31)."},
    {0x620, // 8.1.1 Er.610 and Er.620, 1..7 [errata C63]
     "Model set wrongly; load too heavy; motor stalled; gains too high; ramps too short; U V W in the wrong order; drive damaged.",
     "Watch the load (P0B-12). Free the motor, or test it without load. Lengthen the ramps. Check the motor cable. Initialise the parameters (P02-31)."},
    {0x625, // 8.1.1 Er.625 [errata C67]
     "The brake output is active, and while the command is zero the torque is below 70 % of the gravity load.",
     "Check that the signal reaches the motor's brake, and that the brake relay is not broken."},
    {0x626, // 8.1.1 Er.626 [errata C67]
     "The brake output is inactive, yet the motor made more than two turns.",
     "Check that the signal reaches the motor's brake, and that the brake relay is not broken."},
    {0x630, // 8.1.1 Er.630, 1..3
     "Below 10 r/min at the torque limit for P0A-32: motor stalled; U V W broken or in the wrong order; motor parameters wrong.",
     "Free the motor, or test it without load. Check U V W. Set the motor parameters again and run self-learning."},
    {0x650, // 8.1.1 Er.650
     "The power stage is too hot: the drive is faulty.", "Replace the drive."},
    {0x731, // 8.1.1 Er.731, 1 and 2
     "The battery of the absolute encoder is below 3.0 V: it is empty, or the encoder cable was disconnected.",
     "Replace an empty battery. After a disconnected encoder cable the reset suffices."},
    {0x733, // 8.1.1 Er.733
     "The encoder's multi-turn count is wrong.",
     "Initialise the parameters (P02-31). Set motor, drive and encoder type again. If the fault stays after the reset, replace the motor."},
    {0x735, // 8.1.1 Er.735
     "The encoder's multi-turn count overflowed.",
     "Initialise the parameters (P02-31). Set motor, drive and encoder type again. If the fault stays after the reset, replace the motor."},
    {0x740, // 8.1.1 Er.740, 1..3
     "The encoder's Z signal is disturbed: encoder cable miswired or loose, interference, or a faulty encoder.",
     "Check or replace the encoder cable. Lay it anew and ground it well. Faulty encoder: replace the motor."},
    {0x834, // 8.1.1 Er.834, 1 and 2
     "An analogue input (AI) is above 11.5 V.", "Check the input voltage. If the input is faulty, replace the drive."},
    {0x835, // 8.1.1 Er.835
     "The wiring of an analogue input (AI) picks up interference.",
     "Check the wiring of the analogue inputs. Use a shielded twisted pair."},
    {0xA33, // 8.1.1 Er.A33, 1 and 2
     "Data inside the encoder are wrong: the encoder cable is broken or loose, or the encoder is faulty.",
     "Check or replace the encoder cable. Faulty encoder: replace the motor."},
    {0xA34, // 8.1.1 Er.A34, 1 and 2
     "The drive does not match the motor type, or the encoder cable is broken.",
     "Set the motor model again. Check the encoder cable."},
    {0xA35, // 8.1.1 Er.A35, 1 and 2
     "The Z signal is lost, or A and B change together: the encoder cable is broken or loose, or the encoder is faulty.",
     "Check or replace the encoder cable. Faulty encoder: replace the motor."},
    {0xB00, // 8.1.1 Er.B00, 1..7
     "Deviation above P0A-10: U V W wrong; motor stalled; gains or torque limits too low; pulses too fast; P0A-10 too small; drive or motor faulty.",
     "Check the motor cable. Free the motor, or test it without load. Initialise the parameters (P02-31). Lower the pulse frequency, or raise P0A-10."},
    {0xB01, // 8.1.1 Er.B01, 1..3
     "The input pulses are faster than P0A-09, or disturbed.",
     "Lower the pulse frequency. Use a shielded twisted pair, well grounded. Supply the pulse signal from the drive's internal 24 V."},
    {0xB03, // 8.1.1 Er.B03
     "An electronic gear ratio is out of range.", "Check the electronic gear ratios."},
    {0x110, // 8.1.2 Er.110
     "P05-38 is 0 (pulses of the encoder), and P05-17 does not fit the encoder.", "Set P05-17 within its range."},
    {0x601, // 8.1.2 Er.601, 1 and 2; 1 says P05-34 [errata C37]
     "Homing did not find home within the time of P05-35.",
     "Raise P05-35. Check that the home signal works. Move the home point, or change the search direction."},
    {0x730, // 8.1.2 Er.730 [errata C62]
     "The battery of the absolute encoder is below 3.0 V.",
     "While the power is on, replace the battery by a new one of the right voltage."},
    {0x831, // 8.1.2 Er.831
     "An analogue input (AI1 or AI2) reads more than 500 mV at 0 V.",
     "Check the wiring of the analogue inputs. Use a shielded twisted pair."},
    {0x900, // 8.1.2 Er.900
     "An input with FunIN.34 (emergency stop), wired or virtual, was activated.", "Check the wiring of the input (DI)."},
    {0x909, // 8.1.2 Er.909
     "The load is too high.", "Check whether the load is too heavy or the motor is stalled."},
    {0x920, // 8.1.2 Er.920, 1..4 and a second 4 [errata C60, C65]
     "Braking current too high: bus voltage too high; deceleration too short; internal resistor too weak; P02-25 to P02-27 wrong; braking circuit damaged.",
     "Stabilise the voltage. Lengthen the deceleration. Fit an external resistor (35 ohm or more, not below P02-21), set P02-27. Last, replace the drive."},
    {0x922, // 8.1.2 Er.922
     "The external braking resistance P02-27 is below the lowest that the drive allows, P02-21.", not_in_manual},
    {0x939, // 8.1.2 Er.939
     "The phase current is below 10 % of the rated current and the speed is low, though the torque command is high.",
     "Check the motor cable and wire it anew; if necessary, replace it."},
    {0x941, // 8.1.2 Er.941
     "A parameter was changed that takes effect at the next power-on.", "Switch the power off and on."},
    {0x942, // 8.1.2 Er.942
     "More than 200 parameters were changed together.",
     "Check how it is operated. Before writing parameters that need not be stored in the EEPROM, set P0C-13 to 0."},
    {0x950, // 8.1.2 Er.950
     "The input with FunIN.14 (P-OT, positive overtravel switch) was activated.", not_in_manual},
    {0x952, // 8.1.2 Er.952
     "The input with FunIN.15 (N-OT, negative overtravel switch) was activated.", not_in_manual},
    {0x980, // 8.1.2 Er.980
     "The encoder's algorithm failed.", "Switch the power off and on. If the fault stays after several times, replace the motor."},
    {0xA40, // 8.1.2 Er.A40, 1..3
     "Self-learning of the motor failed: encoder cable or encoder model wrong, or a faulty encoder.",
     "Check the encoder cable. Set motor model and encoder type again. Faulty encoder: replace the motor."},
};
// clang-format on

/// Sections 5.2.4, 8.1.1, 8.1.2. `fault_reset` switches the servo off and sets P0D-01, and writes no P0D-20.
constexpr const char* reset_of(const alarm& a) {
    switch (a.code) {
    case 0x731:
        return "Switch the servo off. Set P0D-20 to 2, which clears the multi-turn count, then P0D-01 to 1.";
    case 0x733:
    case 0x735:
        return "Switch the servo off. Set P0D-20 to 2, which clears the multi-turn count, then P0D-01 to 1. "
               "Switch the "
               "power off and on.";
    default: break;
    }
    if (!a.is_resettable) return "Switch the power off and on; P0D-01 does not reset this fault.";
    return a.kind == alarm_class::warning ? "Set P0D-01 to 1; the servo may stay on."
                                          : "Switch the servo off, then set P0D-01 to 1.";
}
} // namespace detail

/// The advice about the alarm with a code such as 0x101; `not_in_manual` if the manual has no such alarm.
constexpr advice advice_for(u16 code) {
    if (code == 0) return no_fault_advice;
    for (const detail::alarm_advice& a : detail::advice_table) {
        if (a.code == code) return {a.cause, a.remedy, detail::reset_of(*find_alarm(code))};
    }
    return {not_in_manual, not_in_manual, not_in_manual};
}

} // namespace servobus::c630s
