#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Counts the instructions that a small core executes for each operation of an axis, arm-none-eabi-g++ -Os: a conversion
# with its rest, unwrapping into micrometres, sine and cosine, updating a pose, a twist to two wheels. Fails if one
# exceeds its bound on a Cortex-M0+, if a figure differs from the recorded one in axis.tsv (at all with the compiler that
# is named there, by more than 3 % with another), or if a 64-bit division or floating point is linked.
#   sh tests/target/axis.sh [--record]    --record: writes the figures there
set -eu
cd "$(dirname "$0")/../.."
. tests/target/measure.sh

unwanted='__aeabi_[df][a-z0-9]|__aeabi_u?ldivmod|__u?divdi3|__u?moddi3|malloc|_Unwind'
# Prints "name call instructions" for every call of a measured_ function, including what it calls.
calls() {
    awk "$number"'
        FNR == NR {
            at = number($1); at -= at % 2
            if ($3 == "measured_job_begins") begin = at
            else if ($3 == "measured_job_ends") end = at
            else if ($3 ~ /^measured_/) entry[at] = substr($3, 10)
            else if ($3 == "job") for (i = 0; i < number($2); i += 2) is_caller[at + i] = 1
            next
        }
        { pc = number($1) }
        pc == begin { counts = 1 }
        pc == end { counts = 0 }
        counts && pc in entry { name = entry[pc]; ++call[name] }
        pc in is_caller { name = "" }
        counts && name != "" { ++n[name " " call[name]] }
        END { for (c in n) print c, n[c] }' "$work/symbols" "$work/addresses"
}
# Bytes of the library's functions and tables, and of those of the compiler's library that they call: all that the program
# without the library does not have, except the job and the objects of the program.
flash() {
    arm-none-eabi-nm -S --defined-only "$work/program.elf" |
        awk "$number"'
            FNR == NR { is_other[$1] = 1; next }
            NF == 4 && !($4 in is_other) && $4 != "job" && $3 !~ /[bBdD]/ && !($1 in seen) {
                seen[$1] = 1
                bytes += number($2)
            }
            END { print bytes }' "$work/others" -
}
status=0
for core in cortex-m0plus cortex-m4; do
    build nothing "$core"
    arm-none-eabi-nm --defined-only "$work/program.elf" | awk '{ print $3 }' >"$work/others"
    build axis "$core"
    if arm-none-eabi-nm "$work/program.elf" | grep -E " ($unwanted)"; then
        echo "FAILED  on $core: linked, but not to be" >&2
        status=1
    fi
    run || { echo "FAILED  on $core: a wrong result" >&2; exit 1; }
    calls >"$work/$core"
    echo "flash 1 $(flash)" >>"$work/$core"
    echo "ram 1 $(awk "$number"' $3 == "measured_pose" { print number($2) }' "$work/symbols")" >>"$work/$core"
done
most_of() { # CORE NAME FIRST LAST: the most of these calls
    awk -v name="$2" -v first="$3" -v last="$4" \
        '$1 == name && $2 >= first && $2 <= last && $3 > most { most = $3 } END { print most }' "$work/$1"
}

recorded=$here/axis.tsv
: >"$work/figures"
recording=0
[ "${1:-}" != --record ] || recording=1
printf '%-34s%15s%12s%9s\n' "operation" cortex-m0plus cortex-m4 "at most"
operation() { # NAME FUNCTION FIRST LAST MOST-ON-M0+
    name=$1 most=$5
    small=$(most_of cortex-m0plus "$2" "$3" "$4")
    large=$(most_of cortex-m4 "$2" "$3" "$4")
    verdict=""
    if [ "$small" -gt "$most" ]; then verdict="  MORE THAN IT MAY" status=1; fi
    printf '%s\t%s\t%s\n' "$name" "$small" "$large" >>"$work/figures"
    if [ "$recording" = 0 ]; then
        old=$(awk -F'\t' -v n="$name" '$1 == n { print $2, $3 }' "$recorded")
        is_as_recorded "$small $large" "$old" "$recorded"
        [ "$is_recorded" = 1 ] || verdict="$verdict  RECORDED: ${old:-nothing} ($tolerance)" status=1
    fi
    printf '%-34s%15s%12s%9s%s\n' "$name" "$small" "$large" "$most" "$verdict"
}
operation "convert with the rest" convert 1 3 84
operation "unwrap into um" unwrap 1 3 114
operation "sine and cosine" sine 1 3 288
operation "update a pose" update 1 3 748
operation "a twist to two wheels" twist 1 1 251
operation "a twist that is limited" twist 2 2 447
operation "bytes of flash, all of them" flash 1 1 2052
operation "bytes of RAM, a pose" ram 1 1 72
if [ "$recording" = 1 ] && [ "$status" = 0 ]; then
    { echo "# $compiler"; echo "# operation: instructions on Cortex-M0+, on M4"; cat "$work/figures"; } >"$recorded"
fi
exit "$status"
