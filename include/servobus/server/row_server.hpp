// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A Modbus RTU server on a port whose bytes have times, such as a UART of a microcontroller. The device is described by
// its rows: they have the values, and bring along the functions.
//
//     using tank_values = row_values<tank::lowest, tank::level, tank::valve>;
//     constexpr auto timing = modbus::timing_at(115200, modbus::timing_mode::strict);
//     inline tank_values values; // with the factory defaults
//     inline row_server<my_uart, tank_values, timing, with_mask_write> server{uart, values, 7};
//     inline void loop() { server.step(); } // at least once in t3.5
//
// One buffer holds the request and then the response. It is as long as the longest run of rows. The CRC is computed
// while bytes arrive, so a longer request gets its exception all the same.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/core/time.hpp>
#include <servobus/line/port.hpp>
#include <servobus/modbus/rtu.hpp>
#include <servobus/server/options.hpp>
#include <servobus/server/request_executor.hpp>

namespace servobus {

/// A server at one address, with strict timing: a frame begins after a gap of t3.5, ends with one, and has no gap above
/// t1.5. Before the first byte the line counts as quiet. No response is sent to a frame with a bad CRC or of another
/// address, nor to a broadcast.
template <port Port, class Values, modbus::rtu_timing Timing, class... Options>
class row_server : request_executor<Values, Options...> {
    using executor = request_executor<Values, Options...>;
    using crc = typename detail::crc_among<Options...>::type;

    static_assert(Timing.mode == modbus::timing_mode::strict,
                  "a row_server has strict timing: in host timing take a host_row_server");

  public:
    /// `node_address` is 1..247. With `with_hooks<H>` the last argument is the object that has them. All objects
    /// outlive the server.
    template <class... Hooks>
    constexpr row_server(Port& port, Values& values, std::uint8_t node_address, Hooks&... hooks)
        : executor{values, hooks...}, port_{&port}, address_{node_address} {}

    constexpr std::uint8_t address() const { return address_; }
    constexpr void set_address(std::uint8_t node_address) { address_ = node_address; }

    /// Receives what has arrived, executes a request that a gap has ended, or sends more of the response. Never waits.
    /// A request is dropped if the next bytes come before a call has seen the gap after it.
    constexpr void step() {
        if (state_ == state::answering) return send();
        const instant now = port_->now();                     // before the look: no byte of then is newer
        const std::size_t at = count_ < last ? count_ : last; // each byte too many takes the last place
        const transfer came = port_->receive(byte_buffer{frame_ + at, room - at});
        const duration gap = since(last_, now);
        if (came && *came == 0) {
            if (count_ != 0 && gap >= duration{Timing.t3_5}) end_of_frame();
            return;
        }
        last_ = now;
        if (!came) return give_up(); // garbled
        const std::size_t arrived = *came;
        if (count_ != 0 && gap > Timing.longest_gap(arrived)) state_ = state::bad;
        add_to_crc(frame_ + at, arrived);
        count_ += static_cast<u32>(arrived);
    }

    /// True from the end of a request that has a response until the response has left.
    constexpr bool is_answering() const { return state_ == state::answering; }

  private:
    enum class state : std::uint8_t { listening, bad, answering };

    static constexpr std::size_t leading_bytes = detail::leading_bytes_among<Options...>;
    static constexpr std::size_t room = executor::buffer_size + 3 + leading_bytes;
    static constexpr std::size_t last = room - 1;
    using position = std::conditional_t<(room < 256), std::uint8_t, u16>;

    [[gnu::noinline]] constexpr void add_to_crc(const std::uint8_t* data, std::size_t size) {
        crc_ = crc::update(crc_, bytes{data, size});
    }

    // True if what has been received is a frame. It is then at the beginning of the buffer and has `size` bytes.
    constexpr bool is_frame(std::size_t& size) {
        if (state_ != state::listening || size < modbus::min_frame || size > modbus::max_frame) return false;
        if (crc::end(crc_) == 0) return true;
        if constexpr (leading_bytes != 0) {
            if (size > room) return false; // the buffer has lost a part
            for (std::size_t skipped = 1; skipped <= leading_bytes && size > modbus::min_frame; ++skipped) {
                if (frame_[0] != 0x00 && frame_[0] != 0xFF) return false;
                --size;
                for (std::size_t i = 0; i < size; ++i) frame_[i] = frame_[i + 1];
                if (modbus::crc16<crc>(bytes{frame_, size}) == 0) return true;
            }
        }
        return false;
    }

    constexpr void end_of_frame() {
        std::size_t size = count_;
        const bool is_good = is_frame(size);
        count_ = 0;
        state_ = state::listening;
        crc_ = crc::begin();
        if (!is_good) return;
        const std::uint8_t to = frame_[0];
        if (to != address_ && (to != modbus::broadcast || !executor::takes_broadcast(frame_[1]))) return;
        const std::size_t answered = this->execute_at(frame_ + 1, executor::buffer_size, size - 3);
        if (answered == 0 || to == modbus::broadcast) return;
        add_to_crc(frame_, answered + 1);
        const std::uint16_t check = crc::end(crc_);
        frame_[answered + 1] = static_cast<std::uint8_t>(check & 0xFFu);
        frame_[answered + 2] = static_cast<std::uint8_t>(check >> 8);
        count_ = static_cast<u32>(answered + 3);
        sent_ = 0;
        state_ = state::answering;
    }

    constexpr void send() {
        if (sent_ != count_) {
            const transfer taken =
                port_->send(bytes{frame_ + sent_, static_cast<std::size_t>(count_ - sent_)});
            sent_ = taken ? static_cast<position>(sent_ + *taken)
                          : static_cast<position>(count_); // a failed port: the client repeats
            return;
        }
        if (!port_->sent()) return;
        last_ = port_->now();
        give_up();
    }

    // Until t3.5 has passed, what comes belongs to no frame.
    constexpr void give_up() {
        state_ = state::bad;
        count_ = 1;
    }

    Port* port_;
    instant last_{};
    typename crc::state crc_ = crc::begin();
    u32 count_ = 0; // bytes received, or of the response
    position sent_ = 0;
    std::uint8_t address_;
    state state_ = state::listening;
    std::uint8_t frame_[room]{};
};

} // namespace servobus
