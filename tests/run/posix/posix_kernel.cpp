// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The hosted ports on a simulated kernel. It fails where a real one seldom does, and it has a UART, which a
// machine for tests lacks: a queue, a shift register, a driver that takes some settings and not others. All
// calls that it does not simulate go to the real kernel, on a pseudo-terminal.
#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include <fcntl.h>
#include <linux/serial.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include <doctest/doctest.h>

namespace test_kernel {
static int clock_gettime(clockid_t, timespec* to);
static int fcntl(int fd, int what, int flags = 0);
static int flock(int fd, int how);
static int fstat(int fd, struct stat* to);
static int grantpt(int fd);
static int ioctl(int fd, unsigned long what, void* with = nullptr);
static int isatty(int fd);
static int posix_openpt(int flags);
static int ptsname_r(int fd, char* to, std::size_t size);
static ssize_t read(int fd, void* to, std::size_t size);
static int tcgetattr(int fd, termios* to);
static int tcsetattr(int fd, int when, const termios* from);
static int unlockpt(int fd);
static ssize_t write(int fd, const void* from, std::size_t size);
} // namespace test_kernel
static int open_by_test(const char* path, int flags);

// The library calls the functions of the test, in a namespace of its own, since other tests use the real
// ones.
#define servobus servobus_over_a_test_kernel
#include <servobus/client/client.hpp>
#include <servobus/line/line.hpp>
#define clock_gettime test_kernel::clock_gettime
#define fcntl test_kernel::fcntl
#define flock test_kernel::flock
#define fstat test_kernel::fstat
#define grantpt test_kernel::grantpt
#define ioctl test_kernel::ioctl
#define isatty test_kernel::isatty
#define open open_by_test // the ports' member too
#define posix_openpt test_kernel::posix_openpt
#define ptsname_r test_kernel::ptsname_r
#define read test_kernel::read
#define tcgetattr test_kernel::tcgetattr
#define tcsetattr test_kernel::tcsetattr
#define unlockpt test_kernel::unlockpt
#define write test_kernel::write
#include <servobus/posix/pseudo_terminal.hpp>
#include <servobus/posix/serial.hpp>
#undef clock_gettime
#undef fcntl
#undef flock
#undef fstat
#undef grantpt
#undef ioctl
#undef isatty
#undef posix_openpt
#undef ptsname_r
#undef read
#undef tcgetattr
#undef tcsetattr
#undef unlockpt
#undef write

using namespace servobus;
using namespace servobus::posix;
using servobus::posix::detail::termios2;

namespace {

struct uart {
    bool is_there = false;
    unsigned major_number = 4; ///< of the first UARTs; a USB adapter's is 188
    termios settings{};
    tcflag_t not_taken = 0;     ///< bits of c_cflag that its driver leaves as they are
    std::int32_t speed_off = 0; ///< the speed that it sets is so much higher
    std::uint32_t any_speed = 0;
    serial_rs485 direction{};
    void (*replaces)(serial_rs485&) = nullptr; ///< a part of a mode, where RS-485 is switched on
    serial_struct facts{};
    bool takes_low_latency = true;
    bool tells_line_status = true;
    int queued = 0; ///< bytes that have not reached the shift register
    bool is_empty = true;
    bool is_exclusive = false;
    bool has_rts = true; ///< asserted, as the system does when a device is opened
};

struct state {
    std::string_view failing{}; ///< the call that fails,
    int error = 0;              ///< for this reason,
    unsigned spared = 0;        ///< after so many calls that succeed
    unsigned failures = 0;
    std::uint64_t time_us = 1'000'000;
    std::uint32_t delay_after_write_us = 0; ///< of the thread, once the bytes are on their way
    int access = -1;                        ///< of the last open: O_RDONLY, O_RDWR
    uart line{};
};
state kernel;

bool fails(std::string_view call) {
    if (call != kernel.failing) return false;
    if (kernel.spared != 0) {
        --kernel.spared;
        return false;
    }
    ++kernel.failures;
    errno = kernel.error;
    return true;
}

/// Makes this call fail during its lifetime.
class failing {
  public:
    failing(std::string_view call, int error, unsigned spared = 0) {
        kernel.failing = call;
        kernel.error = error;
        kernel.spared = spared;
        kernel.failures = 0;
    }
    failing(const failing&) = delete;
    ~failing() { kernel.failing = {}; }
    unsigned times() const { return kernel.failures; }
};

constexpr std::string_view name_of(unsigned long request) {
    switch (request) {
    case TCGETS2: return "TCGETS2";
    case TCSETS2: return "TCSETS2";
    case TIOCGRS485: return "TIOCGRS485";
    case TIOCSRS485: return "TIOCSRS485";
    case TIOCGSERIAL: return "TIOCGSERIAL";
    case TIOCSSERIAL: return "TIOCSSERIAL";
    case TIOCSERGETLSR: return "TIOCSERGETLSR";
    case TIOCOUTQ: return "TIOCOUTQ";
    default: return "ioctl";
    }
}

constexpr unsigned to_be_kept = CSIZE | CSTOPB | PARENB | PARODD;

} // namespace

