// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A model whose check before a step has a misspelt name, and would never be called.
// EXPECT: a model defines `permit` or names it in `leaves_out`: one of them
// MEND: static constexpr servobus::errc permit(const zlac::prepared_command&, const std::uint16_t*,
//                                       const zlac::cached_settings&);
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

using namespace servobus;

struct model : zlac::model {
    static constexpr model_parts leaves_out{model_part::slower,
                                            model_part::positions,
                                            model_part::stops_after_restart,
                                            model_part::disable_replaces_quick_stop,
                                            model_part::moves_when_enabled,
                                            model_part::grant,
                                            model_part::grant_at_most};
    static constexpr errc permits(const zlac::prepared_command&, const std::uint16_t*,
                                  const zlac::cached_settings&) {
        return errc::ok;
    } // wrong
};

int main() { return sizeof(facade<model, line<some_port>>) == 0 ? 1 : 0; }
