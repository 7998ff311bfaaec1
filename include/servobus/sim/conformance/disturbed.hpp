// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A simulated drive to which something may happen before or after it carries out a request. sim/conformance/trial.hpp
// connects it to the line.
//
//     struct counter { // an observer that only counts
//         unsigned requests = 0;
//         std::uint8_t before() { return ++requests, std::uint8_t{0}; }
//         void after() {}
//     };
#pragma once

#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/slice.hpp>
#include <servobus/core/time.hpp>

namespace servobus::sim {

/// The simulated drive of an author, as the line's station calls it. `Observer` is told of each request: `before()`
/// returns 0, or an exception with which the request is refused, and `after()` follows what was carried out.
template <class Machine, class Observer> class disturbed {
  public:
    /// `make` returns the machine: it need not be copied.
    template <class Make>
    disturbed(Observer& observer, const Make& make) : machine{make()}, observer_{&observer} {}

    std::uint8_t read(std::uint16_t address, slice<std::uint16_t> to) {
        if (const std::uint8_t refusal = observer_->before(); refusal != 0) return refusal;
        const std::uint8_t refusal = machine.read(address, to);
        observer_->after();
        return refusal;
    }
    std::uint8_t write(std::uint16_t address, words_view from) {
        if (const std::uint8_t refusal = observer_->before(); refusal != 0) return refusal;
        const std::uint8_t refusal = machine.write(address, from);
        observer_->after();
        return refusal;
    }

    // What a station asks a store that has it.
    void advance(instant now) requires requires(Machine& m) { m.advance(now); }
    { machine.advance(now); }
    auto rules() const requires requires(const Machine& m) { m.rules(); }
    { return machine.rules(); }
    std::uint8_t address() const requires requires(const Machine& m) { m.address(); }
    { return machine.address(); }
    std::uint32_t baud() const requires requires(const Machine& m) { m.baud(); }
    { return machine.baud(); }
    duration response_delay() const requires requires(const Machine& m) { m.response_delay(); }
    { return machine.response_delay(); }

    Machine machine;

  private:
    Observer* observer_;
};

} // namespace servobus::sim
