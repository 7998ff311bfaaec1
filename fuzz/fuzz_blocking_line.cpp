// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A blocking line over a port that is driven by the input. Every call ends within its bound, gaps are kept,
// and an invalid request is refused and not sent. The result of a call follows from the bytes that came,
// which the target evaluates again by itself. Afterwards, with a port that works again, the next call
// succeeds.
#include <algorithm>
#include <cstdint>

#include <servobus/line/blocking_line.hpp>

#include "line_calls.hpp"

using namespace servobus;
using fuzz::require;
using reference::byte_list;

namespace {

/// What came after a request, as this line interprets it: a response is at the beginning of the first
/// frame, or of one after a gap; only leading bytes may come before it.
class answer {
  public:
    answer(const fuzz::driven_port& port, const byte_list& request, const response_limits& limits,
           const modbus::rtu_timing& timing)
        : request_{request}, limits_{limits}, gap_{timing.longest_gap(1).us}, pause_{timing.t3_5 +
                                                                                     timing.wire_time(1).us},
          is_strict_{timing.mode == modbus::timing_mode::strict}, came_{begun_in(port)} {}

    /// The valid response; empty if there is none.
    byte_list valid() const {
        const byte_list f = first(expected());
        if (f.size() < expected() || !reference::is_frame(f) || is_echo()) return {};
        return is_exception() || fuzz::is_answer(f, request_, limits_) ? f : byte_list{};
    }

    /// Whether this error is the right one for what came.
    bool is_due(errc why) const {
        const bool is_write = !fuzz::is_read(request_);
        switch (why) {
        case errc::timeout: return came_.empty();
        case errc::wrong_function: return came_.size() > 1 && (came_[1] & 0x7Fu) != request_[1];
        case errc::wrong_byte_count: return !is_write && came_.size() > 2 && came_[2] != 2 * request_[5];
        case errc::wrong_address: return is_write && differs(2);
        case errc::wrong_value: return request_[1] == 6 && !differs(2) && differs(4);
        case errc::wrong_quantity: return request_[1] == 16 && !differs(2) && differs(4);
        case errc::truncated_response: return !is_strict_ && is_cut();
        case errc::bad_gap: return is_strict_ && is_cut();
        case errc::bad_crc: return came_.size() >= expected() && !reference::is_frame(first(expected()));
        case errc::own_echo: return is_echo();
        default: return false;
        }
    }

    /// When its last byte came.
    std::uint64_t last() const { return last_; }

  private:
    // The bytes from the first one that may begin a response to the next gap. A response may also begin t3.5
    // after bytes of another node whose CRC fits.
    byte_list begun_in(const fuzz::driven_port& port) {
        unsigned leading = limits_.leading_bytes;
        bool is_start = true;
        byte_list came;
        byte_list others;
        for (std::size_t i = 0; i < port.heard.size(); ++i) {
            const auto& [byte, at, seen_gap] = port.heard[i];
            if (i != 0 && seen_gap > gap_) {
                if (!came.empty()) break;
                is_start = true;
            } else if (!is_start && came.empty() && seen_gap >= pause_ && ends_with_crc(others)) {
                is_start = true;
            }
            if (is_start) others.clear();
            if (!came.empty() || (is_start && byte == request_[0])) {
                came.push_back(byte);
                last_ = at;
            } else if (is_start) {
                is_start = (byte == 0x00 || byte == 0xFF) && leading != 0;
                if (is_start) --leading;
            }
            if (!is_start) others.push_back(byte);
        }
        return came;
    }

    static bool ends_with_crc(const byte_list& all) {
        const std::size_t n = all.size();
        return n > 1 &&
               reference::crc(all.data(), n - 2) == (all[n - 2] | static_cast<unsigned>(all[n - 1]) << 8);
    }
    bool is_exception() const { return came_.size() > 1 && came_[1] == (request_[1] | 0x80u); }
    std::size_t expected() const { return is_exception() ? 5 : fuzz::response_size(request_); }
    bool is_cut() const { return !came_.empty() && came_.size() < expected(); }
    byte_list first(std::size_t n) const {
        return {came_.begin(), came_.begin() + static_cast<long>(std::min(n, came_.size()))};
    }
    // Whether one of the two bytes at `at` came and differs from the request.
    bool differs(std::size_t at) const {
        for (std::size_t i = at; i < at + 2 && i < came_.size(); ++i) {
            if (came_[i] != request_[i]) return true;
        }
        return false;
    }
    // The bytes equal the request up to one byte beyond the expected response, or up to its end if they can be no
    // response. The response to function 06 equals the request: the client handles that case, by another request.
    bool is_echo() const {
        if (fuzz::response_size(request_) == request_.size()) return false;
        const std::size_t beyond = std::min(expected() + 1, request_.size());
        return (came_.size() >= beyond && begins_like_request(beyond)) ||
               (is_no_response() &&
                begins_like_request(std::min({expected(), came_.size(), request_.size()})));
    }
    bool begins_like_request(std::size_t n) const {
        return std::equal(came_.begin(), came_.begin() + static_cast<long>(n), request_.begin());
    }
    bool is_no_response() const {
        if (fuzz::is_read(request_) && came_.size() > 2 && came_[2] != 2 * request_[5]) return true;
        return came_.size() >= expected() && !reference::is_frame(first(expected()));
    }

