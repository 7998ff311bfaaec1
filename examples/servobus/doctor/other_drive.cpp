// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "other_drive.hpp"

#include <array>

#include "../devices/devices.hpp"
#include "../devices/identity.hpp"
#include "../registers/at_rest.hpp"

namespace tool::diagnosis {

bool explain_other_drive(report& to, session& on, const target& of, const std::string& what) {
    const auto look = [&on](u16 address) {
        std::array<u16, 1> word{};
        const servobus::status why = read_words(on, address, word);
        const auto is = why.has_response() ? servobus::presence::present : servobus::presence::no_response;
        return servobus::finding{is, is_ok(why), word[0], why};
    };
    const char* const name = name_of_drive(of.node, look).name;
    const device* const other = name != nullptr ? find_device_quietly(name) : nullptr;
    if (other == nullptr || other == of.kind) return false;
    const std::string named =
        of.kind->file != nullptr ? "what " + of.kind->word() + " describes" : "a " + of.kind->word();
    to.refuse(what + ": perhaps it is a " + name + ", not " + named,
              to.command_for(name + (':' + std::to_string(of.node)), "doctor"));
    return true;
}

} // namespace tool::diagnosis
