// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus probe: settles on a real drive what its manual leaves open, with a person beside it.
#include <algorithm>
#include <array>
#include <cstdio>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <servobus/modbus/pdu.hpp>
#include <servobus/modbus/rtu.hpp>

#include "../devices/device.hpp"
#include "../interpretations/findings_file.hpp"
#include "../os/file_target.hpp"
#include "../os/interrupts.hpp"
#include "../probe/bench.hpp"
#include "../registers/session.hpp"
#include "../registers/typed_value.hpp"
#include "../streams/messages.hpp"
#include "../words/numbers.hpp"
#include "commands.hpp"

namespace tool {
namespace {

// A drive on a port, and the person at the terminal.
class real_bench final : public probe_bench {
  public:
    real_bench(session& on, const target& of) : on_{&on}, of_{&of} {}

  private:
    bool read_now(u16 address, std::span<u16> words) override {
        if (is_interrupted()) return false;
        const chosen what{hex_word(address), address, static_cast<u16>(words.size()), nullptr};
        const servobus::status why = on_->read(what, words);
        return why.error() == servobus::errc::ok || fail(what.name + ": " + why_text(*of_, why, *on_));
    }
    bool responds(u16 address) override {
        return on_->probe(*of_->kind->map->find(address), session::holding).error() == servobus::errc::ok;
    }
    written write_now(u16 address, std::span<const u16> words) override {
        const chosen what{hex_word(address), address, static_cast<u16>(words.size()), nullptr};
        if (is_interrupted()) return written::unknown;
        const servobus::status w = on_->write(what, words);
        if (w) return written::yes;
        if (w.outcome() == servobus::outcome::refused) return written::refused;
        (void)fail(what.name + ": " + why_text(*of_, what, w, *on_));
        return written::unknown;
    }
    void wait_now(servobus::duration time) override {
        const servobus::instant begun = on_->port().now();
        for (servobus::duration gone{}; gone < time; gone = since(begun, on_->port().now()))
            on_->wait(time - gone);
    }
    seen ask_now(const std::string& question) override {
        const std::string answer = answer_to(question + " [yes, no, ?] ");
        return answer == "yes" || answer == "y"  ? seen::yes
               : answer == "no" || answer == "n" ? seen::no
                                                 : seen::unknown;
    }
    bool has_consent(const std::string& what) override {
        return answer_to(what + "\nType move to agree, anything else to leave it out: ") == "move";
    }
    bool power_cycle() override {
        if (answer_to("Switch the drive off, wait until its lamps are dark, switch it on, and type on "
                      "(anything else leaves "
                      "it out): ") != "on")
            return false;
        const servobus::instant begun = clock();
        while (has_patience(begun) && !interrupts::came()) {
            const servobus::instant tried = clock();
            if (responds(of_->kind->version_register)) return true;
            wait_now(servobus::milliseconds(500));
            note_try(tried);
        }
        lose(begun);
        return fail(interrupts::came() ? "interrupted"
                                       : "the drive does not respond since it was switched on");
    }
    seen bad_crc_now() override {
        if (on_->port().is_network()) return seen::unknown;
        const auto good = servobus::modbus::read_frame(of_->node, of_->kind->version_register, 1);
        const servobus::bytes all = good;
        std::vector<std::uint8_t> frame{all.begin(), all.end()};
        frame.back() ^= 0x55u;
        return on_->count_after(servobus::bytes{frame}, longest_wait()) == 0 ? seen::no : seen::yes;
    }
    seen look_at(std::uint8_t node) override {
        on_->set_node(node);
        u16 word[1]{};
        const servobus::errc error =
            on_->read(chosen{"", of_->kind->version_register, 1, nullptr}, word).error();
        on_->set_node(of_->node);
        return error == servobus::errc::ok        ? seen::yes
               : error == servobus::errc::timeout ? seen::no
                                                  : seen::unknown;
    }

    std::optional<u16> count_now(u16 address, u16 word) override {
        if (on_->port().is_network()) return std::nullopt;
        const std::uint16_t values[] = {word};
        const auto request = servobus::modbus::write_frame(of_->node, address, values);
        std::vector<std::uint8_t> came;
        (void)on_->count_after(request, longest_wait(), &came);
        constexpr std::size_t size = 8; // of its response
        if (came.size() < size || came[came.size() - size + 1] != 0x10) return std::nullopt;
        return servobus::load_word(servobus::bytes{came}, came.size() - size + 4);
    }
    servobus::instant clock() const override { return on_->port().now(); }
    servobus::duration response_limit() const override { return on_->response_limit(); }

    // Once: what gives the drive its words back reads and writes too.
    bool is_interrupted() {
        return interrupts::came() && !std::exchange(was_interrupted_, true) && !fail("interrupted");
    }
    servobus::duration longest_wait() const { return on_->response_limit() + servobus::milliseconds(200); }
    session* on_;
    const target* of_;
    bool was_interrupted_ = false;
};

// Says what a drive that was lost may still have of the probe, and the commands that undo it.
class leftovers {
  public:
    leftovers(const arguments& asked, const target& of, const probe_bench& left)
        : asked_{&asked}, of_{&of}, left_{&left}, changed_{left.not_put_back()} {}

