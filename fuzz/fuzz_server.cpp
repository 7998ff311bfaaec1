// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A server with a store, fed with bytes and times. It acts only if a complete frame for it has just ended,
// and then as the reference does. With strict timing that frame began after a gap of t3.5. With host timing,
// where the server cannot always see that gap, it executes exactly the frames that the reference accepts. A
// request after a gap always gets a response, whatever came before. Bytes in one piece have the same effect
// as one by one.
#include <cstdint>
#include <optional>
#include <span>

#include <servobus/modbus/server.hpp>

#include "reference.hpp"
#include "support.hpp"

using namespace servobus;
using fuzz::require;

namespace {

struct store {
    reference::registers words;
    std::uint32_t writes = 0;
    std::uint8_t read(std::uint16_t address, std::span<std::uint16_t> to) {
        for (std::size_t i = 0; i < to.size(); ++i) {
            if (!reference::registers::has(address + static_cast<unsigned>(i))) return 2;
        }
        for (unsigned i = 0; i < to.size(); ++i) to[i] = words[address + i];
        return 0;
    }
    std::uint8_t write(std::uint16_t address, words_view from) {
        for (std::size_t i = 0; i < from.size(); ++i) {
            if (!reference::registers::has(address + static_cast<unsigned>(i))) return 2;
        }
        for (unsigned i = 0; i < from.size(); ++i) words[address + i] = from[i];
        ++writes;
        return 0;
    }
};

struct heard {
    std::uint8_t byte;
    bool may_begin;    ///< a frame may begin here, after a gap
    bool is_after_gap; ///< the gap before it is longer than any inside a frame
};

class bench {
  public:
    explicit bench(fuzz::input& in) : in_{&in} {
        const unsigned choice = in.byte();
        is_strict_ = (choice & 1u) != 0;
        rules_.reads_input_registers = (choice & 2u) != 0;
        now_.us = (choice & 4u) != 0 ? 0xFFFF'FF00u : 0u;
        timing_ = modbus::timing_at((choice & 8u) != 0 ? 9600 : 115200,
                                    is_strict_ ? modbus::timing_mode::strict : modbus::timing_mode::host);
        last_ = now_;
        single_.emplace(node_address, store_, timing_, rules_);
        whole_.emplace(node_address, other_, timing_, rules_);
        heard_.reserve(512);
    }

    void run() {
        while (!in_->empty()) {
            const unsigned what = in_->byte();
            pass(fuzz::time_of(in_->byte()));
            if (what >= 0xE0) {
                receive(what >= 0xF0 ? neighbour(what) : two_faced(what));
                continue;
            }
            switch (what % 6) {
            case 0: receive(in_->take(in_->byte())); break;
            case 1: receive(framed(what)); break;
            case 2: elapse(); break;
            case 3: send(); break;
            case 4: ask(what); break;
            default: receive(spoilt(what)); break;
            }
        }
    }

  private:
    static constexpr std::uint8_t node_address = 7;

    void pass(std::uint32_t us) { now_ = now_ + duration{us}; }

    // A frame to this server, a broadcast or a frame to another node; the fuzzer chooses the PDU.
    reference::byte_list framed(unsigned what) {
        constexpr std::uint8_t addresses[] = {node_address, node_address, 0, node_address + 1};
        const bytes pdu = in_->take(1u + in_->byte() % 253u);
        reference::byte_list body{addresses[what / 8 % 4]};
        body.insert(body.end(), pdu.begin(), pdu.end());
        return reference::framed(body);
    }
    reference::byte_list spoilt(unsigned what) {
        reference::byte_list f = framed(what);
        const std::uint8_t at = in_->byte();
        f[at % f.size()] ^= static_cast<std::uint8_t>(1u << in_->byte() % 8u);
        if ((what & 0x80u) != 0) fuzz::cut(f, at);
        return f;
    }

    static reference::byte_list write_of_9(std::uint8_t node, unsigned address) {
        return reference::framed({node, 16, static_cast<std::uint8_t>(address >> 8),
                                  static_cast<std::uint8_t>(address & 0xFFu), 0, 9});
    }
    // Near 0x0012: the CRC of the response to a write there equals the next byte of the request, its byte count.
    static unsigned two_faced_address(std::uint8_t node) {
        unsigned address = 0x12;
        while (write_of_9(node, address)[6] != 18) ++address;
        return address;
    }

