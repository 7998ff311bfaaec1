// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The library's server of rows with every function that it has, on a pseudo-terminal, until it is killed. It prints
// each register and each coil that a request has changed, one a line.   tables_server LINK
#include <cstdio>
#include <utility>

#include <servobus/posix/pseudo_terminal.hpp>
#include <servobus/server/host_row_server.hpp>

#include "tables.hpp"

using namespace servobus;

namespace {

constexpr identity about[]{
    {0, "Interop works"}, {1, "T-17"}, {2, "1.0"}, {4, "Four tables"}, {0x80, "its own"}};
constexpr char id[] = "tables";
constexpr char version[] = "T17 1.0"; // the additional data

template <class Values> class reported {
  public:
    explicit reported(const Values& values) : values_{&values} {
        for (unsigned i = 0; i < interop::count; ++i) words_[i] = interop::initial(interop::first + i);
        for (unsigned i = 0; i < interop::coils; ++i)
            coils_[i] = interop::initial_bit(interop::first_coil + i);
    }

    template <unsigned... Words, unsigned... Coils>
    void report(std::integer_sequence<unsigned, Words...>, std::integer_sequence<unsigned, Coils...>) {
        (note(words_[Words], values_->template get<interop::word<Words>>(), "%04X=%04X\n",
              interop::first + Words),
         ...);
        (note(coils_[Coils], values_->template get<interop::coil<Coils>>(), "coil %04X=%X\n",
              interop::first_coil + Coils),
         ...);
        (void)std::fflush(stdout);
    }

  private:
    static void note(unsigned& held, unsigned is, const char* words, unsigned address) {
        if (held == is) return;
        held = is;
        std::printf(words, address, is);
    }

    const Values* values_;
    unsigned words_[interop::count]{};
    unsigned coils_[interop::coils]{};
};

template <unsigned... Words, unsigned... Coils, unsigned... Inputs>
int serve(const char* link, std::integer_sequence<unsigned, Words...> words,
          std::integer_sequence<unsigned, Coils...> coils, std::integer_sequence<unsigned, Inputs...>) {
    using values_type = row_values<interop::word<Words>..., interop::input_word<Words>...,
                                   interop::coil<Coils>..., interop::input<Inputs>...>;
    posix::pseudo_terminal port;
    if (port.open(link) != errc::ok) return 1;
    values_type values;
    reported<values_type> changed{values};
    (values.template set<interop::word<Words>>(interop::initial(interop::first + Words)), ...);
    (values.template set<interop::input_word<Words>>(interop::initial(interop::first + Words)), ...);
    (values.template set<interop::coil<Coils>>(interop::initial_bit(interop::first_coil + Coils)), ...);
    (values.template set<interop::input<Inputs>>(interop::initial_bit(interop::first_input + Inputs)), ...);
    host_row_server<posix::pseudo_terminal, values_type, with_mask_write, with_read_write,
                    with_return_query_data, with_identification<about>, with_server_id<id, version>>
        server{port, values, interop::node_address, modbus::timing_at(interop::baud)};
    while (true) {
        port.wait(server.is_answering() ? microseconds(200) : milliseconds(5));
        server.step();
        changed.report(words, coils);
    }
}

} // namespace

int main(int, char** words) {
    return serve(words[1], std::make_integer_sequence<unsigned, interop::count>{},
                 std::make_integer_sequence<unsigned, interop::coils>{},
                 std::make_integer_sequence<unsigned, interop::inputs>{});
}
