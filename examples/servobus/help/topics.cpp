// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "topics.hpp"

namespace tool {

constinit const std::string_view purpose = "motor drives on Modbus RTU, from the command line";

constinit const std::string_view exit_status = "0 done; 1 refused, unknown, no response, no such port "
                                               "(explain: a line that is no valid frame; doctor: an "
                                               "enable would be refused, which standard output says), "
                                               "or standard output or FILE could not be written, or "
                                               "standard input not be read; 2 bad input, nothing was "
                                               "sent. Standard error says why in one line.";

std::span<const topic> topics() {
    static constexpr topic all[] = {
        {"DEVICE",
         "zlac8015d, yako-closed-loop, yako-open-loop or c630s; for read, write, send, watch, listen "
         "and explain also "
         "raw: any device, without a map.\n\nA word with .csv or / is the path of a file that "
         "describes a device: "
         "what map prints, with its registers, and lines \"# key = value\" in front as map "
         "--profile prints them. "
         "The header line names the columns; address and name must be there. What is wrong with it "
         "is said with its "
         "line, and nothing is sent. Where the file has no column flags, write asks before every "
         "write, and restore "
         "is refused; so it is if a row has the flag motion, or the word stopped in the column when."},
        {"BYTES",
         "a function code and its data in hexadecimal, two digits a byte, with blanks or without: 42, "
         "or 03 20 A1 00 01, or 0320A10001. At most 253 bytes. A request of the standard has its "
         "length."},
        {"NODE", "the address on the line; from the factory 1. If it is not given: 1; for explain and "
                 "listen, all that are not named. raw:0 and raw:255 are units of Modbus TCP: the device or "
                 "the gateway "
                 "itself at the end of mbap://HOST, not a node behind it."},
        {"PORT",
         "a serial device, /dev/ttyUSB0 or COM3; tcp://HOST:PORT, a gateway that carries RTU frames over "
         "TCP; mbap://HOST[:PORT], a gateway of Modbus TCP, or a device that responds as unit 1 to 247, "
         "502 if no port is given. IPv6: tcp://[::1]:4001. A response may take half a second longer there "
         "than the drive's own limit, unless --timeout is given. A gateway that repeats requests by "
         "itself is not to be used."},
        {"REG",
         "a name from the map or an address, 0x2088 or 2088h; of a c630s also a parameter number, P0B-17. "
         "For "
         "raw: "
         "ADDRESS or ADDRESS:COUNT, of holding registers.\n\nIn full [TABLE:]ADDRESS[:COUNT][:TYPE][:hi|lo], "
         "also "
         "for raw: TABLE is coil, discrete (a discrete input), input (an input register) or holding; TYPE is "
         "u16, "
         "i16, u32, i32 or f32, of which COUNT are read; a value of 32 bits has its high word first (hi), or "
         "its low "
         "word (lo): coil:12 input:0x30:4 holding:0x10:f32:lo."},
        {"VALUE",
         "in the register's unit, exactly: left_max_current=12.5 is 12.5 A. What the register cannot hold "
         "is refused and nothing is sent. A code by its name, with _ for a blank, or by its number: "
         "control_word=quick_stop; bits by their names: input_polarity=x0+x1. 0x... is the register's "
         "content as it is, also for a signed one: 0xFF9C is -100. Where another register sets the scale "
         "(left_target_speed) VALUE is a whole number of counts.\n\nWhat a zlac8015d does with "
         "host_timeout=0 is not documented: only raw 0x2000=0 writes it, and restore does not. For raw: a "
         "whole number, or COUNT of them with commas, which are one frame; for f32 a decimal number, to the "
         "nearest "
         "that it has; for a coil on or off."},
    };
    return all;
}

std::span<const example> examples() {
    static constexpr example all[] = {
        {"servobus sim zlac8015d --link drive", "a simulated drive, to try the rest without one"},
        {"servobus read drive zlac8015d:1 bus_voltage", "one register"},
        {"servobus write drive zlac8015d:1 left_max_current=12.5", "12.5 A, exactly or not at all"},
        {"servobus watch drive zlac8015d bus_voltage --log run.csv",
         "a live table, and a row a round in a file"},
        {"servobus scan /dev/ttyUSB0", "who responds"},
    };
    return all;
}

} // namespace tool
