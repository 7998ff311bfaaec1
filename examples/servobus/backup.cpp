// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus backup: a drive's parameters into a file.
#include <cerrno>
#include <cstdio>
#include <cstring>

#include <fcntl.h>
#include <unistd.h>

#include "interrupts.hpp"
#include "parameters.hpp"

namespace tool {
namespace {

// A remark for each, and no number where the drive holds what restore would refuse.
std::size_t judge(std::vector<parameter>& all, std::string& first) {
    std::size_t left_out = 0;
    for (parameter& p : all) {
        if (p.number) {
            p.remark = number_text(*p.row, *p.number);
            if (p.row->limits.contains(*p.number)) continue;
            p.remark += ", outside " + std::to_string(p.row->limits.low) + " .. " +
                        std::to_string(p.row->limits.high);
            p.number.reset();
        }
        if (left_out++ == 0) first = static_cast<const char*>(p.row->name) + (", " + p.remark);
    }
    return left_out;
}

// All of it or nothing: under another name until it is on the disk.
int put_file(const std::string& path, const std::string& text) {
    const std::string draft = path + ".part" + std::to_string(::getpid());
    const int fd = ::open(draft.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    std::size_t sent = 0;
    bool is_good = fd >= 0;
    while (is_good && sent < text.size()) {
        const ssize_t n = ::write(fd, text.data() + sent, text.size() - sent);
        if (n > 0) {
            sent += static_cast<std::size_t>(n);
        } else {
            is_good = n < 0 && errno == EINTR;
        }
    }
    is_good = is_good && ::fsync(fd) == 0;
    if (fd >= 0) is_good = ::close(fd) == 0 && is_good;
    is_good = is_good && std::rename(draft.c_str(), path.c_str()) == 0;
    if (is_good) return done;
    const std::string why = std::strerror(errno);
    if (fd >= 0) (void)::unlink(draft.c_str());
    return complain(failed, "cannot write " + path + ": " + why);
}

} // namespace

int backup(std::span<char* const> words) {
    const std::optional<arguments> asked = arguments::parse(words, session::line_options);
    if (!asked) return usage;
    if (asked->words().size() < 2 || asked->words().size() > 3)
        return complain(usage, "backup takes PORT DEVICE[:NODE] and a FILE, or none for standard output");
    const std::optional<target> of = parse_target(asked->words()[1]);
    if (!of) return usage;
    if (of->kind == nullptr) return complain(usage, "backup needs a device with a map, not raw");
    session on;
    if (const int status = on.check(*asked, *of); status != done) return status;
    if (const int status = on.open(asked->words()[0].c_str()); status != done) return status;

    interrupts::arm();
    std::vector<const servobus::entry*> rows;
    for (const servobus::entry& e : of->kind->map->entries) {
        if (is_parameter(e)) rows.push_back(&e);
    }
    std::optional<std::vector<parameter>> all = read_parameters(on, *of, rows);
    if (!all) return failed;
    std::string first;
    const std::size_t left_out = judge(*all, first);
    if (left_out == all->size()) return complain(failed, "the drive refuses every register: " + first);
    if (left_out != 0) {
        note("warning: " + std::to_string(left_out) + " of " + std::to_string(all->size()) +
             " registers are marked ? and will not be restored, the first is " + first);
    }
    const std::string text = file_text(*of->kind, *all);
    if (asked->words().size() == 3) return put_file(asked->words()[2], text);
    (void)std::fputs(text.c_str(), stdout);
    return std::fflush(stdout) == 0 ? done : complain(failed, "cannot write the output");
}

} // namespace tool