namespace test_kernel {

int clock_gettime(clockid_t, timespec* to) {
    *to = {static_cast<time_t>(kernel.time_us / 1'000'000),
           static_cast<long>(kernel.time_us % 1'000'000) * 1000};
    return 0;
}
int fcntl(int fd, int what, int flags) {
    const std::string_view name = what == F_GETFL ? "F_GETFL" : what == F_SETFL ? "F_SETFL" : "F_SETFD";
    return fails(name) ? -1 : ::fcntl(fd, what, flags);
}
int flock(int fd, int how) { return fails("flock") ? -1 : ::flock(fd, how); }
int fstat(int fd, struct stat* to) {
    if (fails("fstat")) return -1;
    const int result = ::fstat(fd, to);
    if (kernel.line.is_there) to->st_rdev = makedev(kernel.line.major_number, 64);
    return result;
}
int grantpt(int fd) { return fails("grantpt") ? -1 : ::grantpt(fd); }
int isatty(int fd) { return fails("isatty") ? 0 : ::isatty(fd); }
int posix_openpt(int flags) { return fails("posix_openpt") ? -1 : ::posix_openpt(flags); }
int ptsname_r(int fd, char* to, std::size_t size) {
    return fails("ptsname_r") ? kernel.error : ::ptsname_r(fd, to, size);
}
ssize_t read(int fd, void* to, std::size_t size) { return fails("read") ? -1 : ::read(fd, to, size); }
ssize_t write(int fd, const void* from, std::size_t size) {
    if (fails("write")) return -1;
    const ssize_t n = ::write(fd, from, size);
    kernel.time_us += kernel.delay_after_write_us;
    return n;
}
int unlockpt(int fd) { return fails("unlockpt") ? -1 : ::unlockpt(fd); }
int tcgetattr(int fd, termios* to) {
    if (fails("tcgetattr")) return -1;
    if (!kernel.line.is_there) return ::tcgetattr(fd, to);
    *to = kernel.line.settings;
    return 0;
}
int tcsetattr(int fd, int when, const termios* from) {
    if (fails("tcsetattr")) return -1;
    if (!kernel.line.is_there) return ::tcsetattr(fd, when, from);
    uart& u = kernel.line;
    const tcflag_t before = u.settings.c_cflag;
    u.settings = *from;
    u.settings.c_cflag = (from->c_cflag & ~u.not_taken) | (before & u.not_taken);
    return 0;
}

int ioctl(int fd, unsigned long what, void* with) {
    if (fails(name_of(what))) return -1;
    uart& u = kernel.line;
    if (!u.is_there) return ::ioctl(fd, what, with);
    switch (what) {
    case TIOCEXCL: u.is_exclusive = true; return 0;
    case TIOCNXCL: u.is_exclusive = false; return 0;
    case TIOCMBIC:
        u.has_rts = u.has_rts && (*static_cast<int*>(with) & TIOCM_RTS) == 0;
        CHECK((*static_cast<int*>(with) & TIOCM_DTR) == 0); // some adapters have their power from it
        return 0;
    case TIOCGRS485: *static_cast<serial_rs485*>(with) = u.direction; return 0;
    case TIOCSRS485:
        u.direction = *static_cast<serial_rs485*>(with);
        if (u.replaces != nullptr && (u.direction.flags & SER_RS485_ENABLED) != 0) u.replaces(u.direction);
        return 0;
    case TIOCGSERIAL: *static_cast<serial_struct*>(with) = u.facts; return 0;
    case TIOCSSERIAL:
        if (u.takes_low_latency) u.facts = *static_cast<serial_struct*>(with);
        return 0;
    case TIOCOUTQ: *static_cast<int*>(with) = u.queued; return 0;
    case TIOCSERGETLSR:
        if (fd < 0 || !u.tells_line_status) break;
        *static_cast<int*>(with) = u.is_empty ? TIOCSER_TEMT : 0;
        return 0;
    case TCGETS2:
        static_cast<termios2*>(with)->c_ospeed =
            static_cast<speed_t>(static_cast<std::int64_t>(u.any_speed) + u.speed_off);
        return 0;
    case TCSETS2: u.any_speed = static_cast<termios2*>(with)->c_ospeed; return 0;
    default: break;
    }
    errno = ENOTTY;
    return -1;
}

} // namespace test_kernel

int open_by_test(const char* path, int flags) {
    kernel.access = flags & O_ACCMODE;
    return fails("open") ? -1 : ::openat(AT_FDCWD, path, flags);
}

namespace {

struct rig {
    pseudo_terminal wire;
    serial port;

    explicit rig(bool has_uart = true) {
        kernel = {};
        REQUIRE(wire.open() == errc::ok);
        kernel.line.is_there = has_uart;
    }
    rig(const rig&) = delete;
    ~rig() { kernel = {}; }
    status open_port(const serial_settings& wanted = {}) { return port.open(wire.path(), wanted); }
    bool has_sent_after(std::uint32_t us) {
        kernel.time_us += us;
        return port.sent();
    }
};

constexpr std::array<std::uint8_t, 8> eight{1, 2, 3, 4, 5, 6, 7, 8};

} // namespace

