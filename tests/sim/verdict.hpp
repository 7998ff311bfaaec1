// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Compares what a client reports of an operation with what the devices executed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <servobus/core/result.hpp>

#include "participant.hpp"
#include "world.hpp"

namespace trial {

/// What an operation is meant to do.
struct intent {
    enum class kind : std::uint8_t { read, write, write_if_different, broadcast, unknown_function };

    kind what = kind::read;
    participant* at = nullptr; ///< null: no device has this address
    std::uint16_t address = 0;
    std::size_t count = 0;            ///< registers
    std::vector<std::uint16_t> words; ///< to be written
    unsigned tries = 1;               ///< how often a read may be sent
    std::size_t request_size = 8;
    std::size_t response_size = 8;

    bool is_write() const { return what != kind::read && what != kind::unknown_function; }
};

/// What the client reports of an operation.
struct claim {
    servobus::status why{};
    servobus::outcome said = servobus::outcome::done; ///< of a write
    std::vector<std::uint16_t> words;                 ///< of a read

    claim() = default;
    explicit claim(servobus::status w) : why{w}, said{w.outcome()} {}

    bool succeeded() const { return why.error() == servobus::errc::ok; }
    bool is_refused() const { return !succeeded() && why.has_response(); }
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
        // Before the first response that is no echo, or where the response and an unexpected byte together
        // repeat the request.
        const bool may_be_echo =
            said_.why.error() == servobus::errc::own_echo &&
            (!in_.court().is_echo_ruled_out(on().asked_node) || in_.court().could_be_echo(on().asked_node) ||
             !meant_.is_write() || meant_.what == kind::write_if_different || begins_like_its_response());
        if (on().is_struck || meant_.at == nullptr || may_be_echo) return;
        ++on().count->had_to_succeed;
        if (!said_.succeeded() && !said_.is_refused())
            throw broken{std::string{on().borne} +
                         ": the line had no fault that excuses a failure, "
                         "but the result is: " +
                         servobus::text(said_.why.error())};
    }

  private:
    using kind = intent::kind;

    scene& on() { return in_.state(); }

