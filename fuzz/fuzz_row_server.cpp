// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A server of rows on a UART, fed with bytes and times; and many requests of all functions. It does what a plain model
// does that is written apart from the library: it executes the frames that begin and end with a gap and responds with
// the same bytes. Its buffer is exactly as long as its rows need. In host timing it executes the frames that a
// reference accepts which keeps every division of the line into frames.
#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>

#include <servobus/server/host_row_server.hpp>
#include <servobus/server/row_server.hpp>

#include "../tests/support/byte_times.hpp"
#include "../tests/support/row_model.hpp"
#include "../tests/support/served_rows.hpp"
#include "reference.hpp"
#include "support.hpp"

using namespace servobus;
using fuzz::byte_list;
using fuzz::require;

namespace {

constexpr std::uint8_t node_address = 7;
constexpr modbus::rtu_timing timing = modbus::timing_at(115200, modbus::timing_mode::strict);
using server = row_server<byte_times::uart, served_rows::values, timing, with_mask_write, with_read_write,
                          with_return_query_data, with_identification<served_rows::about>,
                          with_server_id<served_rows::id>>;

const row_model::device description = served_rows::description();
const row_model::device with_room = [] { // in host timing the buffer has room for each PDU
    row_model::device d = description;
    d.room = modbus::max_pdu;
    return d;
}();

/// A strict receiver of bytes with times.
class listener {
  public:
    explicit listener(row_model::model& of) : model_{&of} {}

    void byte(std::uint8_t b, std::uint32_t now) {
        if (is_answering_) return;
        if (has_begun_ && now - last_ > timing.t1_5 + timing.character) is_bad_ = true;
        has_begun_ = true;
        frame_.push_back(b);
        last_ = now;
    }
    /// No byte has come until now. Returns the response that begins now.
    byte_list silence(std::uint32_t now) {
        if (is_answering_ || !has_begun_ || now - last_ < timing.t3_5) return {};
        const byte_list f = frame_;
        const bool is_good =
            !is_bad_ && f.size() >= 4 && f.size() <= 256 && byte_times::framed({f.begin(), f.end() - 2}) == f;
        frame_.clear();
        has_begun_ = is_bad_ = false;
        if (!is_good || (f[0] != node_address && f[0] != 0)) return {};
        const byte_list pdu{f.begin() + 1, f.end() - 2};
        const bool writes = pdu[0] == 5 || pdu[0] == 6 || pdu[0] == 15 || pdu[0] == 16 || pdu[0] == 22;
        if (f[0] == 0 && !writes) return {};
        byte_list response = model_->respond(pdu);
        if (f[0] == 0 || response.empty()) return {};
        response.insert(response.begin(), node_address);
        is_answering_ = true;
        return byte_times::framed(response);
    }
    void sent(std::uint32_t now) {
        is_answering_ = false;
        has_begun_ = is_bad_ = true; // until a gap
        last_ = now;
    }

  private:
    row_model::model* model_;
    byte_list frame_;
    std::uint32_t last_ = 0;
    bool has_begun_ = false, is_bad_ = false, is_answering_ = false;
};

class bench {
  public:
    explicit bench(fuzz::input& in) : in_{&in} { port_.time.us = in.flag() ? 0xFFFF'F000u : 0; }

    void run() {
        while (!in_->empty()) {
            const unsigned what = in_->byte();
            pass(fuzz::time_of(in_->byte()));
            if (what % 8 == 0) {
                receive(raw(in_->take(in_->byte())));
            } else if (what % 8 < 3) {
                constexpr std::uint8_t addresses[] = {node_address, node_address, 0, node_address + 1};
                byte_list body = raw(in_->take(1u + in_->byte() % 254u));
                body.insert(body.begin(), addresses[what / 8 % 4]);
                ask(body);
            } else {
                // A few of one seed: each of them is a place where the fuzzer can cut and join.
                row_model::maker maker{description, in_->word()};
                for (unsigned i = 0; i <= what / 64; ++i) {
                    byte_list body = maker.request();
                    body.insert(body.begin(), maker.one_in(20) ? std::uint8_t{0} : node_address);
                    ask(body);
                }
            }
        }
        read_everything();
    }

  private:
    static byte_list raw(bytes from) { return {from.begin(), from.end()}; }

    void ask(const byte_list& body) {
        receive(byte_times::framed(body));
        pass(2000);
        pass(2000);
    }
    void receive(const byte_list& all) {
        for (const std::uint8_t b : all) {
            port_.arrived.push_back(b);
            step(timing.character);
        }
    }
    // No byte comes for so long.
    void pass(std::uint32_t us) {
        for (unsigned i = 0; i < 5 && us > 500; ++i, us -= 500) step(500);
        step(us);
    }
    void step(std::uint32_t us) {
        port_.time.us += us;
        const bool was_answering = server_->is_answering();
        const bool has_byte = !port_.arrived.empty();
        if (!was_answering) {
            if (has_byte) {
                listener_.byte(port_.arrived.front(), port_.time.us);
            } else {
                const byte_list response = listener_.silence(port_.time.us);
                expected_.insert(expected_.end(), response.begin(), response.end());
            }
        } else if (has_byte) {
            port_.arrived.pop_front(); // while it sends, nothing is received
        }
        server_->step();
        if (was_answering && !server_->is_answering()) {
            listener_.sent(port_.time.us);
            require(port_.sent_bytes == expected_, "the response is the model's");
            port_.sent_bytes.clear();
            expected_.clear();
        }
        require(server_->is_answering() == !expected_.empty(),
                "a frame is executed if the model executes it");
    }

    void read_everything() {
        pass(5000);
        pass(5000);
        for (const row_model::row& r : description.rows) {
            const unsigned code = r.table == 'c' ? 1 : r.table == 'd' ? 2 : r.table == 'h' ? 3 : 4;
            ask({node_address, row_model::low_byte(code), row_model::low_byte(r.address >> 8),
                 row_model::low_byte(r.address), 0, row_model::low_byte(r.words)});
        }
    }

    fuzz::input* in_;
    byte_times::uart port_{};
    served_rows::values values_{};
    std::unique_ptr<server> server_ =
        std::make_unique<server>(port_, values_, node_address); // on the heap, for its end
    row_model::model model_{description};
    listener listener_{model_};
    byte_list expected_;
};

using host_server = host_row_server<byte_times::uart, served_rows::values, with_mask_write, with_read_write,
                                    with_return_query_data, with_identification<served_rows::about>,
                                    with_server_id<served_rows::id>>;

class host_bench {
  public:
    explicit host_bench(fuzz::input& in) : in_{&in} {}

