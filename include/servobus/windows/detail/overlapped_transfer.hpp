// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Internal: a read or a write of a COM port that goes on while the program runs, and which errors are transient.
// windows/serial.hpp includes it.
//
//     HANDLE port = ::CreateFileA("COM3", GENERIC_READ, 0, nullptr, OPEN_EXISTING, FILE_FLAG_OVERLAPPED, nullptr);
//     servobus::windows::detail::overlapped_transfer reading;
//     if (!reading.prepare() || reading.read(port, 8) != ERROR_SUCCESS) return 1;
//     while (!reading.check(port).is_done) servobus::windows::sleep_for(servobus::milliseconds(1));
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include <servobus/windows/clock.hpp>

namespace servobus::windows::detail {

/// Errors of a system that lacks memory. The device is still there after them.
inline bool is_transient(DWORD error) {
    return error == ERROR_NOT_ENOUGH_MEMORY || error == ERROR_OUTOFMEMORY ||
           error == ERROR_NO_SYSTEM_RESOURCES || error == ERROR_NOT_ENOUGH_QUOTA ||
           error == ERROR_WORKING_SET_QUOTA;
}

/// A read or a write of up to 256 bytes that may take longer than the call that starts it. The system uses
/// the buffer meanwhile, so it neither moves nor ends before the transfer has.
class overlapped_transfer {
  public:
    static constexpr std::size_t largest = 256; // the largest frame

    struct progress {
        bool is_done;
        DWORD count; ///< bytes, if it is done
        DWORD error; ///< ERROR_SUCCESS if it is not done
    };

    overlapped_transfer() = default;
    overlapped_transfer(const overlapped_transfer&) = delete;
    overlapped_transfer& operator=(const overlapped_transfer&) = delete;
    ~overlapped_transfer() { release(); }

    bool prepare() {
        if (event_ == nullptr) event_ = ::CreateEventW(nullptr, TRUE, FALSE, nullptr);
        return event_ != nullptr;
    }
    void release() {
        if (event_ != nullptr) (void)::CloseHandle(event_);
        event_ = nullptr;
    }

    bool is_pending() const { return is_pending_; }
    HANDLE event() const { return event_; }
    const std::uint8_t* data() const { return buffer_; }

    /// Both return ERROR_SUCCESS if the transfer has begun. `check` reports its end.
    DWORD read(HANDLE port, std::size_t count) {
        reset();
        return begun(::ReadFile(port, buffer_, static_cast<DWORD>(count), nullptr, &state_));
    }
    DWORD write(HANDLE port, const std::uint8_t* from, std::size_t count) {
        reset();
        std::memcpy(buffer_, from, count);
        return begun(::WriteFile(port, buffer_, static_cast<DWORD>(count), nullptr, &state_));
    }

    /// Does not wait.
    progress check(HANDLE port) { return finished(port, FALSE); }

    /// Cancels it and waits until the system has released the buffer.
    void cancel(HANDLE port) {
        if (!is_pending_) return;
        (void)::CancelIoEx(port, &state_);
        (void)finished(port, TRUE);
        is_pending_ = false;
    }

  private:
    void reset() {
        state_ = OVERLAPPED{};
        state_.hEvent = event_;
    }
    DWORD begun(BOOL is_complete) {
        const DWORD error = is_complete != 0 ? ERROR_SUCCESS : ::GetLastError();
        is_pending_ = error == ERROR_SUCCESS || error == ERROR_IO_PENDING;
        return is_pending_ ? ERROR_SUCCESS : error;
    }
    progress finished(HANDLE port, BOOL waits) {
        DWORD count = 0;
        const bool succeeded = ::GetOverlappedResult(port, &state_, &count, waits) != 0;
        const DWORD error = succeeded ? ERROR_SUCCESS : ::GetLastError();
        if (error == ERROR_IO_INCOMPLETE) return {false, 0, ERROR_SUCCESS};
        is_pending_ = false;
        return {true, succeeded ? count : 0, error};
    }

    OVERLAPPED state_{};
    HANDLE event_ = nullptr;
    bool is_pending_ = false;
    std::uint8_t buffer_[largest]{};
};

} // namespace servobus::windows::detail
