// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus listen: explains the traffic of others as it passes, and never transmits.
#include <array>
#include <chrono>
#include <cstdio>

#include "../capture/capture.hpp"
#include "../capture/conversation.hpp"
#include "../os/interrupts.hpp"
#include "../os/listening_port.hpp"
#include "../os/log_file.hpp"
#include "../streams/messages.hpp"
#include "../streams/streams.hpp"
#include "../words/utc.hpp"
#include "commands.hpp"

namespace tool {
namespace {

constexpr moment shown_gap = 1'000'000; // us; a longer one is said

std::string milliseconds_text(moment us) {
    return std::to_string(us / 1000) + '.' + std::to_string(us / 100 % 10) + " ms";
}
std::string seconds_text(moment us) {
    const std::string thousandths = std::to_string(us / 1000 % 1000);
    return std::to_string(us / 1'000'000) + '.' + std::string(3 - thousandths.size(), '0') + thousandths;
}

const char* reason(piece::kind what) {
    switch (what) {
    case piece::kind::bad_crc: return "bad CRC";
    case piece::kind::incomplete: return "incomplete";
    case piece::kind::noise: return "noise";
    default: return "";
    }
}

/// The port's clock, which wraps, as time since the start.
class stopwatch {
  public:
    explicit stopwatch(servobus::instant start) : last_{start} {}
    moment at(servobus::instant now) {
        passed_ += since(last_, now).us;
        last_ = now;
        return passed_;
    }

  private:
    servobus::instant last_;
    moment passed_ = 0;
};

/// Standard output, and the FILE of --log.
class report {
  public:
    report(const line_devices& devices, log_file* log) : explainer_{devices}, log_{log} {}

    /// Each returns `done`, or the exit status.
    int frame(moment at, const piece& p, const heard& h) {
        const captured c{h.way, p.data};
        std::string text = explainer_.explain(c).text;
        if (h.after) text += " (after " + milliseconds_text(*h.after) + ')';
        if (h.is_unpaired) text += " (without a request)";
        const char* arrow = h.way == servobus::direction::unknown   ? "?"
                            : h.way == servobus::direction::request ? ">"
                                                                    : "<";
        print(at, arrow, text);
        // The time is a comment of its own, and both are one write: the file is whole after each frame.
        return finish("# " + time_text(at) + '\n' + line_of(c) + '\n');
    }
    int remark(moment at, const std::string& text) {
        print(at, "!", text);
        return finish("# " + time_text(at) + ' ' + text + '\n');
    }
    int begin(const std::string& what) {
        return log_ == nullptr ? done : log_->append("", "# " + time_text(0) + ' ' + what + '\n');
    }

  private:
    static void print(moment at, const char* sign, const std::string& text) {
        std::printf("%s %s %s\n", seconds_text(at).c_str(), sign, text.c_str());
    }
    int finish(const std::string& row) {
        if (log_ != nullptr) {
            if (const int status = log_->append("", row); status != done) return status;
        }
        return streams::flush() ? done : failed; // why is said at the end of the program
    }
    std::string time_text(moment at) const { return utc_text(start_ + std::chrono::microseconds{at}); }

    std::chrono::system_clock::time_point start_ = std::chrono::system_clock::now();
    frame_explainer explainer_;
    log_file* log_;
};

/// What was heard so far, and what is said of it.
class listener {
  public:
    listener(moment gap, moment timeout, report& out)
        : cutter_{gap}, frames_{timeout}, timeout_{timeout}, out_{&out} {}

    /// Bytes that had arrived by `now`; empty if there are none. Returns `done`, or the exit status.
    int take(servobus::bytes arrived, moment now) {
        if (arrived.empty())
            cutter_.elapse(now);
        else
            cutter_.feed(arrived, now);
        if (const int status = take_pieces(); status != done) return status;
        return cutter_.is_empty() && arrived.empty() ? report_overdue(now) : done;
    }
    int close() {
        cutter_.close();
        return take_pieces();
    }
    void stop_after(std::int64_t frames) { most_ = frames; }
    bool is_over() const { return most_ != 0 && count_ >= most_; }

    /// Lines that begin with #, as the comments of a capture do.
    void print_counters() const {
        for (std::size_t i = 0; i < frames_.counters().size(); ++i) {
            const node_counters& c = frames_.counters()[i];
            if (c.is_empty()) continue;
            std::printf("# node=%zu requests=%ju responses=%ju exceptions=%ju no_response=%ju damaged=%ju "
                        "unpaired=%ju slowest_ms=%ju.%ju\n",
                        i, std::uintmax_t{c.requests}, std::uintmax_t{c.responses},
                        std::uintmax_t{c.exceptions}, std::uintmax_t{c.no_response},
                        std::uintmax_t{c.damaged}, std::uintmax_t{c.unpaired},
                        std::uintmax_t{c.slowest / 1000}, std::uintmax_t{c.slowest / 100 % 10});
        }
        std::printf("# frames=%jd bad_crc=%ju incomplete=%ju noise=%ju damaged_bytes=%ju\n",
                    std::intmax_t{count_}, std::uintmax_t{bad_crc_}, std::uintmax_t{incomplete_},
                    std::uintmax_t{noise_}, std::uintmax_t{damaged_bytes_});
    }

