// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A run of a fleet: a ZLAC8015D, a YAKO and a C630S on one line, each with its facade. The facades are
// stepped by a bus or one by one. A client and single exchanges use the same line; exchanges are stepped,
// given up or destroyed, in any order. The program stalls anywhere, the line is faulty, drives restart. The
// judge checks on the wire that no command sends a trigger twice.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fleet.hpp"
#include "mishaps.hpp"
#include "return_watch.hpp"
#include "wire_judge.hpp"

namespace trial {

namespace plans::three {
inline constexpr std::uint32_t baud = 115200;
inline constexpr auto wheels_node = with_times<servobus::zlac8015d::device>(1, 20, 15);
inline constexpr auto lift_node = with_times<servobus::yako::closed_loop::device>(2, 20, 15, 2500);
inline constexpr auto servo_node = with_times<servobus::c630s::device>(3, 46, 15);
inline constexpr auto test_node = with_times<test_device::device>(11, 20, 15);
inline constexpr servobus::poll_plan plan{
    servobus::modbus::timing_at(baud, servobus::modbus::timing_mode::host, servobus::milliseconds(15)),
    servobus::controlled(wheels_node, every(30)),
    servobus::controlled(lift_node, every(60)),
    servobus::controlled(servo_node, every(60)),
    servobus::cyclic<servobus::zlac8015d::bus_voltage>(wheels_node, servobus::milliseconds(100)),
    servobus::cyclic<servobus::yako::closed_loop::output_polarity>(lift_node, servobus::milliseconds(120)),
    servobus::cyclic<servobus::c630s::bus_voltage>(servo_node, servobus::milliseconds(240)),
    servobus::cyclic<test_device::live_pair, test_device::other_word>(test_node, servobus::milliseconds(150)),
    servobus::own_requests(lift_node, servobus::milliseconds(500), 1),
    servobus::own_requests(test_node, servobus::milliseconds(500), 1)};
} // namespace plans::three

/// The machine. Its facades are stepped by its bus or one by one.
class three_drives final : public fleet_of<plans::three::plan, wheels_drive, lift_drive, servo_drive> {
  public:
    explicit three_drives(facade_world& in)
        : wheels_{in.drive<wheels>(hang_on<wheels_participant, servobus::zlac8015d::device>(
              in, servobus::zlac8015d::catalogue, plans::three::wheels_node.address,
              in.state().manuals.draw<servobus::sim::zlac8015d_options>()))},
          lift_{in.drive<stepper>(hang_on<stepper_participant, servobus::yako::closed_loop::device>(
              in, servobus::yako::closed_loop::catalogue, plans::three::lift_node.address,
              in.state().manuals.draw<servobus::sim::yako_options>()))},
          servo_{in.drive<servo>(hang_on<servo_participant, servobus::c630s::device>(
              in, servobus::c630s::catalogue, plans::three::servo_node.address,
              in.state().manuals.draw<servobus::sim::c630s_options>()))} {
        hang_test_device_on(in, plans::three::test_node.address);
        put_together(in, wheels_.drive, lift_.drive, servo_.drive);
    }

  private:
    wheels& wheels_;
    stepper& lift_;
    servo& servo_;
};

class fleet_run {
  public:
    fleet_run(std::uint64_t seed, event_counts& count, std::size_t notes)
        : in_{seed, count, notes, drawn(seed)}, machine_{in_}, wire_{in_.state()}, mishaps_{in_} {
        has_bus_ = in_.state().one_in(2);
        in_.state().blur_us += 4 * longest_idle.us; // a party that is left out does not look
        in_.hostility = in_.state().one_in(3) ? 0 : in_.state().between(10, 100);
        in_.events = in_.state().between(0, 60);
        for (const auto& f : in_.facades()) returns_.emplace_back(in_.state(), *f);
        in_.on_frame = [this](servobus::bytes frame, facade* whose, bool) {
            if (whose != nullptr && !is_others_turn_) return_of(*whose).begins(frame);
        };
        in_.port().on_taken = [this](servobus::bytes what) { wire_.taken(what); };
        if (in_.state().one_in(4)) in_.port().takes_at_most = in_.state().between(1, 7);
        mishaps_.on_port_back = [this] {
            for (return_watch& r : returns_) r.lose("the port's return");
        };
    }

