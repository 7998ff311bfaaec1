// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "snapshot.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "../os/interrupts.hpp"
#include "read_groups.hpp"

namespace tool {

bool snapshot::has_answer() const { return std::ranges::any_of(readings, &reading::is_read); }

bool snapshot::has_port() const {
    return std::ranges::none_of(
        readings, [](const reading& r) { return r.status.error() == servobus::errc::port_lost; });
}

namespace {

// Rows that were read, or not.
class read_rows {
  public:
    read_rows(session& on, const target& of) : on_{&on}, of_{&of} {}

    /// False after an interruption.
    bool read(const read_group& group) {
        if (interrupts::came()) return false;
        const reading whole = ask(group.rows, group.in);
        const bool is_refused = whole.status.error() == servobus::errc::exception;
        if (!is_refused || group.rows.size() == 1) {
            keep(group.rows, whole);
            return true;
        }
        for (const servobus::entry* const& row : group.rows) { // which one it refuses
            if (interrupts::came()) return false;
            keep({&row, 1}, ask({&row, 1}, group.in));
        }
        return true;
    }

    const reading& of(const servobus::entry* row) const { return readings_.at(row); }
    bool has_port() const { return has_port_; }

  private:
    reading ask(std::span<const servobus::entry* const> rows, servobus::table in) {
        if (!has_port_) {
            reading skipped = last_;
            skipped.was_asked = false;
            return skipped;
        }
        std::size_t count = 0;
        for (const servobus::entry* row : rows) count += row->words();
        reading r{std::vector<u16>(count)};
        r.status = on_->read(rows, r.words, in);
        if (!r.is_read()) r.why = why_text(*of_, r.status, *on_);
        has_port_ = r.status.error() != servobus::errc::port_lost;
        last_ = r;
        return r;
    }
    void keep(std::span<const servobus::entry* const> rows, const reading& whole) {
        auto rest = whole.words.begin();
        for (const servobus::entry* row : rows) {
            reading own = whole;
            if (whole.is_read()) {
                const auto end = rest + static_cast<std::ptrdiff_t>(row->words());
                own.words.assign(rest, end);
                rest = end;
            }
            readings_[row] = std::move(own);
        }
    }

    session* on_;
    const target* of_;
    std::map<const servobus::entry*, reading> readings_{};
    reading last_{};
    bool has_port_ = true;
};

// Adds the scale that another row gives.
void add_scale(reading& r, const servobus::entry& row, const servobus::entry& by, const reading& other) {
    r.scale = unknown_scale(row);
    if (!r.is_read()) return;
    if (other.is_read()) {
        r.scale = scale_from(row, by, value_of_words(by, other.words));
        return;
    }
    r.status = other.status;
    r.why = "its scale, " + std::string{by.name} + ": " + other.why;
}

} // namespace

std::optional<snapshot> take_snapshot(session& on, const target& of, std::span<const chosen> wanted) {
    snapshot taken{std::chrono::system_clock::now()};
    if (of.kind != nullptr) {
        read_rows rows{on, of};
        for (const read_group& group : groups_of(of, wanted)) {
            if (!rows.read(group)) return std::nullopt;
        }
        for (const chosen& what : wanted) {
            reading r = rows.of(what.row);
            if (const servobus::entry* const by = of.kind->scaling_row(*what.row))
                add_scale(r, *what.row, *by, rows.of(by));
            taken.readings.push_back(std::move(r));
        }
        return taken;
    }
    bool has_port = true;
    for (const chosen& what : wanted) {
        if (interrupts::came()) return std::nullopt;
        if (!has_port) {
            reading skipped = taken.readings.back();
            skipped.was_asked = false;
            taken.readings.push_back(skipped);
            continue;
        }
        reading r{std::vector<u16>(what.words)};
        r.status = on.read(what, r.words);
        if (!r.is_read()) r.why = why_text(of, r.status, on) + advice_on_number(what, r.status);
        has_port = r.status.error() != servobus::errc::port_lost;
        taken.readings.push_back(std::move(r));
    }
    return taken;
}

} // namespace tool
