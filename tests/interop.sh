#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Interoperability with other programs: libmodbus, mbpoll, tshark, over pseudo-terminals; socat and libmodbus as gateways
# and servers in the network.
#   sh tests/interop.sh [TOOL]     TOOL: the built command-line tool; it is built if not given
# It installs missing packages with apt-get (Debian, Ubuntu) and reports it. A peer that cannot be installed is named,
# and its checks count as skipped.
#   CXX    the compiler, g++ if not given
set -u
tool=${1:-}
case $tool in '' | /*) ;; *) tool=$(pwd)/$tool ;; esac
cd "$(dirname "$0")/.." || exit 1

work=$(mktemp -d)
begun=""
finish() {
    for one in $begun; do kill "$one" 2>/dev/null; done
    rm -rf "$work"
}
trap finish EXIT
trap 'exit 2' INT TERM
checks=0
failed=0
skipped=0

ok() { checks=$((checks + 1)); echo "ok      $1"; }
not_ok() { checks=$((checks + 1)); failed=$((failed + 1)); echo "FAILED  $1"; }
check() { # NAME EXPECTED FOUND
    if [ "$2" = "$3" ]; then ok "$1"; else not_ok "$1: expected '$2', found '$3'"; fi
}
skip() { # HOW-MANY WHAT
    skipped=$((skipped + $1))
    echo "skipped $1 checks: $2"
}

. tests/support/install.sh
CXX=${CXX:-g++}
command -v "${CXX%% *}" >/dev/null 2>&1 || install "$(echo "${CXX%% *}" | sed 's/^clang++/clang/')" libc6-dev || exit 1
has_libmodbus() { echo '#include <modbus/modbus.h>' | $CXX -x c++ -fsyntax-only - 2>/dev/null; }
# has PACKAGE TEST...: installs the package if the test fails, and tests again.
has() {
    package=$1
    shift
    "$@" >/dev/null 2>&1 || install "$package"
    "$@" >/dev/null 2>&1 || { echo "interop.sh: $package cannot be installed"; return 1; }
}

usual="-std=c++20 -O1 -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wold-style-cast -Wshadow -Werror"
build() { # PROGRAM [LIBRARY...]
    program=$1
    shift
    $CXX $usual -Iinclude "tests/interop/$program.cpp" "$@" -o "$work/$program" || { not_ok "build $program"; return 1; }
}
# Starts a program in the background; `ended` ends it.
begin() { # NAME COMMAND...
    name=$1
    shift
    "$@" >"$work/$name.out" 2>"$work/$name.err" &
    eval "pid_of_$name=$!"
    begun="$begun $!"
}
ended() { # NAME
    eval "one=\$pid_of_$1"
    kill "$one" 2>/dev/null
    wait "$one" 2>/dev/null
}
# Waits for a device that the program NAME makes; gives up only if that program has ended.
until_there() { # NAME PATH...
    eval "one=\$pid_of_$1"
    shift
    for path in "$@"; do
        until [ -e "$path" ]; do
            kill -0 "$one" 2>/dev/null || { not_ok "$path was not made"; return 1; }
            sleep 0.05
        done
    done
}
# Runs a program of these tests and counts its checks, one a line.
checked() { # PROGRAM ARGUMENT...
    program=$1
    shift
    "$work/$program" "$@" >"$work/$program.said" 2>&1
    status=$?
    cat "$work/$program.said"
    checks=$((checks + $(grep -cE '^(ok|FAILED) ' "$work/$program.said")))
    found=$(grep -c '^FAILED ' "$work/$program.said")
    failed=$((failed + found))
    # A program that crashed has not reported a failed check.
    [ "$status" = 0 ] || [ "$found" != 0 ] || not_ok "$program ended with $status"
}
same_registers() { # NAME SERVER-SAID CLIENT-SAID: each register that was written, and no other
    sort -u "$2" >"$work/one"
    sort -u "$3" >"$work/other"
    if [ -s "$work/one" ] && cmp -s "$work/one" "$work/other"; then ok "$1"; else
        not_ok "$1"
        diff "$work/one" "$work/other" | head -n 5
    fi
}

foreign_server() { # starts the server of libmodbus at one end of a pair of pseudo-terminals
    begin socat socat "pty,raw,echo=0,link=$work/near" "pty,raw,echo=0,link=$work/far"
    until_there socat "$work/near" "$work/far" || return 1
    begin libmodbus "$work/libmodbus_server" "$work/far"
}
own_server() {
    begin own "$work/own_server" "$work/own"
    until_there own "$work/own"
}

against_libmodbus() {
    build libmodbus_server -lmodbus && build own_client && build own_server && build libmodbus_client -lmodbus &&
        build same_responses || return
    echo "# our client, libmodbus' server"
    foreign_server || return
    checked own_client "$work/near" "$work/written"
    same_registers "libmodbus' server holds what servobus' client wrote" "$work/libmodbus.out" "$work/written"
    ended libmodbus
    echo "# libmodbus' client, our server"
    own_server || return
    checked libmodbus_client "$work/own" "$work/written"
    same_registers "servobus' server holds what libmodbus' client wrote" "$work/own.out" "$work/written"
    ended own
    echo "# the same requests to both servers"
    begin libmodbus "$work/libmodbus_server" "$work/far"
    own_server || return
    checked same_responses "$work/own" "$work/near"
    ended own
    ended libmodbus
    ended socat
}

poll() { # ARGUMENT...: polls the simulated drive with mbpoll and prints the values in one line
    mbpoll -m rtu -b 115200 -P none -0 -1 -o 5 "$@" >"$work/polled" 2>&1
    status=$?
    sed -n 's/^\[[0-9]*\]:[[:space:]]*\([^[:space:]]*\).*/\1/p' "$work/polled" | tr '\n' ' '
    return $status
}
told() { "$tool" read "$work/drive" raw "$@" | sed 's/^[^=]*=0x0*\([0-9A-F]\)/\1/; s/^.*=//; s/ .*//' | tr '\n' ' '; }

