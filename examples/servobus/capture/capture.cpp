// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "capture.hpp"

#include "../streams/messages.hpp"

namespace tool {
namespace {

using servobus::direction;

// A frame without a direction that repeats the last request is most likely its response. A request that is not
// well-formed is one too if its CRC is right: the device responds to it.
bool is_new_request(const servobus::explanation& e, direction way, const frame_bytes& frame,
                    const frame_bytes& before) {
    if (way == direction::response) return false;
    if (way == direction::request) return bool{servobus::modbus::open_frame(frame)};
    return e.is_valid() && (e.way == direction::request || (e.way == direction::unknown && frame != before));
}

constexpr servobus::catalogue no_map{&any_device::facts, {}};

} // namespace

std::string hex_text(servobus::bytes data) {
    constexpr char digits[] = "0123456789ABCDEF";
    std::string text;
    for (const std::uint8_t byte : data) {
        if (!text.empty()) text += ' ';
        text += digits[byte >> 4];
        text += digits[byte & 0xFu];
    }
    return text;
}

std::string line_of(const captured& c) {
    const char* arrow = c.way == direction::unknown ? "" : c.way == direction::request ? "> " : "< ";
    return arrow + hex_text(c.frame);
}

std::optional<line_devices> line_devices::parse(std::span<const std::string> words) {
    line_devices all;
    std::array<bool, 256> is_named{};
    bool has_others = false;
    const device* others = nullptr;
    for (const std::string& word : words) {
        const std::optional<target> one = parse_target(word);
        if (!one) return std::nullopt;
        if (one->is_peer()) {
            refuse_peer(*one);
            return std::nullopt;
        }
        if (&word == words.data()) all.first_ = *one;
        all.longest_response_ = longer_of(all.longest_response_, one->facts().limits.response);
        const bool has_node = one->has_node;
        if (has_node ? is_named[one->node] : has_others) {
            complain(usage, has_node ? "two devices at address " + std::to_string(one->node)
                                     : "two devices for the addresses that are not named");
            return std::nullopt;
        }
        if (has_node) {
            is_named[one->node] = true;
            all.by_address_[one->node] = one->kind;
        } else {
            has_others = true;
            others = one->kind;
        }
    }
    for (std::size_t i = 0; i < is_named.size(); ++i) {
        if (!is_named[i]) all.by_address_[i] = others;
    }
    if (!has_others) all.by_address_[servobus::modbus::broadcast] = all.first_.kind;
    return all;
}

servobus::table_catalogues line_devices::maps_of(std::uint8_t node_address) const {
    const device* at = by_address_[node_address];
    if (at == nullptr) return {&no_map};
    if (at->tables == nullptr) return {at->map};
    using enum servobus::table;
    const auto of = [&](servobus::table t) { return &at->tables[static_cast<std::size_t>(t)]; };
    return {of(holding_registers), of(coils), of(discrete_inputs), of(input_registers)};
}

servobus::explanation frame_explainer::explain_as(const captured& c, direction way) {
    const std::uint8_t node_address = c.frame.empty() ? std::uint8_t{0} : c.frame[0];
    return servobus::explain(devices_->maps_of(node_address), way, c.frame, last_request_, room_);
}

frame_explainer::explained frame_explainer::explain(const captured& c) {
    direction way = c.way;
    servobus::explanation e = explain_as(c, way);
    if (way == direction::unknown && c.of_client != direction::unknown && e.is_valid()) {
        const direction other = c.of_client == direction::request ? direction::response : direction::request;
        if (e.way != direction::unknown) is_log_of_server_ = e.way == other;
        way = is_log_of_server_ ? other : c.of_client;
        e = explain_as(c, way);
    }
    if (is_new_request(e, way, c.frame, last_request_)) last_request_ = c.frame;
    return {std::string{room_.data(), e.size}, e.is_valid(), {way, c.frame}, 0};
}

frame_explainer::explained frame_explainer::explain(const captured& line, const tcp_frame& f, bool is_one) {
    explained e = explain(
        {is_one ? line.way : direction::unknown, f.rtu, is_one ? line.of_client : direction::unknown});
    e.text = "node " + std::to_string(f.unit) + " (Modbus TCP, transaction " + std::to_string(f.transaction) +
             ')' + e.text.substr(std::min(e.text.find(": "), e.text.size()));
    const servobus::bytes own = servobus::bytes{line.frame}.subspan(f.offset, f.size);
    e.frame.frame.assign(own.begin(), own.end());
    e.offset = f.offset;
    return e;
}

std::vector<frame_explainer::explained> frame_explainer::explain_line(const captured& c) {
    const found_frames found = log_line::find_frames(c.frame, last_request_);
    if (found.frames.empty()) {
        const std::vector<tcp_frame> over_tcp = tcp_frames_of(c.frame);
        if (over_tcp.empty()) return {explain(c)};
        std::vector<explained> each;
        for (const tcp_frame& f : over_tcp) each.push_back(explain(c, f, over_tcp.size() == 1));
        return each;
    }
    std::vector<explained> all;
    std::size_t offset = 0;
    const auto add_noise = [&](const frame_bytes& noise, const char* where, explained* around) {
        const std::size_t begin = offset;
        offset += noise.size();
        if (noise.empty()) return;
        if (noise.size() < servobus::modbus::min_frame || log_line::is_idle_line(noise)) {
            around->text += std::string{" (noise "} + where + " it: " + hex_text(noise) + ')';
            return;
        }
        all.push_back({"invalid: no frame in " + std::to_string(noise.size()) + " bytes: " + hex_text(noise),
                       false,
                       {direction::unknown, noise},
                       begin});
    };
    const bool is_one = found.frames.size() == 1;
    for (const found_frame& f : found.frames) {
        // Glued frames have both directions, whatever the mark in front of them is.
        explained e = explain(
            {is_one ? c.way : direction::unknown, f.frame, is_one ? c.of_client : direction::unknown});
        add_noise(f.noise, "before", &e);
        e.offset = offset;
        offset += f.frame.size();
        all.push_back(std::move(e));
    }
    add_noise(found.noise, "after", &all.back());
    return all;
}

} // namespace tool
