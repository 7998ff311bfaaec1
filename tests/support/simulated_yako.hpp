// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A simulated YAKOTEC stepper on a virtual line. If a test asks for it, the shaft drives a machine with
// switches.
#pragma once

#include <servobus/sim/yako.hpp>

#include "simulated_model.hpp"

namespace simulated {

/// Eight turns between the limits, with the home switch around the middle and hard stops a turn beyond.
inline servobus::sim::yako_machine yako_slide() {
    servobus::sim::yako_machine m;
    m.negative_stop = -5000;
    m.negative_limit = -4000;
    m.home_from = -250;
    m.home_to = 250;
    m.positive_limit = 4000;
    m.positive_stop = 5000;
    m.index = 100;
    return m;
}

/// `Model` is `sim::yako_closed_loop` or `sim::yako_open_loop`.
template <class Model> using simulated_yako = simulated_model<Model, servobus::sim::yako_options, 115200>;

using simulated_closed_loop = simulated_yako<servobus::sim::yako_closed_loop>;
using simulated_open_loop = simulated_yako<servobus::sim::yako_open_loop>;

} // namespace simulated
