#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Counts the instructions of each operation with callgrind, beside the same operation written by hand in C, and
# fails if a ratio is above its bound. The counts are the same in every run with the same compiler: a figure is
# the difference between two runs of many operations, so that the start of the program cancels. The loop around
# each operation, 10 instructions, is in all figures.
# The bounds are for g++ 12; clang 14 unrolls the peer's table look-ups, and five of the seven are above theirs.
set -eu
cd "$(dirname "$0")/.."

missing=""
command -v "${CXX:-g++}" >/dev/null 2>&1 || missing="$missing g++"
command -v valgrind >/dev/null 2>&1 || missing="$missing valgrind"
[ -e /usr/include/modbus/modbus.h ] || missing="$missing libmodbus-dev"
if [ -n "$missing" ]; then
    echo "instructions.sh: installing$missing with apt-get"
    as_root=""
    [ "$(id -u)" = 0 ] || as_root=sudo
    $as_root apt-get update -qq
    # shellcheck disable=SC2086
    DEBIAN_FRONTEND=noninteractive $as_root apt-get install -y -qq --no-install-recommends $missing >/dev/null
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"${CXX:-g++}" -std=c++20 -O2 -Iinclude bench/instructions.cpp bench/operations.cpp bench/sides/*.cpp \
    bench/peers/*.cpp -lmodbus -o "$work/instructions"
"$work/instructions" check

counted() { # SIDE OPERATION TIMES
    valgrind --tool=callgrind --callgrind-out-file=/dev/null "$work/instructions" "$@" 2>"$work/log" || return $?
    sed -n 's/.*Collected : *\([0-9]*\).*/\1/p' "$work/log"
}
cost() { # SIDE OPERATION: instructions an operation, or a dash
    few=$(counted "$1" "$2" 1000) || { echo -; return; }
    many=$(counted "$1" "$2" 3000)
    echo $(((many - few + 1000) / 2000))
}

bound() {
    case $1 in
    transaction*) echo 120 ;;
    *) echo 100 ;;
    esac
}

status=0
printf '%-22s%10s%14s%8s%8s%14s%11s\n' "instructions" servobus hand-written ratio bound "only reading" libmodbus
"$work/instructions" operations >"$work/operations"
while IFS= read -r operation; do
    own=$(cost servobus "$operation")
    other=$(cost hand-written "$operation")
    limit=$(bound "$operation")
    verdict=""
    if [ $((100 * own)) -gt $((limit * other)) ]; then
        verdict="  ABOVE ITS BOUND"
        status=1
    fi
    printf '%-22s%10s%14s%8s%8s%14s%11s%s\n' "$operation" "$own" "$other" \
        "$(awk "BEGIN { printf \"%.2f\", $own / $other }")" "$(awk "BEGIN { printf \"%.2f\", $limit / 100 }")" \
        "$(cost "only reading" "$operation")" "$(cost libmodbus "$operation")" "$verdict"
done <"$work/operations"
exit "$status"
