// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The interpretations of each manual for the judges of sim/conformance.hpp, by number. 0 is the simulated drive's
// default. Then follow each position of each switch alone, and all that the field has shown together. The last ones
// contain every pair of positions.
#pragma once

#include <vector>

#include <servobus/sim/yako/options.hpp>

#include <tests/support/c630s_interpretations.hpp>
#include <tests/support/interpretations.hpp>
#include <tests/support/yako_interpretations.hpp>
#include <tests/support/zlac8015d_interpretations.hpp>

namespace subjects {

using ::interpretations::choice;

/// `Manual` has the switches of a simulated drive, which of them are the field's, and how many interpretations are the
/// default and each switch alone. All of the field's together are the next one, where there are any.
template <class Manual> struct interpretations {
    static constexpr unsigned count =
        Manual::alone; // for the runs that the judges themselves spread over all
    static const std::vector<choice>& choices() {
        static const std::vector<choice> found =
            ::interpretations::all_pairs(Manual::switches(), Manual::first_of_field());
        return found;
    }
    static auto options(unsigned interpretation) { return Manual::options_of(choices()[interpretation]); }
    static unsigned alone() {
        unsigned sum = 1;
        for (const unsigned positions : Manual::switches()) sum += positions - 1;
        return sum;
    }
    static unsigned alone_and_field() {
        return alone() + (Manual::first_of_field() < Manual::switches().size() ? 1 : 0);
    }
};

struct zlac8015d_manual {
    static constexpr unsigned alone = 19;
    static std::vector<unsigned> switches() { return zlac8015d_interpretations::switches(); }
    static std::size_t first_of_field() { return zlac8015d_interpretations::sizes.size(); }
    static auto options_of(const choice& c) { return zlac8015d_interpretations::options_of(c); }
};

struct yako_manual {
    static constexpr unsigned alone = 24;
    static std::size_t first_of_field() { return switches().size(); } // no Modbus program of one was found
    /// Those of the safety scenes, and three that requests of the judges reach: a damaged request, a read of a command
    /// register, and a restart after a restored EEPROM.
    static std::vector<unsigned> switches() {
        std::vector<unsigned> all = ::interpretations::yako_switches;
        all.insert(all.end(), 3, 2u);
        return all;
    }
    static auto options_of(const choice& c) {
        servobus::sim::yako_options o = ::interpretations::yako_options_of(c);
        const std::size_t own = ::interpretations::yako_switches.size();
        o.answers_bad_crc = c[own] != 0;
        o.commands_read_back = c[own + 1] != 0;
        o.rescales_feedback_only = c[own + 2] != 0;
        return o;
    }
};

struct c630s_manual {
    static constexpr unsigned alone = 25;
    static std::vector<unsigned> switches() { return c630s_interpretations::switches(); }
    static std::size_t first_of_field() { return c630s_interpretations::detail::sizes.size(); }
    static auto options_of(const choice& c) { return c630s_interpretations::options_of(c); }
};

} // namespace subjects
