// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a client claims of an operation, held against what the devices really executed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <servobus/core/result.hpp>

#include "seat.hpp"
#include "world.hpp"

namespace trial {

/// What an operation is meant to do.
struct intent {
    enum class kind : std::uint8_t { read, write, write_if_different, broadcast, unknown_function };

    kind what = kind::read;
    seat* at = nullptr; ///< null: nobody has this address
    std::uint16_t address = 0;
    std::size_t count = 0;            ///< registers
    std::vector<std::uint16_t> words; ///< to be written
    unsigned tries = 1;               ///< a read may be made
    std::size_t request_size = 8;
    std::size_t response_size = 8;

    bool is_write() const { return what != kind::read && what != kind::unknown_function; }
};

/// What the client says has come of it.
struct claim {
    servobus::failure why{};
    servobus::outcome said = servobus::outcome::done; ///< of a write
    std::vector<std::uint16_t> words;                 ///< of a read

    claim() = default;
    explicit claim(servobus::failure f) : why{f} {}
    explicit claim(servobus::written w) : why{w.why()}, said{w.outcome()} {}

    bool succeeded() const { return why.code == servobus::errc::ok; }
    bool is_refused() const { return why.code == servobus::errc::exception; }
};

class verdict {
  public:
    verdict(world& of, const intent& meant, const claim& said) : in_{of}, meant_{meant}, said_{said} {}

    void give() {
        look_at_executions();
        if (meant_.is_write()) {
            judge_write();
        } else {
            judge_read();
        }
        if (said_.is_refused()) judge_exception();
        judge_requests();
        if (said_.succeeded()) ++on().count->succeeded;
        // Before the first answer; or a response and a stray byte that together are the request again.
        const bool may_be_echo = said_.why.code == servobus::errc::own_echo &&
                                 (!in_.court().is_echo_ruled_out() || !meant_.is_write() ||
                                  meant_.what == kind::write_if_different || begins_like_its_response());
        if (on().is_struck || meant_.at == nullptr || may_be_echo) return;
        ++on().count->had_to_succeed;
        if (!said_.succeeded() && !said_.is_refused())
            throw broken{std::string{on().borne} +
                         ": nothing was wrong on the line that a client need not "
                         "bear, and yet: " +
                         servobus::text(said_.why.code)};
    }

  private:
    using kind = intent::kind;

    scene& on() { return in_.state(); }

    // Nothing is executed but what was asked for, where it was asked for.
    void look_at_executions() {
        for (const auto& s : in_.seats()) {
            const bool is_asked = meant_.what == kind::broadcast || s.get() == meant_.at;
            for (const execution& e : s->executed()) {
                const bool is_meant = e.address == meant_.address && e.words.size() == meant_.count &&
                                      (e.is_write ? meant_.is_write() && e.words == meant_.words : true);
                const bool is_intruders = on().has_intruded && !e.is_write && e.address == 0;
                if (is_intruders || (is_asked && is_meant)) continue;
                in_.court().by_chance_or("G13: unit " + std::to_string(s->device_unit()) +
                                         " executed what it was not asked for");
            }
            if (is_asked && meant_.is_write()) count_writes(s->executed());
        }
    }
    void count_writes(const std::vector<execution>& of) {
        std::size_t here = 0;
        for (const execution& e : of) {
            if (e.is_write && e.refusal == 0) ++here;
        }
        if (here > 1) throw broken{"G15: a write was executed " + std::to_string(here) + " times"};
        executed_ += here;
    }

    void judge_read() {
        if (!said_.succeeded()) return;
        if (meant_.at == nullptr) throw broken{"G2: a read succeeded where no device is"};
        if (meant_.what == kind::unknown_function)
            return in_.court().by_chance_or("G2: a function succeeded that the device does not have");
        const execution* same = nullptr;
        for (const execution& e : meant_.at->executed()) {
            const bool is_this = on().does_clock_lie || e.transaction == on().transaction;
            if (!e.is_write && e.refusal == 0 && e.words == said_.words && is_this) same = &e;
        }
        if (same == nullptr)
            in_.court().by_chance_or("G2: a read gave values that the registers did not have when they were "
                                     "read");
    }

