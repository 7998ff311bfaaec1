// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The lock is the way the file is opened: others may read it and not write.
#ifdef _WIN32

#include "locked_file.hpp"

#include <cerrno>
#include <cstring>

#include "files_windows.hpp"

namespace tool {
namespace {

HANDLE handle(std::intptr_t file) { return reinterpret_cast<HANDLE>(file); }

bool seek(std::intptr_t file, std::uint64_t to) {
    LARGE_INTEGER place{};
    place.QuadPart = static_cast<LONGLONG>(to);
    return ::SetFilePointerEx(handle(file), place, nullptr, FILE_BEGIN) != 0;
}

} // namespace

std::string locked_file::open(const std::string& path) {
    path_ = path;
    // Looked at before it is opened, since that alone can change the lines of a port.
    if (is_device(full_name(path))) return "it is no regular file";
    const DWORD attributes = ::GetFileAttributesA(path.c_str());
    if (attributes != INVALID_FILE_ATTRIBUTES && (attributes & FILE_ATTRIBUTE_DIRECTORY) != 0)
        return std::strerror(EISDIR);
    const auto opened = [&](DWORD how) {
        return reinterpret_cast<std::intptr_t>(::CreateFileA(path.c_str(), GENERIC_READ | GENERIC_WRITE,
                                                             FILE_SHARE_READ, nullptr, how,
                                                             FILE_ATTRIBUTE_NORMAL, nullptr));
    };
    file_ = opened(CREATE_NEW);
    const bool is_new = file_ != none;
    if (!is_new && ::GetLastError() == ERROR_FILE_EXISTS) file_ = opened(OPEN_EXISTING);
    if (file_ == none) {
        const DWORD why = ::GetLastError();
        return why == ERROR_SHARING_VIOLATION ? "another program has it open" : error_text(why);
    }
    if (::GetFileType(handle(file_)) != FILE_TYPE_DISK) return "it is no regular file";
    is_made_here_ = is_new;
    return {};
}

void locked_file::close() {
    if (file_ != none) (void)::CloseHandle(handle(file_));
    file_ = none;
}

void locked_file::remove() {
    close(); // an open file cannot be removed
    (void)::DeleteFileA(path_.c_str());
}

std::optional<std::uint64_t> locked_file::size() const {
    LARGE_INTEGER size{};
    if (::GetFileSizeEx(handle(file_), &size) == 0) return std::nullopt;
    return static_cast<std::uint64_t>(size.QuadPart);
}

bool locked_file::read(std::uint64_t at, std::span<char> to) const {
    DWORD count = 0;
    return seek(file_, at) &&
           ::ReadFile(handle(file_), to.data(), static_cast<DWORD>(to.size()), &count, nullptr) != 0 &&
           count == to.size();
}

std::string locked_file::append(std::string_view text) {
    const std::optional<std::uint64_t> end = size();
    if (!end || !seek(file_, *end)) return error_text(::GetLastError());
    const DWORD why = write_all(handle(file_), text);
    return why == ERROR_SUCCESS ? std::string{} : error_text(why);
}

bool locked_file::cut(std::uint64_t size) { return seek(file_, size) && ::SetEndOfFile(handle(file_)) != 0; }

} // namespace tool

#endif