TEST_CASE(
    "sent() is true when a UART's queue and its shift register are empty and the time on the wire is over") {
    struct wire_time {
        serial_settings settings;
        std::uint32_t us;
    };
    for (const wire_time& w :
         {wire_time{{.baud = 9600}, 8334}, wire_time{{.baud = 9600, .format = character_format::e81}, 9167},
          wire_time{{.baud = 115200}, 695}, wire_time{{.baud = 1234}, 64830}}) {
        CAPTURE(w.settings.baud);
        rig r;
        REQUIRE(r.open_port(w.settings) == errc::ok);
        CHECK_FALSE(r.port.is_pseudo_terminal());
        CHECK(r.port.sent()); // nothing was sent
        REQUIRE(r.port.send(eight).value_or(0) == 8);
        kernel.line.queued = 8;
        kernel.line.is_empty = false;
        CHECK_FALSE(r.has_sent_after(0));
        CHECK_FALSE(r.has_sent_after(w.us)); // the driver is late
        kernel.line.queued = 0;
        CHECK_FALSE(r.has_sent_after(0));
        kernel.line.is_empty = true;
        CHECK(r.has_sent_after(0));
        // A second frame in two parts: their times add up.
        REQUIRE(r.port.send(bytes{eight}.first(4)).value_or(0) == 4);
        REQUIRE(r.port.send(bytes{eight}.first(4)).value_or(0) == 4);
        CHECK_FALSE(r.has_sent_after(w.us - 1)); // an empty queue: the time on the wire counts
        CHECK(r.has_sent_after(2));
        CHECK(r.port.sent());
        // A part that follows when the wire was free again has its own time.
        REQUIRE(r.port.send(bytes{eight}.first(1)));
        kernel.time_us += 50'000;
        REQUIRE(r.port.send(eight));
        CHECK_FALSE(r.has_sent_after(w.us - 1));
        CHECK(r.has_sent_after(1));
    }
}

TEST_CASE("a port that only receives cannot send, and does not switch a driver on by RTS") {
    for (const bool has_uart : {true, false}) {
        CAPTURE(has_uart);
        rig r{has_uart};
        REQUIRE(r.open_port({.receive_only = true}) == errc::ok);
        CHECK(kernel.access == O_RDONLY);
        CHECK(kernel.line.has_rts == !has_uart); // a pseudo-terminal has none
        CHECK(r.port.send(eight).error() == errc::send_failed);
        CHECK(r.port.is_open());
        CHECK(r.port.sent());
        REQUIRE(r.wire.send(bytes{eight}.first(3)).value_or(0) == 3);
        std::array<std::uint8_t, 8> room{};
        CHECK(r.port.receive(room).value_or(0) == 3);
        CHECK(r.wire.receive(room).value_or(9) == 0);
        r.port.close();
        CHECK(r.port.send(eight).error() == errc::port_lost); // not for what it may not do
        // The next one may send again.
        kernel.line.has_rts = true;
        REQUIRE(r.open_port() == errc::ok);
        CHECK(kernel.access == O_RDWR);
        CHECK(kernel.line.has_rts);
        CHECK(r.port.send(eight).value_or(0) == 8);
    }
}

TEST_CASE("where a driver does not report its line status, sent() goes by the time on the wire") {
    rig r;
    kernel.line.is_empty = false;
    SUBCASE("from the start") { kernel.line.tells_line_status = false; }
    SUBCASE("no longer after the port was opened") {}
    SUBCASE("nor what is in its queue") { kernel.line.queued = 8; }
    REQUIRE(r.open_port({.baud = 9600}) == errc::ok);
    kernel.line.tells_line_status = false;
    const failing f{kernel.line.queued != 0 ? "TIOCOUTQ" : "", ENOTTY};
    REQUIRE(r.port.send(eight));
    CHECK_FALSE(r.has_sent_after(8333));
    CHECK(r.has_sent_after(1));
}

TEST_CASE("an echo is dropped when sent() becomes true, unless it is wanted or a response may be in it") {
    const auto drops = [](const serial_settings& settings, std::uint32_t late_us) {
        rig r;
        REQUIRE(r.open_port(settings) == errc::ok);
        REQUIRE(r.port.send(eight));
        REQUIRE(r.wire.send(bytes{eight}.first(3)).value_or(0) == 3);
        const std::uint32_t us = settings.baud == 9600 ? 8334 : settings.baud == 19200 ? 4167 : 695;
        CHECK(r.has_sent_after(us + late_us));
        std::array<std::uint8_t, 8> room{};
        const std::uint16_t left = r.port.receive(room).value_or(99);
        REQUIRE((left == 0 || left == 3));
        return left == 0;
    };
    CHECK(drops({.baud = 9600}, 0));
    CHECK(drops({.baud = 9600}, 4010));
    CHECK_FALSE(drops({.baud = 9600}, 4011)); // t3.5 is 4010.4 us
    CHECK(drops({.baud = 19200}, 2005));
    CHECK_FALSE(drops({.baud = 19200}, 2006)); // 2005.2 us
    CHECK(drops({.baud = 115200}, 1749));
    CHECK_FALSE(drops({.baud = 115200}, 1750));
    CHECK_FALSE(drops({.baud = 9600, .keeps_echo = true}, 0));
}

