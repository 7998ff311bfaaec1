// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Cuts the bytes of others' traffic into frames. A host receives bytes in chunks, so t3.5 cannot be seen: the
// lengths that function codes give decide, and the CRC. Where no frame begins, the cutter resynchronises: it
// searches for the next byte at which a whole, well-formed frame with a right CRC begins. A gap that a host can
// see ends a frame that is not complete.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include <servobus/explain/direction.hpp>

#include "../frames/frame_sizes.hpp"

namespace tool {

/// Microseconds since listening began. It does not wrap.
using moment = std::uint64_t;

/// Bytes that belong together: a frame, or what is none.
struct piece {
    enum class kind : std::uint8_t {
        frame,      ///< its CRC is right; its content may be no valid request or response
        bad_crc,    ///< long enough for a frame
        incomplete, ///< it ended before the length that its function code gives
        noise,      ///< shorter than any frame
    };

    kind what = kind::frame;
    std::vector<std::uint8_t> data{};
    moment begin = 0; ///< when its first byte had arrived
    moment end = 0;   ///< when its last byte had arrived

    bool is_frame() const { return what == kind::frame; }
};

/// Takes what arrives, gives pieces as soon as they are certain. No byte is lost: the pieces, one after the
/// other, are what arrived.
class frame_cutter {
  public:
    /// `gap`: the shortest time without a byte that ends a frame.
    explicit frame_cutter(moment gap) : gap_{gap} {}

    /// Bytes that had arrived by `now`.
    void feed(servobus::bytes arrived, moment now) {
        bytes_.insert(bytes_.end(), arrived.begin(), arrived.end());
        times_.insert(times_.end(), arrived.size(), now);
    }

    /// Nothing had arrived by `now`. A gap ends a frame only if this reports it: the times at which two chunks
    /// were read prove none, since a busy host reads late.
    void elapse(moment now) {
        if (!times_.empty() && now >= times_.back() + gap_) close();
    }
    /// No byte follows any more.
    void close() { closed_ = bytes_.size(); }

    bool is_empty() const { return bytes_.empty(); }

    /// The request whose response may be next; empty if there is none.
    void expect(std::vector<std::uint8_t> request) { expected_ = std::move(request); }

    /// The next piece, if it is certain where it ends.
    std::optional<piece> next() {
        if (bytes_.empty()) return std::nullopt;
        const found here = find(burst());
        if (here.size != 0) return take(piece::kind::frame, here.size);
        if (here.may_come && !is_closed()) return std::nullopt;
        const std::size_t following = find_next();
        if (following == 0 && !is_closed()) {
            if (const std::size_t size = unknown_frame(); size != 0) return take(piece::kind::frame, size);
            // A frame may begin in the last bytes, and in no others.
            if (bytes_.size() < 2 * max_frame) return std::nullopt;
            return take(piece::kind::bad_crc, bytes_.size() - max_frame);
        }
        return cut(following != 0 ? following : burst().size());
    }

  private:
    /// The bytes from some place on as a request or as a response.
    struct candidate {
        enum class state : std::uint8_t { impossible, incomplete, bad_crc, whole };
        state is = state::impossible;
        std::size_t size = 0; ///< 0 while it is not known
    };
    struct found {
        std::size_t size = 0;  ///< of the frame; 0: there is none
        bool may_come = false; ///< more bytes may make a frame of it
    };

    bool is_closed() const { return closed_ != 0; }
    servobus::bytes burst() const {
        const servobus::bytes all = bytes_;
        return is_closed() ? all.first(closed_) : all;
    }

    static candidate of_size(servobus::bytes from, std::size_t size) {
        using enum candidate::state;
        if (from.size() < size) return {incomplete, size};
        return {is_whole(from, size) ? whole : bad_crc, size};
    }

    static candidate as_request(servobus::bytes from) {
        using enum candidate::state;
        if (from.size() < 2) return {incomplete};
        const bool is_exception = (from[1] & servobus::modbus::exception_flag) != 0;
        if (is_exception || !has_length(from) || !may_be_request(from)) return {};
        const std::size_t size = request_size(from);
        if (size == 0) return {incomplete};
        return size > max_frame ? candidate{} : of_size(from, size);
    }

    static candidate as_response(servobus::bytes from) {
        using enum candidate::state;
        if (from[0] == servobus::modbus::broadcast) return {};
        if (from.size() < 2) return {incomplete};
        const bool is_exception = (from[1] & servobus::modbus::exception_flag) != 0;
        if (!is_exception && !(has_length(from) && may_be_response(from))) return {};
        return from.size() < 3 ? candidate{incomplete} : of_size(from, response_size(from));
    }

    bool is_expected(servobus::bytes response) const {
        if (expected_.size() < min_frame || response.size() < 3) return false;
        if (response[0] != expected_[0]) return false;
        if (response[1] == (expected_[1] | servobus::modbus::exception_flag)) return true;
        if (response[1] != expected_[1]) return false;
        const bool is_bits = response[1] == 0x01 || response[1] == 0x02;
        if (!is_bits && !servobus::modbus::is_read(response[1]) && response[1] != 0x17) return true;
        if (expected_.size() < 8) return false;
        const unsigned quantity = servobus::load_word(expected_, 4);
        return response[2] == (is_bits ? (quantity + 7) / 8 : 2 * quantity);
    }

