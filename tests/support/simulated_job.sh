# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# What the tests of the example programs share; they source it. It wants `tool`, the command-line tool, and gives
# `work`, a folder that goes away, `simulator` and `check`.
work=$(mktemp -d)
simulator=""
clean_up() {
    [ -z "$simulator" ] || kill "$simulator" 2>/dev/null
    rm -rf "$work"
}
trap clean_up EXIT
failed=0
checks=0

check() { # NAME EXPECTED FOUND
    checks=$((checks + 1))
    if [ "$2" = "$3" ]; then
        echo "ok      $1"
    else
        echo "FAILED  $1: expected '$2', found '$3'"
        failed=$((failed + 1))
    fi
}

start_simulator() { # DEVICE: it answers on $work/drive
    "$tool" sim "$1" --link "$work/drive" >"$work/simulator.log" 2>&1 &
    simulator=$!
    until [ -e "$work/drive" ]; do
        kill -0 "$simulator" || exit 1
        sleep 0.05
    done
}
