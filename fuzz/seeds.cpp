// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Makes the seeds of the corpora from the frames that the manuals print (tests/manuals/*_frames.csv), in
// the format that each target reads.   sh fuzz/seeds.sh
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace {

using byte_list = std::vector<std::uint8_t>;

struct printed {
    bool is_request;
    byte_list body; ///< address and PDU, without the CRC
    byte_list pdu() const { return {body.begin() + 1, body.end()}; }
};

std::vector<printed> frames_of(const std::string& file) {
    std::ifstream in{file};
    std::vector<printed> all;
    for (std::string line; std::getline(in, line);) {
        const std::size_t comma = line.find(',');
        if (comma == line.npos || line.rfind("direction", 0) == 0) continue;
        printed p{line.rfind("request", 0) == 0, {}};
        const std::string hex = line.substr(comma + 1, line.find(',', comma + 1) - comma - 1);
        for (std::size_t at = 0; at + 1 < hex.size(); at += 3)
            p.body.push_back(static_cast<std::uint8_t>(std::stoul(hex.substr(at, 2), nullptr, 16)));
        if (p.body.size() < 4) continue;
        p.body.resize(p.body.size() - 2);
        all.push_back(p);
    }
    return all;
}

byte_list operator+(byte_list a, const byte_list& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}
std::uint8_t low(std::size_t n) { return static_cast<std::uint8_t>(n & 0xFFu); }

/// The seeds of one target.
class corpus {
  public:
    explicit corpus(const std::string& name) : folder_{"fuzz/corpus/" + name} {
        std::filesystem::create_directories(folder_);
    }
    void add(const std::string& name, const byte_list& data) {
        std::ofstream out{folder_ / name, std::ios::binary};
        for (const std::uint8_t byte : data) out.put(static_cast<char>(byte));
    }

  private:
    std::filesystem::path folder_;
};

// The format of fuzz/fuzz_exchange.cpp: the parts of the request, then a gap and the bytes that arrive.
byte_list transaction(const byte_list& body, std::uint8_t choice, const byte_list& said) {
    byte_list seed{choice, 0x60, 0x70};
    constexpr std::uint8_t codes[] = {3, 4, 6, 16};
    std::uint8_t code = 0;
    while (code < 3 && codes[code] != body[1]) ++code;
    seed.push_back(static_cast<std::uint8_t>(code * 8));
    seed = seed + byte_list{body[2], body[3], body[5]};
    return seed + said;
}

void transactions(corpus& to, const std::string& name, const byte_list& body) {
    to.add(name + "_good", transaction(body, 0, {0x10, 5}));
    to.add(name + "_strict", transaction(body, 1, {0x40, 5}));
    to.add(name + "_exception", transaction(body, 0, {0x10, 2, 2}));
    to.add(name + "_echo", transaction(body, 4, {0x10, 3, 0x30, 5}));
    to.add(name + "_spoilt", transaction(body, 0xE0, {0x10, 0x0D, 2, 3, 0x40, 5}));
    to.add(name + "_in_pieces", transaction(body, 1, {0x10, 0x45, 4, 0x20}));
    to.add(name + "_foreign_first", transaction(body, 0, {0x10, 4, 1, 9, 6, 4, 0x31, 5}));
}

// The format of fuzz/fuzz_line.cpp: clock, tick, timing; then for each call `how`, three times, the request.
void calls(corpus& to) {
    const byte_list calm{0x00, 0x00, 0x00};
    for (const unsigned how : {0u, 1u, 2u, 4u, 6u, 0xC6u}) {
        const byte_list call{low(how), 0x00, 0x82, 0x85};
        const std::string name = "how_" + std::to_string(how);
        to.add(name + "_read", calm + call + byte_list{0x0C} + byte_list(12, 0x60));
        to.add(name + "_write", calm + call + byte_list{0x01} + byte_list(12, 0x61));
        to.add(name + "_write_many", calm + call + byte_list{0x1B} + byte_list(40, 0x7F));
        to.add(name + "_short_sends", byte_list{0x20, 3, 1} + call + byte_list{0x0C} + byte_list(60, 0xA1));
        to.add(name + "_jumps", byte_list{0xA5, 3, 0} + call + byte_list{0x0C} + byte_list(60, 0xD9));
        to.add(name + "_errors", calm + call + byte_list{0x0C} + byte_list(9, 0xF1));
        to.add(name + "_broadcast", calm + call + byte_list{0x08} + byte_list(9, 0x10));
    }
    to.add("stopped_clock", {0xFF, 0, 0, 6, 0, 0x82, 0x85, 0x0C});
}

// The format of fuzz/fuzz_blocking_line.cpp: clock, tick, timing; then for each call `how`, three times, the
// request, and the behaviour of the port: nothing during the gap, then the same action repeatedly.
void blocking_line_calls(corpus& to) {
    constexpr std::uint8_t read = 0x0C, write = 0x01, write_many = 0x1B, broadcast = 0x08;
    for (const std::uint8_t is_strict : {std::uint8_t{0}, std::uint8_t{1}}) {
        const byte_list calm{0x00, 0x00, is_strict};
        const std::string mode = is_strict != 0 ? "strict_" : "host_";
        const auto call = [&](unsigned how, std::uint8_t what, std::uint8_t does, std::size_t times = 24) {
            const byte_list silence(is_strict != 0 ? 7 : 15);
            return byte_list{low(how), 0x00, 0x05, 0x85, what} + silence + byte_list(times, does);
        };
        // Plain, a stop, the byte count as quantity or function 04, request and response in one buffer,
        // local echo.
        for (const unsigned how : {0x80u, 0x81u, 0x82u, 0x84u, 0x88u}) {
            const std::string name = mode + "how_" + std::to_string(how);
            to.add(name + "_read", calm + call(how, read, 0x61));
            to.add(name + "_write", calm + call(how, write, 0x61));
            to.add(name + "_write_many", calm + call(how, write_many, 0x61));
            to.add(name + "_echo", calm + call(how, write, 0x71));
        }
        to.add(mode + "spoilt", calm + call(0x80, read, 0x85));
        to.add(mode + "cut", calm + call(0x80, write, 0x95, 5));
        to.add(mode + "exception", calm + call(0x80, write_many, 0xA5));
        to.add(mode + "noise", calm + call(0x80, read, 0xB5));
        to.add(mode + "short_patience", calm + byte_list{0x80, 0x00, 0x05, 0x00, write} +
                                            byte_list(is_strict != 0 ? 7 : 15) + byte_list(24, 0x61));
        to.add(mode + "errors", calm + call(0x80, write, 0xF0));
        to.add(mode + "broadcast", calm + call(0x90, broadcast, 0x61));
        to.add(mode + "byte_count", calm + call(0x82, write_many + 0x80, 0x61));
        to.add(mode + "echo_of_7_bytes", calm + call(0x88, read + 0xA0, 0x71));
        to.add(mode + "echo_and_zero", calm + call(0x88, read + 0xC0, 0x71));
        to.add(mode + "after_a_time_out", calm + call(0x80, read, 0x00) + call(0x81, write, 0x61));
        to.add(mode + "after_a_response", calm + call(0x80, read, 0x61, 9) + call(0x80, write, 0x61));
        to.add(mode + "long_quarantine", calm + byte_list{0x80, 0x00, 0x8F, 0x85, read});
        to.add(mode + "stop_with_a_long_gap",
               calm + byte_list{0x81, 0x8F, 0x05, 0x85, write} + byte_list(80));
        to.add(mode + "slow",
               byte_list{0, 7, low(is_strict + 2u)} + call(0x80, read, 0x00, 40) + byte_list(20, 0x61));
        to.add(mode + "jumps", byte_list{0xA5, 3, is_strict} + call(0x80, read, 0xD9));
        to.add(mode + "stopped_clock", byte_list{0xFF, 0, is_strict} + call(0x80, read, 0x00));
    }
    for (unsigned kind = 0; kind < 8; ++kind)
        to.add("refused_" + std::to_string(kind), {0, 0, 0, 0x80, 0, 0x05, 0x85, read + 0xE0, low(kind + 8)});
}

void texts(corpus& to) {
    for (const char* text : {"none", "late", "lossy,noisy", "doubled,cut", "unplugged", "late,", ",", "later",
                             "P0B-17", "P31-00", "P0b-17", "P0B-1", "P0B-177"})
        to.add(std::string{"text_"} + (text[0] == ',' ? "comma" : text),
               byte_list(text, text + std::string{text}.size()));
}

void machine_files(corpus& to) {
    const auto add = [&](const char* name, const std::string& text) {
        to.add(name, byte_list(text.begin(), text.end()));
    };
    const std::string first = "servobus-machine format=1\n";
    add("file_lift",
        first + "[lift] device=yako-closed-loop node=2\nrequire microstep_resolution=1000   # compared\n"
                "max_current=3.0 A\nholding_current=60 %\nx0_function=home\nx1_function=undefined\n");
    add("file_two", "\xEF\xBB\xBF" + first +
                        "[lift]  device=yako-closed-loop node=2 baud=115200 character_format=8N1\r\n\r\n"
                        "# the press\r\n[press-1] device=c630s node=3 baud=115200 character_format=8N1\r\n"
                        "require mode_of_operation=position # a comment\r\nnode_address = "
                        "3\r\nhoming_high_speed=100 r/min\r\n");
    add("file_twice", first + "[a] device=c630s node=1\n[a] device=c630s node=2\n");
    add("file_same_input",
        first + "[a] device=yako-closed-loop node=1\nx0_function=home\nx2_function=home\n");
    add("file_other_unit",
        first + "[a] device=yako-closed-loop node=1\nmax_current=2500 mA\nmax_current=2 V\n");
    add("file_later", "servobus-machine format=2\n");
    // A file for each sentence that refuses one.
    const std::string lift = first + "[lift] device=yako-closed-loop node=2\n";
    const std::string two = first + "[a] device=c630s node=3\n[b] device=c630s ";
    unsigned number = 0;
    for (const std::string& refused : {
             std::string{},
             std::string{"servobus\n"},
             first + "lift device=c630s\n",
             first + "[a-name-that-is-longer-than-any-name-may-be] device=c630s node=1\n",
             first + "[a] device=c630s\n",
             first + "[a] node=1\n",
             first + "[a] device=c360s node=1\n",
             first + "[a] device=c630s node=248\n",
             first + "[a] device=c630s node=1 baud=12\n",
             first + "[a] device=c630s node=1 baud=9600 baud=9600\n",
             first + "[a] device=c630s node=1 character_format=9N1\n",
             first + "[a] device=c630s node=1 nodes=2\n",
             first + "max_current=3\n",
             first + "# nothing\n",
             two + "node=3\n",
             two + "node=4 baud=9600\n",
             lift + "max_currents=3.0 A\n",
             lift + "max_current\n",
             lift + "max_current=\n",
             lift + "max_current=3.0.1 A\n",
             lift + "max_current=0.001 A\n",
             lift + "max_current=99 A\n",
             lift + "max_current=3.0 m\n",
             lift + "x0_function=lamp\n",
             lift + "start_motion=1\n",
             lift + "error_code=0\n",
             lift + "require error_code=0\n",
             lift + "max_current=3.0 A\nmax_current=3.0 A\n",
             first + "[a] device=c630s node=3\nnode_address=4\n",
             first + "[a] device=c630s node=3 baud=9600\nbaud_rate=115200\n",
             first + "[a] device=c630s node=3 character_format=8N1\ncharacter_format=8e1\n",
         })
        add(("refused_" + std::to_string(number++)).c_str(), refused);
    add("findings_later", "servobus-findings format=2 device=zlac8015d\n");
    add("findings_of_another", "servobus-findings format=1 device=c630s\n");
    add("findings_unknown", "servobus-findings format=1 device=zlac8015d\nsaved=no\n");
    add("findings_all",
        "servobus-findings format=1 device=zlac8015d\nfirmware=107\nsave=marked # section 3\nby_fault=?\n");
    add("findings_wrong", "servobus-findings format=1 device=zlac8015d\nsave=perhaps\n");
    add("findings_twice", "servobus-findings format=1 device=zlac8015d\nsave=no\nsave=yes\n");
}

void device_files(corpus& to) {
    const auto add = [&](const char* name, const std::string& text) {
        to.add(name, byte_list(text.begin(), text.end()));
    };
    add("file_short", "address,name\n0x10,voltage\n17,current\n12h,power\n");
    add("file_profile",
        "\xEF\xBB\xBF## a meter\r\n# file_format = 1\r\n# name = meter\r\n# lowest_address = 2\r\n# "
        "highest_address = "
        "32\r\n# baud = 19200\r\n# character_format = 8E1\r\n# word_order = selectable\r\n# "
        "word_order_register = "
        "0x19\r\n# eeprom_switch = 0x20\r\n# max_read = 16\r\n# max_write = 8\r\n# response_ms = 250\r\n# "
        "turnaround_ms = 10\r\n# gap_ms = 1.75\r\n# quarantine_ms = 50\r\n# read_retries = 1\r\n# "
        "leading_bytes = "
        "0\r\n# corrupted_request = 1\r\n# acknowledge = 0\r\n# echoes_byte_count = yes\r\n# exception_2 = "
        "refused\r\nname,address,type,word_order\r\nplace,1,i32,selectable\r\nway,3,u32,high\r\n");
    add("file_columns",
        "address,name,words,type,access,saved,when,effective,modes,min,max,default,scale,unit,description,"
        "flags,names,"
        "word_order,table\n0x0010,speed,1,i16,rw,yes,running,immediate,PST,-5,5,0,0.1,r/min,\"A "
        "\"\"speed\"\", "
        "set.\",motion;scaled_elsewhere,,,holding\n0x11,mode,,u16,rw,,stopped,power_cycle,ALL,0,9,1,,,,saved_"
        "on_write;"
        "zero_by_name,0=off;b3=on;0x00C0:0x0040=locked,,\n0x12,total,2,u32,ro,no,,at_stop,T,,,,1/"
        "3,ms,,,,low,\n0x14,axes,,i16,,,,,,,,,,,,,halves,,\n0x15,word,,,wo,,,,,,,,,,,trigger;communication,"
        "hex,,\n,,,,,,"
        ",,,,,,,,,,,,\n0x10,pump,,bool,rw,,,,,0,1,1,,,,motion,0=idle;1=runs,,coil\n0x10,door,,,,,,,,,,,,,,,,,"
        "discrete\n"
        "0x10,level,,i32,,,,,,,,,25,mm,,,,,input\n");
    unsigned number_of_values = 0;
    const std::string columns_of_values = "address,name,words,type,access,scale,unit,names,word_order,table,"
                                          "bits,offset,none,factor,byte_order\n";
    add("file_values",
        "# byte_order = low\n# writes_blocks_only = yes\n# highest_address = 255\n" + columns_of_values +
            "0,voltage,,f32,ro,0.001,V,,low,input,,,0x7FC00000,,high\n0x10,energy,4,u64,rw,,Wh,,,,,,"
            "0xFFFFFFFFFFFFFFFF;0x8000000000000000,,\n0x14,total,,i64,ro,,,,,,,,-1,,\n0x18,name,3,text,rw,,,,"
            ",,,,,,\n"
            "0x1B,hour,,bcd16,rw,,h,0x12=noon,,,high,,,,\n0x1B,minute,,bcd16,rw,,min,,,,0..7,,,,\n"
            "0x1C,date,,bcd32,ro,,,,,,,,,,\n0x1E,current,,sm16,ro,0.1,A,0x8000=none,,,,-100,,ratio,\n"
            "0x1F,way,,sm32,ro,,mm,,,,,,,0x22,low\n0x21,mode,,i16,rw,,,-1=off;b0=on,,,4,,,,\n"
            "0x22,ratio,,u16,rw,0.1,times,,,,,,,,\n0x23,power,,i16,ro,,W,,,,,,0x8000;-1,10^power_sf,\n"
            "0x24,power_sf,,i16,ro,,,,,,,,-32768,,\n0x25,gas,,u32,ro,,ppm,0x80000000=none;b31=hot,,,,,,,\n"
            "0x27,level,,f64,ro,,lux,,high,,,,,,\n0,relay,,bool,rw,,,0x5500=toggle;1=on,,coil,,,,,\n");
    for (const char* row : {"1,a,,text,,,,,,,,,,,",
                            "1,a,200,text,,,,,,,,,,,",
                            "1,a,2,text,,,V,,,,,,,,",
                            "1,a,,f32,,,,0=x,,,,,,,",
                            "1,a,,u128,,,,,,,,,,,",
                            "1,a,,u64,,,,0=x,,,,,,,",
                            "1,a,,u32,,,,,,,0..3,,,,",
                            "1,a,,u16,,,,,,,9..3,,,,",
                            "1,a,,bcd16,,,,,,,0..2,,,,",
                            "1,a,,f32,,,,,,,,1,,,",
                            "1,a,,u16,,,,,,,,1e9,,,",
                            "1,a,,u16,,,,,,,,,0x10000,,",
                            "1,a,,f32,,,,,,,,,nan,,",
                            "1,a,,f32,,,,,,,,,,b,",
                            "1,a,,u16,,,,,,,,,,a,",
                            "1,a,,u16,,,,,,,,,,10^,",
                            "1,a,,u16,,,,,,,,,,b,\n2,b,,u16,,,,,,,,,,a,",
                            "1,a,,u16,,,,,,,,,,b,\n2,b,,f32,,,,,,,,,,,",
                            "1,a,,u16,,,,,,,,,,,big",
                            "1,a,,u16,,,,,,,0..3,,,,\n1,b,,u16,,,,,,,3,,,,",
                            "1,a,,,,,\"x,y\",,,,,,,,",
                            "1,a,,bool,,,,0xFF00=x,,coil,,,,,",
                            "1,a,,u32,,,,0xFFFF:1=x,,,,,,,",
                            "1,a,1,text,,,,,low,,,,,,"})
        add(("values_" + std::to_string(number_of_values++)).c_str(), columns_of_values + row + '\n');
    add("file_wrong", "address;name\n0x10;a\n");
    add("file_quote", "address,name,description\n1,a,\"b\n");
    add("file_twice", "address,name,type\n1,a,u32\n2,b,\n");
    // A file for each sentence that refuses one: before the header line, that line, and rows below all columns.
    unsigned number = 0;
    const auto refuse = [&](const std::string& text) {
        add(("refused_" + std::to_string(number++)).c_str(), text);
    };
    for (const char* line :
         {"# file_format = 9", "# baud = fast", "# gap_ms = 1.2345", "# gap_ms = 70000", "# bauds = 9600",
          "# speed", "# name = a b", "# name = ", "# word_order = middle", "# character_format = 9N1",
          "# echoes_byte_count = perhaps", "# exception_2 = ", "# exception_300 = busy",
          "# baud = 9600\n# baud = 9600", "# lowest_address = 9\n# highest_address = 3",
          "# word_order = selectable", "# word_order_register = 0x19", "# max_read = 0"})
        refuse(std::string{line} + "\naddress,name\n1,a\n");
    for (const char* text :
         {"", "# name = a\n", "address,name\n", "name\na\n", "address,name,name\n1,a,b\n",
          "address,names_of_it,name\n", "address,name\n1,a\n# name = b\n", "address,name\n1\n",
          "address,name\n1,\x01\n", "address,name\n1,a\n2,a\n", "address,name\n1,a\n1,b\n"})
        refuse(text);
    struct cell {
        const char* column;
        const char* text;
    };
    for (const cell& c :
         std::initializer_list<cell>{{"type", "f32"},
                                     {"type", "u8"},
                                     {"words", "2"},
                                     {"words", "two"},
                                     {"access", "rx"},
                                     {"saved", "maybe"},
                                     {"when", "later"},
                                     {"effective", "soon"},
                                     {"modes", "PX"},
                                     {"min", "low"},
                                     {"max", "70000"},
                                     {"max", "0x"},
                                     {"default", "-1"},
                                     {"scale", "1/0"},
                                     {"scale", "ten"},
                                     {"scale", "1e9"},
                                     {"unit", "mA"},
                                     {"unit", "rpm"},
                                     {"unit", "furlong"},
                                     {"unit", "\xC2\xB0"
                                              "C"},
                                     {"flags", "motions"},
                                     {"flags", "trigger"},
                                     {"flags", "zero_by_name"},
                                     {"names", "0=off;0=on"},
                                     {"names", "0=off;1=off"},
                                     {"names", "off"},
                                     {"names", "0="},
                                     {"names", "x=off"},
                                     {"names", "0=12"},
                                     {"names", "b16=on"},
                                     {"names", "0x0F:0x10=on"},
                                     {"names", "0=a+b"},
                                     {"names", "70000=on"},
                                     {"names", "halves"},
                                     {"names", "1=a_name_with_more_characters_than_any_may_have"},
                                     {"word_order", "middle"},
                                     {"word_order", "selectable"},
                                     {"word_order", "high"},
                                     {"table", "coils"},
                                     {"table", "coil"},
                                     {"table", "input"},
                                     {"description", "\"open"}})
        refuse(std::string{"address,name,"} + c.column + "\n10,a," + c.text + "\n");
    refuse("address,name,type,table\n1,a,u16,coil\n");
    refuse("address,name,access,table\n1,a,rw,input\n");
    refuse("address,name,names,table\n1,a,hex,coil\n");
    refuse("address,name,min,max\n1,a,5,3\n");
    refuse("address,name,min,max\n1,a,-1,3\n");
    refuse("address,name,type,word_order\n1,a,u32,middle\n");
    refuse("address,name,names\n1,a,1=a_name_that_is_longer_than_any_name_of_a_register_or_of_a_value_may_be_"
           "in_a_file\n");
    refuse("address,name,names\n1,a,1=2\n");
    refuse("address,name,names\n1,a,off=0\n");
    for (const char* scale : {"0.1,mA", "0.1,kW", "0.1,MS", "0.1,", "0x1/2,V", "1/2/3,V"})
        refuse("address,name,scale,unit\n1,a," + std::string{scale} + "\n");
    refuse("address,name,min,flags,access\n1,a,5,zero_by_name,rw\n");
    refuse("address,name,saved,flags,access\n1,a,no,saved_on_write,rw\n");
    refuse("address,name,type\n65535,a,u32\n");
    refuse("address,name\n400001,a\n");
    refuse("address,name\n1,2a\n");
    refuse("address,name\n1,a_name_with_more_characters_than_any_name_may_have\n");
}

// The format of fuzz/fuzz_functions.cpp: the request's length, the request, the response; and that of
// fuzz/fuzz_explain.cpp: no direction, room, the length of the frame before it, both frames. The pairs are those that
// the standard prints.
void functions(corpus& to, corpus& explain) {
    struct pair {
        const char* name;
        byte_list request;
        byte_list response;
    };
    const pair all[]{
        {"01", {1, 0, 0x13, 0, 0x13}, {1, 3, 0xCD, 0x6B, 5}},
        {"02", {2, 0, 0xC4, 0, 0x16}, {2, 3, 0xAC, 0xDB, 0x35}},
        {"03", {3, 0, 0x6B, 0, 3}, {3, 6, 2, 0x2B, 0, 0, 0, 0x64}},
        {"05", {5, 0, 0xAC, 0xFF, 0}, {5, 0, 0xAC, 0xFF, 0}},
        {"06", {6, 0, 1, 0, 3}, {6, 0, 1, 0, 3}},
        {"07", {7}, {7, 0x6D}},
        {"08", {8, 0, 0, 0xA5, 0x37}, {8, 0, 0, 0xA5, 0x37}},
        {"08_counter", {8, 0, 0x0B, 0, 0}, {8, 0, 0x0B, 0x12, 0x34}},
        {"0B", {11}, {11, 0xFF, 0xFF, 1, 8}},
        {"0C", {12}, {12, 8, 0, 0, 1, 8, 1, 0x21, 0x20, 0}},
        {"0F", {15, 0, 0x13, 0, 10, 2, 0xCD, 1}, {15, 0, 0x13, 0, 10}},
        {"10", {16, 0, 1, 0, 2, 4, 0, 10, 1, 2}, {16, 0, 1, 0, 2}},
        {"11", {17}, {17, 3, 0x42, 0xFF, 1}},
        {"16", {22, 0, 4, 0, 0xF2, 0, 0x25}, {22, 0, 4, 0, 0xF2, 0, 0x25}},
        {"17", {23, 0, 3, 0, 2, 0, 14, 0, 1, 2, 0, 0xFF}, {23, 4, 0, 0xFE, 10, 0xCD}},
        {"18", {24, 4, 0xDE}, {24, 0, 6, 0, 2, 1, 0xB8, 0x12, 0x84}},
        {"2B", {43, 14, 1, 0}, {43, 14, 1, 1, 0, 0, 2, 0, 2, 0x41, 0x42, 1, 0}},
        {"2B_more", {43, 14, 1, 0}, {43, 14, 1, 1, 0xFF, 2, 2, 0, 2, 0x41, 0x42, 1, 1, 0x43}},
        {"2B_single", {43, 14, 4, 5}, {43, 14, 4, 0x82, 0, 0, 1, 5, 1, 0x41}},
        {"exception", {1, 0, 0x13, 0, 0x13}, {0x81, 2}},
        {"no_function", {0x41, 0, 1}, {0x41, 0, 1}},
    };
    for (const pair& each : all) {
        const std::string name = "standard_" + std::string{each.name};
        to.add(name, byte_list{low(each.request.size())} + each.request + each.response);
        explain.add(name, byte_list{0, 200, low(each.request.size() + 1), 1} + each.request + byte_list{1} +
                              each.response);
    }
}

// The format of fuzz/fuzz_row_server.cpp: 0 for strict timing, a byte for the clock; then what comes, after which time,
// and the bytes.
void row_requests(corpus& to) {
    const byte_list requests[]{{1, 0, 0, 0, 4},
                               {2, 0, 7, 0, 3},
                               {3, 0, 0x12, 0, 4},
                               {4, 0, 0x10, 0, 2},
                               {5, 0, 1, 0xFF, 0},
                               {6, 0, 0x10, 0, 2},
                               {8, 0, 0, 0xA5, 0x37},
                               {15, 0, 0, 0, 2, 1, 2},
                               {17},
                               {22, 0, 0x10, 0, 3, 0, 0},
                               {43, 14, 1, 0},
                               {43, 14, 3, 0},
                               {16, 0, 0x10, 0, 4, 8, 0, 2, 0, 9, 0, 7, 0, 0},
                               {23, 0, 0x10, 0, 1, 0, 0x10, 0, 1, 2, 0, 0}};
    for (const byte_list& pdu : requests) {
        for (const unsigned what : {1u, 17u, 25u})
            to.add("request_" + std::to_string(pdu[0]) + "_" + std::to_string(pdu.size()) + "_" +
                       std::to_string(what),
                   byte_list{0, 0, low(what), 0x40, low(pdu.size() - 1)} + pdu);
    }
    for (const unsigned seed : {1u, 2u, 3u, 4u})
        to.add("made_" + std::to_string(seed), {0, low(seed), 0xFF, 0, 0, low(seed)});
    to.add("pieces", {0, 0, 8, 0, 3, 7, 3, 0, 8, 0x20, 5, 0x10, 0, 1, 1, 2, 8, 0x30, 2, 7, 7});
    // In host timing: what comes, after which time, and a number that makes a request.
    for (unsigned seed = 0; seed < 24; ++seed) {
        byte_list all{1};
        for (unsigned i = 0; i < 30; ++i)
            all = all + byte_list{low(1 + (seed + i) % 4 * 8 + (i % 7 == 6 ? 0x80 : 0)),
                                  low(seed % 3 == 0   ? 0x35
                                      : seed % 3 == 1 ? 0x11
                                                      : 0x65),
                                  0, low(seed * 30 + i)};
        to.add("host_" + std::to_string(seed), all);
    }
}

} // namespace

