// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// PORT of the command line: a serial device, or a gateway in the network.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <servobus/line/port.hpp>
#include <servobus/modbus/rtu.hpp>

#include "../command_line/arguments.hpp"
#include "os.hpp"

namespace tool {

using serial_settings = native::serial_settings;

/// A connection that keeps what has come since the last request.
class recorded_tcp : public native::tcp {
  public:
    servobus::transfer receive(servobus::byte_buffer in);

    std::vector<std::uint8_t> came{};
};

/// A serial device by its name, `tcp://HOST:PORT` for RTU frames over TCP, `mbap://HOST[:PORT]` for Modbus TCP.
class any_port {
  public:
    /// True for a name that begins with a scheme of the network.
    static bool is_network(std::string_view name);
    /// True for RTU frames over TCP.
    static bool is_tcp(std::string_view name);

    /// True for one of these that speaks Modbus TCP.
    static bool is_mbap(std::string_view name);

    /// Returns `done`, or the exit status after a complaint: `usage` for a name that is no address.
    int open(const char* name, const serial_settings& settings);

    /// Sets the unit of the device at the other end of an open port of Modbus TCP, 0 or 255.
    void set_peer_unit(std::uint8_t unit);

    /// Opens the port of the last `open` again, without a complaint.
    servobus::status reopen();
    /// In the network: from now on a connection that the peer has closed while no request was under way is made anew as
    /// it is found. Says so on standard error, once.
    void keep_connected() { keeps_connected_ = true; }
    /// How often a connection was made.
    unsigned connections() const { return connections_; }
    bool is_network() const { return !host_.empty(); }
    /// True once there was a response.
    bool has_answered() const { return has_answered_; }
    /// True if the port was lost because its peer speaks no Modbus TCP. One wrong header of a peer that has responded
    /// before is damage.
    bool is_foreign() const;

    /// In the network: drops the connection with what has not left, and connects anew. A connection loses nothing, so
    /// a request that is late would still be carried out, and over `tcp://` its response be taken for the next one.
    servobus::status reconnect();

    /// The number of the last failure, for `os::error_text`; 0 if there was none.
    int os_error() const;

    /// True for a port without a wire, such as that of a simulator: no baud rate changes what it receives.
    bool ignores_rate() const;

    /// What the bytes that came since the last request show of its failure: the request's own echo, a gateway of
    /// another protocol, bytes that are no response of the node. Empty if they show nothing more than `why`.
    std::string diagnosis(servobus::status why) const;
    /// How long the last response took to begin after its request had left; none if no response came.
    std::optional<servobus::duration> response_time() const;

    servobus::transfer send(servobus::bytes out);
    bool sent();
    servobus::transfer receive(servobus::byte_buffer in);
    servobus::instant now() const;
    void wait(servobus::duration d);

  private:
    using mbap = servobus::mbap_port<recorded_tcp>;

    std::string echo_diagnosis(servobus::status why) const;
    servobus::bytes came() const;
    servobus::transfer receive_now(servobus::byte_buffer in);
    bool is_answered() const;
    void pause_before_connecting();

    std::variant<native::serial, native::tcp, mbap> port_{};
    std::string host_{};
    std::string service_{};
    std::string name_{};
    serial_settings settings_{};
    bool keeps_connected_ = false;
    bool is_said_anew_ = false;
    bool is_fresh_ = false;     ///< no request has left on this connection
    bool has_answered_ = false; ///< there was a response
    unsigned connections_ = 0;
    bool is_answered_since_ = false; ///< there was a response on this connection
    servobus::duration pause_{};     ///< before the next connection
    servobus::instant connected_at_{};
    std::optional<servobus::instant> sent_at_{};
    std::optional<servobus::instant> answered_at_{}; ///< the first byte that is not the local echo
    std::vector<std::uint8_t> response_{}; ///< what the line has got since the request began to leave
    bool removes_echo_ = false;
    std::uint8_t peer_unit_ = servobus::modbus::peer_address;
    std::size_t left_to_send_ = 0; ///< of the request that is leaving
    std::vector<std::uint8_t> request_{};
    std::vector<std::uint8_t> came_{}; ///< since the request began to leave; of Modbus TCP the stream has it
};

static_assert(servobus::waiting_port<any_port>);

/// A gateway sets rate and format of its line. False after a complaint if the command line has them.
bool leaves_setting_to_gateway(const arguments& asked);

/// What a response may take longer behind a gateway than on a wire of one's own, if no --timeout is given.
inline constexpr servobus::duration network_delay = servobus::milliseconds(500);

/// The timing of a line on this port: a network delivers a frame in pieces. `longest_pause`: inside a frame, in place
/// of what the port is known for.
servobus::modbus::rtu_timing timing_on(std::string_view name, std::uint32_t baud,
                                       std::optional<servobus::duration> longest_pause = std::nullopt);
/// The value of --inter-byte, if it is given. False after a complaint.
bool parse_longest_pause(const arguments& asked, std::optional<servobus::duration>& longest_pause);

} // namespace tool
