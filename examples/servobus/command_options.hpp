// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The options of the commands, those that several share first. commands.cpp alone includes it.
#pragma once

#include <string_view>

#include "command_line/command.hpp"

namespace tool {

inline constexpr std::string_view common_rates = "9600 19200 38400 57600 115200";
inline constexpr std::string_view character_formats = "8N1 8N2 8E1 8O1";

inline constexpr option line_options[] = {
    {"baud", "N", "bits a second", common_rates},
    {"format", "8N1", "8N1, 8N2, 8E1 or 8O1", character_formats},
    {"timeout", "MS", "how long a response may take to begin"},
    {"retries", "N", "how often a read is repeated; a write never is"},
    {"gap", "MS", "the pause before each request: 8 for a drive whose reads fail right after writes"},
    {"quarantine", "MS",
     "the pause after a request without exactly one valid response, in which a late response is dropped; if "
     "not given, the drive's own, but at least --timeout"},
    {"inter-byte", "MS", "the longest pause inside a response (default 20; 200 over a network)"},
    {"echo", "on|off", "on: the adapter receives what it sends, and what it receives is compared"},
    {"rs485", "HOW",
     "the system switches the driver of an RS-485 port: on, as the board says; rts-on-send or "
     "rts-after-send, "
     "also with the delays before and after, in ms: rts-after-send,1,0"},
};
inline constexpr option_group of_line{"Options of the line",
                                      "The drive's own settings if they are not given.", line_options};

inline constexpr option record_options[] = {
    {"csv", "",
     "a header, then a row each: time,error,unix_time (ms), then a column a register with its unit: "
     "bus_voltage (V). Codes and bits are numbers. A register that could not be read is nan, and error "
     "says why"},
    {"json", "",
     "an object a line: time, unix_ms, registers by name, each with its value, and its unit or the text "
     "of its code, and errors by name. A register that could not be read has null"},
    {"log", "FILE",
     "appends the records to FILE, as CSV if --json is not given, and standard output stays as it is "
     "without them. A new or empty FILE gets the header first. Refused before anything is sent: a FILE "
     "with other columns, one that another program logs into, and what is no regular file. A row is "
     "appended whole or not at all"},
};
inline constexpr option_group of_records{"Records for programs", "One from read, one a round from watch.",
                                         record_options};

inline constexpr const option_group* line_only[] = {&of_line};
inline constexpr const option_group* line_and_records[] = {&of_line, &of_records};

inline constexpr option explain_options[] = {{"hex", "", "repeats the frame in front of its explanation"}};

inline constexpr option sim_options[] = {
    {"node", "N", "address (default 1)"},
    {"baud", "N", "a rate that the drive has (default its own); responses take the time of that rate",
     common_rates},
    {"link", "PATH",
     "a symbolic link to the pseudo-terminal; replaces one to a pseudo-terminal, and nothing else"},
    {"seed", "S", "of the faults (default 1)"},
    {"faults", "LIST", "late,lossy,noisy,doubled,cut,unplugged or none",
     "late lossy noisy doubled cut unplugged none"},
    {"echo", "on|off", "on: as after an adapter that receives what it sends"},
    {"switches", "FILE", "behaves as probe has found of a real drive"},
    {"strict-rate", "on|off", "on: it responds only to a program that has set its rate, as a real one"},
};

inline constexpr option write_options[] = {
    {"blocks-only", "",
     "for a device that takes a single register by function 10h, and a single coil by 0Fh"},
    {"yes", "", "does not ask; without it standard input must say write"},
};

inline constexpr option send_options[] = {
    {"yes", "", "does not ask; without it standard input must say send, unless the function is a read"},
};

inline constexpr option watch_options[] = {
    {"interval", "MS", "between two rounds (default 500)"},
    {"count", "N", "ends after N rounds; without it at Ctrl-C"},
};

inline constexpr option scan_options[] = {
    {"baud", "LIST", "rates, with commas (default 9600,19200,38400,57600,115200)", common_rates},
    {"format", "LIST", "formats, with commas (default 8N1,8N2)", character_formats},
    {"nodes", "A-B", "addresses (default 1-247)"},
    {"identify", "",
     "asks each device that responds what it is, by function 2Bh, and by 11h if it does not say so: vendor, "
     "product, "
     "revision and more"},
    {"timeout", "MS", "how long a response may take to begin (default 50)"},
    {"gap", "MS", "the pause before each request: 8 for a device whose reads fail right after writes"},
    {"quarantine", "MS",
     "the pause after a request without exactly one valid response, in which a late response is dropped; by "
     "default none: the next request goes to another address"},
    {"inter-byte", "MS", "the longest pause inside a response (default 20; 200 over a network)"},
    {"echo", "on|off", "on: the adapter receives what it sends, and what it receives is compared"},
    {"rs485", "HOW",
     "the system switches the driver of an RS-485 port: on, as the board says; rts-on-send or "
     "rts-after-send, "
     "also with the delays before and after, in ms: rts-after-send,1,0"},
};

inline constexpr option listen_options[] = {
    {"baud", "N", "bits a second (default the drive's own)", common_rates},
    {"format", "8N1", "8N1, 8N2, 8E1 or 8O1", character_formats},
    {"timeout", "MS", "how long a response may take to begin; after that the request has none"},
    {"count", "N", "ends after N frames"},
    {"inter-byte", "MS", "the longest pause inside a frame (default 20; 200 over a network)"},
    {"log", "FILE",
     "appends the frames to FILE in the form that explain reads; times and what is wrong are comments"},
};

inline constexpr option doctor_options[] = {
    {"period", "MS",
     "how often a program is to send a setpoint and read feedback of each DEVICE: whether the line allows "
     "it"},
    {"long", "",
     "a line for each register that differs from what it has to hold, where a finding says how many"},
    {"yes", "", "does not ask; without it standard input must say read, if a zlac8015d is enabled"},
};

inline constexpr option restore_options[] = {
    {"dry-run", "", "shows what differs and writes nothing"},
    {"yes", "", "does not ask; without it standard input must say restore"},
    {"save", "", "commands one save at the end (zlac8015d, yako-*; a c630s keeps every write)"},
    {"part", "", "where more than the drive takes at once differ (c630s: 200), the first of them"},
};

inline constexpr option apply_options[] = {
    {"at", "NODE",
     "where the drive is now, if it is not yet where the file has it; so with --baud and --format"},
    {"dry-run", "", "shows what differs and writes nothing"},
    {"yes", "", "does not ask; without it standard input must say apply"},
    {"save", "", "saves where nothing differs too: what write has set is lost with the power until then"},
    {"part", "", "where more than the drive takes at once differ (c630s: 200), the first of them"},
};

inline constexpr option diff_options[] = {
    {"at", "NODE",
     "where the drive is now, if it is not yet where the file has it; so with --baud and --format"},
};

inline constexpr option turn_options[] = {{"turns", "N", "how many turns (default 10)"}};

inline constexpr option map_options[] = {
    {"long", "", "one more column, description, after unit: what the register does, a sentence in quotes"},
    {"profile", "",
     "first the properties of the device, a line \"# key = value\" each: name, addresses, rate, word order, "
     "limits, gaps, exceptions"},
};

} // namespace tool