TEST_CASE("an echo whose reading fails or that does not end keeps no request from having been sent") {
    const serial_settings slow{.baud = 9600};
    std::array<std::uint8_t, 64> room{};
    for (const int error : {EAGAIN, ENOMEM}) {
        rig r;
        REQUIRE(r.open_port(slow) == errc::ok);
        REQUIRE(r.port.send(eight));
        REQUIRE(r.wire.send(bytes{eight}.first(3)).value_or(0) == 3);
        const failing f{"read", error};
        CHECK(r.has_sent_after(8334));
        CHECK(f.times() == 1);
        CHECK(r.port.is_open());
    }
    rig r;
    REQUIRE(r.open_port(slow) == errc::ok);
    REQUIRE(r.port.send(eight));
    std::size_t waiting = 0; // of a line that never rests
    while (waiting < 1500) {
        const std::uint16_t n = r.wire.send(room).value_or(0);
        REQUIRE(n != 0);
        waiting += n;
    }
    CHECK(r.has_sent_after(8334));
    std::size_t left = 0;
    while (const std::uint16_t n = r.port.receive(room).value_or(0)) left += n;
    CHECK(left == waiting - 16 * 64);
}

namespace {

struct plain_device {
    static constexpr profile facts{.name = "plain", .exceptions = standard_exceptions};
};

/// A port on the test kernel, at whose other end an adapter returns all that it receives, and a drive answers each
/// request 3 ms later while it has power: 7 to a read, the request itself to a write of one register. Time passes in
/// `wait` only.
struct echoing_wire {
    rig* on;
    bool has_power = true;
    std::uint32_t standstill_us = 0; ///< of the program, in the next wait after a request
    std::array<std::uint8_t, 8> request{};
    std::uint64_t due_us = 0; ///< of the response; 0: none

    transfer send(bytes out) { return on->port.send(out); }
    bool sent() { return on->port.sent(); }
    transfer receive(byte_buffer in) { return on->port.receive(in); }
    instant now() const { return on->port.now(); }
    void wait(duration d) {
        constexpr auto read_of_7 = std::to_array<std::uint8_t>({1, 3, 2, 0, 7, 0xF9, 0x86});
        if (on->wire.receive(request).value_or(0) == 8) {
            (void)on->wire.send(request);
            due_us = has_power ? kernel.time_us + 3000 : 0;
            kernel.time_us += standstill_us;
            standstill_us = 0;
        }
        kernel.time_us += d.us;
        if (due_us == 0 || kernel.time_us < due_us) return;
        (void)on->wire.send(request[1] == 3 ? bytes{read_of_7} : bytes{request});
        due_us = 0;
    }
};

} // namespace

TEST_CASE("G3: on a wire that only echoes, a program that stood still takes no echo for a response") {
    rig r;
    REQUIRE(r.open_port({.baud = 115200}) == errc::ok);
    echoing_wire wire{&r};
    line bus{wire, modbus::timing_at(115200)};
    client<decltype(bus), plain_device> drive{bus, node<plain_device>{1}};
    u16 word = 0;
    REQUIRE(drive.read_words(0x2000, {&word, 1}));
    CHECK(word == 7);
    REQUIRE(drive.write_word(0x2000, 5));
    wire.has_power = false;
    const status before = drive.write_word(0x2000, 6);
    CHECK(before.error() == errc::timeout);
    wire.standstill_us = 5000;
    const status w = drive.write_word(0x2000, 6);
    CHECK(w.error() == errc::timeout);
    CHECK(w.outcome() == outcome::unknown);
}

TEST_CASE(
    "an adapter echoes if it returned the last request that was seen in time, also if the caller took some") {
    rig r;
    REQUIRE(r.open_port({.baud = 115200}) == errc::ok);
    std::array<std::uint8_t, 8> room{};
    const auto keeps_late_bytes = [&] {
        REQUIRE(r.port.send(eight));
        REQUIRE(r.wire.send(eight).value_or(0) == 8);
        CHECK(r.has_sent_after(695 + 1750));
        return r.port.receive(room).value_or(99) == 8;
    };
    const auto is_sent_with_echo_of = [&](std::size_t count) {
        REQUIRE(r.port.send(eight));
        if (count != 0) REQUIRE(r.wire.send(bytes{eight}.first(count)).value_or(0) == count);
        CHECK(r.has_sent_after(695 + 1749));
        CHECK(r.port.receive(room).value_or(99) == 0);
    };
    CHECK(keeps_late_bytes());
    for (const std::size_t noise : {0u, 1u, 7u}) {
        is_sent_with_echo_of(noise);
        REQUIRE(r.wire.send(eight).value_or(0) == 8);
        CHECK(r.port.receive(room).value_or(0) == 8); // the response
        CHECK(keeps_late_bytes());
    }
    SUBCASE("sent() finds all of them") { is_sent_with_echo_of(8); }
    SUBCASE("the caller receives some while the request leaves") {
        REQUIRE(r.port.send(eight));
        REQUIRE(r.wire.send(bytes{eight}.first(5)).value_or(0) == 5);
        CHECK(r.port.receive(room).value_or(0) == 5);
        REQUIRE(r.wire.send(bytes{eight}.first(3)).value_or(0) == 3);
        CHECK(r.has_sent_after(695));
    }
    CHECK_FALSE(keeps_late_bytes());
    { // what follows the echo is none
        REQUIRE(r.port.send(eight));
        REQUIRE(r.wire.send(eight).value_or(0) == 8);
        REQUIRE(r.wire.send(bytes{eight}.first(5)).value_or(0) == 5);
        CHECK(r.has_sent_after(695 + 1750));
        CHECK(r.port.receive(room).value_or(99) == 5);
    }
    r.port.close();
    REQUIRE(r.open_port({.baud = 115200}) == errc::ok);
    CHECK_FALSE(keeps_late_bytes());
    is_sent_with_echo_of(0); // another adapter
    CHECK(keeps_late_bytes());
}

