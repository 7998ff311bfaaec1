// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The programs that have a serial device open, and the latency timer of its adapter, from folders that are made here.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <doctest/doctest.h>

#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <examples/servobus/os/port_users.hpp>

namespace port_users_tests {
namespace {

namespace fs = std::filesystem;
using namespace tool::os;

/// A folder in the place of the root, which is removed at the end.
struct root {
    fs::path path;

    root() {
        std::string name = (fs::temp_directory_path() / "port_users_XXXXXX").string();
        REQUIRE(::mkdtemp(name.data()) != nullptr);
        path = name;
        fs::create_directories(path / "proc");
        put("proc/locks", "");
    }
    ~root() { fs::remove_all(path); }
    root(const root&) = delete;
    root& operator=(const root&) = delete;

    void put(const std::string& file, const std::string& text) const {
        fs::create_directories((path / file).parent_path());
        std::ofstream{path / file} << text;
    }
    void process(long pid, const std::string& name, std::initializer_list<const char*> open) const {
        const std::string folder = "proc/" + std::to_string(pid);
        put(folder + "/comm", name + "\n");
        fs::create_directories(path / folder / "fd");
        int number = 0;
        for (const char* file : open)
            fs::create_symlink(file, path / folder / "fd" / std::to_string(number++));
    }
    std::vector<port_user> users() const { return users_of("/dev/null", path.string()); }
};

TEST_CASE("the programs that have a device open are found by their descriptors") {
    const root r;
    CHECK(r.users().empty());
    r.process(300, "minicom", {"/dev/zero", "/dev/null"});
    r.process(20, "robot", {"/dev/null"});
    r.process(40, "other", {"/dev/zero", "/dev/tty-that-is-gone"});
    r.process(static_cast<long>(::getpid()), "this one", {"/dev/null"});
    const auto found = r.users();
    REQUIRE(found.size() == 2);
    CHECK(text_of(found[0]) == "robot (process 20)");
    CHECK(text_of(found[1]) == "minicom (process 300)");
    CHECK(users_of("/dev/no-such-device", r.path.string()).empty());
    CHECK(users_of((r.path / "proc/locks").string(), r.path.string()).empty()); // no device
}

TEST_CASE("who serves a pseudo-terminal is no second client") {
    const root r;
    r.process(7, "sim", {"/dev/null", "/dev/ptmx"});
    CHECK(r.users().empty());
}

TEST_CASE("the owner of a lock is found without its descriptors") {
    const root r;
    struct stat of {};
    REQUIRE(::stat("/dev/null", &of) == 0);
    char file[64];
    (void)std::snprintf(file, sizeof file, "%02x:%02x:%llu", ::major(of.st_dev), ::minor(of.st_dev),
                        static_cast<unsigned long long>(of.st_ino));
    r.put("proc/locks", "1: POSIX  ADVISORY  WRITE 11 " + std::string{file} +
                            " 0 EOF\n2: FLOCK  ADVISORY  WRITE 12 " + file +
                            " 0 EOF\n3: FLOCK  ADVISORY  WRITE 13 00:00:1 0 EOF\n");
    for (const long pid : {11, 12, 13}) r.process(pid, "p", {});
    const auto found = r.users();
    REQUIRE(found.size() == 1);
    CHECK(found[0].pid == 12);
}

TEST_CASE("the latency timer of an adapter") {
    const root r;
    const auto timer_of = [&](const char* device) {
        return latency_of((r.path / device).string(), r.path.string());
    };
    CHECK(!timer_of("dev/ttyUSB7"));
    r.put("dev/ttyUSB7", "");
    CHECK(!timer_of("dev/ttyUSB7"));
    r.put("sys/bus/usb-serial/devices/ttyUSB7/latency_timer", "16\n");
    REQUIRE(timer_of("dev/ttyUSB7"));
    CHECK(timer_of("dev/ttyUSB7")->ms == 16);
    CHECK(timer_of("dev/ttyUSB7")->path.ends_with("/devices/ttyUSB7/latency_timer"));
    fs::create_symlink(r.path / "dev/ttyUSB7", r.path / "dev/by-id");
    REQUIRE(timer_of("dev/by-id"));
    r.put("dev/ttyS0", "");
    CHECK(!timer_of("dev/ttyS0"));
    r.put("sys/bus/usb-serial/devices/ttyUSB7/latency_timer", "soon\n");
    CHECK(!timer_of("dev/ttyUSB7"));
}

} // namespace
} // namespace port_users_tests
