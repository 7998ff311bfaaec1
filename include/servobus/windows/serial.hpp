// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Hosted, Windows 7 or newer: a COM port (an on-board UART, a USB adapter) as a port of the library. After
// the device was unplugged, every call returns `port_lost`; `reconnecting<serial>` (line/reconnecting.hpp) opens it
// again.
//
//     servobus::windows::serial port;
//     if (port.open("COM3") != servobus::errc::ok) return static_cast<int>(port.os_error());
//     servobus::line line{port, servobus::modbus::timing_at(115200)};
//
// `sent()` is true when the driver has taken all bytes and reports an empty queue, and the wire time of the
// bytes has passed: Windows does not report the last stop bit. So a pair of virtual ports must emulate the
// baud rate (com0com: EmuBR=yes), or a response can arrive before the request counts as sent.
//
// FTDI adapters pass received bytes on after up to 16 ms. The latency timer in the port's advanced settings
// (device manager) should be 1 ms; a program cannot set it by functions of Windows.
//
// The tests run it on wine, over pseudo-terminals. The error codes by which drivers of USB adapters report
// that they were unplugged were not tested: each error that does not mean a lack of memory counts as
// `port_lost`.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <cstddef>
#include <cstdint>
#include <cstring>

#include <servobus/line/port.hpp>
#include <servobus/line/transmission.hpp>
#include <servobus/registers/profile.hpp>
#include <servobus/windows/clock.hpp>
#include <servobus/windows/detail/overlapped_transfer.hpp>

namespace servobus::windows {

/// The settings of a serial device. `settings_of(device::facts)` makes them from a drive's profile.
struct serial_settings {
    std::uint32_t baud = 115200; ///< bits a second; also rates that are not standard, if the driver has them
    character_format format = character_format::n81;
    /// The driver switches the RS-485 driver by RTS (RTS_CONTROL_TOGGLE). If it cannot do so, `open` fails,
    /// since nothing would reach the wire. Adapters that switch by themselves need `false`.
    bool rs485 = false;
    /// The adapter has local echo and the line removes it (`echoed`): `sent` leaves the echo in the receiver.
    bool keeps_echo = false;
    /// Nothing is sent: the port is opened for reading only, `send` fails with `send_failed`, and RTS is withdrawn,
    /// which switches the RS-485 driver of some adapters.
    bool receive_only = false;
};

/// The factory settings of a drive, from its profile.
constexpr serial_settings settings_of(const profile& facts) {
    return {.baud = facts.baud, .format = facts.format, .rs485 = false, .keeps_echo = false};
}

/// What the devices of a line share, as `settings_on_one_line` finds it.
constexpr serial_settings settings_of(const uart_settings& shared) {
    return {.baud = shared.baud, .format = shared.format, .rs485 = false, .keeps_echo = false};
}

namespace detail {

/// The device name of a port: `\\.\COM10` for `COM10`. Without the prefix Windows finds COM1 to COM9 only.
class device_name {
  public:
    explicit device_name(const char* name) {
        constexpr std::size_t prefix_size = 4;
        const bool has_prefix = std::strncmp(name, R"(\\.\)", prefix_size) == 0 ||
                                std::strncmp(name, R"(\\?\)", prefix_size) == 0;
        const std::size_t begin = has_prefix ? 0 : prefix_size;
        const std::size_t size = std::strlen(name);
        if (size == 0 || begin + size >= sizeof text_) return;
        std::memcpy(text_, R"(\\.\)", prefix_size);
        std::memcpy(text_ + begin, name, size + 1);
    }
    /// Empty if the name is empty or too long.
    const char* text() const { return text_; }

