// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Stands in for pluginlib's macro (pluginlib 5, Humble; the same in Jazzy): the class must have the base and be made by
// `new` without arguments, and a test gets it as the class loader would.
#pragma once

#include <memory>

namespace stand_in {
/// Makes the exported class; the unit that exports it defines this.
template <class Base> std::unique_ptr<Base> make_plugin();
} // namespace stand_in

#define PLUGINLIB_EXPORT_CLASS(class_type, base_class_type)                                                  \
    template <> std::unique_ptr<base_class_type> stand_in::make_plugin<base_class_type>() {                  \
        return std::unique_ptr<base_class_type>{new class_type};                                             \
    }