    void judge_write() {
        using servobus::outcome;
        judge& court = in_.court();
        const bool is_broadcast = meant_.what == kind::broadcast;
        if (said_.said == outcome::not_sent && court.writes() != 0)
            throw broken{"G16: a write that was sent is said not to have been"};
        if (said_.said == outcome::unknown && court.writes() == 0)
            throw broken{"G16: a write that was not sent is said to be unknown"};
        if (said_.said == outcome::refused && executed_ != 0)
            court.by_chance_or("G16: a write that was executed is said to be refused");
        if (is_broadcast && said_.said == outcome::done && !on().is_struck && !on().is_any_away) {
            for (const auto& s : in_.seats()) {
                if (s->is_gauge() && s->executed().size() != 1)
                    throw broken{"G30: a broadcast is said to be done, and a device did not execute it"};
            }
        }
        if (is_broadcast) return;
        if (meant_.at == nullptr) {
            if (said_.said == outcome::done)
                throw broken{"G3: a write is said to be done where no device is"};
            return;
        }
        if (meant_.what == kind::write_if_different) return judge_difference();
        if (said_.said != outcome::done) return;
        if (executed_ != 1) court.by_chance_or("G16: a write is said to be done that was not executed");
    }

    void judge_difference() {
        const execution* seen = nullptr;
        for (const execution& e : meant_.at->executed()) {
            if (!e.is_write && e.refusal == 0) seen = &e; // the last one: a reboot may lie between two
        }
        judge& court = in_.court();
        if (said_.said == servobus::outcome::done && seen == nullptr)
            return court.by_chance_or("G17: nothing was read and yet it is said to be as wanted");
        const bool is_equal = seen != nullptr && seen->words == meant_.words;
        if (is_equal && court.writes() != 0)
            court.by_chance_or("G17: a value was written that was there already");
        if (!is_equal && said_.said == servobus::outcome::done && executed_ != 1)
            court.by_chance_or("G17: another value was there, and a write is said to be done that was not");
    }

    // A function 10h whose response, CRC and all, is the request's beginning: a stray byte after it makes it
    // the echo.
    bool begins_like_its_response() const {
        if (meant_.at == nullptr || !meant_.is_write() || meant_.words.empty()) return false;
        const auto high = [](std::size_t word) { return static_cast<std::uint8_t>(word >> 8 & 0xFFu); };
        const auto low = [](std::size_t word) { return static_cast<std::uint8_t>(word & 0xFFu); };
        const std::uint8_t head[] = {meant_.at->unit(),    0x10,
                                     high(meant_.address), low(meant_.address),
                                     high(meant_.count),   low(meant_.count)};
        const std::uint16_t crc = plain_crc(head);
        return low(crc) == low(2 * meant_.count) && high(crc) == high(meant_.words[0]);
    }

    void judge_exception() {
        if (meant_.at == nullptr) throw broken{"G12: an exception where no device is"};
        const std::uint8_t number = said_.why.exception;
        bool is_known =
            meant_.what == kind::unknown_function && number == meant_.at->rules().illegal_function;
        for (const execution& e : meant_.at->executed())
            is_known = is_known || (e.refusal != 0 && e.refusal == number);
        // An exception says nothing of the request that it refuses.
        is_known = is_known || (on().cuts_quarantine && meant_.at->has_refused(number));
        // Some drives say so when a request came damaged.
        is_known = is_known || (on().is_struck && number != 0 && number == meant_.at->rules().bad_crc);
        if (!is_known)
            in_.court().by_chance_or("G12: exception " + std::to_string(number) +
                                     " is not what the device answered");
    }

    void judge_requests() {
        const judge& court = in_.court();
        if (court.writes() > (meant_.is_write() ? 1u : 0u))
            throw broken{"G15: a write was sent " + std::to_string(court.writes()) + " times"};
        if (court.reads() > meant_.tries + (in_.state().has_intruded ? 1u : 0u))
            throw broken{"G15: a request was repeated more often than was allowed"};
    }

    world& in_;
    const intent& meant_;
    const claim& said_;
    std::size_t executed_ = 0;
};

} // namespace trial
