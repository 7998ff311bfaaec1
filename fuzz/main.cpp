// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Runs a target on files, and on all files of folders in the order of their names. So any compiler can run
// the corpora, without the fuzzer.   TARGET FILE-OR-FOLDER...
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "support.hpp"

namespace {

std::vector<std::filesystem::path> files_of(const std::filesystem::path& given) {
    if (!std::filesystem::is_directory(given)) return {given};
    std::vector<std::filesystem::path> files;
    for (const auto& one : std::filesystem::directory_iterator{given}) {
        if (one.is_regular_file()) files.push_back(one.path());
    }
    std::sort(files.begin(), files.end());
    return files;
}

bool run(const std::filesystem::path& file) {
    std::ifstream in{file, std::ios::binary};
    const std::vector<char> text{std::istreambuf_iterator<char>{in}, std::istreambuf_iterator<char>{}};
    if (!in) {
        (void)std::fprintf(stderr, "cannot read %s\n", file.c_str());
        return false;
    }
    // A separate buffer of the exact size, so that a read beyond it is found.
    const std::vector<std::uint8_t> data{text.begin(), text.end()};
    (void)std::fprintf(stderr, "%s\n", file.c_str()); // the last file printed is the one that trapped
    return LLVMFuzzerTestOneInput(data.data(), data.size()) == 0;
}

} // namespace

int main(int count, char** words) {
    std::size_t inputs = 0;
    for (int i = 1; i < count; ++i) {
        for (const auto& file : files_of(words[i])) {
            if (!run(file)) return 1;
            ++inputs;
        }
    }
    std::printf("%zu\n", inputs);
    return inputs == 0 ? 1 : 0;
}
