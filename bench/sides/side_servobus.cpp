// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The operations as a program does them with the library. A transaction is a call of the client, with
// everything that the line handles: gaps, unexpected bytes, quarantine, time limits, a stopped clock.
#include <algorithm>
#include <array>
#include <iterator>
#include <span>

#include <servobus/client/client.hpp>

#include "../operations.hpp"

namespace bench {
namespace {

namespace sb = servobus;
using namespace servobus::modbus;

struct memory_port {
    memory_wire wire{};

    sb::transfer send(sb::bytes out) {
        return static_cast<std::uint16_t>(wire_send(&wire, out.data(), out.size()));
    }
    bool sent() { return true; }
    sb::transfer receive(sb::byte_buffer in) {
        return static_cast<std::uint16_t>(wire_receive(&wire, in.data(), in.size()));
    }
    sb::instant now() { return {wire_now(&wire)}; }
};

struct device {
    static constexpr sb::profile facts{.name = "bench"};
};
template <std::uint16_t Address>
inline constexpr sb::reg<sb::u16, sb::access::rw, device> row{Address, sb::full<sb::u16>, sb::no_unit, 0};

struct session {
    memory_port port;
    sb::line<memory_port, sb::unobserved> wire{port, timing_at(115200)};
    sb::client<sb::line<memory_port, sb::unobserved>, device> client{wire, sb::node<device>{1}};
};

void open(task& t) {
    alignas(session) static std::byte place[sizeof(session)];
    auto* const s = new (place) session;
    // A first read, as in a running program: after a write the client would otherwise read once, in case the
    // response is an echo.
    constexpr std::uint8_t answer[] = {0x01, 0x03, 0x02, 0x00, 0x00, 0xB8, 0x44};
    std::ranges::copy(answer, s->port.wire.response);
    s->port.wire.response_size = std::size(answer);
    s->port.wire.clock += 1'000'000;
    const frame<8> request = read_frame(1, 0x20A0, 1);
    std::array<std::uint8_t, 7> response{};
    exchange x{request, response, s->wire.timing(), s->client.node().limits};
    s->wire.run(x, s->client.node().gaps);
    t.wire = &s->port.wire;
    t.session = s;
}
session& session_of(task& t) { return *static_cast<session*>(t.session); }

sb::byte_buffer pdu_of(task& t) { return sb::byte_buffer{t.frame}.subspan(1); }

void build_write(task& t) {
    t.frame[0] = t.node_address;
    t.frame_size = close_frame(t.frame, put_write_request(pdu_of(t), t.address, t.value));
    t.ok = t.frame_size != 0;
}
void build_read(task& t) {
    constexpr function code = function::read_holding_registers;
    t.frame[0] = t.node_address;
    t.frame_size = close_frame(t.frame, put_read_request(pdu_of(t), code, t.address, 10));
    t.ok = t.frame_size != 0;
}
void build_write_many(task& t) {
    t.frame[0] = t.node_address;
    t.frame_size = close_frame(t.frame, put_write_request(pdu_of(t), t.address, t.values));
    t.ok = t.frame_size != 0;
}

bool parsed(sb::bytes frame, std::uint8_t node_address, std::span<std::uint16_t> words) {
    const sb::result<opened> f = open_frame(frame);
    if (!f || f->address != node_address) return false;
    const sb::result<response> r = parse_response(f->pdu);
    if (!r || r->code != 0x03 || r->is_exception || r->quantity != words.size()) return false;
    r->values().copy_to(words);
    return true;
}
void parse(task& t) { t.ok = parsed(sb::bytes{t.frame}.first(t.frame_size), t.node_address, t.words); }

void write(task& t) {
    t.ok = static_cast<bool>(session_of(t).client.write<row<0x20A0>>(sb::checked(t.value)));
}
void read_many(task& t) {
    t.ok = session_of(t).client.read_words(t.address, t.words).error() == sb::errc::ok;
}
void write_many(task& t) { t.ok = static_cast<bool>(session_of(t).client.write_words(t.address, t.values)); }

} // namespace

const side servobus_side{"servobus", open,  build_write, build_read, build_write_many,
                         parse,      write, read_many,   write_many};

} // namespace bench
