#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# The cost of a device's map for a program that includes it and reads two registers: the instructions that the compiler
# executes for each row, and bytes of flash on a Cortex-M0+. Callgrind counts the instructions, so they are the same
# in every run with one compiler. Both figures are compared with the same program with only these two rows, so they
# exclude the cost of reading. Fails if a row costs more instructions than its bound (for g++ 12), or if unused rows
# cost flash. A bound is 3 % above the counted figure. The microseconds are these instructions at the rate at which
# this machine executes the compiler; nothing depends on them.
#   sh bench/compile_cost.sh
set -eu
cd "$(dirname "$0")/.."

extra=""
command -v arm-none-eabi-g++ >/dev/null 2>&1 ||
    extra="gcc-arm-none-eabi libnewlib-arm-none-eabi libstdc++-arm-none-eabi-newlib"
. bench/compiler.sh

# program FILE HEADER NAMESPACE REGISTER REGISTER: writes a program that reads two registers of a map.
program() {
    echo "#include <servobus/client/client.hpp>
#include <servobus/device/$2>
namespace map = servobus::$3;" >"$1"
    reading "$4" "$5" >>"$1"
}
# two_rows FILE DEVICE ADDRESS ADDRESS: writes the same program with these two rows only.
two_rows() {
    {
        echo "#include <servobus/client/client.hpp>
#include <servobus/device/$2/values.hpp>
namespace map { using servobus::$2::device; }"
        for row in "a $3" "b $4"; do
            echo "namespace map { inline constexpr servobus::reg<servobus::u16, servobus::access::ro, device> row_${row% *}{
                ${row#* }, servobus::full<servobus::u16>, servobus::no_unit, servobus::no_default}; }"
        done
        reading row_a row_b
    } >"$1"
}
reading() { # REGISTER REGISTER
    cat <<REST
struct uart {
    servobus::transfer send(servobus::bytes);
    bool sent();
    servobus::transfer receive(servobus::byte_buffer);
    servobus::instant now();
};
unsigned both(servobus::client<servobus::line<uart>, map::device>& c) {
    const auto a = c.template read<map::$1>();
    const auto b = c.template read<map::$2>();
    return a && b ? 1u : 0u;
}
REST
}

seconds() { # FILE: the shortest of nine compilations
    for _ in 1 2 3 4 5 6 7 8 9; do
        bash -c 'TIMEFORMAT=%U; time g++ '"$flags"' "$1"' _ "$1" 2>&1
    done | sort -n | head -1
}
flash() { # FILE
    arm-none-eabi-g++ -std=c++20 -Os -mcpu=cortex-m0plus -mthumb -fno-exceptions -fno-rtti -fno-unwind-tables \
        -fno-asynchronous-unwind-tables -Iinclude -c "$1" -o "$work/flash.o"
    arm-none-eabi-size "$work/flash.o" | awk 'NR == 2 { print $1 + $2 + $3 }'
}

echo '#include <servobus/client/client.hpp>' >"$work/without.cpp"
without=$(instructions "$work/without.cpp")
without_seconds=$(seconds "$work/without.cpp")
status=0
rate=$(awk "BEGIN { printf \"%.0f\", $without / $without_seconds / 1e6 }")
line='%-18s%6s%15s%12s%12s%10s%8s%14s'
# shellcheck disable=SC2059
printf "$line\n" map rows instructions "for a row" bound "us a row" flash "with two rows"
measure() { # NAME ROWS BOUND HEADER NAMESPACE DEVICE REGISTER ADDRESS REGISTER ADDRESS
    name=$1 rows=$2 bound=$3 header=$4
    program "$work/map.cpp" "$header" "$5" "$7" "$9"
    two_rows "$work/two.cpp" "$6" "$8" "${10}"
    size=$(flash "$work/map.cpp")
    few=$(flash "$work/two.cpp")
    more=$(($(instructions "$work/map.cpp") - $(instructions "$work/two.cpp")))
    a_row=$((more / (rows - 2)))
    verdict=""
    [ "$a_row" -le "$bound" ] || verdict="  ABOVE ITS BOUND"
    [ "$size" -le "$few" ] || verdict="$verdict  UNUSED ROWS COST FLASH"
    [ -z "$verdict" ] || status=1
    # shellcheck disable=SC2059
    printf "$line%s\n" "$name" "$rows" "$more" "$a_row" "$bound" "$((a_row / rate))" "$size" "$few" "$verdict"
}
measure zlac8015d 116 319000 zlac8015d/registers.hpp zlac8015d zlac8015d speed_resolution 0x2022 max_motor_speed 0x2008
measure yako-closed-loop 204 161000 yako/closed_loop.hpp yako::closed_loop yako error_code 0x0006 drive_model 0x0000
measure yako-open-loop 208 150500 yako/open_loop.hpp yako::open_loop yako error_code 0x0006 drive_model 0x0000
measure c630s 463 295500 c630s/registers.hpp c630s c630s software_version 0x0100 servo_status 0x3000
echo "here the compiler executes $rate instructions a us"
exit "$status"
