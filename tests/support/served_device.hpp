// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A server of rows as a device on a virtual line: its port has the bytes of the line, and their times.
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include <servobus/server/row_server.hpp>
#include <servobus/sim/station.hpp>

namespace tests {

/// The port of the server.
struct served_device_uart {
    servobus::instant time{};
    std::deque<std::uint8_t> arrived{};
    std::vector<std::uint8_t> leaving{};
    servobus::instant has_left_at{};
    bool is_sending = false;
    bool is_garbled = false;

    servobus::transfer send(servobus::bytes all) {
        leaving.assign(all.begin(), all.end());
        return static_cast<std::uint16_t>(all.size());
    }
    bool sent() { return leaving.empty() && !is_sending; }
    servobus::transfer receive(servobus::byte_buffer into) {
        if (is_garbled) {
            is_garbled = false;
            return servobus::errc::receive_failed;
        }
        std::uint16_t n = 0;
        for (; n < into.size() && !arrived.empty(); ++n) {
            into[n] = arrived.front();
            arrived.pop_front();
        }
        return n;
    }
    servobus::instant now() { return time; }
};

/// A `row_server` of `Values`. While it sends, it receives nothing.
template <class Values, servobus::modbus::rtu_timing Timing, class... Options>
class served_device final : public servobus::sim::line_device {
  public:
    served_device(Values& values, std::uint8_t node_address, std::uint32_t baud)
        : server_{uart_, values, node_address}, baud_{baud} {}
    served_device(const served_device&) = delete;
    served_device& operator=(const served_device&) = delete;

    /// True: each response leaves with a wrong CRC.
    void set_wrong_crc(bool is_wrong) { has_wrong_crc_ = is_wrong; }

    void receive(std::uint8_t byte, bool is_readable, servobus::instant now) override {
        run(now);
        if (uart_.is_sending) return; // its receiver is off
        if (is_readable)
            uart_.arrived.push_back(byte);
        else
            uart_.is_garbled = true;
        received_at_ = now;
        server_.step();
    }
    servobus::duration run(servobus::instant now) override {
        uart_.time = now;
        if (uart_.is_sending && !servobus::went_back(uart_.has_left_at, now)) uart_.is_sending = false;
        server_.step();
        const bool is_quiet = servobus::since(received_at_, now) > servobus::milliseconds(5);
        const bool is_busy = server_.is_answering() || uart_.is_sending || !is_quiet;
        return is_busy ? servobus::microseconds(100) : until_it_receives;
    }
    servobus::bytes send(servobus::instant now) override {
        if (uart_.leaving.empty()) return {};
        frame_.swap(uart_.leaving);
        uart_.leaving.clear();
        if (has_wrong_crc_) frame_.back() = static_cast<std::uint8_t>(frame_.back() ^ 1u);
        uart_.is_sending = true;
        uart_.has_left_at = now + Timing.wire_time(frame_.size());
        return frame_;
    }
    std::uint32_t baud() const override { return baud_; }

  private:
    served_device_uart uart_{};
    servobus::row_server<served_device_uart, Values, Timing, Options...> server_;
    std::vector<std::uint8_t> frame_{};
    servobus::instant received_at_{};
    std::uint32_t baud_;
    bool has_wrong_crc_ = false;
};

} // namespace tests
