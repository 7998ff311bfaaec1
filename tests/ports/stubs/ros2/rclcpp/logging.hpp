// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Repeats the logging macros that the hardware interface uses (rclcpp 16, Humble; the same in Jazzy). Each message is
// kept, so that a test can count and compare them.
#pragma once

#include <cstdarg>
#include <cstdio>
#include <string>
#include <vector>

#include "rclcpp/logger.hpp"

namespace stand_in {

/// The messages so far, each with its level in front: "ERROR base: no response".
inline std::vector<std::string>& logged() {
    static std::vector<std::string> all;
    return all;
}

[[gnu::format(printf, 3, 4)]] inline void log(const rclcpp::Logger&, const char* level, const char* format,
                                              ...) {
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    (void)std::vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    logged().push_back(std::string{level} + " " + text);
}

} // namespace stand_in

#define RCLCPP_INFO(logger, ...) stand_in::log(logger, "INFO", __VA_ARGS__)
#define RCLCPP_WARN(logger, ...) stand_in::log(logger, "WARN", __VA_ARGS__)
#define RCLCPP_ERROR(logger, ...) stand_in::log(logger, "ERROR", __VA_ARGS__)
