// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the RP2040 port uses of pico_time.
#pragma once

#include <stdint.h>

typedef int32_t alarm_id_t;
/// Returns 0: the alarm is over; > 0: call again so many us from now; < 0: so many us after the time it was
/// due.
typedef int64_t (*alarm_callback_t)(alarm_id_t id, void* user_data);

uint32_t time_us_32(void);
alarm_id_t add_alarm_in_us(uint64_t us, alarm_callback_t callback, void* user_data, bool fire_if_past);
