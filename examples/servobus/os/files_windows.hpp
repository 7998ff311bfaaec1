// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Windows: what locked_file_windows.cpp and file_target_windows.cpp share.
#pragma once

#include <string>
#include <string_view>
#include <utility>

#include <servobus/windows/clock.hpp>

#include "os.hpp"

namespace tool {

/// Closes itself.
class file_handle {
  public:
    file_handle() = default;
    explicit file_handle(HANDLE file) : file_{file} {}
    file_handle(file_handle&& other) noexcept : file_{std::exchange(other.file_, INVALID_HANDLE_VALUE)} {}
    file_handle& operator=(file_handle&&) = delete;
    ~file_handle() { (void)close(); }

    bool is_open() const { return file_ != INVALID_HANDLE_VALUE; }
    HANDLE get() const { return file_; }
    bool close() { return !is_open() || ::CloseHandle(std::exchange(file_, INVALID_HANDLE_VALUE)) != 0; }

  private:
    HANDLE file_ = INVALID_HANDLE_VALUE;
};

/// The path from its root on. A name of a device begins with `\\.\`, also if it was given as `COM3` or `NUL`.
inline std::string full_name(const std::string& path) {
    std::string full(MAX_PATH, '\0');
    DWORD size = ::GetFullPathNameA(path.c_str(), static_cast<DWORD>(full.size()), full.data(), nullptr);
    if (size > full.size()) {
        full.resize(size);
        size = ::GetFullPathNameA(path.c_str(), size, full.data(), nullptr);
    }
    full.resize(size);
    return full;
}
inline bool is_device(const std::string& full) { return full.starts_with(R"(\\.\)"); }

/// An error of Windows in words.
inline std::string error_text(DWORD error) { return os::error_text(static_cast<int>(error)); }

/// 0, or the error of Windows.
inline DWORD write_all(HANDLE to, std::string_view rest) {
    while (!rest.empty()) {
        DWORD count = 0;
        if (::WriteFile(to, rest.data(), static_cast<DWORD>(rest.size()), &count, nullptr) == 0)
            return ::GetLastError();
        if (count == 0) return ERROR_WRITE_FAULT;
        rest.remove_prefix(count);
    }
    return ERROR_SUCCESS;
}

} // namespace tool
