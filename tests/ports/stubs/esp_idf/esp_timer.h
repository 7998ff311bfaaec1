// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the ESP-IDF port uses of the timer.
#pragma once

#include <stdint.h>

extern "C" int64_t esp_timer_get_time(void);
