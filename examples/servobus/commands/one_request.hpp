// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// One request of any function on an open port, and its response, whose length may be unknown until it has come.
#pragma once

#include <optional>
#include <string>

#include <servobus/client/open_responses.hpp>

#include "../registers/session.hpp"

namespace tool {

/// A port with a line on which responses of any length come. It stays where it was made.
class one_request {
  public:
    one_request() = default;
    one_request(const one_request&) = delete;
    one_request& operator=(const one_request&) = delete;

    /// Returns `done`, or the exit status after a complaint.
    int open(const arguments& asked, const target& of);

    /// Sends the request once. The response's PDU lies in `room`, of `max_pdu` bytes.
    /// A response that repeats its request may be an echo: what a read of one register after it brings rules that out.
    /// Errors: those of `client::transact` with a rule; `own_echo` if it does not.
    servobus::result<servobus::bytes> transact(servobus::bytes pdu, servobus::byte_buffer room);

    /// The error of a status, in the device's words.
    std::string why_text(servobus::status why) const;

  private:
    using line_type = servobus::line<any_port, stray_bytes, servobus::echoed, servobus::modbus::open_lengths>;
    using client_type = servobus::client<line_type, any_device, any_node>;

    bool shows_no_echo();

    target of_{};
    any_port port_;
    std::uint8_t retries_ = 0;       ///< of the read
    bool is_echo_ruled_out_ = false; ///< by the command line
    std::optional<line_type> line_;
    std::optional<client_type> client_;
};

} // namespace tool
