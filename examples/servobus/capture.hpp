// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The form of captured frames, which `explain` reads and `listen` writes, and their explanations: a frame in hex a
// line, "> " or "< " in front for a request or a response.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <servobus/explain/explain.hpp>

#include "session.hpp"

namespace tool {

using frame_bytes = std::vector<std::uint8_t>;

struct captured {
    servobus::direction way = servobus::direction::unknown;
    frame_bytes frame;
};

/// Nothing for a line that is no frame in hex.
std::optional<captured> parse_captured(std::string_view line);

/// `01 03 20 AB`
std::string hex_text(servobus::bytes data);
/// The line, without its end.
std::string line_of(const captured& c);

/// The devices of a line by their addresses.
class line_devices {
  public:
    /// `DEVICE[:NODE]...`; without NODE at every address that no other has. Complains by itself.
    static std::optional<line_devices> parse(std::span<const std::string> words);

    const servobus::catalogue& map_of(std::uint8_t node_address) const;
    /// The first one.
    const servobus::profile& facts() const { return first_.facts(); }
    /// How long a response of any of them may take.
    servobus::duration longest_response() const { return longest_response_; }

  private:
    target first_{};
    std::array<const device*, 256> by_address_{};
    servobus::duration longest_response_{};
};

/// Explains frames in their order: a response by the last request before it.
class frame_explainer {
  public:
    explicit frame_explainer(const line_devices& devices) : devices_{&devices} {}

    struct explained {
        std::string text;
        bool is_valid;
    };
    explained explain(const captured& c);

  private:
    const line_devices* devices_;
    frame_bytes last_request_{};
};

} // namespace tool