    world& place() { return in_; }

    void go() {
        scene& on = in_.state();
        for (const auto& f : in_.facades()) {
            if (!f->make_ready()) throw broken{"G9: a drive could not be set up on a line without faults"};
            wire_.commanded(f->place().address());
        }
        on.chance = in_.hostility;
        mishaps_.begin();
        in_.stall_always();
        constexpr int commands = 20;
        for (int i = 0; i < commands; ++i) {
            on.is_struck = true; // nothing has to succeed here
            mishaps_.draw();
            if (on.one_in(40)) restart(*in_.facades()[on.random.below(3)]);
            for (const auto& f : in_.facades()) control_code(*f);
            const std::uint64_t end = on.now() + on.random.below(400'000);
            do turn();
            while (on.now() < end);
        }
        end();
    }

  private:
    using errc = servobus::errc;
    static constexpr servobus::duration longest_idle = servobus::milliseconds(2);

    static conditions drawn(std::uint64_t seed) {
        servobus::sim::dice random = dice_of_conditions(seed);
        conditions c = draw_conditions(random);
        c.timing = plans::three::plan.timing();
        c.wire.baud = plans::three::baud;
        c.resolution_us = 1;
        return c;
    }

    void control_code(facade& f) {
        scene& on = in_.state();
        const bool is_stop = on.one_in(10);
        if (!is_stop && !f.is_idle()) return;
        const errc refusal = is_stop ? f.begin_stop(on) : on.one_in(3) ? f.begin_any(on) : f.begin_motion(on);
        if (refusal != errc::ok) return;
        on.log->remark(on.now(), "node " + std::to_string(f.place().address()) + ": " + f.wanted().name);
        ++on.count->operations;
        wire_.commanded(f.place().address());
        return_of(f).ordered();
        under_way_[index_of(f)] = true;
    }

    // One loop iteration: steps all parties in random order, and sometimes leaves one out.
    void turn() {
        scene& on = in_.state();
        servobus::duration idle = longest_idle;
        std::array<std::size_t, 6> order{0, 1, 2, 3, 4, 5};
        for (std::size_t i = order.size() - 1; i != 0; --i)
            std::swap(order[i], order[on.random.below(static_cast<std::uint32_t>(i + 1))]);
        for (const std::size_t party : order) {
            if (on.one_in(16)) continue;
            const servobus::duration own = step(party);
            idle = own < idle ? own : idle;
        }
        mishaps_.look();
        for (return_watch& r : returns_) r.look();
        for (const auto& f : in_.facades()) judge(*f);
        in_.port().wait(idle.us == 0 ? servobus::microseconds(1) : idle);
    }
    servobus::duration step(std::size_t party) {
        constexpr servobus::duration none = longest_idle;
        in_.port().begin_turn();
        if (party < 3) {
            if (has_bus_) return party == 0 ? machine_.step() : none;
            return in_.facades()[party]->step();
        }
        is_others_turn_ = true;
        const servobus::duration idle = party == 3 ? step_exchange() : none;
        if (party == 4 && in_.state().one_in(60)) (void)in_.line().is_free();
        if (party == 5 && in_.state().one_in(400)) ask();
        is_others_turn_ = false;
        return idle;
    }

    // An exchange of the application: a read that is stepped to its end, given up or destroyed.
    servobus::duration step_exchange() {
        scene& on = in_.state();
        if (!exchange_) {
            if (!on.one_in(60)) return servobus::milliseconds(2);
            participant& at = other_participant();
            const auto request =
                servobus::modbus::read_frame(at.address(), at.is_test_device() ? 0x0010 : 0x0006, 1);
            for (std::size_t i = 0; i < request.size; ++i) request_[i] = request.data[i];
            gaps_ = at.gaps();
            limits_ = at.limits();
            exchange_.emplace(servobus::bytes{request_}, response_, in_.line().timing(), limits_);
        }
        const servobus::duration idle = in_.line().step(*exchange_, gaps_);
        if (on.one_in(120) && !exchange_->done()) in_.line().abandon(*exchange_);
        if (exchange_->done() || on.one_in(150)) exchange_.reset(); // done, or destroyed before its end
        return idle;
    }
    // A blocking client.
    void ask() {
        participant& at = other_participant();
        std::array<std::uint16_t, 1> word{};
        (void)at.read(at.is_test_device() ? 0x0010 : 0x0006, word,
                      servobus::modbus::function::read_holding_registers);
    }
    // Never a drive with a watchdog: only its facade sends requests to it, since any other read may let it
    // go on.
    participant& other_participant() {
        for (;;) {
            participant& s = in_.any_participant();
            if (s.kind() == drive_kind::none || s.kind() == drive_kind::yako) return s;
        }
    }

    void judge(facade& f) {
        if (!under_way_[index_of(f)] || !f.is_idle()) return;
        under_way_[index_of(f)] = false;
        const servobus::command_status& r = f.last();
        const std::string& name = f.wanted().name;
        const unsigned triggers = wire_.triggers(f.place().address());
        in_.state().log->remark(in_.state().now(), "   node " + std::to_string(f.place().address()) +
                                                       " ended: " + std::string{servobus::text(r.error())});
        if (r) ++in_.state().count->succeeded;
        if (r.outcome() == servobus::outcome::not_sent && triggers != 0)
            throw broken{"G33: " + name + " is reported not sent, but a trigger was on the wire"};
        const bool is_start = name == "move" || name == "start segment";
        if (r && is_start && triggers == 0)
            throw broken{"G16: " + name + " is reported done, but no trigger was on the wire"};
    }

    void restart(facade& f) {
        scene& on = in_.state();
        const std::uint64_t when = on.now() + on.random.below(100'000);
        const std::uint32_t off = 1000u * on.between(1, 300);
        in_.port().plan(when, [this, &f, off] {
            in_.state().strikes(strike::reboot);
            f.place().reboot(in_.state().now() + off);
            return_of(f).restarted();
        });
    }

    // Ends all faults and stops all drives until each stop has ended.
    void end() {
        scene& on = in_.state();
        on.log->remark(on.now(), "all faults end");
        on.chance = 0;
        mishaps_.heal();
        exchange_.reset();
        const std::uint64_t begun = on.now();
        for (const auto& f : in_.facades()) {
            while (f->begin_end() != errc::ok && on.now() - begun < 70'000'000) turn();
            wire_.commanded(f->place().address());
            return_of(*f).ordered();
            while (!f->is_idle() && on.now() - begun < 140'000'000) turn();
            if (!f->is_idle()) throw broken{"G29: after all faults have ended a stop does not end"};
        }
        on.count->wire_frames += wire_.frames();
    }

    std::size_t index_of(const facade& f) const {
        std::size_t i = 0;
        while (in_.facades()[i].get() != &f) ++i;
        return i;
    }
    return_watch& return_of(const facade& f) { return returns_[index_of(f)]; }

    mutable facade_world in_;
    three_drives machine_;
    wire_judge wire_;
    mishaps mishaps_;
    std::vector<return_watch> returns_; ///< of the facades, in their order
    std::array<bool, 3> under_way_{};   ///< of each facade: a command of the application is in progress
    std::optional<servobus::modbus::exchange> exchange_;
    std::array<std::uint8_t, 8> request_{};
    std::array<std::uint8_t, 16> response_{};
    servobus::bus_gaps gaps_{};
    servobus::response_limits limits_{};
    bool has_bus_ = false;
    bool is_others_turn_ = false;
};

} // namespace trial
