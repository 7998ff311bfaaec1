// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The profile of a device as C++.
#pragma once

#include <string>

#include <servobus/registers/profile.hpp>

namespace tool::cpp {

/// The class `device` with the profile, of which it has what is not usual.
std::string device_class(const servobus::profile& facts);

} // namespace tool::cpp
