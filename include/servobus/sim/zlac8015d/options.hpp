// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the simulated ZLAC8015D does where the RS485 manual V1.07 is silent or can be read two ways: a switch
// for each. Position 0 of each is what the model does by default. [Bn] are entries of device/errata.md.
#pragma once

#include <cstdint>

namespace servobus::sim {

/// What a test may choose of the simulated drive. Each is a reading of the manual; which one a real drive
/// follows is not known.
struct zlac8015d_options {
    /// What ends a watchdog stop, section 4, 2000h [B34]. True: the next valid request, and the wheels go on
    /// to the targets that are set: the worst case for a controller. False: the drive stays in quick stop
    /// until it is enabled again.
    bool resumes_after_watchdog = true;

    /// What 2010h keeps, section 4 [B11]. "Saves all parameters with the attribute RW", while the tables mark
    /// some rows RW and others RW/S.
    enum class kept : std::uint8_t {
        marked, ///< the rows marked RW/S; mode, targets and ramps are the factory's after a restart
        all,    ///< every row that can be written, the mode 200Dh among them
    };
    kept save = kept::marked;

    /// A watchdog time of 0, section 4, 2000h: in its range, and not explained [B28].
    enum class zero : std::uint8_t {
        off,   ///< there is no watchdog
        stops, ///< the time is always over: an enabled drive stops immediately
    };
    zero host_timeout = zero::off;

    /// The shaft's two bits of 20A2h, section 4, while an enabled wheel turns: "released" or "locked", and no
    /// third value for a shaft that is driven [B30].
    enum class shaft : std::uint8_t { locked, released };
    shaft while_turning = shaft::locked;

    /// The same bits in torque mode, which holds no position [B30].
    shaft in_torque_mode = shaft::locked;

    /// The same bits after a quick stop, by 05h, the input or the watchdog. 2021h calls the result "locks the
    /// shaft" [B30].
    enum class stopped : std::uint8_t { emergency, locked };
    stopped after_quick_stop = stopped::emergency;

    /// Bits 0 and 8 of 20A2h, section 4: "0: 停机 1: 运行". 停机 is also the name of the command 07h [B31].
    enum class running : std::uint8_t {
        turns,   ///< 1 while a wheel turns or a move is under way, powered or not
        driven,  ///< as above, but 0 for a wheel that rolls without power
        enabled, ///< 1 while the drive is enabled, 0 from the stop command on, though the wheel still turns
    };
    running bit = running::turns;

    /// 20A5h, 20A6h, section 4: the "most recent" fault code [B32].
    enum class fault_code : std::uint8_t {
        until_reset,   ///< 06h clears it
        until_restart, ///< 06h ends the alarm; the code remains until the drive is switched off
    };
    fault_code code = fault_code::until_reset;

    /// Which motor a fault switches off: section 3.5 has a code for each wheel and says no more [B33].
    enum class switched_off : std::uint8_t { both_wheels, its_wheel };
    switched_off by_fault = switched_off::both_wheels;

    /// 201Ah, 201Bh = 1, sections 3.6 and 4: "抱闸关闭", which is "the brake closes" or "the brake output is
    /// off" [B29]. Code 0 does the opposite.
    enum class brake : std::uint8_t { engages, releases };
    brake code_1 = brake::engages;
};

} // namespace servobus::sim
