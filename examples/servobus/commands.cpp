// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The table of the commands.
#include "commands.hpp"

#include "command_options.hpp"
#include "commands/commands.hpp"
#include "help/help.hpp"

namespace tool {
namespace {

constexpr command all_commands[] = {
    {.name = "map",
     .words = "DEVICE [REG]",
     .summary = "the register map as CSV, or one register",
     .about = "Prints a row for each register: address, name, words, type, access, whether it is saved, "
              "when it may be written, when that takes effect, modes, range, default, scale, unit, further "
              "flags, names of codes and bits, and word order. With "
              "REG it prints what that register does, these properties in words, and the names of its codes "
              "or bits.",
     .options = map_options,
     .run = map},
    {.name = "alarms",
     .words = "DEVICE",
     .summary = "the drive's alarms as CSV, with advice",
     .about = "Prints a row for each alarm, of the zlac8015d for each fault bit: code, class, resettable, "
              "name, and in quotes what its manual says: cause, remedy, and how it is reset. Where the "
              "manual does not say whether it can be reset, resettable is unstated.",
     .run = alarms},
    {.name = "explain",
     .words = "DEVICE[:NODE]...",
     .summary = "frames in words",
     .about =
         "Takes frames from standard input in hex, \"> \" or \"< \" in front for a request or a response; "
         "without it both are tried. Lines may have the form of other programs' logs (0x1 0x3, 01:03, "
         "[01][03], Tx:000001-01 03), several frames without a gap, cut by their lengths and CRC, and noise "
         "around a frame; what follows # is skipped. Every function of the standard has words; of another "
         "one "
         "the bytes are printed. "
         "A response to a read is named by the last request before it. Several devices "
         "by their addresses: zlac8015d:1 c630s:2; one without NODE has all other addresses.",
     .options = explain_options,
     .run = explain,
     .takes_raw = true},
    {.name = "sim",
     .words = "DEVICE",
     .summary = "a simulated drive",
     .about = "Prints the path of the pseudo-terminal on which the drive responds and runs until SIGINT "
              "or SIGTERM. SIGUSR1 pulls the plug of the line, and puts it in again: nothing passes "
              "either way, while the drive runs on. SIGUSR2 switches the drive off and on. A device of a "
              "file keeps what is written to its rows, and "
              "refuses what they do not allow.",
     .options = sim_options,
     .run = simulate},
    {.name = "read",
     .words = "PORT DEVICE[:NODE] REG...",
     .summary = "registers, once",
     .about = "Prints name=value unit.",
     .shared = line_and_records,
     .run = read,
     .takes_raw = true},
    {.name = "write",
     .words = "PORT DEVICE[:NODE] REG=VALUE...",
     .summary = "registers, checked first",
     .about = "Checks every REG=VALUE before it sends anything, writes them one by one in their order and "
              "stops at the first failure, or when its output cannot be written. A write is sent once, "
              "never again by itself. If one of them may move a machine (a target, a start, an address "
              "without a map; not a stop) write says so and asks first. Where a drive can switch the word "
              "order of its 32-bit values, it is read from it before the first of them.",
     .options = write_options,
     .shared = line_only,
     .run = write,
     .takes_raw = true},
    {.name = "send",
     .words = "PORT DEVICE[:NODE] BYTES...",
     .summary = "any request, by its bytes",
     .about =
         "Sends a function code and its data, with address and CRC or the header of Modbus TCP, once. Prints "
         "the response as it is on a serial line, in hex, then in words as explain does. Status 1 for an "
         "exception and for no response. A function that the standard knows as a read is sent at once; of "
         "every other one send says so and asks first. The response to a function that the standard does not "
         "have ends where the line is silent. Where a response repeats its request, a read of one register "
         "shows whether it was an echo: --retries is for that read, and --echo off says that there is "
         "none.",
     .options = send_options,
     .shared = line_only,
     .run = send,
     .takes_raw = true},
    {.name = "watch",
     .words = "PORT DEVICE[:NODE] REG...",
     .summary = "registers, again and again",
     .about =
         "A live table on a terminal and one line a round elsewhere. A port that is lost is opened anew as "
         "soon as it is back, and each round until then says so. Its requests feed the watchdog "
         "of a drive: motors may run on though their controller is dead.",
     .options = watch_options,
     .shared = line_and_records,
     .run = watch,
     .takes_raw = true},
    {.name = "scan",
     .words = "PORT",
     .summary = "which addresses respond",
     .about =
         "Asks every address at every rate and prints who responds: BAUD FORMAT NODE and the device, "
         "if it is one of these four; \"garbled\" for bytes that are no response, twice: two drives "
         "at one address, or another setting. It reads one register, but any frame feeds the "
         "watchdog of a drive, whose motors may run on though their controller is dead. A pseudo-terminal "
         "has no rate and no format: it is scanned once.",
     .options = scan_options,
     .run = scan},
    {.name = "listen",
     .words = "PORT DEVICE[:NODE]...",
     .summary = "the traffic of others in words",
     .about = "Explains it as it passes, and never sends. A line has the time in seconds and > for a "
              "request; < for a response, with the time since its request; ? for a write of one register "
              "that may be either; ! for what is wrong: bad CRC, incomplete, noise, no response, a gap of "
              "more than a second. At Ctrl-C it ends with counters by address, in lines that begin with "
              "#. Several devices as for explain.",
     .options = listen_options,
     .run = listen,
     .takes_raw = true},
    {.name = "doctor",
     .words = "PORT DEVICE[:NODE]...",
     .summary = "what keeps a drive from turning",
     .about = "Reads and explains, and never writes. A line a finding: refused (an enable does not succeed), "
              "matters "
              "(the motor does not turn, or otherwise than meant) or unread, then the registers with their "
              "values, why, "
              "and after -> what mends it. Lines that begin with line are about the port and the line: "
              "response times, the "
              "USB adapter's latency timer, other programs on the port, what several devices have to share. "
              "Of a device "
              "from a file: rows that it does not give, values outside their range (matters), and values "
              "that differ from "
              "their default (differs). Status 1 where an enable would be refused, or there is no "
              "response.\n\nA request "
              "feeds the watchdog of a zlac8015d. So it reads the status and the mode, and asks before it "
              "goes on if the drive is enabled.",
     .options = doctor_options,
     .shared = line_only,
     .run = doctor},
    {.name = "backup",
     .words = "PORT DEVICE[:NODE] [FILE]",
     .summary = "a drive's parameters to a file",
     .about = "Writes every parameter, a line of text each, to FILE (only once all are read) or to "
              "standard output. A file that exists is replaced as a whole, or stays as it is if anything "
              "fails; it keeps its mode, and its owner where that is allowed. Symbolic links are "
              "followed. A device, a FIFO or a pipe is written into; a block device, a folder, a link to "
              "nothing and PORT itself are refused.",
     .shared = line_only,
     .run = backup},
    {.name = "restore",
     .words = "PORT DEVICE[:NODE] FILE",
     .summary = "a drive's parameters from one",
     .about = "Checks the whole file before it sends anything and refuses while the drive is enabled or "
              "moves. It skips triggers, targets and the settings of the line, writes only what differs, "
              "reads each back and stops at the first failure, or when its output cannot be written; run "
              "again, it goes on there. Before it writes it says how many writes into the EEPROM that "
              "costs. A register that a backup marks with ? (the drive refused to give it, or holds what "
              "its manual does not allow) is left alone.",
     .options = restore_options,
     .shared = line_only,
     .run = restore},
    {.name = "apply",
     .words = "PORT FILE [NAME...]",
     .summary = "a machine's parameters from a file",
     .about =
         "Brings the drives of a machine file, or those that are named, to what it says. Checks the whole "
         "file "
         "before it sends anything, finds each drive, and refuses while one is enabled or moves, or if it is "
         "not what the file requires. Then it prints what differs and how many writes into the EEPROM that "
         "costs, asks, writes only that, reads each back, sets rate and address last and looks for the drive "
         "there, saves, and compares again. Run again after an end of any kind, it goes on there; where "
         "all is as the file says, it writes nothing. FILE.unsaved names the drives that are written but not "
         "saved.",
     .options = apply_options,
     .shared = line_only,
     .run = apply},
    {.name = "diff",
     .words = "PORT FILE [NAME...]",
     .summary = "a machine's parameters compared",
     .about =
         "Compares the drives of a machine file, or those that are named, with what it says, and prints what "
         "differs: from the drive's value to the file's. It only reads. Status 1 if anything differs.",
     .options = diff_options,
     .shared = line_only,
     .run = diff},
    {.name = "turn",
     .words = "PORT DEVICE[:NODE]",
     .summary = "counts of a shaft turned by hand",
     .about =
         "Reads the positions of a drive that is not enabled, waits for Enter while a person turns the shaft "
         "forward by whole turns, and prints the counts of a turn and the direction. Status 1 if the drive's "
         "settings say another number.",
     .options = turn_options,
     .shared = line_only,
     .run = turn},
    {.name = "probe",
     .words = "PORT DEVICE[:NODE] FILE",
     .summary = "what a manual leaves open, on a real drive",
     .about =
         "Settles where the drive's manual can be read in several ways: step by step it brings a drive that "
         "is at "
         "rest into states in which its readings show which way it follows, and asks the person beside it "
         "what "
         "only a person sees. Before anything moves it says what, and the person types move. Motors run at "
         "the slowest speed. Registers that it changes get their old words back. FILE gets what was found, "
         "with "
         "the firmware's version and nothing of the machine or its owner; sim --switches FILE behaves so. "
         "What "
         "did not show is open, ?.",
     .shared = line_only,
     .run = probe},
    {.name = "header",
     .words = "DEVICE",
     .summary = "a device as a C++ header",
     .about =
         "Prints a header for programs with the library: the device's profile, a row for each register, coil "
         "and input, and a catalogue for tools. The device of meter.csv is in namespace meter. A file with a "
         "pair in another word order than the others is refused.",
     .run = header},
    {.name = "completion",
     .words = "bash",
     .summary = "completion for the shell",
     .about = "Prints the script; for this shell: . <(servobus completion bash). For all later ones, put "
              "it into ~/.local/share/bash-completion/completions/servobus, or that line into ~/.bashrc.",
     .run = completion},
    {.name = "manual",
     .words = "",
     .summary = "the manual page",
     .about = "Prints its source; to read it: servobus manual | man -l -.",
     .run = [](const arguments& asked) { return print_manual(commands(), asked); }},
};

} // namespace

const command_table& commands() {
    static constexpr command_table table{.all = all_commands, .shared = line_and_records};
    return table;
}

} // namespace tool
