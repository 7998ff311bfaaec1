// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the programs that move a machine stand on: the port, the drive, its live table, and the care that a
// real machine asks for: typed consent, a stop on every way out.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include <servobus/line/reconnecting.hpp>
#include <servobus/servobus.hpp>

#include "host.hpp"

/// One drive on one port. A member that fails stops the drive and ends the program with status 1. `Machine`
/// says what is driven:
///
///     using device, feedback;                    // of the drive
///     template <class Line> using drive;
///     using stop;                                // a command that is repeated on every way out
///     static constexpr const char *name, *warning, *at_rest, *not_at_rest;
///     static constexpr unsigned lines;           // of its table
///     static void print(const feedback&);
///     static bool is_running(const feedback&), is_at_rest(const feedback&);
template <class Machine> class bench {
    using feedback = typename Machine::feedback;

  public:
    bench(int argc, char** argv)
        : simulator_{simulator_of(argc, argv)}, port_{argv[1], host::settings_of(Machine::device::facts)} {
        host::watch_for_interruptions();
        if (!port_.is_open()) {
            const std::string why = host::open_failure(argv[1], port_.why().error(), port_.port().os_error());
            end((std::string{"cannot open "} + argv[1] + ": " + why).c_str());
        }
        if (simulator_ == 0) host::ask_for_consent(Machine::warning);
        was_opened_ = true;
    }

    ~bench() { stop(); }
    bench(const bench&) = delete;
    bench& operator=(const bench&) = delete;

    /// Runs a command that has to succeed and does the same if it is carried out twice: three times if need be. A drive
    /// whose state is not known is taken over before. A signal does not wait for the command's end.
    template <class Command> void must(const Command& command) {
        for (int tries = 3;;) {
            const servobus::command_status how = run(command);
            if (how) return;
            if (--tries == 0 || how.outcome() == servobus::outcome::refused) end_at(how.error());
            if (drive_.state() == servobus::drive_state::needs_init) (void)run(servobus::init{});
        }
    }
    /// The same for a motion that must not begin twice: it is repeated only if no byte of it was sent.
    template <class Command> void must_once(const Command& command) {
        for (int tries = 3;;) {
            const servobus::command_status how = run(command);
            if (how) return;
            if (--tries == 0 || how.outcome() != servobus::outcome::not_sent || how.has_changed())
                end_at(how.error());
        }
    }

    /// Shows the drive for a while.
    void watch(servobus::duration time) {
        const servobus::instant start = port_.now();
        while (servobus::since(start, port_.now()) < time) show_once();
        end_table();
    }

    /// Shows the drive until it stands.
    void watch_until_standstill() {
        do show_once();
        while (Machine::is_running(shown_));
        end_table();
    }

    /// Pulls the simulated line's plug, or asks for it, and shows the drive until it is silent, at most 10 s.
    void pull_the_plug() {
        if (simulator_ != 0) {
            say("the plug is pulled for two seconds");
            if (!host::toggle_plug(simulator_))
                return say("not here: this system has no signal for the simulator");
        } else {
            say("pull the plug of the line within ten seconds, and put it back (or just wait)");
        }
        const servobus::instant start = port_.now();
        bool answers = true;
        while (answers && servobus::since(start, port_.now()) < servobus::milliseconds(10'000)) {
            check_signal();
            const auto f = drive_.read();
            answers = static_cast<bool>(f);
            if (answers) show(*f);
            pause();
        }
        end_table();
        if (!answers) std::printf("   no response: nothing more is known of the drive\n");
        if (simulator_ == 0) return;
        while (servobus::since(start, port_.now()) < servobus::milliseconds(2000)) pause();
        (void)host::toggle_plug(simulator_);
    }

    /// Initialises the drive, again and again until it answers; the port opens itself if it went away.
    void take_over(servobus::duration within) {
        const servobus::instant start = port_.now();
        for (;;) {
            check_signal();
            const servobus::command_status r = drive_.run(servobus::init{});
            if (r) break;
            if (servobus::since(start, port_.now()) > within) end_at(r.error());
            pause();
        }
        const auto f = look();
        show(*f);
        end_table();
        if (f->has_fault()) must(servobus::fault_reset{});
    }

    /// True if the last look showed the machine standing and free of faults.
    bool is_at_rest() {
        const auto f = look();
        const bool rests = Machine::is_at_rest(*f) && !f->has_fault();
        say(rests ? Machine::at_rest : Machine::not_at_rest);
        return rests;
    }

    /// Lets time pass, unless a signal ends the program.
    void rest(servobus::duration time) {
        const servobus::instant start = port_.now();
        while (servobus::since(start, port_.now()) < time) pause();
    }

    bool is_simulated() const { return simulator_ != 0; }
    auto& drive() { return drive_; }

    /// A heading; an end names the step that it begins.
    void say(const char* words) {
        step_ = words;
        std::printf("-- %s\n", words);
        std::fflush(stdout);
    }

  private:
    using port = servobus::reconnecting<host::serial>;
    using line = servobus::line<port>;

    // 0 for a real machine.
    static int simulator_of(int argc, char** argv) {
        const int pid = argc == 4 && std::strcmp(argv[2], "--simulator") == 0 ? std::atoi(argv[3]) : 0;
        if (argc == 2 || pid > 0) return pid;
        std::fprintf(stderr, "usage: %s PORT [--simulator PID]\n", Machine::name);
        std::exit(2);
    }

    void check_signal() {
        if (host::is_interrupted()) end("interrupted");
    }

    template <class Command> servobus::command_status run(const Command& command) {
        if (const auto begun = drive_.begin(command); !begun) end_at(begun.error());
        while (!drive_.is_idle()) {
            check_signal();
            wire_.sleep(drive_.step());
        }
        check_signal();
        return drive_.last();
    }
    [[noreturn]] void end_at(servobus::errc why) {
        end((std::string{step_} + ": " + servobus::text(why)).c_str());
    }
    [[noreturn]] void end(const char* why) {
        end_table();
        std::fprintf(stderr, "%s: %s\n", Machine::name, why);
        stop();
        std::exit(1);
    }

    // A stop is repeated until the drive says that it stands, or does not answer at all.
    void stop() {
        if (!was_opened_) return;
        for (int i = 0; i < 3; ++i) {
            const servobus::command_status r = drive_.run(typename Machine::stop{});
            if (r) return;
            // A stop at least as urgent is under way.
            while (r.error() == servobus::errc::busy && !drive_.is_idle()) wire_.sleep(drive_.step());
        }
        std::fprintf(stderr, "%s: the stop was not confirmed\n", Machine::name);
    }

    auto look() {
        auto f = drive_.read();
        for (int again = 0; !f && again < 2; ++again) f = drive_.read();
        if (!f) end_at(f.error());
        return f;
    }

    void pause() {
        check_signal();
        host::sleep_for(servobus::milliseconds(100));
    }

    void show_once() {
        check_signal();
        const auto f = look();
        if (f->has_fault()) end((std::string{step_} + ": the drive reports a fault").c_str());
        show(*f);
        pause();
    }

    // On a terminal the table is drawn over the last one, else the first, every fifth and the last look are
    // printed.
    void show(const feedback& f) {
        const bool is_terminal = host::is_terminal();
        if (is_terminal && looks_ != 0) std::printf("\033[%uA\r", Machine::lines);
        is_printed_ = is_terminal || looks_ % 5 == 0;
        shown_ = f;
        if (is_printed_) print(f);
        ++looks_;
    }

    static void print(const feedback& f) {
        Machine::print(f);
        std::fflush(stdout);
    }

    void end_table() {
        if (looks_ != 0 && !is_printed_) print(shown_);
        looks_ = 0;
    }

    const char* step_ = "opening the port";
    int simulator_;
    port port_;
    line wire_{port_, servobus::modbus::timing_at(Machine::device::facts.baud)};
    typename Machine::template drive<line> drive_{wire_, 1};
    feedback shown_{};
    unsigned looks_ = 0;
    bool is_printed_ = false;
    bool was_opened_ = false;
};