TEST_CASE("a thread that is delayed as it hands a request over takes no response for an echo") {
    rig r;
    REQUIRE(r.open_port({.baud = 115200}) == errc::ok);
    kernel.delay_after_write_us = 3000;
    REQUIRE(r.port.send(eight)); // on the wire for 695 us; the response may begin 1750 us later
    kernel.delay_after_write_us = 0;
    REQUIRE(r.wire.send(bytes{eight}.first(3)).value_or(0) == 3);
    CHECK(r.port.sent());
    std::array<std::uint8_t, 8> room{};
    CHECK(r.port.receive(room).value_or(0) == 3);
}

TEST_CASE("what a lost port had taken counts as sent when its time on the wire is over") {
    rig r;
    REQUIRE(r.open_port({.baud = 9600}) == errc::ok);
    REQUIRE(r.port.send(eight));
    kernel.line.queued = 8;
    std::array<std::uint8_t, 8> room{};
    {
        const failing f{"read", ENODEV};
        CHECK(r.port.receive(room).error() == errc::port_lost);
    }
    CHECK_FALSE(r.port.is_open());
    CHECK_FALSE(r.has_sent_after(8333));
    CHECK(r.has_sent_after(1));
}

TEST_CASE("a UART is open for one program only, and free again when it is closed") {
    rig r;
    REQUIRE(r.open_port() == errc::ok);
    CHECK(kernel.line.is_exclusive);
    r.port.close();
    CHECK_FALSE(kernel.line.is_exclusive);
    const failing f{"open", EBUSY};
    CHECK(r.open_port() == errc::port_in_use);
    CHECK(r.port.os_error() == EBUSY);
}

TEST_CASE("G47: why a device cannot be opened") {
    struct reason {
        std::string_view call;
        int error;
        errc why;
    };
    for (const reason& x :
         {reason{"open", ENOENT, errc::no_such_port}, reason{"open", ENOTDIR, errc::no_such_port},
          reason{"open", ENODEV, errc::no_such_port}, reason{"open", ENXIO, errc::no_such_port},
          reason{"open", EACCES, errc::no_permission}, reason{"open", EPERM, errc::no_permission},
          reason{"open", EBUSY, errc::port_in_use}, reason{"flock", EWOULDBLOCK, errc::port_in_use},
          reason{"flock", ENOLCK, errc::port_lost}, reason{"open", EMFILE, errc::port_lost},
          reason{"isatty", EIO, errc::no_such_port}, reason{"isatty", ENOTTY, errc::bad_argument}}) {
        CAPTURE(std::string{x.call});
        CAPTURE(x.error);
        rig r;
        const failing f{x.call, x.error};
        CHECK(r.open_port() == x.why);
        CHECK(r.port.os_error() == x.error);
        CHECK_FALSE(r.port.is_open());
    }
}

TEST_CASE("a pseudo-terminal is not exclusive, and a port of unknown kind counts as a UART") {
    rig r{false};
    REQUIRE(r.open_port() == errc::ok);
    CHECK(r.port.is_pseudo_terminal());
    r.port.close();
    const failing f{"fstat", EOVERFLOW};
    REQUIRE(r.open_port() == errc::ok);
    CHECK_FALSE(r.port.is_pseudo_terminal());
}

TEST_CASE("a port is recognised as a pseudo-terminal by its device's number") {
    for (const unsigned number : {4u, 135u, 136u, 143u, 144u, 166u, 188u}) {
        CAPTURE(number);
        rig r;
        kernel.line.major_number = number;
        REQUIRE(r.open_port() == errc::ok);
        CHECK(r.port.is_pseudo_terminal() == (number >= 136 && number <= 143));
    }
}

