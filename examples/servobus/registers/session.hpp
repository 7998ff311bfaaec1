// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What read, write and watch share: a drive on an open port, and registers by name or address.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <servobus/client/client.hpp>

#include "../command_line/arguments.hpp"
#include "../devices/device.hpp"
#include "../devices/row_words.hpp"
#include "../frames/stray_bytes.hpp"
#include "../os/hear.hpp"
#include "../os/port.hpp"
#include "../words/line_settings.hpp"
#include "raw.hpp"

namespace tool {

/// The client's device type where the device is known only at run time; its figures are put into the node.
struct any_device {
    static constexpr servobus::profile facts{.name = "raw",
                                             .word_order = servobus::word_order::unknown,
                                             .exceptions = servobus::standard_exceptions};
};

/// A node on a line, or the device at the other end of Modbus TCP.
struct any_node : servobus::node<any_device> {
    using node::node;
    constexpr bool is_valid() const { return address != servobus::modbus::broadcast; }
};

/// DEVICE[:NODE]
struct target {
    const device* kind = nullptr; ///< null: raw
    std::uint8_t node = 1;
    std::uint8_t peer_unit = 0; ///< 0 or 255, if `node` is `peer_address`
    bool has_node = false;      ///< the command line names it

    bool is_peer() const { return node == servobus::modbus::peer_address; }
    /// `c630s:2`, as the command line has it; for one with a map.
    std::string word() const { return kind->word() + ':' + std::to_string(node); }

    const servobus::profile& facts() const { return kind != nullptr ? kind->facts() : any_device::facts; }
};

/// One REG of the command line: a register of the map, or raw words.
struct chosen {
    std::string name;
    u16 address = 0;
    u16 words = 1;                              ///< or bits
    const servobus::entry* row = nullptr;       ///< null: raw
    raw_form form{};                            ///< of raw: what it is; of a row: its table
    const servobus::entry* scaled_by = nullptr; ///< the row that scales it
};

/// These complain by themselves.
std::optional<target> parse_target(std::string_view text);
/// Refuses units 0 and 255 where they are no device: anywhere but on Modbus TCP.
int refuse_peer(const target& of);
std::optional<chosen> parse_register(const target& of, std::string_view text);
/// From the third word on, for a command that reads. Empty if one of them cannot be read.
std::vector<chosen> parse_readable(const target& of, const arguments& asked);

struct rate_and_format {
    std::uint32_t baud = 0;
    servobus::character_format format = servobus::character_format::n81;
};
/// What `--baud` and `--format` say; `otherwise` for the one that is not given. Complains by itself.
std::optional<rate_and_format> parse_rate_and_format(const arguments& asked, rate_and_format otherwise);

/// A row of the map as if it had been chosen.
chosen choose(const servobus::entry& row, servobus::table in = servobus::table::holding_registers);

/// The names of a register's codes or bits, as VALUE takes them.
std::vector<std::string> names_of(const servobus::entry& row);
/// The same with the codes or bits: `5 deceleration, 7 immediate`, `bit 0 x0`.
std::string codes_of(const servobus::entry& row);
/// Ends the complaint about a value that is none of a row's codes; empty for a row without names.
std::string what_it_takes(const servobus::entry& row);

/// The content of what was chosen in words: `12.5 A`, `enable (0x0008)`. See row_words.hpp for the order of the words.
std::string value_text(const chosen& what, std::span<const u16> words);
/// The same with the scale that another row gives.
std::string value_text(const chosen& what, std::span<const u16> words, const servobus::row_scale& scale);
/// The value of a row that has none.
inline constexpr std::string_view no_value = "no value";
/// `current=12.34 A`; `current: no value`.
std::string assigned_text(const chosen& what, std::span<const u16> words, const servobus::row_scale& scale);

/// Why a row with `flag::zero_by_name` takes no 0 here, and what writes it.
std::string undocumented_zero(const servobus::entry& e);
/// Sets `words` for VALUE, which was given for a row; the high word of a pair is first. Returns the reason, which
/// begins with the row's name, if the register cannot hold it exactly or may not be written; else an empty text.
std::string read_value(const servobus::entry& row, bool is_bit, std::string_view text,
                       std::vector<u16>& words);
/// The words for VALUE, which was given for a register; the high word of a pair is first. Complains by itself
/// if the register cannot hold it exactly or may not be written.
std::optional<std::vector<u16>> parse_value(const chosen& what, std::string_view text);

/// What went wrong on a port, in the drive's words, or what the bytes that came show of it.
std::string why_text(const target& of, servobus::status why, const any_port& port);

/// An open port with a client of one node. It stays where it was made. Where the drive can switch the word
/// order of the words of a pair, it is read from the drive before the first pair, and again after a write to
/// the switch or a lost answer. Above the session the high word is always first, and the
/// high byte; a part of a register has its bits alone.
class session {
  public:
    using line_type = servobus::line<any_port, stray_bytes, servobus::echoed>;
    using client_type = servobus::client<line_type, any_device, any_node>;

