// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A line over a port that is driven by the input. Every call ends within its bound, gaps are kept, and a
// successful call has its response. Afterwards, with a port that works again, the next call succeeds.
#include <cstdint>

#include <servobus/line/line.hpp>

#include "line_calls.hpp"

using namespace servobus;
using fuzz::require;
using modbus::exchange;

namespace {

class bench {
  public:
    explicit bench(fuzz::input& in)
        : on_{in}, line_{on_.port, modbus::timing_at(115200, in.flag() ? modbus::timing_mode::strict
                                                                       : modbus::timing_mode::host)},
          judge_{on_, line_.timing().t3_5, false} {}

    void run() {
        for (int i = 0; i < on_.most_calls() && !on_.in->empty(); ++i) transact();
        fuzz::judge_recovery(on_, line_, judge_);
    }

  private:
    void transact() {
        const fuzz::call c{*on_.in};
        reference::byte_list response(fuzz::response_size(c.request));
        exchange x{c.request, response, line_.timing(), c.limits, c.priority};
        require(!x.done(), "a valid request is ready to be sent");

        judge_.begin();
        const bool was_proven = line_.is_echo_ruled_out();
        const duration bound = line_.bound(c.request.size(), response.size(), c.limits, c.wanted);
        switch (c.how / 2 % 8) {
        case 0: step(x, c.wanted, on_.in->byte()); break; // then it is destroyed
        case 1:
            step(x, c.wanted, on_.in->byte());
            line_.abandon(x);
            require(x.done(), "an exchange that is given up has ended");
            break;
        case 2: step(x, c.wanted, 100'000); break;
        default: line_.run(x, c.wanted); break;
        }
        judge_.judge_time(bound);
        judge_.judge_silence(c, longer_of(line_.timing().visible_gap(), c.wanted.quarantine));
        if (x.done()) {
            judge_.judge_end(x.status(), c.request, x.response(), c.limits);
            if (!was_proven && line_.is_echo_ruled_out())
                require(x.status().error() == errc::exception || !same_bytes(x.response(), c.request),
                        "G3 a response that repeats the request does not rule the echo out");
            return;
        }
        judge_.note_unfinished();
        intrude(c);
        on_.port.time += 60'000'000; // longer than any of its time limits
    }

    void step(exchange& x, const bus_gaps& wanted, unsigned most) {
        for (unsigned i = 0; i < most && !x.done(); ++i) {
            const duration idle = line_.step(x, wanted);
            if (x.done()) break;
            // `step` does not detect a stopped clock, so this loop ends by itself.
            if (on_.clock == fuzz::clock_kind::stopped && on_.in->empty()) break;
            on_.port.wait(idle < duration{5000} ? idle : duration{5000});
        }
    }

    // Another exchange while the line carries one: it must send nothing.
    void intrude(const fuzz::call& c) {
        reference::byte_list response(256);
        exchange other{c.request, response, line_.timing(), c.limits, c.priority};
        const std::size_t before = on_.port.request.size();
        line_.step(other, c.wanted);
        if (other.done() && other.status().error() == errc::busy)
            require(on_.port.request.size() == before && !other.was_sent(),
                    "an exchange that ends as busy has sent nothing");
        if (!other.done()) line_.abandon(other);
    }

    fuzz::wire on_;
    line<fuzz::driven_port, unobserved> line_;
    fuzz::call_judge judge_;
};

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::input in{data, size};
    bench{in}.run();
    return 0;
}
