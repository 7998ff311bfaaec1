// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "log_file.hpp"

#include <vector>

#include "../streams/messages.hpp"

namespace tool {

log_file::~log_file() {
    if (file_.is_made_here() && is_empty()) file_.remove();
}

int log_file::complain_of(const std::string& why) const {
    return complain(failed, "cannot write " + path_ + ": " + why);
}

int log_file::open(const std::string& path) {
    path_ = path;
    if (const std::string why = file_.open(path); !why.empty()) return complain_of(why);
    const std::optional<std::uint64_t> bytes = file_.size();
    char last = '\n';
    if (!bytes || (*bytes != 0 && !file_.read(*bytes - 1, {&last, 1})))
        return complain_of("its last line cannot be read");
    if (last == '\n') return done;
    return complain(usage, path_ + ": its last line has no end; complete or remove that line first");
}

bool log_file::begins_with(std::string_view text) const {
    std::vector<char> found(text.size());
    return file_.read(0, found) && std::string_view{found.data(), found.size()} == text;
}

int log_file::append(std::string_view header, std::string_view row) {
    const std::optional<std::uint64_t> before = file_.size();
    if (!before) return complain_of("its size is not known");
    const std::string why = file_.append(std::string{*before == 0 ? header : ""} + std::string{row});
    if (why.empty()) return done;
    const std::optional<std::uint64_t> now = file_.size();
    const bool is_whole = (now && *now <= *before) || file_.cut(*before);
    return complain_of(why + (is_whole ? "" : "; its last row is not complete"));
}

} // namespace tool
