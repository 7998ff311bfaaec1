// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The profile of a device from the lines `# key = value` of its file.
#pragma once

#include <array>
#include <deque>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <servobus/registers/profile.hpp>

namespace tool {

/// A profile that owns its texts. It stays where it was made.
class owned_profile {
  public:
    owned_profile() = default;
    owned_profile(const owned_profile&) = delete;
    owned_profile& operator=(const owned_profile&) = delete;

    /// Takes a line without the `#`. Returns the reason why it is refused; empty if it is not.
    std::string take(std::string_view line);
    /// Must be called once, after the last line. Sets `key` to the key that the reason is about.
    std::string finish(std::string_view name_of_file, std::string& key);

    const servobus::profile& facts() const { return facts_; }
    /// True if values of the device have the low byte first in each word, where a row does not say otherwise. A word of
    /// 16 bits alone never has.
    bool is_low_byte_first() const { return is_low_byte_first_; }

  private:
    std::string set(const std::string& key, std::string_view value);
    static std::string set_yes_or_no(const std::string& key, std::string_view value, bool& fact);
    std::string set_block_writes(std::string_view value);
    std::string set_exception(std::string_view number, std::string_view words);

    servobus::profile facts_{.name = ""};
    bool is_low_byte_first_ = false;
    std::string name_{};
    std::deque<std::string> words_{};
    std::map<std::string, std::string, std::less<>> given_{};
    std::vector<servobus::exception_meaning> exceptions_{};
};

} // namespace tool
