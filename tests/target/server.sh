#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# What a server of rows adds to the program of a small core: flash, static RAM with the values of the rows, stack, and
# the instructions of a read of twelve words without the user's functions. Fails if a response is wrong, or a figure is
# above its budget or differs from the recorded one in server.tsv, which bench/README.md shows.
#   sh tests/target/server.sh [--record]    --record: writes the figures there, and into bench/README.md
set -eu
cd "$(dirname "$0")/../.."

. tests/target/measure.sh

recorded=$here/server.tsv
recording=0
[ "${1:-}" != --record ] || recording=1
printf '%s\n' "# $compiler" "# server, on a Cortex-M0+: flash RAM stack instructions" >"$work/figures"
status=0
line='%-44s%-14s%7s%6s%7s%14s'
# shellcheck disable=SC2059
printf "$line\n" "a server of ten holding registers" core flash ram stack instructions
server() { # NAME BUDGETS FLAGS...: flash, RAM, stack and instructions on the Cortex-M0+
    name=$1 budgets=$2
    shift 2
    for core in cortex-m0plus cortex-m4; do
        made() { # FLAGS...
            compile server "$work/program.o" "$core" -I. "$@"
            compile server_board "$work/board.o" "$core" "$@"
            arm-none-eabi-g++ -mcpu="$core" -mthumb "$work/program.o" "$work/board.o" -nostartfiles \
                --specs=nano.specs -Wl,--gc-sections -T "$here/target.ld" -o "$work/program.elf"
        }
        made -DNOTHING "$@"
        flash=$(size_of '$1 + $2') ram=$(size_of '$2 + $3')
        made "$@"
        flash=$(($(size_of '$1 + $2') - flash)) ram=$(($(size_of '$2 + $3') - ram))
        run || { echo "FAILED  $name on $core: a response is wrong"; status=1; continue; }
        now="$flash $ram $(cat "$work/stack") $(instructions '^(uart_|clock_us|board_)')"
        verdict=""
        if [ "$core" = cortex-m0plus ]; then
            left=$budgets
            for figure in $now; do
                [ "$figure" -le "${left%% *}" ] || verdict="  ABOVE ITS BUDGET $budgets" status=1
                left=${left#* }
            done
            printf '%s\t%s\n' "$name" "$(echo "$now" | tr ' ' '\t')" >>"$work/figures"
            if [ "$recording" = 0 ]; then
                old=$(awk -F'\t' -v n="$name" '$1 == n { print $2, $3, $4, $5 }' "$recorded")
                is_as_recorded "$now" "${old:-0 0 0 0}" "$recorded"
                [ "$is_recorded" = 1 ] || verdict="$verdict  RECORDED: ${old:-nothing}"
            fi
            [ -z "$verdict" ] || status=1
        fi
        # shellcheck disable=SC2059,SC2086
        printf "$line%s\n" "$name" "$core" $now "$verdict"
    done
}

server "alone" "1080 92 164 1650" -DONLY_HOLDING
server "and four coils, two input registers" "1280 92 164 1650"
server "... CRC by a table of 16 entries" "1280 92 164 1650" "-DOPTIONS=,with_crc<modbus::crc_table16>"
server "... function 16h" "1400 92 180 1700" -DOPTIONS=,with_mask_write
server "... functions 16h and 17h" "1620 92 180 1700" -DOPTIONS=,with_mask_write,with_read_write
server "... function 2Bh" "1580 92 164 1650" "-DOPTIONS=,with_identification<about>"
server "... two hooks" "1380 96 164 1650" -DHOOKS

if [ "$status" != 0 ]; then
    echo "target/server.sh: FAILED; if the figures are meant to be these: python3 -B bench/record.py"
elif [ "$recording" = 1 ]; then
    cp "$work/figures" "$recorded"
    python3 -B bench/readme.py
    echo "target/server.sh: recorded in $recorded and bench/README.md"
else
    echo "target/server.sh: all as in $recorded ($tolerance)"
fi
exit "$status"
