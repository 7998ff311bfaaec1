// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "recorder.hpp"

#include <cstdio>

#include "../streams/messages.hpp"
#include "../streams/streams.hpp"

namespace tool {

int recorder::prepare(const arguments& asked, std::span<const chosen> wanted) {
    const char* path = asked.text("log");
    is_json_ = asked.has("json");
    if (is_json_ && asked.has("csv")) return complain(usage, "--csv and --json exclude each other");
    is_on_ = is_json_ || asked.has("csv") || path != nullptr;
    if (!is_on_) return done;
    std::optional<columns> all = columns::of(wanted);
    if (!all) return usage;
    columns_ = *std::move(all);
    if (path == nullptr) return done;
    log_.emplace();
    if (const int status = log_->open(path); status != done) return status;
    // Other columns in the same file would shift its values unseen.
    const std::string begin = is_json_ ? std::string{columns::json_begin} : columns_.csv_header();
    if (log_->is_empty() || log_->begins_with(begin)) return done;
    if (!is_json_ && log_->begins_with(begin.substr(0, begin.size() - 1) + "\r\n"))
        return complain(usage, std::string{path} + ": its line ends were changed (CR LF)");
    return complain(usage, std::string{path} + (is_json_ ? ": it is no log of --json; give another file"
                                                         : ": it has other columns; give another file"));
}

int recorder::put(const snapshot& s) {
    if (!is_on_) return done;
    const std::string header = is_json_ ? std::string{} : columns_.csv_header();
    const std::string row = is_json_ ? columns_.json_line(s) : columns_.csv_row(s);
    if (log_) return log_->append(header, row);
    if (!has_header_) (void)std::fputs(header.c_str(), stdout);
    has_header_ = true;
    (void)std::fputs(row.c_str(), stdout);
    return streams::flush() ? done : failed; // why is said at the end of the program
}

} // namespace tool
