// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A model that does not say after which commands positions count from elsewhere. Its drive has none.
// EXPECT: which commands have a new origin is stated
// MEND: inline constexpr auto kinds = servobus::command_kinds<effect>{}
//     .of(servobus::command_kind::other, effect::none)
//     .of(servobus::command_kind::move, effect::moved)
//     .with_new_origin();
#include <servobus/device/zlac8015d.hpp>

#include "program.hpp"

using namespace servobus;

enum class effect : std::uint8_t { none, moved, end };
struct own_command : zlac::prepared_command {
    effect then = effect::none;
};
struct model : zlac::model {
    using prepared_command = own_command;
    static constexpr auto kinds = command_kinds<effect>{} // wrong
                                      .of(command_kind::other, effect::none)
                                      .of(command_kind::move, effect::moved);
};

int main() { return sizeof(facade<model, line<some_port>>) == 0 ? 1 : 0; }
