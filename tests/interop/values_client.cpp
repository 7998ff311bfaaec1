// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The library's client with a server of values.hpp. It notes each value that it writes in a file, a line each, which is
// compared with the output of the server.   values_client DEVICE FILE
#include <cstdio>
#include <string>

#include <servobus/any_value.hpp>
#include <servobus/posix/serial.hpp>
#include <servobus/servobus.hpp>

#include "registers.hpp"
#include "report.hpp"
#include "values.hpp"

using namespace servobus;
using interop::check;

namespace {

template <word_order Order> struct device {
    static constexpr profile facts{.name = "values", .word_order = Order, .baud = interop::baud};
};
template <word_order Order, unsigned Behind> struct rows {
    static constexpr unsigned base =
        (Order == word_order::high_first ? interop::high_first_block : interop::low_first_block) + Behind;
    template <class T> using rw = reg<T, access::rw, device<Order>>;
    template <class T> static constexpr rw<T> at(unsigned place) {
        return {static_cast<u16>(base + place), full<T>, no_unit, no_default};
    }
    static constexpr rw<servobus::f32> single = at<servobus::f32>(interop::f32_at);
    static constexpr rw<servobus::f64> twice = at<servobus::f64>(interop::f64_at);
    static constexpr rw<servobus::u32> natural = at<servobus::u32>(interop::u32_at);
    static constexpr rw<servobus::i32> integer = at<servobus::i32>(interop::i32_at);
    static constexpr rw<servobus::u64> counter = at<servobus::u64>(interop::u64_at);
    static constexpr rw<servobus::i64> balance = at<servobus::i64>(interop::i64_at);
    static constexpr rw<with<servobus::f32, low_byte_first>> swapped =
        at<with<servobus::f32, low_byte_first>>(interop::swapped_at);
    static constexpr rw<text_of<4>> name = at<text_of<4>>(interop::text_at);
};

template <word_order Order> void exchange(line<posix::serial>& wire, std::FILE* notes) {
    client io{wire, node<device<Order>>{interop::node_address}};
    const std::string of = Order == word_order::high_first ? "high word first: " : "low word first: ";
    constexpr const interop::value_set& expected = interop::read_values;
    using r = rows<Order, 0>;
    for (int tries = 0; tries < 20 && !io.template read<r::natural>(); ++tries) {}
    const auto all = io.template read<r::single, r::twice, r::natural, r::integer, r::counter, r::balance,
                                      r::swapped, r::name>();
    check(all && all->is_one_frame, of + "all values come in one frame");
    if (!all) return;
    check(all->template get<r::single>().value() == expected.f32, of + "f32");
    check(all->template get<r::twice>().value() == expected.f64, of + "f64");
    check(all->template get<r::natural>() == expected.u32, of + "u32");
    check(all->template get<r::integer>() == expected.i32, of + "i32");
    check(all->template get<r::counter>() == expected.u64, of + "u64");
    check(all->template get<r::balance>() == expected.i64, of + "i64");
    check(all->template get<r::swapped>().value() == expected.swapped, of + "f32, low byte first");
    check(all->template get<r::name>() == expected.text, of + "text");
    check(io.template read<r::counter>() && *io.template read<r::counter>() == expected.u64,
          of + "u64 alone");

    using w = rows<Order, interop::written_behind>;
    constexpr const interop::value_set& wanted = interop::written_values;
    const char* const order = Order == word_order::high_first ? "high" : "low";
    const auto note = [&](const status& how, const char* what, const char* value) {
        check(how.error() == errc::ok, of + what + " is written");
        (void)std::fprintf(notes, "%s %s %s\n", order, what, value);
    };
    char text[40];
    const auto shown = [&](const char* format, auto value) {
        (void)std::snprintf(text, sizeof text, format, value);
        return text;
    };
    note(io.template write<w::single>(wanted.f32), "f32", shown("%.9g", static_cast<double>(wanted.f32)));
    note(io.template write<w::twice>(wanted.f64), "f64", shown("%.17g", wanted.f64));
    note(io.template write<w::natural>(wanted.u32), "u32",
         shown("%lu", static_cast<unsigned long>(wanted.u32)));
    note(io.template write<w::integer>(wanted.i32), "i32", shown("%ld", static_cast<long>(wanted.i32)));
    note(io.template write<w::counter>(wanted.u64), "u64",
         shown("%llu", static_cast<unsigned long long>(wanted.u64)));
    note(io.template write<w::balance>(wanted.i64), "i64", shown("%lld", static_cast<long long>(wanted.i64)));
    note(io.template write<w::swapped>(wanted.swapped), "swapped",
         shown("%.9g", static_cast<double>(wanted.swapped)));
    note(io.template write<w::name>(checked(wanted.text)), "text", wanted.text);
}

} // namespace

int main(int, char** words) {
    posix::serial port;
    std::FILE* const notes = std::fopen(words[2], "w");
    if (notes == nullptr || port.open(words[1], {.baud = interop::baud}) != errc::ok) return 1;
    line wire{port, modbus::timing_at(interop::baud)};
    exchange<word_order::high_first>(wire, notes);
    exchange<word_order::low_first>(wire, notes);
    (void)std::fclose(notes);
    return interop::failed == 0 ? 0 : 1;
}
