// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Repeats the handles of state and command interfaces (hardware_interface 2.54.0, Humble).
#pragma once

#include <string>

namespace hardware_interface {

class ReadOnlyHandle {
  public:
    ReadOnlyHandle(const std::string& prefix_name, const std::string& interface_name,
                   double* value_ptr = nullptr)
        : prefix_name_{prefix_name}, interface_name_{interface_name}, value_ptr_{value_ptr} {}
    ReadOnlyHandle(const ReadOnlyHandle& other) = default;
    ReadOnlyHandle(ReadOnlyHandle&& other) = default;
    ReadOnlyHandle& operator=(const ReadOnlyHandle& other) = default;
    ReadOnlyHandle& operator=(ReadOnlyHandle&& other) = default;
    virtual ~ReadOnlyHandle() = default;

    operator bool() const { return value_ptr_ != nullptr; }
    const std::string get_name() const { return prefix_name_ + "/" + interface_name_; }
    const std::string& get_interface_name() const { return interface_name_; }
    const std::string& get_prefix_name() const { return prefix_name_; }
    double get_value() const { return *value_ptr_; }

  protected:
    std::string prefix_name_;
    std::string interface_name_;
    double* value_ptr_;
};

class ReadWriteHandle : public ReadOnlyHandle {
  public:
    using ReadOnlyHandle::ReadOnlyHandle;
    ReadWriteHandle(const ReadWriteHandle& other) = default;
    ReadWriteHandle(ReadWriteHandle&& other) = default;
    void set_value(double value) { *this->value_ptr_ = value; }
};

class StateInterface : public ReadOnlyHandle {
  public:
    StateInterface(const StateInterface& other) = default;
    StateInterface(StateInterface&& other) = default;
    using ReadOnlyHandle::ReadOnlyHandle;
};

class CommandInterface : public ReadWriteHandle {
  public:
    CommandInterface(const CommandInterface& other) = delete;
    CommandInterface(CommandInterface&& other) = default;
    using ReadWriteHandle::ReadWriteHandle;
};

} // namespace hardware_interface
