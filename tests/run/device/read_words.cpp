// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Each field of the feedback, of a fault's record and of a wide position comes from its own register, in the drive's
// word order. Each register of the drive holds another value.
#include <cstdint>

#include <doctest/doctest.h>

#include <servobus/device/c630s.hpp>
#include <servobus/device/yako.hpp>
#include <servobus/device/zlac8015d.hpp>
#include <tests/support/driven_zlac8015d.hpp>
#include <tests/support/simulated_c630s.hpp>
#include <tests/support/simulated_yako.hpp>

namespace read_words_tests {

using namespace servobus;
using namespace servobus::units;

namespace {

/// A drive whose registers from `first` to `last` hold their own addresses, once `is_distinct`: 0B07h holds 0B07h.
template <class Model> struct distinct : Model {
    using Model::Model;
    bool is_distinct = false;
    u16 first = 0;
    u16 last = 0;

    void show(u16 from, u16 to) {
        is_distinct = true;
        first = from;
        last = to;
    }
    std::uint8_t read(u16 address, slice<u16> to) {
        const std::uint8_t why = Model::read(address, to);
        for (std::size_t i = 0; i < to.size(); ++i) {
            const auto at = static_cast<u16>(address + i);
            if (is_distinct && at >= first && at <= last) to[i] = at;
        }
        return why;
    }
};

template <class Model, template <class> class Drive>
struct axis : simulated::simulated_yako<distinct<Model>> {
    Drive<typename simulated::simulated_yako<distinct<Model>>::line_type> drive{this->line, 1, unsupervised};
};
struct servo : simulated::simulated_model<distinct<sim::c630s>, sim::c630s_options, 57600> {
    c630s::drive<line_type> drive{line, 1, unsupervised};
};
struct dual_servo : simulated::simulated_model<distinct<sim::zlac8015d>, sim::zlac8015d_options, 115200> {
    zlac8015d::drive<line_type> drive{line, 1, unsupervised};
};

} // namespace

TEST_CASE("a YAKO's feedback has each of its registers") {
    const auto check = [](auto a, int of_a_count, bool is_low_first) {
        REQUIRE(a->drive.run(init{}));
        if (is_low_first) REQUIRE(a->drive.run(yako::set_word_order{yako::word_order_setting::low_first}));
        // 0007h is the status, which has an alarm in 0008h and more: it stays as it is.
        a->model.show(0x0008, 0x000C);
        const auto f = a->drive.read();
        REQUIRE(f);
        CHECK(f->error == 0);
        CHECK(f->inputs.to_word() == (0x0008 & 0x7F));
        CHECK(f->position.count() == (is_low_first ? 0x000B'000A : 0x000A'000B));
        CHECK(f->speed == yako::speed{0x0C * of_a_count}); // in 0.1 r/min
        CHECK(a->drive.feedback(milliseconds(1000))->position == f->position);
        a->model.show(0x0009, 0x0009);
        CHECK(a->drive.read()->outputs.to_word() == (0x0009 & 3));
        a->model.show(0x0006, 0x0006);
        CHECK(a->drive.read()->error == 0x0006);
    };
    using closed = axis<sim::yako_closed_loop, yako::closed_loop::drive>;
    using open = axis<sim::yako_open_loop, yako::open_loop::drive>;
    for (const bool is_low_first : {false, true}) {
        CAPTURE(is_low_first);
        closed c;
        check(&c, 10, is_low_first);
        open o;
        check(&o, 10, is_low_first);
    }
    closed finer;
    REQUIRE(finer.drive.run(init{}));
    REQUIRE(finer.drive.run(yako::set_speed_resolution{yako::speed_count::tenth_r_per_min}));
    finer.model.show(0x000C, 0x000C);
    CHECK(finer.drive.read()->speed == yako::speed{0x0C});
}

TEST_CASE("a C630S's feedback, fault records and wide positions have each of their registers") {
    servo r;
    REQUIRE(r.drive.run(init{}));
    r.model.show(0x0B00, 0x0BFF);
    const result<c630s::feedback> f = r.drive.read();
    REQUIRE(f);
    CHECK(f->speed.count() == 0x0B00);
    CHECK(f->commanded_speed.count() == 0x0B01);
    CHECK(f->torque.count() == 0x0B02);
    CHECK(f->wired_inputs.to_word() == (0x0B03 & c630s::inputs::from_word(0xFFFF).to_word()));
    CHECK(f->position.count() == 0x0B08'0B07); // the low word first
    CHECK(f->following_error.count() == 0x0B36'0B35);
    CHECK(f->fine_speed.count() == 0x0B38'0B37);
    CHECK(f->alarm_code == 0); // of another record than the present one
    r.model.show(0x0B22, 0x0B22);
    CHECK(r.drive.read()->alarm_code == 0x0B22);
    // The record that is read back is the one that was asked for.
    r.model.show(0x0B22, 0x0B2A);
    const auto e = r.drive.fault(3);
    REQUIRE(e);
    CHECK(e->alarm_code == 0x0B22);
    CHECK(e->time.count() == 0x0B24'0B23);
    CHECK(e->speed.count() == 0x0B25);
    CHECK(e->u_current.count() == 0x0B26);
    CHECK(e->v_current.count() == 0x0B27);
    CHECK(e->bus_voltage.count() == 0x0B28);
    CHECK(e->wired_inputs.to_word() == (0x0B29 & c630s::inputs::from_word(0xFFFF).to_word()));
    CHECK(e->wired_outputs.to_word() == (0x0B2A & c630s::outputs::from_word(0xFFFF).to_word()));
    r.model.show(0x0B00, 0x0BFF);
    using enum c630s::wide_position;
    CHECK(*r.drive.read(mechanical) == 0x0B3D'0B3C'0B3B'0B3A);
    CHECK(*r.drive.read(encoder) == 0x0B50'0B4F'0B4E'0B4D);
    CHECK(*r.drive.read(load) == 0x0B54'0B53'0B52'0B51);
}

TEST_CASE("a ZLAC8015D's feedback has each of its registers") {
    dual_servo r;
    REQUIRE(r.drive.run(init{}));
    r.model.show(0x20A3, 0x20AC);
    const result<zlac8015d::feedback> f = r.drive.read();
    REQUIRE(f);
    CHECK(f->hall.to_word() == zlac8015d::hall_inputs::from_word(0x20A3).to_word());
    CHECK(f->temperature.to_word() == zlac8015d::motor_temperatures::from_word(0x20A4).to_word());
    CHECK(f->left_faults == zlac8015d::faults{0x20A5});
    CHECK(f->right_faults == zlac8015d::faults{0x20A6});
    CHECK(f->left_position.count() == 0x20A7'20A8); // the high word first
    CHECK(f->right_position.count() == 0x20A9'20AA);
    CHECK(f->left_speed.count() == 0x20AB);
    CHECK(f->right_speed.count() == 0x20AC);
}

} // namespace read_words_tests
