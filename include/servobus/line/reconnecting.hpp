// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A port that opens itself again after it was lost, as a USB adapter that was unplugged or a gateway that restarts.
//
//     reconnecting<posix::serial> port{"/dev/serial/by-id/usb-FTDI_FT232R-if00-port0", posix::serial_settings{}};
//     line wire{port, modbus::timing_at(115200)};
//     if (port.take_change()) std::puts(text(port.why().error())); // "ok", "the port is gone", "there is no such port"
//
//   open --a call finds the loss--> lost --an attempt, and the call reports the loss--> open
//
// Nothing moves by itself for that. The call that opens the port still returns `port_lost`: no frame crosses the loss.
// Line and facades drop what they knew of the drives. A drive that may be moving is stopped first (G21, G45). Each
// motion needs a command of the program again, or in a `setpoint_loop` a consent (G44).
//
// Attempts are made in `send` and `receive`, while the program asks something of the line:
// - A serial device is tried 500 ms after the loss or the last attempt.
// - A port of the network is tried after 100 ms. Each attempt or connection without a received byte doubles that, up to
//   3.2 s.
//
// An attempt takes as long as `open` does. Over a network that is up to `connect_within`, and the resolution of a name
// has no limit. If other lines share the thread, give a short `connect_within` and a numeric address.
//
// The path is looked up anew in each attempt. An adapter that was `/dev/ttyUSB0` may return as `/dev/ttyUSB1`, and
// another one take the old name. So give a name that follows the adapter. On Linux that is a link of udev:
// - `/dev/serial/by-id/...` is this adapter, wherever it is plugged in;
// - `/dev/serial/by-path/...` is whatever is in this socket.
//
// Windows keeps the COM number of an adapter that has a serial number. A program that knows better has `set_endpoint`.
//
// Nothing is allocated: the texts of the endpoint are kept by their pointers.
#pragma once

#include <servobus/core/cxx20.hpp>

#include <concepts>
#include <cstdint>
#include <utility>

#include <servobus/core/status.hpp>
#include <servobus/core/time.hpp>
#include <servobus/line/port.hpp>

namespace servobus {

/// A port that `reconnecting` can open. Its `endpoint` says what to open, and `open` closes what was open before. While
/// it is closed each transfer returns `port_lost`, and its clock goes on. The pauses between attempts grow where it has
/// `static constexpr bool is_network = true`.
template <class P>
concept reopenable_port = port<P> && requires(P& p, const P& closed, const typename P::endpoint& at) {
    { p.open(at) } -> std::same_as<status>;
    { closed.is_open() } -> std::same_as<bool>;
    p.close();
};

/// A `Port` that opens itself, at first in its constructor; see the top of this header. It does not move.
template <reopenable_port Port> class reconnecting {
  public:
    using endpoint = typename Port::endpoint;
    static constexpr bool has_gateway = servobus::has_gateway<Port>;

    /// Takes what the port's `open` takes, and makes the first attempt: `why()` says how it ended.
    template <class... Parts>
    requires requires(const Parts&... of) { endpoint{of...}; }
    explicit reconnecting(const Parts&... of) : at_{of...} { attempt(); }
    reconnecting(const reconnecting&) = delete; // a line refers to it
    reconnecting& operator=(const reconnecting&) = delete;
    ~reconnecting() = default;

    transfer send(bytes frame) {
        return may_transfer() ? noted(port_.send(frame)) : transfer{errc::port_lost};
    }
    bool sent() { return !port_.is_open() || port_.sent(); }
    transfer receive(byte_buffer into) {
        if (!may_transfer()) return errc::port_lost;
        const transfer t = noted(port_.receive(into));
        has_received_ = has_received_ || (t && *t != 0);
        return t;
    }
    instant now() { return port_.now(); }
    void wait(duration d) requires waiting_port<Port> { port_.wait(d); }
    void expect(std::uint16_t missing) requires expecting_port<Port> { port_.expect(missing); }

    bool is_open() const { return is_open_ && port_.is_open(); }
    /// `ok` while it is open, `port_lost` from a loss to the next attempt, then the error of the last attempt.
    status why() const { return is_open_ && !port_.is_open() ? status{errc::port_lost} : why_; }
    /// True once after the first attempt, each opening and each loss. Between a loss and the next opening at least one
    /// pause passes: a program that asks more often misses none.
    bool take_change() {
        note_loss();
        return std::exchange(has_changed_, false);
    }
    /// From the next attempt on this is opened. An open port stays as it is.
    void set_endpoint(const endpoint& at) { at_ = at; }
    /// Closes the port, as a loss: for a connection on which a response may still be under way. It is opened again
    /// after its pause.
    void drop() {
        if constexpr (requires(Port & p) { p.abort(); })
            port_.abort();
        else
            port_.close();
        note_loss();
    }
    /// For what it says beside transfers, such as `os_error()`.
    const Port& port() const { return port_; }
    /// As that of a port of Modbus TCP; it stays as set when the port is opened again.
    void set_peer_unit(std::uint8_t unit) requires requires(Port& p) { p.set_peer_unit(unit); }
    { port_.set_peer_unit(unit); }

  private:
    static constexpr bool is_network = requires { requires Port::is_network; };
    static constexpr duration first_pause = milliseconds(is_network ? 100 : 500);
    static constexpr duration longest_pause = milliseconds(is_network ? 3200 : 500);

    // False also in the call that opens the port: so a call reports each loss, whoever has found it.
    bool may_transfer() {
        note_loss();
        if (is_open_) return true;
        if (since(ended_, port_.now()) >= pause_) attempt();
        return false;
    }
    transfer noted(const transfer& t) {
        note_loss();
        return t;
    }
    void attempt() {
        why_ = port_.open(at_);
        is_open_ = static_cast<bool>(why_);
        has_changed_ = has_changed_ || is_open_ || pause_ == duration{};
        if (!is_open_) begin_pause();
    }
    void note_loss() {
        if (!is_open_ || port_.is_open()) return;
        is_open_ = false;
        has_changed_ = true;
        why_ = errc::port_lost;
        begin_pause();
    }
    void begin_pause() {
        const bool is_first = std::exchange(has_received_, false) || pause_ == duration{};
        const duration next = is_first ? first_pause : pause_ * 2;
        pause_ = next < longest_pause ? next : longest_pause;
        ended_ = port_.now();
    }

    Port port_{};
    endpoint at_;
    duration pause_{}; // before the next attempt; zero until the first failure
    instant ended_{};  // the loss, or the last attempt
    status why_{};
    bool is_open_ = false;      // as the last call has found it
    bool has_received_ = false; // on this connection
    bool has_changed_ = false;
};

} // namespace servobus
