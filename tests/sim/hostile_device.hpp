// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A device whose bytes are damaged on their way: it is placed between a station and the line and decides
// for each response what happens to it. Late and doubled responses stay within the limits of G2.
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/sim/station.hpp>

#include "neighbours.hpp"
#include "scene.hpp"
#include "timed_sender.hpp"

namespace trial {

class hostile_device final : public servobus::sim::line_device {
  public:
    hostile_device(scene& on, servobus::sim::line_device& inner, babbler& others)
        : on_{&on}, inner_{&inner}, others_{&others}, sender_{on} {}

    /// The client begins to send. Decides what this device will receive of the request.
    void prepare(std::size_t size, bool may_be_spoiled) {
        heard_ = 0;
        expected_ = size;
        is_lost_ = may_be_spoiled && loses_request_;
        spoiled_at_ = nowhere;
        if (is_lost_) {
            loses_request_ = false;
            ++losses_;
            return on_->strikes(last_loss_ = strike::lost_request);
        }
        if (!may_be_spoiled || on_->random.below(6000) >= on_->chance) return;
        if (on_->one_in(2)) {
            is_lost_ = true;
            on_->strikes(strike::lost_request);
        } else {
            spoiled_at_ = on_->random.below(static_cast<std::uint32_t>(size));
            on_->strikes(strike::corrupted_request);
            on_->is_spoiled = true;
        }
    }
    /// The next request to it is lost, or its next response.
    void lose_next(bool is_response) { (is_response ? loses_response_ : loses_request_) = true; }
    void lose_nothing() { loses_request_ = loses_response_ = false; }
    /// What was lost last by `lose_next`.
    strike last_loss() const { return last_loss_; }
    unsigned losses() const { return losses_; }
    /// Without power for a time: it receives and sends nothing. The station does not notice and goes on
    /// with its response, so the device stays off until that response would have ended.
    void be_off(std::uint64_t until_us) {
        off_until_ = until_us < on_->sounding_until ? on_->sounding_until : until_us;
        sender_.stop();
    }
    bool is_off() const { return on_->now() < off_until_; }

    void receive(std::uint8_t byte, bool is_readable, servobus::instant now) override {
        const std::size_t at = heard_++;
        if (is_off() || (at < expected_ && is_lost_)) return;
        inner_->receive(at == spoiled_at_ ? static_cast<std::uint8_t>(byte ^ 0x10u) : byte, is_readable, now);
    }
    servobus::duration run(servobus::instant now) override {
        const servobus::duration quiet = inner_->run(now);
        take(inner_->send(now));
        const servobus::duration due = sender_.until_due();
        return quiet < due ? quiet : due;
    }
    servobus::bytes send(servobus::instant) override { return sender_.due(); }
    std::uint32_t baud() const override { return inner_->baud(); }

  private:
    static constexpr std::size_t nowhere = ~std::size_t{0};

    // Takes a response of the station and sends it now, changed, or never.
    void take(servobus::bytes frame) {
        if (const std::uint64_t end = on_->now() + on_->wire_time(frame.size()); is_off() && end > off_until_)
            off_until_ = end;
        if (!frame.empty() && !is_off() && loses_response_) {
            loses_response_ = false;
            ++losses_;
            on_->sounds_until(on_->now() + on_->wire_time(frame.size()) + on_->timing.t3_5);
            on_->strikes(last_loss_ = strike::lost_response);
        } else if (!frame.empty() && !is_off()) {
            // Some drives respond to noise that looks like a damaged request.
            if (frame[0] != on_->asked_node) {
                on_->is_struck = true;
                (void)say(on_->now(), frame);
            } else if (on_->random.below(1000) >= on_->chance) {
                sender_.send_at(on_->now(), frame);
            } else {
                spoil({frame.begin(), frame.end()});
            }
        }
    }
    // Returns the time at which it ends.
    std::uint64_t say(std::uint64_t at, servobus::bytes what) {
        const std::uint64_t end = sender_.send_at(at, what);
        on_->sounds_until(end);
        return end;
    }
    // Sends two pieces without a gap between them.
    void say(std::uint64_t at, servobus::bytes first, servobus::bytes then) {
        (void)say(say(at, first), then);
    }

