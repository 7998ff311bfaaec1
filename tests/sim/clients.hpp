// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The line of one run with one to four clients on it, each with its device. Everything is drawn from the
// seed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include <servobus/device/c630s/catalogue.hpp>
#include <servobus/device/yako/closed_loop_catalogue.hpp>
#include <servobus/device/yako/open_loop_catalogue.hpp>
#include <servobus/device/zlac8015d/catalogue.hpp>
#include <servobus/sim/c630s.hpp>
#include <servobus/sim/yako.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include "world.hpp"

namespace trial {

/// What the adapter does with the echo of a request.
enum class hearing : std::uint8_t {
    nothing, ///< it has no echo, or drops it
    itself,  ///< passes it on, and the line is configured for it
    untold,  ///< passes it on, and the line is not configured for it: no call may succeed
};

template <class Line> class clients final : public world {
  public:
    using line_type = Line;
    using test_participant = participant_of<line_type, test_device::device, test_device::registers>;

    clients(std::uint64_t seed, event_counts& count, std::size_t notes, const conditions& of,
            hearing adapter = hearing::nothing, bool has_devices = true)
        : world{seed, count, notes, of}, line_{port(), of.timing, watch{&court()}} {
        if constexpr (requires { line_.echo().is_on; }) {
            line_.echo().is_on = adapter == hearing::itself;
            if (line_.echo().is_on) court().expect_echoes();
        }
        if (adapter != hearing::nothing) port().echo.be_kept();
        // For a blocking line a frame that is not the response ends at the next gap that the line sees, not
        // earlier.
        if constexpr (Line::is_small) {
            state().frames_apart_us =
                of.timing.longest_gap(1).us + 2u * of.timing.character + state().blur_us;
            court().bear_glitches();
            court().suspect_all_as_one();
            // It reads its clock before its receiver, so it counts a stall between the two as a part of the
            // next gap.
            port().stalls_before_receive = false;
        }
        if (!has_devices) be_empty();
        fill_participants();
        hostility = draw_hostility(state());
        events = state().random.below(3) == 0 ? 0 : state().random.below(120);
        if (state().one_in(6)) port().takes_at_most = state().between(4, 16);
        begin_to_stall();
    }

    line_type& line() { return line_; }

  private:
    void fill_participants() {
        for (std::uint32_t n = state().between(1, 4); n != 0; --n) {
            add_participant();
            settle(*this, *participants().back());
        }
    }
    template <class Device, class Store, class... Options>
    void add(const servobus::catalogue& map, Options... options) {
        (void)take_in(std::make_unique<participant_of<line_type, Device, Store>>(
            state(), line_, others(), map, free_unit(), baud(), options...));
    }
    template <class Options> Options drawn() { return state().manuals.template draw<Options>(); }
    void add_participant() {
        using namespace servobus;
        const std::uint32_t kind = state().random.below(10);
        switch (kind) {
        case 0:
            return add<zlac8015d::device, sim::zlac8015d>(zlac8015d::catalogue,
                                                          drawn<sim::zlac8015d_options>());
        case 1:
            return add<yako::closed_loop::device, sim::yako_closed_loop>(yako::closed_loop::catalogue,
                                                                         drawn<sim::yako_options>());
        case 2:
            return add<yako::open_loop::device, sim::yako_open_loop>(yako::open_loop::catalogue,
                                                                     drawn<sim::yako_options>());
        case 3: return add<c630s::device, sim::c630s>(c630s::catalogue, drawn<sim::c630s_options>());
        default: return add_test_device();
        }
    }
    void add_test_device() {
        add<test_device::device, test_device::registers>(test_device::catalogue);
        auto& node = static_cast<test_participant&>(*participants().back()).client.node();
        node.word_order =
            state().one_in(2) ? servobus::word_order::low_first : servobus::word_order::high_first;
        node.read_retries = static_cast<std::uint8_t>(state().between(0, 3));
    }

    line_type line_;
};

} // namespace trial
