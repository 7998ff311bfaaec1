// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A model that looks for a row which its feedback does not have.
// EXPECT: the_row_is_not_one_of_this_block
// MEND: static constexpr std::uint8_t fault_at = servobus::image_of<zlac::left_faults>::place_of<zlac::left_faults>;
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

using namespace servobus;

struct model : zlac::model {
    using image = image_of<zlac::status_word, zlac::hall_state>;
    static constexpr std::uint8_t fault_at = image::place_of<zlac::left_faults>; // wrong
};

int main() { return sizeof(facade<model, line<some_port>>) == 0 ? 1 : 0; }
