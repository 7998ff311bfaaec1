// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A client closes every frame with the CRC engine of its line, which also checks the responses. The engine
// here has another polynomial than Modbus, so that a frame of any other engine is noticed on the wire, and it
// counts its calls.
#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

#include <servobus/line/blocking_line.hpp>
#include <tests/support/line_and_client.hpp>

#include <tests/support/scripted_port.hpp>

namespace line_engine_tests {

using namespace servobus;
using tests::byte_list;

namespace {

unsigned ends = 0; // of the engine's computations while the program runs

// CRC-16/MCRF4XX: the reflected polynomial 8408h.
struct other_engine {
    struct state {
        std::uint16_t crc;
    };
    static constexpr state begin() noexcept { return {0xFFFF}; }
    static constexpr state update(state s, std::uint8_t byte) noexcept {
        unsigned crc = s.crc ^ byte;
        for (int bit = 0; bit < 8; ++bit) crc = (crc & 1u) != 0 ? crc >> 1 ^ 0x8408u : crc >> 1;
        return {static_cast<std::uint16_t>(crc)};
    }
    static constexpr state update(state s, bytes all) noexcept {
        for (const std::uint8_t byte : all) s = update(s, byte);
        return s;
    }
    static constexpr std::uint16_t end(state s) noexcept {
        if (!__builtin_is_constant_evaluated()) ++ends; // clang 14 folds the function of C++23 to true
        return s.crc;
    }
};
static_assert(modbus::crc_engine<other_engine>);
static_assert(modbus::crc16<other_engine>(hex("31 32 33 34 35 36 37 38 39")) == 0x6F91); // the check value

// The same CRC, computed from the polynomial's other end: highest bit first, with the bytes and the result
// mirrored.
std::uint16_t other_crc(bytes data) {
    const auto mirrored = [](unsigned v, int bits) {
        unsigned m = 0;
        for (int i = 0; i < bits; ++i) m = m << 1 | (v >> i & 1u);
        return m;
    };
    unsigned crc = 0xFFFF;
    for (const std::uint8_t byte : data) {
        crc ^= mirrored(byte, 8) << 8;
        for (int i = 0; i < 8; ++i) crc = ((crc & 0x8000u) != 0 ? crc << 1 ^ 0x1021u : crc << 1) & 0xFFFFu;
    }
    return static_cast<std::uint16_t>(mirrored(crc, 16));
}

byte_list closed(byte_list body) {
    const std::uint16_t crc = other_crc(body);
    body.push_back(tests::low_byte(crc));
    body.push_back(tests::high_byte(crc));
    return body;
}
bool is_closed(const byte_list& frame) {
    return frame.size() > 2 && closed(byte_list(frame.begin(), frame.end() - 2)) == frame;
}

// A response of the Modbus drive, closed with the other CRC.
byte_list response_to(tests::register_file& file, const byte_list& request) {
    byte_list response = file.response_to(request);
    response.resize(response.size() - 2);
    return closed(std::move(response));
}

struct drive_type {
    static constexpr profile facts{.name = "drive"};
};
inline constexpr reg<u16, access::rw, drive_type> first{0x0010, full<u16>, no_unit, 0};
inline constexpr reg<u16, access::rw, drive_type> second{0x0011, full<u16>, no_unit, 0};
inline constexpr reg<u32, access::rw, drive_type> third{0x0012, full<u32>, no_unit, 0};
inline constexpr reg<u16, access::rw, drive_type> distant{0x0040, full<u16>, no_unit, 0};

struct small_rig {
    using line_type = blocking_line<tests::waiting_scripted_port, modbus::timing_at(115200),
                                    milliseconds(100), other_engine>;
    tests::waiting_scripted_port port;
    tests::register_file file;
    line_type on{port};

    small_rig() {
        file.words = {{0x10, 1}, {0x11, 1}, {0x12, 1}, {0x13, 1}, {0x40, 1}};
        port.device = [this](tests::scripted_port& p, const tests::sent_frame& f) {
            if (f.data[0] == 1 && is_closed(f.data)) p.say(500, response_to(file, f.data));
        };
    }
    std::vector<byte_list> frames() const {
        std::vector<byte_list> all{};
        for (const tests::sent_frame& f : port.frames) all.push_back(f.data);
        return all;
    }
};

// What a client needs of a line that polls: it passes the frame to the drive, and the response back.
struct plain_line {
    static constexpr bool is_small = false;
    using crc = other_engine;
    template <class, bool = false, bool = false, class = priority>
    using exchange_for = modbus::basic_exchange<other_engine>;
    static constexpr std::size_t longest_frame = modbus::max_frame;

