// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The operations that are measured besides the CRC: each side does the same operations on the same task. A
// side is a separate source file, and all inputs and outputs are in memory, so that no compiler knows a
// value. Before any measurement every byte on the wire and every value of each side is compared with the
// same frames.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "peers/memory_wire.h"

namespace bench {

/// One drive on a wire, and the inputs and outputs of every operation.
struct task {
    memory_wire* wire = nullptr; ///< the side's own
    void* session = nullptr;     ///< the side's own: its port, line and client
    // in
    std::uint8_t node_address = 1;
    std::uint16_t address = 0x20A0;
    std::uint16_t value = 0x1234;
    std::array<std::uint16_t, 10> values{};
    // in for parse, out for build
    std::array<std::uint8_t, 32> frame{};
    std::size_t frame_size = 0;
    // out
    std::array<std::uint16_t, 10> words{};
    bool ok = false;
};

/// The operations of a side. One that it does not have is null.
struct side {
    const char* name;
    void (*open)(task&);
    void (*build_write)(task&);      ///< 06
    void (*build_read)(task&);       ///< 03
    void (*build_write_many)(task&); ///< 10h, ten registers
    void (*parse)(task&);            ///< the response to a read of ten registers
    void (*write)(task&);            ///< a complete transaction, 06
    void (*read_many)(task&);        ///< a complete transaction, 03, ten registers
    void (*write_many)(task&);       ///< a complete transaction, 10h, ten registers
};

extern const side servobus_side;
extern const side hand_written_side;
extern const side libmodbus_side;        ///< over the same wire in memory: its system calls are diverted
extern const side libmodbus_socket_side; ///< over a socket pair, unchanged
extern const side socket_only_side;      ///< the same system calls, without libmodbus
extern const side reading_only_side; ///< sends a prepared request and only reads the bytes of the response

/// An operation and its name.
struct operation {
    const char* name;
    void (*side::*run)(task&);
};
inline constexpr std::array operations{
    operation{"build 06", &side::build_write},           operation{"build 03", &side::build_read},
    operation{"build 10h x10", &side::build_write_many}, operation{"parse 03 x10", &side::parse},
    operation{"transaction 06", &side::write},           operation{"transaction 03 x10", &side::read_many},
    operation{"transaction 10h x10", &side::write_many},
};

/// Makes `t` ready for an operation by this side: inputs, and the response that the device will give.
void prepare(task& t, const side& who, const operation& what);

/// True if the side sends the right bytes and returns the right values in every operation that it has.
/// Prints the others on standard error.
bool works(const side& who);
/// True if `works` is, and the side accepts no response with a wrong bit.
bool is_correct(const side& who);

} // namespace bench
