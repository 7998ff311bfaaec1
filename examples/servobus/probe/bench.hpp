// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What a probe of a drive works with: a drive that it asks, and a person beside it. commands/probe.cpp has the real
// ones; a test has a simulated drive, and a person who sees what that does.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <servobus/core/time.hpp>

namespace tool {

enum class seen : std::uint8_t { yes, no, unknown };

/// A register, or a pair, that does not hold its owner's words for certain. The words are in the order of the frame.
struct changed_register {
    std::uint16_t address;
    std::vector<std::uint16_t> old; ///< its owner's
    std::vector<std::uint16_t> now; ///< the last ones that were written
    bool is_certain;                ///< the drive has responded to that write, and was not switched off since
};
/// A word that makes the drive safe, and had no response.
struct unsafe_word {
    std::uint16_t address;
    std::uint16_t word;
};

/// A drive and a person. Once a request has failed, nothing more is sent but what makes the drive safe: reads give 0,
/// and nothing that was read after it counts. A line that stays silent ends all requests 20 s after the first that
/// failed.
class probe_bench {
  public:
    static constexpr servobus::duration patience = servobus::milliseconds(20'000);

    probe_bench() = default;
    probe_bench(const probe_bench&) = delete;
    probe_bench& operator=(const probe_bench&) = delete;
    virtual ~probe_bench() = default;

    std::uint16_t read(std::uint16_t address) { return read_words<1>(address)[0]; }
    std::array<std::uint16_t, 2> read_pair(std::uint16_t address) { return read_words<2>(address); }
    /// False if the drive refused it by an exception.
    bool write(std::uint16_t address, std::uint16_t word) {
        const std::uint16_t words[] = {word};
        return !has_failed_ && write_words(address, words) == written::yes;
    }
    /// Two words in one frame.
    bool write_pair(std::uint16_t address, std::array<std::uint16_t, 2> words) {
        return !has_failed_ && write_words(address, words) == written::yes;
    }
    /// Also after a failure, and again for 2 s if it is not known to be done: what stops a motor.
    void write_safely(std::uint16_t address, std::uint16_t word) {
        constexpr int most = 10;
        constexpr servobus::duration longest = servobus::milliseconds(2000);
        std::erase_if(unsafe_, [&](const unsafe_word& u) { return u.address == address; });
        unsafe_.push_back({address, word});
        const std::uint16_t words[] = {word};
        const servobus::instant begun = clock();
        for (int i = 0; i < most && may_try() && since(begun, clock()) < longest; ++i) {
            const servobus::instant tried = clock();
            if (write_words(address, words) != written::unknown) return unsafe_.pop_back();
            wait_now(servobus::milliseconds(200));
            note_try(tried);
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
    bool switch_off_and_on() {
        if (has_failed_ || !power_cycle()) return false;
        for (const owned& o : owned_) {
            const auto last = last_.find(o.address);
            if (last != last_.end() && last->second.words != o.words) last->second.is_certain = false;
        }
        return true;
    }
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
        lose(clock());
    }
    /// Why it has ended early; empty if it has not.
    const std::string& trouble() const { return trouble_; }

    servobus::instant now() const { return clock(); }
    bool has_failed() const { return has_failed_; }
    /// How long a response may take to begin.
    servobus::duration longest_response() const { return response_limit(); }
    /// Waits for a drive that was lost, so that it gets its old words back. True if it responds.
    bool is_back(std::uint16_t address) {
        while (has_failed_ && may_try()) {
            const servobus::instant tried = clock();
            wait_now(servobus::milliseconds(200));
            is_silent_ = !responds(address);
            has_failed_ = is_silent_;
            note_try(tried);
        }
        return !has_failed_;
    }

    // What the drive keeps of the probe

    /// The owner's words of a register that is going to be changed. The first ones count.
    void note_old(std::uint16_t address, std::span<const std::uint16_t> words) {
        if (std::ranges::find(owned_, address, &owned::address) == owned_.end())
            owned_.push_back({address, {words.begin(), words.end()}});
    }
    /// The registers that were changed and are not known to hold their owner's words, in the order in which they are to
    /// get them: that of `note_old`, or the last one first.
    std::vector<changed_register> not_put_back() const {
        std::vector<changed_register> all;
        const auto is_back = [](const owned& o, const last_write& w) {
            return w.words == o.words && w.is_certain;
        };
        for (const owned& o : owned_) {
            const auto last = last_.find(o.address), kept = stored_.find(o.address);
            if (last != last_.end() && !is_back(o, last->second))
                all.push_back({o.address, o.words, last->second.words, last->second.is_certain});
            else if (kept != stored_.end() && !is_back(o, kept->second))
                all.push_back({o.address, o.words, kept->second.words, false});
        }
        if (is_last_first_) std::ranges::reverse(all);
        return all;
    }
    /// For a drive whose registers may not hold some words beside those of others.
    void put_back_last_first() { is_last_first_ = true; }
    /// The stops that had no response, in the order in which they were tried.
    const std::vector<unsafe_word>& unsafe() const { return unsafe_; }
    /// True from a save of the probe's words on, until the owner's are saved.
    bool has_saved() const { return has_saved_; }
    void set_saved(bool is_so) { has_saved_ = is_so; }
    /// From now on the drive stores what is written, or does not.
    void set_storing(bool is_so) { is_storing_ = is_so; }
    /// The order of the words of pairs, for a drive that can be set to one.
    bool is_low_first() const { return is_low_first_; }
    void set_low_first(bool is_so) { is_low_first_ = is_so; }

  protected:
    enum class written : std::uint8_t { yes, refused, unknown };

    /// The first reason of a failure. Returns false.
    bool fail(const std::string& why) {
        if (trouble_.empty()) trouble_ = why;
        return false;
    }

    /// No request since `begun` has had a response.
    void lose(servobus::instant begun) {
        if (!has_failed_) lost_at_ = begun;
        has_failed_ = true;
    }
    /// False if a drive that is silent since `begun` is not waited for any longer.
    bool has_patience(servobus::instant begun) const {
        return since(begun, clock()) + longest_try_ <= patience;
    }
    /// Notes how long a try took that may be repeated, so that the last one ends in time.
    void note_try(servobus::instant begun) { longest_try_ = longer_of(longest_try_, since(begun, clock())); }

  private:
    struct owned {
        std::uint16_t address;
        std::vector<std::uint16_t> words;
    };
    struct last_write {
        std::vector<std::uint16_t> words;
        bool is_certain;
    };

    bool may_try() const { return !is_silent_ || has_patience(lost_at_); }
    template <std::size_t N> std::array<std::uint16_t, N> read_words(std::uint16_t address) {
        std::array<std::uint16_t, N> words{};
        if (has_failed_) return words;
        const servobus::instant begun = clock();
        is_silent_ = !read_now(address, words);
        if (is_silent_) lose(begun);
        return is_silent_ ? std::array<std::uint16_t, N>{} : words;
    }
    written write_words(std::uint16_t address, std::span<const std::uint16_t> words) {
        const servobus::instant begun = clock();
        const written how = write_now(address, words);
        is_silent_ = how == written::unknown;
        if (is_silent_) lose(begun);
        if (how == written::refused) return how;
        const last_write now{{words.begin(), words.end()}, how == written::yes};
        last_[address] = now;
        if (is_storing_) stored_[address] = now;
        return how;
    }

    virtual bool read_now(std::uint16_t address, std::span<std::uint16_t> words) = 0;
    /// Reads a register once. False, without a complaint, if there is no response.
    virtual bool responds(std::uint16_t address) = 0;
    virtual written write_now(std::uint16_t address, std::span<const std::uint16_t> words) = 0;
    virtual void wait_now(servobus::duration time) = 0;
    virtual seen ask_now(const std::string& question) = 0;
    virtual bool has_consent(const std::string& what) = 0;
    /// A drive that stays silent then is lost.
    virtual bool power_cycle() = 0;
    virtual seen bad_crc_now() = 0;
    virtual seen look_at(std::uint8_t node) = 0;
    virtual std::optional<std::uint16_t> count_now(std::uint16_t address, std::uint16_t word) = 0;
    virtual servobus::instant clock() const = 0;
    virtual servobus::duration response_limit() const = 0;

    bool has_failed_ = false;
    bool is_silent_ = false;      // the last request had no response
    servobus::instant lost_at_{}; // where `has_failed_`
    servobus::duration longest_try_{};
    std::string trouble_{};
    std::vector<owned> owned_{};
    std::map<std::uint16_t, last_write> last_{};
    std::map<std::uint16_t, last_write> stored_{}; // at once, by a drive that does so
    std::vector<unsafe_word> unsafe_{};
    bool has_saved_ = false;
    bool is_storing_ = false;
    bool is_low_first_ = false;
    bool is_last_first_ = false;
};

} // namespace tool
