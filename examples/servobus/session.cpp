// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A drive on an open port: its settings from the command line, and failures in words.
#include "session.hpp"

#include <array>
#include <utility>

#include <servobus/client/request_machine.hpp>
#include <servobus/modbus/functions.hpp>

namespace tool {

std::optional<target> parse_target(std::string_view text) {
    const std::size_t colon = text.find(':');
    const std::string_view name = text.substr(0, colon);
    target t;
    if (name != "raw") {
        t.kind = find_device(name);
        if (t.kind == nullptr) return std::nullopt;
    }
    if (colon == text.npos) return t;
    const servobus::profile& facts = t.facts();
    const std::optional<std::int64_t> node = parse_integer(text.substr(colon + 1));
    if (!node || *node < facts.lowest_address || *node > facts.highest_address) {
        complain(usage, "'" + std::string{text.substr(colon + 1)} + "' is no node address of " + facts.name +
                            ": " + std::to_string(facts.lowest_address) + " to " +
                            std::to_string(facts.highest_address));
        return std::nullopt;
    }
    t.node = static_cast<std::uint8_t>(*node);
    return t;
}

// Modbus Application Protocol V1.1b3, 7.
static const char* gateway_words(std::uint8_t number) {
    return number == 0x0A ? "gateway path unavailable" : "gateway target device failed to respond";
}

std::string why_text(const target& of, servobus::status why, const any_port& port) {
    if (std::string words = port.diagnosis(why); !words.empty()) return words;
    if (why.error() == servobus::errc::exception) {
        return "refused, exception " + std::to_string(why.exception()) + " (" +
               of.facts().meaning(why.exception()) + ")";
    }
    std::string words = servobus::text(why.error());
    if (why.error() == servobus::errc::gateway_exception)
        words +=
            " (exception " + std::to_string(why.exception()) + ", " + gateway_words(why.exception()) + ")";
    if (why.error() == servobus::errc::port_lost && port.os_error() != 0)
        words += std::string{": "} + os::error_text(port.os_error());
    return words;
}

std::string why_text(const target& of, servobus::status why, const session& on) {
    return why_text(of, why, on.port());
}

std::string why_text(const target& of, const chosen& what, const servobus::status& w, const session& on) {
    const bool is_refused = w.outcome() == servobus::outcome::refused;
    std::string words = is_refused ? "" : std::string{text(w.outcome())} + ", ";
    words += why_text(of, w, on);
    if (is_refused && what.row != nullptr && has(what.row->flags, servobus::flag::when_stopped))
        words += ", may be written only while the motor stands";
    return words;
}

std::optional<servobus::character_format> parse_format(std::string_view text) {
    using servobus::character_format;
    if (text == "8N1") return character_format::n81;
    if (text == "8N2") return character_format::n82;
    if (text == "8E1") return character_format::e81;
    if (text == "8O1") return character_format::o81;
    return std::nullopt;
}

int session::check(const arguments& asked, const target& of) {
    if (any_port::is_network(asked.words()[0]) && !leaves_setting_to_gateway(asked)) return usage;
    const servobus::profile& facts = of.facts();
    settings_ = native::settings_of(facts);
    node_ = servobus::node<any_device>{of.node};
    facts_ = &facts;
    kind_ = of.kind;
    word_order_ = facts.word_order;
    node_.limits = facts.limits;
    node_.gaps = {.gap = facts.gap, .quarantine = facts.quarantine};

    const auto baud = asked.number("baud", 600, 4'000'000, facts.baud);
    const auto timeout = asked.number("timeout", 1, 60'000, facts.limits.response.us / 1000);
    const auto retries = asked.number("retries", 0, 100, facts.read_retries);
    if (!baud || !timeout || !retries) return usage;
    settings_.baud = static_cast<std::uint32_t>(*baud);
    node_.limits.response = servobus::milliseconds(static_cast<std::uint32_t>(*timeout));
    has_timeout_ = asked.has("timeout");
    retries_ = static_cast<std::uint8_t>(*retries);
    if (!parse_longest_pause(asked, longest_pause_) || !check_gaps(asked)) return usage;

    if (const char* format = asked.text("format")) {
        const std::optional<servobus::character_format> parsed = parse_format(format);
        if (!parsed)
            return complain(usage, std::string{"--format takes 8N1, 8N2, 8E1 or 8O1, not '"} + format + "'");
        settings_.format = *parsed;
    }
    const std::optional<bool> echoes = asked.on_or_off("echo");
    if (!echoes) return usage;
    settings_.keeps_echo = *echoes;
    return done;
}

// A late response must be dropped within the quarantine. Who gives a longer timeout has a slower drive, which may be
// late by as much; a shorter timeout does not make the drive any faster.
bool session::check_gaps(const arguments& asked) {
    const auto gap = asked.number("gap", 0, 60'000, facts_->gap.us / 1000);
    const auto quarantine = asked.number("quarantine", 0, 60'000, facts_->quarantine.us / 1000);
    if (!gap || !quarantine) return false;
    if (asked.has("gap")) node_.gaps.gap = servobus::milliseconds(static_cast<std::uint32_t>(*gap));
    has_quarantine_ = asked.has("quarantine");
    if (has_quarantine_) {
        node_.gaps.quarantine = servobus::milliseconds(static_cast<std::uint32_t>(*quarantine));
    }
    later_quarantine_ = node_.gaps.quarantine;
    if (!has_quarantine_ && has_timeout_) {
        const servobus::duration wait = node_.limits.response;
        const servobus::duration usual = facts_->limits.response + facts_->quarantine;
        later_quarantine_ = longer_of(later_quarantine_, wait);
        if (wait < usual) later_quarantine_ = longer_of(later_quarantine_, usual - wait);
    }
    return true;
}

int session::open(const char* path) {
    if (const int status = port_.open(path, settings_); status != done) return status;
    if (any_port::is_network(path)) {
        node_.limits.has_gateway = true;
        if (!has_timeout_) node_.limits.response = node_.limits.response + network_delay;
        // No response can come late there: its connection is dropped, or it has the number of its request.
        if (!has_quarantine_) node_.gaps.quarantine = node_.gaps.quarantine + network_delay;
        later_quarantine_ = node_.gaps.quarantine;
    }
    is_tcp_ = any_port::is_tcp(path);
    node_.read_retries = 0; // `read_repeated` has them
    line_.emplace(port_, timing_on(path, settings_.baud, longest_pause_));
    line_->echo().is_on = settings_.keeps_echo;
    client_.emplace(*line_, node_);
    return done;
}

void session::forget() {
    word_order_ = facts_->word_order;
    wears_.reset();
}

servobus::status session::read_raw(u16 address, std::span<u16> words, servobus::table from) {
    const servobus::status why = read_repeated(address, words, from);
    // Who does not answer may be another drive, or the same one after a power cycle, when it comes back.
    if (why.error() != servobus::errc::ok && why.error() != servobus::errc::exception) forget();
    return why;
}

servobus::status session::read_once(u16 address, std::span<u16> words, servobus::table from) {
    using servobus::modbus::function;
    switch (from) {
    case servobus::table::coils: return read_bits_once(address, words, function::read_coils);
    case servobus::table::discrete_inputs:
        return read_bits_once(address, words, function::read_discrete_inputs);
    case servobus::table::input_registers:
        return client_->read_words(address, words, function::read_input_registers);
    case servobus::table::holding_registers: break;
    }
    return client_->read_words(address, words);
}

servobus::status session::read_bits_once(u16 address, std::span<u16> bits, servobus::modbus::function code) {
    namespace modbus = servobus::modbus;
    std::array<std::uint8_t, 5> request{};
    if (modbus::put_read_bits_request(request, code, address, static_cast<u16>(bits.size())) == 0)
        return servobus::errc::bad_argument;
    std::array<std::uint8_t, modbus::max_pdu> room{};
    const auto response = servobus::byte_buffer{room}.first(2 + modbus::bytes_of_bits(bits.size()));
    const servobus::status why = client_->transact(request, response);
    if (!why) return why;
    const auto values = modbus::parse_bits_response(*modbus::parse_bits_request(request), response);
    if (!values) return servobus::status::sent(values.error());
    for (std::size_t i = 0; i < bits.size(); ++i) bits[i] = (*values)[i] ? 1 : 0;
    return why;
}

servobus::status session::read_repeated(u16 address, std::span<u16> words, servobus::table from) {
    for (unsigned tries = 0;; ++tries) {
        const servobus::status why = read_once(address, words, from);
        note_request();
        using enum servobus::errc;
        if (why.error() == ok || why.error() == bad_argument || why.error() == port_lost) return why;
        if (is_tcp_) {
            if (why.error() == exception) return why;
            const bool is_connected = port_.reconnect() == ok;
            if (tries == retries_) return why;
            if (!is_connected) return {port_lost};
        } else if (tries == retries_ || !servobus::request_machine::is_worth_a_retry(why, node_)) {
            return why;
        }
    }
}

// The first request after a start waits for the drive's own quarantine, which is the shortest that another program's
// request may need.
void session::note_request() { client_->node().gaps.quarantine = later_quarantine_; }

servobus::status session::write_once(const chosen& what, std::span<const u16> words) {
    if (what.form.is_bit()) return write_coils(what.address, words);
    client_->node().read_retries = retries_; // the reads that rule out an echo
    const servobus::status w = words.size() == 1 ? client_->write_word(what.address, words[0])
                                                 : client_->write_words(what.address, words);
    client_->node().read_retries = 0;
    note_request();
    return w;
}

servobus::status session::write_coils(u16 address, std::span<const u16> coils) {
    namespace modbus = servobus::modbus;
    std::array<std::uint8_t, modbus::max_pdu> request{};
    std::size_t size = 0;
    if (coils.size() == 1) {
        size = modbus::put_write_coil_request(request, address, coils[0] != 0);
        // The response repeats the request, so an echo is ruled out first.
        u16 before = 0;
        if (!line_->is_echo_ruled_out()) {
            const servobus::status why = read_raw(address, {&before, 1}, servobus::table::coils);
            if (!line_->is_echo_ruled_out()) return why.with_sent(false);
        }
    } else {
        std::array<bool, modbus::max_write_bits> values{};
        for (std::size_t i = 0; i < coils.size(); ++i) values[i] = coils[i] != 0;
        size = modbus::put_write_coils_request(request, address,
                                               servobus::slice<const bool>{values.data(), coils.size()});
    }
    if (size == 0) return servobus::errc::bad_argument;
    const servobus::bytes pdu = servobus::bytes{request}.first(size);
    std::array<std::uint8_t, 5> response{};
    const servobus::status why = client_->transact(pdu, response);
    if (!why) return why;
    return modbus::check_response(pdu, response);
}

bool session::is_stop(const chosen& what, std::span<const u16> words) const {
    return kind_ != nullptr && words.size() == 1 && kind_->stops(what.address, words[0]);
}

servobus::status session::learn_word_order() {
    if (word_order_ != servobus::word_order::unknown || facts_->word_order_register == 0) return {};
    u16 setting = 0;
    const servobus::status why = read_raw(facts_->word_order_register, {&setting, 1});
    if (why.error() != servobus::errc::ok) return why;
    if (setting > 1) return {servobus::errc::unexpected_value};
    word_order_ = setting == 0 ? servobus::word_order::high_first : servobus::word_order::low_first;
    return {};
}

servobus::status session::ask_wear(bool& wears) {
    if (!wears_) {
        u16 setting = 0;
        const servobus::status why = read_raw(facts_->eeprom_switch, {&setting, 1});
        if (why.error() != servobus::errc::ok) return why;
        wears_ = setting != 0;
    }
    wears = *wears_;
    return {};
}

void session::swap_pair(std::span<u16> pair) const {
    if (word_order_ == servobus::word_order::low_first) std::swap(pair[0], pair[1]);
}

servobus::status session::read(const chosen& what, std::span<u16> words) {
    if (what.row == nullptr) return read_raw(what.address, words, what.form.table);
    return read({&what.row, 1}, words);
}

servobus::status session::read(std::span<const servobus::entry* const> rows, std::span<u16> words) {
    for (const servobus::entry* row : rows) {
        if (row->words() == 1) continue;
        const servobus::status why = learn_word_order();
        if (why.error() != servobus::errc::ok) return why;
    }
    const servobus::status why = read_raw(rows[0]->address, words);
    if (why.error() != servobus::errc::ok) return why;
    for (const servobus::entry* row : rows) {
        if (row->words() == 2) swap_pair(words.first(2));
        words = words.subspan(row->words());
    }
    return {};
}

servobus::status session::write(const chosen& what, std::span<const u16> words) {
    std::vector<u16> sent{words.begin(), words.end()};
    if (what.row != nullptr && what.row->words() == 2) {
        const servobus::status why = learn_word_order();
        if (why.error() != servobus::errc::ok) return why.with_sent(false);
        swap_pair(sent);
    }
    // Whose answer may be the last at this address is asked first, so that no echo passes for it.
    if (what.row != nullptr && has(what.row->flags, servobus::flag::communication) &&
        !line_->is_echo_ruled_out()) {
        u16 word = 0;
        const servobus::status why = read_raw(what.address, {&word, 1});
        if (!line_->is_echo_ruled_out()) return why.with_sent(false);
    }
    const servobus::status w = write_once(what, sent);
    // What is late must not be carried out any more, but for a stop.
    if (w.outcome() == servobus::outcome::unknown && !is_stop(what, words)) (void)port_.reconnect();
    const auto covers = [&](u16 address) {
        return address != 0 && address >= what.address && address - what.address < what.words;
    };
    if (w.outcome() == servobus::outcome::unknown || covers(facts_->word_order_register) ||
        covers(facts_->eeprom_switch))
        forget();
    return w;
}

} // namespace tool
