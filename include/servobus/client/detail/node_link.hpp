// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A node on a line, and the facts that were learned of the node. They hold until a request to the node gets no
// valid response. The link is the base of a client. Blocking and stepped calls ask the link when their request leaves,
// and report to it what a write makes stale.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <servobus/client/node.hpp>
#include <servobus/client/ram_only.hpp>
#include <servobus/line/line.hpp>
#include <servobus/registers/cached_registers.hpp>
#include <servobus/registers/reg.hpp>

namespace servobus::detail {

template <class Link> class stepped_request;

/// The key for the link of a client. Only stepped calls have one.
class stepped_key {
    template <class Link> friend class stepped_request;
    constexpr stepped_key() = default;
};

// The facts that a write makes stale. Empty where nothing is learned of the node.
template <bool Learns> struct made_stale {
    bool tokens = false;
    bool word_order = false;
};
template <> struct made_stale<false> {};

// The facts on which a write depends until it leaves. Empty where the device has nothing of the kind.
template <bool HasTokens> struct needed_token {
    ram_only token{};
    bool is_needed = false;
};
template <> struct needed_token<false> {};
template <bool HasOrders> struct used_order {
    word_order order = word_order::unknown; // unknown: no value of the write has two words
    constexpr void use(word_order one) { order = one; }
};
template <> struct used_order<false> {
    constexpr void use(word_order) {}
};

template <class Line, device_class Device, class Node> class node_link {
  public:
    using line_type = Line;
    using crc = typename Line::crc; // every frame has it, as the line checks the responses

    static constexpr bool has_tokens = Device::facts.eeprom_switch != 0;
    static constexpr bool refuses_function_05 = Device::facts.refuses_function_05();
    static constexpr bool refuses_function_06 = Device::facts.refuses_function_06();
    /// True if a word order can become stale, also during a read.
    static constexpr bool loses_word_order = Device::facts.word_order_register != 0 && !is_fixed<Node>;
    /// True if anything is learned of the node that a restart would change.
    static constexpr bool learns = loses_word_order || has_tokens;

    constexpr node_link(Line& on, Node at) : line_{&on}, node_{at}, learned_{on, at} {}

    constexpr Line& line() { return *line_; }
    constexpr Node& node() {
        drop_stale_word_order(); // first, so that a word order that the caller sets remains
        return node_;
    }
    constexpr const Node& node() const { return node_; }

    /// The node's word order; unknown if stale.
    constexpr word_order current_word_order() {
        if constexpr (loses_word_order) (void)current_epoch();
        drop_stale_word_order();
        return node_.word_order;
    }
    /// True if the parts of one reading have one word order. `before`: the word order after the previous part.
    static constexpr bool is_one_order(std::size_t part, word_order before, word_order now) {
        return part == 0 || now == before;
    }
    constexpr bool is_good(ram_only token) { return token.holds(node_.address, current_epoch()); }

    struct condition : needed_token<has_tokens>, used_order<!has_fixed_word_order<Device>> {};
    static constexpr condition needing(ram_only token) {
        static_assert(has_tokens, "this device keeps writes only when told to");
        condition on;
        on.token = token;
        on.is_needed = true;
        return on;
    }
    /// Why the write must not leave now, or `ok`.
    constexpr errc refusal([[maybe_unused]] const condition& on) {
        if constexpr (!has_fixed_word_order<Device>) {
            if (on.order != word_order::unknown && current_word_order() != on.order)
                return errc::needs_word_order;
        }
        if constexpr (has_tokens) {
            if (on.is_needed && !is_good(on.token)) return errc::needs_init;
        }
        return errc::ok;
    }

    using stale = made_stale<learns>;
    [[gnu::always_inline]] static constexpr stale invalidated_by([[maybe_unused]] bytes request) {
        if constexpr (learns) {
            return {has_tokens && writes(Device::facts.eeprom_switch, request),
                    loses_word_order && writes(Device::facts.word_order_register, request)};
        } else {
            return {};
        }
    }
    /// All that a write of any register would make stale.
    static constexpr stale all() {
        if constexpr (learns)
            return {true, true};
        else
            return {};
    }
    /// Called before the write leaves. A broadcast reaches all nodes. The epoch begins for all clients of the node.
    template <bool IsBroadcast = false>
    [[gnu::always_inline]] constexpr void invalidate([[maybe_unused]] const stale& what) {
        if constexpr (learns) {
            if (what.tokens || what.word_order)
                line_->begin_epoch(IsBroadcast ? modbus::broadcast : node_.address);
        }
        if constexpr (loses_word_order) {
            if (what.word_order) learned_.stated = node_.word_order = word_order::unknown;
        }
    }
    /// As `invalidate`, before a write that may have to wait: the token that it needs stays good for it.
    constexpr void invalidate_before([[maybe_unused]] condition& waiting, const stale& what) {
        if constexpr (has_tokens) {
            const bool is_kept = waiting.is_needed && is_good(waiting.token);
            invalidate(what);
            if (is_kept) waiting.token = {node_.address, line_->epoch(node_.address)};
        } else {
            invalidate(what);
        }
    }

    /// True if a facade of the device caches settings. On a `blocking_line` there is none.
    static constexpr bool may_have_facade = !Line::is_small && has_cached_registers<Device>;
    /// True if a write of these registers makes the settings of a facade stale.
    static constexpr bool is_cached([[maybe_unused]] u16 address, [[maybe_unused]] std::size_t words) {
        if constexpr (may_have_facade)
            return is_cached_by_facade<Device>(address, words);
        else
            return false;
    }
    template <const auto&... Rs>
    static constexpr bool are_cached = (is_cached(Rs.address, row_type<Rs>::words) || ...);
    template <const auto& Rows>
    static constexpr bool has_cached_element =
        is_cached(Rows.first.address,
                  static_cast<std::size_t>((row_type<Rows>::size - 1) * Rows.stride) + row_type<Rows>::words);
    /// Returns how a write of such registers has ended.
    template <bool IsBroadcast = false> constexpr status changed(status how) {
        if (how.was_sent()) note_change<IsBroadcast>();
        return how;
    }
    template <bool IsBroadcast = false> constexpr void note_change() {
        line_->note_change(IsBroadcast ? modbus::broadcast : node_.address);
    }
    /// As `changed`, for registers that are known at run time.
    constexpr status written([[maybe_unused]] u16 address, [[maybe_unused]] std::size_t words, status how) {
        if constexpr (may_have_facade) {
            if (is_cached(address, words)) return changed(how);
        }
        return how;
    }

    // A frame of function 10h around its words.
    static constexpr void complete_block(std::uint8_t node_address, byte_buffer frame, u16 address) {
        const std::size_t payload = frame.size() - 9;
        frame[0] = node_address;
        frame[1] = static_cast<std::uint8_t>(modbus::function::write_multiple_registers);
        store_word(frame, 2, address);
        frame[4] = 0;
        frame[5] = static_cast<std::uint8_t>(payload / 2);
        frame[6] = static_cast<std::uint8_t>(payload);
        const byte_buffer tail = frame.last(2);
        const u16 check = modbus::crc16<crc>(bytes{frame}.first(frame.size() - 2));
        tail[0] = static_cast<std::uint8_t>(check & 0xFFu);
        tail[1] = static_cast<std::uint8_t>(check >> 8);
    }

  protected:
    Line* line_;
    [[no_unique_address]] Node node_;

  private:
    static constexpr bool writes(u16 wanted, bytes request) {
        const u16 address = load_word(request, 2);
        const u16 words = request[1] == 0x10 ? load_word(request, 4) : u16{1};
        const u16 distance = static_cast<u16>(wanted - address);
        return distance < words;
    }

    // From here on an exchange that was not stepped to its end counts as a miss.
    [[gnu::noinline]] constexpr epoch current_epoch() {
        if constexpr (!Line::is_small) (void)line_->is_free();
        return line_->epoch(node_.address);
    }
    // A word order that was read from the drive is valid in its epoch; then that with which the node was made counts.
    // No call of `is_free` here: `node()` must not free the line of an exchange.
    constexpr void drop_stale_word_order() {
        if constexpr (loses_word_order) {
            const epoch now = line_->epoch(node_.address);
            if (is_same_life(learned_.at, now)) return;
            learned_.at = now;
            node_.word_order = learned_.stated;
        }
    }

    // The word order that the node was made with, and the epoch in which another one was read. Empty where it
    // never changes.
    struct learned_order {
        constexpr learned_order(const Line& on, const Node& of)
            : stated{of.word_order}, at{on.epoch(of.address)} {}
        word_order stated;
        epoch at;
    };
    struct nothing_learned {
        constexpr nothing_learned(const Line&, const Node&) {}
    };
    [[no_unique_address]] std::conditional_t<loses_word_order, learned_order, nothing_learned> learned_;
};

} // namespace servobus::detail