    // The addressed device executes exactly the request, and the other devices execute nothing.
    void look_at_executions() {
        for (const auto& s : in_.participants()) {
            const bool is_asked = meant_.what == kind::broadcast || s.get() == meant_.at;
            for (const execution& e : s->executed()) {
                const bool is_meant = e.address == meant_.address && e.words.size() == meant_.count &&
                                      (e.is_write ? meant_.is_write() && e.words == meant_.words : true);
                const bool is_intruders = on().has_intruded && !e.is_write && e.address == 0;
                if (is_intruders || (is_asked && is_meant)) continue;
                in_.court().by_chance_or("G13: node " + std::to_string(s->device_address()) +
                                         " executed a request that was not sent to it");
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
        const bool is_unknown = meant_.what == kind::unknown_function;
        if (is_unknown && in_.court().was_returned() && !in_.court().could_be_echo(on().asked_node)) return;
        if (meant_.at == nullptr) throw broken{"G2: a read succeeded at an address without a device"};
        if (is_unknown)
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
            throw broken{"G16: a write is reported not sent although it was sent"};
        if (said_.said == outcome::unknown && court.writes() == 0)
            throw broken{"G16: a write is reported unknown although it was not sent"};
        if (said_.said == outcome::refused && executed_ != 0)
            court.by_chance_or("G16: a write is reported refused although it was executed");
        if (is_broadcast && said_.said == outcome::done && !on().is_struck && !on().is_any_away) {
            for (const auto& s : in_.participants()) {
                if (s->is_test_device() && s->executed().size() != 1)
                    throw broken{"G30: a broadcast is reported done, but a device did not execute it"};
            }
        }
        if (is_broadcast) return;
        if (court.was_returned()) {
            // The nodes may be back before the read that is to rule out an echo.
            const bool is_detectable = court.could_be_echo(on().asked_node) && !court.has_differed();
            (is_detectable ? on().count->detected_returns : on().count->undetected_returns) += 1;
            const bool is_taken_for_done = said_.said == outcome::done && executed_ == 0;
            if (is_taken_for_done && is_detectable)
                throw broken{"G3: a write is reported done that the adapter has returned"};
            if (is_taken_for_done) return; // nothing has shown that it may be an echo
        }
        if (meant_.at == nullptr) {
            if (said_.said == outcome::done)
                throw broken{"G3: a write is reported done at an address without a device"};
            return;
        }
        if (meant_.what == kind::write_if_different) return judge_difference();
        if (said_.said != outcome::done) return;
        if (executed_ != 1) court.by_chance_or("G16: a write is reported done although it was not executed");
    }

    void judge_difference() {
        const execution* seen = nullptr;
        for (const execution& e : meant_.at->executed()) {
            if (e.is_write) break;         // a read after it rules out an echo
            if (e.refusal == 0) seen = &e; // the last one, since a restart may come between two
        }
        judge& court = in_.court();
        if (said_.said == servobus::outcome::done && seen == nullptr)
            return court.by_chance_or("G17: the value is reported as wanted although nothing was read");
        const bool is_equal = seen != nullptr && seen->words == meant_.words;
        if (is_equal && court.writes() != 0)
            court.by_chance_or("G17: a value was written that the register already had");
        if (!is_equal && said_.said == servobus::outcome::done && executed_ != 1)
            court.by_chance_or("G17: the register had another value, and the write is reported done although "
                               "it was not executed");
    }

    // A function 10h whose response, including its CRC, equals the beginning of the request. With an
    // unexpected byte after it, it looks like the echo.
    bool begins_like_its_response() const {
        if (meant_.at == nullptr || !meant_.is_write() || meant_.words.empty()) return false;
        const auto high = [](std::size_t word) { return static_cast<std::uint8_t>(word >> 8 & 0xFFu); };
        const auto low = [](std::size_t word) { return static_cast<std::uint8_t>(word & 0xFFu); };
        const std::uint8_t head[] = {meant_.at->address(), 0x10,
                                     high(meant_.address), low(meant_.address),
                                     high(meant_.count),   low(meant_.count)};
        const std::uint16_t crc = plain_crc(head);
        return low(crc) == low(2 * meant_.count) && high(crc) == high(meant_.words[0]);
    }

    void judge_exception() {
        if (meant_.at == nullptr) throw broken{"G12: an exception from an address without a device"};
        const std::uint8_t number = said_.why.exception();
        bool is_known =
            meant_.what == kind::unknown_function && number == meant_.at->rules().illegal_function;
        for (const execution& e : meant_.at->executed())
            is_known = is_known || (e.refusal != 0 && e.refusal == number);
        // An exception does not identify its request, so it may belong to the earlier one.
        is_known = is_known || (on().cuts_quarantine && meant_.at->has_refused(number));
        // Some drives respond to a damaged request with an exception of its own.
        is_known = is_known || (on().is_struck && number != 0 && number == meant_.at->rules().bad_crc);
        if (!is_known)
            in_.court().by_chance_or("G12: exception " + std::to_string(number) +
                                     " is not what the device responded");
    }

    void judge_requests() {
        const judge& court = in_.court();
        if (court.writes() > (meant_.is_write() ? 1u : 0u))
            throw broken{"G15: a write was sent " + std::to_string(court.writes()) + " times"};
        // A write asks once more where the read before it had a response that its echo can be.
        const unsigned rounds = meant_.is_write() && court.had_echo_like_read() ? 2 : 1;
        if (court.reads() > rounds * meant_.tries + (in_.state().has_intruded ? 1u : 0u))
            throw broken{"G15: a request was repeated more often than allowed"};
    }

    world& in_;
    const intent& meant_;
    const claim& said_;
    std::size_t executed_ = 0;
};

} // namespace trial
