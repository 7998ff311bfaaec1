#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# What the library adds to a small core's program that reads 8 registers and writes 2: flash beside the same
# program without it, static RAM, stack, and executed instructions, without the user's own four functions, each
# instruction that qemu's Cortex-M executes counted. And nothing of the run-time library that a small program
# would not have anyway. A figure that is more than 3 % above the recorded one fails: figures.tsv has them.
#   sh tests/target/run.sh [--record]    --record: writes what was measured to figures.tsv
set -eu
cd "$(dirname "$0")/../.."

missing=""
command -v arm-none-eabi-g++ >/dev/null 2>&1 ||
    missing="gcc-arm-none-eabi libnewlib-arm-none-eabi libstdc++-arm-none-eabi-newlib"
command -v qemu-system-arm >/dev/null 2>&1 || missing="$missing qemu-system-arm"
if [ -n "$missing" ]; then
    echo "target/run.sh: installing $missing with apt-get"
    as_root=""
    [ "$(id -u)" = 0 ] || as_root=sudo
    $as_root apt-get update -qq
    # shellcheck disable=SC2086
    DEBIAN_FRONTEND=noninteractive $as_root apt-get install -y -qq --no-install-recommends $missing >/dev/null
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
here=tests/target
recorded=$here/figures.tsv
strict="-Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wold-style-cast -Wshadow -Werror"

build() { # PROGRAM CORE FLAGS...: into $work/program.elf
    program=$1 core=$2
    shift 2
    # shellcheck disable=SC2086
    arm-none-eabi-g++ -std=c++20 -Os -mcpu="$core" -mthumb -ffreestanding -fno-exceptions -fno-rtti \
        -fno-unwind-tables -fno-asynchronous-unwind-tables -ffunction-sections -fdata-sections $strict -Wno-psabi "$@" \
        -Iinclude "$here/$program.cpp" "$here/board.cpp" -nostartfiles --specs=nano.specs -Wl,--gc-sections \
        -T "$here/target.ld" -o "$work/program.elf"
}
size_of() { # the number of an awk expression over text, data and bss
    arm-none-eabi-size "$work/program.elf" | awk "NR == 2 { print $1 }"
}

# What a program must not need, since it is large, slow or not there; the least one no copying of memory either.
unwanted='malloc|free$|_sbrk|printf|__cxa_|__aeabi_[df][a-z0-9]|__aeabi_u?ldivmod|_Unwind|_ZGV'
run() { # the program: $work/stack and, each instruction's address, $work/addresses
    qemu-system-arm -M mps2-an386 -semihosting-config enable=on,target=native -display none -serial null \
        -singlestep -d exec,nochain -D "$work/log" -kernel "$work/program.elf" 2>"$work/stack" </dev/null || return 1
    arm-none-eabi-nm -S --defined-only "$work/program.elf" | awk 'NF == 4 { print $1, $2, $4 }' >"$work/symbols"
    awk -F/ '/^Trace/ { print $2 }' "$work/log" >"$work/addresses"
}
# Instructions of the measured job that are not the user's.
instructions() {
    awk 'function number(hex,   n, i) {
             n = 0
             for (i = 1; i <= length(hex); ++i) n = 16 * n + index("0123456789abcdef", substr(hex, i, 1)) - 1
             return n
         }
         FNR == NR {
             at = number($1); at -= at % 2
             if ($3 == "measured_job_begins") begin = at
             if ($3 == "measured_job_ends") end = at
             if ($3 ~ /^(uart_|clock_us)/) for (i = 0; i < number($2); i += 2) users[at + i] = 1
             next
         }
         { pc = number($1) }
         pc == begin { counts = 1 }
         pc == end { counts = 0 }
         counts && !(pc in users) { ++n }
         END { print n - 4 }' "$work/symbols" "$work/addresses" # less the mark and the call
}

status=0
printf '%s\n' "# program core flash ram stack instructions" >"$work/figures"
line='%-34s%-14s%7s%6s%7s%14s'
# shellcheck disable=SC2059
printf "$line\n" "what the library adds" core flash ram stack instructions
option() { # NAME PROGRAM FLAGS...
    name=$1 source=$2
    shift 2
    for core in cortex-m0plus cortex-m4; do
        build nothing "$core"
        flash=$(size_of '$1 + $2') ram=$(size_of '$2 + $3')
        build "$source" "$core" "$@"
        flash=$(($(size_of '$1 + $2') - flash)) ram=$(($(size_of '$2 + $3') - ram))
        run || { echo "FAILED  $name on $core: the job was not done"; status=1; continue; }
        stack=$(sed 's/^0*//' "$work/stack") count=$(instructions)
        verdict=""
        banned=$unwanted
        [ "$source" != small ] || banned="$unwanted|mem(cpy|set|move)"
        symbols=$(arm-none-eabi-nm "$work/program.elf" | awk '{ print $NF }' | grep -E "^($banned)" || true)
        [ -z "$symbols" ] || verdict="  PULLS IN $(echo $symbols)"
        printf '%s\t%s\t%s\t%s\t%s\t%s\n' "$name" "$core" "$flash" "$ram" "$stack" "$count" >>"$work/figures"
        old=$(awk -F'\t' -v n="$name" -v c="$core" '$1 == n && $2 == c { print $3, $4, $5, $6 }' "$recorded" 2>/dev/null || true)
        if [ "${1:-}" != --record ] && [ "$recording" = 0 ]; then
            # shellcheck disable=SC2086
            above=$(echo "$flash $ram $stack $count ${old:-0 0 0 0}" |
                awk '{ for (i = 1; i <= 4; ++i) if (100 * $i > 103 * $(i + 4)) print "above" }')
            [ -z "$above" ] || verdict="$verdict  ABOVE THE RECORDED ${old:-nothing}"
        fi
        [ -z "$verdict" ] || status=1
        # shellcheck disable=SC2059
        printf "$line%s\n" "$name" "$core" "$flash" "$ram" "$stack" "$count" "$verdict"
    done
}
recording=0
[ "${1:-}" != --record ] || recording=1

option "small line" small
option "  CRC by a table of 16" small -DCRC=crc_table16
option "  CRC by a table of 256" small -DCRC=crc_table256
option "  CRC in words" small '-DCRC=crc_trinomial<32>'
option "  strict timing" small -DTIMING=strict
option "  and single writes (06)" single
option "line" full
option "  with echo handling" echo -DHEARS_ITSELF
option "  and a ZLAC8015D's facade" facade

if [ "$recording" = 1 ]; then
    cp "$work/figures" "$recorded"
    echo "target/run.sh: recorded in $recorded"
elif [ "$status" = 0 ]; then
    echo "target/run.sh: all within 3 % of $recorded"
else
    echo "target/run.sh: FAILED"
fi
exit "$status"