  private:
    char text_[260]{};
};

/// Translates the error of a `CreateFile` that has failed. `port_lost` is for all other reasons.
constexpr errc opening_error(DWORD error) {
    switch (error) {
    case ERROR_ACCESS_DENIED: // so Windows says it of a COM port that is open
    case ERROR_SHARING_VIOLATION: return errc::port_in_use;
    case ERROR_FILE_NOT_FOUND:
    case ERROR_PATH_NOT_FOUND:
    case ERROR_INVALID_NAME:
    case ERROR_BAD_PATHNAME:
    case ERROR_DEV_NOT_EXIST:
    case ERROR_DEVICE_NOT_CONNECTED: return errc::no_such_port;
    default: return errc::port_lost;
    }
}

} // namespace detail

/// A COM port, open for this program alone. It does not move, since the system writes to its buffers. A
/// default-constructed one is closed, and every transfer on it returns `errc::port_lost`.
class serial {
  public:
    /// A COM port and its settings: what `reconnecting` opens again. The name is kept by its pointer.
    struct endpoint {
        const char* name = "";
        serial_settings settings{};
    };

    serial() = default;
    serial(const serial&) = delete;
    serial& operator=(const serial&) = delete;
    ~serial() { close(); }

    /// Opens a port by its name, `COM3` or `COM10`, also with the prefix of device names in front, after closing
    /// the one that was open. Bytes that were received before are discarded. Errors, with the system's reason in
    /// `os_error()`:
    /// - `no_such_port`: no port has this name
    /// - `port_in_use`: another program has it. Windows reports a lack of permission in the same way
    /// - `bad_argument`: not a serial device, or a baud rate, format or RS-485 mode that it does not support
    /// - `port_lost`: another reason of the system
    status open(const char* name, const serial_settings& wanted = {}) {
        close();
        if (!reading_.prepare() || !writing_.prepare()) return fail(::GetLastError(), errc::port_lost);
        const detail::device_name device{name};
        if (*device.text() == '\0') return fail(ERROR_INVALID_NAME, errc::no_such_port);
        const DWORD access = wanted.receive_only ? GENERIC_READ : GENERIC_READ | GENERIC_WRITE;
        const HANDLE opened =
            ::CreateFileA(device.text(), access, 0, nullptr, OPEN_EXISTING, FILE_FLAG_OVERLAPPED, nullptr);
        if (opened == nullptr || opened == INVALID_HANDLE_VALUE) {
            const DWORD error = ::GetLastError();
            return fail(error, detail::opening_error(error));
        }
        port_ = opened;
        if (const DWORD error = configure(wanted); error != ERROR_SUCCESS) {
            close();
            return fail(error, errc::bad_argument);
        }
        (void)::PurgeComm(port_, PURGE_RXABORT | PURGE_RXCLEAR | PURGE_TXABORT | PURGE_TXCLEAR);
        keeps_echo_ = wanted.keeps_echo;
        receive_only_ = wanted.receive_only;
        first_ = last_ = 0;
        sending_.restart(wanted.baud, wanted.format == character_format::n81 ? 10u : 11u);
        error_ = ERROR_SUCCESS;
        return errc::ok;
    }
    status open(const endpoint& at) { return open(at.name, at.settings); }

    /// Discards what has been neither sent nor received.
    void close() {
        if (port_ == nullptr) return;
        reading_.cancel(port_);
        writing_.cancel(port_);
        (void)::CloseHandle(port_);
        port_ = nullptr;
        sending_.finish(); // what has not left will not
    }

    bool is_open() const { return port_ != nullptr; }
    /// `GetLastError()` of the last failure, for a message; 0 if there was none.
    std::uint32_t os_error() const { return error_; }

    /// Takes up to 256 bytes; none while the driver has not taken those of the call before. Errors:
    /// `port_lost`, `send_failed` (also if the port is `receive_only`).
    transfer send(bytes out) {
        if (!is_open()) return errc::port_lost;
        if (receive_only_) return errc::send_failed;
        if (const errc before = end_write(); before != errc::ok) return before;
        if (out.empty() || writing_.is_pending()) return std::uint16_t{0};
        constexpr std::size_t most = detail::overlapped_transfer::largest;
        const std::size_t count = out.size() < most ? out.size() : most;
        const instant at = now();
        if (const DWORD error = writing_.write(port_, out.data(), count); error != ERROR_SUCCESS)
            return lose(error, errc::send_failed);
        sending_.add(count, at);
        return static_cast<std::uint16_t>(count);
    }

