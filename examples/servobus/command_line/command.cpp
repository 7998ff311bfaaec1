// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "command.hpp"

#include <string>

#include "../streams/messages.hpp"
#include "../words/nearest.hpp"

namespace tool {

const option* command::find(std::string_view option_name) const {
    for (const option& o : options) {
        if (o.name == option_name) return &o;
    }
    for (const option_group* group : shared) {
        for (const option& o : group->options) {
            if (o.name == option_name) return &o;
        }
    }
    return nullptr;
}

std::vector<std::string_view> command::option_names() const {
    std::vector<std::string_view> names;
    for (const option& o : options) names.push_back(o.name);
    for (const option_group* group : shared) {
        for (const option& o : group->options) names.push_back(o.name);
    }
    return names;
}

const command* command_table::find(std::string_view name) const {
    for (const command& c : all) {
        if (c.name == name) return &c;
    }
    return nullptr;
}

const command* command_table::require(std::string_view name) const {
    if (const command* c = find(name)) return c;
    std::vector<std::string_view> names;
    for (const command& c : all) names.push_back(c.name);
    complain(usage, "unknown command '" + std::string{name} + "'" +
                        did_you_mean(name, names, "; see servobus --help"));
    return nullptr;
}

} // namespace tool
