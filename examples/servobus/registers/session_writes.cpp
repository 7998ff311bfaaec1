// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The writes of a session, which are not repeated.
#include "session.hpp"

#include <array>

#include <servobus/explain/direction.hpp>
#include <servobus/modbus/functions.hpp>

namespace tool {

servobus::status session::write_once(const chosen& what, std::span<const u16> words) {
    if (what.form.is_bit()) return write_coils(what.address, words);
    if (words.size() == 1 && has_no_echo_ && has_function_06_)
        return write_single(servobus::modbus::function::write_single_register, what.address, words[0]);
    client_->node().read_retries = retries_; // the reads that rule out an echo
    const servobus::status w = words.size() == 1 && has_function_06_
                                   ? client_->write_word(what.address, words[0])
                                   : client_->write_words(what.address, words);
    client_->node().read_retries = 0;
    note_request(w);
    return w;
}

servobus::status session::write_coils(u16 address, std::span<const u16> coils) {
    namespace modbus = servobus::modbus;
    std::array<std::uint8_t, modbus::max_pdu> request{};
    std::size_t size = 0;
    const bool is_word = coils.size() == 1 && coils[0] > 1; // that no other function can send
    if (coils.size() == 1 && (is_word || has_function_05_)) {
        const u16 word = is_word ? coils[0] : coils[0] != 0 ? modbus::coil_on : modbus::coil_off;
        if (has_no_echo_) return write_single(modbus::function::write_single_coil, address, word);
        size = modbus::put_write_coil_request(request, address, coils[0] != 0);
        servobus::store_word(request, 3, word);
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
    note_request(why);
    if (!why) return why;
    return servobus::check_seen_response(pdu, response);
}

// Without the reads that rule out an echo: the command line says that there is none.
servobus::status session::write_single(servobus::modbus::function code, u16 address, u16 word) {
    const std::vector<std::uint8_t> request = frame_of(code, address, word);
    std::array<std::uint8_t, 8> response{};
    line_type::exchange x{request, response, line_->timing(), node_.limits};
    line_->run(x, node_.gaps);
    note_request(x.status());
    return x.status();
}

bool session::is_stop(const chosen& what, std::span<const u16> words) const {
    return kind_ != nullptr && words.size() == 1 && kind_->is_stop(what.address, words[0]);
}

servobus::status session::write(const chosen& what, std::span<const u16> words) {
    const servobus::status w = has_port() ? write_now(what, words) : servobus::errc::port_lost;
    // Nothing has left, so that the same write may leave after the port has returned.
    const bool may_leave = w.error() == servobus::errc::port_lost && !w.was_sent();
    return may_leave && is_lost_ && has_port() ? write_now(what, words) : w;
}

servobus::status session::write_now(const chosen& what, std::span<const u16> words) {
    std::vector<u16> sent{words.begin(), words.end()};
    if (what.row != nullptr && has_word_order(*what.row)) {
        const servobus::status why = learn_word_order();
        if (why.error() != servobus::errc::ok) return why.with_sent(false);
    }
    if (what.row != nullptr && what.row->is_part()) {
        const servobus::status why = complete_part(what, sent);
        if (why.error() != servobus::errc::ok) return why.with_sent(false);
    }
    if (what.row != nullptr) {
        const std::vector<u16> usual = sent;
        reorder(*what.row, usual, sent);
    }
    // Whose answer may be the last at this address is asked first, so that no echo passes for it.
    if (!has_no_echo_ && what.row != nullptr && has(what.row->flags, servobus::flag::communication) &&
        !line_->is_echo_ruled_out()) {
        u16 word = 0;
        const servobus::status why = read_raw(what.address, {&word, 1}, what.form.table);
        if (!line_->is_echo_ruled_out()) return why.with_sent(false);
    }
    const servobus::status w = write_once(what, sent);
    // What is late must not be carried out any more, but for a stop.
    if (w.outcome() == servobus::outcome::unknown && !is_stop(what, words) && port_.is_network())
        is_lost_ = port_.reconnect() != servobus::errc::ok;
    const auto covers = [&](u16 address) {
        return address != 0 && what.form.table == holding && address >= what.address &&
               address - what.address < what.words;
    };
    if (w.outcome() == servobus::outcome::unknown || covers(facts_->word_order_register) ||
        covers(facts_->eeprom_switch))
        forget();
    return w;
}

// Adds the register's other bits.
servobus::status session::complete_part(const chosen& what, std::span<u16> word) {
    u16 held = 0;
    const servobus::status why = read_raw(what.address, {&held, 1}, what.form.table);
    if (why.error() != servobus::errc::ok) return why;
    u16 usual = 0;
    reorder(*what.row, {&held, 1}, {&usual, 1});
    const u16 mask = what.row->form->mask();
    word[0] = static_cast<u16>((usual & ~mask) | (word[0] & mask));
    return why;
}

} // namespace tool