    // A frame of another node that can be read as a request or as a response, which have different lengths.
    // After the shorter one follow bytes that the fuzzer chooses, or a request to this server.
    reference::byte_list two_faced(unsigned what) {
        const auto other = static_cast<std::uint8_t>(node_address + 1 + what % 2);
        const auto registers = static_cast<std::uint8_t>(4 + in_->byte() % 122);
        const auto count = static_cast<std::uint8_t>(2 * registers);
        reference::byte_list all;
        reference::byte_list body;
        std::size_t size = 3u + count;
        if ((what & 2u) != 0) { all = reference::framed({other, 3, in_->byte(), in_->byte(), 0, registers}); }
        if ((what & 4u) != 0) {
            static const unsigned addresses[]{two_faced_address(node_address + 1),
                                              two_faced_address(node_address + 2)};
            body = write_of_9(other, addresses[what % 2]);
            size = 7 + 18;
        } else {
            const std::uint8_t low = in_->byte();
            body = reference::framed(
                {other, 3, count, low, 0, static_cast<std::uint8_t>(1 + in_->byte() % 125)});
        }
        const std::uint8_t choice = in_->byte();
        const bytes given = in_->take(choice / 4u);
        const reference::byte_list inside =
            choice % 2 == 0 ? reference::byte_list{given.begin(), given.end()}
                            : reference::framed({choice % 4 == 1 ? node_address : std::uint8_t{0}, 6, 0, 1, 0,
                                                 static_cast<std::uint8_t>(choice)});
        body.insert(body.end(), inside.begin(), inside.end());
        body.resize(size);
        body = reference::framed(body);
        all.insert(all.end(), body.begin(), body.end());
        if ((what & 8u) != 0) fuzz::cut(all, in_->byte());
        return all;
    }

    // A request or response of another node, of any function, after some bytes 00 or FF; or a request to this
    // server after such bytes. The payload may be a write to this server.
    reference::byte_list neighbour(unsigned what) {
        constexpr std::uint8_t codes[] = {1, 2, 3, 4, 5, 6, 15, 16, 22, 23, 0x65, 7};
        const unsigned choice = in_->byte();
        const std::uint8_t code = codes[choice % 12];
        const bool is_own = (what & 8u) != 0;
        reference::byte_list all(what % 8 > 4 ? what % 8 - 2u : 0u, (choice & 0x80u) != 0 ? 0xFF : 0x00);
        const bytes given = in_->take(in_->byte() % 32u);
        reference::byte_list payload{given.begin(), given.end()};
        if ((choice & 0x40u) != 0) payload = reference::framed({node_address, 6, 0, 1, 0, in_->byte()});
        const auto size = static_cast<std::uint8_t>(payload.size());
        reference::byte_list body{is_own ? node_address : static_cast<std::uint8_t>(node_address + 1), code};
        if ((choice & 0x20u) == 0) { // a request
            if (code != 0x65) body.insert(body.end(), {0, in_->byte(), 0, in_->byte()});
            if (code == 22) body.insert(body.end(), {0, 1});
            if (code == 23) body.insert(body.end(), {0, 1, 0, static_cast<std::uint8_t>(size / 2)});
            if (code == 15 || code == 16 || code == 23) body.push_back(size);
            if (code == 15 || code == 16 || code == 23 || code == 0x65)
                body.insert(body.end(), payload.begin(), payload.end());
        } else {
            if (code < 5 || code == 23) body.push_back(size);
            if (code < 5 || code == 23 || code == 0x65)
                body.insert(body.end(), payload.begin(), payload.end());
            if (body.size() == 2) body.resize(code == 22 ? 8 : 6, in_->byte());
        }
        body = reference::framed(body);
        all.insert(all.end(), body.begin(), body.end());
        if (code == 0x65) all.resize(all.size() + choice / 12 % 3);
        return all;
    }

    // Whether bytes that came together began after t3.5 if they were one, and not if they are all.
    bool is_pause_of_one(std::size_t arrived) const {
        const duration gap = since(last_, now_);
        return !is_strict_ && gap >= t3_5_before(1) && gap < t3_5_before(arrived);
    }
    duration t3_5_before(std::size_t arrived) const {
        return duration{timing_.t3_5} + timing_.wire_time(arrived);
    }

