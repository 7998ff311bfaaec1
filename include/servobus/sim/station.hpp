// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Devices on a virtual line: the interface of a device that receives and sends bytes, and a register store
// with a server as such a device. Include it with sim/line.hpp to connect a simulated drive, or implement
// `line_device` for a device of your own.
//
//     servobus::sim::zlac8015d drive;
//     servobus::sim::station station{drive, servobus::milliseconds(2)}; // responds after 2 ms
//     servobus::sim::virtual_line wire{115200};
//     wire.attach(station);
#pragma once

#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/time.hpp>
#include <servobus/modbus/server.hpp>

namespace servobus::sim {

/// A device on a virtual line. The times that it gets never go back.
class line_device {
  public:
    /// Receives a character whose last bit has just passed; `is_readable` is false if the device's UART
    /// cannot decode it, at another baud rate for example.
    virtual void receive(std::uint8_t byte, bool is_readable, instant now) = 0;
    /// Advances the device to `now`. Returns after what time to call it again if it receives nothing before;
    /// above 0.
    virtual duration run(instant now) = 0;
    /// Returned by `run` if nothing happens until the device receives a byte.
    static constexpr duration until_it_receives{0xFFFF'FFFF};
    /// The frame whose first bit is sent now; empty if there is none. Each frame is returned once.
    virtual bytes send(instant now) = 0;
    /// The baud rate of its UART.
    virtual std::uint32_t baud() const = 0;

  protected:
    ~line_device() = default;
};

/// A register store with its server, as a device on a line. If the store has `advance(instant)`, the station
/// advances it with the line's time. If it has `address()` and `baud()`, the station follows them, also when
/// they change. If it has `response_delay()`, responses are delayed at least as long.
template <modbus::register_store Store> class station final : public line_device {
  public:
    /// Takes address, rate and server rules from the store. `response_delay` counts from the last bit of the
    /// request; a response never begins before t3.5.
    explicit station(Store& store, duration response_delay = microseconds(500)) requires requires(Store& s) {
        s.address();
        s.baud();
    } : station{store, store.address(), store.baud(), response_delay, modbus::rules_of(store)} {}

    station(Store& store, std::uint8_t node_address, std::uint32_t baud,
            duration response_delay = microseconds(500), modbus::server_rules rules = {})
        : store_{&store}, server_{node_address, store, modbus::timing_at(baud, modbus::timing_mode::strict),
                                  rules},
          rules_{rules}, delay_{response_delay}, baud_{baud} {}

    void set_response_delay(duration delay) { delay_ = delay; }
    /// True: it waits for a gap of t3.5 before it responds. False, the default: it receives nothing while it
    /// prepares a response, and responds after its delay even if another device is sending. No manual says
    /// which a drive does.
    void set_listening(bool listens) { listens_ = listens; }
    const modbus::server<Store>& server() const { return server_; }

    void receive(std::uint8_t byte, bool is_readable, instant now) override {
        run(now);
        if (server_.is_answering() && !listens_) return;
        if (!server_.is_answering()) last_received_ = now; // its delay counts from here
        // An undecodable character arrives with wrong bits, so that the frame fails its CRC.
        const std::uint8_t seen = is_readable ? byte : static_cast<std::uint8_t>(byte ^ 0x55u);
        server_.feed(bytes{&seen, 1}, now);
    }

    duration run(instant now) override {
        if constexpr (requires { store_->advance(now); }) store_->advance(now);
        if (is_sending_ && went_back(sends_until_, now)) return since(now, sends_until_);
        if (is_sending_) server_.sent(sends_until_);
        is_sending_ = false;
        follow_settings();
        server_.elapse(now);
        const duration idle = since(last_received_, now);
        const duration gap = server_.timing().visible_gap();
        const duration ready = longer_of(gap, response_delay());
        if (idle <= gap) return idle < ready ? ready - idle : microseconds(1);
        if (idle < ready) return ready - idle;
        // The gap has just ended the frame: the response is due another t3.5 later.
        return server_.is_answering() ? duration{server_.timing().t3_5} : until_it_receives;
    }

    bytes send(instant now) override {
        if (is_sending_ || since(last_received_, now) < response_delay()) return {};
        const bytes frame = server_.response(now);
        if (frame.empty()) return {};
        is_sending_ = true;
        sends_until_ = now + server_.timing().wire_time(frame.size());
        return frame;
    }

    std::uint32_t baud() const override { return baud_; }

  private:
    duration response_delay() const {
        if constexpr (requires { store_->response_delay(); }) {
            return longer_of(delay_, store_->response_delay());
        } else {
            return delay_;
        }
    }

    // A power cycle may change the address or the rate.
    void follow_settings() {
        if constexpr (requires { store_->address(), store_->baud(); }) {
            server_.set_address(store_->address());
            if (store_->baud() == baud_) return;
            baud_ = store_->baud();
            server_ = modbus::server<Store>{store_->address(), *store_,
                                            modbus::timing_at(baud_, modbus::timing_mode::strict), rules_};
        }
    }

    Store* store_;
    modbus::server<Store> server_;
    modbus::server_rules rules_;
    duration delay_;
    instant last_received_{};
    instant sends_until_{};
    std::uint32_t baud_;
    bool is_sending_ = false;
    bool listens_ = false;
};

} // namespace servobus::sim
