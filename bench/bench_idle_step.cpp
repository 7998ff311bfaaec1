// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Steps a bus while none of its reads is due, for bench/plan_cost.py, which counts the instructions of a step. Before
// that each read has had a response.
//   idle_step READS STEPS    READS: 2 or 60
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include <servobus/bus/bus.hpp>

namespace {

using namespace servobus;

struct meter {
    static constexpr profile facts{.name = "meter"};
};
constexpr reg<u16, access::ro, meter> level{0x0010, full<u16>, no_unit, no_default};

/// A port at which any node responds to a request for one register.
class answering_port {
  public:
    transfer send(bytes request) {
        response_ = {request[0], 3, 2, 0, 7};
        (void)modbus::close_frame(response_, 4);
        begins_ = now_ + 1500;
        at_ = 0;
        return static_cast<std::uint16_t>(request.size());
    }
    bool sent() const { return static_cast<std::int32_t>(now_ - begins_) > -700; }
    transfer receive(byte_buffer to) {
        std::uint16_t n = 0;
        if (now_ < begins_) return n;
        while (at_ < response_.size() && n < to.size()) to[n++] = response_[at_++];
        return n;
    }
    instant now() const { return {now_}; }
    void pass(std::uint32_t us) { now_ += us; }

  private:
    std::array<std::uint8_t, 7> response_{};
    std::size_t at_ = 7;
    std::uint32_t now_ = 0;
    std::uint32_t begins_ = 0;
};

template <std::size_t... I> consteval auto reads(std::index_sequence<I...>) {
    return poll_plan{modbus::timing_at(115200),
                     cyclic<level>(node<meter>{std::uint8_t{I + 1}}, milliseconds(600'000))...};
}
constexpr auto few = reads(std::make_index_sequence<2>{});
constexpr auto many = reads(std::make_index_sequence<60>{});

template <const auto& Plan> int run_idle(long steps) {
    answering_port port;
    scheduled_line on{port, Plan.timing()};
    auto all = make_bus<Plan>(on);
    for (int i = 0; all.count(Plan.size - 1) == 0; ++i, port.pass(100)) {
        if (i == 100'000) return 1;
        (void)all.step();
    }
    std::uint32_t idle = 0;
    for (; steps > 0; --steps, port.pass(100)) idle += all.step().us;
    return idle == 0;
}

} // namespace

int main(int count, char** words) {
    if (count != 3) return 2;
    const long steps = std::atol(words[2]);
    return std::atoi(words[1]) == 2 ? run_idle<few>(steps) : run_idle<many>(steps);
}
