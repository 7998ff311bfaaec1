// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A simulated drive that counts its frames and can inject a fault at a frame of a given number. For tests
// that inject a fault at every frame that a program sends, where a line of single bytes would be too slow.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <servobus/modbus/server.hpp>
#include <tests/support/line_and_client.hpp>

namespace simulated {

using servobus::bytes, servobus::byte_buffer, servobus::duration, servobus::instant, servobus::transfer;
namespace modbus = servobus::modbus;

enum class mishap {
    none,
    no_more_requests,  ///< the line is lost: the drive receives nothing from this frame on
    no_more_responses, ///< the drive receives requests, and its responses are lost
    request_lost,
    response_lost,
    response_damaged,
    response_late,      ///< after its limit: the next request may be on its way
    refused,            ///< by exception 4, device failure
    port_lost_sending,  ///< before this frame, and back after 50 ms
    port_lost_awaiting, ///< after this frame, and back after 50 ms
    restart,            ///< the drive restarts after this frame and receives nothing while it boots
    blink,              ///< the drive restarts after this frame and boots in no time
};

/// A simulated drive with its own address and baud rate, and a port to it. The port transfers whole frames
/// and takes about their time on the wire.
template <class Model> class frame_port {
  public:
    using frame = std::vector<std::uint8_t>;

    explicit frame_port(const Model& drive) : model{drive}, baud{drive.baud()} {}

    Model model;
    std::uint32_t baud;
    std::vector<frame> requests;           ///< including the lost ones
    std::vector<Model>* history = nullptr; ///< receives a copy of the drive after each frame

    // The port

    transfer send(bytes out) {
        if (what_ == mishap::port_lost_sending && requests.size() == strikes_at_) lose();
        if (is_lost()) return servobus::errc::port_lost;
        requests.emplace_back(out.begin(), out.end());
        time_ += wire_time(out.size());
        carry(out);
        return static_cast<std::uint16_t>(out.size());
    }
    bool sent() { return true; }
    transfer receive(byte_buffer in) {
        if (is_lost()) return servobus::errc::port_lost;
        if (!late_.empty() && time_ >= late_due_) {
            const std::size_t n = late_.size() < in.size() ? late_.size() : in.size();
            for (std::size_t i = 0; i < n; ++i) in[i] = late_[i];
            late_.erase(late_.begin(), late_.begin() + static_cast<std::ptrdiff_t>(n));
            return static_cast<std::uint16_t>(n);
        }
        if (size_ == 0 || time_ < due_) return std::uint16_t{0};
        const std::size_t n = size_ < in.size() ? size_ : in.size();
        for (std::size_t i = 0; i < n; ++i) in[i] = response_[given_ + i];
        given_ += n;
        size_ -= n;
        return static_cast<std::uint16_t>(n);
    }
    instant now() { return instant{static_cast<std::uint32_t>(++time_)}; }
    void wait(duration longest) {
        std::uint64_t end = time_ + longest.us;
        if (size_ != 0 && due_ < end) end = due_;
        if (!late_.empty() && late_due_ < end) end = late_due_;
        if (end > time_) time_ = end;
    }

    // For the test

    void pass(duration time) {
        time_ += time.us;
        model.advance(instant{static_cast<std::uint32_t>(time_)});
    }
    std::uint64_t time_us() const { return time_; }

    /// Injects this fault at frame `number`, where the next frame is 0.
    void plan(mishap what, std::size_t number) {
        what_ = what;
        strikes_at_ = requests.size() + number;
        has_struck_ = false;
    }
    mishap planned() const { return what_; }
    void mend() { what_ = mishap::none; }
    bool has_struck() const { return has_struck_; }
    std::uint64_t struck_at() const { return struck_at_; }
    /// True if the motor was energised since the drive was switched on again.
    bool has_been_energised() const { return model.enables() != enables_before_; }

    /// A restart lasts longer than all tries of one read, 3 x 100 ms. A blink loses no frame.
    static constexpr duration boot = servobus::milliseconds(500);
    /// In addition to its time: later than any limit of the tests.
    static constexpr duration late_by = servobus::milliseconds(150);
    static constexpr duration lost_for = servobus::milliseconds(50);

  private:
    std::uint64_t wire_time(std::size_t size) const { return 11'000'000u / baud * size; }

    void lose() {
        if (has_struck_) return;
        has_struck_ = true;
        struck_at_ = time_;
        lost_until_ = time_ + lost_for.us;
        size_ = 0;
    }
    bool is_lost() const { return time_ < lost_until_; }

    void carry(bytes request) {
        const std::size_t number = requests.size() - 1;
        const bool is_it = what_ != mishap::none && number == strikes_at_;
        const bool is_over = what_ != mishap::none && number > strikes_at_;
        if (is_it && what_ != mishap::port_lost_sending) {
            has_struck_ = true;
            struck_at_ = time_;
        }
        model.advance(instant{static_cast<std::uint32_t>(time_)});
        size_ = given_ = 0;
        const bool is_cut = what_ == mishap::no_more_requests && (is_it || is_over);
        const bool is_booting = what_ == mishap::restart && is_over && time_ - struck_at_ < boot.us;
        if (is_cut || is_booting || (what_ == mishap::request_lost && is_it)) return;
        if (request[0] != model.address() || baud != model.baud()) return;
        const bytes pdu = request.subspan(1, request.size() - 3);
        std::size_t size = 2;
        if (what_ == mishap::refused && is_it) {
            response_[1] = static_cast<std::uint8_t>(request[1] | 0x80u);
            response_[2] = 4;
        } else {
            size = modbus::respond(model, pdu, byte_buffer{response_}.subspan(1), model.rules());
        }
        if (history != nullptr) history->push_back(model);
        if ((what_ == mishap::restart || what_ == mishap::blink) && is_it) {
            model.power_cycle();
            enables_before_ = model.enables();
        }
        if (what_ == mishap::no_more_responses && (is_it || is_over)) return;
        if (what_ == mishap::response_lost && is_it) return;
        response_[0] = request[0];
        size_ = modbus::close_frame(response_, size);
        due_ = time_ + 2000 + wire_time(size_);
        if (!is_it) return;
        if (what_ == mishap::response_damaged) response_[size_ / 2] ^= 0x10u;
        if (what_ == mishap::port_lost_awaiting) lost_until_ = time_ + lost_for.us;
        if (what_ == mishap::port_lost_awaiting) size_ = 0;
        if (what_ != mishap::response_late) return;
        late_.assign(response_.begin(), response_.begin() + static_cast<std::ptrdiff_t>(size_));
        late_due_ = due_ + late_by.us;
        size_ = 0;
    }

    std::array<std::uint8_t, modbus::max_frame> response_{};
    std::size_t size_ = 0;
    std::size_t given_ = 0;
    std::uint64_t time_ = 0;
    std::uint64_t due_ = 0;
    std::uint64_t struck_at_ = 0;
    std::uint64_t lost_until_ = 0;
    frame late_;
    std::uint64_t late_due_ = 0;
    std::size_t strikes_at_ = 0;
    std::uint32_t enables_before_ = 0;
    mishap what_ = mishap::none;
    bool has_struck_ = false;
};

} // namespace simulated
