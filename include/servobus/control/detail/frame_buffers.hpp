// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The buffers of a machine's exchange, and how a request is made for a purpose. The response buffer:
//
//     | held feedback | response of the frame under way | or, where nothing is held, the response from the beginning
#pragma once

#include <cstddef>
#include <cstdint>

#include <servobus/control/detail/command_slot.hpp>
#include <servobus/control/detail/held_feedback.hpp>
#include <servobus/control/detail/knowledge.hpp>
#include <servobus/control/detail/terms.hpp>
#include <servobus/control/states.hpp>
#include <servobus/core/bytes.hpp>
#include <servobus/modbus/pdu.hpp>
#include <servobus/modbus/rtu.hpp>

namespace servobus::detail {

template <class Model, class Exchange> class frame_buffers {
  public:
    constexpr explicit frame_buffers(std::uint8_t node_address) : request_{node_address} {}
    // The exchange refers to the buffers.
    frame_buffers(const frame_buffers&) = delete;
    frame_buffers& operator=(const frame_buffers&) = delete;

    constexpr bool is_write() const { return modbus::is_write(request_[1]); }
    /// Where feedback that is held back lies.
    constexpr std::uint8_t* held() { return response_; }

    /// Makes the request for a step, the feedback or the witness. Held feedback is dropped if its response finds no
    /// room.
    template <class Line>
    constexpr void fill(Exchange& x, flight what, knowledge<Model>& known, const command_slot<Model>& slot,
                        const terms& by, instant now, const Line& on) {
        const routine_run& run = slot.run();
        const byte_buffer pdu = byte_buffer{request_}.subspan(1);
        std::size_t size = 5;
        std::size_t words = 0;
        if (what == flight::step) {
            size = run.put_request(pdu);
            words = run.current().count;
        } else {
            const register_block block = block_of(what, known, slot, now);
            put_read(pdu, block);
            words = block.words;
        }
        // The machine's own frame needs no check.
        const bytes request = modbus::close_trusted<typename Exchange::crc>(request_, size);
        const std::size_t response = is_write() ? 8u : 5u + 2u * words;
        held_feedback& held = known.feedback().held();
        std::size_t at = held.size(); // after feedback that is held back
        if (at + response > sizeof response_) {
            held.drop();
            at = 0;
        }
        const priority how = what == flight::step && run.is_urgent() ? priority::stop : by.priority();
        const byte_buffer room{response_ + at, response};
        x = Exchange::trusted(request, room, on.timing(), by.limits(), how);
    }

  private:
    // The registers that a read of the feedback or of the witness reads.
    static constexpr register_block block_of(flight what, knowledge<Model>& known,
                                             const command_slot<Model>& slot, instant now) {
        if (what == flight::witness) {
            const step* look = known.witness(slot.command()).look;
            return look != nullptr ? register_block{look->address, look->count} : image_block<Model>;
        }
        polling<Model>& polling = known.polling();
        const bool is_image_first = known.last_frame() != last_frame::feedback && polling.is_image_due(now) &&
                                    !polling.may_wait_for(slot, now);
        return polling.choose(slot.run(), is_image_first);
    }
    [[gnu::noinline]] static constexpr void put_read(byte_buffer pdu, register_block block) {
        constexpr auto read = modbus::function::read_holding_registers;
        modbus::put_trusted_request(pdu, read, block.address, block.words);
    }

    std::uint8_t request_[24];
    std::uint8_t response_[held_feedback::room(image_block<Model>.words)]{};
};

} // namespace servobus::detail
