// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A drive's parameters as a file's text, and back.
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <map>
#include <memory>
#include <set>

#include <servobus/modbus/crc16.hpp>

#include "../streams/messages.hpp"
#include "../words/csv.hpp"
#include "../words/numbers.hpp"
#include "parameters.hpp"

namespace tool {
namespace {

constexpr std::string_view magic = "servobus-backup ";
constexpr std::int64_t backup_format = 1;
constexpr std::size_t largest_backup = 1'000'000; // bytes

u16 crc_of(std::string_view text) {
    std::vector<std::uint8_t> bytes{text.begin(), text.end()};
    return servobus::modbus::crc16(bytes);
}

std::optional<std::string> read_whole(const std::string& path) {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file{std::fopen(path.c_str(), "rb"), std::fclose};
    std::string text;
    char chunk[4096];
    while (file && text.size() <= largest_backup) {
        const std::size_t got = std::fread(chunk, 1, sizeof chunk, file.get());
        if (got == 0) break;
        text.append(chunk, got);
    }
    if (file && std::ferror(file.get()) == 0) return text;
    complain(usage, "cannot read " + path + ": " + std::strerror(errno));
    return std::nullopt;
}

// The value behind `name` in a line of words, up to the next blank.
std::string_view field(std::string_view line, std::string_view name) {
    const std::size_t at = line.find(name);
    if (at == line.npos) return {};
    line.remove_prefix(at + name.size());
    return line.substr(0, line.find(' '));
}

// Takes a file's text apart. Each step that fails gives its reason.
class reader {
  public:
    reader(const device& of, std::string_view text) : of_{&of}, rest_{text} {
        for (const servobus::entry& e : of.map->entries)
            rows_by_name_.emplace(static_cast<const char*>(e.name), &e);
    }

    /// The reason why the file is refused; empty if it is not.
    std::string read() {
        std::string why = envelope();
        while (why.empty() && !rest_.empty()) why = row(next_line());
        return why.empty() ? whole() : why;
    }

    std::vector<parameter> take() { return std::move(found_); }

  private:
    std::string_view next_line() {
        const std::size_t end = rest_.find('\n');
        const std::string_view line = rest_.substr(0, end);
        rest_.remove_prefix(end == rest_.npos ? rest_.size() : end + 1);
        ++number_;
        return line;
    }

    // The first and the last line.
    std::string envelope() {
        if (!rest_.starts_with(magic)) return "it is no backup file";
        if (rest_.find('\r') != rest_.npos) return "its line ends were changed (CR LF)";
        const std::string shown{field(rest_.substr(0, rest_.find('\n')), " format=")};
        if (shown != std::to_string(backup_format))
            return "it has format '" + shown + "', not " + std::to_string(backup_format);
        const std::size_t last = rest_.rfind("\ncrc16=");
        const std::optional<std::int64_t> stated =
            last == rest_.npos || !rest_.ends_with('\n')
                ? std::nullopt
                : parse_integer(rest_.substr(last + 7, rest_.size() - last - 8));
        if (!stated) return "it is truncated: its last line, with the checksum, is missing";
        rest_ = rest_.substr(0, last + 1);
        if (const u16 crc = crc_of(rest_); *stated != crc)
            return "it was changed or damaged: its checksum is " +
                   hex_word(static_cast<u16>(*stated & 0xFFFF)) + ", that of its content " + hex_word(crc);
        const std::string_view header = next_line();
        if (const std::string name{field(header, " device=")}; name != of_->facts().name)
            return "it is of a " + name + ", not of a " + of_->facts().name;
        rows_ = parse_integer(field(header, " rows="));
        return {};
    }

    const servobus::entry* find(std::string_view name) const {
        const auto at = rows_by_name_.find(name);
        return at != rows_by_name_.end() ? at->second : nullptr;
    }

    // name=number # remark
    std::string row(std::string_view line) {
        const std::string place = "line " + std::to_string(number_) + ", ";
        line = csv::without_remark(line);
        const std::size_t equals = line.find('=');
        if (equals == line.npos) return place + "'" + std::string{line} + "' is no name=number";
        const std::string name{line.substr(0, equals)};
        const std::string value{line.substr(equals + 1)};
        const servobus::entry* e = find(name);
        if (e == nullptr) return place + of_->facts().name + " has no register '" + name + "'";
        if (e->rights != servobus::access::rw)
            return place + name + " is " + text(e->rights) + ", no parameter";
        if (!names_.insert(name).second) return place + name + " is there twice";
        if (value == "?") {
            found_.push_back({e, std::nullopt, {}});
            return {};
        }
        const std::optional<std::vector<u16>> words = parse_plain(*e, value);
        const bool is_number = parse_integer(value) && !is_text(*e);
        if (!words && !is_number)
            return place + name + ": '" + value + "' is no " +
                   (is_text(*e)    ? "text in quotes of " + std::to_string(2 * e->words()) + " characters"
                    : is_float(*e) ? "finite number"
                                   : "whole number");
        if (!words || !takes_words(*e, *words)) {
            return place + name + ": " + value + " is outside " + std::to_string(e->limits.low) + " .. " +
                   std::to_string(e->limits.high) + what_it_takes(*e);
        }
        found_.push_back({e, words, {}});
        return {};
    }

    std::string whole() const {
        for (const servobus::entry& e : of_->map->entries) {
            if (is_parameter(e) && !names_.contains(static_cast<const char*>(e.name)))
                return static_cast<const char*>(e.name) + std::string{" is missing"};
        }
        if (!rows_ || *rows_ != static_cast<std::int64_t>(found_.size()))
            return "its first line says another number of rows than its " + std::to_string(found_.size());
        return {};
    }

    const device* of_;
    std::string_view rest_;
    std::map<std::string_view, const servobus::entry*> rows_by_name_{};
    std::size_t number_ = 0;
    std::optional<std::int64_t> rows_{};
    std::set<std::string, std::less<>> names_{};
    std::vector<parameter> found_{};
};

} // namespace

bool is_parameter(const servobus::entry& e) {
    return e.rights == servobus::access::rw && !has(e.flags, servobus::flag::trigger) &&
           !has(e.flags, servobus::flag::motion);
}

bool is_restorable(const servobus::entry& e) {
    return is_parameter(e) && !has(e.flags, servobus::flag::communication);
}

std::string file_text(const device& of, std::span<const parameter> all) {
    std::string text = std::string{magic} + "format=" + std::to_string(backup_format) +
                       " device=" + of.facts().name + " rows=" + std::to_string(all.size()) + '\n';
    for (const parameter& p : all) {
        text += static_cast<const char*>(p.row->name);
        text += '=' + (p.words ? plain_text(*p.row, *p.words) : std::string{"?"}) + " # " + p.remark + '\n';
    }
    return text + "crc16=" + hex_word(crc_of(text)) + '\n';
}

std::optional<std::vector<parameter>> parse_file(const device& of, const std::string& path) {
    const std::optional<std::string> text = read_whole(path);
    if (!text) return std::nullopt;
    reader r{of, *text};
    const std::string why = r.read();
    if (why.empty()) return r.take();
    complain(usage, path + " is refused: " + why);
    return std::nullopt;
}

} // namespace tool
