// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus probe: settles on a real drive what its manual leaves open, with a person beside it.
#include <cstdio>
#include <string>
#include <utility>

#include <servobus/modbus/pdu.hpp>
#include <servobus/modbus/rtu.hpp>

#include "../commands.hpp"
#include "../os/file_target.hpp"
#include "../os/interrupts.hpp"
#include "../probe/bench.hpp"
#include "../session.hpp"
#include "../text/findings_file.hpp"

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
        const servobus::entry& row = *of_->kind->map->find(of_->kind->version_register);
        std::vector<u16> words(row.words());
        constexpr int seconds = 30;
        for (int i = 0; i < 2 * seconds && !interrupts::came(); ++i) {
            if (on_->read(choose(row), words).error() == servobus::errc::ok) return true;
            wait_now(servobus::milliseconds(500));
        }
        return fail("the drive does not respond since it was switched on");
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

    // Once: what gives the drive its words back reads and writes too.
    bool is_interrupted() {
        return interrupts::came() && !std::exchange(was_interrupted_, true) && !fail("interrupted");
    }
    servobus::duration longest_wait() const { return on_->response_limit() + servobus::milliseconds(200); }
    session* on_;
    const target* of_;
    bool was_interrupted_ = false;
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
    return bench.trouble().empty() ? done : complain(failed, "ended early: " + bench.trouble());
}

} // namespace tool
