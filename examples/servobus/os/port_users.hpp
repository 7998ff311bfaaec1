// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Linux: what the system knows of a serial device besides its port: which programs have it open, and how long its USB
// adapter keeps what it has received. The systems that do not tell have no users and no timer. Header-only, so that a
// test gives it a root folder of its own.
#pragma once

#include <optional>
#include <string>
#include <vector>

#ifdef __linux__
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>
#endif

namespace tool::os {

/// A program that has a device open.
struct port_user {
    long pid = 0;
    std::string name; ///< as `ps` shows it; empty if it is not known
};

/// "minicom (process 1234)"
inline std::string text_of(const port_user& u) {
    return (u.name.empty() ? "a program" : u.name) + " (process " + std::to_string(u.pid) + ")";
}

/// The timer of a USB adapter, and the file that sets it.
struct latency_timer {
    std::string path;
    unsigned ms = 0;
};

#ifndef __linux__
inline std::vector<port_user> users_of(const std::string&, const std::string& = "") { return {}; }
inline std::optional<latency_timer> latency_of(const std::string&, const std::string& = "") { return {}; }
#else

namespace detail {

namespace fs = std::filesystem;

inline std::string first_line(const fs::path& file) {
    std::ifstream in{file};
    std::string line;
    (void)std::getline(in, line);
    return line;
}

inline std::vector<fs::path> entries_of(const fs::path& folder) {
    std::error_code failed;
    std::vector<fs::path> all;
    for (fs::directory_iterator at{folder, failed}, end; !failed && at != end; at.increment(failed))
        all.push_back(at->path());
    return all;
}

// True if one of its descriptors is the device, and none is the other side of a pseudo-terminal: who serves the
// device is no second client. Descriptors of other users cannot be seen.
inline bool has_open(const fs::path& process, const struct stat& device) {
    bool is_found = false;
    for (const fs::path& fd : entries_of(process / "fd")) {
        std::error_code failed;
        if (fs::read_symlink(fd, failed).string().find("ptmx") != std::string::npos) return false;
        struct stat of {};
        if (::stat(fd.c_str(), &of) == 0 && S_ISCHR(of.st_mode) && of.st_rdev == device.st_rdev)
            is_found = true;
    }
    return is_found;
}

// The owners of locks on the device: every user sees those of all programs.
inline std::vector<long> lock_owners(const fs::path& list, const struct stat& device) {
    char wanted[64];
    (void)std::snprintf(wanted, sizeof wanted, "%02x:%02x:%llu", ::major(device.st_dev),
                        ::minor(device.st_dev), static_cast<unsigned long long>(device.st_ino));
    std::vector<long> owners;
    std::ifstream in{list};
    for (std::string line; std::getline(in, line);) {
        std::istringstream words{line};
        std::string number, kind, mode, access, owner, file;
        words >> number >> kind >> mode >> access >> owner >> file;
        if (kind == "FLOCK" && file == wanted) owners.push_back(std::atol(owner.c_str()));
    }
    return owners;
}

} // namespace detail

/// The programs that have the device open, without this one and without the one that serves a pseudo-terminal. `root`:
/// in front of /proc.
inline std::vector<port_user> users_of(const std::string& path, const std::string& root = "") {
    namespace fs = std::filesystem;
    struct stat device {};
    if (::stat(path.c_str(), &device) != 0 || !S_ISCHR(device.st_mode)) return {};
    const fs::path processes = root + "/proc";
    const std::vector<long> owners = detail::lock_owners(processes / "locks", device);
    std::vector<port_user> users;
    for (const fs::path& process : detail::entries_of(processes)) {
        const std::string name = process.filename().string();
        if (name.find_first_not_of("0123456789") != std::string::npos) continue;
        const long pid = std::atol(name.c_str());
        if (pid == static_cast<long>(::getpid())) continue;
        const bool has_lock = std::find(owners.begin(), owners.end(), pid) != owners.end();
        if (has_lock || detail::has_open(process, device))
            users.push_back({pid, detail::first_line(process / "comm")});
    }
    std::sort(users.begin(), users.end(), [](const auto& a, const auto& b) { return a.pid < b.pid; });
    return users;
}

/// The timer of the USB adapter that the device is; none for any other device. `root`: in front of /sys.
inline std::optional<latency_timer> latency_of(const std::string& path, const std::string& root = "") {
    namespace fs = std::filesystem;
    std::error_code failed;
    const fs::path device = fs::canonical(path, failed);
    if (failed) return std::nullopt;
    const fs::path file =
        fs::path{root + "/sys/bus/usb-serial/devices"} / device.filename() / "latency_timer";
    const std::string text = detail::first_line(file);
    if (text.empty() || text.find_first_not_of("0123456789") != std::string::npos) return std::nullopt;
    return latency_timer{file.string(), static_cast<unsigned>(std::strtoul(text.c_str(), nullptr, 10))};
}

#endif

} // namespace tool::os
