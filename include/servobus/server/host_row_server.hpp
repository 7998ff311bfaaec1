// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A Modbus RTU server of rows on a port where bytes come in bursts, such as a USB adapter or a pseudo-terminal of a PC.
// Programs on a microcontroller include server/row_server.hpp, whose buffer is smaller and whose timing is strict.
//
//     using tank_values = row_values<tank::lowest, tank::level, tank::valve>;
//     inline tank_values values;
//     inline host_row_server<my_uart, tank_values> server{uart, values, 7, modbus::timing_at(115200)};
//     inline void loop() { server.step(); } // then wait for a byte, at most a millisecond
//
// request_receiver describes which frames are executed. Frames of other nodes with functions 01 .. 06, 0F, 10h, 16h and
// 17h have known lengths; what has none delays a request by no more than t3.5. A request to this server with a function
// of no known length (08, 11h, 2Bh) is executed after a visible gap.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/core/bytes.hpp>
#include <servobus/line/port.hpp>
#include <servobus/modbus/request_receiver.hpp>
#include <servobus/modbus/rtu.hpp>
#include <servobus/server/options.hpp>
#include <servobus/server/request_executor.hpp>

namespace servobus {

/// A server at one address. Its timing is known at run time, as the baud rate of a command line is.
template <port Port, class Values, class... Options>
class host_row_server : request_executor<Values, Options...>,
                        modbus::request_receiver<host_row_server<Port, Values, Options...>> {
    using executor = request_executor<Values, Options...>;
    using receiver = modbus::request_receiver<host_row_server>;

    static_assert(((detail::option_number<Options> <
                    detail::option_number<with_crc<modbus::default_crc>>)&&...),
                  "with_crc and with_leading_bytes are options of a row_server");

  public:
    using receiver::address, receiver::set_address, receiver::is_answering, receiver::timing,
        receiver::dropped;

    /// `node_address` is 1..247. With `with_hooks<H>` the last argument is the object that has them. All objects
    /// outlive the server.
    template <class... Hooks>
    constexpr host_row_server(Port& port, Values& values, std::uint8_t node_address,
                              modbus::rtu_timing of_line, Hooks&... hooks)
        : executor{values, hooks...}, receiver{node_address, of_line}, port_{&port} {}

    /// Receives what has arrived, executes a request that has ended, or sends more of the response. Never waits. The
    /// gap before bytes that have waited in the port counts only as far as calls of `step` found none.
    constexpr void step() {
        const instant now = port_->now(); // before the look: no byte of then is newer
        std::uint8_t room[64];
        const transfer came = port_->receive(byte_buffer{room});
        if (came && *came == 0) {
            this->elapse(now);
        } else {
            // A wrong byte in place of a garbled one: no frame of this server or to all begins with it.
            if (!came) room[0] = this->address() == 0x55 ? 0x56 : 0x55;
            this->feed_late(bytes{room, came ? *came : std::size_t{1}}, port_->now());
        }
        send(now);
    }

  private:
    friend receiver;

    // Functions of which a request has a known length.
    static constexpr bool is_executed(std::uint8_t code) { return modbus::response_length(code, 0) != 0; }

    constexpr std::size_t execute(bytes frame, byte_buffer pdu) {
        if (frame[0] == modbus::broadcast && !executor::takes_broadcast(frame[1])) return 0;
        const std::size_t size = frame.size() - 3;
        for (std::size_t i = 0; i < size; ++i) pdu[i] = frame[1 + i];
        return this->execute_at(pdu.data(), modbus::max_pdu, size);
    }

    constexpr void send(instant now) {
        const bytes response = this->response(now);
        if (response.empty()) return;
        if (sent_ != response.size()) {
            const transfer taken = port_->send(response.subspan(sent_));
            sent_ = taken ? sent_ + *taken : response.size(); // a failed port: the client repeats
        }
        // Without another call of `step` between, which would drop the client's next request.
        if (sent_ == response.size() && port_->sent()) {
            sent_ = 0;
            this->sent(port_->now());
        }
    }

    Port* port_;
    std::size_t sent_ = 0;
};

} // namespace servobus
