// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A drive or another device as the tool has it: its map, and what the commands do with it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <servobus/control/advice.hpp>
#include <servobus/core/result.hpp>
#include <servobus/registers/catalogue.hpp>
#include <servobus/registers/line_choices.hpp>

#include "../interpretations/findings.hpp"

namespace tool {

using servobus::u16;
using servobus::u32;

// The functions of a device get these. Only they and their callers need more than the name.
struct simulation;
class session;
class probe_bench;
namespace diagnosis {
struct examination;
}

/// The rest of a drive, in which its parameters may be changed; else what disturbs it.
struct repose {
    servobus::status why{}; ///< why it could not be read
    std::string unrest{};   ///< what is enabled or moves; empty if nothing is
};

/// The command that keeps a drive's parameters over a power cycle.
struct save_command {
    u16 address;
    u16 value;
    u16 cleared_first = 0; ///< a register that must read 0 when it is given; 0: none
};

/// A position that turns with a shaft by hand.
struct turned_shaft {
    const char* name;       ///< `left`
    u16 position;           ///< its register
    std::int64_t counts;    ///< of a turn, as the drive's settings say; 0: they do not
    const char* where_said; ///< `4 x left_encoder_lines`
};
struct turned_shafts {
    servobus::status why{}; ///< why its settings could not be read
    std::vector<turned_shaft> all{};
};

/// A row of a drive's table of alarms.
struct alarm_row {
    std::string code; ///< as the drive shows or reports it
    const char* kind;
    const char* resettable; ///< yes, no, or unstated
    const char* name;
    servobus::advice what;
};

/// A drive that the tool knows, or a device from a file. The four functions after the map are null for a file.
struct device {
    const servobus::catalogue* map = nullptr;
    int (*simulate)(const simulation&) = nullptr;
    std::vector<alarm_row> (*alarms)() = nullptr;
    repose (*at_rest)(session&) = nullptr;
    bool (*stops)(u16 address, u16 word) = nullptr;  ///< a write that stops the motor and does nothing else
    std::optional<save_command> save = std::nullopt; ///< none: every write is kept
    int (*number)(std::string_view) = nullptr;       ///< the address of a parameter number
    unsigned most_stored = 0;                        ///< writes into the EEPROM without an alarm; 0: any
    bool (*excludes)(u16 one, u16 other) = nullptr;  ///< registers that may not both hold a word above 0
    /// Where its manual can be read in several ways; none if nothing is known of that.
    std::span<const interpretation> interpretations{};
    /// Settles them on a real drive that is at rest; null where nothing does.
    void (*probe)(probe_bench&, findings&) = nullptr;
    u16 version_register = 0; ///< of its firmware; 0: none
    /// Null: it does not count what is turned by hand.
    turned_shafts (*turning)(session&) = nullptr;
    /// Where its rate and format are set; null: nothing says it.
    const servobus::line_choices* on_line = nullptr;
    u16 node_register = 0; ///< where its address is set; 0: nothing says it
    /// The checks of `doctor`; null: those of any device.
    const diagnosis::examination* examination = nullptr;
    bool has_watchdog = true;   ///< any request may feed it; false: it has none. A file does not say it
    const char* file = nullptr; ///< its path; null for a drive that the tool knows
    bool has_flags = true;      ///< false: nothing says which registers move a machine
    /// Points to the tables of a file, in the order of `servobus::table`; null for a drive that the tool knows, whose
    /// rows are all in `map`.
    const servobus::catalogue* tables = nullptr;

    const servobus::profile& facts() const { return *map->device; }
    /// The rows of a table; a drive that the tool knows has those of holding registers alone.
    std::span<const servobus::entry> rows_of(servobus::table t) const {
        if (tables != nullptr) return tables[static_cast<std::size_t>(t)].entries;
        return t == servobus::table::holding_registers ? map->entries : std::span<const servobus::entry>{};
    }
    const char* sentence(const servobus::entry& of, servobus::table t) const {
        return (tables != nullptr ? tables[static_cast<std::size_t>(t)] : *map).sentence(of);
    }
    /// The row that scales another one; null if none does.
    const servobus::entry* scaling_row(const servobus::entry& of) const {
        if (of.form == nullptr || of.form->scaled == servobus::scaling::none) return nullptr;
        return servobus::catalogue{nullptr, rows_of(of.form->scale_table)}.find(of.form->scale_address);
    }
    /// As the command line names it: its name, or the path of its file.
    std::string word() const { return file != nullptr ? file : facts().name; }
    /// True for a write that stops the motor and does nothing else.
    bool is_stop(u16 address, u16 word) const { return stops != nullptr && stops(address, word); }
    /// The name of a register, and its address.
    std::string display_name(u16 address) const;
};

inline constexpr servobus::table all_tables[] = {servobus::table::coils, servobus::table::discrete_inputs,
                                                 servobus::table::holding_registers,
                                                 servobus::table::input_registers};

} // namespace tool
