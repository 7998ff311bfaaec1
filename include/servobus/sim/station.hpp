// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What hangs on a virtual line: any device that hears bytes and says some, and a register store behind a
// server as such a device.
#pragma once

#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/time.hpp>
#include <servobus/modbus/server.hpp>

namespace servobus::sim {

/// What hangs on a virtual line. Its times never go back.
class line_device {
  public:
    /// A character's last bit has passed by; `is_readable` is false if it was garbled for this device's UART,
    /// by another baud rate for example.
    virtual void hear(std::uint8_t byte, bool is_readable, instant now) = 0;
    /// Time passes. Returns after what time to be called again, if nothing is heard before; above 0.
    virtual duration run(instant now) = 0;
    /// Nothing will happen of itself.
    static constexpr duration until_it_hears{0xFFFF'FFFF};
    /// The frame whose first bit leaves now; empty if there is none. Asked once for each frame.
    virtual bytes talk(instant now) = 0;
    /// The rate its UART is set to.
    virtual std::uint32_t baud() const = 0;

  protected:
    ~line_device() = default;
};

/// A register store with its server, hung on a line. Where the store has `advance(instant)` it is kept in
/// time, where it has `unit()` and `baud()` it is heard at its own address and rate, and where it has
/// `response_delay()` its responses wait as long.
template <modbus::register_store Store> class station final : public line_device {
  public:
    /// The drive as it comes: its own address and rate. `response_delay` counts from the request's last bit;
    /// the response never begins before t3.5.
    explicit station(Store& store, duration response_delay = microseconds(500)) requires requires(Store& s) {
        s.unit();
        s.baud();
    } : station{store, store.unit(), store.baud(), response_delay, modbus::rules_of(store)} {}

    station(Store& store, std::uint8_t unit, std::uint32_t baud, duration response_delay = microseconds(500),
            modbus::server_rules rules = {})
        : store_{&store}, server_{unit, store, modbus::timing_at(baud, modbus::timing_mode::strict), rules},
          rules_{rules}, delay_{response_delay}, baud_{baud} {}

    void set_response_delay(duration delay) { delay_ = delay; }
    /// Whether it waits for a gap of t3.5 before it answers, or begins when its delay is over even if another
    /// one sends, as a drive does that does not listen while it works. No manual says which; it does not,
    /// unless told.
    void set_listening(bool listens) { listens_ = listens; }
    const modbus::server<Store>& server() const { return server_; }

    void hear(std::uint8_t byte, bool is_readable, instant now) override {
        run(now);
        if (server_.is_answering() && !listens_) return;
        if (!server_.is_answering()) last_heard_ = now; // from here its delay counts
        // A garbled character makes a frame worthless; its bits fit no CRC.
        const std::uint8_t seen = is_readable ? byte : static_cast<std::uint8_t>(byte ^ 0x55u);
        server_.feed(bytes{&seen, 1}, now);
    }

    duration run(instant now) override {
        if constexpr (requires { store_->advance(now); }) store_->advance(now);
        if (is_talking_ && went_back(talks_until_, now)) return since(now, talks_until_);
        if (is_talking_) server_.sent(talks_until_);
        is_talking_ = false;
        follow_settings();
        server_.elapse(now);
        const duration quiet = since(last_heard_, now);
        const duration silence = server_.timing().visible_silence();
        const duration ready = longer_of(silence, response_delay());
        if (quiet <= silence) return quiet < ready ? ready - quiet : microseconds(1);
        if (quiet < ready) return ready - quiet;
        // A frame that only its silence ended: the response is due another one later.
        return server_.is_answering() ? duration{server_.timing().t3_5} : until_it_hears;
    }

    bytes talk(instant now) override {
        if (is_talking_ || since(last_heard_, now) < response_delay()) return {};
        const bytes frame = server_.response(now);
        if (frame.empty()) return {};
        is_talking_ = true;
        talks_until_ = now + server_.timing().wire_time(frame.size());
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

    // A drive may come back from a power cycle with another address or rate.
    void follow_settings() {
        if constexpr (requires { store_->unit(), store_->baud(); }) {
            server_.set_unit(store_->unit());
            if (store_->baud() == baud_) return;
            baud_ = store_->baud();
            server_ = modbus::server<Store>{store_->unit(), *store_,
                                            modbus::timing_at(baud_, modbus::timing_mode::strict), rules_};
        }
    }

    Store* store_;
    modbus::server<Store> server_;
    modbus::server_rules rules_;
    duration delay_;
    instant last_heard_{};
    instant talks_until_{};
    std::uint32_t baud_;
    bool is_talking_ = false;
    bool listens_ = false;
};

} // namespace servobus::sim