    void run() {
        while (!in_->empty()) {
            const unsigned what = in_->byte();
            pass(fuzz::time_of(in_->byte()));
            row_model::maker maker{description, in_->word()};
            byte_list body = what % 8 == 0 ? raw(in_->take(in_->byte())) : maker.request();
            if (what % 8 != 0) {
                constexpr std::uint8_t addresses[] = {node_address, node_address, 0, node_address + 1};
                body.insert(body.begin(), addresses[what / 8 % 4]);
                body = reference::framed(body);
                if ((what & 0x80u) != 0) fuzz::cut(body, what);
            }
            receive(body);
        }
        pass(50'000);
        pass(50'000);
        require(!server_.is_answering(), "G9 after gaps the server is idle");
        receive(reference::framed(byte_list{node_address, 3, 0, 0x10, 0, 1}));
        require(server_.is_answering(), "G9 G14 after a gap a request gets a response");
        pass(50'000);
    }

  private:
    static byte_list raw(bytes from) { return {from.begin(), from.end()}; }

    void receive(const byte_list& all) {
        for (const std::uint8_t b : all) {
            port_.arrived.push_back(b);
            const bool was_answering = server_.is_answering();
            const auto due = was_answering ? std::nullopt : listener_.receive(b);
            server_.step();
            judge(due);
        }
    }
    // No byte comes for so long. The listener is told as the server can know it.
    void pass(std::uint32_t us) {
        for (unsigned i = 0; i < 60 && us > 600; ++i, us -= 600) step(600);
        step(us);
    }
    void step(std::uint32_t us) {
        port_.time.us += us;
        gap_ += us;
        const bool was_answering = server_.is_answering();
        std::optional<reference::byte_list> due;
        if (!was_answering && has_received_) {
            if (gap_ >= host_timing.t3_5) listener_.pause();
            if (gap_ > host_timing.visible_gap().us) due = listener_.silence(true);
        }
        server_.step();
        judge(due);
    }

    void judge(const std::optional<reference::byte_list>& due) {
        if (!port_.arrived.empty() || was_consumed()) gap_ = 0;
        if (due) {
            const byte_list pdu{due->begin() + 1, due->end() - 2};
            const bool writes = pdu[0] == 5 || pdu[0] == 6 || pdu[0] == 15 || pdu[0] == 16 || pdu[0] == 22;
            if ((*due)[0] != 0 || writes) {
                byte_list response = model_.respond(pdu);
                if ((*due)[0] != 0 && !response.empty()) {
                    response.insert(response.begin(), node_address);
                    expected_ = reference::framed(response);
                }
            }
        }
        // A response may begin and end in one step.
        if (!expected_.empty() && !server_.is_answering()) {
            require(port_.sent_bytes == expected_, "the response is the model's");
            port_.sent_bytes.clear();
            expected_.clear();
            listener_.responded();
            gap_ = 0;
        }
        const bool has_answered = server_.is_answering() || !port_.sent_bytes.empty();
        require(has_answered == !expected_.empty(), "G13 G14 exactly the frames that are due are executed");
    }
    bool was_consumed() {
        const bool is = consumed_ != port_.taken;
        consumed_ = port_.taken;
        has_received_ = has_received_ || is;
        return is;
    }

    static constexpr modbus::rtu_timing host_timing = modbus::timing_at(115200);
    fuzz::input* in_;
    byte_times::uart port_{};
    served_rows::values values_{};
    host_server server_{port_, values_, node_address, host_timing};
    row_model::model model_{with_room};
    reference::listener listener_{node_address, 4, true};
    byte_list expected_;
    std::size_t consumed_ = 0;
    std::uint32_t gap_ = 0;
    bool has_received_ = false;
};

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::input in{data, size};
    if (in.flag()) {
        host_bench{in}.run();
    } else {
        bench{in}.run();
    }
    return 0;
}
