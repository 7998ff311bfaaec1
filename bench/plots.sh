#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Draws bench/plots/size.svg from tests/target/figures.tsv and bench/peers/recorded.tsv. Runs the benchmarks of the CRC
# and draws bench/plots/crc.svg from them. Fails if a series or a value is missing in a plot.
set -eu
cd "$(dirname "$0")/.."

if ! command -v python3 >/dev/null 2>&1; then
    . tests/support/install.sh
    must_install python3
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
sh bench/build.sh "$work"
# Many short, interleaved repetitions: some of each run undisturbed, and the best one is drawn.
"$work/servobus_bench" --benchmark_min_time=0.004 --benchmark_repetitions=150 \
    --benchmark_enable_random_interleaving=true --benchmark_out="$work/times.json" --benchmark_out_format=json \
    --benchmark_filter='^(crc_(bitwise|table16|table256|slicing8|trinomial<(8|64)>)|libmodbus, a frame)/' >"$work/log"
sed -n '/^ns, CRC/,/^$/p' "$work/log" | grep '[0-9] x\|ns,'

compiler=$(basename "${CXX:-g++}")
case $compiler in # the name may carry the version already, as g++-12 does
*[0-9]) ;;
*) compiler="$compiler $("${CXX:-g++}" -dumpversion | cut -d . -f 1)" ;;
esac
python3 -B bench/plot.py "$work/times.json" "$compiler -O2, $(uname -m | tr _ -); the best of 150 repetitions."
python3 -B bench/plot.py --check
echo "plots.sh: bench/plots/size.svg and bench/plots/crc.svg are drawn"
