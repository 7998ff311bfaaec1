#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# What the library adds to the program of a small core: flash, compared with the same program without it, static RAM
# with every object of the library, stack, and the instructions that qemu's Cortex-M executes, counted one by one.
# The job of the first programs is to read 8 registers and write 2; the programs with a facade or a bus use it as in
# a machine. A simulated drive responds, and its responses show whether the job was done. Flash and instructions are
# given without and with the four functions of the user, which board.cpp contains.
# Fails if a program links an unwanted part of the run-time library, exceeds its row of budgets.tsv, or if a figure
# differs from the recorded one in figures.tsv or calls.tsv, which bench/README.md shows: at all with the compiler that
# is named there, by more than 3 % with another.
#   sh tests/target/run.sh [--record]    --record: writes the figures to these files and into bench/README.md
set -eu
cd "$(dirname "$0")/../.."

. tests/target/measure.sh
recorded=$here/figures.tsv
recorded_calls=$here/calls.tsv

# Functions that no program may link, since they are large, slow or missing. `blocking` may not copy memory either.
unwanted='malloc|free$|_sbrk|printf|__cxa_|__aeabi_[df][a-z0-9]|__aeabi_u?ldivmod|__aeabi_u?idiv|_Unwind|_ZGV'

status=0
printf '%s\n' "# $compiler" "# program core flash ram stack instructions requests flash-with-callbacks instructions-with-callbacks" \
    >"$work/figures"
