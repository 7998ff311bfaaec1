// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the Zephyr port uses of the GPIO API.
#pragma once

#include <stdint.h>

struct device {
    const char* name;
};

struct gpio_dt_spec {
    const struct device* port;
    uint8_t pin;
    uint16_t dt_flags;
};

#define GPIO_OUTPUT_INACTIVE ((1U << 17) | (1U << 18))

extern "C" {
int gpio_pin_configure_dt(const struct gpio_dt_spec* spec, uint32_t extra_flags);
int gpio_pin_set_dt(const struct gpio_dt_spec* spec, int value);
}