    void receive(bytes arrived) {
        const bool is_single = is_pause_of_one(arrived.size());
        // `single_` receives each byte at its own time, `whole_` all bytes at the time of the last one.
        const duration character = is_strict_ ? timing_.wire_time(1) : duration{};
        for (const std::uint8_t byte : arrived) {
            pass(character.us);
            const before b{*this};
            note(byte);
            const auto due = is_strict_ || b.was_answering ? std::nullopt : listener_.receive(byte);
            single_->feed(bytes{&byte, 1}, now_);
            b.judge(*this, due);
        }
        if (is_single) {
            for (const std::uint8_t byte : arrived) whole_->feed(bytes{&byte, 1}, now_);
        } else {
            whole_->feed(arrived, now_);
        }
        compare();
    }

    void note(std::uint8_t byte) {
        const duration gap = since(last_, now_);
        const bool is_gap = has_received_ && gap > timing_.longest_gap(1);
        const duration silence =
            is_strict_ ? duration{timing_.t3_5} + timing_.wire_time(1) : timing_.visible_gap();
        const bool may_begin = !has_received_ || (is_gap && gap >= silence);
        if (has_received_ && gap >= t3_5_before(1) && !single_->is_answering()) listener_.pause();
        if (is_gap && !single_->is_answering()) (void)listener_.silence(false);
        heard_.push_back({byte, may_begin, is_gap});
        has_received_ = true;
        last_ = now_;
    }

    reference::byte_list last_bytes(std::size_t size) const {
        reference::byte_list f;
        for (std::size_t i = heard_.size() - size; i < heard_.size(); ++i) f.push_back(heard_[i].byte);
        return f;
    }

    void elapse() {
        const before b{*this};
        const bool is_silent = since(last_, now_) > timing_.visible_gap();
        if (!b.was_answering && since(last_, now_) >= t3_5_before(0)) listener_.pause();
        const auto due = is_strict_ || b.was_answering || !is_silent ? std::nullopt : listener_.silence(true);
        single_->elapse(now_);
        whole_->elapse(now_);
        b.judge(*this, due);
        compare();
    }

    void send() {
        const bytes frame = single_->response(now_);
        if (frame.empty()) return;
        require(since(last_, now_).us >= timing_.t3_5, "a response begins after a gap of t3.5");
        pass(timing_.wire_time(frame.size()).us);
        single_->sent(now_);
        whole_->sent(now_);
        listener_.responded();
        last_ = now_;
        has_received_ = true;
        compare();
    }