  private:
    int take_pieces() {
        while (!is_over()) {
            const std::optional<piece> p = cutter_.next();
            if (!p) return done;
            int status = report_overdue(p->begin);
            if (status == done) status = report_gap(*p);
            if (status == done) status = take_piece(*p);
            if (status != done) return status;
            cutter_.expect(frames_.expected());
        }
        return done;
    }

    int take_piece(const piece& p) {
        const heard h = frames_.take(p);
        if (!p.is_frame()) {
            ++(p.what == piece::kind::bad_crc      ? bad_crc_
               : p.what == piece::kind::incomplete ? incomplete_
                                                   : noise_);
            damaged_bytes_ += p.data.size();
            return out_->remark(p.begin, std::string{reason(p.what)} + ": " + hex_text(p.data));
        }
        ++count_;
        if (h.unanswered) {
            const int status =
                out_->remark(p.begin, "no response from node " + std::to_string(*h.unanswered) +
                                          " before the next request");
            if (status != done) return status;
        }
        return out_->frame(p.begin, p, h);
    }

    int report_overdue(moment now) {
        const std::optional<std::uint8_t> node = frames_.overdue(now);
        if (!node) return done;
        return out_->remark(now, "no response from node " + std::to_string(*node) + " within " +
                                     std::to_string(timeout_ / 1000) + " ms");
    }

    int report_gap(const piece& p) {
        const moment gap = p.begin - last_;
        const bool is_shown = has_heard_ && gap > shown_gap;
        has_heard_ = true;
        last_ = p.end;
        return is_shown ? out_->remark(p.begin, "gap of " + seconds_text(gap) + " s") : done;
    }

    frame_cutter cutter_;
    conversation frames_;
    moment timeout_;
    report* out_;
    moment last_ = 0; // when the last byte had arrived
    bool has_heard_ = false;
    std::int64_t most_ = 0;
    std::int64_t count_ = 0;
    std::uint64_t bad_crc_ = 0;
    std::uint64_t incomplete_ = 0;
    std::uint64_t noise_ = 0;
    std::uint64_t damaged_bytes_ = 0;
};

// Returns `done` at the end that was asked for, or the exit status.
int run(listening_port& port, listener& ears) {
    stopwatch watch{port.now()};
    std::array<std::uint8_t, 512> chunk{};
    while (!interrupts::came() && !ears.is_over()) {
        // Before the port is asked: that it was empty then is what a gap is judged by.
        const moment asked = watch.at(port.now());
        const servobus::transfer came = port.receive(chunk);
        if (!came) {
            (void)ears.close();
            return complain(failed, why_text(target{}, came.status(), port.port()));
        }
        const moment now = *came != 0 ? watch.at(port.now()) : asked;
        const int status = ears.take(servobus::bytes{chunk}.first(*came), now);
        if (status != done) return status;
        // In slices, since a signal may come right before the sleep.
        if (*came == 0) port.wait(servobus::milliseconds(20));
    }
    return ears.close();
}

// FILE has frames, or nothing.
int open_log(log_file& log, const char* path) {
    if (const int status = log.open(path); status != done) return status;
    if (log.is_empty() || log.begins_with("#") || log.begins_with(">") || log.begins_with("<")) return done;
    return complain(usage, std::string{path} + ": it is no file of frames; give another file");
}

std::string joined(std::span<const std::string> words) {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
    return text;
}

} // namespace

int listen(const arguments& asked) {
    if (asked.words().size() < 2) return complain(usage, "listen takes PORT DEVICE[:NODE]...");
    const std::string& name = asked.words()[0];
    if (name.starts_with("mbap://"))
        return complain(usage, "a connection of Modbus TCP has no traffic of others to listen to");
    const bool is_network = any_port::is_network(name);
    if (is_network && !leaves_setting_to_gateway(asked)) return usage;
    const std::optional<line_devices> devices = line_devices::parse(std::span{asked.words()}.subspan(1));
    if (!devices) return usage;
    const servobus::profile& facts = devices->facts();
    const std::uint32_t limit =
        devices->longest_response().us / 1000 + (is_network ? network_delay.us / 1000 : 0);
    const auto setting = parse_rate_and_format(asked, {facts.baud, facts.format});
    const auto timeout = asked.number("timeout", 1, 60'000, limit);
    const auto count = asked.number("count", 1, INT32_MAX, 0);
    std::optional<servobus::duration> longest_pause;
    if (!setting || !timeout || !count || !parse_longest_pause(asked, longest_pause)) return usage;
    serial_settings settings{};
    settings.baud = setting->baud;
    settings.format = setting->format;
    std::optional<log_file> log;
    if (const char* path = asked.text("log")) {
        if (const int status = open_log(log.emplace(), path); status != done) return status;
    }
    listening_port port;
    if (const int status = port.open(name.c_str(), settings); status != done) return status;

    interrupts::arm();
    note("listening on " + name);
    report out{*devices, log ? &*log : nullptr};
    int status = out.begin(name + ' ' + joined(std::span{asked.words()}.subspan(1)));
    if (status != done) return status;
    const moment gap = timing_on(name, settings.baud, longest_pause).visible_gap().us;
    listener ears{gap, static_cast<moment>(*timeout) * 1000, out};
    ears.stop_after(*count);
    status = run(port, ears);
    ears.print_counters();
    return status;
}

} // namespace tool
