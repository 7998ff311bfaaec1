// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus doctor: what keeps a drive from turning, or makes it turn otherwise than meant. It reads, and has no call
// that writes.
#include <cstdio>
#include <utility>

#include "../devices/devices.hpp"
#include "../doctor/device_file.hpp"
#include "../doctor/examination.hpp"
#include "../doctor/line_findings.hpp"
#include "../doctor/other_drive.hpp"
#include "../doctor/reading.hpp"
#include "../os/interrupts.hpp"
#include "../registers/consent.hpp"
#include "../streams/messages.hpp"
#include "../streams/streams.hpp"
#include "../words/numbers.hpp"
#include "commands.hpp"

namespace tool {
namespace {

using diagnosis::check_list;
using diagnosis::held_registers;
using diagnosis::is_refusal;

// The options of the line as the command line has them, for the commands that findings name.
std::string options_of(const arguments& asked) {
    std::string all;
    for (const option& o : asked.of().shared[0]->options) {
        const char* const value = asked.text(o.name);
        if (value != nullptr && o.name != "echo") all += " --" + std::string{o.name} + ' ' + value;
    }
    return asked.on_or_off("echo").value_or(false) ? all + " --echo on" : all;
}

// One device on the line.
class consultation {
  public:
    consultation(const arguments& asked, const target& of, unsigned devices, unsigned period_ms)
        : asked_{&asked}, of_{&of}, port_{asked.words()[0]}, to_{port_, of.word(), options_of(asked),
                                                                 asked.has("long")},
          devices_{devices}, period_ms_{period_ms} {}

    session& line() { return on_; }

    int run(bool is_first) {
        if (const int status = on_.open(port_.c_str()); status != done) return status;
        on_.wait_for_port(servobus::milliseconds(2000));
        if (is_first) {
            diagnosis::judge_port(to_, port_);
            ear_.listen();
        }
        const int status =
            of_->kind->examination != nullptr ? examine_drive(*of_->kind->examination) : examine_any();
        return streams::flush() ? status : failed;
    }

  private:
    int examine_drive(const diagnosis::examination& e) {
        held_registers held;
        const auto first = [&] {
            std::vector<const servobus::entry*> rows;
            for (const u16 address : e.status) rows.push_back(of_->kind->map->find(address));
            return rows;
        }();
        row_ = {first[0]};
        if (!read(held, first)) return end();
        if (e.must_ask != nullptr && e.must_ask(held)) {
            note("warning: " + of_->word() +
                 " is enabled, and each request feeds its watchdog: the wheels may run on though their "
                 "controller is "
                 "dead");
            if (const int status =
                    ask_consent(*asked_, "read", "go on", "not confirmed, nothing more was read");
                status != done)
                return status;
        }
        if (!is_patient_) judge_line();
        if (!ear_.account().is_reliable()) return end();
        if (ear_.account().answered < ear_.account().asked) (void)be_patient();
        held.on = facts_of_line();
        if (!read(held, diagnosis::rows_of(e.checks, *of_->kind->map), &e.checks)) return end();
        if (is_foreign(held, diagnosis::rows_of(e.checks, *of_->kind->map))) return end();
        for (const diagnosis::check* c : diagnosis::find(e.checks, held))
            to_.finding(*c, held, *of_->kind->map);
        return end();
    }

    // A device whose registers hold what the drive's cannot is another one: findings about them would be about nothing.
    bool is_foreign(const held_registers& held, std::span<const servobus::entry* const> rows) {
        constexpr std::size_t most = 2; // of a real drive: a word that its manual leaves out
        std::size_t read = 0, outside = 0, alike = 0;
        for (const servobus::entry* e : rows) {
            if (!held.has(e->address) || !e->limits.is_stated) continue;
            ++read;
            const u32 bits =
                e->words() == 1 ? held.word(e->address) : static_cast<u32>(held.pair(e->address));
            outside += !e->takes(e->number(bits));
            alike += bits == held.word(rows[0]->address);
        }
        constexpr std::size_t fewest = 8; // of which no drive holds the same in all
        const bool has_one_word = read >= fewest && alike == read;
        if (outside <= most && !has_one_word) return false;
        const std::string scan = "servobus scan " + port_ + to_.echo_option() + " --nodes " +
                                 std::to_string(of_->node) + " --identify";
        if (has_one_word) {
            to_.refuse("all of " + counted(read, "register") + " hold the same word: it is no " +
                           of_->kind->word(),
                       scan);
            return true;
        }
        to_.refuse(std::to_string(outside) + " of " + counted(read, "register") + " hold what a " +
                       of_->kind->word() + " does not take: it is another device, or its bytes are exchanged",
                   scan);
        return true;
    }

    int examine_any() {
        const asked_row first = first_readable(*of_->kind);
        if (first.row == nullptr) return complain(usage, of_->kind->word() + " has no row that can be read");
        row_ = first;
        const servobus::status why = on_.probe(*first.row, first.in);
        if (!why.has_response()) {
            explain(why);
            return to_.end(false);
        }
        judge_line();
        const servobus::status ended = diagnosis::judge_rows(to_, on_, *of_);
        if (interrupts::came()) return failed;
        if (ended.error() != servobus::errc::ok) explain(ended);
        judge_strays();
        return to_.end(false);
    }

    // An interruption ends it without a result.
    int end() {
        judge_strays();
        return interrupts::came() ? failed : to_.end(true);
    }
    // Says nothing that the reads with listening have shown already.
    void judge_strays() {
        on_.listen_on();
        const line_account& heard = ear_.account();
        const bool is_said = !heard.strays.empty() || heard.doubled != 0 || heard.late != 0;
        if (const std::string strays = on_.strays(); !strays.empty() && !is_said) to_.warn(strays, "");
    }