    std::uint64_t last_ = 0;
    byte_list request_;
    response_limits limits_;
    std::uint64_t gap_;
    std::uint64_t pause_;
    bool is_strict_;
    byte_list came_;
};

template <modbus::timing_mode Mode, duration Quarantine> class bench {
  public:
    explicit bench(fuzz::wire& on) : on_{&on}, line_{on.port}, judge_{on, line_.timing().t3_5, true} {}

    void run() {
        for (int i = 0; i < on_->most_calls() && !on_->in->empty(); ++i) transact();
        on_->port.has_local_echo = false;
        fuzz::judge_recovery(*on_, line_, judge_);
    }

  private:
    using line_type = blocking_line<fuzz::driven_port, modbus::timing_at(115200, Mode), Quarantine>;

    void transact() {
        fuzz::call c{*on_->in};
        const unsigned how = c.how / 2;
        const unsigned what = c.what >> 5;
        const bool is_read = fuzz::is_read(c.request);
        if (is_read && what >= 5) c.request = like_its_response(what);
        if (is_read && what < 5 && (how & 1u) != 0) c.request = with_function(c.request, 4);
        c.limits.echoes_byte_count = (how & 1u) != 0;
        if ((how & 8u) != 0) c.limits.turnaround = c.limits.response;
        on_->port.echoes_byte_count = what == 4;
        on_->port.has_local_echo = (how & 4u) != 0;
        const bool is_in_place = (how & 2u) != 0 && !is_read;
        const bool is_broadcast = c.request[0] == 0;
        if (what == 7)
            is_broadcast ? refuse<true>(c) : refuse<false>(c);
        else
            is_broadcast ? carry<true>(c, is_in_place) : carry<false>(c, is_in_place);
    }

    static byte_list with_function(byte_list request, std::uint8_t code) {
        request[1] = code;
        request.resize(request.size() - 2);
        return reference::framed(request);
    }
    // Reads whose echo is a response with a valid CRC: its first 7 bytes, or the whole echo with zeros
    // after it.
    static byte_list like_its_response(unsigned what) {
        if (what == 5) return reference::framed({6, 3, 0x02, 0x12, 0, 1});
        return reference::framed({5, 3, 4, 0x10, 0, 2});
    }

    template <bool IsBroadcast> void carry(const fuzz::call& c, bool is_in_place) {
        byte_list request = c.request; // a buffer of its exact size, like the response
        byte_list room(is_in_place ? 0 : fuzz::response_size(request));
        const byte_buffer response = is_in_place ? byte_buffer{request}.first(8) : byte_buffer{room};
        const typename line_type::template exchange_for<response_limits, IsBroadcast> x{
            request, response, line_.timing(), c.limits, c.priority};
        judge_.begin();
        const bool was_proven = line_.is_echo_ruled_out();
        const duration bound = line_.bound(request.size(), response.size(), c.limits, c.wanted);
        if (c.wanted.quarantine > Quarantine) return judge_refusal(line_.run(x, c.wanted));
        const status w = line_.run(x, c.wanted);
        judge_.judge_time(bound);
        judge_.judge_silence(c, longer_of(line_.timing().visible_gap(), Quarantine));
        const bytes whole = w.error() == errc::exception ? response.first(5) : response;
        judge_.judge_end(w, c.request, whole, c.limits);
        judge_proof(w, was_proven, c.request, whole);
        if (w && fuzz::is_read(c.request)) {
            for (std::size_t i = 0; i < c.request[5]; ++i)
                require(x.words()[i] == load_word(response, 3 + 2 * i),
                        "the words are those of the response");
        }
        if (IsBroadcast)
            judge_broadcast(w, c.limits);
        else
            judge_answer(w, c, whole);
    }

    void judge_refusal(const status& w) const {
        require(w.error() == errc::bad_argument && !w.was_sent(), "an invalid request is a bad argument");
        require(!judge_.has_begun(), "an invalid request is not sent");
    }

    // Invalid requests, and requests whose response does not fit into its buffer.
    template <bool IsBroadcast> void refuse(const fuzz::call& c) {
        const unsigned kind = on_->in->byte();
        const unsigned n = kind / 8;
        byte_list q = c.request;
        byte_list response(fuzz::response_size(q));
        switch (kind % 8) {
        case 0: q.resize(n % 8); break;
        case 1: q.resize(256 + n); break;
        case 2: q = reference::framed({5, 3, 0x20, 0x88, 0, 1, 0}); break;
        case 3: q = reference::framed({0, 3, 0x20, 0x88, 0, 1}); break;
        case 4: // a response of more than 255 bytes
            q = reference::framed({5, 4, 0, 0, 0, static_cast<std::uint8_t>(126 + 4 * n)});
            response.resize(600);
            break;
        case 5:
        case 6: response.resize(n % response.size()); break;
        default: judge_refusal(attempt<!IsBroadcast>(q, response, c)); return;
        }
        judge_refusal(attempt<IsBroadcast>(q, response, c));
    }
    template <bool IsBroadcast>
    status attempt(const byte_list& request, byte_list& response, const fuzz::call& c) {
        const byte_list exact{request}; // no spare bytes after it
        judge_.begin();
        return line_.run(
            typename line_type::template exchange_for<response_limits, IsBroadcast>{
                exact, response, line_.timing(), c.limits, c.priority},
            c.wanted);
    }

    // A response that begins like its request may be an echo, so it does not rule an echo out. A request without a
    // valid response makes an echo possible again; so may one after whose response further bytes came.
    void judge_proof(const status& w, bool was_proven, const byte_list& request, bytes response) const {
        if (on_->port.has_lied) return;
        const bool is_broadcast = request[0] == 0;
        const bool has_response = !is_broadcast && (w || w.error() == errc::exception);
        const std::size_t n = std::min(response.size(), request.size());
        const bool is_proof = has_response && !same_bytes(response.first(n), bytes{request}.first(n));
        const bool is_miss = !w && w.error() != errc::exception && w.error() != errc::acknowledged &&
                             (!is_broadcast || w.error() == errc::port_lost);
        const bool is_proven = is_proof || (was_proven && !is_miss);
        require(is_proven || !line_.is_echo_ruled_out(),
                "G3 only a response that cannot be an echo rules the echo out");
        const bool is_alone = on_->port.heard.size() <= (is_broadcast ? 0 : response.size());
        require(line_.is_echo_ruled_out() || !is_proven || !is_alone,
                "G3 a response that cannot be an echo rules the echo out");
    }

    void judge_broadcast(const status& w, const response_limits& limits) const {
        if (!on_->is_honest() || !w) return;
        require(on_->port.time - on_->port.left_at >= limits.turnaround.us,
                "G30 a broadcast takes at least its turnaround time");
    }

    void judge_answer(const status& w, const fuzz::call& c, bytes response) const {
        const fuzz::driven_port& port = on_->port;
        const errc why = w.error();
        if (!on_->is_honest() || why == errc::receive_failed || why == errc::port_lost) return;
        if (port.left_at == 0) {
            require(why == errc::line_busy || why == errc::send_failed || why == errc::partial_send,
                    "a request that has not left ends with an error that shows it");
            return;
        }
        if (port.is_garbled_while_leaving) return; // of which byte is not known
        if (is_disturbed(c.request)) return judge_disturbed(w, response);
        const answer came{port, c.request, c.limits, line_.timing()};
        const byte_list valid = came.valid();
        if (w || why == errc::exception) {
            require(same_bytes(valid, response), "G2 a successful call has the valid response that came");
            return;
        }
        require(valid.empty(), "a valid response is accepted");
        require(came.is_due(why), "G2 each mismatch has its own error");
        if (why == errc::truncated_response || why == errc::bad_gap)
            require(port.time > came.last() + line_.timing().longest_gap(1).us,
                    "G7 only a gap truncates a response");
        if (why == errc::timeout)
            require(port.time - port.left_at >= c.limits.response.us,
                    "a timeout comes after the time limit, not before");
    }

    // True if bytes came while the request left that are neither its echo nor 00 or FF.
    bool is_disturbed(const byte_list& request) const {
        std::size_t echoed = 0;
        for (const std::uint8_t byte : on_->port.while_leaving) {
            if (echoed < request.size() && byte == request[echoed])
                ++echoed;
            else if (byte != 0x00 && byte != 0xFF)
                return true;
        }
        return false;
    }
    // Another node's frame may have begun while the request left: a response counts after a gap only.
    void judge_disturbed(const status& w, bytes response) const {
        if (!w && w.error() != errc::exception) return;
        const auto& heard = on_->port.heard;
        const std::uint64_t least =
            std::min<std::uint64_t>(line_.timing().longest_gap(1).us, line_.timing().t3_5);
        // The true time before each byte, of which the line has seen at most as much as a gap.
        bool is_after_gap = false;
        bool is_found = false; // the response, after one
        std::uint64_t last = on_->port.last_while_leaving;
        for (auto at = heard.begin(); at != heard.end() && !is_found; ++at) {
            is_after_gap = is_after_gap || at->at - last >= least;
            last = at->at;
            const auto rest = static_cast<std::size_t>(heard.end() - at);
            is_found = is_after_gap && rest >= response.size() &&
                       std::equal(response.begin(), response.end(), at,
                                  [](std::uint8_t byte, const auto& a) { return a.byte == byte; });
        }
        require(is_found, "G6 what follows a frame that began while the request left is no response");
    }

    fuzz::wire* on_;
    line_type line_;
    fuzz::call_judge judge_;
};

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::input in{data, size};
    fuzz::wire on{in};
    const unsigned kind = in.byte();
    if ((kind & 2u) == 0) on.port.character_us = 0; // leaves more of the input for the response
    if ((kind & 1u) != 0)
        bench<modbus::timing_mode::strict, milliseconds(5)>{on}.run();
    else
        bench<modbus::timing_mode::host, milliseconds(25)>{on}.run();
    return 0;
}