against_mbpoll() {
    echo "# mbpoll, the simulated drive of the tool"
    begin sim "$tool" sim zlac8015d --link "$work/drive"
    until_there sim "$work/drive" || return
    check "mbpoll reads a register" "1000 " "$(poll -a 1 -r 8192 -c 1 "$work/drive")"
    check "mbpoll reads two registers" "$(poll -a 1 -r 8320 -c 1 "$work/drive")$(poll -a 1 -r 8321 -c 1 "$work/drive")" \
        "$(poll -a 1 -r 8320 -c 2 "$work/drive")"
    poll -a 1 -r 8320 "$work/drive" 700 >/dev/null
    check "mbpoll writes a register" 0 $?
    check "the tool reads what mbpoll wrote" "left_acceleration_time=700 ms" \
        "$("$tool" read "$work/drive" zlac8015d left_acceleration_time)"
    poll -a 1 -r 8320 "$work/drive" 300 400 >/dev/null
    check "mbpoll writes two registers" 0 $?
    check "mbpoll reads what it wrote" "300 400 " "$(poll -a 1 -r 8320 -c 2 "$work/drive")"
    "$tool" write "$work/drive" zlac8015d left_acceleration_time=900 >/dev/null
    check "mbpoll reads what the tool wrote" "900 " "$(poll -a 1 -r 8320 -c 1 "$work/drive")"
    poll -a 1 -r 4096 -c 1 "$work/drive" >/dev/null
    check "mbpoll gets the exception for a register that does not exist" 1 "$(grep -ci 'illegal data address' "$work/polled")"
    poll -a 1 -t 0 -r 1 -c 1 "$work/drive" >/dev/null
    check "mbpoll gets the exception for coils" 1 "$(grep -ci 'illegal function' "$work/polled")"
    mbpoll -m rtu -b 115200 -P none -0 -1 -o 0.3 -a 2 -r 8192 -c 1 "$work/drive" >"$work/polled" 2>&1
    check "mbpoll gets no response from a node that does not exist" 1 "$(grep -ci 'timed out' "$work/polled")"
    ended sim
}

# Prints how tshark dissects each frame, in the columns of frames_pcap.cpp.
dissected() {
    tshark -r "$1" -o mbrtu.crc_verification:TRUE -o mbrtu.tcp.port:1502 -T fields -E separator=, -E 'aggregator= ' \
        -e mbrtu.crc16.status -e mbrtu.unit_id -e modbus.func_code -e modbus.exception_code \
        -e modbus.reference_num -e modbus.word_cnt -e modbus.byte_cnt -e modbus.regval_uint16 -e modbus.data \
        -e _ws.expert.severity -e _ws.col.Info 2>"$work/tshark.err" |
        sed 's/ *\(Query:\|Response:\).*/\1/; s/^0,.*/bad CRC/'
}
judged_by_tshark() {
    build frames_pcap || return
    echo "# tshark, the frames that we make"
    "$work/frames_pcap" "$work/frames.pcap" "$work/expected" tests/manuals/*_frames.csv
    check "the printed frames are made again for tshark" 0 $?
    dissected "$work/frames.pcap" >"$work/dissected"
    frames=$(wc -l <"$work/expected")
    check "tshark reads every frame as a frame" "$frames" "$(wc -l <"$work/dissected")"
    wrong=$(paste -d '|' "$work/expected" "$work/dissected" | awk -F '|' '$1 != $2 { ++n } END { print n + 0 }')
    check "tshark sees in $frames frames what we see, and warns of none" 0 "$wrong"
    [ "$wrong" = 0 ] || diff "$work/expected" "$work/dissected" | head -n 10
    bad=$(grep -c '^bad CRC$' "$work/expected")
    check "$bad frames with a wrong CRC are so for tshark too" "$bad" "$(grep -c '^bad CRC$' "$work/dissected")"
}

if has libmodbus-dev has_libmodbus && has socat command -v socat; then
    against_libmodbus
else
    skip 91 "our client and server against libmodbus"
fi
if [ -z "$tool" ]; then
    echo "interop.sh: building the command-line tool"
    tool=$work/servobus
    # shellcheck disable=SC2086
    $CXX -std=c++20 -O1 -Iinclude examples/servobus/*.cpp examples/servobus/*/*.cpp -o "$tool" || not_ok "the tool does not build"
fi
if has mbpoll command -v mbpoll; then
    against_mbpoll
else
    skip 10 "the simulated drive against mbpoll"
fi
if has socat command -v socat && has libmodbus-dev has_libmodbus && has python3 command -v python3; then
    . tests/interop/network.sh
    over_ethernet
else
    skip 87 "the tool behind gateways"
fi
if has tshark command -v tshark; then
    judged_by_tshark
else
    skip 4 "tshark's view of our frames"
fi

echo "interop.sh: $checks checks, $failed failed, $skipped skipped"
[ "$failed" = 0 ]
