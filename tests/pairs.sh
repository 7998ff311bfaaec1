#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Plays every pair of mishaps by the judges for everybody (include/servobus/sim/conformance.hpp), for each command of each
# drive in each start state, under the default interpretation of the manual. Then it plays every single mishap under each
# interpretation alone and under each pair of interpretations. Installs a missing compiler first (Debian, Ubuntu).
#   sh tests/pairs.sh --state FOLDER [DRIVE...]         all shards that FOLDER does not have yet
#   sh tests/pairs.sh --state FOLDER DRIVE SHARD/SHARDS one shard of the pairs of mishaps of a drive
#   sh tests/pairs.sh --count [DRIVE...]                about how many pairs of mishaps there are, in a minute
#   DRIVE     zlac8015d, yako_closed_loop, yako_open_loop, c630s, or winch, the example's; all if none is given
#   CXX       the compiler, g++ if not given
#   CXXFLAGS  flags after the usual ones
#   JOBS      shards at a time, 1 if not given
#   SHARDS    parts of the pairs of each drive, 100 if not given
# FOLDER keeps a file for each finished shard, of this program only: after a change of the code all is played again. A line
# for each shard, with its runs, findings and CPU seconds. The last line is a summary. The status is 1 if FOLDER has a
# finding, and 2 after a wrong argument.
set -u
cd "$(dirname "$0")/.." || exit 1

usage() {
    echo "usage: sh tests/pairs.sh --state FOLDER [DRIVE...] | --state FOLDER DRIVE SHARD/SHARDS | --count [DRIVE...]" >&2
    exit 2
}
all="winch zlac8015d yako_closed_loop yako_open_loop c630s"
counts=0
state=""
case ${1:-} in
--count)
    counts=1
    shift ;;
--state)
    [ $# -ge 2 ] || usage
    state=$2
    shift 2 ;;
*) usage ;;
esac
shard=""
drives=""
for word in "$@"; do
    case " $all " in
    *" $word "*) drives="$drives $word" ;;
    *)
        case $word in */*[!0-9]* | *[!0-9/]* | /* | */ | */*/*) usage ;; */*) shard=$word ;; *) usage ;; esac ;;
    esac
done
[ -z "$shard" ] || [ "$(echo "$drives" | wc -w)" = 1 ] || usage
[ -n "$drives" ] || drives=$all

. tests/support/install.sh
CXX=${CXX:-g++}
command -v "${CXX%% *}" >/dev/null 2>&1 || must_install "$(echo "${CXX%% *}" | sed 's/^clang++/clang/')" libc6-dev
[ -e /usr/include/doctest/doctest.h ] || must_install doctest-dev

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
warnings="-Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wold-style-cast -Wshadow -Werror"
# shellcheck disable=SC2086
$CXX -std=c++20 -O2 $warnings -Iinclude -I. ${CXXFLAGS:-} tests/sim/pairs.cpp -o "$work/pairs" || exit 1

if [ $counts = 1 ]; then
    for drive in $drives; do
        echo "$drive: $("$work/pairs" "$drive" count) of mishaps, $("$work/pairs" "$drive" choices) interpretations"
    done
    exit 0
fi

folder="$state/$(cksum <"$work/pairs" | tr ' ' _)"
mkdir -p "$folder" || exit 2

# play DRIVE KIND SHARD/SHARDS, unless it is finished. Ends all if the shard does not exist.
cat >"$work/play" <<'END'
file="$folder/$(echo "$1 $2 $3" | tr ' /' '__')"
[ -e "$file" ] && exit 0
"$work/pairs" "$1" "$2" "$3" >"$file.part"
status=$?
[ $status -le 1 ] || { echo "pairs.sh: $1 $2 $3: status $status"; exit 255; }
mv "$file.part" "$file"
cat "$file"
END
export work folder
list() {
    if [ -n "$shard" ]; then
        echo "$drives mishaps $shard"
        return
    fi
    shards=${SHARDS:-100}
    for drive in $drives; do
        i=0
        while [ $i -lt "$shards" ]; do
            echo "$drive mishaps $i/$shards"
            i=$((i + 1))
        done
        choices=$("$work/pairs" "$drive" choices)
        i=0
        while [ $i -lt "$choices" ]; do
            echo "$drive interpretations $i/$choices"
            i=$((i + 1))
        done
    done
}
list | nice -n 10 xargs -P "${JOBS:-1}" -L 1 sh "$work/play"
ended=$?
cat "$folder"/*_* 2>/dev/null | awk '
    / runs, .* findings, / { runs += $4; findings += $6; seconds += $8; ++shards }
    END {
        printf "pairs.sh: %d shards are finished: %.0f runs, %d findings, %.0f s\n", shards, runs, findings, seconds
        exit findings == 0 ? 0 : 1
    }'
found=$?
[ $ended = 0 ] || exit 2
exit $found
