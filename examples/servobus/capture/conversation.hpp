// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Pairs the frames of others' traffic: which is a request, which the response to it, which request got none. A
// write of one register equals its response, so what came before decides: the same bytes within the response
// timeout are the response. Where that is not known (as listening begins, and after damaged bytes) such a frame
// has no direction.
#pragma once

#include <algorithm>
#include <array>
#include <optional>

#include <servobus/explain/explain.hpp>

#include "../frames/frame_sizes.hpp"
#include "frame_cutter.hpp"

namespace tool {

/// What a frame is among the others.
struct heard {
    servobus::direction way = servobus::direction::unknown;
    std::optional<moment> after{};            ///< a response: the time since its request
    bool is_unpaired = false;                 ///< a response without a request before it
    std::optional<std::uint8_t> unanswered{}; ///< a request: the one before it, to this node, got no response
};

/// The counters of a node. Each request is in one of `responses`, `exceptions`, `no_response` and `damaged`,
/// except one that still waits for its response and those to all nodes.
struct node_counters {
    std::uint64_t requests = 0;
    std::uint64_t responses = 0; ///< without the exceptions
    std::uint64_t exceptions = 0;
    std::uint64_t no_response = 0;
    std::uint64_t damaged = 0;  ///< requests after which only damaged bytes came
    std::uint64_t unpaired = 0; ///< responses without a request, and frames of unknown direction
    moment slowest = 0;         ///< of the responses

    bool is_empty() const { return requests + unpaired == 0; }
};

class conversation {
  public:
    /// `timeout`: how long a response may take to begin.
    explicit conversation(moment timeout) : timeout_{timeout} {}

    /// The node that has not responded within the timeout by `now`; said once for each request.
    std::optional<std::uint8_t> overdue(moment now) {
        if (state_ != state::open || now <= asked_ + timeout_) return std::nullopt;
        state_ = state::overdue;
        ++of_request().no_response;
        return request_[0];
    }

    /// The next piece. Ask `overdue` for the time of its begin first. Of a piece that is no frame nothing is
    /// returned.
    heard take(const piece& next) {
        heard h;
        if (!next.is_frame()) {
            take_damaged(next.data.size());
            return h;
        }
        h.way = direction_of(next);
        if (h.way == servobus::direction::request) {
            take_request(next, h);
        } else if (h.way == servobus::direction::response) {
            take_response(next, h);
        } else {
            ++of(next).unpaired;
            keep(next, state::tentative);
        }
        is_in_doubt_ = h.way == servobus::direction::unknown;
        return h;
    }

    /// The request to which a response may still come; empty if there is none.
    std::vector<std::uint8_t> expected() const {
        return may_be_answered() ? request_ : std::vector<std::uint8_t>{};
    }

    const std::array<node_counters, 256>& counters() const { return counters_; }

  private:
    /// The state of the last request.
    enum class state : std::uint8_t {
        none,      ///< there is none, or it needs no response, or has one
        tentative, ///< it may be a response instead
        open,      ///< waits for its response
        overdue,   ///< reported as without a response
        damaged,   ///< damaged bytes came in place of its response
    };

    static constexpr std::size_t longest_glitch = 3; ///< bytes that a switching driver puts before a frame

    bool may_be_answered() const { return state_ != state::none; }
    node_counters& of(const piece& p) { return counters_[p.data[0]]; }
    node_counters& of_request() { return counters_[request_[0]]; }

    void keep(const piece& request, state now) {
        request_ = request.data;
        asked_ = request.end;
        state_ = now;
    }

    servobus::direction direction_of(const piece& frame) const {
        using enum servobus::direction;
        const std::uint8_t code = frame.data[1];
        if ((code & servobus::modbus::exception_flag) != 0) return response;
        if (frame.data[0] == servobus::modbus::broadcast) return request;
        const servobus::bytes pdu = pdu_of(frame.data, frame.data.size());
        const bool may_be_request = servobus::is_request(pdu);
        const bool may_be_response = servobus::is_response(pdu);
        if (may_be_request != may_be_response) return may_be_request ? request : response;
        if (may_be_request) {
            const bool is_waited_for = state_ == state::open || state_ == state::tentative;
            const bool is_in_time = is_waited_for && frame.begin <= asked_ + timeout_;
            if (is_in_time && frame.data[0] == request_[0] && answers_request(pdu)) return response;
            return is_in_doubt_ && !is_waited_for ? unknown : request;
        }
        // Neither: what is wrong with it is said by `explain`.
        const bool is_known = servobus::is_of_known_function(pdu);
        if (is_known && frame.data.size() == request_size(frame.data)) return request;
        if (may_be_answered() && frame.data[0] == request_[0] && code == request_[1]) return response;
        return is_in_doubt_ ? unknown : request;
    }
    bool answers_request(servobus::bytes pdu) const {
        const servobus::bytes asked = pdu_of(request_, request_.size());
        return servobus::check_seen_response(asked, pdu) == servobus::errc::ok;
    }

    void take_damaged(std::size_t size) {
        if (size <= longest_glitch) return;
        if (state_ == state::open) {
            state_ = state::damaged;
            ++of_request().damaged;
            return;
        }
        if (state_ == state::tentative) state_ = state::none;
        is_in_doubt_ = true;
    }

    void take_request(const piece& frame, heard& h) {
        if (state_ == state::open) {
            ++of_request().no_response;
            h.unanswered = request_[0];
        }
        ++of(frame).requests;
        keep(frame, frame.data[0] == servobus::modbus::broadcast ? state::none : state::open);
    }

    void take_response(const piece& frame, heard& h) {
        node_counters& node = of(frame);
        h.is_unpaired = !may_be_answered() || !is_response_to_request(frame.data);
        if (h.is_unpaired) {
            ++node.unpaired;
            return;
        }
        // What was counted for want of this response.
        if (state_ == state::overdue) --node.no_response;
        if (state_ == state::damaged) --node.damaged;
        if (state_ == state::tentative) {
            --node.unpaired;
            ++node.requests;
        }
        state_ = state::none;
        const bool is_exception = (frame.data[1] & servobus::modbus::exception_flag) != 0;
        ++(is_exception ? node.exceptions : node.responses);
        h.after = frame.begin - asked_;
        node.slowest = std::max(node.slowest, *h.after);
    }

    bool is_response_to_request(servobus::bytes response) const {
        const servobus::bytes request = request_;
        if (response[0] != request[0]) return false;
        if (response[1] == (request[1] | servobus::modbus::exception_flag)) return true;
        if (response[1] != request[1]) return false;
        if (servobus::modbus::is_read(request[1]) && request.size() == 8)
            return response[2] == 2u * servobus::load_word(request, 4);
        if (servobus::modbus::is_write(request[1]) && request.size() >= 8 && response.size() == 8)
            return servobus::load_word(response, 2) == servobus::load_word(request, 2);
        const bool is_checked = servobus::is_request(pdu_of(request, request.size()));
        return !is_checked || answers_request(pdu_of(response, response.size()));
    }

    moment timeout_;
    std::vector<std::uint8_t> request_{};
    moment asked_ = 0; ///< when the last byte of the request had arrived
    state state_ = state::none;
    bool is_in_doubt_ = true;
    std::array<node_counters, 256> counters_{};
};

} // namespace tool
