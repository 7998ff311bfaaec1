#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Builds the fuzzing targets, runs their corpora and fuzzes each; installs missing packages first (Debian,
# Ubuntu).   sh fuzz/run.sh [SECONDS [TARGET...]]        15 seconds each if not given, two targets at a time
#            CXX=g++ sh fuzz/run.sh --replay [TARGET...] only the corpora, with any compiler, without a fuzzer
#   CXX       the compiler, clang++ if not given; only clang++ has the fuzzer
#   CXXFLAGS  flags after the usual ones
#   SEED      makes runs of equal length repeatable; any number but 0
#   JOBS      targets at a time, 2 if not given
#   FOUND     where inputs that crash are kept, fuzz/found if not given
#   KEEP      a folder for the inputs that fuzzing keeps, from which the next run continues
# One line a target: runs, runs a second, coverage, crashes. The status is 1 if any crashed or did not build.
set -u
cd "$(dirname "$0")/.." || exit 1

replays=0
seconds=15
if [ "${1:-}" = --replay ]; then
    replays=1
    shift
elif [ $# -gt 0 ]; then
    seconds=$1
    shift
fi
case $seconds in '' | *[!0-9]*)
    echo "usage: sh fuzz/run.sh [SECONDS [TARGET...]], sh fuzz/run.sh --replay [TARGET...]" >&2
    exit 2 ;;
esac

CXX=${CXX:-clang++}
has_header() { echo "#include <$1>" | $CXX -x c++ -fsyntax-only - 2>/dev/null; }
links_fuzzer() {
    echo 'extern "C" int LLVMFuzzerTestOneInput(const unsigned char*, unsigned long) { return 0; }' |
        $CXX -x c++ -fsanitize=fuzzer,address,undefined - -o "$work/probe" 2>/dev/null
}
. tests/support/install.sh

work=$(mktemp -d)
found=${FOUND:-fuzz/found}
trap 'rm -rf "$work"; rmdir "$found" 2>/dev/null' EXIT
command -v "${CXX%% *}" >/dev/null 2>&1 || install "$(echo "${CXX%% *}" | sed 's/^clang++/clang/')" libc6-dev
if [ "$replays" = 0 ] && ! links_fuzzer; then
    install "libclang-rt-$($CXX -dumpversion | cut -d. -f1)-dev"
    links_fuzzer || {
        echo "run.sh: $CXX has no -fsanitize=fuzzer; CXX=$CXX sh fuzz/run.sh --replay runs the corpora"
        exit 1
    }
fi
has_header modbus/modbus.h || install libmodbus-dev

all=""
for folder in fuzz/corpus/*; do all="$all $(basename "$folder")"; done
skipped=""
if ! has_header modbus/modbus.h; then
    skipped=" (libmodbus-dev cannot be installed: its target is skipped)"
    all=$(echo "$all" | sed 's/ libmodbus//')
fi
# Names of targets are plain, so that word splitting is harmless.
[ $# -eq 0 ] || all="$*"

usual="-std=c++20 -O1 -g1 -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wold-style-cast -Wshadow -Werror"
usual="$usual -Iinclude ${CXXFLAGS:-}"
mkdir -p "$found"
# Otherwise the sanitizer keeps 256 MB of freed memory for each target.
export ASAN_OPTIONS="quarantine_size_mb=16:${ASAN_OPTIONS:-}"

# makes_frames TARGET: true if it makes frames, calls or time from a few bytes. There an operand of a comparison is seldom
# a byte of the input, and recording the operands would take half of the time. Long inputs mostly repeat what short ones
# do: they grow by runs, of which these have many. The fuzzer also counts how often each feature occurs, up to a
# threshold, which costs as much as a run if it is not low.
makes_frames() { case $1 in line | blocking_line | server | row_server | conformance | simulators) ;; *) return 1 ;; esac; }

# one TARGET: builds it and runs it; its line goes to $work/TARGET.line
one() {
    libraries=""
    [ "$1" != libmodbus ] || libraries=-lmodbus
    if [ "$replays" = 1 ]; then
        # Without sanitizers, unless CXXFLAGS adds them.
        $CXX $usual fuzz/main.cpp "fuzz/fuzz_$1.cpp" $libraries -o "$work/$1" || return 1
        "$work/$1" "fuzz/corpus/$1" >"$work/$1.log" 2>&1 || return 1
        echo "$1: $(tail -n 1 "$work/$1.log") inputs, no crash" >"$work/$1.line"
        return 0
    fi
    guidance=""
    limits=-max_len=1200
    if makes_frames "$1"; then
        guidance=-fno-sanitize-coverage=trace-cmp
        limits="-max_len=512 -len_control=1000 -entropic_feature_frequency_threshold=16"
    fi
    $CXX $usual -O2 -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=all \
        -fsanitize-coverage-ignorelist=fuzz/uncounted.txt $guidance "fuzz/fuzz_$1.cpp" $libraries -o "$work/$1" || return 1
    find "fuzz/corpus/$1" -type f | sort | paste -s -d , - >"$work/$1.seeds"
    # A folder costs a file for each new input, so only who asks for one has it.
    kept=""
    if [ -n "${KEEP:-}" ]; then
        kept=$KEEP/$1
        mkdir -p "$kept" || return 1
    fi
    # First the whole corpus once, so that an input that crashed before always fails.
    "$work/$1" -runs=0 "fuzz/corpus/$1" >"$work/$1.log" 2>&1 &&
        "$work/$1" -seed="${SEED:-0}" -max_total_time="$seconds" $limits -timeout=300 -rss_limit_mb=1500 \
            -print_final_stats=1 -artifact_prefix="$found/$1-" -seed_inputs="@$work/$1.seeds" ${kept:+"$kept"} >"$work/$1.log" 2>&1 || return 1
    runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$work/$1.log")
    rate=$(sed -n 's/^stat::average_exec_per_sec: *//p' "$work/$1.log")
    coverage=$(sed -n 's/.* cov: \([0-9]*\) .*/\1/p' "$work/$1.log" | tail -n 1)
    echo "$1: $runs runs, $rate a second, coverage $coverage, 0 crashes" >"$work/$1.line"
}
judged() {
    if one "$1" 2>"$work/$1.err"; then
        cat "$work/$1.line"
    else
        echo "$1: FAILED"
        head -n 20 "$work/$1.err"
        [ ! -e "$work/$1.log" ] || grep -aE 'broken:|ERROR:|runtime error|Test unit|Base64|^fuzz/corpus' "$work/$1.log" | tail -n 12
        echo "$1" >>"$work/failed"
    fi
}

# Each of the $jobs slots takes every $jobs-th target.
jobs=${JOBS:-2}
slot() {
    turn=0
    for target in $all; do
        [ $((turn % jobs)) != "$1" ] || judged "$target"
        turn=$((turn + 1))
    done
}
for one_slot in $(seq 0 $((jobs - 1))); do slot "$one_slot" & done
wait

count=$(echo $all | wc -w)
if [ -e "$work/failed" ]; then
    where="what crashed them is in $found"
    [ "$replays" = 0 ] || where="the last file named above each message is the one"
    echo "run.sh: $(wc -l <"$work/failed") of $count targets FAILED; $where"
    exit 1
fi
echo "run.sh: $count targets, no crash$skipped"