TEST_CASE(
    "G31: the RS-485 driver is switched as the kernel has it from the board, with its polarity and delays") {
    constexpr std::uint32_t others = SER_RS485_RX_DURING_TX | SER_RS485_TERMINATE_BUS;
    struct board {
        std::uint32_t states, becomes;
    };
    for (const board& b :
         {board{0, SER_RS485_RTS_ON_SEND}, board{SER_RS485_RTS_ON_SEND, SER_RS485_RTS_ON_SEND},
          board{SER_RS485_RTS_AFTER_SEND, SER_RS485_RTS_AFTER_SEND}}) {
        CAPTURE(b.states);
        rig r;
        kernel.line.direction.flags = b.states | others;
        kernel.line.direction.delay_rts_before_send = 5;
        kernel.line.direction.delay_rts_after_send = 4;
        REQUIRE(r.open_port() == errc::ok); // not wanted: left as it is
        CHECK(kernel.line.direction.flags == (b.states | others));
        REQUIRE(r.open_port({.baud = 9600, .rs485 = true}) == errc::ok);
        const serial_rs485& d = kernel.line.direction;
        CHECK(d.flags == (SER_RS485_ENABLED | b.becomes | others));
        CHECK(d.delay_rts_before_send == 5);
        CHECK(d.delay_rts_after_send == 4);
    }
}

TEST_CASE("G31: a program states the polarity and the delays of the RS-485 driver, in whole milliseconds") {
    using enum rs485_polarity;
    rig r;
    kernel.line.direction.flags = SER_RS485_RTS_ON_SEND | SER_RS485_TERMINATE_BUS;
    kernel.line.direction.delay_rts_before_send = 5;
    kernel.line.direction.delay_rts_after_send = 90;
    serial_settings wanted{.baud = 9600, .rs485 = true};
    wanted.driver = {rts_after_send, microseconds(1001), duration{}};
    REQUIRE(r.open_port(wanted) == errc::ok);
    const serial_rs485& d = kernel.line.direction;
    CHECK(d.flags == (SER_RS485_ENABLED | SER_RS485_RTS_AFTER_SEND | SER_RS485_TERMINATE_BUS));
    CHECK(d.delay_rts_before_send == 2);
    CHECK(d.delay_rts_after_send == 0);
    wanted.driver = {.polarity = rts_on_send, .after_send = milliseconds(3)};
    REQUIRE(r.open_port(wanted) == errc::ok);
    CHECK(d.flags == (SER_RS485_ENABLED | SER_RS485_RTS_ON_SEND | SER_RS485_TERMINATE_BUS));
    CHECK(d.delay_rts_before_send == 2);
    CHECK(d.delay_rts_after_send == 3);
}

TEST_CASE("G31: a port whose RS-485 driver would be switched off later than t3.5 is not opened") {
    struct rate {
        std::uint32_t baud, longest_ms; // 3.5 x 11 bits, 1750 us above 19200 Bd
    };
    for (const rate& w : {rate{4800, 8}, rate{9600, 4}, rate{19'200, 2}, rate{115'200, 1}}) {
        for (const bool is_stated : {false, true}) {
            CAPTURE(w.baud);
            CAPTURE(is_stated);
            rig r;
            const auto open_with = [&](std::uint32_t ms) {
                serial_settings wanted{.baud = w.baud, .rs485 = true};
                kernel.line.direction = {};
                kernel.line.direction.flags = SER_RS485_RTS_AFTER_SEND;
                kernel.line.direction.delay_rts_after_send = is_stated ? 77 : ms;
                if (is_stated) wanted.driver.after_send = milliseconds(ms);
                return r.open_port(wanted);
            };
            CHECK(open_with(w.longest_ms) == errc::ok);
            CHECK(kernel.line.direction.flags == (SER_RS485_ENABLED | SER_RS485_RTS_AFTER_SEND));
            CHECK(open_with(w.longest_ms + 1) == errc::rs485_late);
            CHECK_FALSE(r.port.is_open());
            CHECK(kernel.line.direction.flags == SER_RS485_RTS_AFTER_SEND); // nothing was changed
        }
    }
    rig r;
    kernel.line.direction.delay_rts_after_send = 0xFFFF'FFFF;
    CHECK(r.open_port({.rs485 = true}) == errc::rs485_late);
}

TEST_CASE("G31: an RS-485 mode that the port's driver refuses or replaces is an error, and leaves the mode "
          "as it was") {
    for (const std::string_view call : {"TIOCGRS485", "TIOCSRS485"}) {
        for (const int error : {EINVAL, ENOTTY}) {
            rig r;
            const failing f{call, error};
            CHECK(r.open_port({.rs485 = true}) == errc::rs485_refused);
            CHECK(r.port.os_error() == error);
            CHECK_FALSE(r.port.is_open());
        }
        rig r;
        const failing f{call, EIO}; // unplugged meanwhile
        CHECK(r.open_port({.rs485 = true}) == errc::port_lost);
        CHECK(r.port.os_error() == EIO);
    }
    struct replacement {
        void (*replaces)(serial_rs485&);
        errc why;
    };
    for (const replacement& x :
         {replacement{[](serial_rs485& m) { m.flags &= ~std::uint32_t{SER_RS485_ENABLED}; },
                      errc::rs485_refused},
          replacement{[](serial_rs485& m) { m.flags ^= SER_RS485_RTS_ON_SEND | SER_RS485_RTS_AFTER_SEND; },
                      errc::rs485_refused},
          replacement{[](serial_rs485& m) { m.delay_rts_before_send = 0; }, errc::rs485_refused},
          replacement{[](serial_rs485& m) { m.delay_rts_after_send = 0; }, errc::rs485_refused},
          replacement{[](serial_rs485& m) { m.delay_rts_after_send = 100; }, errc::rs485_late}}) {
        rig r;
        kernel.line.direction.flags = SER_RS485_TERMINATE_BUS;
        kernel.line.replaces = x.replaces;
        serial_settings wanted{.baud = 9600, .rs485 = true};
        wanted.driver = {rs485_polarity::rts_after_send, milliseconds(2), milliseconds(1)};
        CHECK(r.open_port(wanted) == x.why);
        CHECK_FALSE(r.port.is_open());
        CHECK(kernel.line.direction.flags == SER_RS485_TERMINATE_BUS);
    }
    // Hardware with one polarity, and a program that states none.
    rig r;
    kernel.line.replaces = [](serial_rs485& m) {
        m.flags &= ~std::uint32_t{SER_RS485_RTS_ON_SEND};
        m.flags |= SER_RS485_RTS_AFTER_SEND;
    };
    CHECK(r.open_port({.rs485 = true}) == errc::ok);
}

