#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Counts the instructions that a small core executes for each operation of the protocol, arm-none-eabi-g++ -Os: the CRC
# by each engine, building requests, parsing a response, a step of an idle drive, and, as tests/target/run.sh counts
# them, the whole read of 8 registers and write of 2. Fails if a CRC engine exceeds its bound, or if a figure differs
# from the recorded one in operations.tsv: at all with the compiler that is named there, by more than 3 % with another.
#   sh tests/target/operations.sh [--record]    --record: writes the counts there, and into bench/README.md
set -eu
cd "$(dirname "$0")/../.."
. tests/target/measure.sh

# Prints for every call of a measured_ function, including the functions that it calls but those of the user:
# "name call instructions".
calls() {
    awk "$number"'
        FNR == NR {
            at = number($1); at -= at % 2
            if ($3 == "measured_job_begins") begin = at
            else if ($3 == "measured_job_ends") end = at
            else if ($3 ~ /^measured_/) entry[at] = substr($3, 10)
            else if ($3 ~ /^(uart_|clock_us)/) for (i = 0; i < number($2); i += 2) is_users[at + i] = 1
            else if ($3 == "job" || $3 ~ /all_lengths/) for (i = 0; i < number($2); i += 2) is_caller[at + i] = 1
            next
        }
        { pc = number($1) }
        pc == begin { counts = 1 }
        pc == end { counts = 0 }
        counts && pc in entry { name = entry[pc]; ++call[name] }
        pc in is_caller { name = "" }
        counts && name != "" && !(pc in is_users) { ++n[name " " call[name]] }
        END { for (c in n) print c, n[c] }' "$work/symbols" "$work/addresses"
}
for core in cortex-m0plus cortex-m4; do
    build operations "$core"
    run || { echo "FAILED  on $core: a wrong result" >&2; exit 1; }
    calls >"$work/$core"
    build blocking "$core"
    run
    echo "pair 1 $(instructions "$drive_and_callbacks")" >>"$work/$core"
    build idle "$core"
    run || { echo "FAILED  on $core: the drive was not idle" >&2; exit 1; }
    calls >>"$work/$core"
done
count() { awk -v name="$2" -v call="$3" '$1 == name && $2 == call { print $3 }' "$work/$1"; } # CORE NAME CALL

recorded=$here/operations.tsv
: >"$work/figures"
keep() { # NAME FIGURES...: notes the figures; without --record also compares them with the recorded ones
    name=$1
    shift
    printf '%s\t%s\n' "$name" "$(echo "$@" | tr ' ' '\t')" >>"$work/figures"
    [ "$recording" = 0 ] || return 0
    old=$(awk -F'\t' -v n="$name" '$1 == n { $1 = ""; print }' "$recorded")
    is_as_recorded "$*" "$old" "$recorded"
    [ "$is_recorded" = 1 ] || {
        echo "RECORDED:$old"
        status=1
    }
}
recording=0
[ "${1:-}" != --record ] || recording=1
status=0
above() { # FIGURE MOST: whether the figure exceeds MOST; false if MOST is -
    [ "$2" != - ] && awk "BEGIN { exit !($1 > $2) }"
}
line='%-18s%-15s%8s%9s%11s'
# shellcheck disable=SC2059
printf "$line\n" "CRC" core "8 bytes" "a byte" "unaligned"
engine() { # NAME FUNCTION [MOST-OF-8 MOST-A-BYTE MOST-AT-AN-ODD-ADDRESS, of each core]
    name=$1 function=$2 all=""
    shift 2
    for core in cortex-m0plus cortex-m4; do
        eight=$(count $core "$function" 1)
        aligned=$(awk "BEGIN { printf \"%.2f\", ($(count $core "$function" 3) - $(count $core "$function" 2)) / 192 }")
        odd=$(awk "BEGIN { printf \"%.2f\", ($(count $core "$function" 5) - $(count $core "$function" 4)) / 192 }")
        verdict=""
        if above "$eight" "${1:--}" || above "$aligned" "${2:--}" || above "$odd" "${3:--}"; then
            verdict="  MORE THAN IT MAY"
            status=1
        fi
        [ $# -lt 3 ] || shift 3
        all="$all $eight $aligned"
        # shellcheck disable=SC2059
        printf "$line%s\n" "$name" "$core" "$eight" "$aligned" "$odd" "$verdict"
    done
    # shellcheck disable=SC2086
    keep "$name" $all
}
engine crc_bitwise bitwise
engine crc_table16 table16
engine crc_table256 table256
engine 'crc_trinomial<8>' trinomial8 - 14 14 - 10 10
engine 'crc_trinomial<16>' trinomial16
engine 'crc_trinomial<32>' trinomial32 - 3.75 8.5 62 2.75 2.75

printf '\n%-34s%15s%12s\n' "operation" cortex-m0plus cortex-m4
operation() { # NAME FUNCTION [MOST]
    most=${3:--}
    set -- "$1" "$(count cortex-m0plus "$2" 1)" "$(count cortex-m4 "$2" 1)"
    verdict=""
    if above "$2" "$most" || above "$3" "$most"; then verdict="  MORE THAN IT MAY" status=1; fi
    printf '%-34s%15s%12s%s\n' "$@" "$verdict"
    keep "$@"
}
operation "build a write (06)" build_06
operation "build a read (03)" build_03
operation "build a write of 8 (10h)" build_10h
operation "parse a response of 8" parse_03
operation "a step of an idle drive" idle_step 113 # 9 of them call it and compare what it returns
operation "read 8 and write 2, a blocking line" pair
if [ "$recording" = 1 ] && [ "$status" = 0 ]; then
    { echo "# $compiler"; echo "# CRC engine: 8 bytes and a byte on Cortex-M0+, the same on M4; operation: M0+, M4"; cat "$work/figures"; } >"$recorded"
    python3 -B bench/readme.py
fi
exit "$status"
