// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// servobus: maps, explains, simulates, reads and writes motor drives on Modbus RTU.
//
//     g++ -std=c++20 -Iinclude examples/servobus/*.cpp -o servobus
#include <cstdio>
#include <string_view>

#include <servobus/core/version.hpp>

#include "streams.hpp"
#include "tool.hpp"

namespace {

constexpr const char help[] = R"(servobus: motor drives on Modbus RTU, from the command line

  servobus map DEVICE                 the register map as CSV
  servobus alarms c630s               the drive's alarms as CSV
  servobus explain DEVICE[:NODE]... [--hex]    frames from standard input, each in words
  servobus sim DEVICE                 a simulated drive on a pseudo-terminal
  servobus read PORT DEVICE[:NODE] REG... [--csv|--json] [--log FILE]
  servobus write PORT DEVICE[:NODE] REG=VALUE... [--yes]
  servobus watch PORT DEVICE[:NODE] REG... [--csv|--json] [--log FILE]
  servobus scan PORT
  servobus listen PORT DEVICE[:NODE]... [--log FILE]
  servobus backup PORT DEVICE[:NODE] [FILE]
  servobus restore PORT DEVICE[:NODE] FILE [--dry-run] [--yes] [--save] [--part]
  servobus --version

DEVICE  zlac8015d, yako-closed-loop, yako-open-loop or c630s; for read, write, watch, listen and explain also raw:
        any device, without a map.
NODE    the address on the line; from the factory 1.
PORT    a serial device; tcp://HOST:PORT, a gateway that carries RTU frames over TCP; mbap://HOST[:PORT], a gateway
        or device of Modbus TCP, 502 if no port is given. IPv6: tcp://[::1]:4001. A response may take half a second
        longer there than the drive's own limit, unless --timeout is given. A gateway that repeats requests by
        itself is not to be used.
REG     a name from the map or an address, 0x2088; of a c630s also a parameter number, P0B-17. For raw:
        ADDRESS or ADDRESS:COUNT.
VALUE   in the register's unit, exactly: left_max_current=12.5 is 12.5 A. What the register cannot hold is
        refused and nothing is sent. A code by its name, with _ for a blank, or by its number:
        control_word=quick_stop; bits by their names: input_polarity=x0+x1. 0x... is the register's content
        as it is, also for a signed one: 0xFF9C is -100. Where another register sets the scale
        (left_target_speed) VALUE is a whole number of counts. What a zlac8015d does with host_timeout=0 is not
        documented: only raw 0x2000=0 writes it, and restore does not. For raw: a whole number, or COUNT of them with
        commas, which are one frame.

read and watch print name=value unit. write checks every REG=VALUE before it sends anything, writes them one
by one in their order and stops at the first failure. A write is sent once, never again by itself. If one of
them may move a machine (a target, a start, an address without a map; not a stop) write says so and asks
first. Where a drive can switch the word order of its 32-bit values, it is read from it before the first of them.

backup writes every parameter, a line of text each, to FILE (only once all are read) or to standard output. A
file that exists is replaced as a whole, or stays as it is if anything fails; it keeps its mode, and its owner where
that is allowed. Symbolic links are followed. A device, a FIFO or a pipe is written into; a block device, a folder, a
link to nothing and PORT itself are refused.
restore checks the whole file before it sends anything and refuses while the drive is enabled or moves. It
skips triggers, targets and the settings of the line, writes only what differs, reads each back and stops at
the first failure; run again, it goes on there. Before it writes it says how many writes into the EEPROM that
costs. A register that a backup marks with ? (the drive refused to give it, or holds what its manual does not
allow) is left alone.
  --dry-run          restore: shows what differs and writes nothing
  --yes              write, restore: does not ask; without it standard input must say write or restore
  --save             restore: commands one save at the end (zlac8015d, yako-*; a c630s keeps every write)
  --part             restore: where more than the drive takes at once differ (c630s: 200), the first of them

Options of read, write, watch, backup and restore (the drive's own settings if not given):
  --baud N           bits a second
  --format 8N1       8N1 8N2 8E1 8O1
  --timeout MS       how long an answer may take to begin
  --retries N        how often a read is repeated; a write never is
  --echo on|off      on: the adapter hears itself, and what it hears is compared
  --interval MS      watch: between two rounds (default 500)
  --count N          watch: ends after N rounds; without it at Ctrl-C

watch is a live table on a terminal and one line a round elsewhere. Its requests feed the watchdog of a drive:
motors may run on though their controller is dead.

Records for programs, from read (one) and watch (one a round); examples/servobus/README.md has the formats:
  --csv              a header, then a row each: time,error,unix_time (ms), then a column a register with its
                     unit: bus_voltage (V). Codes and bits are numbers. A register that could not be read is
                     nan, and error says why.
  --json             an object a line: time, unix_ms, registers by name, each with its value, and its unit or
                     the text of its code, and errors by name. A register that could not be read has null.
  --log FILE         appends the records to FILE, as CSV if --json is not given, and standard output stays as it
                     is without them. A new or empty FILE gets the header first. Refused before anything is
                     sent: a FILE with other columns, one that another program logs into, and what is no
                     regular file. A row is appended whole or not at all.

scan asks every address at every rate and says who answers: BAUD FORMAT NODE and the device, if it is one of
these four; "garbled" for bytes that are no response, twice: two drives at one address, or another setting. It reads
one register, but any frame feeds the watchdog of a drive, whose motors may run on though their controller is dead.
  --baud LIST        rates, with commas (default 9600,19200,38400,57600,115200)
  --format LIST      formats, with commas (default 8N1,8N2)
  --nodes A-B        addresses (default 1-247)
  --timeout MS       how long an answer may take to begin (default 50)
  --echo on|off      as above

listen explains the traffic of others and never sends. A line has the time in seconds and > for a request; < for a
response, with the time since its request; ? for a write of one register that may be either; ! for what is wrong: bad
CRC, incomplete, noise, no response, a gap of more than a second. At Ctrl-C it ends with counters by address, in lines
that begin with #. Several devices as for explain.
  --baud, --format   as above
  --timeout MS       how long a response may take to begin; after that the request has none
  --count N          ends after N frames
  --log FILE         appends the frames to FILE in the form that explain reads; times and what is wrong are comments

alarms prints code,class,resettable,name.

explain takes one frame in hex a line, "> " or "< " in front for a request or a response; without it both are
tried. Empty lines and lines that begin with # are skipped. A response to a read is named by the last request
before it. --hex repeats the frame in front of its explanation. Several devices by
their addresses: zlac8015d:1 c630s:2; one without NODE has all other addresses.

Options of sim:
  --node N           address (default 1)
  --baud N           a rate that the drive has (default its own); responses take the time of that rate
  --link PATH        a symbolic link to the pseudo-terminal; replaces one to a pseudo-terminal, and nothing else
  --seed S           of the faults (default 1)
  --faults LIST      late,lossy,noisy,doubled,cut,unplugged or none
  --echo on|off      on: as behind an adapter that hears itself
It prints the pseudo-terminal's path and runs until SIGINT or SIGTERM. SIGUSR1 pulls the plug of the line, and
puts it in again: nothing passes either way, while the drive runs on.

Exit status: 0 done; 1 refused, unknown, no response, no such port (explain: a line that is no valid frame), or
standard output or FILE could not be written, or standard input not be read; 2 bad input, nothing was sent.
Standard error says why in one line. write and restore stop when their output cannot be written.
)";

struct control_code {
    std::string_view name;
    int (*run)(std::span<char* const>);
};

constexpr control_code commands[] = {
    {"map", tool::map},       {"alarms", tool::alarms},   {"explain", tool::explain}, {"sim", tool::simulate},
    {"read", tool::read},     {"write", tool::write},     {"scan", tool::scan},       {"watch", tool::watch},
    {"backup", tool::backup}, {"restore", tool::restore}, {"listen", tool::listen},
};

bool is_help(std::string_view word) { return word == "--help" || word == "-h"; }

int run(std::span<char* const> words) {
    if (words.size() < 2) return tool::complain(tool::usage, "no command; see servobus --help");
    for (const char* word : words.subspan(1)) {
        if (is_help(word) || std::string_view{words[1]} == "help") {
            (void)std::fputs(help, stdout);
            return tool::done;
        }
        if (std::string_view{word} == "--version") {
            const servobus::version_number v = servobus::version;
            (void)std::printf("servobus %d.%d.%d\n", v.major_number, v.minor_number, v.patch_number);
            return tool::done;
        }
    }
    for (const control_code& c : commands) {
        if (c.name == words[1]) return c.run(words.subspan(2));
    }
    return tool::complain(tool::usage,
                          std::string{"unknown command '"} + words[1] + "'; see servobus --help");
}

} // namespace

int main(int argc, char** argv) {
    tool::streams::prepare();
    return tool::streams::finish(run({argv, static_cast<std::size_t>(argc)}));
}
