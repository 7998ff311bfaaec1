// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The RTU back end of libmodbus, in two ways. Over a socket pair: the response is written into the other
// end before each transaction and the request is read there afterwards. The same system calls without
// libmodbus are a separate side. And over the wire in memory: the `write`, `read` and `select` of this file
// replace those of the C library and divert the calls for one descriptor. libmodbus itself is not changed.
#include <modbus/modbus.h>

#include <fcntl.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>

#include "../operations.hpp"
#include "side_libmodbus.hpp"

namespace bench {
namespace {

memory_wire wire;
int diverted = -1; // the descriptor whose calls go to the wire in memory

struct session {
    modbus_t* context = nullptr;
    int near_end = -1;
    int far_end = -1;
};
session over_memory, over_sockets;

modbus_t* new_context(int descriptor) {
    modbus_t* const context = modbus_new_rtu("/dev/null", 115200, 'N', 8, 1);
    modbus_set_slave(context, 1);
    modbus_set_socket(context, descriptor);
    return context;
}

void open_memory(task& t) {
    if (over_memory.context == nullptr) {
        diverted = ::open("/dev/null", O_RDWR);
        over_memory.context = new_context(diverted);
    }
    wire = {};
    t.wire = &wire;
    t.session = &over_memory;
}

void open_sockets(task& t) {
    if (over_sockets.context == nullptr) {
        int ends[2];
        if (socketpair(AF_UNIX, SOCK_STREAM, 0, ends) != 0) return;
        over_sockets = {new_context(ends[0]), ends[0], ends[1]};
    }
    wire = {};
    t.wire = &wire;
    t.session = &over_sockets;
}

modbus_t* context_of(const task& t) { return static_cast<session*>(t.session)->context; }

void write(task& t) { t.ok = modbus_write_register(context_of(t), t.address, t.value) == 1; }
void read_many(task& t) { t.ok = modbus_read_registers(context_of(t), t.address, 10, t.words.data()) == 10; }
void write_many(task& t) {
    t.ok = modbus_write_registers(context_of(t), t.address, 10, t.values.data()) == 10;
}

// Does the work of the other end of the line before and after a transaction.
template <void (*Transaction)(task&)> void with_far_end(task& t) {
    const int far_end = static_cast<session*>(t.session)->far_end;
    const bool answered = ::write(far_end, t.wire->response, t.wire->response_size) > 0;
    Transaction(t);
    const ssize_t heard = ::read(far_end, t.wire->request, sizeof t.wire->request);
    t.wire->request_size = heard > 0 ? static_cast<std::size_t>(heard) : 0;
    t.ok = t.ok && answered;
}

// The system calls of a transaction, each once, without a protocol. The request is already in `frame`.
void only_calls(task& t) {
    const int near_end = static_cast<session*>(t.session)->near_end;
    const bool sent = ::write(near_end, t.frame.data(), t.frame_size) > 0;
    fd_set set;
    FD_ZERO(&set);
    FD_SET(near_end, &set);
    timeval limit{0, 500'000};
    const bool readable = ::select(near_end + 1, &set, nullptr, nullptr, &limit) == 1;
    std::array<std::uint8_t, 256> response;
    t.ok = sent && readable && ::read(near_end, response.data(), response.size()) > 0;
}

} // namespace

const side libmodbus_side{"libmodbus", open_memory, nullptr,   nullptr,   nullptr,
                          nullptr,     write,       read_many, write_many};
const side libmodbus_socket_side{"libmodbus, socket pair",
                                 open_sockets,
                                 nullptr,
                                 nullptr,
                                 nullptr,
                                 nullptr,
                                 with_far_end<write>,
                                 with_far_end<read_many>,
                                 with_far_end<write_many>};
const side socket_only_side{"socket pair alone",
                            open_sockets,
                            nullptr,
                            nullptr,
                            nullptr,
                            nullptr,
                            with_far_end<only_calls>,
                            with_far_end<only_calls>,
                            with_far_end<only_calls>};

bool libmodbus_sends(const std::uint8_t* bytes, std::size_t count) {
    task t;
    if (over_memory.context == nullptr) open_memory(t);
    return modbus_send_raw_request(over_memory.context, const_cast<std::uint8_t*>(bytes),
                                   static_cast<int>(count)) > 0;
}

} // namespace bench

extern "C" {

ssize_t write(int descriptor, const void* bytes, size_t count) {
    if (descriptor != bench::diverted || descriptor < 0) return syscall(SYS_write, descriptor, bytes, count);
    return static_cast<ssize_t>(wire_send(&bench::wire, static_cast<const uint8_t*>(bytes), count));
}

ssize_t read(int descriptor, void* bytes, size_t room) {
    if (descriptor != bench::diverted || descriptor < 0) return syscall(SYS_read, descriptor, bytes, room);
    return static_cast<ssize_t>(wire_receive(&bench::wire, static_cast<uint8_t*>(bytes), room));
}

int select(int count, fd_set* readable, fd_set* writable, fd_set* excepted, timeval* limit) {
    const bool is_wire =
        bench::diverted >= 0 && readable != nullptr && FD_ISSET(bench::diverted, readable) != 0;
    if (!is_wire) return static_cast<int>(syscall(SYS_select, count, readable, writable, excepted, limit));
    return bench::wire.arrived != 0 ? 1 : 0;
}
}
