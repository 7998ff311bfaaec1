// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A line in virtual time, for tests of programs that use the library: a `port` for the client at one end,
// simulated devices, each with a server, at the other. Bytes take their time on the wire (11 bits a
// character) and devices take time to respond; virtual time skips the rest, so that hours of traffic run in
// seconds. The same seed replays the same run. Faults happen at random by a seeded source or at given times.
//
//     servobus::sim::zlac8015d drive;
//     servobus::sim::station station{drive};
//     servobus::sim::virtual_line wire{115200};
//     wire.attach(station);
//     servobus::line line{wire, servobus::modbus::timing_at(115200)};
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/core/time.hpp>
#include <servobus/line/port.hpp>
#include <servobus/modbus/rtu.hpp>
#include <servobus/sim/faults.hpp>
#include <servobus/sim/station.hpp>

namespace servobus::sim {

/// A byte on the wire, for a test's log.
struct wire_byte {
    std::uint64_t at_us = 0; ///< when its last bit passed, from the line's construction
    std::uint8_t value = 0;
    bool is_from_client = false;
};

/// The settings of a virtual line.
struct line_settings {
    std::uint32_t baud = 115200; ///< the client's UART
    std::uint64_t seed = 1;
    bool echoes = false;     ///< the client receives what it sends, as on many RS-485 adapters
    bool keeps_echo = false; ///< the port leaves the echo to the line: give it `echoed`
    duration echo_delay{};   ///< above 0 the echo ends after `sent()` is true, as with USB
    /// Above 0 the adapter returns a request to which no device has responded so long after its last bit, as some do
    /// while no drive is connected. Longer than the devices take.
    duration unanswered_return{};
    instant start{};                 ///< first value of the clock: a test may begin before its wrap
    duration poll = microseconds(1); ///< what a call of sent, receive or now takes
};

/// The line and its clock, for up to `Devices` devices. It refers to the devices, which must outlive it.
template <std::size_t Devices> class basic_virtual_line {
  public:
    using byte_hook = void (*)(void* context, const wire_byte& byte);

    explicit basic_virtual_line(const line_settings& settings = {})
        : settings_{settings}, faults_{settings.seed}, character_{
                                                           modbus::timing_at(settings.baud).character} {}
    explicit basic_virtual_line(std::uint32_t baud, std::uint64_t seed = 1)
        : basic_virtual_line{line_settings{.baud = baud, .seed = seed}} {}

    // The port

    /// Takes a whole frame. Sending starts immediately, or after the bytes that are still being sent. Errors:
    /// `port_lost` while unplugged.
    transfer send(bytes out) {
        if (is_unplugged_) return errc::port_lost;
        if (!is_sending()) begin_request(out.size());
        std::uint16_t taken = 0;
        for (; taken < out.size() && queued_ < request_.size(); ++taken) request_[queued_++] = out[taken];
        return taken;
    }
    bool sent() {
        pass(settings_.poll.us);
        if (is_sending()) return false;
        if (settings_.echoes && !settings_.keeps_echo && !was_reported_) { // as a port must: it is the echo
            first_arrived_ = (first_arrived_ + came_while_leaving_) % inbox_.size();
            arrived_ -= came_while_leaving_;
        }
        was_reported_ = true;
        return true;
    }
    transfer receive(byte_buffer in) {
        pass(settings_.poll.us);
        if (is_unplugged_) return errc::port_lost;
        std::uint16_t size = 0;
        for (; size < in.size() && arrived_ != 0; ++size, --arrived_) {
            in[size] = inbox_[first_arrived_];
            first_arrived_ = (first_arrived_ + 1) % inbox_.size();
            if (came_while_leaving_ != 0) --came_while_leaving_;
        }
        return size;
    }
    /// The time. Each call takes `line_settings::poll`, so that a loop that polls the clock ends.
    instant now() {
        pass(settings_.poll.us);
        return clock();
    }
    /// Advances the time by `longest`, or until a byte has arrived for the client.
    void wait(duration longest) {
        const std::uint64_t end = time_ + longest.us;
        while (time_ < end && arrived_ == 0 && !is_unplugged_) go_on(end);
    }

    // The test's side

    /// Connects a device to the line. False if `Devices` are attached already.
    bool attach(line_device& device) {
        if (count_ == Devices) return false;
        places_[count_++] = {&device, true};
        idle_until_ = 0;
        return true;
    }
    /// Disconnects a device or connects it again; `device` counts from 0 in the order of `attach`. The device
    /// continues to run meanwhile.
    void set_connected(std::size_t device, bool is_connected) { places_[device].is_connected = is_connected; }

    fault_plan& faults() { return faults_.plan(); }
    /// Removes the client's port: `send` and `receive` fail with `port_lost` until `plug`.
    void unplug() {
        is_unplugged_ = true;
        arrived_ = came_while_leaving_ = 0;
        queued_ = gone_ = 0;
        return_at_ = never;
    }
    void plug() { is_unplugged_ = false; }
    /// Interrupts the wire for a time: no byte passes, and no call reports it.
    void cut_for(duration time) { cut_until_ = time_ + time.us; }
    /// True while no byte passes.
    bool is_cut() const { return time_ < cut_until_ || faults_.plan().is_unplugged; }

    /// Sets the client's UART to another rate. Between the client and a device at another rate every byte
    /// arrives corrupted, in both directions.
    void set_baud(std::uint32_t baud) {
        settings_.baud = baud;
        character_ = modbus::timing_at(baud).character;
    }
    void set_echo(bool echoes) { settings_.echoes = echoes; }
    /// See `line_settings::unanswered_return`.
    void set_unanswered_return(duration after) { settings_.unanswered_return = after; }
    /// Requests that the adapter has returned, since no device had responded.
    std::uint32_t returned() const { return returned_; }

    /// Advances the time while the client does not call the port.
    void pass(duration time) {
        idle_until_ = 0; // a test may have changed a device
        pass(time.us);
    }
    /// us since the line's construction; does not wrap.
    std::uint64_t time_us() const { return time_; }
    /// The time, without the time that a call of `now` takes.
    instant clock() const { return instant{static_cast<std::uint32_t>(settings_.start.us + time_)}; }

    /// Sets a function that is called for every byte on the wire that is not lost.
    void set_hook(byte_hook hook, void* context) {
        hook_ = hook;
        hook_context_ = context;
    }
    /// Frames that the client sent, and that devices sent (a duplicated response counts once).
    std::uint32_t requests() const { return requests_; }
    std::uint32_t responses() const { return responses_; }
    /// Frames with a fault of the plan.
    std::uint32_t struck() const { return struck_; }
    /// Bytes that were corrupted because two senders overlapped.
    std::uint32_t collisions() const { return collisions_; }

  private:
    struct place {
        line_device* device = nullptr;
        bool is_connected = true;
    };
    // A device's frame that is being sent, or is waiting for its delay.
    struct transmission {
        std::array<std::uint8_t, max_spoiled> data{};
        std::uint64_t next_at = 0; // when the last bit of byte `gone` passes
        std::size_t size = 0;
        std::size_t gone = 0;
        std::size_t device = 0;
        std::uint32_t baud = 0;
        std::uint32_t character = 0;

        bool is_free() const { return gone == size; }
        bool is_on_line(std::uint64_t at) const { return !is_free() && at + character >= next_at; }
    };
    static constexpr std::uint64_t never = ~std::uint64_t{0};
    // While nothing happens on the wire, devices run this often, so that their motors lag by no more.
    static constexpr std::uint64_t longest_lag_us = 50;
    static constexpr std::size_t none_wrong = ~std::size_t{0};

    bool is_sending() const { return gone_ < queued_; }

    void begin_request(std::size_t size) {
        queued_ = gone_ = 0;
        came_while_leaving_ = 0;
        idle_until_ = 0;
        was_reported_ = false;
        return_at_ = never;
        next_out_ = time_ + character_;
        request_fate_ = faults_.decide_request();
        wrong_byte_ = request_fate_.is_corrupted && size != 0 ? request_fate_.seed % size : none_wrong;
        ++requests_;
        if (!request_fate_.is_clean()) ++struck_;
    }

    void pass(std::uint32_t us) {
        const std::uint64_t end = time_ + us;
        if (end < idle_until_) {
            time_ = end;
            return;
        }
        while (time_ < end) go_on(end);
    }

    // Advances to the next event, at most to `end`.
    void go_on(std::uint64_t end) {
        std::uint64_t next = earlier(end, time_ + 1'000'000); // clocks wrap: devices run each second
        if (is_sending()) next = earlier(next, next_out_);
        if (responding_ != 0) next = earlier(next, next_response_byte());
        if (echoed_ != 0) next = earlier(next, echoes_[first_echo_].at_us);
        next = earlier(next, earlier(next_look_, return_at_));
        if (next > time_) time_ = next;
        const bool was_sending = is_sending();
        if (was_sending && next_out_ <= time_) pass_request_byte();
        if (responding_ != 0) pass_response_bytes();
        for (; echoed_ != 0 && echoes_[first_echo_].at_us <= time_; --echoed_) {
            deliver(echoes_[first_echo_].value);
            first_echo_ = (first_echo_ + 1) % echoes_.size();
        }
        if (was_sending && !is_sending()) came_while_leaving_ = arrived_;
        run_devices();
        if (return_at_ <= time_) return_request();
        idle_until_ = earlier(earlier(next_look_, return_at_), time_ + longest_lag_us);
        if (is_sending() || echoed_ != 0 || responding_ != 0) idle_until_ = 0;
    }

    std::uint64_t next_response_byte() const {
        std::uint64_t next = never;
        std::size_t left = responding_;
        for (std::size_t i = 0; left != 0; ++i) {
            const transmission& v = transmissions_[i];
            if (v.is_free()) continue;
            next = earlier(next, v.next_at);
            --left;
        }
        return next;
    }
    void pass_response_bytes() {
        std::size_t left = responding_;
        for (std::size_t i = 0; left != 0; ++i) {
            transmission& v = transmissions_[i];
            if (v.is_free()) continue;
            if (v.next_at <= time_) pass_response_byte(v);
            --left;
        }
    }

    static std::uint64_t earlier(std::uint64_t a, std::uint64_t b) { return a < b ? a : b; }

    void run_devices() {
        next_look_ = never;
        for (std::size_t i = 0; i < count_; ++i) {
            const duration idle = places_[i].device->run(clock());
            if (idle != line_device::until_it_receives) next_look_ = earlier(next_look_, time_ + idle.us);
            const bytes frame = places_[i].device->send(clock());
            if (!frame.empty() && places_[i].is_connected) begin_response(i, frame);
        }
    }

    void pass_request_byte() {
        std::uint8_t byte = request_[gone_];
        if (gone_ == wrong_byte_)
            byte = static_cast<std::uint8_t>(byte ^ (1 + (request_fate_.seed >> 8) % 255));
        ++gone_;
        next_out_ += character_;
        if (settings_.unanswered_return != duration{} && !is_sending())
            return_at_ = time_ + settings_.unanswered_return.us;
        byte = mixed(byte, nullptr);
        if (settings_.echoes && echoed_ != echoes_.size())
            echoes_[(first_echo_ + echoed_++) % echoes_.size()] = {time_ + settings_.echo_delay.us, byte};
        if (request_fate_.is_lost || is_cut()) return;
        if (hook_ != nullptr) hook_(hook_context_, {time_, byte, true});
        spread(byte, settings_.baud, count_);
    }

    void return_request() {
        return_at_ = never;
        ++returned_;
        for (std::size_t i = 0; i < queued_; ++i) deliver(request_[i]);
    }

    void pass_response_byte(transmission& v) {
        const std::uint8_t byte = mixed(v.data[v.gone++], &v);
        if (v.is_free()) --responding_;
        v.next_at += v.character;
        if (is_cut() || !places_[v.device].is_connected) return;
        if (hook_ != nullptr) hook_(hook_context_, {time_, byte, false});
        deliver(v.baud == settings_.baud ? byte : static_cast<std::uint8_t>(byte ^ 0x55u));
        spread(byte, v.baud, v.device);
    }

    // The byte as it arrives: corrupted if another sender overlaps.
    std::uint8_t mixed(std::uint8_t byte, const transmission* own) {
        bool collides = own != nullptr && is_sending();
        for (const transmission& v : transmissions_) {
            if (&v != own && v.is_on_line(time_)) collides = true;
        }
        if (!collides) return byte;
        ++collisions_;
        return static_cast<std::uint8_t>(byte ^ 0x5Au);
    }

    // Delivers a byte to every device except the sender; `count_` is the client.
    void spread(std::uint8_t byte, std::uint32_t baud, std::size_t sender) {
        for (std::size_t i = 0; i < count_; ++i) {
            if (i == sender || !places_[i].is_connected) continue;
            line_device& d = *places_[i].device;
            d.receive(byte, d.baud() == baud, clock());
        }
    }

    void deliver(std::uint8_t byte) {
        if (is_unplugged_ || arrived_ == inbox_.size()) return;
        inbox_[(first_arrived_ + arrived_++) % inbox_.size()] = byte;
    }

    void begin_response(std::size_t device, bytes frame) {
        const fate what = faults_.decide();
        ++responses_;
        return_at_ = never;
        if (!what.is_clean()) ++struck_;
        std::array<std::uint8_t, max_spoiled> spoiled{};
        const std::size_t size = spoil(what, frame, spoiled);
        if (size == 0) return;
        const std::uint32_t baud = places_[device].device->baud();
        const std::uint32_t character = modbus::timing_at(baud).character;
        const std::uint64_t begins = time_ + what.delay.us;
        transmit(device, bytes{spoiled}.first(size), begins, baud, character);
        if (what.is_doubled)
            transmit(device, bytes{spoiled}.first(size),
                     begins + size * character + faults_.plan().doubled_after.us, baud, character);
    }

    void transmit(std::size_t device, bytes data, std::uint64_t begins, std::uint32_t baud,
                  std::uint32_t character) {
        for (transmission& v : transmissions_) {
            if (!v.is_free()) continue;
            for (std::size_t i = 0; i < data.size(); ++i) v.data[i] = data[i];
            v.next_at = begins + character;
            v.size = data.size();
            v.gone = 0;
            v.device = device;
            v.baud = baud;
            v.character = character;
            ++responding_;
            return;
        }
    }

    line_settings settings_;
    fault_source faults_;
    std::uint32_t character_;
    std::uint64_t time_ = 0;
    std::uint64_t cut_until_ = 0;
    std::uint64_t next_out_ = never;
    std::uint64_t return_at_ = never;
    std::uint64_t next_look_ = 0;  // when a device is to run next
    std::uint64_t idle_until_ = 0; // no event happens before
    std::array<place, Devices> places_{};
    std::array<transmission, 8> transmissions_{};
    std::size_t responding_ = 0; // transmissions that are not free: in most steps there is none
    std::array<std::uint8_t, 512> request_{};
    std::array<std::uint8_t, 8192> inbox_{};
    std::array<wire_byte, 512> echoes_{};
    std::size_t first_echo_ = 0;
    std::size_t echoed_ = 0;
    std::size_t count_ = 0;
    std::size_t queued_ = 0;
    std::size_t gone_ = 0;
    std::size_t wrong_byte_ = none_wrong;
    std::size_t first_arrived_ = 0;
    std::size_t arrived_ = 0;
    std::size_t came_while_leaving_ =
        0; // of the bytes that arrived, the first ones: before the last stop bit left
    fate request_fate_{};
    byte_hook hook_ = nullptr;
    void* hook_context_ = nullptr;
    std::uint32_t requests_ = 0;
    std::uint32_t responses_ = 0;
    std::uint32_t struck_ = 0;
    std::uint32_t returned_ = 0;
    std::uint32_t collisions_ = 0;
    bool is_unplugged_ = false;
    bool was_reported_ = true;
};

using virtual_line = basic_virtual_line<32>;

} // namespace servobus::sim