int main() {
    corpus request{"request"}, response{"response"}, server{"server"}, exchange{"exchange"}, line{"line"},
        blocking_line{"blocking_line"}, explain{"explain"}, text{"text"}, simulators{"simulators"},
        libmodbus{"libmodbus"}, of_functions{"functions"}, row_server{"row_server"},
        conformance{"conformance"}, device_file{"device_file"}, machine_file{"machine_file"};
    calls(line);
    blocking_line_calls(blocking_line);
    texts(text);
    device_files(device_file);
    machine_files(machine_file);
    functions(of_functions, explain);
    row_requests(row_server);
    // Each command once, undisturbed but for a late response.
    for (std::uint8_t c = 0; c < 15; ++c) conformance.add("command_" + std::to_string(c), {c, 0, 4, 2, 5, 3});
    std::uint8_t device = 0;
    for (const std::string manual : {"zlac8015d", "yako", "c630s"}) {
        const std::vector<printed> frames = frames_of("tests/manuals/" + manual + "_frames.csv");
        if (frames.empty()) return 1;
        const std::size_t step = 1 + frames.size() / 18;
        byte_list session{device};
        for (std::size_t i = 0; i < frames.size(); i += step) {
            const printed& p = frames[i];
            const std::string name = manual + "_" + std::to_string(i + 1);
            (p.is_request ? request : response).add(name, p.pdu());
            const auto direction = static_cast<std::uint8_t>((p.is_request ? 1 : 2) + 16 * device);
            explain.add(name, byte_list{direction, 60, 0} + p.body);
            if (!p.is_request) continue;
            const byte_list wrapped = byte_list{low(p.pdu().size() - 1)} + p.pdu();
            server.add(name, byte_list{low(i % 16), 1, 0} + wrapped + byte_list{3, 0x34, 4, 0x40} + p.pdu());
            libmodbus.add(name, byte_list{0x80, low(p.pdu().size() - 1)} + p.pdu());
            // The simulators take registers by their place in the map.
            const byte_list act{low(p.body[1] == 16  ? 3 + 16u
                                    : p.body[1] == 3 ? 4u
                                                     : 0u),
                                0, p.body[3], p.body[4], p.body[5]};
            session = session + act + byte_list{6, 0, 0, 0x4E, 0x23};
        }
        simulators.add(manual + "_session", session);
        std::size_t made = 0;
        for (std::size_t i = 0; i < frames.size() && made < 2; i += 5) {
            if (!frames[i].is_request || frames[i].body.size() < 6) continue;
            transactions(exchange, manual + "_" + std::to_string(i + 1), frames[i].body);
            ++made;
        }
        device = static_cast<std::uint8_t>(device + (device == 1 ? 2 : 1)); // yako has two maps
    }
    return 0;
}