    void explain(servobus::status why) { diagnosis::explain_silence(to_, port_, *of_, why, on_, ear_, row_); }
    void judge_line() {
        diagnosis::judge_responses(to_, port_, *of_, on_, ear_, row_);
        diagnosis::judge_period(to_, on_, ear_.account().median(), of_->kind->examination != nullptr,
                                devices_, period_ms_);
    }

    // Sets limits with which the device can be read all the same. False if nothing that was heard gives such limits, or
    // the second time.
    bool be_patient() {
        const line_account& heard = ear_.account();
        const bool has_way =
            heard.answered != 0 && heard.is_reliable() && (heard.echoed == 0 || on_.removes_echo());
        if (!has_way || std::exchange(is_patient_, true)) return false;
        on_.be_patient(
            servobus::longer_of(on_.response_limit(), servobus::milliseconds(timeout_for(heard.most()))));
        return true;
    }

    diagnosis::line_facts facts_of_line() const {
        const bool has_rate = !on_.port().is_network() && !on_.port().ignores_rate();
        return {.baud = has_rate ? on_.baud() : 0,
                .format = on_.format(),
                .node = of_->node,
                .response_ms = of_->facts().limits.response.us / 1000,
                .quarantine_ms = of_->facts().quarantine.us / 1000,
                .period_ms = period_ms_};
    }

    // False if the device does not respond, which is reported; what it refuses is reported and left out.
    bool read(held_registers& held, std::span<const servobus::entry* const> rows,
              const check_list* list = nullptr) {
        const auto ask = [&](std::span<const servobus::entry* const> some, std::span<u16> words) {
            if (interrupts::came()) return servobus::status{servobus::errc::port_lost};
            return on_.read(some, words);
        };
        bool is_asked_who = false;
        for (const diagnosis::unread& u : diagnosis::read_into(held, rows, of_->facts().max_read, ask)) {
            if (interrupts::came()) return false;
            const std::string what =
                std::string{static_cast<const char*>(u.row->name)} + ": " + why_text(*of_, u.why, on_);
            if (is_refusal(u.why) && !std::exchange(is_asked_who, true) &&
                diagnosis::explain_other_drive(to_, on_, *of_, what))
                return false;
            if (!is_refusal(u.why) || list == nullptr) {
                if (is_patient_ && to_.has_refusal()) return false; // it is explained
                explain(u.why);
                return be_patient() && read(held, rows, list);
            }
            to_.unread(what, decides(*list, u.row->address));
        }
        return true;
    }
    static bool decides(const check_list& list, u16 address) {
        for (const diagnosis::check& c : list.checks) {
            for (const u16 watched : c.of.all()) {
                if (c.is == diagnosis::refuses && watched == address) return true;
            }
        }
        for (const u16 one : list.needed) {
            if (one == address) return true;
        }
        return false;
    }

    const arguments* asked_;
    const target* of_;
    std::string port_;
    session on_;
    diagnosis::report to_;
    diagnosis::line_hearing ear_{on_};
    bool is_patient_ = false; ///< the line was explained
    asked_row row_{};         ///< by which the line is judged
    unsigned devices_;
    unsigned period_ms_;
};

// Complains by itself.
std::optional<std::vector<target>> parse_targets(const arguments& asked) {
    std::vector<target> all;
    for (std::size_t i = 1; i < asked.words().size(); ++i) {
        const std::optional<target> of = parse_target(asked.words()[i]);
        if (!of) return std::nullopt;
        if (of->kind == nullptr) {
            complain(usage, "doctor needs a device with a map, not raw");
            return std::nullopt;
        }
        for (const target& other : all) {
            if (other.node != of->node) continue;
            complain(usage, "two devices at node " + std::to_string(of->node) +
                                ": name their addresses, DEVICE:NODE");
            return std::nullopt;
        }
        all.push_back(*of);
    }
    return all;
}

} // namespace

int doctor(const arguments& asked) {
    if (asked.words().size() < 2) return complain(usage, "doctor takes PORT DEVICE[:NODE]...");
    const std::optional<std::vector<target>> all = parse_targets(asked);
    if (!all) return usage;
    if (all->size() > diagnosis::most_devices)
        return complain(usage,
                        "doctor takes at most " + std::to_string(diagnosis::most_devices) + " devices");
    const auto period = asked.number("period", 1, 60'000, 0);
    if (!period) return usage;
    for (const target& of : *all) { // before anything is opened
        session checked;
        if (const int status = checked.check(asked, of); status != done) return status;
    }
    interrupts::arm();
    std::optional<servobus::uart_settings> shared;
    if (all->size() > 1 && !any_port::is_network(asked.words()[0])) {
        shared = diagnosis::judge_shared_line(*all);
        if (!shared) return failed;
    }
    int result = done;
    for (std::size_t i = 0; i < all->size(); ++i) {
        consultation one{asked, (*all)[i], static_cast<unsigned>(all->size()),
                         static_cast<unsigned>(*period)};
        if (const int status = one.line().check(asked, (*all)[i]); status != done) return status;
        if (shared) {
            one.line().set_rate(asked.has("baud") ? one.line().baud() : shared->baud,
                                asked.has("format") ? one.line().format() : shared->format);
        }
        const int status = one.run(i == 0);
        if (interrupts::came()) return complain(failed, "interrupted");
        result = status == done ? result : status;
    }
    return result;
}

} // namespace tool
