// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Judges for every drive: plays each command of a facade against its simulated drive on a hostile line. Every mishap
// happens at every request, and what the library promises is checked from outside. The author of a drive writes a
// subject, which says what the simulated drive does and how it is seen; examples/own_device/own_subject.hpp has one.
//
//     template <class Subject> bool is_right(void (*print)(void*, const sim::finding&)) {
//         sim::conformance<Subject> kit{print};
//         return kit.singles().findings == 0; // every mishap at every request of every command
//     }
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>

#include <servobus/control/motor_drive.hpp>
#include <servobus/sim/conformance/examination.hpp>
#include <servobus/sim/conformance/expected.hpp>
#include <servobus/sim/conformance/finding.hpp>
#include <servobus/sim/conformance/judge.hpp>
#include <servobus/sim/conformance/mishap.hpp>
#include <servobus/sim/conformance/player.hpp>
#include <servobus/sim/conformance/subject.hpp>
#include <servobus/sim/conformance/trial.hpp>
#include <servobus/sim/conformance/wire_log.hpp>
#include <servobus/sim/faults.hpp>

namespace servobus::sim {

/// A part of a list of runs: each `of`-th, `number` being the first, 0 .. of - 1. The parts together are the list.
struct share {
    std::uint32_t number = 0;
    std::uint32_t of = 1;
};

/// Refuses a subject before anything is made of it, so that the assertion is the only error.
template <class Subject> class conformance {
  public:
    template <class... Arguments> explicit conformance(Arguments...) {}

  private:
    static_assert(conformance_subject<Subject>, "the subject lacks something: see sim::conformance_subject");
};

template <class Subject>
requires conformance_subject<Subject>
class conformance<Subject> {
    using drive_type = typename trial<Subject>::drive_type;
    static_assert(motor_drive<drive_type>, "the judges are for a motor_drive");
    static_assert(
        requires(drive_type & d, typename Subject::machine& m) {
            { Subject::take_over(d, m) } -> std::same_as<bool>;
        },
        "the subject says by take_over(drive, machine) how the drive is made ready");

  public:
    /// Each broken promise is reported to it.
    using report = typename conformance_judge<Subject>::report;

    explicit conformance(report to, void* context = nullptr) : player_{to, context} {}

    /// Every mishap at every request of every command, each interpretation of the manual alone. Of equal requests in a
    /// row, as in a wait, the first, the second and the last.
    played singles() {
        for (unsigned interpretation = 0; interpretation < Subject::interpretations; ++interpretation)
            singles(interpretation);
        return player_.so_far();
    }
    /// The same for one interpretation, or a part of it. Each part plays every command once without a mishap.
    played singles(unsigned interpretation, share part = {}) {
        each_single(interpretation, part, [&](unsigned c, planned_mishap only) {
            (void)player_.play(c, interpretation, only, {});
        });
        return player_.so_far();
    }

    /// Plays every pair of mishaps whose first one is a single mishap of the part, and the single mishaps too. The
    /// second one is at the same request, or at a later one of the command or of the half second after it.
    played every_pair(unsigned interpretation, share part = {}) {
        each_pair(interpretation, part, [&](unsigned c, planned_mishap first, planned_mishap second) {
            (void)player_.play(c, interpretation, first, second);
        });
        return player_.so_far();
    }
    /// Counts the pairs that `every_pair` plays. Plays the single mishaps for that.
    std::uint64_t count_pairs(unsigned interpretation, share part = {}) {
        std::uint64_t count = 0;
        each_pair(interpretation, part, [&](unsigned, planned_mishap, planned_mishap) { ++count; });
        return count;
    }

    /// Random pairs of mishaps, as many as `runs`; the same seed plays the same.
    played pairs(std::uint64_t seed, std::uint32_t runs) {
        if (!examination_.is_fit_for_pairs(player_, 0)) return player_.so_far();
        dice random{seed};
        for (std::uint32_t i = 0; i < runs; ++i) {
            const unsigned c = random.below(player_.cases());
            const unsigned interpretation = random.below(Subject::interpretations);
            const auto any = [&](unsigned from) {
                return planned_mishap{all_mishaps[random.below(mishaps)], from + random.below(12)};
            };
            const planned_mishap first = any(0);
            (void)player_.play(c, interpretation, first, any(first.request));
        }
        return player_.so_far();
    }

    /// Plays a run whose command and mishaps are taken from bytes: for a fuzzer. Fewer than six bytes play nothing.
    played from(bytes chosen) {
        if (chosen.size() < 6) return player_.so_far();
        const planned_mishap first{all_mishaps[chosen[2] % mishaps], chosen[3] % 32u};
        const planned_mishap second{all_mishaps[chosen[4] % mishaps], first.request + chosen[5] % 32u};
        (void)player_.play(chosen[0] % player_.cases(), chosen[1] % Subject::interpretations, first, second);
        return player_.so_far();
    }

  private:
    static constexpr std::uint32_t mishaps = sizeof all_mishaps / sizeof *all_mishaps;

    // Calls `use(command, mishap)` for each single mishap of the part. A step in the numbers from request to request
    // lets a part of an even number have every mishap.
    template <class Use> void each_single(unsigned interpretation, share part, const Use& use) {
        if (!examination_.is_fit(player_, interpretation)) return;
        std::uint32_t number = 0;
        for (unsigned c = 0; c < player_.cases(); ++c) {
            for (const unsigned request : play(c, interpretation, {})) {
                for (const mishap m : all_mishaps) {
                    if (number++ % part.of == part.number) use(c, planned_mishap{m, request});
                }
                ++number;
            }
        }
    }
    template <class Use> void each_pair(unsigned interpretation, share part, const Use& use) {
        each_single(interpretation, part, [&](unsigned c, planned_mishap first) {
            for (const unsigned request : play(c, interpretation, first)) {
                if (request < first.request) continue;
                for (const mishap m : all_mishaps) {
                    if (request > first.request || m > first.what) use(c, first, planned_mishap{m, request});
                }
            }
        });
    }
    // Returns at which requests another mishap makes a run: none after a finding, which must be mended first.
    chosen_requests play(unsigned c, unsigned interpretation, planned_mishap only) {
        const std::uint32_t findings = player_.so_far().findings;
        const chosen_requests at = player_.play(c, interpretation, only);
        return player_.so_far().findings == findings ? at : chosen_requests{};
    }

    conformance_player<Subject> player_;
    conformance_examination<Subject> examination_{};
};

} // namespace servobus::sim
