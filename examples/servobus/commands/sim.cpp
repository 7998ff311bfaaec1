// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus sim: the command line of a simulated drive.
#include "../device_file/device_file.hpp"
#include "../devices/devices.hpp"
#include "../interpretations/findings_file.hpp"
#include "../simulators/simulators.hpp"
#include "../streams/messages.hpp"
#include "../words/line_settings.hpp"
#include "commands.hpp"

#include <filesystem>

namespace tool {
namespace {

// The link takes the place of one that another simulator has left, and of no other.
int check_link(const char* path) {
    if (path == nullptr) return done;
    std::error_code error;
    const std::string before = std::filesystem::read_symlink(path, error).string();
    const std::string_view text = before;
    if (error || text.starts_with("/dev/pts/") || text.starts_with("/dev/ttys")) return done;
    return complain(failed,
                    std::string{"cannot make a link at "} + path + ": it is a symbolic link to " + before);
}

// Reads the file with a probe's findings on a real drive.
int read_switches(const device& of, const std::string& path, simulation& wanted) {
    if (of.interpretations.empty()) return complain(usage, of.word() + " has no switches");
    constexpr std::size_t largest_findings = 100'000; // bytes
    std::string why;
    const std::string text = read_text_file(path, largest_findings, why);
    if (!why.empty()) return complain(usage, why);
    findings found{of.interpretations};
    if (why = parse_findings(found, of.facts().name, text); !why.empty())
        return complain(usage, path + ':' + why);
    wanted.ways = found.numbers();
    return done;
}

} // namespace

int simulate(const arguments& asked) {
    if (asked.words().size() != 1) return complain(usage, "sim takes one DEVICE");
    const device* of = find_device(asked.words()[0]);
    if (of == nullptr) return usage;
    const servobus::profile& facts = of->facts();
    const auto node = asked.number("node", facts.lowest_address, facts.highest_address, facts.lowest_address);
    const auto baud = asked.number("baud", lowest_baud, highest_baud, facts.baud);
    const auto seed = asked.number("seed", 0, INT64_MAX, 1);
    if (!node || !baud || !seed) return usage;
    simulation wanted{.node = static_cast<std::uint8_t>(*node),
                      .baud = static_cast<std::uint32_t>(*baud),
                      .seed = static_cast<std::uint64_t>(*seed),
                      .faults = {},
                      .echoes = false,
                      .has_strict_rate = false,
                      .link = asked.text("link"),
                      .ways = {}};
    const char* faults = asked.text("faults");
    if (faults != nullptr && !servobus::sim::parse_faults(faults, wanted.faults)) {
        return complain(usage,
                        std::string{"--faults takes a list of late, lossy, noisy, doubled, cut, unplugged "
                                    "and none, with commas, not '"} +
                            faults + "'");
    }
    const std::optional<bool> echoes = asked.on_or_off("echo");
    if (!echoes) return usage;
    wanted.echoes = *echoes;
    const std::optional<bool> is_strict = asked.on_or_off("strict-rate");
    if (!is_strict) return usage;
    wanted.has_strict_rate = *is_strict;
    if (const char* path = asked.text("switches")) {
        if (const int status = read_switches(*of, path, wanted); status != done) return status;
    }
    if (const int status = check_link(wanted.link); status != done) return status;
    return of->simulate != nullptr ? of->simulate(wanted) : simulate_file(*of, wanted);
}

} // namespace tool
