// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The winch of the example under the judges of sim/conformance.hpp: command, mishaps and requests from the fuzzer. A
// target for a drive of one's own is these lines with its own subject.
#include "../examples/own_device/own_subject.hpp"

#include "support.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    servobus::sim::conformance<winch::subject> kit{
        [](void*, const servobus::sim::finding& f) { fuzz::require(false, f.what); }};
    (void)kit.from({data, size});
    return 0;
}
