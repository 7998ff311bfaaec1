// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A simulated device of a file: its rows hold the values that clients write. What else the device does, such as
// measuring, no file says.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <servobus/core/bytes.hpp>
#include <servobus/core/slice.hpp>
#include <servobus/core/time.hpp>
#include <servobus/modbus/request_receiver.hpp>

#include "../devices/device.hpp"

namespace tool {

/// Executes functions 01 to 06, 0Fh and 10h on the rows of a file, with the checks of the standard in its order: the
/// function (exception 1), quantity and byte count (3), the addresses (2), the values (3). An address without a row,
/// half a pair and a row without that access are wrong addresses; a value outside `min` and `max` is a wrong value. A
/// coil also takes the words of function 05 that have names, and keeps its state then.
class file_model {
  public:
    file_model(const device& of, std::uint8_t node, std::uint32_t baud);

    std::uint8_t address() const { return node_; }
    std::uint32_t baud() const { return baud_; }
    void advance(servobus::instant) {}
    const servobus::response_limits& limits() const { return facts_->limits; }

    /// Builds the response in `out`, at least 253 bytes, and returns its length.
    std::size_t execute(servobus::bytes pdu, servobus::byte_buffer out);

  private:
    struct row {
        const servobus::entry* what;
        std::vector<u16> words; // in the order of row_words.hpp; of a bit 0 or 1
    };
    struct found_rows {
        std::size_t first;
        std::size_t count;
    };

    // Each returns 0 or an exception.
    std::uint8_t read(servobus::bytes pdu, servobus::table of, servobus::byte_buffer out) const;
    std::uint8_t write(servobus::bytes pdu, servobus::table of);
    std::uint8_t find(servobus::table of, std::size_t address, std::size_t quantity,
                      servobus::access not_this, found_rows& found) const;
    bool takes_function(servobus::bytes pdu, servobus::table of) const;
    bool is_named_word(std::size_t address, u16 word) const;
    servobus::word_order order_of(const servobus::entry& e) const;
    std::vector<u16> reordered(const servobus::entry& e, std::span<const u16> words) const;

    const std::vector<row>& rows_of(servobus::table t) const { return rows_[static_cast<std::size_t>(t)]; }

    const servobus::profile* facts_;
    std::array<std::vector<row>, 4> rows_{};
    std::uint8_t node_;
    std::uint32_t baud_;
};

/// Its server.
class file_server : public servobus::modbus::request_receiver<file_server> {
  public:
    file_server(std::uint8_t node, file_model& model, servobus::modbus::rtu_timing timing)
        : request_receiver{node, timing, 4, model.limits().corrupted_request}, model_{&model} {}

  private:
    friend request_receiver;

    static bool is_executed(std::uint8_t code);
    std::size_t execute(servobus::bytes frame, servobus::byte_buffer pdu);

    file_model* model_;
};

} // namespace tool
