// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus, the command-line tool: what its files share. Every command returns its exit status and writes at
// most one line of complaint.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <servobus/control/advice.hpp>
#include <servobus/core/result.hpp>
#include <servobus/registers/catalogue.hpp>
#include <servobus/registers/line_choices.hpp>
#include <servobus/sim/faults.hpp>

#include "probe/findings.hpp"

namespace tool {

using servobus::u16;
using servobus::u32;

// Exit statuses.
inline constexpr int done = 0;
inline constexpr int failed = 1; // refused, unknown, no response, no such port
inline constexpr int usage = 2;  // bad input; nothing was sent

/// Writes `servobus: message` to standard error and returns `status`.
int complain(int status, const std::string& message);
/// As above, for a note or a warning.
void note(const std::string& message);
/// How many complaints and notes were written.
std::size_t note_count();

std::string hex_word(u16 word);
/// `1 write`, `2 writes`.
std::string counted(std::size_t n, const char* thing);
/// A whole number, decimal or 0x…; nothing else may stand around it.
std::optional<std::int64_t> parse_integer(std::string_view text);
/// An address as programs or manuals write it: 0x2088, 8328, 2088h.
std::optional<std::int64_t> parse_address(std::string_view text);

struct command;

/// What a command is asked for: words, and options with or without a value.
class arguments {
  public:
    /// The words after the command's name. Complains by itself, also about an option that `of` does not have.
    static std::optional<arguments> parse(std::span<char* const> words, const command& of);

    const std::vector<std::string>& words() const { return words_; }
    bool has(std::string_view name) const { return find(name) != nullptr; }
    const char* text(std::string_view name) const;
    /// The option's number, or `otherwise` if it is not given. Complains by itself.
    std::optional<std::int64_t> number(std::string_view name, std::int64_t low, std::int64_t high,
                                       std::int64_t otherwise) const;
    /// `off` if it is not given. Complains by itself.
    std::optional<bool> on_or_off(std::string_view name) const;

  private:
    const std::string* find(std::string_view name) const;

    std::vector<std::string> words_;
    std::map<std::string, std::string, std::less<>> options_;
};

/// How a simulator is asked for.
struct simulation {
    std::uint8_t node = 1;
    std::uint32_t baud = 0;
    std::uint64_t seed = 1;
    servobus::sim::fault_plan faults{};
    /// What the other end sends comes back to it, as from an adapter that receives what it sends.
    bool echoes = false;
    bool has_strict_rate = false; ///< no response at another rate than its own
    const char* link = nullptr;
    /// A number for each interpretation of the device; none: the simulator's own.
    std::vector<unsigned> ways{};
};

class session;
class probe_bench;
namespace diagnosis {
struct examination;
}

/// Whether a drive's parameters may be changed now.
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
    const char* sentence(u16 address, servobus::table t) const {
        return (tables != nullptr ? tables[static_cast<std::size_t>(t)] : *map).sentence(address);
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

/// The drives that the tool knows, by their names, without those of files. Each registers itself: see
/// devices/registered_drive.hpp.
std::span<const device> devices();
/// The drive of that name, or the device of a file; a word with `.csv` or `/` is a file's path. The same word is the
/// same device. Complains by itself.
const device* find_device(std::string_view word);
/// As above, but sets `why` in place of a complaint.
const device* find_device(std::string_view word, std::string& why);
/// As above, but null without a reason.
const device* find_device_quietly(std::string_view word);

/// A row to ask whether a device responds; null if none can be read.
struct asked_row {
    const servobus::entry* row = nullptr;
    servobus::table in = servobus::table::holding_registers;
};
/// The register of its address, else the first row that can be read.
asked_row first_readable(const device& of);

/// DEVICE[:NODE] in its parts. The colon of `C:/meter.csv` is none before a node.
struct device_word {
    std::string_view name;
    std::optional<std::string_view> node{};
};
device_word split_device(std::string_view text);

/// A line that a person types on standard input, after a question on standard error; empty at its end.
std::string answer_to(const std::string& question);
/// Returns `done` with `--yes`, or once a person has typed `verb`; else complains by itself.
int ask_consent(const arguments& asked, const std::string& verb, const char* to_do = "write",
                const char* refusal = "not confirmed, nothing was written");

// The commands, one a file of commands/. Their options are those of their rows in commands.cpp.
int map(const arguments& asked);
int explain(const arguments& asked);
int simulate(const arguments& asked);
int read(const arguments& asked);
int write(const arguments& asked);
int scan(const arguments& asked);
int watch(const arguments& asked);
int alarms(const arguments& asked);
int backup(const arguments& asked);
int restore(const arguments& asked);
int apply(const arguments& asked);
int diff(const arguments& asked);
int turn(const arguments& asked);
int probe(const arguments& asked);
int listen(const arguments& asked);
int doctor(const arguments& asked);
int header(const arguments& asked);
int completion(const arguments& asked);
int manual(const arguments& asked);

} // namespace tool
