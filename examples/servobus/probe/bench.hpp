// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a probe of a drive works with: a drive that it asks, and a person beside it. commands/probe.cpp has the real ones; a
// test has a simulated drive, and a person who sees what that does.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include <servobus/core/time.hpp>

namespace tool {

enum class seen : std::uint8_t { yes, no, unknown };

/// A drive and a person. Once a request has failed, nothing more is sent but what makes the drive safe: reads give 0, and
/// nothing that was read after it counts.
class probe_bench {
  public:
    probe_bench() = default;
    probe_bench(const probe_bench&) = delete;
    probe_bench& operator=(const probe_bench&) = delete;
    virtual ~probe_bench() = default;

    std::uint16_t read(std::uint16_t address) { return read_words<1>(address)[0]; }
    std::array<std::uint16_t, 2> read_pair(std::uint16_t address) { return read_words<2>(address); }
    /// False if the drive refused it by an exception.
    bool write(std::uint16_t address, std::uint16_t word) {
        const std::uint16_t words[] = {word};
        return !has_failed_ && write_words(address, words);
    }
    /// Two words in one frame.
    bool write_pair(std::uint16_t address, std::array<std::uint16_t, 2> words) {
        return !has_failed_ && write_words(address, words);
    }
    /// Also after a failure, and again if it is not known to be done: what stops a motor.
    void write_safely(std::uint16_t address, std::uint16_t word) {
        constexpr int most = 10;
        const std::uint16_t words[] = {word};
        for (int i = 0; i < most; ++i) {
            const written how = write_now(address, words);
            if (how != written::unknown) return;
            has_failed_ = true;
            wait_now(servobus::milliseconds(200));
        }
    }
    /// Without a request meanwhile.
    void wait(servobus::duration time) {
        if (!has_failed_) wait_now(time);
    }
    /// Asks the person, who may not know.
    seen ask(const std::string& question) { return has_failed_ ? seen::unknown : ask_now(question); }
    /// Asks for consent to what moves or holds a machine, typed in full.
    bool may(const std::string& what) { return !has_failed_ && has_consent(what); }
    /// Asks the person to switch the drive off and on, and waits until it responds. False: it was not done.
    bool switch_off_and_on() { return !has_failed_ && power_cycle(); }
    /// Whether there is any response to a frame whose CRC is wrong.
    seen answers_bad_crc() { return has_failed_ ? seen::unknown : bad_crc_now(); }
    /// Whether the drive responds at this address, which may not be its own.
    seen responds_at(std::uint8_t node) { return has_failed_ ? seen::unknown : look_at(node); }
    /// The count of registers, bytes 5 and 6 of the frame, in the response to function 10h that writes one word: by the
    /// standard 1. None if it is not known.
    std::optional<std::uint16_t> count_in_response(std::uint16_t address, std::uint16_t word) {
        return has_failed_ ? std::nullopt : count_now(address, word);
    }
    /// Ends the probe before it has begun: nothing would show.
    void give_up(const std::string& why) {
        trouble_ = why;
        has_failed_ = true;
    }
    /// Why it has ended early; empty if it has not.
    const std::string& trouble() const { return trouble_; }

    servobus::instant now() const { return clock(); }
    bool has_failed() const { return has_failed_; }
    /// Waits for a drive that was lost, so that it gets its old words back: 20 s at most. True if it responds.
    bool is_back(std::uint16_t address) {
        std::uint16_t word[1]{};
        for (int i = 0; i < 100 && has_failed_; ++i) {
            wait_now(servobus::milliseconds(200));
            has_failed_ = !read_now(address, word);
        }
        return !has_failed_;
    }

  protected:
    enum class written : std::uint8_t { yes, refused, unknown };

    /// The first reason of a failure. Returns false.
    bool fail(const std::string& why) {
        if (trouble_.empty()) trouble_ = why;
        return false;
    }

  private:
    template <std::size_t N> std::array<std::uint16_t, N> read_words(std::uint16_t address) {
        std::array<std::uint16_t, N> words{};
        if (has_failed_) return words;
        has_failed_ = !read_now(address, words);
        return has_failed_ ? std::array<std::uint16_t, N>{} : words;
    }
    bool write_words(std::uint16_t address, std::span<const std::uint16_t> words) {
        const written how = write_now(address, words);
        has_failed_ = has_failed_ || how == written::unknown;
        return how == written::yes;
    }

    virtual bool read_now(std::uint16_t address, std::span<std::uint16_t> words) = 0;
    virtual written write_now(std::uint16_t address, std::span<const std::uint16_t> words) = 0;
    virtual void wait_now(servobus::duration time) = 0;
    virtual seen ask_now(const std::string& question) = 0;
    virtual bool has_consent(const std::string& what) = 0;
    virtual bool power_cycle() = 0;
    virtual seen bad_crc_now() = 0;
    virtual seen look_at(std::uint8_t node) = 0;
    virtual std::optional<std::uint16_t> count_now(std::uint16_t address, std::uint16_t word) = 0;
    virtual servobus::instant clock() const = 0;

    bool has_failed_ = false;
    std::string trouble_{};
};

} // namespace tool
