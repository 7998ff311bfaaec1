// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// One exchange, fed with bytes and times. It ends within its bound. It accepts only a complete response that
// matches the request. Bytes fed in one piece have the same effect as bytes fed one by one.
#include <algorithm>
#include <cstdint>

#include <servobus/modbus/exchange.hpp>

#include "reference.hpp"
#include "support.hpp"

using namespace servobus;
using fuzz::require;
using modbus::exchange;

namespace {

class bench {
  public:
    explicit bench(fuzz::input& in) : in_{&in} {
        const unsigned choice = in.byte();
        timing_ =
            modbus::timing_at((choice & 2u) != 0 ? 9600 : 115200,
                              (choice & 1u) != 0 ? modbus::timing_mode::strict : modbus::timing_mode::host,
                              duration{std::min(fuzz::time_of(in.byte()), longest_pause)});
        limits_.response = duration{fuzz::time_of(in.byte())};
        limits_.leading_bytes = static_cast<std::uint8_t>(choice >> 5);
        limits_.echoes_byte_count = (choice & 4u) != 0;
        now_.us = (choice & 8u) != 0 ? 0xFFFF'FFF0u : 0u;
        make_request();
        // Heap buffers of the exact size, so that the sanitizer finds a write beyond them.
        const std::size_t room = (choice & 16u) != 0 ? in.byte() + std::size_t{in.flag()} : 256u;
        response_.resize(room);
        other_response_.resize(room);
    }

    void run() {
        exchange x{request_, response_, timing_, limits_};
        exchange y{request_, other_response_, timing_, limits_};
        if (x.done()) {
            require(x.status().error() == errc::bad_argument && !x.was_sent(),
                    "a bad request is refused, not sent");
            return;
        }
        sent_ = now_;
        x.sent(now_);
        y.sent(now_);

        longest_ = x.longest();
        look(x, y);
        while (!in_->empty() && !x.done()) feed(x, y);
        if (!x.done()) wait_out(x);
        judge(x);
    }

  private:
    // A duration holds 35 minutes, and the sum of 256 pauses must fit.
    static constexpr std::uint32_t longest_pause = 4'000'000;

    void make_request() {
        constexpr std::uint8_t codes[] = {3, 4, 6, 16};
        const std::uint8_t kind = in_->byte();
        reference::byte_list body{static_cast<std::uint8_t>(kind % 8 == 7 ? in_->byte() : 1 + kind % 8)};
        body.push_back(kind / 8 % 8 < 7 ? codes[kind / 8 % 4] : in_->byte());
        const std::uint16_t address = in_->word();
        body.push_back(static_cast<std::uint8_t>(address >> 8));
        body.push_back(static_cast<std::uint8_t>(address & 0xFFu));
        const unsigned quantity = in_->byte();
        body.push_back((kind & 0x40u) != 0 ? in_->byte() : std::uint8_t{0});
        body.push_back(static_cast<std::uint8_t>(quantity));
        if (body[1] == 16) {
            body.push_back(static_cast<std::uint8_t>(2 * quantity & 0xFFu));
            body.resize(7 + (2 * quantity & 0xFFu), 0x5A);
        }
        if ((kind & 0x80u) != 0) body.resize(in_->byte());
        request_ = body.size() >= 2 ? reference::framed(body) : body;
    }

    // The valid response to the request.
    reference::byte_list good_response() {
        reference::byte_list body{request_.begin(), request_.begin() + 2};
        if (body[1] == 3 || body[1] == 4) {
            body.push_back(static_cast<std::uint8_t>(2 * request_[5]));
            const bytes words = in_->take(2u * request_[5]);
            body.insert(body.end(), words.begin(), words.end());
            body.resize(3 + 2u * request_[5]);
        } else {
            body.insert(body.end(), request_.begin() + 2,
                        request_.begin() + std::min<long>(6, length(request_)));
        }
        return reference::framed(body);
    }
    static long length(const reference::byte_list& f) { return static_cast<long>(f.size()); }

    reference::byte_list next() {
        const unsigned what = in_->byte();
        reference::byte_list f;
        switch (what % 8) {
        case 0:
        case 1: {
            const bytes raw = in_->take(in_->byte());
            return {raw.begin(), raw.end()};
        }
        case 2:
            f = reference::framed({request_[0], static_cast<std::uint8_t>(request_[1] | 0x80u), in_->byte()});
            break;
        case 3: f = request_; break; // an echo
        case 4: {                    // any bytes with a valid CRC
            const bytes raw = in_->take(2u + in_->byte());
            f.assign(raw.begin(), raw.end());
            f = reference::framed(f);
            break;
        }
        default: f = good_response(); break;
        }
        if (what >= 0xC0) return neighbour(f, what);
        if ((what & 0x08u) != 0)
            f[in_->byte() % f.size()] ^= static_cast<std::uint8_t>(1u << in_->byte() % 8u);
        if ((what & 0x10u) != 0) f = reference::framed({f.begin(), f.end() - 2});
        if ((what & 0x20u) != 0) fuzz::cut(f, in_->byte());
        if ((what & 0x40u) != 0) { // the rest comes later
            const auto cut = f.begin() + in_->byte() % length(f);
            held_.assign(cut, f.end());
            f.erase(cut, f.end());
        }
        return f;
    }

