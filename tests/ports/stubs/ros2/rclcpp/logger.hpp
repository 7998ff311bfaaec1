// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Repeats rclcpp::Logger and get_logger (rclcpp 16, Humble; the same in Jazzy).
#pragma once

#include <string>

namespace rclcpp {

class Logger {
  public:
    const char* get_name() const { return name_.c_str(); }

  private:
    friend Logger get_logger(const std::string& name);
    explicit Logger(const std::string& name) : name_{name} {}

    std::string name_;
};

inline Logger get_logger(const std::string& name) { return Logger{name}; }

} // namespace rclcpp
