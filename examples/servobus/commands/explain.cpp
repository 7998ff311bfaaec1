// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus explain: captured frames in words.
#include <cstdio>
#include <iostream>
#include <string>
#include <vector>

#include "../capture/capture.hpp"
#include "../streams/messages.hpp"
#include "../streams/streams.hpp"
#include "commands.hpp"

namespace tool {
namespace {

// Where a frame stands among the bytes of its line.
std::string place_of(const frame_explainer::explained& e) {
    return "bytes " + std::to_string(e.offset + 1) + ".." + std::to_string(e.offset + e.frame.frame.size());
}
// The frame in front of its explanation, and where it stands.
std::string repeated(const frame_explainer::explained& e, const captured& line) {
    if (e.frame.frame.size() == line.frame.size()) return line_of(e.frame) + "  ";
    return line_of(e.frame) + "  (" + place_of(e) + ")  ";
}

} // namespace

int explain(const arguments& asked) {
    if (asked.words().empty()) return complain(usage, "explain takes DEVICE[:NODE]...");
    const std::optional<line_devices> devices = line_devices::parse(asked.words());
    if (!devices) return usage;

    int status = done;
    frame_explainer explainer{*devices};
    std::string line;
    while (std::getline(std::cin, line)) {
        if (log_line::without_comment(line).empty()) continue;
        const std::optional<captured> c = parse_captured(line);
        if (!c) {
            (void)std::puts("invalid: not a frame in hex");
            if (!streams::flush()) return failed;
            status = failed;
            continue;
        }
        const std::vector<frame_explainer::explained> all = explainer.explain_line(*c);
        for (const frame_explainer::explained& e : all) {
            if (asked.has("hex")) {
                std::printf("%s", repeated(e, *c).c_str());
            } else if (all.size() > 1) {
                std::printf("%s: ", place_of(e).c_str());
            }
            std::printf("%s\n", e.text.c_str());
            if (!e.is_valid) status = failed;
        }
        if (!streams::flush()) return failed; // a live capture is explained as it comes
    }
    return streams::end_of_input(status);
}

} // namespace tool