    bool are_none() const { return left_->unsafe().empty() && changed_.empty() && !left_->has_saved(); }
    void print() const {
        if (!left_->unsafe().empty()) {
            std::string stops;
            for (const unsafe_word& u : left_->unsafe()) stops += ' ' + assignment(u.address, {&u.word, 1});
            say("a stop had no response: the motor may be energised, and may turn; stop it first: " +
                command(of_->word(), stops));
        }
        if (!changed_.empty())
            say(counted(changed_.size(), "register") + (changed_.size() == 1 ? " is" : " are") +
                " not put back:");
        for (const changed_register& c : changed_)
            say("  " + name_of(c.address) + ": " + text_of(c.address, c.old) + " before, " +
                (c.is_certain ? "" : "perhaps ") + text_of(c.address, c.now) + " now");
        print_commands();
    }

  private:
    // The line of the drive may have options of its own, as the probe had.
    std::string command(const std::string& device, const std::string& writes) const {
        std::string all = "servobus write " + asked_->words()[0] + ' ' + device + writes;
        for (const option& o : asked_->of().shared[0]->options) {
            const char* const value = asked_->text(o.name);
            if (value != nullptr) all += " --" + std::string{o.name} + ' ' + value;
        }
        return all;
    }
    // Rows that take no 0 by their name are raw. The switch of an EEPROM is on before words that are to be stored, and
    // before its own word, which is stored then too.
    void print_commands() const {
        const u16 wears = of_->facts().eeprom_switch;
        const std::string is_on = wears == 0 ? "" : ' ' + assignment(wears, std::array<u16, 1>{1});
        std::string writes, raw, last;
        if (left_->has_saved()) writes += is_on;
        for (const changed_register& c : changed_) {
            const std::string one = ' ' + assignment(c.address, c.old);
            if (c.address == wears)
                last = is_on + one;
            else if (c.old[0] == 0 && takes_no_zero(c.address))
                raw += ' ' + hex_word(c.address) + "=0";
            else
                writes += one;
        }
        if (const std::optional<save_command>& save = of_->kind->save; save && left_->has_saved()) {
            if (save->cleared_first != 0)
                last += ' ' + assignment(save->cleared_first, std::array<u16, 1>{0});
            last += ' ' + assignment(save->address, {&save->value, 1});
        }
        if (!raw.empty()) say_command(command("raw:" + std::to_string(of_->node), raw));
        if (writes += last; !writes.empty()) say_command(command(of_->word(), writes));
    }
    static void say_command(const std::string& words) {
        say("once the drive responds, put them back: " + words);
    }
    static void say(const std::string& line) { (void)std::fprintf(stderr, "%s\n", line.c_str()); }

    const servobus::entry* row_at(u16 address) const { return of_->kind->map->find(address); }
    bool takes_no_zero(u16 address) const {
        const servobus::entry* const row = row_at(address);
        return row != nullptr && has(row->flags, servobus::flag::zero_by_name);
    }
    std::string name_of(u16 address) const {
        const servobus::entry* const row = row_at(address);
        return row != nullptr ? std::string{static_cast<const char*>(row->name)} : hex_word(address);
    }
    // The high word first.
    std::vector<u16> in_order(std::span<const u16> words) const {
        std::vector<u16> all{words.begin(), words.end()};
        if (left_->is_low_first()) std::ranges::reverse(all);
        return all;
    }
    std::string text_of(u16 address, std::span<const u16> words) const {
        const servobus::entry* const row = row_at(address);
        return row != nullptr ? value_text(choose(*row), in_order(words)) : hex_word(words[0]);
    }
    std::string assignment(u16 address, std::span<const u16> words) const {
        const servobus::entry* const row = row_at(address);
        return row != nullptr ? typed_assignment(choose(*row), in_order(words))
                              : hex_word(address) + '=' + hex_word(words[0]);
    }

    const arguments* asked_;
    const target* of_;
    const probe_bench* left_;
    std::vector<changed_register> changed_;
};

} // namespace

int probe(const arguments& asked) {
    if (asked.words().size() != 3) return complain(usage, "probe takes PORT DEVICE[:NODE] FILE");
    const std::optional<target> of = parse_target(asked.words()[1]);
    if (!of) return usage;
    if (of->kind == nullptr || of->kind->probe == nullptr)
        return complain(usage, asked.words()[1] + ": nothing is known to probe");
    session on;
    if (const int status = on.check(asked, *of); status != done) return status;
    file_target file{asked.words()[2]};
    if (const int status = file.prepare(asked.words()[0].c_str()); status != done) return status;
    if (const int status = on.open(asked.words()[0].c_str()); status != done) return status;
    interrupts::arm();
    const repose rest = of->kind->at_rest(on);
    if (rest.why.error() != servobus::errc::ok)
        return complain(failed, "the drive's state: " + why_text(*of, rest.why, on));
    if (!rest.unrest.empty()) return complain(failed, "refused: " + rest.unrest);

    findings found{of->kind->interpretations};
    const servobus::entry& row = *of->kind->map->find(of->kind->version_register);
    std::vector<u16> version(row.words());
    if (const servobus::status why = on.read(choose(row), version); why.error() != servobus::errc::ok)
        return complain(failed, std::string{row.name} + ": " + why_text(*of, why, on));
    found.firmware = std::to_string(version[0]);
    real_bench bench{on, *of};
    of->kind->probe(bench, found);
    const std::string lines = finding_lines(found);
    std::printf("%s", lines.c_str());
    if (const int status = file.put(findings_head(found, of->facts().name) + lines); status != done)
        return status;
    if (!bench.trouble().empty()) (void)complain(failed, "ended early: " + bench.trouble());
    const leftovers left{asked, *of, bench};
    if (!left.are_none()) left.print();
    return bench.trouble().empty() && left.are_none() ? done : failed;
}

} // namespace tool
