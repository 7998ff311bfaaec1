#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Tests the command-line tool with its own simulated drives: sh tests/tool.sh PATH-TO-SERVOBUS [PART...]
# Prints one line for each check and a summary; fails if a check failed. Each file in tests/tool/ is a part; without a
# PART all of them run.

tool=${1:?usage: sh tests/tool.sh PATH-TO-SERVOBUS [PART...]}
shift
"$tool" --help >/dev/null || exit 2
[ $# -gt 0 ] || set -- offline command_line suggestions zlac8015d scan devices parameters refused_files consent \
    output backup_targets machine_output listen causes
dir=$(mktemp -d) || exit 2
drive=$dir/drive
parts=$(dirname "$0")/tool
passed=0
failed=0
sim=

finish() {
    [ -n "$sim" ] && kill "$sim" 2>/dev/null
    rm -rf "$dir"
}
trap finish EXIT
trap 'exit 2' INT TERM

ok() { passed=$((passed + 1)); echo "ok      $1"; }
not_ok() { failed=$((failed + 1)); echo "FAILED  $1"; head -n 20 "$dir/out" "$dir/err" | sed 's/^/        /'; }

# Runs the tool and keeps its output, its standard error and its status.
run() { "$tool" "$@" >"$dir/out" 2>"$dir/err" </dev/null; status=$?; }

# check NAME CONDITION...: the condition is a command.
check() {
    name=$1
    shift
    if "$@"; then ok "$name"; else not_ok "$name"; fi
}
status_is() { [ "$status" -eq "$1" ]; }
out_is() { [ "$(cat "$dir/out")" = "$1" ]; }
err_lines_are() { [ "$(wc -l <"$dir/err")" -eq "$1" ]; }
err_has() { grep -qF -- "$1" "$dir/err"; }

# succeeds NAME EXPECTED-OUTPUT ARGUMENTS...
succeeds() {
    name=$1 expected=$2
    shift 2
    run "$@"
    if status_is 0 && out_is "$expected"; then ok "$name"; else not_ok "$name (status $status)"; fi
}
# fails NAME STATUS WORDS ARGUMENTS...: one line on standard error that has the words, no output
fails() {
    name=$1 expected=$2 words=$3
    shift 3
    run "$@"
    if status_is "$expected" && err_has "$words" && err_lines_are 1 && out_is ""; then
        ok "$name"
    else
        not_ok "$name (status $status, expected $expected: $words)"
    fi
}

# until_true COMMAND...: tries for ten seconds
until_true() {
    tries=0
    until "$@"; do
        tries=$((tries + 1))
        [ "$tries" -ge 200 ] && return 1
        sleep 0.05
    done
}
# start_sim DEVICE [OPTION...]: starts a simulated drive at $drive
start_sim() {
    rm -f "$dir/sim.out"
    "$tool" sim "$@" --link "$drive" >"$dir/sim.out" 2>"$dir/sim.err" &
    sim=$!
    until_true test -s "$dir/sim.out" -a -e "$drive"
}
stop_sim() {
    kill "$sim"
    wait "$sim"
    status=$?
    sim=
}

# Corrects the checksum of a backup: restore prints the right one before it opens its port.
fix_checksum() {
    wanted=$("$tool" restore /dev/no-such-port "$1" "$2" 2>&1 | sed -n 's/.*that of its content //p')
    [ -z "$wanted" ] || sed -i "s/^crc16=.*/crc16=$wanted/" "$2"
}
# Prints a backup with another value within the range in every register for which there is one.
other_values() {
    "$tool" map "$1" | awk -F'[,=# ]' '
        NR == FNR { low[$2] = $10; high[$2] = $11; next }
        $1 in high && high[$1] != "" && $2 != "?" {
            v = $2 < high[$1] ? $2 + 1 : $2 - 1
            if (v >= low[$1]) { print $1 "=" v " #"; next }
        }
        { print }' - "$2"
}

for part in "$@"; do
    echo "# $part"
    . "$parts/$part.sh"
    [ -z "$sim" ] || stop_sim
done

echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]
