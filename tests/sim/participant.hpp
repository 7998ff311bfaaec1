// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A participant of the line: a device, everything between it and the wire, and its client.
#pragma once

#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include <servobus/client/client.hpp>
#include <servobus/registers/catalogue.hpp>
#include <servobus/sim/station.hpp>

#include "hostile_device.hpp"
#include "lines.hpp"
#include "test_device.hpp"
#include "witness.hpp"

namespace trial {

/// A node on the simulated line, whatever its device is.
class participant {
  public:
    participant() = default;
    participant(const participant&) = delete;
    participant& operator=(const participant&) = delete;
    virtual ~participant() = default;

    // The device
    virtual hostile_device& device() = 0;
    virtual std::vector<execution>& executed() = 0;
    virtual bool has_refused(std::uint8_t exception) const = 0;
    virtual servobus::modbus::server_rules rules() const = 0;
    virtual std::uint8_t device_address() const = 0;
    virtual void set_device_address(std::uint8_t node_address) = 0;
    virtual void set_delay(servobus::duration delay) = 0;
    /// The shortest response delay of the drive itself.
    virtual servobus::duration own_delay() const = 0;
    virtual void set_listening(bool listens) = 0;
    virtual void reboot(std::uint64_t off_until_us) = 0;
    virtual const servobus::catalogue& map() const = 0;
    virtual bool is_test_device() const = 0;
    virtual drive_kind kind() const = 0;
    /// Of the device's switches.
    virtual const switch_positions& positions() const = 0;

    // Its client
    virtual std::uint8_t& address() = 0;
    virtual servobus::response_limits& limits() = 0;
    virtual servobus::bus_gaps& gaps() = 0;
    virtual unsigned retries() = 0;
    virtual servobus::status read(std::uint16_t address, std::span<std::uint16_t> words,
                                  servobus::modbus::function code) = 0;
    virtual servobus::status write(std::uint16_t address, std::uint16_t value) = 0;
    virtual servobus::status write(std::uint16_t address, std::span<const std::uint16_t> words) = 0;
    virtual servobus::status transact(servobus::bytes pdu, servobus::byte_buffer response) = 0;

    std::uint32_t usual_delay_us = 0;
    std::uint64_t slow_until = 0;

    /// The client uses the device's present address.
    bool is_where_it_is_looked_for() { return address() == device_address(); }
};

template <class Line, servobus::device_class Device, servobus::modbus::register_store Store>
class participant_of final : public participant {
  public:
    template <class... Options>
    participant_of(scene& on, Line& line, babbler& others, const servobus::catalogue& map,
                   std::uint8_t node_address, std::uint32_t baud, Options... options)
        : client{line, servobus::node<Device>{node_address}}, map_{&map}, positions_{positions_of(
                                                                              options...)},
          store_{on.transaction, node_address, baud, options...}, spoiled_{on, station_, others} {}

    servobus::client<Line, Device> client;

    Store& model() { return store_.store(); }

    hostile_device& device() override { return spoiled_; }
    std::vector<execution>& executed() override { return store_.executed(); }
    bool has_refused(std::uint8_t exception) const override {
        return store_.has_refused(exception) || exception == rules().illegal_function;
    }
    servobus::modbus::server_rules rules() const override { return store_.rules(); }
    std::uint8_t device_address() const override { return store_.address(); }
    void set_device_address(std::uint8_t node_address) override { store_.set_address(node_address); }
    void set_delay(servobus::duration delay) override { station_.set_response_delay(delay); }
    servobus::duration own_delay() const override { return store_.response_delay(); }
    void set_listening(bool listens) override { station_.set_listening(listens); }
    void reboot(std::uint64_t off_until_us) override {
        store_.power_cycle();
        spoiled_.be_off(off_until_us);
    }
    const servobus::catalogue& map() const override { return *map_; }
    bool is_test_device() const override { return std::is_same_v<Device, test_device::device>; }
    drive_kind kind() const override { return kind_of(Device::facts.name); }
    const switch_positions& positions() const override { return positions_; }

    std::uint8_t& address() override { return client.node().address; }
    servobus::response_limits& limits() override { return client.node().limits; }
    servobus::bus_gaps& gaps() override { return client.node().gaps; }
    unsigned retries() override { return client.node().read_retries; }
    servobus::status read(std::uint16_t address, std::span<std::uint16_t> words,
                          servobus::modbus::function code) override {
        return client.read_words(address, words, code);
    }
    servobus::status write(std::uint16_t address, std::uint16_t value) override {
        return client.write_word(address, value);
    }
    servobus::status write(std::uint16_t address, std::span<const std::uint16_t> words) override {
        return client.write_words(address, words);
    }
    servobus::status transact(servobus::bytes pdu, servobus::byte_buffer response) override {
        if constexpr (Line::is_small) {
            return servobus::errc::bad_argument; // a blocking line has no such call
        } else {
            return client.transact(pdu, response);
        }
    }

  private:
    const servobus::catalogue* map_;
    switch_positions positions_;
    witness<Store> store_;
    servobus::sim::station<witness<Store>> station_{store_};
    hostile_device spoiled_;
};

} // namespace trial