    // A frame of another node, of a function with or without a known length, that contains these bytes.
    reference::byte_list neighbour(const reference::byte_list& inside, unsigned what) {
        constexpr std::uint8_t codes[] = {0x65, 0x07, 1, 23};
        const std::uint8_t code = codes[what / 8 % 4];
        reference::byte_list f{static_cast<std::uint8_t>(request_[0] ^ 0x10u), code};
        if (code == 1 || code == 23) f.push_back(static_cast<std::uint8_t>(inside.size() & 0xFFu));
        f.insert(f.end(), inside.begin(), inside.end());
        f = reference::framed(f);
        if (code == 0x65) f.resize(f.size() + in_->byte() % 3u);
        return f;
    }

    // What another node sent since the last gap: nothing, bytes of which nothing is known, a frame whose
    // function has no known length, which may go on, or one that is whole by its length.
    enum class neighbours : std::uint8_t { none, any, open, whole };
    neighbours before() const {
        if (burst_.empty()) return neighbours::none;
        if (burst_.size() < 3 || burst_[0] == request_[0] || burst_[0] == 0 || burst_[0] == 0xFF)
            return neighbours::any;
        const unsigned code = burst_[1];
        if (code == 0x65 || code == 7) return neighbours::open;
        const bool is_whole = (code == 1 || code == 23) && burst_.size() == 5u + burst_[2];
        return is_whole && reference::is_frame(burst_) ? neighbours::whole : neighbours::any;
    }

    void feed(exchange& x, exchange& y) {
        const std::uint32_t gap = fuzz::time_of(in_->byte());
        const reference::byte_list chunk = held_.empty() ? next() : held_;
        held_.clear();
        const bool is_strict = timing_.mode == modbus::timing_mode::strict;
        const duration character = is_strict ? timing_.wire_time(1) : duration{};
        pass(x, y, duration{gap});
        if (x.done() || chunk.empty()) return;
        const bool is_first = x.state() == exchange::phase::awaiting && history_.empty();
        const instant start = now_;
        now_ = now_ + character * static_cast<std::uint32_t>(chunk.size());
        const duration quiet = since(heard_, now_);
        if (quiet > timing_.longest_gap(chunk.size())) burst_.clear();
        const neighbours others = before();
        // With host timing `elapse` has seen the pause; the bytes themselves come in no time.
        const bool is_paused =
            quiet >= duration{timing_.t3_5} + timing_.wire_time(is_strict ? chunk.size() : 1);
        const bool is_over = is_paused && burst_.size() < 257 && reference::is_frame(burst_);
        may_have_ended_ = (may_have_ended_ && !burst_.empty()) || is_over;
        heard_ = now_;
        const std::size_t taken = is_strict ? y.feed(chunk, now_) : y.feed_late(chunk, now_);
        std::size_t taken_singly = 0;
        instant at = start;
        for (const std::uint8_t byte : chunk) {
            at = at + character;
            const std::size_t kept = is_strict ? x.feed(byte, at) : x.feed_late(byte, at);
            if (kept != 0) history_.push_back(byte); // a byte after what may have been an echo
            taken_singly += kept;
            if (x.done()) break;
        }
        require(taken == taken_singly, "G7 bytes in one piece are accepted like bytes one by one");
        compare(x, y);
        if (is_first && is_the_response(chunk) && chunk.size() == x.response_size()) {
            if (begins_the_request(chunk))
                require(x.state() == exchange::phase::receiving,
                        "G4 what may be an echo is not yet a response");
            else
                require(x.done() && x.status().error() == errc::ok, "a valid response is accepted");
        }
        burst_.insert(burst_.end(), chunk.begin(), chunk.end());
        if (!is_strict && is_the_response(chunk) && chunk.size() == x.response_size() &&
            !begins_the_request(chunk)) {
            if (others == neighbours::whole || (others == neighbours::open && is_over))
                require(x.done() && x.status().error() == errc::ok,
                        "G41 the response is accepted t3.5 after a frame of another node");
            if (others == neighbours::open && !may_have_ended_)
                require(!x.done(), "G41 bytes that follow such a frame without a pause are no response");
        }
        if (!x.done()) look(x, y);
    }

