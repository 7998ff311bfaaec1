// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the ESP-IDF port uses of tasks.
#pragma once

extern "C" void stub_yield(void);
#define taskYIELD() stub_yield()
