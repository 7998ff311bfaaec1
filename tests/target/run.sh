#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# What the library adds to the program of a small core: flash, compared with the same program without it, static RAM
# with every object of the library, stack, and the instructions that qemu's Cortex-M executes, counted one by one.
# The job of the first programs is to read 8 registers and write 2; the programs with a facade or a bus use it as in
# a machine. A simulated drive responds, and its responses show whether the job was done. Flash and instructions are
# given without and with the four functions of the user, which board.cpp contains.
# Fails if a program links an unwanted part of the run-time library, or if a figure differs from the recorded one in
# figures.tsv, which bench/README.md shows: at all with the compiler that is named there, by more than 3 % with another.
#   sh tests/target/run.sh [--record]    --record: writes the figures to figures.tsv and into bench/README.md
set -eu
cd "$(dirname "$0")/../.."

. tests/target/measure.sh
recorded=$here/figures.tsv

# Functions that no program may link, since they are large, slow or missing. `blocking` may not copy memory either.
unwanted='malloc|free$|_sbrk|printf|__cxa_|__aeabi_[df][a-z0-9]|__aeabi_u?ldivmod|__aeabi_u?idiv|_Unwind|_ZGV'

status=0
printf '%s\n' "# $compiler" "# program core flash ram stack instructions requests flash-with-callbacks instructions-with-callbacks" \
    >"$work/figures"
