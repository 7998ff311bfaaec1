// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Reads the drive by a bare exchange, without a line or a client: the smallest use of the library, where the
// program itself waits for the gap, sends, and passes the received bytes on one by one.
#pragma once

#include <array>
#include <cstdint>

#include "job.hpp"

/// Reads status, faults, positions and speeds once. Call `turn()` in each loop iteration; it never waits.
template <servobus::port Port> class bare_look {
  public:
    constexpr explicit bare_look(Port& on) : port_{&on} {}
    // Not copyable: the exchange refers to the buffer.
    bare_look(const bare_look&) = delete;
    bare_look& operator=(const bare_look&) = delete;

    /// Starts a read. The request is sent after a gap of `silence`: t3.5, or longer after an error.
    void begin(servobus::duration silence) {
        began_ = port_->now();
        silence_ = silence;
        taken_ = 0;
        exchange_ = servobus::modbus::exchange{request, response_, job::timing, limits};
    }

    void turn() {
        if (exchange_.state() == servobus::modbus::exchange::phase::ready) {
            leave();
        } else {
            receive();
        }
    }

    bool is_over() const { return exchange_.done(); }
    servobus::errc error() const { return exchange_.status().error(); }
    job::zlac::feedback seen() const {
        std::array<std::uint16_t, words> got{};
        if (exchange_.words().size() == words) exchange_.words().copy_to(got);
        return job::zlac::feedback::from_words(got);
    }

  private:
    void leave() {
        if (since(began_, port_->now()) < silence_) return;
        if (taken_ < request.size) {
            const servobus::transfer took = port_->send(servobus::bytes{request}.subspan(taken_));
            if (!took) return exchange_.abort(took.error(), taken_ != 0);
            taken_ += *took;
        }
        if (taken_ == request.size && port_->sent()) exchange_.sent(port_->now());
    }

    void receive() {
        const servobus::instant before = port_->now(); // more bytes may come after the look for one
        std::uint8_t byte = 0;
        const servobus::transfer came = port_->receive({&byte, 1});
        if (!came) return exchange_.abort(came.error(), true);
        if (*came == 1) {
            exchange_.feed_late(byte, port_->now());
        } else {
            exchange_.elapse(before);
        }
    }

    static constexpr std::uint16_t words =
        job::zlac::right_actual_speed.address - job::zlac::status_word.address + 1;
    static constexpr auto request =
        servobus::modbus::read_frame(1, job::zlac::status_word.address, words); // in flash, with its CRC
    static constexpr servobus::response_limits limits = job::patient_node().limits;

    Port* port_;
    std::array<std::uint8_t, 5u + 2u * words> response_{};
    servobus::modbus::exchange exchange_{};
    servobus::instant began_{};
    servobus::duration silence_{};
    std::size_t taken_ = 0;
};
