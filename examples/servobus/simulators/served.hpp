// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A simulated drive on a pseudo-terminal in real time: bytes, pace, faults and signals. What the drive does
// is the model's matter.
#pragma once

#include <servobus/modbus/server.hpp>

#include "../streams/messages.hpp"
#include "simulators.hpp"

#ifdef _WIN32

namespace tool {

/// Windows has no pseudo-terminals.
template <class Model, class Server = servobus::modbus::server<Model>> class served {
  public:
    served(Model&, const simulation&) {}
    int run(const char*) {
        return complain(failed, "a simulated drive needs a pseudo-terminal, which Windows does not have");
    }
};

} // namespace tool

#else

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstring>

#include <servobus/posix/pseudo_terminal.hpp>
#include <servobus/sim/faults.hpp>

#include "../streams/streams.hpp"

namespace tool {

/// What signals ask of a running simulation.
struct signals {
    static inline volatile std::sig_atomic_t stop = 0;
    static inline volatile std::sig_atomic_t toggle = 0;
    static inline volatile std::sig_atomic_t cycle = 0;

    static void arm() {
        struct sigaction act {};
        act.sa_handler = [](int) { stop = 1; };
        (void)::sigaction(SIGINT, &act, nullptr);
        (void)::sigaction(SIGTERM, &act, nullptr);
        act.sa_handler = [](int) { toggle = 1; };
        (void)::sigaction(SIGUSR1, &act, nullptr);
        act.sa_handler = [](int) { cycle = 1; };
        (void)::sigaction(SIGUSR2, &act, nullptr);
    }
};

/// A frame on its way out, all of it at the time when its last bit would have passed.
struct departure {
    std::array<std::uint8_t, 2 * servobus::sim::max_spoiled> data{};
    std::size_t size = 0;
    servobus::instant due{};

    /// Says it all once more. In one piece: between two, a busy machine can put a pause of any length, and
    /// what comes after t3.5 may be taken for the response to the next request by any client.
    void repeat(servobus::duration pause) {
        std::copy_n(data.begin(), size, data.begin() + size);
        size += size;
        due = due + pause;
    }
};

/// A model, such as a register store, that also lives in time. `Server` executes requests on it.
template <class Model, class Server = servobus::modbus::server<Model>> class served {
  public:
    served(Model& model, const simulation& wanted)
        : model_{&model}, server_{model.address(), model, servobus::modbus::timing_at(model.baud())},
          faults_{wanted.seed, wanted.faults}, echoes_{wanted.echoes}, is_strict_{wanted.has_strict_rate} {}

    /// Returns the exit status.
    int run(const char* link) {
        signals::arm();
        if (port_.open(link) != servobus::errc::ok) {
            return complain(failed, std::string{"cannot make a pseudo-terminal"} +
                                        (link != nullptr ? std::string{" at "} + link : "") + ": " +
                                        std::strerror(port_.os_error()));
        }
        std::printf("%s\n", port_.path());
        if (!streams::flush()) return failed;
        while (signals::stop == 0) {
            if (signals::toggle != 0) toggle();
            if (signals::cycle != 0) cycle();
            port_.wait(turn());
        }
        return done;
    }

  private:
    static constexpr servobus::duration idle = servobus::milliseconds(20);
    static constexpr servobus::duration thinking = servobus::microseconds(500);

    void toggle() {
        signals::toggle = 0;
        bool& is_unplugged = faults_.plan().is_unplugged;
        is_unplugged = !is_unplugged;
        note(is_unplugged ? "unplugged" : "plugged in");
    }

    void cycle() {
        signals::cycle = 0;
        if constexpr (requires { model_->power_cycle(); }) {
            model_->power_cycle();
            follow();
            note("switched off and on");
        }
    }

    // A write may have changed the drive's own address.
    void follow() { server_.set_address(model_->address()); }

    // At another rate what comes is no frame to a real drive, which says nothing.
    bool is_at_own_rate() const {
        const std::uint32_t theirs = is_strict_ ? port_.baud() : 0;
        return theirs == 0 || theirs == model_->baud();
    }

    /// Does what is due. Returns for how long nothing will be.
    servobus::duration turn() {
        const servobus::instant now = port_.now();
        model_->advance(now);
        if (!receive(now)) return idle;
        return speak(now);
    }

    bool receive(servobus::instant now) {
        std::array<std::uint8_t, 512> chunk{};
        const servobus::transfer came = port_.receive(chunk);
        if (!came) return false;
        if (*came == 0) {
            server_.elapse(now);
            return true;
        }
        if (!is_at_own_rate()) return true;
        if (echoes_) (void)port_.send(servobus::bytes{chunk}.first(*came));
        // A frame's fate is decided as it begins: what comes within a few milliseconds belongs to it.
        if (request_size_ == 0 || since(heard_, now) > servobus::milliseconds(5)) {
            request_ = faults_.decide_request();
            request_size_ = 0;
        }
        heard_ = now;
        request_size_ += *came;
        if (request_.is_lost || faults_.plan().is_unplugged) return true;
        if (request_.is_corrupted) chunk[request_.seed % *came] ^= 0x55u;
        request_.is_corrupted = false;
        server_.feed_late(servobus::bytes{chunk}.first(*came), port_.now());
        return true;
    }

    servobus::duration speak(servobus::instant now) {
        if (pending_.size == 0) prepare(now);
        if (pending_.size != 0) {
            if (went_back(pending_.due, now)) return std::min(since(now, pending_.due), idle);
            leave(now);
        }
        return is_answering() ? servobus::microseconds(200) : idle;
    }

    // Takes the server's response, which it has t3.5 after the request.
    void prepare(servobus::instant now) {
        const servobus::bytes frame = server_.response(now);
        if (frame.empty()) return;
        const servobus::sim::fate fate = faults_.decide();
        pending_.size = spoil(fate, frame, pending_.data);
        const servobus::duration silence{server_.timing().t3_5};
        pending_.due = heard_ + wire_time(request_size_) + longer_of(silence, thinking_time()) + fate.delay +
                       wire_time(pending_.size);
        if (fate.is_doubled) pending_.repeat(faults_.plan().doubled_after + wire_time(pending_.size));
        if (pending_.size == 0) end(now);
    }

    void leave(servobus::instant now) {
        // Nobody reads a full line: the rest is lost, as on a wire.
        if (!faults_.plan().is_unplugged)
            (void)port_.send(servobus::bytes{pending_.data}.first(pending_.size));
        pending_.size = 0;
        end(now);
    }

    void end(servobus::instant now) {
        server_.sent(now);
        follow();
        request_size_ = 0;
    }

    servobus::duration thinking_time() const {
        if constexpr (requires { model_->response_delay(); }) {
            return longer_of(thinking, model_->response_delay());
        } else {
            return thinking;
        }
    }

    bool is_answering() const {
        return request_size_ != 0 && since(heard_, port_.now()) < servobus::milliseconds(10);
    }

    // Ten bits a character: 8N1.
    servobus::duration wire_time(std::size_t characters) const {
        const std::uint32_t baud = model_->baud();
        return servobus::duration{
            static_cast<std::uint32_t>((std::uint64_t{characters} * 10'000'000u + baud - 1) / baud)};
    }

    servobus::posix::pseudo_terminal port_;
    Model* model_;
    Server server_;
    servobus::sim::fault_source faults_;
    servobus::sim::fate request_{};
    departure pending_{};
    servobus::instant heard_{};
    std::size_t request_size_ = 0;
    bool echoes_;
    bool is_strict_;
};

} // namespace tool

#endif
