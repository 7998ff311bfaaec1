// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#ifdef _WIN32

#include "file_target.hpp"

#include <cerrno>
#include <cstring>

#include "../streams/messages.hpp"
#include "files_windows.hpp"

namespace tool {
namespace {

file_handle opened(const std::string& path, DWORD access, DWORD how) {
    return file_handle{::CreateFileA(path.c_str(), access, FILE_SHARE_READ | FILE_SHARE_WRITE, nullptr, how,
                                     FILE_ATTRIBUTE_NORMAL, nullptr)};
}

// A new file beside `place`, in the same file system. Not open if there is none.
file_handle make_draft(const std::string& place, std::string& draft) {
    const std::string folder = place.substr(0, place.rfind('\\') + 1);
    for (int tries = 0; tries < 100; ++tries) {
        draft = folder + "servobus" + std::to_string(::GetCurrentProcessId()) + '-' + std::to_string(tries) +
                ".part";
        file_handle file{::CreateFileA(draft.c_str(), GENERIC_WRITE, 0, nullptr, CREATE_NEW,
                                       FILE_ATTRIBUTE_NORMAL, nullptr)};
        if (file.is_open() || ::GetLastError() != ERROR_FILE_EXISTS) return file;
    }
    return {};
}

} // namespace

class file_target::place {
  public:
    explicit place(std::string path) : path_{std::move(path)} {}

    int prepare(const char* port) {
        if (std::string why = look(); !why.empty()) return complain_of(why);
        if (::lstrcmpiA(full_name(path_).c_str(), full_name(port).c_str()) == 0)
            return complain(usage, path_ + " is the port");
        return done;
    }
    int put(const std::string& text) {
        std::string why = look(); // it may have changed while the drive was read
        if (why.empty()) why = kind_ == kind::stream ? stream(text) : replace(text);
        return why.empty() ? done : complain_of(why);
    }

  private:
    enum class kind { fresh, regular, stream };

    // These return why they could not, or nothing.

    // What the name leads to now.
    std::string look() {
        place_ = full_name(path_);
        kind_ = kind::stream;
        if (is_device(place_)) return {};
        kind_ = kind::fresh;
        const DWORD attributes = ::GetFileAttributesA(path_.c_str());
        if (attributes == INVALID_FILE_ATTRIBUTES) {
            const DWORD why = ::GetLastError();
            return why == ERROR_FILE_NOT_FOUND || why == ERROR_PATH_NOT_FOUND ? std::string{}
                                                                              : error_text(why);
        }
        if ((attributes & FILE_ATTRIBUTE_DIRECTORY) != 0) return std::strerror(EISDIR);
        kind_ = kind::regular;
        return (attributes & FILE_ATTRIBUTE_REPARSE_POINT) != 0 ? follow() : std::string{};
    }

    // A link is followed, and its end replaced.
    std::string follow() {
        const file_handle end = opened(path_, 0, OPEN_EXISTING);
        if (!end.is_open()) {
            const DWORD why = ::GetLastError();
            return why == ERROR_FILE_NOT_FOUND ? "it is a symbolic link to nothing" : error_text(why);
        }
        char name[4096]{};
        const DWORD size = ::GetFinalPathNameByHandleA(end.get(), name, sizeof name, FILE_NAME_NORMALIZED);
        if (size == 0 || size >= sizeof name) return error_text(::GetLastError());
        place_.assign(name, size);
        return {};
    }

    // All of it or nothing: under another name until it is on the disk.
    std::string replace(const std::string& text) const {
        // As if it were written in place: a file that may not be written is not replaced either.
        if (kind_ == kind::regular && !opened(place_, GENERIC_WRITE, OPEN_EXISTING).is_open())
            return error_text(::GetLastError());
        std::string draft;
        file_handle file = make_draft(place_, draft);
        if (!file.is_open()) return error_text(::GetLastError());
        DWORD why = write_all(file.get(), text);
        if (why == ERROR_SUCCESS && ::FlushFileBuffers(file.get()) == 0) why = ::GetLastError();
        if (!file.close() && why == ERROR_SUCCESS) why = ::GetLastError();
        if (why == ERROR_SUCCESS && !move(draft)) why = ::GetLastError();
        if (why == ERROR_SUCCESS) return {};
        // The old file is gone then: the new one must not go too.
        if (why == ERROR_UNABLE_TO_MOVE_REPLACEMENT) {
            if (rename(draft)) return {};
            return error_text(why) + "; its new content is in " + draft;
        }
        (void)::DeleteFileA(draft.c_str());
        return error_text(why);
    }
    bool move(const std::string& draft) const {
        if (kind_ == kind::regular) // keeps attributes and access list
            return ::ReplaceFileA(place_.c_str(), draft.c_str(), nullptr, 0, nullptr, nullptr) != 0;
        return rename(draft);
    }
    bool rename(const std::string& draft) const {
        return ::MoveFileExA(draft.c_str(), place_.c_str(),
                             MOVEFILE_REPLACE_EXISTING | MOVEFILE_WRITE_THROUGH) != 0;
    }

    std::string stream(const std::string& text) const {
        file_handle file = opened(path_, GENERIC_WRITE, OPEN_EXISTING);
        if (!file.is_open()) return error_text(::GetLastError());
        const DWORD why = write_all(file.get(), text);
        return why == ERROR_SUCCESS ? std::string{} : error_text(why);
    }

    int complain_of(const std::string& why) const {
        return complain(failed, "cannot write " + path_ + ": " + why);
    }

    std::string path_;
    std::string place_{}; // where it is once its links are followed
    kind kind_ = kind::fresh;
};

file_target::file_target(std::string path) : place_{std::make_unique<place>(std::move(path))} {}
file_target::~file_target() = default;
int file_target::prepare(const char* port) { return place_->prepare(port); }
int file_target::put(const std::string& text) { return place_->put(text); }

} // namespace tool

#endif
