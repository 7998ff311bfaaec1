// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A register store that records every request executed on it. The reports of a client are compared with this
// record. It takes the drive's place on the line, so that the address can be changed at any time.
#pragma once

#include <bitset>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <servobus/core/time.hpp>
#include <servobus/modbus/server.hpp>

namespace trial {

/// A request that reached a device's registers.
struct execution {
    bool is_write = false;
    std::uint8_t refusal = 0; ///< 0: carried out
    std::uint16_t address = 0;
    std::vector<std::uint16_t> words; ///< that were read or written
    std::uint64_t transaction = 0;    ///< the number of the last request on the wire
};

/// `transaction` is counted elsewhere and must outlive it.
template <servobus::modbus::register_store Store> class witness {
  public:
    template <class... Options>
    witness(const std::uint64_t& transaction, std::uint8_t node_address, std::uint32_t baud,
            Options... options)
        : store_{options...}, transaction_{&transaction}, baud_{baud}, address_{node_address} {}

    std::uint8_t read(std::uint16_t address, std::span<std::uint16_t> to) {
        const std::uint8_t refusal = store_.read(address, to);
        has_refused_[refusal] = refusal != 0;
        executed_.push_back({false, refusal, address, {to.begin(), to.end()}, *transaction_});
        return refusal;
    }
    std::uint8_t write(std::uint16_t address, servobus::words_view from) {
        const std::uint8_t refusal = store_.write(address, from);
        has_refused_[refusal] = refusal != 0;
        execution e{true, refusal, address, {}, *transaction_};
        for (std::size_t i = 0; i < from.size(); ++i) e.words.push_back(from[i]);
        executed_.push_back(std::move(e));
        return refusal;
    }
    void advance(servobus::instant now) {
        if constexpr (requires(Store & s) { s.advance(now); }) store_.advance(now);
    }
    std::uint8_t address() const { return address_; }
    std::uint32_t baud() const { return baud_; }
    servobus::modbus::server_rules rules() const { return servobus::modbus::rules_of(store_); }
    servobus::duration response_delay() const {
        if constexpr (requires(const Store& s) { s.response_delay(); }) {
            return store_.response_delay();
        } else {
            return {};
        }
    }

    void set_address(std::uint8_t node_address) { address_ = node_address; }
    void power_cycle() { store_.power_cycle(); }
    std::vector<execution>& executed() { return executed_; }
    /// The store has returned this exception at least once.
    bool has_refused(std::uint8_t exception) const { return has_refused_[exception]; }
    Store& store() { return store_; }

  private:
    Store store_;
    std::vector<execution> executed_;
    std::bitset<256> has_refused_;
    const std::uint64_t* transaction_;
    std::uint32_t baud_;
    std::uint8_t address_;
};

} // namespace trial
