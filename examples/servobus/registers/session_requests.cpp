// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The reads of a session, which are repeated, and a port that is lost meanwhile.
#include "session.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include <servobus/client/request_machine.hpp>
#include <servobus/modbus/functions.hpp>

#include "../os/interrupts.hpp"
#include "../streams/messages.hpp"

namespace tool {

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
    using enum servobus::errc;
    if (!has_port()) return {port_lost};
    bool was_lost = false;
    for (unsigned tries = 0;; ++tries) {
        const servobus::status why = read_once(address, words, from);
        note_request(why);
        if (why.error() == ok || why.error() == bad_argument) return why;
        if (why.error() == port_lost) {
            // A port that is lost twice at one register is of no use.
            if (std::exchange(was_lost, true) || !has_port()) return why;
        } else if (is_tcp_) {
            if (why.error() == exception) return why;
            is_lost_ = port_.reconnect() != ok;
            if (tries == retries_) return why;
            if (!has_port()) return {port_lost};
        } else if (tries == retries_ || !servobus::request_machine::is_worth_a_retry(why, node_)) {
            return why;
        }
    }
}

servobus::status session::probe(const servobus::entry& row, servobus::table from) {
    std::vector<u16> words(row.words());
    const std::uint8_t retries = std::exchange(retries_, std::uint8_t{0});
    const servobus::status why = read_raw(row.address, words, from);
    retries_ = retries;
    return why;
}

// The first request of a session waits for the drive's own quarantine alone, so that a long --timeout delays no start.
void session::note_request(servobus::status why) {
    client_->node().gaps.quarantine = later_quarantine_;
    has_worked_ = has_worked_ || why.has_response();
    if (why.error() == servobus::errc::port_lost) is_lost_ = true;
}

bool session::may_return() const {
    return patience_.has_value() && !port_.is_foreign() && (has_worked_ || !port_.is_network());
}

bool session::has_port() {
    if (!is_lost_) return true;
    forget(); // another drive may be there when it returns
    if (!may_return()) return false;
    const servobus::instant begin = native::monotonic_now();
    while (port_.reopen() != servobus::errc::ok) {
        const int error = port_.os_error();
        const std::string reason = error != 0 ? ": " + os::error_text(error) : std::string{};
        if (!is_said_lost_) note(name_ + " is gone" + reason + "; waiting for it");
        is_said_lost_ = true;
        if (interrupts::came() || since(begin, native::monotonic_now()) >= *patience_) return false;
        native::sleep_for(servobus::milliseconds(100));
    }
    is_lost_ = false;
    if (is_said_lost_) {
        note(name_ + " is back");
    } else if (!is_said_reopened_) {
        note(name_ + " was lost, and opened anew");
        is_said_reopened_ = true;
    }
    is_said_lost_ = false;
    return true;
}

servobus::status session::learn_word_order() {
    // The drive may have been restarted with its gateway.
    if (std::exchange(connections_, port_.connections()) != port_.connections()) forget();
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

void session::reorder(const servobus::entry& row, std::span<const u16> words, std::span<u16> out) const {
    const bool is_own = row.own_word_order != servobus::word_order::unknown;
    const servobus::words_in_order ordered{row, words, 0, is_own ? row.own_word_order : word_order_};
    for (std::size_t i = 0; i < row.words(); ++i) out[i] = ordered[i];
}

servobus::status session::read(const chosen& what, std::span<u16> words) {
    if (what.row == nullptr) return read_raw(what.address, words, what.form.table);
    return read({&what.row, 1}, words, what.form.table);
}

servobus::status session::read(std::span<const servobus::entry* const> rows, std::span<u16> words,
                               servobus::table from) {
    const bool has_order = std::ranges::any_of(rows, [](const auto* row) { return has_word_order(*row); });
    const bool needs_order = has_order && facts_->word_order_register != 0;
    const std::size_t first = rows.front()->address;
    std::vector<u16> block(rows.back()->address + rows.back()->words() - first);
    for (bool is_again = false;; is_again = true) {
        if (needs_order) {
            const servobus::status why = learn_word_order();
            if (why.error() != servobus::errc::ok) return why;
        }
        const servobus::status why = read_raw(rows[0]->address, block, from);
        if (why.error() != servobus::errc::ok) return why;
        // The port was lost meanwhile, and the word order with it.
        const bool is_forgotten = needs_order && word_order_ == servobus::word_order::unknown;
        if (!is_forgotten) break;
        if (is_again) return {servobus::errc::needs_word_order};
    }
    for (const servobus::entry* row : rows) {
        reorder(*row, std::span{block}.subspan(row->address - first, row->words()), words);
        if (row->is_part()) words[0] = static_cast<u16>(words[0] & row->form->mask());
        words = words.subspan(row->words());
    }
    return {};
}

std::vector<std::uint8_t> session::read_request(const servobus::entry& row, servobus::table from) const {
    using servobus::modbus::function;
    const function code = from == servobus::table::coils             ? function::read_coils
                          : from == servobus::table::discrete_inputs ? function::read_discrete_inputs
                          : from == servobus::table::input_registers ? function::read_input_registers
                                                                     : function::read_holding_registers;
    const bool is_of_bits = code == function::read_coils || code == function::read_discrete_inputs;
    return frame_of(code, row.address, is_of_bits ? u16{1} : static_cast<u16>(row.words()));
}

// A frame with two words: a read, or a single write.
std::vector<std::uint8_t> session::frame_of(servobus::modbus::function code, u16 first, u16 second) const {
    std::vector<std::uint8_t> frame{node_.address, static_cast<std::uint8_t>(code)};
    for (const u16 word : {first, second}) {
        frame.push_back(static_cast<std::uint8_t>(word >> 8));
        frame.push_back(static_cast<std::uint8_t>(word & 0xFFu));
    }
    const u16 crc = servobus::modbus::crc16(frame);
    frame.push_back(static_cast<std::uint8_t>(crc & 0xFFu));
    frame.push_back(static_cast<std::uint8_t>(crc >> 8));
    return frame;
}

void session::listen_on() {
    constexpr servobus::duration longest = servobus::milliseconds(300);
    // A device that has given no response in time may be late.
    const servobus::duration silence = has_worked_ ? until_second_response : longest;
    std::uint8_t room[256];
    const servobus::instant begun = port_.now();
    servobus::instant last = begun;
    while (!is_lost_ && since(last, port_.now()) < silence && since(begun, port_.now()) < longest) {
        const servobus::transfer got = port_.receive(room);
        if (!got) break;
        if (*got != 0) {
            line_->observer().on_unexpected(servobus::bytes{room, *got});
            last = port_.now();
        }
        port_.wait(servobus::milliseconds(1));
    }
}

std::size_t session::count_after(servobus::bytes frame, servobus::duration time,
                                 std::vector<std::uint8_t>* all) {
    std::size_t sent = 0, came = 0;
    std::uint8_t room[256];
    const servobus::instant begun = port_.now();
    while (since(begun, port_.now()) < time) {
        if (sent != frame.size()) {
            const servobus::transfer taken = port_.send(frame.subspan(sent));
            if (!taken) return 0;
            sent += *taken;
        }
        if (const servobus::transfer got = port_.receive(room)) {
            came += *got;
            if (all != nullptr) all->insert(all->end(), room, room + *got);
        }
        port_.wait(servobus::milliseconds(1));
    }
    return settings_.keeps_echo && came >= frame.size() ? came - frame.size() : came;
}

} // namespace tool
