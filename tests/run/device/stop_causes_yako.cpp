// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Why a YAKO's move has stopped short, by each of its inputs with each function, and by the software limits.
#include <cstddef>
#include <cstdint>
#include <initializer_list>

#include <doctest/doctest.h>

#include <servobus/device/yako.hpp>
#include <tests/support/driven_yako.hpp>

namespace stop_causes_yako_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::yako;

namespace {

/// A drive whose move has come to rest short of its target, with these inputs. 0041h and on are their functions.
template <class Model> struct cut_short : Model {
    using Model::Model;
    bool is_cut = false;
    u16 status = 0; ///< of 0007h besides
    u16 inputs = 0; ///< 0008h
    u16 functions[7]{};

    std::uint8_t read(u16 address, slice<u16> to) {
        const std::uint8_t why = Model::read(address, to);
        for (std::size_t i = 0; is_cut && i < to.size(); ++i) {
            const std::size_t at = address + i;
            if (at == 0x0007) to[i] = static_cast<u16>((to[i] & ~0x0064u) | status);
            if (at == 0x0008) to[i] = inputs;
            if (at == 0x000A || at == 0x000B) to[i] = at == 0x000B ? u16{50} : u16{0}; // the place
            if (at >= 0x0041 && at <= 0x0047) to[i] = functions[at - 0x0041];
        }
        return why;
    }
};

template <class Axis> void check_inputs(std::size_t inputs) {
    Axis a;
    REQUIRE(a.drive.run(init{}));
    REQUIRE(a.drive.run(enable{}));
    const auto cause = [&] {
        a.model.is_cut = false;
        REQUIRE(a.drive.run(halt{}));
        REQUIRE(a.drive.run(declare_position{0 * pulse}));
        REQUIRE(a.drive.run(move_by{1000 * pulse}));
        a.model.is_cut = true;
        a.run(300);
        CHECK(a.drive.run(wait_reached{}).error() == errc::stopped_short);
        return a.drive.arrival().cause;
    };
    for (std::size_t i = 0; i < inputs; ++i) {
        CAPTURE(i);
        for (unsigned f = 0; f <= 18; ++f) {
            CAPTURE(f);
            for (const bool is_active : {true, false}) {
                CAPTURE(is_active);
                for (u16& other : a.model.functions) other = 1; // home
                a.model.functions[i] = static_cast<u16>(f);
                a.model.inputs = static_cast<u16>(is_active ? 1u << i : 0x7Fu & ~(1u << i));
                // Limits, "motor free", stop, emergency stop.
                CHECK(cause() == (is_active && f >= 2 && f <= 6 ? stop_cause::input : stop_cause::unknown));
            }
        }
    }
    a.model.inputs = 0;
    for (const u16 beyond : {u16{0x0020}, u16{0x0040}}) {
        a.model.status = beyond;
        CHECK(cause() == stop_cause::software_limit);
    }
    a.model.status = 0;
    CHECK(cause() == stop_cause::unknown); // not that of the move before
}

} // namespace

TEST_CASE("G34: the cause of a move's end is each input that stops it, and no other") {
    SUBCASE("closed loop") {
        check_inputs<simulated::driven_yako<cut_short<sim::yako_closed_loop>, closed_loop::drive>>(4);
    }
    SUBCASE("open loop") {
        check_inputs<simulated::driven_yako<cut_short<sim::yako_open_loop>, open_loop::drive>>(7);
    }
}

} // namespace stop_causes_yako_tests
