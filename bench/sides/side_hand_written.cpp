// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The operations of the hand-written code, and the lower limit for all sides: a transaction that sends a
// prepared frame and only reads the bytes of the response.
#include <array>

#include "../operations.hpp"
#include "../peers/hand_written.h"

namespace bench {
namespace {

memory_wire wire;
hw_port port;

void open(task& t) {
    wire = {};
    port = {&wire, wire_send, wire_receive, wire_now, 100'000};
    t.wire = &wire;
    t.session = &port;
}
const hw_port* port_of(const task& t) { return static_cast<const hw_port*>(t.session); }

void build_write(task& t) {
    t.frame_size = hw_build_write(t.frame.data(), t.node_address, t.address, t.value);
    t.ok = t.frame_size != 0;
}
void build_read(task& t) {
    t.frame_size = hw_build_read(t.frame.data(), t.node_address, t.address, 10);
    t.ok = t.frame_size != 0;
}
void build_write_many(task& t) {
    t.frame_size = hw_build_write_many(t.frame.data(), t.node_address, t.address, t.values.data(), 10);
    t.ok = t.frame_size != 0;
}
void parse(task& t) {
    t.ok = hw_parse_read(t.frame.data(), t.frame_size, t.node_address, t.words.data(), 10) == hw_ok;
}
void write(task& t) { t.ok = hw_write(port_of(t), t.node_address, t.address, t.value) == hw_ok; }
void read_many(task& t) {
    t.ok = hw_read(port_of(t), t.node_address, t.address, t.words.data(), 10) == hw_ok;
}
void write_many(task& t) {
    t.ok = hw_write_many(port_of(t), t.node_address, t.address, t.values.data(), 10) == hw_ok;
}

void only_read(task& t) {
    const hw_port* const p = port_of(t);
    p->send(p->wire, t.frame.data(), t.frame_size);
    std::array<std::uint8_t, 32> response;
    const std::size_t count = p->receive(p->wire, response.data(), response.size());
    std::uint8_t all = 0;
    for (std::size_t i = 0; i < count; ++i) all = static_cast<std::uint8_t>(all ^ response[i]);
    t.words[0] = all;
    t.ok = count != 0;
}

} // namespace

const side hand_written_side{"hand-written", open,  build_write, build_read, build_write_many,
                             parse,          write, read_many,   write_many};
const side reading_only_side{"only reading", open,      nullptr,   nullptr,  nullptr,
                             nullptr,        only_read, only_read, only_read};

} // namespace bench
