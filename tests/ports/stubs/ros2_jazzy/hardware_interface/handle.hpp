// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Repeats the handles of state and command interfaces (hardware_interface 4.46.0, Jazzy), without their locks, and with
// values of type double alone.
#pragma once

#include <optional>
#include <string>

namespace hardware_interface {

class Handle {
  public:
    [[deprecated("Use InterfaceDescription for initializing the Interface")]] Handle(
        const std::string& prefix_name, const std::string& interface_name, double* value_ptr)
        : prefix_name_{prefix_name}, interface_name_{interface_name},
          handle_name_{prefix_name + "/" + interface_name}, value_ptr_{value_ptr} {}
    Handle(const Handle& other) noexcept = default;
    Handle& operator=(const Handle& other) = default;
    virtual ~Handle() = default;

    operator bool() const { return value_ptr_ != nullptr; }
    const std::string& get_name() const { return handle_name_; }
    const std::string& get_interface_name() const { return interface_name_; }
    const std::string& get_prefix_name() const { return prefix_name_; }
    template <typename T = double> [[nodiscard]] std::optional<T> get_optional() const { return *value_ptr_; }
    template <typename T> [[nodiscard]] bool set_value(const T& value) {
        *value_ptr_ = value;
        return true;
    }

  protected:
    std::string prefix_name_;
    std::string interface_name_;
    std::string handle_name_;
    double* value_ptr_ = nullptr;
};

class StateInterface : public Handle {
  public:
    StateInterface(const StateInterface& other) = default;
    using Handle::Handle;
};

class CommandInterface : public Handle {
  public:
    CommandInterface(const CommandInterface& other) = delete;
    CommandInterface(CommandInterface&& other) = default;
    using Handle::Handle;
};

} // namespace hardware_interface