    // G9, G14: after a gap a request gets the response of the reference.
    void ask(unsigned what) {
        pass(timing_.visible_gap().us + timing_.t3_5 + 10'000u);
        elapse(); // executes a frame that only a gap completes; its response waits for t3.5
        pass(timing_.visible_gap().us + timing_.t3_5 + 10'000u);
        send();
        pass(timing_.visible_gap().us + timing_.t3_5 + 10'000u);
        require(!single_->is_answering(), "after a response has left the server is idle");
        constexpr std::uint8_t codes[] = {3, 6, 16, 4};
        const bytes rest = in_->take(what / 8 % 2 == 0 ? 4 : 5 + in_->byte());
        reference::byte_list pdu{codes[what / 16 % 4]};
        pdu.insert(pdu.end(), rest.begin(), rest.end());
        if (pdu[0] == 16 && (pdu.size() < 6 || pdu.size() > 253 || pdu[5] != pdu.size() - 6)) return;
        if (pdu[0] != 16 && pdu.size() != 5) return;
        reference::byte_list body{node_address};
        body.insert(body.end(), pdu.begin(), pdu.end());
        reference::registers all = store_.words;
        const reference::byte_list expected = reference::respond(all, pdu, rules_.reads_input_registers);
        receive(reference::framed(body));
        require(single_->is_answering(), "G9 G14 after a gap a request gets a response");
        const bytes response = single_->response(now_ + duration{timing_.t3_5});
        require(response.size() == expected.size() + 3 &&
                    same_bytes(response.subspan(1, expected.size()), expected),
                "G14 the response is that of the standard");
    }

    // G7: bytes in one piece have the same effect as one by one.
    void compare() const {
        require(single_->is_answering() == whole_->is_answering() && single_->dropped() == whole_->dropped(),
                "bytes in one piece have the same effect as one by one");
        require((store_.writes == 0 && other_.writes == 0) || store_.words == other_.words,
                "bytes in one piece write the same registers as one by one");
        const instant later = now_ + duration{timing_.t3_5};
        require(same_bytes(single_->response(later), whole_->response(later)),
                "bytes in one piece get the same response as one by one");
    }

    // The state before a byte came or time passed. The registers are those of the bench.
    struct before {
        bool was_answering;
        std::uint32_t writes;

        explicit before(const bench& b) : was_answering{b.single_->is_answering()}, writes{b.store_.writes} {}

        // `due`: with host timing, the frame that must be executed.
        void judge(bench& b, const std::optional<reference::byte_list>& due) const {
            const bool answers = !was_answering && b.single_->is_answering();
            const bool has_changed = writes != b.store_.writes && b.words_before_ != b.store_.words;
            judge(b, due, answers, has_changed);
            if (has_changed) b.words_before_ = b.store_.words;
        }
        void judge(const bench& b, const std::optional<reference::byte_list>& due, bool answers,
                   bool has_changed) const {
            if (!b.is_strict_) {
                if (due) return require(follows(b, *due, answers), "G13 G14 a frame that is due is executed");
                require(!answers && !has_changed, "G13 no frame is executed that may belong to another node");
            }
            if (!answers && !has_changed) return;
            for (std::size_t size = 4; size <= 256 && size <= b.heard_.size(); ++size) {
                if (explains(b, size, answers)) return;
            }
            require(false, "G13 G14 only a complete request for this server is executed and gets a response");
        }

        // Whether the last `size` bytes are a frame that makes the reference do the same.
        bool explains(const bench& b, std::size_t size, bool answers) const {
            const std::size_t from = b.heard_.size() - size;
            if (!begins(b, from)) return false;
            for (std::size_t i = from + 1; i < b.heard_.size(); ++i) {
                if (b.heard_[i].is_after_gap) return false;
            }
            const reference::byte_list frame = b.last_bytes(size);
            return reference::is_frame(frame) && (frame[0] == node_address || frame[0] == 0) &&
                   follows(b, frame, answers);
        }

        // Whether a frame may begin here: after a gap, and after bytes 00 or FF that followed it.
        static bool begins(const bench& b, std::size_t at) {
            for (unsigned skipped = 0; skipped <= b.rules_.leading_bytes; ++skipped, --at) {
                if (b.heard_[at].may_begin) return true;
                if (at == 0 || b.heard_[at].is_after_gap) return false;
                if (b.heard_[at - 1].byte != 0x00 && b.heard_[at - 1].byte != 0xFF) return false;
            }
            return false;
        }

        // Whether the server did the same as the reference with this frame.
        bool follows(const bench& b, const reference::byte_list& frame, bool answers) const {
            if (answers != (frame[0] == node_address)) return false;
            reference::registers all = b.words_before_;
            const reference::byte_list pdu{frame.begin() + 1, frame.end() - 2};
            const reference::byte_list response =
                reference::respond(all, pdu, b.rules_.reads_input_registers);
            if (all != b.store_.words) return false;
            if (!answers) return true;
            reference::byte_list whole{node_address};
            whole.insert(whole.end(), response.begin(), response.end());
            return same_bytes(reference::framed(whole),
                              b.single_->response(b.now_ + duration{b.timing_.t3_5}));
        }
    };

    fuzz::input* in_;
    store store_;
    store other_;
    reference::registers words_before_; ///< those of `store_` before the byte or the time that is judged
    modbus::rtu_timing timing_{};
    modbus::server_rules rules_{};
    std::optional<modbus::server<store>> single_;
    std::optional<modbus::server<store>> whole_;
    reference::list<heard> heard_;
    instant now_{};
    instant last_{};
    bool is_strict_ = false;
    bool has_received_ = false;
    reference::listener listener_{node_address, rules_.leading_bytes}; ///< for host timing
};

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::input in{data, size};
    bench{in}.run();
    return 0;
}
