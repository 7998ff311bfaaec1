// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The behaviour of the simulated ZLAC8015D where the RS485 manual V1.07 is silent or can be read in two ways:
// one switch for each. The first value of each is the model's default. [Bn] are entries of device/errata.md.
//
//     servobus::sim::zlac8015d_options chosen;
//     chosen.resumes_after_watchdog = false;
//     servobus::sim::zlac8015d drive{chosen};
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstdint>

namespace servobus::sim {

/// What a test may choose of the simulated ZLAC8015D. Each value is an interpretation of the manual; which one a real
/// drive follows is unknown.
struct zlac8015d_options {
    /// What ends a watchdog stop, section 4, 2000h [B34]. True: the next valid request ends it and the wheels
    /// continue to their present targets, the worst case for a controller. False: the drive stays in quick
    /// stop until it is enabled again.
    bool resumes_after_watchdog = true;

    /// Which registers 2010h saves, section 4 [B11]. The manual says "saves all parameters with the attribute
    /// RW", and its tables mark some rows RW and others RW/S.
    enum class kept : std::uint8_t {
        marked, ///< the rows marked RW/S; mode, targets and ramps have factory values after a restart
        all,    ///< every row that can be written, the mode 200Dh among them
    };
    kept save = kept::marked;

    /// What a watchdog time of 0 means, section 4, 2000h: it is in the range, and not explained [B28].
    enum class zero : std::uint8_t {
        off,   ///< there is no watchdog
        stops, ///< the time has always expired: an enabled drive stops immediately
    };
    zero host_timeout = zero::off;

    /// The shaft's two bits of 20A2h, section 4, while an enabled wheel turns. They can say "released" or
    /// "locked"; a driven shaft has no value of its own [B30].
    enum class shaft : std::uint8_t { locked, released };
    shaft while_turning = shaft::locked;

    /// The same bits in torque mode, which holds no position [B30].
    shaft in_torque_mode = shaft::locked;

    /// The same bits after a quick stop by 05h, the input or the watchdog. The text of 2021h calls the result
    /// "locks the shaft" [B30].
    enum class stopped : std::uint8_t { emergency, locked };
    stopped after_quick_stop = stopped::emergency;

    /// Bits 0 and 8 of 20A2h, section 4: "0: 停机 1: 运行". 停机 is also the name of the command 07h [B31].
    enum class running : std::uint8_t {
        turns,   ///< 1 while a wheel turns or a move is under way, powered or not
        driven,  ///< as above, but 0 for a wheel that rolls without power
        enabled, ///< 1 while the drive is enabled, 0 from the stop command on, even if the wheel still turns
    };
    running bit = running::turns;

    /// How long 20A5h and 20A6h keep a code, section 4: the "most recent" fault code [B32].
    enum class fault_code : std::uint8_t {
        until_reset,   ///< 06h clears it
        until_restart, ///< 06h ends the alarm; the code stays until the drive is switched off
    };
    fault_code code = fault_code::until_reset;

    /// Which motor a fault switches off. Section 3.5 has a code for each wheel and says nothing else [B33].
    enum class switched_off : std::uint8_t { both_wheels, its_wheel };
    switched_off by_fault = switched_off::both_wheels;

    /// What 201Ah, 201Bh = 1 does, sections 3.6 and 4: "抱闸关闭", which means "the brake closes" or "the brake
    /// output is off" [B29]. Code 0 does the opposite.
    enum class brake : std::uint8_t { engages, releases };
    brake code_1 = brake::engages;

    /// The shaft's two bits of 20A2h of a motor without power, after power-on and after 07h [B30]. A ZLAC8030D
    /// showed the emergency stop after 07h. A shaft that 2007h = 1 locks at power-on shows that.
    enum class idle : std::uint8_t { released, emergency };
    idle idle_shaft = idle::released;

    /// 20ABh and 20ACh show the speed in the position modes too [B31]. False: they read 0 there.
    bool shows_speed_of_moves = true;

    /// The starts 10h, 11h and 12h that a drive carries out, section 3.2 and 200Fh [B25]. The maker's quick start
    /// guide starts both wheels by 10h and never writes 200Fh.
    enum class start : std::uint8_t {
        any,     ///< each, whatever 200Fh is
        by_200F, ///< 10h if 200Fh is 1, 11h and 12h if it is 0
    };
    start position_start = start::any;

    /// 08h before a mode is set, section 3.1: programs that ran on drives send it first [B35]. False: it is ignored.
    /// True: it enables the drive, which obeys the mode that is set then.
    bool enables_without_mode = false;

    /// The ramps of 2080h to 2083h to a speed [B36].
    enum class ramp : std::uint8_t {
        begins_anew, ///< S-shaped, over the whole time, anew with each changed target: as 754 samples of a drive
        linear,      ///< the acceleration time from 0 to the target, the deceleration time from there to 0
    };
    ramp speed_ramp = ramp::begins_anew;

    /// 2012h, 2013h and 2014h take the printed codes alone, section 4 [B14]. False: any word. A program for a
    /// ZLAC8030D writes a time into 2014h.
    bool checks_option_codes = true;

    /// When a new 2022h scales the commanded speeds, section 4 [B21]. False: at the next power-on, if it was saved: the
    /// maker's quick start guide, and a driver's author. True: immediately.
    bool rescales_immediately = false;
};

} // namespace servobus::sim