TEST_CASE("G31: the delay of the RS-485 driver before the first bit counts as time of sending") {
    rig r;
    kernel.line.tells_line_status = false;
    kernel.line.direction.delay_rts_before_send = 5;
    for (const std::uint32_t delay_us : {5000u, 0u}) {
        REQUIRE(r.open_port({.baud = 9600, .rs485 = delay_us != 0}) == errc::ok);
        REQUIRE(r.port.send(bytes{eight}.first(4)).value_or(0) == 4);
        REQUIRE(r.port.send(bytes{eight}.last(4)).value_or(0) == 4);
        CHECK_FALSE(r.has_sent_after(delay_us + 8333));
        CHECK(r.has_sent_after(2));
    }
}

TEST_CASE("low latency is requested if it is wanted, and reported only if the driver keeps it") {
    constexpr auto low_latency = static_cast<int>(ASYNC_LOW_LATENCY);
    rig r;
    kernel.line.facts.flags = 0x0010;
    REQUIRE(r.open_port({.low_latency = false}) == errc::ok);
    CHECK_FALSE(r.port.has_low_latency());
    CHECK(kernel.line.facts.flags == 0x0010);
    REQUIRE(r.open_port() == errc::ok);
    CHECK(r.port.has_low_latency());
    CHECK(kernel.line.facts.flags == (0x0010 | low_latency));
    for (const unsigned spared : {0u, 1u}) {
        const failing f{"TIOCGSERIAL", ENOTTY, spared};
        REQUIRE(r.open_port() == errc::ok);
        CHECK_FALSE(r.port.has_low_latency());
    }
    {
        const failing f{"TIOCSSERIAL", EPERM};
        REQUIRE(r.open_port() == errc::ok);
        CHECK_FALSE(r.port.has_low_latency());
    }
    kernel.line.facts.flags = 0;
    kernel.line.takes_low_latency = false;
    REQUIRE(r.open_port() == errc::ok);
    CHECK_FALSE(r.port.has_low_latency());
}

TEST_CASE("a port whose driver does not take the format or the speed is not opened") {
    using enum character_format;
    struct wish {
        character_format format;
        tcflag_t bits;
    };
    for (const wish& w : {wish{n81, 0}, wish{n82, CSTOPB}, wish{e81, PARENB}, wish{o81, PARENB | PARODD}}) {
        rig r;
        REQUIRE(r.open_port({.baud = 19200, .format = w.format}) == errc::ok);
        CHECK((kernel.line.settings.c_cflag & to_be_kept) == (CS8 | w.bits));
        CHECK((kernel.line.settings.c_iflag & INPCK) == ((w.bits & PARENB) != 0 ? tcflag_t{INPCK} : 0u));
        CHECK(::cfgetospeed(&kernel.line.settings) == B19200);
        for (const tcflag_t bit : {tcflag_t{CSTOPB}, tcflag_t{PARENB}, tcflag_t{PARODD}}) {
            kernel.line.settings.c_cflag = CS8;
            kernel.line.not_taken = bit;
            const bool is_needed = (w.bits & bit) != 0;
            CHECK(r.open_port({.format = w.format}) == (is_needed ? errc::bad_argument : errc::ok));
            if (is_needed) CHECK(r.port.os_error() == EINVAL);
        }
        kernel.line.settings.c_cflag = CS7;
        kernel.line.not_taken = CSIZE;
        CHECK(r.open_port({.format = w.format}) == errc::bad_argument);
    }
    rig r;
    kernel.line.not_taken = CBAUD;
    kernel.line.settings.c_cflag = B9600;
    CHECK(r.open_port({.baud = 19200}) == errc::bad_argument);
    CHECK(r.open_port({.baud = 9600}) == errc::ok);
}

