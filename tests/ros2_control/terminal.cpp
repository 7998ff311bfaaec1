// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The exported plugin on a real port of the system: a simulated drive on a pseudo-terminal, in real time. Its
// description is that of urdf/robot.urdf.xacro, as described.py prints it.
//     terminal DESCRIPTION PID       PID: of examples/simulated_drive, which unplugs its line at SIGUSR1
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <new>
#include <sstream>
#include <string>
#include <thread>

#include <sys/resource.h>

#include <servobus/device/zlac8015d.hpp>
#include <servobus/posix/serial.hpp>
#include <servobus/servobus.hpp>

#include "hardware_interface/system_interface.hpp"
#include "manager.hpp"
#include "pluginlib/class_list_macros.hpp"

// Defined by the plugin.
template <>
std::unique_ptr<hardware_interface::SystemInterface>
stand_in::make_plugin<hardware_interface::SystemInterface>();

namespace {
unsigned long allocations = 0;
} // namespace

// Not inline: g++ 12 compares an inlined one with the library's.
[[gnu::noinline]] void* operator new(std::size_t size) {
    ++allocations;
    if (void* const room = std::malloc(size)) return room;
    throw std::bad_alloc{};
}
[[gnu::noinline]] void operator delete(void* room) noexcept { std::free(room); }
[[gnu::noinline]] void operator delete(void* room, std::size_t) noexcept { std::free(room); }

namespace {

using namespace servobus;
using clock_type = std::chrono::steady_clock;
using hardware_interface::return_type;
using manager::primary;

int failed = 0;
void check(const char* name, bool condition) {
    std::printf("%s %s\n", condition ? "ok     " : "FAILED ", name);
    failed += condition ? 0 : 1;
}

hardware_interface::HardwareInfo read_description(const char* path) {
    hardware_interface::HardwareInfo info{};
    std::ifstream file{path};
    for (std::string line; std::getline(file, line);) {
        std::istringstream words{line};
        std::string kind, name, rest;
        words >> kind >> name >> rest;
        hardware_interface::InterfaceInfo one{};
        one.name = name;
        const bool is_of_joint = info.sensors.empty();
        if (kind == "name") info.name = name;
        if (kind == "param") info.hardware_parameters[name] = rest;
        if (kind == "joint") info.joints.emplace_back().name = name;
        if (kind == "sensor") info.sensors.emplace_back().name = name;
        if (kind == "command") info.joints.back().command_interfaces.push_back(one);
        if (kind == "state")
            (is_of_joint ? info.joints : info.sensors).back().state_interfaces.push_back(one);
    }
    return info;
}

// How often this thread has given up its core by itself, as it does to wait.
long waits() {
    rusage used{};
    (void)::getrusage(RUSAGE_THREAD, &used);
    return used.ru_nvcsw;
}

/// The framework's loop at 100 Hz, for a time or until an error; notes how long calls take.
struct loop {
    manager::component& of;
    double longest_ms = 0;
    long waited = 0;
    unsigned long allocated = 0;
    unsigned cycles = 0;

    return_type run(int ms) {
        auto next = clock_type::now();
        const auto end = next + std::chrono::milliseconds(ms);
        while (next < end) {
            const auto began = clock_type::now();
            const long before = waits();
            const unsigned long made = allocations;
            return_type how = of.read();
            if (how == return_type::OK) how = of.write();
            if (how != return_type::OK) return how;
            longest_ms = std::max(
                longest_ms, std::chrono::duration<double, std::milli>(clock_type::now() - began).count());
            waited += waits() - before;
            allocated += allocations - made;
            ++cycles;
            next += std::chrono::milliseconds(10);
            std::this_thread::sleep_until(next);
        }
        return return_type::OK;
    }
};

// What the drive itself says, by another program's means.
double left_turns(const std::string& path) {
    posix::serial port;
    if (port.open(path.c_str()) != errc::ok) return NAN;
    line wire{port, modbus::timing_at(115200)};
    client<line<posix::serial>, zlac8015d::device> drive{wire, node<zlac8015d::device>{1}};
    const auto seen = drive.read<zlac8015d::left_actual_position>();
    return seen ? seen->count() / 4096.0 : NAN;
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 3) return std::fprintf(stderr, "usage: terminal DESCRIPTION PID\n"), 2;
    const hardware_interface::HardwareInfo info = read_description(argv[1]);
    const auto simulator = static_cast<pid_t>(std::atoi(argv[2]));
    const auto plugin = stand_in::make_plugin<hardware_interface::SystemInterface>();
    manager::component base{*plugin};
    loop at_100_hz{base};

    base.initialise(info);
    check("the URDF's description is accepted", base.state() == primary::PRIMARY_STATE_UNCONFIGURED);
    base.configure();
    base.activate();
    check("a new drive is not activated before it was switched off and on", !base.is_active());
    (void)::kill(simulator, SIGUSR2);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    base.activate();
    check("the drive on the port is activated", base.is_active());
    base.command(4, -4);
    check("it drives for 2 s", at_100_hz.run(2000) == return_type::OK);
    check("at the commanded velocity", std::abs(base.value("left_wheel_joint/velocity") - 4) < 0.1);
    base.command(0, 0);
    check("and stops", at_100_hz.run(1200) == return_type::OK);
    const double there = base.value("left_wheel_joint/position");
    base.deactivate();
    base.clean_up();
    const double turns = left_turns(info.hardware_parameters.at("port"));
    std::printf("        position %.6f rad, the drive's %.6f\n", there, turns * 6.283185307179586);
    check("the position is the drive's", std::abs(there - turns * 6.283185307179586) < 1e-6 && there > 5);

    base.configure();
    base.activate();
    base.command(4, 4);
    check("it drives again", at_100_hz.run(1000) == return_type::OK);
    (void)::kill(simulator, SIGUSR1);
    check("a lost line deactivates", at_100_hz.run(3000) == return_type::ERROR);
    check("by one error of the framework's kind", base.errors() == 1);
    (void)::kill(simulator, SIGUSR1);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    base.configure();
    base.activate();
    check("it is activated again", base.is_active());
    base.shut_down();
    check("it is shut down", base.state() == primary::PRIMARY_STATE_FINALIZED);
    std::printf("        %u cycles, the longest read and write took %.3f ms, %ld waited\n", at_100_hz.cycles,
                at_100_hz.longest_ms, at_100_hz.waited);
    // The kernel's own locks on a terminal may make a thread wait now and then.
    check("read and write do not wait", at_100_hz.waited * 50 < at_100_hz.cycles);
    check("read and write allocate nothing", at_100_hz.allocated == 0);
    for (const std::string& line : stand_in::logged()) std::printf("        %s\n", line.c_str());
    return failed == 0 ? 0 : 1;
}
