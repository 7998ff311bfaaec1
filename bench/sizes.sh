#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Prints the bytes of code and table of each CRC engine on Cortex-M, arm-none-eabi-g++ -Os. Fails if an engine exceeds
# its bound, or if a size differs from bench/figures/sizes.tsv.
#   sh bench/sizes.sh [--record]    --record: writes the sizes there, and into bench/README.md
set -eu
cd "$(dirname "$0")/.."
if ! command -v arm-none-eabi-g++ >/dev/null 2>&1; then
    . tests/support/install.sh
    must_install gcc-arm-none-eabi libnewlib-arm-none-eabi libstdc++-arm-none-eabi-newlib
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
figures=bench/figures/sizes.tsv
status=0
printf '%-28s%12s%12s\n' "bytes of code and table" "Cortex-M4" "Cortex-M0+"
for engine in 'crc_bitwise' 'crc_table16' 'crc_table256' 'crc_trinomial<8>' 'crc_trinomial<16>' 'crc_trinomial<32>'; do
    printf '#include <servobus/modbus/crc_tables.hpp>\nusing namespace servobus::modbus;\n%s\n' \
        "std::uint16_t crc(const std::uint8_t* p, std::size_t n) { using e = $engine; return e::end(e::update(e::begin(), servobus::slice<const std::uint8_t>{p, n})); }" \
        >"$work/engine.cpp"
    row=""
    for core in cortex-m4 cortex-m0plus; do
        arm-none-eabi-g++ -std=c++20 -Os -mcpu=$core -mthumb -fno-exceptions -fno-rtti -fno-unwind-tables \
            -fno-asynchronous-unwind-tables -Iinclude -c "$work/engine.cpp" -o "$work/engine.o"
        row="$row $(arm-none-eabi-size "$work/engine.o" | awk 'NR == 2 { print $1 + $2 }')"
    done
    verdict=""
    case $engine in
    'crc_trinomial<8>') most=80 ;;
    'crc_trinomial<32>') most=220 ;;
    *) most=1000 ;;
    esac
    for size in $row; do [ "$size" -le "$most" ] || verdict="  LARGER THAN IT MAY BE"; done
    # shellcheck disable=SC2086
    printf '%s\t%s\t%s\n' "$engine" $row >>"$work/figures"
    [ "${1:-}" = --record ] || grep -qxF "$(tail -n 1 "$work/figures")" "$figures" || verdict="$verdict  NOT AS RECORDED"
    [ -z "$verdict" ] || status=1
    # shellcheck disable=SC2086
    printf '%-28s%12s%12s%s\n' "$engine" $row "$verdict"
done
if [ "${1:-}" = --record ] && [ "$status" = 0 ]; then
    { echo "# CRC engine, bytes with its table on Cortex-M4, on Cortex-M0+"; cat "$work/figures"; } >"$figures"
    python3 -B bench/readme.py
fi
exit "$status"
