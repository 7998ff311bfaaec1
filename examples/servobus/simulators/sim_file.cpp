// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus sim FILE
#include "../devices/device.hpp"
#include "file_model.hpp"
#include "served.hpp"
#include "simulators.hpp"

namespace tool {

int simulate_file(const device& of, const simulation& wanted) {
    file_model model{of, wanted.node, wanted.baud};
    return served<file_model, file_server>{model, wanted}.run(wanted.link);
}

} // namespace tool