    /// True when the last stop bit has left the wire; see the top of this header. As it turns true, it discards the
    /// local echo. If it is called later than t3.5 after the end of the request, the bytes may be the response: they
    /// stay, unless this adapter has echoed the last request that was seen in time: then it discards as many of them
    /// as were sent.
    bool sent() {
        if (!sending_.is_under_way()) return true;
        if (is_open()) {
            if (end_write() == errc::ok && writing_.is_pending()) return false;
            if (is_open() && queued().cbOutQue != 0) return false;
        }
        if (!sending_.is_over(now())) return false;
        if (is_open() && !keeps_echo_ && !discard_echo()) return false;
        sending_.finish();
        return true;
    }

    /// Errors: `port_lost`, `receive_failed`.
    transfer receive(byte_buffer in) {
        std::size_t count = take(in, 0);
        while (count < in.size()) {
            if (!is_open()) return count != 0 ? transfer{static_cast<std::uint16_t>(count)} : errc::port_lost;
            if (const errc before = end_read(); before != errc::ok && count == 0) return before;
            const std::size_t had = count;
            count = take(in, count);
            if (count == had) break;
        }
        if (in.empty() && !is_open()) return errc::port_lost;
        if (count != 0 && sending_.is_under_way()) sending_.note_arrival(count, now());
        return static_cast<std::uint16_t>(count);
    }

    instant now() const { return monotonic_now(); }

    /// Sleeps until a byte arrives or `d` has passed. If the device is gone it sleeps for all of `d`, so that
    /// a loop over it does not spin. A Ctrl-C does not end it: Windows runs its handler in another thread. There is no
    /// `wakes_early` as in posix/serial.hpp: Windows ends a sleep at its next tick, up to 16 ms late.
    void wait(duration d) {
        const instant start = now();
        if (first_ != last_) return;
        if (is_open()) (void)end_read();
        if (is_open() && reading_.is_pending()) {
            detail::wait_for(reading_.event(), d);
            (void)end_read();
            if (is_open()) return;
        }
        if (first_ != last_) return;
        const duration passed = since(start, now());
        if (passed < d) sleep_for(d - passed);
    }

  private:
    errc fail(DWORD error, errc why) {
        error_ = error;
        return why;
    }

    // Closes the handle of a device that is gone: it stays gone even if another device gets its name.
    errc lose(DWORD error, errc otherwise) {
        error_ = error;
        if (detail::is_transient(error)) return otherwise;
        close();
        return errc::port_lost;
    }

    DWORD configure(const serial_settings& wanted) {
        if (wanted.baud == 0) return ERROR_INVALID_PARAMETER;
        DCB set{};
        set.DCBlength = sizeof set;
        if (::GetCommState(port_, &set) == 0) return ::GetLastError();
        const bool has_parity =
            wanted.format == character_format::e81 || wanted.format == character_format::o81;
        set.BaudRate = wanted.baud;
        set.ByteSize = 8;
        set.Parity = wanted.format == character_format::e81   ? BYTE{EVENPARITY}
                     : wanted.format == character_format::o81 ? BYTE{ODDPARITY}
                                                              : BYTE{NOPARITY};
        set.StopBits = wanted.format == character_format::n82 ? BYTE{TWOSTOPBITS} : BYTE{ONESTOPBIT};
        set.fBinary = 1;
        set.fParity = has_parity ? 1u : 0u;
        set.fErrorChar = has_parity ? 1u : 0u; // a byte in error reads as 0: the CRC fails
        set.ErrorChar = 0;
        set.fNull = 0;
        set.fAbortOnError = 0; // otherwise each error stops all transfers until it is cleared
        set.fOutxCtsFlow = 0;
        set.fOutxDsrFlow = 0;
        set.fDsrSensitivity = 0;
        set.fOutX = 0;
        set.fInX = 0;
        set.fDtrControl = DTR_CONTROL_ENABLE & 3u;
        set.fRtsControl = wanted.rs485 ? RTS_CONTROL_TOGGLE & 3u : RTS_CONTROL_ENABLE & 3u;
        if (wanted.receive_only) set.fRtsControl = RTS_CONTROL_DISABLE & 3u;
        if (::SetCommState(port_, &set) == 0) return ::GetLastError();
        // Some drivers ignore what they do not have, so the settings are read back.
        DCB got{};
        got.DCBlength = sizeof got;
        if (::GetCommState(port_, &got) == 0) return ::GetLastError();
        const std::uint32_t off =
            got.BaudRate < wanted.baud ? wanted.baud - got.BaudRate : got.BaudRate - wanted.baud;
        if (off > wanted.baud / 32 || got.ByteSize != set.ByteSize || got.Parity != set.Parity ||
            got.StopBits != set.StopBits || (wanted.rs485 && got.fRtsControl != set.fRtsControl))
            return ERROR_INVALID_PARAMETER;
        // A read ends with the first bytes, a write when the driver has taken all.
        COMMTIMEOUTS times{};
        times.ReadIntervalTimeout = MAXDWORD;
        times.ReadTotalTimeoutMultiplier = MAXDWORD;
        times.ReadTotalTimeoutConstant = MAXDWORD - 1;
        if (::SetCommTimeouts(port_, &times) == 0) return ::GetLastError();
        (void)::SetupComm(port_, 4096, 4096); // a recommendation to the driver
        return ERROR_SUCCESS;
    }

