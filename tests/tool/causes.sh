# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Part of tests/tool.sh: what the bytes on the line show of a failure: the request's own echo, another protocol, bytes
# that are no response; a port that this user may not open; several registers of which some fail. odd_peer.py is a
# gateway that responds wrongly.
# shellcheck shell=sh

# read_from SCHEME BYTES ARGUMENT...: reads from a peer that responds with these bytes.
read_from() {
    rm -f "$dir/peer"
    python3 -B "$parts/odd_peer.py" "$2" >"$dir/peer" &
    peer=$!
    until_true test -s "$dir/peer"
    url="$1://127.0.0.1:$(cat "$dir/peer")"
    shift 2
    run read "$url" "$@"
    kill "$peer" 2>/dev/null
    wait "$peer" 2>/dev/null
}
# says NAME TEXT: status 1, no output, one line of complaint that ends so
says() {
    name=$1 expected=$2
    if status_is 1 && out_is "" && err_lines_are 1 && [ "$(cat "$dir/err")" = "servobus: $expected" ]; then
        ok "$name"
    else
        not_ok "$name (status $status)"
    fi
}

# An adapter that receives what it sends.
start_sim zlac8015d --echo on
run read "$drive" zlac8015d bus_voltage
says "read: the request's own echo" "bus_voltage: what came is the request's own echo: try --echo on"
run read "$drive" zlac8015d:9 bus_voltage --timeout 100 --retries 0
says "read: the echo alone" "bus_voltage: what came is the request's own echo: try --echo on"
run read "$drive" raw 0x0212 --baud 115200
says "read: an echo that is a well-formed response" "0x0212: what came is the request's own echo: try --echo on"
run watch "$drive" zlac8015d bus_voltage --count 2 --interval 10
check "watch: the request's own echo, in each round" \
    [ "$(grep -c 'bus_voltage=(what came is the request.s own echo: try --echo on)$' "$dir/out")" -eq 2 ]
check "watch: and at the end" err_has "no response in any round: what came is the request's own echo: try --echo on"
run write "$drive" zlac8015d left_max_current=13
says "G3: write: what may be the request's own echo" \
    "left_max_current: unknown, what came may be the request's own echo: try --echo on"
run write "$drive" zlac8015d node_address=2
says "G3: write: nothing is sent after an echo" "node_address: not sent, what came is the request's own echo: try --echo on"
stop_sim

# One that does not, or no drive.
start_sim zlac8015d
run read "$drive" zlac8015d bus_voltage --echo on
says "read: no echo" "bus_voltage: the request did not come back as echo: try --echo off"
run read "$drive" raw 0x20A1:4 --echo on --baud 115200
says "read: a response in place of the echo" "0x20A1:4: the request did not come back as echo: try --echo off"
run watch "$drive" zlac8015d bus_voltage --count 1 --interval 10 --echo on
check "watch: no echo" err_has "no response in any round: the request did not come back as echo: try --echo off"

# Several registers.
run read "$drive" raw 0x3000 0x20A1 0x3001:2 0x2088 --baud 115200
check "read: each register that failed is named with its reason" \
    [ "$(cat "$dir/err")" = "servobus: 0x3000: refused, exception 2 (illegal data address); 0x3001:2: refused, exception 2 (illegal data address)" ]
check "read: the others are printed" out_is "0x20A1=2400 (0x0960)
0x2088=0 (0x0000)"
check "read: and the status is 1" status_is 1
run read "$drive" zlac8015d:9 bus_voltage status_word --timeout 20 --retries 0
says "read: no response to any" "bus_voltage: no response; status_word: no response"
stop_sim

# Gateways.
response="01 03 02 09 60"
read_from mbap "nnnn 0000 0005 $response" zlac8015d bus_voltage
check "mbap: the peer works" out_is "bus_voltage=24.00 V"
read_from mbap "$response BE 3C" zlac8015d bus_voltage --retries 0
says "mbap: RTU frames" "bus_voltage: what came is no Modbus TCP: try $(echo "$url" | sed s/mbap/tcp/)"
read_from mbap "01 83 02 C0 F1" zlac8015d bus_voltage --retries 0 --timeout 200
says "mbap: RTU frames that are shorter than a header" \
    "bus_voltage: what came is no Modbus TCP: try $(echo "$url" | sed s/mbap/tcp/)"
read_from mbap "nnnn 0000 FFFF $response" zlac8015d bus_voltage --retries 0
says "mbap: a wrong length" "bus_voltage: what came is no Modbus TCP: try $(echo "$url" | sed s/mbap/tcp/)"
read_from mbap "FFFF 0000 0005 $response" zlac8015d bus_voltage --retries 0 --timeout 200
says "mbap: another number" "bus_voltage: 11 bytes came, none a response of node 1"
read_from tcp "55 55 55 55 55 55 $response BE 3C" zlac8015d bus_voltage --retries 0 --timeout 200
says "a glitch in front of a response" "bus_voltage: 13 bytes came, none a response of node 1"
read_from tcp "55" zlac8015d:7 bus_voltage --retries 0 --timeout 200
says "a glitch" "bus_voltage: 1 byte came, none a response of node 7"
read_from tcp "$response BE 3D" zlac8015d bus_voltage --retries 0
says "a wrong CRC stays one" "bus_voltage: wrong CRC"

# A port that this user may not open: root may open any, but for one without its capabilities.
unprivileged() {
    if [ "$(id -u)" -eq 0 ]; then setpriv --bounding-set=-all --inh-caps=-all "$@"; else "$@"; fi
}
if [ -n "${ON_WINE:-}" ]; then
    echo "left out: Windows has no groups of a port"
elif ! unprivileged true 2>/dev/null; then
    echo "left out: this machine lets root keep its capabilities"
else
    start_sim zlac8015d
    terminal=$(readlink "$drive")
    [ "$(id -u)" -ne 0 ] || chgrp tty "$terminal"
    chmod 060 "$terminal"
    group=$(stat -c %G "$terminal")
    unprivileged "$tool" read "$drive" zlac8015d bus_voltage >"$dir/out" 2>"$dir/err"
    status=$?
    if [ "$group" = root ]; then
        echo "left out: a pseudo-terminal has no group of its own here"
    else
        says "a port of another group" "cannot open $drive: Permission denied; the group $group may use it: sudo usermod -aG $group \$USER, then log out and in again"
    fi
    chmod 000 "$terminal"
    unprivileged "$tool" read "$drive" zlac8015d bus_voltage >"$dir/out" 2>"$dir/err"
    status=$?
    says "a port that its group may not use either" \
        "cannot open $drive: Permission denied; only its owner may use it, and the administrator"
    stop_sim
fi
run read /dev/null zlac8015d bus_voltage
says "no serial device: the system's reason" \
    "cannot open /dev/null: no serial device, or not with these settings: Inappropriate ioctl for device"
