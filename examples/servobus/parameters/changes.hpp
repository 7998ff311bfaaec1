// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The changes that restore and apply make to a drive's parameters, with everything that must hold before and after a
// write. Only a register that differs is written, once, and it is read back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "../devices/device.hpp"
#include "parameters.hpp"

namespace tool {

/// A register that holds something else than it should.
struct change {
    const servobus::entry* row;
    std::vector<u16> before; ///< in the order of row_words.hpp
    std::vector<u16> after;
};

std::string name_of(const servobus::entry& e);
/// Refuses a device of a file if something of it moves: the file does not say how to see that it is at rest. Returns
/// `done`, or the exit status after a complaint.
int refuse_moving(const device& of, const char* verb);
/// True for the address, the rate and the format of a drive: as these are written, the drive may be gone.
bool is_of_line(const device& of, const servobus::entry& e);

/// How a command changes parameters.
struct change_rules {
    const char* verb;      ///< the command, in complaints
    bool is_dry = false;   ///< nothing is written: what refuses is a warning
    bool saves = false;    ///< a save follows, where the drive has a command for it
    bool in_parts = false; ///< of more than the drive stores without an alarm, the first are written
    std::string drive{};   ///< in front of what is printed: `lift.`
};

/// The changes of one drive. In this order: `look_for_rest`, `compare`, `say_cost`, then `write`. Each returns `done`,
/// or the exit status after a complaint, and has written nothing unless it says so.
class changes {
  public:
    changes(session& on, const target& of, const change_rules& rules) : on_{&on}, of_{&of}, rules_{rules} {}

    /// Refused while the drive is enabled or moves; a warning for one that is dry.
    int look_for_rest() { return look_for_rest(rules_.is_dry); }
    /// Reads what `wanted` names and keeps what differs. Each has a number, and none is there twice.
    int read_differences(std::vector<parameter> wanted);
    /// The same, in an order in which no two terminals have a function at once.
    /// Refuses what clashes with the drive's other terminals.
    int compare(std::vector<parameter> wanted);
    /// Says what the changes cost: writes into the EEPROM, terminals that may become active. Refused if they are more
    /// than the drive stores without an alarm.
    int say_cost();
    /// Writes all but what sets the line. Says what has been written if it ends early.
    int write();
    /// Commands the drive to keep what was written. Of a drive without such a command it is done already.
    int save();

    /// Prints a line for each, `max_current=2.8 A -> 3.0 A`.
    void print() const;
    /// Leaves all but the first ones as they are.
    void keep_first(std::size_t count) { all_.resize(count < all_.size() ? count : all_.size()); }
    const std::vector<change>& all() const { return all_; }
    /// How many registers differ; `all` may change one of them in two steps.
    std::size_t differing() const { return differing_; }

  private:
    int look_for_rest(bool only_says_so);
    void release_first();
    void line_last();
    int look_for_clash();
    int count_stores();
    int refuse_too_many(std::size_t& stored);
    void cut_to(std::size_t most);
    int carry_out(const change& c);
    int look_after(const std::string& name);
    int stop_at(std::string why, bool is_unknown = false) const;

    session* on_;
    const target* of_;
    change_rules rules_;
    std::vector<change> all_{};
    std::size_t differing_ = 0;
    std::size_t written_ = 0;
};

} // namespace tool
