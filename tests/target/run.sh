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

. tests/target/measure.sh
recorded=$here/figures.tsv

# What a program must not need, since it is large, slow or not there; the least one no copying of memory either.
unwanted='malloc|free$|_sbrk|printf|__cxa_|__aeabi_[df][a-z0-9]|__aeabi_u?ldivmod|_Unwind|_ZGV'

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
        stack=$(sed 's/^0*//' "$work/stack") count=$(instructions '^(uart_|clock_us)')
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
        # What a program of this kind may cost at most, whatever was recorded.
        if [ "$source $core $#" = "small cortex-m0plus 0" ]; then
            [ "$flash" -le 880 ] && [ "$ram" -le 40 ] && [ "$stack" -le 176 ] && [ "$count" -le 2900 ] ||
                verdict="$verdict  ABOVE ITS BUDGET 880 40 176 2900"
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
option "  without retries" small -DWITHOUT_RETRIES
option "  and single writes (06)" single
option "line" full
option "  with echo handling" echo -DHEARS_ITSELF
option "  and a bus" bus
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