TEST_CASE("the speed that a driver sets may be 3 % away, either way, and no more") {
    for (const std::int32_t percent_off : {-50, -4, -3, 0, 3, 4, 50}) {
        CAPTURE(percent_off);
        rig r;
        kernel.line.speed_off = percent_off * 1280;
        const bool is_near = percent_off >= -3 && percent_off <= 3;
        CHECK(r.open_port({.baud = 128'000}) == (is_near ? errc::ok : errc::bad_argument));
        CHECK(kernel.line.any_speed == 128'000);
        if (!is_near) CHECK(r.port.os_error() == EINVAL);
    }
}

TEST_CASE("the settings of a device are those of its profile") {
    constexpr profile facts{.name = "any", .baud = 57'600, .format = character_format::e81};
    const serial_settings s = settings_of(facts);
    CHECK(s.baud == 57'600);
    CHECK(s.format == character_format::e81);
    CHECK_FALSE(s.rs485);
    CHECK_FALSE(s.keeps_echo);
    CHECK(s.low_latency);
    static_assert(settings_of(facts).baud == 57'600);
}

TEST_CASE("a call that fails while a port is opened is reported with its reason, and the port stays closed") {
    struct call {
        std::string_view name;
        errc why;
        unsigned spared = 0;
    };
    for (const call& c : {call{"open", errc::port_lost}, call{"flock", errc::port_lost},
                          call{"tcgetattr", errc::bad_argument}, call{"tcgetattr", errc::bad_argument, 1},
                          call{"tcsetattr", errc::bad_argument}, call{"TCGETS2", errc::bad_argument},
                          call{"TCGETS2", errc::bad_argument, 1}, call{"TCSETS2", errc::bad_argument}}) {
        CAPTURE(std::string{c.name});
        CAPTURE(c.spared);
        rig r;
        const failing f{c.name, ENOMEM, c.spared};
        CHECK(r.open_port({.baud = 123'456}) == c.why);
        CHECK(f.times() == 1);
        CHECK(r.port.os_error() == ENOMEM);
        CHECK_FALSE(r.port.is_open());
    }
    for (const std::string_view name : {"posix_openpt", "grantpt", "unlockpt", "F_GETFL", "F_SETFL",
                                        "F_SETFD", "tcgetattr", "tcsetattr", "ptsname_r"}) {
        CAPTURE(std::string{name});
        rig r{false};
        const failing f{name, ENOMEM};
        CHECK(r.wire.open() == errc::port_lost);
        CHECK(f.times() == 1);
        CHECK(r.wire.os_error() == ENOMEM);
        CHECK_FALSE(r.wire.is_open());
    }
}

TEST_CASE("a port is lost after the errors that mean so, and after no others") {
    std::array<std::uint8_t, 8> room{};
    for (const int error : {EIO, ENXIO, ENODEV, EBADF, EPIPE, ESHUTDOWN, EINVAL, ENOMEM, EFAULT}) {
        CAPTURE(error);
        const bool is_gone = error != EINVAL && error != ENOMEM && error != EFAULT;
        for (const bool is_sending : {false, true}) {
            rig r;
            REQUIRE(r.open_port() == errc::ok);
            {
                const failing f{is_sending ? "write" : "read", error};
                const errc otherwise = is_sending ? errc::send_failed : errc::receive_failed;
                const transfer t = is_sending ? r.port.send(eight) : r.port.receive(room);
                CHECK(t.error() == (is_gone ? errc::port_lost : otherwise));
                CHECK(f.times() == 1);
            }
            CHECK(r.port.os_error() == (error == EBADF ? 0 : error));
            CHECK(r.port.is_open() == !is_gone);
        }
    }
}

TEST_CASE("on the drive's side of a pseudo-terminal it is no error if a program closes its end") {
    std::array<std::uint8_t, 8> room{};
    for (const bool is_sending : {false, true}) {
        const auto transfer_of = [&](rig& r, int error) {
            REQUIRE(r.open_port() == errc::ok);
            const failing f{is_sending ? "write" : "read", error}; // it closes it between check and transfer
            const transfer t = is_sending ? r.wire.send(eight) : r.wire.receive(room);
            CHECK(f.times() == 1);
            return t;
        };
        rig r{false};
        CHECK(transfer_of(r, EIO).value_or(99) == 0);
        if (!is_sending) CHECK(transfer_of(r, EPIPE).value_or(99) == 0); // so some systems say it
        CHECK(r.wire.os_error() == 0);
        CHECK(transfer_of(r, ENODEV).error() == errc::port_lost);
        CHECK(r.wire.os_error() == ENODEV);
        CHECK(transfer_of(r, EINVAL).error() == (is_sending ? errc::send_failed : errc::receive_failed));
        CHECK(r.wire.is_open());
    }
}

TEST_CASE("a transfer that signals interrupt again and again moves nothing, and returns") {
    rig r;
    REQUIRE(r.open_port() == errc::ok);
    std::array<std::uint8_t, 8> room{};
    {
        const failing f{"write", EINTR};
        CHECK(r.port.send(eight).value_or(99) == 0);
        CHECK(f.times() >= 2);
        CHECK(f.times() <= 100);
    }
    REQUIRE(r.wire.send(eight).value_or(0) == 8);
    {
        const failing f{"read", EINTR};
        CHECK(r.port.receive(room).value_or(99) == 0);
        CHECK(f.times() >= 2);
        CHECK(f.times() <= 100);
    }
    CHECK(r.port.receive(room).value_or(0) == 8); // nothing is lost
    CHECK(room == eight);
}