    // Whether the chunk alone is a valid response to the request.
    bool is_the_response(const reference::byte_list& f) const {
        const std::uint8_t code = request_[1];
        if (request_[0] == 0 || !reference::is_frame(f) || f[0] != request_[0] || f[1] != code) return false;
        if (code == 3 || code == 4) return f.size() == 5 + 2u * request_[5] && f[2] == f.size() - 5;
        return (code == 6 || code == 16) && f.size() == 8 &&
               std::equal(f.begin(), f.begin() + 6, request_.begin());
    }

    // Whether the chunk may also be the beginning of an echo.
    bool begins_the_request(const reference::byte_list& f) const {
        return f.size() < request_.size() && std::equal(f.begin(), f.end(), request_.begin());
    }

    // Lets time pass and calls `elapse` whenever it is due.
    void pass(exchange& x, exchange& y, duration span) {
        duration left = span;
        for (int looks = 0; !x.done() && idle_ <= left; ++looks) {
            require(looks < 64, "G29 the number of calls of elapse is limited");
            if (idle_ > duration{1}) {
                require(x.elapse(now_ + (idle_ - duration{1})) == duration{1} && !x.done(),
                        "nothing happens before the time that elapse returned");
            }
            now_ = now_ + idle_;
            left = left - idle_;
            look(x, y);
        }
        now_ = now_ + left;
        idle_ = idle_ - (left < idle_ ? left : idle_);
    }

    void look(exchange& x, exchange& y) {
        idle_ = x.elapse(now_);
        require(idle_ == y.elapse(now_),
                "G7 elapse returns the same time for one piece as for bytes one by one");
        compare(x, y);
        if (!x.done()) {
            require(since(sent_, now_) < longest_ + timing_.wire_time(512),
                    "G29 an exchange ends within its bound");
            require(idle_ != duration{}, "elapse returns a time greater than zero");
        }
    }

    void wait_out(exchange& x) {
        now_ = now_ + longest_ + duration{1};
        for (int looks = 0; looks < 3 && !x.done(); ++looks) now_ = now_ + x.elapse(now_);
        require(x.done(), "G29 an exchange ends after its longest time");
    }

    void compare(const exchange& x, const exchange& y) const {
        require(x.state() == y.state(), "G7 bytes in one piece have the same effect as one by one");
        require(!x.done() || x.status() == y.status(),
                "G7 bytes in one piece have the same result as one by one");
        require(same_bytes(x.response(), y.response()),
                "G7 bytes in one piece are stored like bytes one by one");
    }

    // G2: checks what was accepted as a response.
    void judge(const exchange& x) {
        const errc why = x.status().error();
        if (why != errc::ok) require(x.words().size() == 0, "a failed read gives no words");
        if (why != errc::ok && why != errc::exception) return;
        if (x.is_broadcast()) {
            require(why == errc::ok && x.response().empty(), "G30 a broadcast has no response");
            require(!modbus::is_read(request_[1]), "G30 a broadcast does not read");
            return;
        }
        const reference::byte_list f{x.response().begin(), x.response().end()};
        require(reference::is_frame(f) && f[0] == request_[0],
                "G2 a response is a frame of the requested node");
        require(history_.size() >= f.size() && std::equal(f.rbegin(), f.rend(), history_.rbegin()),
                "G1 G2 a response came after its request, complete and contiguous");
        const std::uint8_t code = request_[1];
        if (why == errc::exception) {
            require(f.size() == 5 && f[1] == (code | 0x80u) && f[2] == x.status().exception(),
                    "G12 an exception belongs to the request and its number is unchanged");
            return;
        }
        require(f[1] == code, "G2 a response has the request's function");
        if (code == 3 || code == 4) {
            require(f.size() == 5 + 2u * request_[5] && f[2] == 2 * request_[5],
                    "G2 a read has its byte count");
            require(x.words().size() == request_[5], "a read gives its words");
        }
        if (code != 6 && code != 16) return;
        reference::byte_list expected = reference::framed({request_.begin(), request_.begin() + 6});
        if (code == 16 && limits_.echoes_byte_count && f.size() == 8 && f[5] == request_[6]) {
            expected[5] = request_[6];
            expected = reference::framed({expected.begin(), expected.begin() + 6});
        }
        require(f == expected, "G2 the response to a write repeats the address and the value or quantity");
    }

    fuzz::input* in_;
    modbus::rtu_timing timing_{};
    response_limits limits_{};
    reference::byte_list request_;
    reference::byte_list response_;
    reference::byte_list other_response_;
    reference::byte_list held_;
    reference::byte_list history_;
    reference::byte_list burst_;  ///< since the last gap
    bool may_have_ended_ = false; ///< a pause in it followed bytes whose CRC fits
    instant heard_{};
    instant now_{};
    instant sent_{};
    duration longest_{};
    duration idle_{};
};

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::input in{data, size};
    bench{in}.run();
    return 0;
}
