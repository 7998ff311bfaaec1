// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Writes a line for each test case to the file that REQUESTS names: how many requests it sent, a number that stands for
// their bytes, its source and its name. With REQUESTS_OF it writes the requests of the test cases of that name.
#include <tests/requests/recorder.hpp>

#include <doctest/doctest.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace recorder {

namespace {

struct record {
    std::FILE* file = nullptr;
    const char* wanted = std::getenv("REQUESTS_OF");
    bool is_wanted = false;
    std::uint64_t number = 0;
    unsigned long long requests = 0;

    record() {
        if (const char* const name = std::getenv("REQUESTS")) file = std::fopen(name, "w");
    }
};
record& now() {
    static record only;
    return only;
}

struct listener : doctest::IReporter {
    explicit listener(const doctest::ContextOptions&) {}
    void report_query(const doctest::QueryData&) override {}
    void test_run_start() override {}
    void test_run_end(const doctest::TestRunStats&) override {
        if (now().file != nullptr) std::fclose(now().file);
    }
    void test_case_start(const doctest::TestCaseData& of) override {
        record& r = now();
        of_ = &of;
        r.number = 0xCBF2'9CE4'8422'2325u;
        r.requests = 0;
        r.is_wanted = r.wanted != nullptr && std::strstr(of.m_name, r.wanted) != nullptr;
    }
    void test_case_reenter(const doctest::TestCaseData&) override {}
    void test_case_end(const doctest::CurrentTestCaseStats&) override {
        const record& r = now();
        if (r.file == nullptr || r.requests == 0) return;
        const char* const source = std::strstr(of_->m_file.c_str(), "tests/run/");
        std::fprintf(r.file, "%llu\t%016llx\t%s\t%s\n", r.requests, static_cast<unsigned long long>(r.number),
                     source != nullptr ? source : of_->m_file.c_str(), of_->m_name);
        std::fflush(r.file);
    }
    void test_case_exception(const doctest::TestCaseException&) override {}
    void subcase_start(const doctest::SubcaseSignature&) override {}
    void subcase_end() override {}
    void log_assert(const doctest::AssertData&) override {}
    void log_message(const doctest::MessageData&) override {}
    void test_case_skipped(const doctest::TestCaseData&) override {}

  private:
    const doctest::TestCaseData* of_ = nullptr;
};

} // namespace

void request(const std::uint8_t* data, std::size_t size) {
    record& r = now();
    ++r.requests;
    for (std::size_t i = 0; i < size; ++i) r.number = (r.number ^ data[i]) * 0x100'0000'01B3u;
    if (!r.is_wanted || r.file == nullptr) return;
    for (std::size_t i = 0; i < size; ++i) std::fprintf(r.file, "%02X ", static_cast<unsigned>(data[i]));
    std::fprintf(r.file, "\n");
}

} // namespace recorder

REGISTER_LISTENER("requests", 1, recorder::listener);