    // What the driver has in its queues; closes a port that is gone.
    COMSTAT queued() {
        COMSTAT status{};
        DWORD line_errors = 0;
        if (::ClearCommError(port_, &line_errors, &status) != 0) return status;
        (void)lose(::GetLastError(), errc::receive_failed);
        return COMSTAT{};
    }

    errc end_write() {
        if (!writing_.is_pending()) return errc::ok;
        const detail::overlapped_transfer::progress p = writing_.check(port_);
        return p.error == ERROR_SUCCESS ? errc::ok : lose(p.error, errc::send_failed);
    }

    // Takes the result of the read that has ended. A next one begins when its bytes have been used. There is
    // always one under way, of a single byte if none has arrived: its event ends `wait`.
    errc end_read() {
        for (int tries = 0; tries < 2 && first_ == last_; ++tries) {
            if (!reading_.is_pending()) {
                const std::size_t arrived = queued().cbInQue;
                if (!is_open()) return errc::port_lost;
                constexpr std::size_t most = detail::overlapped_transfer::largest;
                const std::size_t count = arrived < 1 ? 1 : arrived < most ? arrived : most;
                if (const DWORD error = reading_.read(port_, count); error != ERROR_SUCCESS)
                    return lose(error, errc::receive_failed);
            }
            const detail::overlapped_transfer::progress p = reading_.check(port_);
            if (!p.is_done) return errc::ok;
            // Windows cancels a read when the thread that began it ends: then the next one works. If the
            // device is gone, that fails too.
            if (p.error != ERROR_SUCCESS && p.error != ERROR_OPERATION_ABORTED)
                return lose(p.error, errc::receive_failed);
            first_ = 0;
            last_ = p.count;
        }
        return errc::ok;
    }

    // Moves received bytes to `in` from its index `at` on; the index after them.
    std::size_t take(byte_buffer in, std::size_t at) {
        for (; at < in.size() && first_ != last_; ++at) in[at] = reading_.data()[first_++];
        return at;
    }

    // False if a read of bytes that have arrived is under way: it may end a moment after it was begun.
    bool discard_echo() {
        for (int reads = 0; reads < 16; ++reads) {
            if (end_read() != errc::ok) break;
            if (first_ == last_) {
                if (is_open() && reading_.is_pending() && queued().cbInQue != 0) return false;
                break;
            }
            const std::size_t most = sending_.most_to_discard(now());
            if (most == 0) break;
            const std::size_t count = last_ - first_ < most ? last_ - first_ : most;
            sending_.note_discarded(count);
            first_ += count;
            if (first_ != last_) break;
            first_ = last_ = 0;
        }
        sending_.decide_echo(now());
        return true;
    }

    detail::overlapped_transfer reading_;
    detail::overlapped_transfer writing_;
    HANDLE port_ = nullptr;
    transmission sending_{};
    std::uint32_t error_ = 0;
    std::size_t first_ = 0; // of the received bytes in reading_
    std::size_t last_ = 0;
    bool keeps_echo_ = false;
    bool receive_only_ = false;
};

static_assert(waiting_port<serial>);

} // namespace servobus::windows
