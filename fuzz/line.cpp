// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A line over a port that does what the input says. Every call ends within its bound, silences are kept, a
// success has its reply; afterwards, with a port that works again, the next call succeeds.
#include <algorithm>
#include <cstdint>

#include <servobus/line.hpp>

#include "driven_port.hpp"

using namespace servobus;
using fuzz::require;
using modbus::exchange;

namespace {

class bench {
  public:
    explicit bench(fuzz::input& in)
        : in_{&in}, clock_{clock_of(in.byte())}, tick_{1u + in.byte() % 8u}, port_{in, clock_, tick_},
          line_{port_, modbus::timing_at(115200, in.flag() ? modbus::timing_mode::strict
                                                           : modbus::timing_mode::host)} {}

    void run() {
        const int most =
            clock_ == fuzz::clock_kind::stopped ? 1 : 8; // there each call takes its 10 000 looks
        for (int i = 0; i < most && !in_->empty(); ++i) transact();
        port_.calm_down();
        port_.time += 60'000'000; // whoever held the line is gone
        const bool is_done = succeeds();
        if (clock_ != fuzz::clock_kind::stopped)
            require(is_done, "G9 on a line that works again a call succeeds");
    }

  private:
    using line_type = line<fuzz::driven_port, unobserved>;

    static fuzz::clock_kind clock_of(std::uint8_t choice) {
        if (choice >= 0xFC) return fuzz::clock_kind::stopped;
        return choice < 0xA0 ? fuzz::clock_kind::honest : fuzz::clock_kind::jumping;
    }

    void transact() {
        const unsigned how = in_->byte();
        const silences wanted{duration{fuzz::time_of(in_->byte() & 0x8Fu)},
                              duration{fuzz::time_of(in_->byte() & 0x8Fu)}, (how & 1u) != 0};
        patience limits;
        limits.response = duration{fuzz::time_of(in_->byte() & 0x8Fu)};
        limits.leading_bytes = static_cast<std::uint8_t>(how >> 5);
        const reference::byte_list request = next_request();
        reference::byte_list reply(request[1] == 3 ? 5 + 2u * request[5] : 8u);
        exchange x{request, reply, line_.timing(), limits};
        require(!x.done(), "a good request is ready");

        port_.forget();
        const start begun{*this};
        const duration bound = line_.bound(request.size(), reply.size(), limits, wanted);
        switch (how / 2 % 8) {
        case 0: step(x, wanted, in_->byte()); break; // and then it is forgotten
        case 1:
            step(x, wanted, in_->byte());
            line_.abandon(x);
            require(x.done(), "an exchange that is given up has ended");
            break;
        case 2: step(x, wanted, 100'000); break;
        default: line_.run(x, wanted); break;
        }
        begun.judge_time(*this, bound);
        judge(x, wanted);
        if (x.done()) return;
        intrude(request, limits, wanted);
        port_.time += 60'000'000; // it has had all its time
    }

    // Before a call, and at its end.
    struct start {
        std::uint64_t time;
        std::size_t left;

        explicit start(const bench& b) : time{b.port_.time}, left{b.in_->size()} {}

        // Each byte of the input makes at most a call take longer or be made once more.
        void judge_time(const bench& b, duration bound) const {
            if (b.clock_ != fuzz::clock_kind::honest) return;
            const std::uint64_t slack = b.tick_ * (200 + 8 * (left - b.in_->size()));
            require(b.port_.time - time <= bound.us + slack, "G29 a call returns within its bound");
        }
    };

    reference::byte_list next_request() {
        const unsigned what = in_->byte();
        const std::uint8_t unit = what % 8 == 0 ? std::uint8_t{0} : std::uint8_t{5};
        const auto n = static_cast<std::uint8_t>(1 + what / 8 % 4);
        reference::byte_list body{unit, 6, 0x20, 0x88, 0x00, n};
        if (what % 8 >= 4) body[1] = 3;
        if (what % 8 == 3) {
            body[1] = 16;
            body.push_back(static_cast<std::uint8_t>(2 * n));
            body.resize(7 + 2u * n, 0x11);
        }
        return reference::framed(body);
    }

    void step(exchange& x, const silences& wanted, unsigned most) {
        for (unsigned i = 0; i < most && !x.done(); ++i) {
            const duration idle = line_.step(x, wanted);
            if (x.done()) break;
            // A superloop has no guard against a clock that stands still: it is the caller's turn to stop.
            if (clock_ == fuzz::clock_kind::stopped && in_->empty()) break;
            port_.wait(idle < duration{5000} ? idle : duration{5000});
        }
    }

    // One exchange at a time.
    void intrude(const reference::byte_list& request, const patience& limits, const silences& wanted) {
        reference::byte_list reply(256);
        exchange other{request, reply, line_.timing(), limits};
        const std::size_t before = port_.request.size();
        line_.step(other, wanted);
        if (other.done() && other.why().code == errc::busy)
            require(port_.request.size() == before && !other.was_sent(),
                    "who finds the line busy sends nothing");
        if (!other.done()) line_.abandon(other);
    }

    void judge(const exchange& x, const silences& wanted) {
        const bool has_begun = !port_.request.empty();
        if (has_begun && clock_ == fuzz::clock_kind::honest && !port_.has_lied) {
            require(port_.silence_before >= line_.timing().t3_5, "G8 a request comes after t3.5 of silence");
            require(port_.silence_before >= wanted.gap.us, "G8 a request comes after the node's own gap");
            if (is_troubled_ && !wanted.is_urgent) {
                const std::uint64_t silence =
                    std::max(line_.timing().visible_silence().us, wanted.quarantine.us);
                require(port_.silence_before >= silence, "G1 after trouble the line is left silent");
            }
        }
        if (has_begun && !wanted.is_urgent) is_troubled_ = false;
        if (!x.done()) { // one that was never begun troubles nobody
            is_troubled_ = is_troubled_ || has_begun;
            return;
        }
        const errc why = x.why().code;
        if (why != errc::ok && why != errc::exception) {
            if (x.was_sent() || has_begun) is_troubled_ = true;
            if (!port_.has_lied)
                require(x.was_sent() == has_begun, "G16 what is not sent has not begun to leave");
            return;
        }
        if (port_.has_lied) return;
        require(same_bytes(port_.request, x.request()), "a success is that of a request that left whole");
        if (x.is_broadcast()) return;
        const reference::byte_list f{x.reply().begin(), x.reply().end()};
        require(reference::is_frame(f) && f[0] == x.request()[0],
                "G2 a reply is a frame of the unit that was asked");
        require((f[1] & 0x7Fu) == x.request()[1], "G2 a reply has the request's function");
        const auto found = std::search(port_.heard.begin(), port_.heard.end(), f.begin(), f.end());
        require(found != port_.heard.end(), "G1 a reply has come after its request had left");
    }

    bool succeeds() {
        patience limits;
        const reference::byte_list request = reference::framed({5, 3, 0x20, 0xAB, 0, 2});
        reference::byte_list reply(9);
        exchange x{request, reply, line_.timing(), limits};
        port_.forget();
        const start begun{*this};
        const duration bound = line_.bound(request.size(), reply.size(), limits, {});
        line_.run(x, {});
        require(x.done(), "a blocking call ends");
        begun.judge_time(*this, bound);
        return x.why().code == errc::ok;
    }

    fuzz::input* in_;
    fuzz::clock_kind clock_;
    std::uint32_t tick_;
    fuzz::driven_port port_;
    line_type line_;
    bool is_troubled_ = false;
};

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::input in{data, size};
    bench{in}.run();
    return 0;
}
