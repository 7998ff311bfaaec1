// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What read, write and watch share: a drive on an open port, and registers by name or address.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <servobus/client.hpp>
#include <servobus/posix/serial.hpp>

#include "tool.hpp"

namespace tool {

/// The client's device type where the device is known only at run time; its figures are put into the node.
struct any_device {
    static constexpr servobus::profile facts{
        .name = "raw", .order = servobus::word_order::unknown, .exceptions = servobus::standard_exceptions};
};

/// DEVICE[:NODE]
struct target {
    const device* kind = nullptr; ///< null: raw
    std::uint8_t node = 1;

    const servobus::profile& facts() const { return kind != nullptr ? kind->facts() : any_device::facts; }
};

/// One REG of the command line: a register of the map, or raw words.
struct chosen {
    std::string name;
    u16 address = 0;
    u16 words = 1;
    const servobus::entry* row = nullptr; ///< null: raw
};

/// These complain by themselves.
std::optional<target> parse_target(std::string_view text);
std::optional<chosen> parse_register(const target& of, std::string_view text);

/// The content of what was chosen, as it came, in words: `12.5 A`, `enable (0x0008)`.
std::string value_text(const target& of, const chosen& what, std::span<const u16> words);

/// The words for VALUE, which was given for a register. Complains by itself if the register cannot hold it
/// exactly or may not be written.
std::optional<std::vector<u16>> parse_value(const target& of, const chosen& what, std::string_view text);

/// What went wrong, in the drive's words.
std::string why_text(const target& of, servobus::failure why, int os_error);

/// An open port with a client of one node. It stays where it was made.
class session {
  public:
    using line_type = servobus::line<servobus::posix::serial>;
    using client_type = servobus::client<line_type, any_device>;

    static constexpr arguments::option options[] = {{"baud"},    {"format"},   {"timeout"}, {"echo"},
                                                    {"retries"}, {"interval"}, {"count"}};

    session() = default;
    session(const session&) = delete;
    session& operator=(const session&) = delete;

    /// Returns `done`, or the exit status after a complaint.
    int check(const arguments& asked, const target& of);
    int open(const char* path);

    client_type& drive() { return *client_; }
    servobus::failure read(const chosen& what, std::span<u16> words) {
        return client_->read_words(what.address, words);
    }
    int os_error() const { return port_.os_error(); }

  private:
    servobus::posix::serial port_;
    servobus::posix::serial_settings settings_;
    servobus::node<any_device> node_;
    std::optional<line_type> line_;
    std::optional<client_type> client_;
};

} // namespace tool
