// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a client does in a run: one random operation after another, through any interface of the library.
// Each is judged when it ends.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "clients.hpp"
#include "events.hpp"
#include "stepping.hpp"
#include "verdict.hpp"

namespace trial {

template <class Line> class operations {
  public:
    explicit operations(clients<Line>& in) : in_{in}, events_{in} {}

    /// Lets some time pass, then carries out one operation.
    void one() {
        scene& on = in_.state();
        events_.pass_some_time();
        participant& at = in_.any_participant();
        events_.begin(at);
        in_.court().set_quiet(at.gaps());
        in_.court().begin_operation();
        in_.port().forget_request();
        on.model = {at.limits().response.us, at.gaps().quarantine.us, at.limits().leading_bytes};
        draw(at);
        for (const auto& s : in_.participants()) s->executed().clear();
        on.log->remark(on.now(), describe(at));
        const std::uint64_t bound = bound_at(at);
        const std::uint64_t stalled = on.stalled_us;
        const std::uint64_t begun = on.now() - stalled;
        stepping_.forget();
        const claim said = carry_out(at);
        const std::uint64_t took = on.now() - on.stalled_us - begun;
        on.log->remark(on.now(), "   ended: " + std::string{servobus::text(said.why.error())});
        ++on.count->operations;
        events_.wait_for_rest_of_request(stepping_.gave_up());
        check_time(std::max(bound, bound_at(at)), took);
        verdict{in_, meant_, said}.give();
        on.log->mix(static_cast<std::uint64_t>(said.why.error()) | said.why.exception() * 256u);
        for (const std::uint16_t w : said.words) on.log->mix(w);
        events_.end(at);
    }

  private:
    using kind = intent::kind;
    using test_participant = typename clients<Line>::test_participant;
    enum class way : std::uint8_t { plain, typed, raw, stepped };

    scene& on() { return in_.state(); }
    std::uint32_t below(std::uint32_t n) { return on().random.below(n); }

    void draw(participant& at) {
        static constexpr kind kinds[] = {kind::read,      kind::read,
                                         kind::read,      kind::read,
                                         kind::write,     kind::write,
                                         kind::write,     kind::write_if_different,
                                         kind::broadcast, kind::unknown_function};
        meant_ = {};
        // A blocking line has four functions and no stepped exchanges.
        meant_.what = kinds[below(Line::is_small ? 9 : 10)];
        meant_.at = at.is_where_it_is_looked_for() && !in_.is_empty() ? &at : nullptr;
        meant_.tries = at.retries() + 1;
        auto* const tested = dynamic_cast<test_participant*>(&at);
        way_ = static_cast<way>(below(Line::is_small ? 2 : 4));
        if (way_ == way::typed && (tested == nullptr || meant_.what == kind::unknown_function))
            way_ = way::plain;
        if (tested == nullptr && (meant_.what == kind::write_if_different || meant_.what == kind::broadcast))
            meant_.what = kind::write;
        if (meant_.what == kind::write_if_different || meant_.what == kind::broadcast) way_ = way::typed;
        if (meant_.what == kind::unknown_function) {
            way_ = way::raw;
            meant_.response_size = 8 + 2 * below(8);
            meant_.request_size = 8;
            return;
        }
        if (way_ == way::typed) return draw_row();
        draw_place(at, tested != nullptr);
        if (meant_.is_write()) {
            for (std::size_t i = 0; i < meant_.count; ++i)
                if (meant_.words.size() < meant_.count)
                    meant_.words.push_back(static_cast<std::uint16_t>(on().random.roll()));
            is_single_ = meant_.count == 1 && below(3) != 0;
            meant_.request_size = is_single_ ? 8 : 9 + 2 * meant_.count;
        } else {
            meant_.response_size = 5 + 2 * meant_.count;
        }
    }

    // Rows of the test device: a word, a pair, or several in one frame.
    void draw_row() {
        row_ = below(3);
        const bool is_pair = row_ == 1;
        meant_.count = is_pair ? 2 : 1;
        switch (meant_.what) {
        case kind::read:
            meant_.address = row_ == 0 ? 0x0010 : 0x0020;
            if (row_ == 2) meant_.count = 3;
            break;
        case kind::broadcast:
            meant_.address = 0x0220;
            meant_.count = 1;
            break;
        default: meant_.address = is_pair ? 0x0210 : 0x0200;
        }
        meant_.response_size = 5 + 2 * meant_.count;
        meant_.request_size = 9 + 2 * meant_.count;
        if (!meant_.is_write()) return;
        // Small numbers, so that the register often has the value already.
        const std::uint32_t choices = meant_.what == kind::write_if_different ? 2 : 60'000;
        for (std::size_t i = 0; i < meant_.count; ++i)
            meant_.words.push_back(static_cast<std::uint16_t>(below(choices)));
        meant_.response_size = std::max(meant_.response_size, std::size_t{8});
    }

    void draw_place(participant& at, bool is_test_device) {
        const std::uint32_t most = below(12) == 0 ? 123 : 8;
        meant_.count = 1 + below(most);
        if (is_test_device) {
            const std::uint32_t place = below(20);
            if (place == 0) {
                meant_.count = 1;
                meant_.address = static_cast<std::uint16_t>(test_device::refusing + below(256));
            } else if (place == 1) {
                meant_.address = static_cast<std::uint16_t>(below(0x4000));
            } else if (meant_.is_write() || place < 6) {
                meant_.address = static_cast<std::uint16_t>(test_device::kept_begin + below(0x80));
            } else {
                meant_.address = static_cast<std::uint16_t>(below(0x100));
            }
            return;
        }
        const auto& map = at.map();
        meant_.count = 1 + below(std::min(most, 16u));
        for (;;) {
            const auto& e = map.entries[below(static_cast<std::uint32_t>(map.entries.size()))];
            meant_.address = e.address;
            if (!meant_.is_write()) return;
            if (!is_harmless(map, e)) continue;
            meant_.count = e.words();
            const bool is_bounded = e.limits.low < e.limits.high && e.words() == 1;
            if (is_bounded)
                meant_.words = {static_cast<std::uint16_t>(
                    e.limits.low + below(static_cast<std::uint32_t>(e.limits.high - e.limits.low)))};
            return;
        }
    }
    // A write of this register does not stop the drive's responses, change its address or delay its
    // responses.
    static bool is_harmless(const servobus::catalogue& map, const servobus::entry& e) {
        using servobus::flag;
        const bool is_c630s_communication = map.device->eeprom_switch != 0 && e.address >> 8 == 0x0C;
        return e.rights != servobus::access::ro && !has(e.flags, flag::trigger) &&
               !has(e.flags, flag::communication) && !has(e.flags, flag::motion) && !is_c630s_communication;
    }

    claim carry_out(participant& at) {
        switch (way_) {
        case way::typed: return carry_out_typed(static_cast<test_participant&>(at));
        case way::raw: return carry_out_raw(at);
        case way::stepped:
            if constexpr (!Line::is_small) return stepping_.carry_out(in_, at, meant_, is_single_);
            break;
        default: break;
        }
        if (meant_.is_write()) {
            return claim{is_single_ ? at.write(meant_.address, meant_.words[0])
                                    : at.write(meant_.address, std::span<const std::uint16_t>{meant_.words})};
        }
        std::vector<std::uint16_t> words(meant_.count, 0xDEAD);
        claim c{at.read(meant_.address, words, servobus::modbus::function::read_holding_registers)};
        if (c.succeeded()) {
            c.words = words;
        } else if (std::any_of(words.begin(), words.end(), [](std::uint16_t w) { return w != 0xDEAD; })) {
            throw broken{"G2: a read that failed changed the caller's words"};
        }
        return c;
    }

    claim carry_out_raw(participant& at) {
        std::array<std::uint8_t, servobus::modbus::max_pdu> pdu{};
        std::size_t size = 5;
        if (meant_.what == kind::unknown_function) {
            pdu[0] = 0x2B;
        } else if (meant_.is_write() && !is_single_) {
            size = servobus::modbus::put_write_request(pdu, meant_.address,
                                                       std::span<const std::uint16_t>{meant_.words});
        } else if (meant_.is_write()) {
            size = servobus::modbus::put_write_request(pdu, meant_.address, meant_.words[0]);
        } else {
            size =
                servobus::modbus::put_read_request(pdu, servobus::modbus::function::read_holding_registers,
                                                   meant_.address, static_cast<std::uint16_t>(meant_.count));
        }
        std::vector<std::uint8_t> response(meant_.response_size - 3);
        claim c{at.transact(servobus::bytes{pdu}.first(size), response)};
        if (c.succeeded() && meant_.what == kind::read) {
            for (std::size_t i = 2; i + 1 < response.size(); i += 2)
                c.words.push_back(static_cast<std::uint16_t>(response[i] << 8 | response[i + 1]));
        }
        return c;
    }

    claim carry_out_typed(test_participant& at) {
        auto& client = at.client;
        const auto order = client.node().word_order;
        const std::uint16_t first = meant_.words.empty() ? std::uint16_t{0} : meant_.words[0];
        if (meant_.what == kind::broadcast)
            return claim{client.template broadcast<test_device::all_hear>(servobus::checked(first))};
        if (meant_.what == kind::read) return read_typed(client, order);
        const bool if_different = meant_.what == kind::write_if_different;
        if (row_ == 1) {
            const std::uint32_t value = join(meant_.words[0], meant_.words[1], order);
            return claim{
                if_different
                    ? client.template write_if_different<test_device::kept_pair>(servobus::checked(value))
                    : client.template write<test_device::kept_pair>(servobus::checked(value))};
        }
        return claim{if_different ? client.template write_if_different<test_device::kept_word>(
                                        servobus::checked(first))
                                  : client.template write<test_device::kept_word>(servobus::checked(first))};
    }

    template <class Client> claim read_typed(Client& client, servobus::word_order order) {
        const auto take = [&](claim& c, std::uint32_t pair) {
            const auto high = static_cast<std::uint16_t>(pair >> 16);
            const auto low = static_cast<std::uint16_t>(pair & 0xFFFFu);
            const bool is_high_first = order == servobus::word_order::high_first;
            c.words.push_back(is_high_first ? high : low);
            c.words.push_back(is_high_first ? low : high);
        };
        if (row_ == 0) {
            const auto r = client.template read<test_device::live_word>();
            claim c{r.status()};
            c.words = {*r};
            return c;
        }
        claim c;
        if (row_ == 1) {
            const auto r = client.template read<test_device::live_pair>();
            c = claim{r.status()};
            take(c, *r);
        } else {
            const auto r = client.template read<test_device::live_pair, test_device::other_word>();
            c = claim{r.status()};
            take(c, servobus::get<test_device::live_pair>(*r));
            c.words.push_back(servobus::get<test_device::other_word>(*r));
        }
        return c;
    }
    static std::uint32_t join(std::uint32_t first, std::uint32_t second, servobus::word_order order) {
        return order == servobus::word_order::high_first ? first << 16 | second : second << 16 | first;
    }

    std::uint64_t bound_at(participant& at) {
        return in_.line().bound(meant_.request_size, meant_.response_size, at.limits(), at.gaps()).us;
    }
    void check_time(std::uint64_t bound, std::uint64_t took) {
        const std::uint64_t exchanges = std::max(1u, in_.court().exchanges());
        std::uint64_t most = exchanges * (bound + 200 + 4 * in_.resolution_us()) * events_.clock_factor() +
                             stepping_.added_us();
        if (events_.is_clock_stopped()) most += exchanges * 60'000'000;
        if (took > most)
            throw broken{"G29: an operation took " + std::to_string(took) + " us, its bound is " +
                         std::to_string(most)};
    }

    std::string describe(participant& at) const {
        static constexpr const char* names[] = {"read", "write", "write if different", "broadcast",
                                                "unknown function"};
        static constexpr const char* ways[] = {"", ", typed", ", raw", ", stepped"};
        return "node " + std::to_string(at.address()) + (meant_.at == nullptr ? " (absent)" : "") + ": " +
               names[static_cast<unsigned>(meant_.what)] + " " + std::to_string(meant_.address) + " x " +
               std::to_string(meant_.count) + ways[static_cast<unsigned>(way_)];
    }

    clients<Line>& in_;
    events events_;
    stepping<Line> stepping_;
    intent meant_;
    way way_ = way::plain;
    std::uint32_t row_ = 0;
    bool is_single_ = true;
};

} // namespace trial