    // The frame that begins with the first of these bytes.
    found find(servobus::bytes from) const {
        using enum candidate::state;
        const candidate request = as_request(from);
        const candidate response = as_response(from);
        if (request.is == whole && response.is == whole) return {longer(from, request.size, response.size)};
        if (response.is == whole && is_expected(from)) return {response.size};
        // A whole request may be the beginning of a longer response, whose CRC tells then.
        const bool is_likely = response.is == incomplete && (!is_in_step_ || is_expected(from));
        if (request.is == whole && response.is != whole && !is_likely) return {request.size};
        if (request.is == incomplete || response.is == incomplete) {
            const candidate& other = request.is == whole ? request : response;
            return {is_closed() && other.is == whole ? other.size : 0, true};
        }
        return {response.is == whole ? response.size : 0};
    }

    // Zeros after a frame keep its CRC right, and come from a line that no one drives.
    static std::size_t longer(servobus::bytes from, std::size_t one, std::size_t other) {
        const std::size_t low = one < other ? one : other;
        const std::size_t high = one < other ? other : one;
        for (std::size_t i = low; i < high; ++i) {
            if (from[i] != 0) return high;
        }
        return low;
    }

    // Where the next whole frame begins; 0 if there is none. Among bytes that are not in step only what is
    // well-formed counts, since by chance one place in 65536 has a right CRC.
    std::size_t find_next() const {
        using enum candidate::state;
        for (std::size_t at = 1; at + min_frame <= burst().size(); ++at) {
            const servobus::bytes from = burst().subspan(at);
            if (!has_length(from)) continue;
            const candidate request = as_request(from);
            if (request.is == whole && servobus::is_request(pdu_of(from, request.size))) return at;
            const candidate response = as_response(from);
            if (response.is == whole && servobus::is_response(pdu_of(from, response.size))) return at;
        }
        return 0;
    }

    // What the first `size` bytes are, which a gap or a frame follows, and with which no frame of a known length
    // begins.
    piece cut(std::size_t size) {
        const servobus::bytes from = burst().first(size);
        if (size < min_frame)
            return take(size > 1 && has_length(from) ? piece::kind::incomplete : piece::kind::noise, size);
        if (is_whole(from, size)) return take(piece::kind::frame, size);
        if (!has_length(from)) return cut_unknown(from);
        const std::size_t wanted = likely_size(from);
        if (size < wanted) return take(piece::kind::incomplete, size);
        return take(piece::kind::bad_crc, wanted);
    }

    // Only the CRC tells where a frame of an unknown function ends.
    piece cut_unknown(servobus::bytes from) {
        for (std::size_t size = min_frame; size <= from.size(); ++size) {
            if (size > max_frame) break;
            if (is_whole(from, size)) return take(piece::kind::frame, size);
        }
        return take(piece::kind::bad_crc, from.size());
    }

    // The length of a frame of an unknown function that others follow without a gap, 0 if there is none: its CRC is
    // right, and after it comes a frame to or from the same node, or more than any frame has.
    std::size_t unknown_frame() const {
        const servobus::bytes all = bytes_;
        if (all.size() < 2 || has_length(all)) return 0;
        const bool is_long = all.size() > max_frame + 1;
        for (std::size_t size = min_frame; size + 1 < all.size(); ++size) {
            if (size > max_frame) break;
            if ((is_long || all[size] == all[0]) && is_whole(all, size)) return size;
        }
        return 0;
    }

    // The length that a damaged frame of a known function had, most likely.
    std::size_t likely_size(servobus::bytes from) const {
        const std::size_t request = as_request(from).size;
        const std::size_t response = as_response(from).size;
        if (request == from.size() || response == from.size()) return from.size();
        if (response != 0 && is_expected(from)) return response;
        return request != 0 ? request : from.size();
    }

    piece take(piece::kind what, std::size_t size) {
        const auto count = static_cast<std::ptrdiff_t>(size);
        piece p{what, {bytes_.begin(), bytes_.begin() + count}, times_.front(), times_[size - 1]};
        bytes_.erase(bytes_.begin(), bytes_.begin() + count);
        times_.erase(times_.begin(), times_.begin() + count);
        closed_ = closed_ < size ? 0 : closed_ - size;
        is_in_step_ = p.is_frame();
        return p;
    }

    moment gap_;
    std::vector<std::uint8_t> bytes_{};
    std::vector<moment> times_{}; ///< when each byte had arrived
    std::vector<std::uint8_t> expected_{};
    std::size_t closed_ = 0;  ///< a gap follows so many bytes; 0: none is known
    bool is_in_step_ = false; ///< the last piece was a frame
};

} // namespace tool
