#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# The cost of including a header: seconds (the shortest of five compilations), the memory of the compiler, and for the
# umbrella header with one device the instructions that the compiler executes. Callgrind counts them, so they are the
# same in every run with one compiler. Fails if a device costs more instructions than its bound (for g++ 12), which
# was 5 % above the counted figure when the bound was set. Nothing depends on the seconds.
#   sh bench/include_cost.sh [--bounds]    --bounds: only the figures that have bounds
set -eu
cd "$(dirname "$0")/.."

extra=""
[ -x /usr/bin/time ] || extra=time
. bench/compiler.sh

including() { # HEADER...: writes $work/program.cpp, which includes them
    for header in "$@"; do echo "#include <$header>"; done >"$work/program.cpp"
}
# The memory is that of the compiler proper, the largest process that g++ starts.
seconds_and_megabytes() {
    for _ in 1 2 3 4 5; do
        # shellcheck disable=SC2086
        /usr/bin/time -f "%U %M" g++ $flags "$work/program.cpp" 2>&1 >/dev/null | tail -n 1
    done | sort -n | awk 'NR == 1 { printf "%.2f %.0f", $1, $2 / 1024 }'
}
if [ "${1:-}" != --bounds ]; then
    printf '%-52s%8s%6s\n' header seconds MB
    row() { # NAME HEADER...
        name=$1
        shift
        including "$@"
        # shellcheck disable=SC2046
        printf '%-52s%8s%6s\n' "$name" $(seconds_and_megabytes)
    }
    row "nothing"
    row "<array> <span>, which are not included" array span
    for header in $(cd include && find servobus -name '*.hpp' ! -path '*/windows/*' ! -path '*/device/*/*' ! -path '*/sim/*/*' | sort); do
        row "$header" "$header"
    done
    for map in zlac8015d/registers yako/closed_loop yako/open_loop c630s/registers; do
        row "servobus/device/$map.hpp" "servobus/device/$map.hpp"
    done
    for device in zlac8015d yako c630s; do
        row "servobus/servobus.hpp and device/$device.hpp" servobus/servobus.hpp "servobus/device/$device.hpp"
    done
    echo
fi

status=0
printf '%-36s%14s%14s\n' "the umbrella header and" "million instr." bound
bounded() { # DEVICE BOUND
    including servobus/servobus.hpp "servobus/device/$1.hpp"
    count=$(($(instructions "$work/program.cpp") / 1000000))
    verdict=""
    if [ "$count" -gt "$2" ]; then verdict="  ABOVE ITS BOUND" status=1; fi
    printf '%-36s%14s%14s%s\n' "device/$1.hpp" "$count" "$2" "$verdict"
}
bounded zlac8015d 760
bounded yako 810
bounded c630s 1095
exit "$status"