    static constexpr servobus::table holding = servobus::table::holding_registers;

    session() = default;
    session(const session&) = delete;
    session& operator=(const session&) = delete;

    /// Returns `done`, or the exit status after a complaint.
    int check(const arguments& asked, const target& of);
    /// After `check`: the rate and format of a drive whose command line does not say them.
    void set_rate(std::uint32_t baud, servobus::character_format format) {
        settings_.baud = baud;
        settings_.format = format;
    }
    std::uint32_t baud() const { return settings_.baud; }
    servobus::character_format format() const { return settings_.format; }
    int open(const char* path);

    /// Errors: those of `client::read_words`; `unexpected_value` if the drive's word order is none.
    servobus::status read(const chosen& what, std::span<u16> words);
    /// Adjacent rows of a table, in address order, in one request. `words` has those of each row, one after the other.
    servobus::status read(std::span<const servobus::entry* const> rows, std::span<u16> words,
                          servobus::table from = holding);
    /// Reads the register of a part, changes its bits and writes it. `not_sent` or `refused` also if the word order, or
    /// the register of a part, could not be read.
    servobus::status write(const chosen& what, std::span<const u16> words);

    /// Does nothing if the word order is known.
    servobus::status learn_word_order();
    /// Sets `wears` to whether the drive puts every write into its EEPROM now; reads its switch where that is
    /// not known. Only for a drive with such a switch.
    servobus::status ask_wear(bool& wears);
    const any_port& port() const { return port_; }
    /// The next requests go to another address of the same line, or back to the drive's own.
    void set_node(std::uint8_t address) {
        node_.address = address;
        client_.emplace(*line_, node_);
    }
    void wait(servobus::duration time) { port_.wait(time); }
    /// How long a response may take to begin.
    servobus::duration response_limit() const { return node_.limits.response; }
    /// Sends bytes as they are, and counts those that come within `time`, which it appends to `all` if that is not
    /// null. For a port with a line of its own.
    std::size_t count_after(servobus::bytes frame, servobus::duration time,
                            std::vector<std::uint8_t>* all = nullptr);
    /// Reads one row once, without a retry.
    servobus::status probe(const servobus::entry& row, servobus::table from);
    servobus::modbus::rtu_timing timing() const { return line_->timing(); }
    /// From now on a response may take as long, and a read is repeated more often.
    void be_patient(servobus::duration limit) {
        node_.limits.response = limit;
        client_->node().limits.response = limit;
        retries_ = 10;
    }
    bool removes_echo() const { return settings_.keeps_echo; }
    /// The frame that reads a row.
    std::vector<std::uint8_t> read_request(const servobus::entry& row, servobus::table from) const;
    /// Sends a frame as it is, and listens: see os/hear.hpp.
    overheard hear(servobus::bytes request, servobus::duration longest) {
        return tool::hear(port_, request, longest);
    }
    /// Listens on after the last response, for as long as a second one would take to begin; longer if there was none.
    void listen_on();
    /// Names what came beside the responses so far, or late; empty if nothing did.
    std::string strays() const {
        const stray_bytes& all = line_->observer();
        const std::uint32_t limit = node_.limits.response.us / 1000;
        return has_worked_ ? all.text(node_.address, limit) : all.late_text(node_.address, limit);
    }

