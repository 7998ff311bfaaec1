// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// One call of a client as a machine without I/O: which request is next, and how the call ended. A read is
// repeated as often as the node says, a write never. A response to function 06 repeats its request, so it may be
// an echo until a line has received anything else, and again after a request without a valid response. A read after the
// write then rules that out. Before a setting of
// the line the read goes first: the response to such a write may be the last one. Blocking and stepped calls are
// loops over this machine: they build the frames and carry them.
//
//     const node<zlac8015d::device> of{1};
//     request_machine call = request_machine::write();
//     status why = status::sent(errc::ok); // the write's; then each time that of the request of `call.now()`
//     while (call.goes_on(why, of, true, false)) {}
//     if (why.error() != errc::own_echo) return 1;
#pragma once

#include <cstdint>

#include <servobus/core/status.hpp>

namespace servobus {

/// The progress of one call: the request under way, and the attempts that failed.
class request_machine {
  public:
    /// The purpose of the request under way.
    enum class stage : std::uint8_t {
        ended,
        reading,
        transacting, ///< any function: it may write
        writing,
        looking,      ///< for a device at an address (scan.hpp)
        asking_first, ///< reads the register before a setting of the line is written to it
        checking,     ///< reads the register after a write whose response may be its echo
    };

    constexpr request_machine() = default; ///< no call
    static constexpr request_machine read() { return request_machine{stage::reading}; }
    static constexpr request_machine transaction() { return request_machine{stage::transacting}; }
    /// `asks_first`: an echo must be ruled out before the write leaves, not after it.
    static constexpr request_machine write(bool asks_first = false) {
        return request_machine{asks_first ? stage::asking_first : stage::writing};
    }
    /// A write that goes on after its response.
    static constexpr request_machine check() { return request_machine{stage::checking}; }
    static constexpr request_machine look() { return request_machine{stage::looking}; }

    constexpr stage now() const { return stage_; }
    constexpr bool done() const { return stage_ == stage::ended; }
    /// True if the request is a read of one register whose value does not matter.
    constexpr bool is_asking() const { return stage_ >= stage::asking_first; }

    /// The request has ended with `why`. True: the request of `now()` is next. False: the call has ended with `why`.
    /// `repeats`: a response repeats its request, as that to function 06 does. It may be an echo unless an echo
    /// `is_ruled_out` (`line::is_echo_ruled_out`).
    template <class Node>
    [[gnu::always_inline]] constexpr bool goes_on(status& why, const Node& of, bool repeats,
                                                  bool is_ruled_out) {
        if (stage_ == stage::reading) {
            if (is_worth_a_retry(why, of) && attempts_++ < of.read_retries) return true;
        } else if (stage_ == stage::transacting) {
            if (repeats && !is_ruled_out && why) why = status::sent(errc::own_echo);
        } else if (stage_ == stage::writing) {
            if (repeats && !is_ruled_out && why) {
                stage_ = stage::checking;
                attempts_ = 0;
                return true;
            }
        } else if (stage_ != stage::ended) {
            if (is_ruled_out) {
                if (stage_ == stage::asking_first) {
                    stage_ = stage::writing;
                    return true;
                }
                why = status::sent(errc::ok);
            } else {
                if (attempts_++ < of.read_retries) return true;
                why = stage_ == stage::asking_first ? status{errc::own_echo} : status::sent(errc::own_echo);
            }
        }
        stage_ = stage::ended;
        return false;
    }

    /// A look has ended with `why`; `has_received`: anything came. True if the look is to be repeated, which is done
    /// once: the bytes may be a damaged response. A response, a timeout without a byte and a failed port end it.
    constexpr bool looks_again(const status& why, bool has_received) {
        const bool repeats = is_garbled(why, has_received) && attempts_++ == 0;
        if (!repeats) stage_ = stage::ended;
        return repeats;
    }
    /// True if what came is no response. To a UART two devices, or another baud rate, look like a garbled character.
    static constexpr bool is_garbled(const status& why, bool has_received) {
        if (why.error() == errc::receive_failed) return true;
        // A timeout too: bytes of another node, or that were ignored until a gap, may have come.
        if (why.error() == errc::timeout) return has_received;
        return why.error() >= errc::no_echo && why.error() != errc::gateway_exception && !why.has_response();
    }

    /// The call is given up; `came` is how its request ended. Returns how the call ended.
    constexpr status given_up(status came) {
        const stage was = stage_;
        stage_ = stage::ended;
        if (was == stage::checking) return status::sent(errc::own_echo);
        if (was == stage::asking_first) return errc::busy; // nothing of the write was sent
        return came;
    }

    /// True if the request or its response was lost or damaged on its way.
    template <class Node> static constexpr bool is_worth_a_retry(const status& why, const Node& of) {
        if (why.error() == errc::exception)
            return why.exception() != 0 && why.exception() == of.limits.corrupted_request;
        return why.error() >= errc::timeout && why.error() < errc::exception;
    }

  private:
    [[gnu::always_inline]] constexpr explicit request_machine(stage first) : stage_{first} {}

    stage stage_ = stage::ended;
    std::uint8_t attempts_ = 0; // failed ones of this stage
};

} // namespace servobus