line='%-72s%-14s%7s%6s%7s%14s%10s%16s%14s'
# shellcheck disable=SC2059
printf "$line\n" "what the library adds" core flash ram stack instructions requests "with callbacks:" instructions
budget_of() { # NAME CORE: the most that a program may take: flash, RAM, stack, instructions, with callbacks
    case "$1 on $2" in
    "blocking line on cortex-m0plus") echo 1056 40 156 1920 2700 ;;
    "... strict timing on cortex-m0plus") echo 908 40 156 2850 3930 ;;
    "... and a single write (06) first, read back while an echo is possible on cortex-m0plus") echo 1232 40 156 2600 3700 ;;
    "line on cortex-m0plus") echo 2748 144 344 3400 4870 ;;
    "... stepped: the calls of a client on cortex-m0plus") echo 3640 144 400 3900 5000 ;;
    "... CRC in 32-bit words on cortex-m0plus") echo 1132 40 156 1620 2440 ;;
    "line on cortex-m0plus") echo 2730 148 340 4000 5100 ;;
    "... without the counters on cortex-m0plus") echo 2608 116 340 4000 5100 ;;
    "... stepped: exchanges of constant frames, without a client on cortex-m0plus")
        echo 2952 148 260 4100 5200 ;;
    # 9.2 KB above the line; the drive has 404 B of RAM.
    "line, facade: init, enable, velocity, disable on cortex-m0plus") echo 12220 515 460 66000 79000 ;;
    # 10.6 KB above the line.
    "line, facade with supervisors: modes, move, stops, feedback, reset on cortex-m0plus")
        echo 13655 515 580 315000 385000 ;;
    esac
}
is_within() { # BUDGET FIGURES...
    budget_left=$1
    shift
    for figure; do
        [ "$figure" -le "${budget_left%% *}" ] || return 1
        budget_left=${budget_left#* }
    done
}
option() { # NAME PROGRAM FLAGS...
    name=$1 source=$2
    shift 2
    for core in cortex-m0plus cortex-m4; do
        build nothing "$core" "$@"
        flash=$(size_of '$1 + $2') ram=$(size_of '$2 + $3')
        build "$source" "$core" "$@"
        flash=$(($(size_of '$1 + $2') - flash)) ram=$(($(size_of '$2 + $3') - ram))
        run || { echo "FAILED  $name on $core: the job was not done"; status=1; continue; }
        stack=$(cat "$work/stack") requests=$(cat "$work/requests")
        count=$(instructions "$drive_and_callbacks") count_all=$(instructions "$drive")
        flash_all=$((flash + $(callbacks_size)))
        verdict=""
        banned=$unwanted
        [ "$source" != blocking ] || banned="$unwanted|mem(cpy|set|move)"
        symbols=$(arm-none-eabi-nm "$work/program.elf" | awk '{ print $NF }' | grep -E "^($banned)" || true)
        [ -z "$symbols" ] || verdict="  PULLS IN $(echo $symbols)"
        now="$flash $ram $stack $count $requests $flash_all $count_all"
        printf '%s\t%s\t%s\n' "$name" "$core" "$(echo "$now" | tr ' ' '\t')" >>"$work/figures"
        if [ "$recording" = 0 ]; then
            old=$(awk -F'\t' -v n="$name" -v c="$core" \
                '$1 == n && $2 == c { print $3, $4, $5, $6, $7, $8, $9 }' "$recorded")
            is_as_recorded "$now" "${old:-0 0 0 0 0 0 0}" "$recorded"
            [ "$is_recorded" = 1 ] || verdict="$verdict  RECORDED: ${old:-nothing}"
        fi
        # The upper limits of some programs, whatever was recorded.
        budget=$(budget_of "$name" "$core")
        [ -z "$budget" ] || is_within "$budget" "$flash" "$ram" "$stack" "$count" "$count_all" ||
            verdict="$verdict  ABOVE ITS BUDGET $budget"
        [ -z "$verdict" ] || status=1
        # shellcheck disable=SC2059
        printf "$line%s\n" "$name" "$core" "$flash" "$ram" "$stack" "$count" "$requests" "$flash_all" "$count_all" "$verdict"
    done
}
object() { # NAME BOUND: the RAM of an object, which may have so many bytes at most
    size=$((0x$(arm-none-eabi-nm -S "$work/objects.o" | awk -v name="$1" '$4 == name { print $2 }')))
    verdict=""
    [ "$size" -le "$2" ] || { verdict="  ABOVE ITS BUDGET $2" status=1; }
    printf '%-72s%-14s%7s%6s%s\n' "$(echo "$1" | tr _ ' ')" cortex-m0plus "" "$size" "$verdict"
}
adds() { # NAME BOUND LINE CALLS: the flash that calls add to tables.cpp, at most so many bytes
    build tables cortex-m0plus -DLINE="$3" -DCALLS=0
    flash=$(size_of '$1 + $2')
    build tables cortex-m0plus -DLINE="$3" -DCALLS="$4"
    flash=$(($(size_of '$1 + $2') - flash))
    verdict=""
    [ "$flash" -le "$2" ] || { verdict="  ABOVE ITS BUDGET $2" status=1; }
    printf '%-72s%-14s%7s%s\n' "$1" cortex-m0plus "$flash" "$verdict"
}
recording=0
[ "${1:-}" != --record ] || recording=1

option "blocking line" blocking
option "... CRC by a table of 16 entries" blocking -DCRC=crc_table16
option "... CRC by a table of 256 entries" blocking -DCRC=crc_table256
option "... CRC in 32-bit words" blocking '-DCRC=crc_trinomial<32>'
option "... strict timing" blocking -DTIMING=strict
option "... without the two retries of a read" blocking -DWITHOUT_RETRIES
option "... and a single write (06) first, read back while an echo is possible" single
option "line" full
option "... without the counters" full -DOBSERVER=unobserved
option "... with echo handling" echo -DHEARS_ITSELF
option "... stepped: exchanges of constant frames, without a client" stepped_exchange
option "... stepped: the calls of a client" stepped
option "line, facade: init, enable, velocity, disable" facade
option "line, facade with supervisors: modes, move, stops, feedback, reset" facade_full
option "line, bus: each of two cyclic reads" bus
option "line, bus, facade: the same commands, the reads between them" bus_facade

# shellcheck disable=SC2086
arm-none-eabi-g++ -std=c++20 -Os -mcpu=cortex-m0plus -mthumb -ffreestanding -fno-exceptions -fno-rtti $strict \
    -Wno-psabi -Iinclude -c "$here/objects.cpp" -o "$work/objects.o"
object facade_of_a_zlac8015d 404
object facade_of_a_closed_loop_yako 470
object facade_of_an_open_loop_yako 470
object facade_of_a_c630s 480

# What calls for other tables and functions add to a program that reads and writes holding registers.
adds "blocking line: and input registers" 184 0 1
adds "... coils read" 184 0 2
adds "... a coil written (05)" 252 0 4
adds "... coils written (0F)" 184 0 8
adds "... bits of a register changed (16h)" 232 0 16
adds "... a write and read in one transaction (17h)" 724 0 32
adds "... all of these" 1660 0 63
adds "line: and input registers" 276 1 1
adds "... coils read" 272 1 2
adds "... a coil written (05)" 288 1 4
adds "... coils written (0F)" 192 1 8
adds "... bits of a register changed (16h)" 296 1 16
adds "... a write and read in one transaction (17h)" 464 1 32
adds "... all of these" 1664 1 63

if [ "$recording" = 1 ]; then
    [ "$status" = 0 ] || { echo "target/run.sh: FAILED, nothing recorded"; exit 1; }
    cp "$work/figures" "$recorded"
    python3 -B bench/readme.py
    echo "target/run.sh: recorded in $recorded and bench/README.md"
elif [ "$status" = 0 ]; then
    echo "target/run.sh: all as in $recorded ($tolerance)"
else
    echo "target/run.sh: FAILED; if the figures are meant to be these: python3 -B bench/record.py"
fi
exit "$status"
