// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Captured frames and their explanations. `listen` writes a frame in hex a line, "> " or "< " in front for a
// request or a response; `explain` reads this and the forms of other programs (log_line.hpp).
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <servobus/explain/explain.hpp>

#include "../frames/log_line.hpp"
#include "../registers/session.hpp"

namespace tool {

/// `01 03 20 AB`
std::string hex_text(servobus::bytes data);
/// The line, without its end.
std::string line_of(const captured& c);

/// The devices of a line by their addresses.
class line_devices {
  public:
    /// `DEVICE[:NODE]...`; without NODE at every address that no other has. Complains by itself.
    static std::optional<line_devices> parse(std::span<const std::string> words);

    /// The rows of the device at an address.
    servobus::table_catalogues maps_of(std::uint8_t node_address) const;
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
        captured frame;
        std::size_t offset = 0; ///< of the frame in its line, in bytes
    };
    /// The bytes as one frame.
    explained explain(const captured& c);
    /// The frames among the bytes of a line. Noise around a frame is in its text; more noise than an idle line
    /// gives is an explanation of its own, which is not valid. Without any frame: the bytes as one.
    std::vector<explained> explain_line(const captured& c);

  private:
    explained explain(const captured& line, const tcp_frame& f, bool is_one);
    servobus::explanation explain_as(const captured& c, servobus::direction way);

    const line_devices* devices_;
    std::vector<char> room_ =
        std::vector<char>(300'000); // 2000 coils with their names and those of their states
    frame_bytes last_request_{};
    bool is_log_of_server_ = false; ///< what is sent there are the responses
};

} // namespace tool
