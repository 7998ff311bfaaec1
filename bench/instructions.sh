#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Counts the instructions of each operation with callgrind, and those of the same operation written by hand in C.
# Fails if a ratio is above its bound. The counts are the same in every run with the same compiler: a figure is
# the difference between two runs of many operations, which excludes the start of the program. All figures include
# the loop around each operation, 10 instructions.
# Each compiler has its own bounds: clang++ unrolls the peer's table look-ups and g++ does not, so the peer is faster
# with clang++. bench/figures/instructions.tsv has the figures of g++ 12 and clang++ 14. With one of these compilers,
# a figure that differs by more than 1 % from the recorded one fails too.
#   CXX=clang++ sh bench/instructions.sh [--record]   --record: writes the counts there, and into bench/README.md
set -eu
cd "$(dirname "$0")/.."

missing=""
command -v "${CXX:-g++}" >/dev/null 2>&1 || missing="$missing g++"
command -v valgrind >/dev/null 2>&1 || missing="$missing valgrind"
[ -e /usr/include/modbus/modbus.h ] || missing="$missing libmodbus-dev"
if [ -n "$missing" ]; then
    . tests/support/install.sh
    # shellcheck disable=SC2086
    must_install $missing
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"${CXX:-g++}" -std=c++20 -O2 -Iinclude bench/bench_instructions.cpp bench/operations.cpp bench/sides/*.cpp \
    bench/peers/*.cpp -lmodbus -o "$work/instructions"
"$work/instructions" check

counted() { # SIDE OPERATION TIMES
    valgrind --tool=callgrind --callgrind-out-file=/dev/null "$work/instructions" "$@" 2>"$work/log" || return $?
    sed -n 's/.*Collected : *\([0-9]*\).*/\1/p' "$work/log"
}
cost() { # SIDE OPERATION: instructions per operation, or a dash
    few=$(counted "$1" "$2" 1000) || { echo -; return; }
    many=$(counted "$1" "$2" 3000)
    echo $(((many - few + 1000) / 2000))
}

family=g++
! echo | "${CXX:-g++}" -dM -E -x c++ - | grep -q __clang__ || family=clang++
compiler="$family $("${CXX:-g++}" -dumpversion | cut -d . -f 1)"
bound() { # hundredths
    case "$family $1" in
    "g++ transaction"*) echo 119 ;;
    "g++ "*) echo 80 ;;
    "clang++ transaction"*) echo 153 ;;
    *) echo 105 ;;
    esac
}
figures=bench/figures/instructions.tsv

status=0
echo "$compiler -O2"
printf '%-22s%10s%14s%8s%8s%14s%11s\n' "instructions" servobus hand-written ratio bound "only reading" libmodbus
"$work/instructions" operations >"$work/operations"
while IFS= read -r operation; do
    own=$(cost servobus "$operation")
    other=$(cost hand-written "$operation")
    library=$(cost libmodbus "$operation")
    limit=$(bound "$operation")
    verdict=""
    printf '%s\t%s\t%s\t%s\t%s\n' "$compiler" "$operation" "$own" "$other" "$library" >>"$work/figures"
    if [ "${1:-}" != --record ]; then
        awk -F'\t' -v c="$compiler" -v o="$operation" -v own="$own" -v other="$other" '
            $1 == c && $2 == o { exit away(own, $3) || away(other, $4) }
            function away(now, old) { return 100 * now > 101 * old || 100 * now < 99 * old }' "$figures" || {
            verdict="  NOT AS RECORDED"
            status=1
        }
    fi
    if [ $((100 * own)) -gt $((limit * other)) ]; then
        verdict="$verdict  ABOVE ITS BOUND"
        status=1
    fi
    printf '%-22s%10s%14s%8s%8s%14s%11s%s\n' "$operation" "$own" "$other" \
        "$(awk "BEGIN { printf \"%.2f\", $own / $other }")" "$(awk "BEGIN { printf \"%.2f\", $limit / 100 }")" \
        "$(cost "only reading" "$operation")" "$library" "$verdict"
done <"$work/operations"
if [ "${1:-}" = --record ] && [ "$status" = 0 ]; then
    { grep '^#' "$figures"; { grep -v '^#' "$figures" | grep -v "^$compiler	" || true; cat "$work/figures"; } |
        sort -s -r -k 1,1; } >"$work/all"
    cp "$work/all" "$figures"
    python3 -B bench/readme.py
fi
exit "$status"