    tests::register_file file;
    std::vector<byte_list> all{};
    modbus::rtu_timing times = modbus::timing_at(115200);

    plain_line() { file.words = {{0x10, 1}, {0x11, 1}, {0x12, 1}, {0x13, 1}, {0x40, 1}}; }
    const modbus::rtu_timing& timing() const { return times; }
    bool is_echo_ruled_out(std::uint8_t) const { return all.size() > 1; }
    static bool is_free() { return true; }
    static servobus::epoch epoch(std::uint8_t) { return {}; }
    void run(modbus::basic_exchange<other_engine>& x, bus_gaps) {
        const instant sent{1000};
        all.emplace_back(x.request().begin(), x.request().end());
        x.sent(sent);
        if (all.back()[0] == 1 && is_closed(all.back()))
            (void)x.feed(response_to(file, all.back()), sent + milliseconds(3));
        if (!x.done()) (void)x.elapse(sent + milliseconds(200));
    }
};
struct plain_rig {
    using line_type = plain_line;
    plain_line on;
    std::vector<byte_list> frames() const { return on.all; }
};

template <class Rig, class Node> void use(std::size_t expected) {
    Rig r;
    client<typename Rig::line_type, drive_type, Node> drive{r.on, Node{}};
    ends = 0;
    std::array<u16, 2> words{3, 4};
    CHECK(drive.template write<first>(7)); // and a read that rules out an echo
    CHECK(*drive.template read<first>() == 7);
    CHECK(drive.template write<second>(8));
    CHECK(drive.template write<third>(0x12345));
    CHECK(*drive.template read<third>() == 0x12345);
    CHECK((drive.template write<first, second>(9, 10)));
    CHECK((drive.template read<first, third>()));
    CHECK((drive.template read<first, distant>()));
    CHECK(drive.template write_if_different<second>(11));
    CHECK(drive.write_word(0x0011, 12));
    CHECK(drive.write_words(0x0010, words));
    CHECK(drive.read_words(0x0010, words).error() == errc::ok);
    CHECK(drive.read_words(0x0010, words, modbus::function::read_input_registers).error() == errc::ok);
    CHECK(drive.template broadcast<first>(13));
    CHECK(drive.template broadcast<third>(14));
    if constexpr (!Rig::line_type::is_small) {
        std::array<std::uint8_t, 4> pdu{};
        CHECK(drive.transact(hex("03 00 10 00 01"), pdu));
        CHECK(tests::byte_list(pdu.begin(), pdu.end()) == byte_list{3, 2, 0, 3});
    }
    CHECK(r.frames().size() == expected);
    for (const byte_list& frame : r.frames()) CHECK(is_closed(frame));
    CHECK(ends >= r.frames().size()); // but for constant requests, one for a request and one for its response
}

} // namespace

TEST_CASE("a client on a blocking line with its own engine uses no other") {
    use<small_rig, node<drive_type>>(19);
    use<small_rig, fixed_node<drive_type, 1>>(19);
}

TEST_CASE("a client closes each frame with the engine with which its line checks responses") {
    use<plain_rig, node<drive_type>>(20);
}

static_assert(std::is_same_v<small_rig::line_type::crc, other_engine>);
static_assert(
    std::is_same_v<blocking_line<tests::scripted_port, modbus::timing_at(9600)>::crc, modbus::default_crc>);
static_assert(std::is_same_v<line<tests::scripted_port>::crc, line<tests::scripted_port>::exchange::crc>);
static_assert(std::is_same_v<modbus::basic_exchange<other_engine>::crc, other_engine>);
// A frame of another engine by the public functions, for a bus of the program's own.
static_assert(modbus::read_frame<other_engine>(1, 0x10, 1).size == 8);
static_assert(modbus::crc16<other_engine>(modbus::read_frame<other_engine>(1, 0x10, 1)) == 0);
static_assert(modbus::crc16<other_engine>(modbus::write_frame<other_engine>(1, 0x10, 1)) == 0);
static_assert(modbus::crc16<other_engine>(modbus::write_frame<other_engine>(1, 0x10, {1, 2})) == 0);
static_assert(modbus::crc16<other_engine>(modbus::write_frame<other_engine>(1, 0x10,
                                                                            std::array<u16, 2>{1, 2})) == 0);

} // namespace line_engine_tests