    void spoil(byte_list frame) {
        scene& on = *on_;
        const std::uint64_t now = on.now();
        const bool was_silent = on.sounding_until < now;
        // The station receives no request until then, whatever becomes of its response.
        on.sounds_until(now + on.wire_time(frame.size()) + on.timing.t3_5);
        constexpr auto first = static_cast<std::uint32_t>(strike::lost_response);
        constexpr auto last = static_cast<std::uint32_t>(strike::flood);
        switch (static_cast<strike>(on.between(first, last))) {
        case strike::lost_response: return on.strikes(strike::lost_response);
        case strike::late_response: return be_late(frame, was_silent);
        case strike::doubled_response: return double_it(frame);
        case strike::cut_response:
            on.strikes(strike::cut_response);
            on.must_fail = true;
            frame.resize(on.random.below(static_cast<std::uint32_t>(frame.size())));
            return (void)say(now, frame);
        case strike::corrupted_response: return corrupt(frame);
        case strike::short_pause: return pause(frame, false);
        case strike::long_pause: return pause(frame, true);
        case strike::noise_before: return make_noise(frame, true);
        case strike::noise_after: return make_noise(frame, false);
        case strike::glitch_before:
            on.strikes(strike::glitch_before, on.model.leading_bytes == 0);
            on.borne = "G5";
            return say(now, glitch(), frame);
        case strike::glitch_after: on.strikes(strike::glitch_after, false); return say(now, frame, glitch());
        case strike::foreign_before: return let_others_speak(frame);
        case strike::foreign_unit:
            on.strikes(strike::foreign_unit);
            on.must_fail = true;
            frame[0] = absent_unit();
            frame.resize(frame.size() - 2);
            return (void)say(now, closed(frame));
        case strike::misshapen_response: return misshape(frame);
        case strike::collision: return collide(frame);
        case strike::flood:
            on.strikes(strike::flood);
            on.is_spoiled = true;
            on.borne = "G10";
            (void)say(now, random_bytes(on, on.between(257, 700)));
            return;
        default: sender_.send_at(now, frame);
        }
    }

    // Later than the device would respond. It may begin after the timeout only if nothing else can have
    // ended the transaction earlier, since the quarantine begins when the transaction ends.
    void be_late(const byte_list& frame, bool was_silent) {
        scene& on = *on_;
        const bool is_alone = on.is_awaited && !on.may_end_early && was_silent;
        const std::uint32_t most = on.model.quarantine_us * 9 / 10 + (is_alone ? on.model.response_us : 0u);
        const std::uint32_t passed = passed_us();
        on.strikes(strike::late_response);
        (void)say(on.now() + on.between(0, most > passed ? most - passed : 0), frame);
    }

    // The second one begins before the next request has left, which has at least eight characters.
    void double_it(const byte_list& frame) {
        scene& on = *on_;
        on.strikes(strike::doubled_response, false);
        const std::uint64_t end = say(on.now(), frame);
        (void)say(end + on.between(0, on.timing.t3_5 + on.wire_time(5)), frame);
    }

    // All wrong bits lie within sixteen, so the CRC always detects them.
    void corrupt(byte_list frame) {
        scene& on = *on_;
        on.strikes(strike::corrupted_response);
        on.is_spoiled = true; // it may look like a shorter frame
        const std::size_t at = on.random.below(static_cast<std::uint32_t>(frame.size()));
        frame[at] = static_cast<std::uint8_t>(frame[at] ^ on.between(1, 255));
        if (at + 1 < frame.size() && on.one_in(2)) frame[at + 1] ^= on.any_byte();
        on.must_fail = true;
        (void)say(on.now(), frame);
    }

    void pause(const byte_list& frame, bool is_long) {
        scene& on = *on_;
        const bool is_strict = on.timing.mode == servobus::modbus::timing_mode::strict;
        const std::uint32_t borne = is_strict ? on.timing.t1_5 : on.timing.visible_gap().us;
        const std::uint32_t sure = is_strict ? borne : borne - 2u * on.timing.character;
        const std::size_t at = on.between(1, static_cast<std::uint32_t>(frame.size()) - 1);
        const servobus::bytes all{frame};
        std::uint32_t rest = on.between(1, sure * 8 / 10);
        const std::uint32_t seen = borne + 2u * on.timing.character + on.blur_us;
        if (is_long) rest = on.between(seen, borne + on.model.quarantine_us * 8 / 10);
        on.strikes(is_long ? strike::long_pause : strike::short_pause, is_long);
        // The client cannot see the pause while the adapter holds the bytes back.
        if (is_long && !on.does_clock_lie && on.now() >= on.held_until)
            on.must_fail = on.has_long_pause = true;
        on.borne = "G7";
        (void)say(say(on.now(), all.first(at)) + rest, all.subspan(at));
    }

