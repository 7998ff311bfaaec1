// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The base of the stepped calls of a client, for all registers: a program has one copy for each type of client. It
// is a loop over `request_machine` that never waits: it makes the frame of the next request in the memory of the
// call, and steps its exchange.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include <servobus/client/raw_client.hpp>
#include <servobus/client/request_machine.hpp>

namespace servobus::detail {

/// The kind of a call decides which request rules out an echo, and how long responses are.
enum class call_of : std::uint8_t {
    registers,
    tables, ///< bits, and reads of several tables: the quantity lies behind request and response
    masked, ///< function 16h
    both,   ///< function 17h
};

/// True while a write of a register that a facade caches is still to be noted. Empty for writes of other registers.
template <bool IsCached> struct change_note { bool is_due = false; };
template <> struct change_note<false> {};

/// One call at a time: requests of one node, stepped to their end. `Link` is what the client knows of its node. The
/// derived call has the memory of the frame, the same for request and response: `read_room` or `write_room` bytes.
template <class Link> class stepped_request {
    using line_type = typename Link::line_type;
    static_assert(!line_type::is_small, "a blocking_line has blocking calls only: stepped calls need a line");
    using stage = request_machine::stage;

  public:
    // The line and the exchange keep its address while the call is under way.
    stepped_request(const stepped_request&) = delete;
    stepped_request& operator=(const stepped_request&) = delete;
    constexpr ~stepped_request() { cancel(); }

    /// True if no call is under way: it has ended, or none was begun yet.
    constexpr bool done() const { return machine_.done(); }
    /// How the last call ended; `busy` while one is under way, `bad_argument` before the first.
    constexpr servobus::status status() const { return status_; }

    /// Gives the call up. The status is `timeout` (outcome unknown) if any of the request has left, else `busy`
    /// (nothing was sent), or `own_echo` if only the check of a write was left. The line stays in order, also if
    /// the object is destroyed.
    constexpr void cancel() {
        if (done()) return;
        link_->line().abandon(exchange_);
        end(machine_.given_up(exchange_.status()));
    }

  protected:
    using condition = typename Link::condition;
    static constexpr bool has_tokens = Link::has_tokens;
    static constexpr condition needing(servobus::ram_only token) { return Link::needing(token); }
    static constexpr std::size_t shortest_room = 8; // a request of function 03 or 06
    static constexpr std::size_t read_room(std::size_t words) {
        return words < 2 ? shortest_room : 5 + 2 * words;
    }
    /// `asks_first`: a read goes first. Its frame lies after that of the write, which is kept.
    static constexpr std::size_t write_room(std::size_t words, bool asks_first) {
        const bool is_short = words == 1 && !Link::refuses_function_06;
        return (is_short ? shortest_room : 9 + 2 * words) + (asks_first ? shortest_room : 0);
    }

    /// For a read of any table: of the longer one of request and response, and the quantity behind them.
    static constexpr std::size_t part_room(std::size_t response) {
        return (response < shortest_room ? shortest_room : response) + 2;
    }

    [[gnu::noinline]] constexpr explicit stepped_request(Link& of) : link_{&of} {}
    // cppcheck-suppress returnTempReference ; it is the client itself
    template <class Client> static constexpr Link& link_of(Client& of) { return of.link_for(stepped_key{}); }

    /// No call is under way. Errors: `bad_argument`.
    constexpr errc begin_read(std::uint8_t* frame, u16 address, std::size_t words,
                              modbus::function code = modbus::function::read_holding_registers) {
        const auto count = static_cast<u16>(words);
        if (!node().is_valid() || !modbus::detail::is_readable(code, address, count))
            return refused(errc::bad_argument);
        return begin(request_machine::read(), frame, 5 + 2 * words, address, static_cast<std::uint8_t>(code));
    }
    /// Reads a value of `Words` words, which `value_in` finds in the frame at the end.
    template <std::size_t Words> constexpr errc begin_value(std::uint8_t* frame, u16 address) {
        if (!done()) return errc::busy;
        if (const errc why = order_known_if(Words == 2); why != errc::ok) return refused(why);
        return begin_read(frame, address, Words);
    }
    template <std::size_t Words> constexpr result<u32> value_in(bytes frame) const {
        if (!status()) return status();
        if constexpr (Words == 2) {
            if (order_at_end() == word_order::unknown) return errc::needs_word_order;
            return join_words(load_word(frame, 3), load_word(frame, 5), order_at_end());
        } else {
            return u32{load_word(frame, 3)};
        }
    }
    /// Writes a value of `Words` words: function 06, or 10h for two. `asks_first`: an echo must be ruled
    /// out before the write leaves, not after it.
    template <std::size_t Words>
    constexpr errc begin_value(std::uint8_t* frame, u16 address, u32 bits, condition on, bool asks_first) {
        if (!done()) return errc::busy;
        if constexpr (Words == 2) {
            const word_order order = link_->current_word_order();
            if (order == word_order::unknown) return refused(errc::needs_word_order);
            on.use(order);
            (void)store_value({frame, 13}, 7, bits, 2, order);
            return begin_block(frame, 2, address, on, asks_first);
        } else if constexpr (Link::refuses_function_06) {
            store_word({frame, 9}, 7, static_cast<u16>(bits));
            return begin_block(frame, 1, address, on, asks_first);
        } else {
            const byte_buffer request{frame, 8};
            request[0] = node().address;
            (void)modbus::put_write_request(request.subspan(1), address, static_cast<u16>(bits));
            (void)modbus::close_trusted<crc>(request, 5);
            return begin_write(frame, 8, on, asks_first);
        }
    }
    /// Writes the words that lie in `frame` from its byte 7 on.
    constexpr errc begin_block(std::uint8_t* frame, std::size_t words, u16 address, const condition& on,
                               bool asks_first = false) {
        const std::size_t size = 9 + 2 * words;
        Link::complete_block(node().address, {frame, size}, address);
        return begin_write(frame, size, on, asks_first);
    }
    /// Stores a value of one or two words. Returns its bytes.
    static constexpr std::size_t store_value(byte_buffer frame, std::size_t at, u32 bits, std::size_t words,
                                             word_order order) {
        if (words == 2) {
            const word_pair pair = split_words(bits, order);
            store_word(frame, at, pair.first);
            store_word(frame, at + 2, pair.second);
        } else {
            store_word(frame, at, static_cast<u16>(bits));
        }
        return 2 * words;
    }
    constexpr bool is_echo_ruled_out() const { return link_->line().is_echo_ruled_out(node().address); }
    constexpr word_order current_order() { return link_->current_word_order(); }
    constexpr errc order_known_if(bool matters) {
        return matters && current_order() == word_order::unknown ? errc::needs_word_order : errc::ok;
    }
    /// The word order of the words that were read.
    constexpr word_order order_at_end() const {
        if constexpr (Link::loses_word_order)
            return order_.value;
        else
            return std::as_const(*link_).node().word_order;
    }

    template <bool IsCached> static constexpr change_note<IsCached> change_of([[maybe_unused]] bool is_due) {
        if constexpr (IsCached)
            return {is_due};
        else
            return {};
    }
    /// As `move_on`, of a write.
    template <call_of What = call_of::registers, class Change>
    constexpr duration move_on_and_note(std::uint8_t* frame, [[maybe_unused]] Change& change) {
        const duration idle = move_on<What>(frame);
        note(change);
        return idle;
    }
    /// Notes once, as soon as the write has begun to leave, that it makes the settings of a facade stale.
    constexpr void note(change_note<false>) const {}
    constexpr void note(change_note<true>& change) {
        const stage now = machine_.now();
        const bool is_writing = now == stage::writing || now == stage::transacting;
        const bool has_left = done()       ? status_.was_sent()
                              : is_writing ? exchange_.was_sent()
                                           : now == stage::checking;
        if (!change.is_due || !has_left) return;
        change.is_due = false;
        link_->note_change();
    }
    /// Sets the facts that a request of function 17h needs until it leaves.
    constexpr void set_condition(const condition& on) { condition_ = on; }

    /// The call is not begun.
    constexpr errc refused(errc why) {
        status_ = why;
        return why;
    }

    /// Moves the call on without waiting; `frame` is the one that it began with. Returns the time within which nothing
    /// happens unless a byte comes.
    template <call_of What = call_of::registers> constexpr duration move_on(std::uint8_t* frame) {
        if (done()) return {};
        const bool is_writing = What == call_of::both || machine_.now() == stage::writing;
        if (is_writing && exchange_.state() == line_type::exchange::phase::ready) {
            if (const errc why = link_->refusal(condition_);
                why != errc::ok) { // while it waited for the line
                link_->line().abandon(exchange_);
                machine_ = {};
                end(why);
                return {};
            }
        }
        const duration idle = link_->line().step(exchange_, node().gaps);
        if (!exchange_.done()) return idle;
        servobus::status why = exchange_.status();
        // Facts may have been learned anew while the write waited for the line.
        if (is_writing) link_->invalidate(stale_);
        const bool repeats = What == call_of::both     ? !exchange_.differs_from_request()
                             : What == call_of::masked ? true
                                                       : code_ == (What == call_of::tables ? 0x05 : 0x06);
        if (machine_.goes_on(why, node(), repeats, link_->line().is_echo_ruled_out(node().address)))
            make_request<What>(frame);
        else
            end(why);
        return {};
    }

    using crc = typename line_type::crc;

    // Const: a stale word order is not dropped.
    constexpr const auto& node() const { return std::as_const(*link_).node(); }

    /// Begins a call whose frame is made. `size`: of the response to a read, else of the request.
    template <call_of What = call_of::registers>
    constexpr errc begin(request_machine call, std::uint8_t* frame, std::size_t size, u16 address,
                         std::uint8_t code) {
        machine_ = call;
        if constexpr (What == call_of::tables || What == call_of::masked) condition_ = {};
        size_ = static_cast<std::uint8_t>(size);
        address_ = address;
        code_ = code;
        status_ = errc::busy;
        make_request<What>(frame);
        return errc::ok;
    }

  private:
    constexpr errc begin_write(std::uint8_t* frame, std::size_t size, const condition& on, bool asks_first) {
        if (!done()) return errc::busy;
        if (!node().is_valid()) return refused(errc::bad_argument);
        if (const errc why = link_->refusal(on); why != errc::ok) return refused(why);
        condition_ = on;
        return begin(request_machine::write(asks_first && !link_->line().is_echo_ruled_out(node().address)),
                     frame, size, load_word(bytes{frame, size}, 2), frame[1]);
    }
    // Makes the exchange of the request that is next. A response takes the memory of its request.
    template <call_of What> constexpr void make_request(std::uint8_t* at) {
        std::size_t size = size_;
        std::size_t response = What == call_of::masked ? 10 : 8;
        if (What == call_of::both) {
            stale_ = {}; // it writes no setting
            response = address_;
        } else if (machine_.now() == stage::writing) {
            if constexpr (What == call_of::tables) {
                stale_ = {}; // no coil is a setting
            } else {
                stale_ = Link::invalidated_by(bytes{at, size});
                link_->invalidate_before(condition_, stale_);
            }
        } else {
            std::uint8_t code = code_;
            response = size;
            u16 quantity = 1;
            if (machine_.is_asking()) {
                if (machine_.now() == stage::asking_first) at += size; // the write is kept
                constexpr bool asks_coil = What == call_of::tables;
                code = asks_coil ? 1 : 3;
                response = asks_coil ? 6 : 7;
            } else if constexpr (What == call_of::tables) {
                quantity = load_word(bytes{at, part_room(size)}, part_room(size) - 2);
            }
            if constexpr (What != call_of::tables) quantity = static_cast<u16>((response - 5) / 2);
            size = 8;
            const byte_buffer request{at, size};
            request[0] = node().address;
            modbus::put_trusted_request(request.subspan(1), static_cast<modbus::function>(code), address_,
                                        quantity);
            (void)modbus::close_trusted<crc>(request, 5);
        }
        exchange_.restart({at, size}, {at, response}, link_->line().timing(), node().limits, node().priority);
        if constexpr (What == call_of::both) exchange_.judge_like(modbus::like(at[1]));
    }

    constexpr void end(servobus::status why) {
        if constexpr (Link::loses_word_order) order_.value = current_order();
        status_ = why;
    }

    struct kept_order {
        word_order value = word_order::unknown;
    };
    struct no_order {};

    request_machine machine_;
    std::uint8_t size_ = 0; // bytes of the response to a read, or of the request of a write
    std::uint8_t code_ = 0;
    u16 address_ = 0;
    [[no_unique_address]] typename Link::stale stale_{};
    [[no_unique_address]] std::conditional_t<Link::loses_word_order, kept_order, no_order> order_{};
    servobus::status status_{errc::bad_argument};
    Link* link_;
    [[no_unique_address]] condition condition_{};
    typename line_type::exchange exchange_;
};

} // namespace servobus::detail