    /// From now on a port that was lost is opened anew, and what cannot have been sent leaves then: a call waits for it
    /// for `patience`. Says so on standard error.
    void wait_for_port(servobus::duration patience) { patience_ = patience; }
    /// False if a port that was lost is not expected to return.
    bool may_return() const;
    /// False if the port is lost, and has not returned within the patience.
    bool has_port();

  private:
    servobus::status read_raw(u16 address, std::span<u16> words, servobus::table from = holding);
    servobus::status read_once(u16 address, std::span<u16> words, servobus::table from);
    servobus::status read_bits_once(u16 address, std::span<u16> bits, servobus::modbus::function code);
    /// Over `tcp://` over a new connection each time.
    servobus::status read_repeated(u16 address, std::span<u16> words, servobus::table from);
    bool check_gaps(const arguments& asked);
    void note_request(servobus::status why);
    servobus::status write_now(const chosen& what, std::span<const u16> words);
    servobus::status write_once(const chosen& what, std::span<const u16> words);
    servobus::status write_coils(u16 address, std::span<const u16> coils);
    servobus::status write_single(servobus::modbus::function code, u16 address, u16 word);
    std::vector<std::uint8_t> frame_of(servobus::modbus::function code, u16 first, u16 second) const;
    bool is_stop(const chosen& what, std::span<const u16> words) const;
    void forget();
    /// From the order of the device to that above the session, or back.
    void reorder(const servobus::entry& row, std::span<const u16> words, std::span<u16> out) const;
    servobus::status complete_part(const chosen& what, std::span<u16> word);

    const servobus::profile* facts_ = nullptr;
    const device* kind_ = nullptr; ///< null: raw
    servobus::word_order word_order_ = servobus::word_order::unknown;
    std::optional<bool> wears_;
    any_port port_;
    std::string name_{}; ///< of the port
    serial_settings settings_;
    bool has_timeout_ = false;    ///< one was given
    bool has_no_echo_ = false;    ///< the command line says so, and the device may not answer reads
    bool has_function_05_ = true; ///< else a single coil is written by 0Fh
    bool has_function_06_ = true; ///< else a single register is written by 10h
    bool is_tcp_ = false;
    bool has_quarantine_ = false;
    servobus::duration later_quarantine_{}; ///< after the first request
    std::optional<servobus::duration> longest_pause_{};
    std::uint8_t retries_ = 0; ///< of a read
    std::optional<servobus::duration> patience_{};
    unsigned connections_ = 0; ///< of the port, when the word order was learned
    bool has_worked_ = false;  ///< the drive has responded
    bool is_lost_ = false;
    bool is_said_lost_ = false;
    bool is_said_reopened_ = false;
    any_node node_;
    std::uint8_t peer_unit_ = 0; ///< of a `node_` that is the peer
    std::optional<line_type> line_;
    std::optional<client_type> client_;
};

/// What went wrong in a session, in the drive's words.
std::string why_text(const target& of, servobus::status why, const session& on);

/// The same for a write: its outcome too, and when the register may be written.
std::string why_text(const target& of, const chosen& what, const servobus::status& w, const session& on);
/// Where a raw register does not exist and its address is one of those by which manuals count from 1: "; a manual that
/// counts from 40001 means 0x0000 by 40001". Else empty.
std::string advice_on_number(const chosen& what, servobus::status why);

} // namespace tool
