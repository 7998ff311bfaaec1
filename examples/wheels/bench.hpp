// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What the wheel program stands on: the port, the drive, its live table, and the care that a real machine
// asks for: typed consent, a stop on every way out.
#pragma once

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <signal.h>
#include <unistd.h>

#include <servobus/device/zlac8015d.hpp>
#include <servobus/posix/serial.hpp>
#include <servobus/servobus.hpp>

/// One drive on one port. A member that fails stops the drive and ends the program with status 1.
class bench {
  public:
    bench(int argc, char** argv) {
        if (argc == 4 && std::strcmp(argv[2], "--simulator") == 0) simulator_ = std::atoi(argv[3]);
        if (argc < 2 || (argc != 2 && simulator_ <= 0)) {
            std::fprintf(stderr, "usage: wheels PORT [--simulator PID]\n");
            std::exit(2);
        }
        path_ = argv[1];
        std::signal(SIGINT, on_signal);
        std::signal(SIGTERM, on_signal);
        std::signal(SIGHUP, on_signal);
        std::signal(SIGPIPE, SIG_IGN); // a reader that goes away must not end it without a stop
        if (simulator_ == 0) ask_for_consent();
        if (open() != servobus::errc::ok) end("cannot open the port");
        was_opened_ = true;
    }

    ~bench() { stop(); }
    bench(const bench&) = delete;
    bench& operator=(const bench&) = delete;

    /// Runs an order that has to succeed.
    template <class Order> void must(const Order& order) {
        check_signal();
        const servobus::report r = drive_.run(order);
        if (!r) end(servobus::text(r.error()));
    }

    /// Shows the drive for a while.
    void watch(servobus::duration time) {
        const servobus::instant start = port_.now();
        while (servobus::since(start, port_.now()) < time) show_once();
        end_table();
    }

    /// Shows the drive until both wheels stand.
    void watch_until_standstill() {
        do show_once();
        while (drive_.seen().state.is_running());
        end_table();
    }

    /// Pulls the simulated line's plug, or asks for it, and shows the drive until it is silent, at most 10 s.
    void pull_the_plug() {
        if (simulator_ != 0) {
            say("the plug is pulled for two seconds");
            ::kill(simulator_, SIGUSR1);
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
        if (!answers) std::printf("   no answer: nothing more is believed of the drive\n");
        if (simulator_ == 0) return;
        while (servobus::since(start, port_.now()) < servobus::milliseconds(2000)) pause();
        ::kill(simulator_, SIGUSR1);
    }

    /// Initialises the drive, again and again until it answers; opens the port anew if it went away.
    void take_over(servobus::duration within) {
        const servobus::instant start = port_.now();
        for (;;) {
            check_signal();
            const servobus::report r = drive_.run(servobus::zlac8015d::init{});
            if (r) break;
            if (servobus::since(start, port_.now()) > within) end(servobus::text(r.error()));
            if (r.error() == servobus::errc::port_lost) (void)open();
            pause();
        }
        const auto f = drive_.read();
        if (!f) end(servobus::text(f.error()));
        show(*f);
        end_table();
        if (f->any_fault()) must(servobus::zlac8015d::fault_reset{});
    }

    /// True if the last look showed both wheels standing and free of faults.
    bool both_at_rest() {
        const auto f = drive_.read();
        if (!f) end(servobus::text(f.error()));
        const bool rests =
            !f->state.is_running() && f->left_speed.count() == 0 && f->right_speed.count() == 0;
        say(rests && !f->any_fault() ? "both wheels at rest" : "the wheels are not at rest");
        return rests && !f->any_fault();
    }

    void say(const char* words) {
        std::printf("-- %s\n", words);
        std::fflush(stdout);
    }

  private:
    using line = servobus::line<servobus::posix::serial>;

    static void on_signal(int) { interrupted_ = 1; }

    servobus::errc open() {
        return port_.open(path_, servobus::posix::settings_of(servobus::zlac8015d::device::facts));
    }

    void ask_for_consent() {
        std::printf(
            "This moves a real machine at up to 30 r/min. Lift the wheels off the ground, keep a wired\n"
            "emergency stop at hand: this program is no safety function.\nType MOVE to go on: ");
        std::fflush(stdout);
        char answer[16] = {};
        if (std::fgets(answer, sizeof answer, stdin) == nullptr || std::strcmp(answer, "MOVE\n") != 0) {
            std::printf("Nothing was sent.\n");
            std::exit(2);
        }
    }

    void check_signal() {
        if (interrupted_ != 0) end("interrupted");
    }

    [[noreturn]] void end(const char* why) {
        end_table();
        std::fprintf(stderr, "wheels: %s\n", why);
        stop();
        std::exit(1);
    }

    // A stop is repeated until the drive says that it stands, or does not answer at all.
    void stop() {
        if (!was_opened_) return;
        for (int i = 0; i < 3; ++i) {
            if (drive_.run(servobus::zlac8015d::disable{})) return;
        }
        std::fprintf(stderr, "wheels: the stop was not confirmed\n");
    }

    void pause() {
        check_signal();
        ::usleep(100'000);
    }

    void show_once() {
        check_signal();
        const auto f = drive_.read();
        if (!f) end(servobus::text(f.error()));
        if (f->any_fault()) end("the drive reports a fault");
        show(*f);
        pause();
    }

    static void show_wheel(const char* name, servobus::i32 tenths, servobus::i32 counts, unsigned faults) {
        std::printf("   %-5s %6.1f r/min %9ld counts  faults %04x\n", name, tenths / 10.0,
                    static_cast<long>(counts), faults);
    }

    static void print(const servobus::zlac8015d::feedback& f) {
        show_wheel("left", f.left_speed.count(), f.left_position.count(), f.left_faults.bits);
        show_wheel("right", f.right_speed.count(), f.right_position.count(), f.right_faults.bits);
        std::fflush(stdout);
    }

    // On a terminal the two lines are drawn over the last ones, else the first, every fifth and the last look
    // are printed.
    void show(const servobus::zlac8015d::feedback& f) {
        const bool is_terminal = ::isatty(STDOUT_FILENO) == 1;
        if (is_terminal && looks_ != 0) std::printf("\033[2A\r");
        is_printed_ = is_terminal || looks_ % 5 == 0;
        if (is_printed_) print(f);
        ++looks_;
    }

    void end_table() {
        if (looks_ != 0 && !is_printed_) print(drive_.seen());
        looks_ = 0;
    }

    static inline volatile std::sig_atomic_t interrupted_ = 0;

    const char* path_ = nullptr;
    pid_t simulator_ = 0;
    servobus::posix::serial port_;
    line wire_{port_, servobus::modbus::timing_at(servobus::zlac8015d::device::facts.baud)};
    servobus::zlac8015d::drive<line> drive_{wire_, 1};
    unsigned looks_ = 0;
    bool is_printed_ = false;
    bool was_opened_ = false;
};
