// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A simulated drive where the judges want its subject.
// EXPECT: the subject lacks something: see sim::conformance_subject
// MEND: servobus::sim::conformance<winch::subject> kit{nullptr};
#include "../../examples/own_device/own_subject.hpp"

int main() {
    servobus::sim::conformance<winch::simulated> kit{nullptr}; // wrong
    return kit.singles().findings == 0 ? 0 : 1;
}
