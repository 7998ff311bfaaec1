// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the Zephyr port uses of the kernel; a tick is 100 us here.
#pragma once

#include <stdint.h>

typedef struct {
    int64_t ticks;
} k_timeout_t;

#define SYS_FOREVER_US (-1)
#define K_TICKS(t) (k_timeout_t{static_cast<int64_t>(t)})
#define K_USEC(us) (k_timeout_t{(static_cast<int64_t>(us) + 99) / 100})
#define K_NO_WAIT (k_timeout_t{0})

struct k_sem {
    unsigned int count;
    unsigned int limit;
};

struct k_timer;
typedef void (*k_timer_expiry_t)(struct k_timer* timer);
struct k_timer {
    k_timer_expiry_t expiry;
    void* user_data;
};

extern "C" {
int k_sem_init(struct k_sem* sem, unsigned int initial_count, unsigned int limit);
void k_sem_give(struct k_sem* sem);
int k_sem_take(struct k_sem* sem, k_timeout_t timeout);
void k_timer_init(struct k_timer* timer, k_timer_expiry_t expiry, k_timer_expiry_t stop);
void k_timer_user_data_set(struct k_timer* timer, void* data);
void* k_timer_user_data_get(const struct k_timer* timer);
void k_timer_start(struct k_timer* timer, k_timeout_t duration, k_timeout_t period);
void k_yield(void);
int64_t k_uptime_ticks(void);
}

inline uint64_t k_ticks_to_us_floor64(int64_t ticks) { return static_cast<uint64_t>(ticks) * 100; }
inline uint32_t k_us_to_ticks_floor32(uint32_t us) { return us / 100; }
