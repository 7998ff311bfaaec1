// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A regular file that one program at a time appends to: what log_file asks the operating system for.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace tool {

class locked_file {
  public:
    locked_file() = default;
    locked_file(const locked_file&) = delete;
    locked_file& operator=(const locked_file&) = delete;
    ~locked_file() { close(); }

    /// Opens or makes a file and locks it. A folder, a device, a pipe and a link to nothing are refused. Returns why
    /// it could not, or nothing.
    std::string open(const std::string& path);
    void close();
    /// Closes it and removes its name.
    void remove();

    /// False if it was there before.
    bool is_made_here() const { return is_made_here_; }
    /// Bytes; none if the system does not tell.
    std::optional<std::uint64_t> size() const;
    /// False unless all of `to` could be read, from the byte `at` on.
    bool read(std::uint64_t at, std::span<char> to) const;
    /// In one write, unless the system takes only a part of it. Returns why it could not, or nothing.
    std::string append(std::string_view text);
    /// True if the file has been cut back to `size`.
    bool cut(std::uint64_t size);

  private:
    static constexpr std::intptr_t none = -1;

    std::string path_{};
    std::intptr_t file_ = none; // a descriptor, or a handle of Windows
    bool is_made_here_ = false;
};

} // namespace tool