    void make_noise(const byte_list& frame, bool is_before) {
        scene& on = *on_;
        on.strikes(is_before ? strike::noise_before : strike::noise_after, is_before);
        if (is_before) on.is_spoiled = true;
        const byte_list noise = random_bytes(on, on.between(1, 6));
        say(on.now(), is_before ? noise : frame, is_before ? frame : noise);
    }

    // From an absent address, since a present device would take the response to a write for a request.
    void let_others_speak(const byte_list& frame) {
        scene& on = *on_;
        neighbour what = any_neighbour(on);
        // A broadcast is a client's, and this line has one client, which waits for a response now.
        while (what == neighbour::broadcast) what = any_neighbour(on);
        ++on.count->lives.awaited[played::at(what)];
        const byte_list other = frame_of(on, what, absent_unit(), altered(frame));
        // A frame of unknown length ends with a gap.
        const std::uint32_t gap = on.timing.t3_5 + on.blur_us + 2u * on.timing.character;
        const std::uint32_t apart =
            has_known_length(what) || on.frames_apart_us > gap ? on.frames_apart_us : gap;
        // The device's own response must still begin in time.
        const std::uint32_t taken = on.wire_time(other.size() + 3) + apart;
        // The client cannot see that gap while the adapter holds the bytes back.
        const bool is_gap_hidden =
            !has_known_length(what) && on.held_until > on.now() + on.wire_time(other.size());
        on.strikes(strike::foreign_before, passed_us() + taken >= on.model.response_us || is_gap_hidden);
        on.borne = "G11";
        (void)say(say(on.now(), other) + apart, frame);
    }

    // A frame with a valid CRC that is not a valid response to the request.
    void misshape(byte_list frame) {
        scene& on = *on_;
        on.strikes(strike::misshapen_response);
        on.must_fail = true;
        frame.resize(frame.size() - 2);
        const bool is_read = servobus::modbus::is_read(frame[1]);
        const std::uint32_t way = on.random.below(4);
        if (way == 0 || (frame[1] & 0x80) != 0) {
            frame[1] = frame[1] == 0x03 ? 0x04 : 0x03;
        } else if (is_read && way == 1 && frame.size() > 5) {
            frame[2] = static_cast<std::uint8_t>(frame[2] - 2);
            frame.resize(frame.size() - 2);
        } else if (is_read) {
            frame[2] = static_cast<std::uint8_t>(frame[2] + 2);
            frame.push_back(on.any_byte());
            frame.push_back(on.any_byte());
        } else {
            frame[2 + on.random.below(4)] ^= static_cast<std::uint8_t>(0x40u << on.random.below(2));
        }
        (void)say(on.now(), closed(frame));
    }

    void collide(const byte_list& frame) {
        scene& on = *on_;
        on.strikes(strike::collision);
        on.is_spoiled = true;
        (void)say(on.now(), frame);
        const std::uint32_t offset = on.between(0, on.wire_time(frame.size() - 1));
        on.sounds_until(others_->sender.send_at(on.now() + offset, random_bytes(on, on.between(1, 12))));
    }

    byte_list glitch() {
        byte_list b;
        const std::uint32_t most = on_->model.leading_bytes == 0 ? 4u : on_->model.leading_bytes;
        for (std::uint32_t n = on_->between(1, most); n != 0; --n) b.push_back(on_->one_in(2) ? 0x00 : 0xFF);
        return b;
    }
    std::uint8_t absent_unit() { return static_cast<std::uint8_t>(on_->between(200, 247)); }

    // The time since the request has left.
    std::uint32_t passed_us() const { return static_cast<std::uint32_t>(on_->now() - on_->left_us); }

    scene* on_;
    servobus::sim::line_device* inner_;
    babbler* others_;
    timed_sender sender_;
    std::uint64_t off_until_ = 0;
    std::size_t heard_ = 0;
    std::size_t expected_ = 0;
    std::size_t spoiled_at_ = nowhere;
    strike last_loss_ = strike::lost_request;
    unsigned losses_ = 0;
    bool is_lost_ = false;
    bool loses_request_ = false;
    bool loses_response_ = false;
};

} // namespace trial