printf '%s\n' "# $compiler" "# calls, flash that they add on a Cortex-M0+: blocking-line line" >"$work/calls"
line='%-72s%-14s%7s%6s%7s%14s%10s%16s%14s'
# shellcheck disable=SC2059
printf "$line\n" "what the library adds" core flash ram stack instructions requests "with callbacks:" instructions
budgets=$here/budgets.tsv
budget_of() { # NAME CORE: the most that a program may take: flash, RAM, stack, instructions, with callbacks
    [ "$2" = cortex-m0plus ] || return 0
    awk -F'\t' -v n="$1" '$1 == n { print $2, $3, $4, $5, $6 }' "$budgets"
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
flash_of_calls() { # LINE CALLS: the flash that calls add to tables.cpp
    build tables cortex-m0plus -DLINE="$1" -DCALLS=0
    without=$(size_of '$1 + $2')
    build tables cortex-m0plus -DLINE="$1" -DCALLS="$2"
    echo $(($(size_of '$1 + $2') - without))
}
adds() { # NAME CALLS BOUND BOUND: on a blocking line and on a line, at most so many bytes
    now="$(flash_of_calls 0 "$2") $(flash_of_calls 1 "$2")"
    printf '%s\t%s\n' "$1" "$(echo "$now" | tr ' ' '\t')" >>"$work/calls"
    verdict=""
    if [ "$recording" = 0 ]; then
        old=$(awk -F'\t' -v n="$1" '$1 == n { print $2, $3 }' "$recorded_calls")
        is_as_recorded "$now" "${old:-0 0}" "$recorded_calls"
        [ "$is_recorded" = 1 ] || verdict="  RECORDED: ${old:-nothing}"
    fi
    is_within "$3 $4" $now || verdict="$verdict  ABOVE ITS BUDGET $3 $4"
    [ -z "$verdict" ] || status=1
    # shellcheck disable=SC2086
    printf '%-72s%-14s%7s%6s%s\n' "$1" cortex-m0plus $now "$verdict"
}
# A value of a float or of 64 bits, read by integers alone: nothing for floating point or division is linked.
by_integers() { # NAME CALLS BOUND BOUND
    adds "$@"
    for of in 0 1; do
        build tables cortex-m0plus -DLINE="$of" -DCALLS="$2"
        symbols=$(arm-none-eabi-nm "$work/program.elf" | awk '{ print $NF }' | grep -E "^($unwanted)" || true)
        [ -z "$symbols" ] || { echo "FAILED  $1 links $(echo $symbols)"; status=1; }
    done
}
# Names that stand in two rows, of which the second would never be reached, and those that no program has.
names_are_unique() { # FILE COLUMNS
    doubled=$(grep -v '^#' "$1" | cut -f "$2" | sort | uniq -d)
    [ -z "$doubled" ] || { echo "FAILED  two rows of $1: $doubled"; status=1; }
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
object facade_of_a_zlac8015d 400
object facade_of_a_closed_loop_yako 440
object facade_of_an_open_loop_yako 440
object facade_of_a_c630s 476

# What calls for other tables and functions add to a program that reads and writes holding registers.
printf '\n%-72s%-14s%7s%6s\n' "what calls add" core "flash: blocking line," line
adds "read two input registers" 1 184 276
adds "read three coils" 2 184 272
adds "write a coil (05)" 4 248 272
adds "write two coils (0F)" 8 184 192
adds "change bits of a register (16h)" 16 232 296
adds "write, then read (17h)" 32 752 464
adds "all of them" 63 1684 1644
by_integers "read two floats, one as a count" 128 672 760
by_integers "read 64 bits" 512 268 360
by_integers "read a part of a register" 1024 236 320
by_integers "read a value and its exponent, as a count" 2048 836 924
adds "read two floats, one in floating point" 256 1408 1496
build tables cortex-m0plus -DLINE=0 -DCALLS=256
arm-none-eabi-nm "$work/program.elf" | grep -q ' __aeabi_f' ||
    { echo "FAILED  no floating point is found where the program asks for it"; status=1; }

# The floor of the picture in bench/README.md: the job by hand, whose figures stand with those of the other libraries.
floor="hand-written, without promises"
recorded_floor=bench/peers/recorded.tsv
build nothing cortex-m0plus
flash=$(size_of '$1 + $2') ram=$(size_of '$2 + $3')
build by_hand cortex-m0plus
flash=$(($(size_of '$1 + $2') - flash + $(callbacks_size))) ram=$(($(size_of '$2 + $3') - ram))
run || { echo "FAILED  $floor: the job was not done"; status=1; }
now="$flash $ram $(cat "$work/stack") $(instructions "$drive")"
verdict=""
if [ "$recording" = 0 ]; then
    old=$(awk -F'\t' -v n="$floor" '$1 == n { print $2, $3, $4, $5 }' "$recorded_floor")
    is_as_recorded "$now" "${old:-0 0 0 0}" "$recorded"
    [ "$is_recorded" = 1 ] || verdict="  RECORDED: ${old:-nothing}" status=1
fi
# shellcheck disable=SC2086
printf '\n%-72s%-14s%7s%6s%7s%14s%s\n' "$floor; with callbacks" cortex-m0plus $now "$verdict"

names_are_unique "$budgets" 1
names_are_unique "$work/figures" 1,2
names_are_unique "$work/calls" 1
unused=$(grep -v '^#' "$budgets" | cut -f 1 | grep -vxF "$(cut -f 1 "$work/figures")" || true)
[ -z "$unused" ] || { echo "FAILED  a budget of no program: $unused"; status=1; }

if [ "$recording" = 1 ]; then
    [ "$status" = 0 ] || { echo "target/run.sh: FAILED, nothing recorded"; exit 1; }
    cp "$work/figures" "$recorded"
    cp "$work/calls" "$recorded_calls"
    sed -i "s/^$floor\t.*/$floor\t$(echo "$now" | sed 's/ /\\t/g')/" "$recorded_floor"
    python3 -B bench/readme.py
    echo "target/run.sh: recorded in $recorded and bench/README.md"
elif [ "$status" = 0 ]; then
    echo "target/run.sh: all as in $recorded ($tolerance)"
else
    echo "target/run.sh: FAILED; if the figures are meant to be these: python3 -B bench/record.py"
fi
exit "$status"
