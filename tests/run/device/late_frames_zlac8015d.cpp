// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A ZLAC8015D whose responses come later than the limit of its profile, and within limit and quarantine: G2, G15 and
// honest ends of a move. A short limit costs commands, and never truth.
#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>

#include <tests/support/driven_zlac8015d.hpp>

namespace late_frames_zlac8015d_tests {

using namespace servobus;
using namespace servobus::units;
using namespace servobus::zlac8015d;

namespace {

constexpr node<zlac8015d::device> by_default{1};
constexpr std::uint32_t limit_ms = by_default.limits.response.us / 1000;
constexpr std::uint32_t hidden_ms = limit_ms + by_default.gaps.quarantine.us / 1000;
static_assert(limit_ms == 32 && hidden_ms == 132);
// A response begins t3.5 after its request, and so much later.
constexpr std::uint32_t latest_ms = hidden_ms - 2;
constexpr std::size_t every_frame = ~std::size_t{0};

/// Each frame of a program, and the response to one of them, or to all, late.
struct late_rig {
    simulated::driven_zlac8015d r;
    std::size_t frames = 0;
    std::size_t late = 0; // counts from 1
    std::uint32_t starts_sent = 0;
    std::uint64_t last_us = 0; // the last byte of a request

    explicit late_rig(std::uint32_t ms) {
        r.wire.faults().late_by = milliseconds(ms);
        r.wire.set_hook(&late_rig::note, this);
    }
    late_rig(const late_rig&) = delete;

    static void note(void* self, const sim::wire_byte& b) {
        auto& at = *static_cast<late_rig*>(self);
        if (!b.is_from_client) return;
        // A stop waits for no quarantine: a late response may have garbled its first frame.
        constexpr std::uint64_t gap_us = 1000;
        if (b.at_us > at.last_us + gap_us) at.r.log.open.clear();
        at.last_us = b.at_us;
        const std::size_t before = at.r.log.frames.size();
        simulated::request_log::note(&at.r.log, b);
        if (at.r.log.frames.size() == before) return;
        ++at.frames;
        const simulated::frame& f = at.r.log.frames.back();
        if (f[1] == 0x06 && load_word(f, 2) == 0x200E && f[5] == 0x10) ++at.starts_sent;
        at.r.wire.faults().late_response = at.late == at.frames || at.late == every_frame ? 1000 : 0;
    }
    void spoil(std::size_t frame) {
        frames = 0;
        late = frame;
    }
    std::int64_t position() const { return r.model.left().position; }
};

/// A value of the feedback is the drive's, at some moment of the read that returns it.
void check_read(late_rig& w) {
    const std::int64_t before = w.position();
    const auto seen = w.r.drive.read();
    if (!seen) return;
    const std::int64_t now = seen->left_position.count();
    CHECK(now >= before);
    CHECK(now <= w.position());
}

void be_ready(late_rig& w) {
    REQUIRE(w.r.drive.run(init{}));
    REQUIRE(w.r.drive.run(enable_in{operating_mode::relative_position}));
}

} // namespace

TEST_CASE("G2, G15: a move with one frame that is late is made once, and its ends are honest") {
    unsigned played = 0, made = 0, lost = 0;
    for (std::uint32_t ms = limit_ms; ms <= latest_ms; ms += 7) {
        for (std::size_t late = 1;; ++late) {
            CAPTURE(ms);
            CAPTURE(late);
            late_rig w{ms};
            be_ready(w);
            const std::int64_t from = w.position();
            w.spoil(late);
            const command_status moved = w.r.drive.run(move_by{2000 * pulse, 2000 * pulse});
            const command_status reached = moved ? w.r.drive.run(wait_reached{}) : moved;
            check_read(w);
            check_read(w);
            CHECK(w.starts_sent <= 1);
            CHECK(w.r.model.starts() <= 1);
            if (moved) CHECK(w.r.model.starts() == 1);
            if (moved.outcome() == outcome::not_sent || moved.outcome() == outcome::refused)
                CHECK(w.r.model.starts() == 0);
            if (reached) CHECK(w.position() == from + 2000);
            if (!moved) REQUIRE(w.r.drive.run(halt{}));
            ++played;
            made += reached ? 1u : 0u;
            lost += moved ? 0u : 1u;
            if (w.frames < late) break;
        }
    }
    CHECK(played > 100);
    CHECK(made > 50);
    CHECK(lost > 10);
}

TEST_CASE("G2, G15: a program whose frames are all late makes no move twice and reads no value of another "
          "request") {
    for (std::uint32_t ms = limit_ms; ms <= latest_ms; ms += 1) {
        CAPTURE(ms);
        late_rig w{ms};
        be_ready(w);
        w.spoil(every_frame);
        const command_status moved = w.r.drive.run(move_by{2000 * pulse, 2000 * pulse});
        CHECK(moved.outcome() != outcome::done);
        for (int i = 0; i < 10; ++i) {
            check_read(w);
            w.r.wire.pass(milliseconds(3));
        }
        CHECK(w.starts_sent <= 1);
        CHECK_FALSE(w.r.drive.run(init{}));
        CHECK(w.r.model.starts() <= 1);
        w.spoil(0);
        // All that came late has come within the quarantine of the last request.
        REQUIRE(w.r.drive.run(init{}));
        CHECK(w.r.model.stands_still());
        CHECK(w.r.model.starts() <= 1);
        be_ready(w);
        const std::int64_t from = w.position();
        REQUIRE(w.r.drive.run(move_by{2000 * pulse, 2000 * pulse}));
        REQUIRE(w.r.drive.run(wait_reached{}));
        CHECK(w.position() == from + 2000);
    }
}

} // namespace late_frames_zlac8015d_tests
