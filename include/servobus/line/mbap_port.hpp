// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Modbus TCP as a port: a line of RTU frames above, a stream of MBAP frames below. Source: Modbus Messaging on TCP/IP
// Implementation Guide V1.0b, 3.1.3. The stream is a port that loses and reorders nothing: a TCP connection
// (posix/tcp.hpp, or your own over lwIP or an Ethernet controller).
//
//     servobus::mbap_port<my_connection> port; // a stream with send, sent, receive and now
//     servobus::line line{port, servobus::modbus::timing_at(115200)};
//
//   request  | number 2 | protocol 0 2 | length 2 | unit 1 | PDU |     the line's address and PDU, without its CRC
//   response | the same number ...                                     any other number: a late response, dropped
//
// The number makes a response belong to one request, so that none that is late is taken for another (G2). The line
// keeps its gaps and its quarantine nevertheless. The CRC of a frame above is made here: between gateway and drive the
// gateway checks the drive's own.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include <servobus/core/bytes.hpp>
#include <servobus/line/port.hpp>
#include <servobus/modbus/crc16.hpp>
#include <servobus/modbus/pdu.hpp>

namespace servobus {

namespace detail {

struct no_endpoint {};
template <class Stream> struct endpoint_of { using type = no_endpoint; };
template <class Stream>
requires requires { typename Stream::endpoint; }
struct endpoint_of<Stream> {
    using type = typename Stream::endpoint;
};

} // namespace detail

/// A port over `Stream`. After what is no MBAP frame the stream has no known frame boundary any more: `receive` and
/// every later call return `port_lost`, until it is opened again; `is_foreign` tells this from a lost stream. A
/// stream that has `close` is closed then.
template <port Stream> class mbap_port {
  public:
    /// Exceptions 0Ah and 0Bh are the gateway's words: the node has sent no response.
    static constexpr bool has_gateway = true;
    static constexpr bool is_network = true;
    /// The stream's own, if it has one: `reconnecting<mbap_port<Stream>>` opens it again.
    using endpoint = typename detail::endpoint_of<Stream>::type;

    mbap_port() = default;
    explicit mbap_port(Stream stream) : stream_{std::move(stream)} {}

    /// Opens the stream, with its own arguments and errors, and forgets what was under way.
    template <class... Arguments>
    requires requires(Stream& s, Arguments&&... with) { s.open(std::forward<Arguments>(with)...); }
    status open(Arguments&&... with) {
        sent_ = sending_ = arrived_ = ready_ = taken_ = 0;
        is_broken_ = is_foreign_ = false;
        return stream_.open(std::forward<Arguments>(with)...);
    }
    /// Ends the port until it is opened again. What the stream has taken is still sent.
    void close() { lose(); }
    /// The same, but what has not left this host is not sent any more.
    void abort() requires requires(Stream& s) { s.abort(); }
    {
        stream_.abort();
        lose();
    }
    /// True while its stream is open and has carried MBAP frames alone.
    bool is_open() const requires requires(const Stream& s) { s.is_open(); }
    { return !is_broken_ && stream_.is_open(); }
    /// True if the port was lost since what came is no MBAP frame: the peer may carry RTU frames as they are.
    bool is_foreign() const { return is_foreign_; }
    /// The unit of frames to `modbus::peer_address` (client/peer_node.hpp): 255, which the guide recommends, or 0,
    /// which some devices demand. On Modbus TCP both are the device at the other end, and not all nodes behind it.
    void set_peer_unit(std::uint8_t unit) { peer_unit_ = unit; }
    Stream& stream() { return stream_; }
    const Stream& stream() const { return stream_; }

    /// Takes a whole frame, or nothing while the one before is still leaving. A frame that was taken leaves completely,
    /// also if the line gives its exchange up. Errors: those of the stream; `send_failed` for what is no RTU frame.
    transfer send(bytes frame) {
        if (is_broken_) return errc::port_lost;
        if (const transfer t = push(); !t) return t;
        if (sent_ != sending_) return std::uint16_t{0};
        if (frame.size() < smallest_rtu || frame.size() > largest_rtu) return errc::send_failed;
        const std::size_t size = frame.size() - crc_size;
        ++number_;
        const std::uint8_t header[header_size] = {
            static_cast<std::uint8_t>(number_ >> 8), static_cast<std::uint8_t>(number_), 0, 0,
            static_cast<std::uint8_t>(size >> 8),    static_cast<std::uint8_t>(size)};
        for (std::size_t i = 0; i < header_size; ++i) out_[i] = header[i];
        for (std::size_t i = 0; i < size; ++i) out_[header_size + i] = frame[i];
        is_to_peer_ = frame[0] == modbus::peer_address;
        if (is_to_peer_) out_[header_size] = peer_unit_;
        sent_ = 0;
        sending_ = header_size + size;
        ready_ = taken_ = 0;
        if (const transfer t = push(); !t) {
            const bool has_left = sent_ != 0; // then it counts as sent, and the next call reports the loss
            if (!has_left) return t;
        }
        return static_cast<std::uint16_t>(frame.size());
    }
    bool sent() {
        if (!is_broken_) (void)push(); // nothing leaves once the stream is lost
        return is_broken_ || (sent_ == sending_ && stream_.sent());
    }
    /// Gives the response to the last request, with a CRC. Errors: those of the stream; `port_lost`.
    transfer receive(byte_buffer in) {
        if (is_broken_) return errc::port_lost;
        // What has arrived first: after it the peer may have closed the connection.
        while (taken_ == ready_) {
            if (take_frame()) continue;
            if (is_broken_) break;
            const transfer t = pull();
            if (!t) return t;
            if (*t == 0) break;
        }
        if (is_broken_) return errc::port_lost;
        std::uint16_t n = 0;
        while (taken_ != ready_ && n < in.size()) in[n++] = response_[taken_++];
        return n;
    }
    instant now() const { return stream_.now(); }
    void wait(duration d) requires waiting_port<Stream> {
        if (taken_ == ready_) stream_.wait(d);
    }

  private:
    // A connection that is closed lets `wait` sleep, and the gateway take another.
    void lose() {
        is_broken_ = true;
        if constexpr (requires(Stream & s) { s.close(); }) stream_.close();
    }

    static constexpr std::size_t header_size = 6; ///< number, protocol, length
    static constexpr std::size_t crc_size = 2;
    static constexpr std::size_t smallest_rtu = 4;
    static constexpr std::size_t largest_rtu = 256;
    static constexpr std::size_t largest_mbap = header_size + largest_rtu - crc_size;

    // Gives the stream more of the request that is leaving.
    transfer push() {
        while (sent_ != sending_) {
            const transfer t = stream_.send(bytes{out_}.first(sending_).subspan(sent_));
            if (!t) {
                lose();
                return t;
            }
            if (*t == 0) break;
            sent_ += *t;
        }
        return std::uint16_t{0};
    }
    transfer pull() {
        const transfer t = stream_.receive(byte_buffer{in_}.subspan(arrived_));
        if (!t) lose();
        if (t) arrived_ += *t;
        return t;
    }
    // False if no frame has arrived completely.
    bool take_frame() {
        if (arrived_ < header_size) return false;
        const std::size_t size = std::size_t{in_[4]} << 8 | in_[5];
        if (in_[2] != 0 || in_[3] != 0 || size < smallest_rtu - crc_size || size > largest_rtu - crc_size) {
            is_foreign_ = true;
            lose();
            return false;
        }
        const std::size_t whole = header_size + size;
        if (arrived_ < whole) return false;
        const unsigned number = unsigned{in_[0]} << 8 | in_[1];
        const bool is_awaited = sending_ != 0 && ready_ == 0;
        if (is_awaited && number == number_) {
            for (std::size_t i = 0; i < size; ++i) response_[i] = in_[header_size + i];
            if (is_to_peer_ && response_[0] == peer_unit_) response_[0] = modbus::peer_address;
            const std::uint16_t crc = modbus::crc16(bytes{response_}.first(size));
            response_[size] = static_cast<std::uint8_t>(crc);
            response_[size + 1] = static_cast<std::uint8_t>(crc >> 8);
            ready_ = size + crc_size;
            taken_ = 0;
        }
        for (std::size_t i = whole; i < arrived_; ++i) in_[i - whole] = in_[i];
        arrived_ -= whole;
        return true;
    }

    Stream stream_{};
    std::array<std::uint8_t, largest_mbap> out_{};
    std::array<std::uint8_t, largest_mbap> in_{};
    std::array<std::uint8_t, largest_rtu> response_{};
    std::size_t sending_ = 0; ///< of `out_`
    std::size_t sent_ = 0;
    std::size_t arrived_ = 0; ///< in `in_`
    std::size_t ready_ = 0;   ///< of `response_`; 0 until it has arrived
    std::size_t taken_ = 0;
    std::uint16_t number_ = 0;
    std::uint8_t peer_unit_ = modbus::peer_address;
    bool is_to_peer_ = false; ///< the last request
    bool is_broken_ = false;
    bool is_foreign_ = false;
};

} // namespace servobus
