# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# The command-line tool behind gateways: socat as a transparent one to each simulated drive, libmodbus as a server of
# Modbus TCP, a second one that passes Modbus TCP on to a simulated drive. Read by interop.sh.

# Waits for the first line that a program prints, and prints it.
first_line_of() { # NAME
    eval "one=\$pid_of_$1"
    until [ -s "$work/$1.out" ]; do
        kill -0 "$one" 2>/dev/null || return 1
        sleep 0.05
    done
    head -n 1 "$work/$1.out"
}
# The port on which socat listens, as it says itself.
port_of_socat() { # NAME
    eval "one=\$pid_of_$1"
    until grep -q 'listening on' "$work/$1.err" 2>/dev/null; do
        kill -0 "$one" 2>/dev/null || return 1
        sleep 0.05
    done
    sed -n 's/.*listening on .*:\([0-9]*\)$/\1/p' "$work/$1.err" | head -n 1
}
run() { # AS ARGUMENT...: output, errors and status of the tool
    as=$1
    shift
    "$tool" "$@" >"$work/$as.said" 2>"$work/$as.complained" </dev/null
    echo $? >"$work/$as.status"
}
# A gateway for one connection: it has the drive's port until it ends, and then the next program may have it.
gateway_run() { # SCHEME AS COMMAND ARGUMENT...
    scheme=$1 as=$2 command=$3
    shift 3
    rm -f "$work/gateway.out" "$work/gateway.err"
    case $scheme in
    tcp) begin gateway timeout 60 socat -d -d "TCP-LISTEN:0,bind=127.0.0.1" "OPEN:$work/drive,raw,echo=0"
        port=$(port_of_socat gateway) ;;
    mbap) begin gateway timeout 60 python3 -B tests/interop/mbap_gateway.py "$work/drive"
        port=$(first_line_of gateway) ;;
    esac
    [ -n "$port" ] || not_ok "the gateway has no port"
    run "$as" "$command" "$scheme://127.0.0.1:$port" "$@"
    sed -i "s|$scheme://127.0.0.1:$port|PORT|g" "$work/$as.said" "$work/$as.complained"
    wait "$pid_of_gateway"
}
both() { # NAME STATUS COMMAND ARGUMENT...: the command says the same over the gateway as over the serial port
    what=$1 status=$2 command=$3
    shift 3
    run direct "$command" "$work/drive" "$@"
    sed -i "s|$work/drive|PORT|g" "$work/direct.said" "$work/direct.complained"
    gateway_run "$scheme" gateway "$command" "$@"
    for kind in said complained; do
        cmp -s "$work/direct.$kind" "$work/gateway.$kind" && continue
        not_ok "$scheme, $drive: $what: $kind"
        diff "$work/direct.$kind" "$work/gateway.$kind" | head -n 5
        return
    done
    check "$scheme, $drive: $what" "$status $status" "$(cat "$work/direct.status") $(cat "$work/gateway.status")"
}
fails() { # NAME STATUS WORDS ARGUMENT...: one line of complaint that has the words, and no output
    what=$1 expected=$2 words=$3
    shift 3
    run failing "$@"
    if [ "$(cat "$work/failing.status")" = "$expected" ] && [ ! -s "$work/failing.said" ] &&
        [ "$(wc -l <"$work/failing.complained")" = 1 ] && grep -qF -- "$words" "$work/failing.complained"; then
        ok "$what"
    else
        not_ok "$what: status $(cat "$work/failing.status"), $(cat "$work/failing.complained")"
    fi
}

behind_gateways() { # SCHEME
    scheme=$1
    for drive in zlac8015d yako-closed-loop yako-open-loop c630s; do
        begin sim "$tool" sim $drive --link "$work/drive"
        until_there sim "$work/drive" || return
        case $drive in
        zlac8015d) names="bus_voltage left_actual_position host_timeout" change=left_acceleration_time=700 ;;
        yako-*) names="status_word actual_position node_address" change=acceleration_time=70 ;;
        c630s) names="actual_speed feedback_pulses max_speed" change=max_speed=3000 ;;
        esac
        # shellcheck disable=SC2086
        both "reads" 0 read $drive $names
        both "writes" 0 write $drive $change
        both "a register that is refused" 1 read raw 0x7777
        if [ "$scheme" = tcp ]; then
            both "no response of another node" 1 read $drive:9 "${names%% *}" --timeout 200 --retries 0
        else
            gateway_run mbap gateway read $drive:9 "${names%% *}" --retries 0
            check "$scheme, $drive: the gateway says that another node does not respond" 1 \
                "$(grep -c 'exception 11' "$work/gateway.complained")"
        fi
        rm -f "$work/direct.txt" "$work/gateway.txt"
        run direct backup "$work/drive" $drive "$work/direct.txt"
        gateway_run "$scheme" gateway backup $drive "$work/gateway.txt"
        check "$scheme, $drive: backs up the same parameters" "1 $(cat "$work/direct.txt")" \
            "$(grep -c '^crc16=' "$work/gateway.txt") $(cat "$work/gateway.txt")"
        both "restores what differs not" 0 restore $drive "$work/direct.txt" --dry-run
        gateway_run "$scheme" gateway watch $drive "${names%% *}" --count 3 --interval 0
        check "$scheme, $drive: watches" 3 "$(grep -c "${names%% *}=" "$work/gateway.said")"
        gateway_run "$scheme" gateway scan --nodes 1-2
        check "$scheme, $drive: finds the drive" "- - 1 ${drive%%-*}" "$(cat "$work/gateway.said")"
        ended sim
    done
}

against_modbus_tcp() {
    build libmodbus_tcp_server -lmodbus || return
    echo "# libmodbus' server of Modbus TCP"
    begin tcp_server "$work/libmodbus_tcp_server"
    port=$(first_line_of tcp_server) || { not_ok "libmodbus' server does not start"; return; }
    url=mbap://127.0.0.1:$port
    check "reads" "0x0010=16 (0x0010) 0x0011=17 (0x0011)" "$("$tool" read "$url" raw:1 0x0010:2 | tr '\n' ' ' | sed 's/ $//')"
    check "reads the most that a frame holds" 125 "$("$tool" read "$url" raw:1 0x0000:125 | wc -l)"
    check "writes one register" "0x0020=7 (0x0007)" "$("$tool" write "$url" raw:1 0x0020=7 --yes 2>/dev/null)"
    "$tool" write "$url" raw:1 0x0030:3=1,2,3 --yes >/dev/null 2>&1
    check "writes several registers in a frame" "1 2 3 " \
        "$("$tool" read "$url" raw:1 0x0030:3 | sed 's/^[^=]*=\([0-9]*\) .*/\1/' | tr '\n' ' ')"
    fails "an exception reaches the caller" 1 "exception 2" read "$url" raw:1 0x2000
    fails "no response of another node" 1 "no response" read "$url" raw:9 0x0000 --timeout 100 --retries 0
    # The response to the first try arrives while the second one is awaited, and is not taken for it.
    check "G2: a late response is dropped by its number" "0x01F4=502 (0x01F6)" \
        "$("$tool" read "$url" raw:1 0x01F4 --timeout 1000 --retries 3)"
    fails "a connection that is closed instead of a response" 1 "port" read "$url" raw:1 0x01F5 --retries 0
    fails "a connection that is lost in the middle of a response" 1 "port" read "$url" raw:1 0x01F6 --retries 0
    run watch watch "$url" raw:1 0x0001 0x01F6 --count 5 --interval 0
    check "watch ends where the connection is lost" 1 "$(cat "$work/watch.status")"
    ended tcp_server
}

bad_names() {
    echo "# names that are no port, and hosts that are not there"
    fails "no host" 2 "the host is missing" read tcp://:4001 zlac8015d bus_voltage
    fails "no port" 2 "the port is missing" read tcp://127.0.0.1 zlac8015d bus_voltage
    fails "a port that is none" 2 "a number from 1 to 65535" read tcp://127.0.0.1:0 zlac8015d bus_voltage
    fails "a port that is a word" 2 "a number from 1 to 65535" read mbap://127.0.0.1:http zlac8015d bus_voltage
    fails "IPv6 without brackets" 2 "brackets" read mbap://::1:502 zlac8015d bus_voltage
    fails "a bracket that does not end" 2 "']' is missing" read mbap://[::1 zlac8015d bus_voltage
    fails "a name that does not resolve" 1 "cannot open mbap://no.such.host.invalid" read mbap://no.such.host.invalid zlac8015d bus_voltage
    fails "a host that refuses" 1 "refused" read tcp://127.0.0.1:1 zlac8015d bus_voltage
    fails "a port that is a folder" 1 "cannot open" read "$work" zlac8015d bus_voltage
    fails "rates of a gateway" 2 "the gateway sets" scan mbap://127.0.0.1:1 --baud 9600
    fails "a format of a gateway" 2 "the gateway sets" read tcp://127.0.0.1:1 zlac8015d bus_voltage --format 8N1
    # No program accepts, and the queue of connections is full: the system does not answer any more.
    begin full_queue python3 -c '
import socket, time
s = socket.socket(); s.bind(("127.0.0.1", 0)); s.listen(0)
held = []
for _ in range(8):
    c = socket.socket(); c.setblocking(False); c.connect_ex(s.getsockname()); held.append(c)
time.sleep(0.2); print(s.getsockname()[1], flush=True); time.sleep(600)'
    fails "a host that never answers the connect" 1 "does not answer" read "tcp://127.0.0.1:$(first_line_of full_queue)" zlac8015d bus_voltage
    ended full_queue
    begin six socat -d -d "TCP6-LISTEN:0,bind=[::1],reuseaddr,fork" "SYSTEM:cat"
    if port=$(port_of_socat six) && [ -n "$port" ]; then
        # It returns each request: no register has that value.
        fails "G3: IPv6, and a gateway that returns requests only" 1 "what came is the request's own echo" read "tcp://[::1]:$port" zlac8015d bus_voltage --retries 0
    else
        skip 1 "this machine has no IPv6"
    fi
    ended six
}

# A network that is late and loses nothing.
late_network() {
    echo "# a network that is late for longer than any limit, and loses nothing"
    begin sim "$tool" sim zlac8015d --link "$work/drive"
    until_there sim "$work/drive" || return
    begin late python3 -B tests/interop/stalling_gateway.py "$work/drive" 7 1.6
    url=tcp://127.0.0.1:$(first_line_of late)
    run late watch "$url" zlac8015d bus_voltage left_max_current host_timeout --count 40 --interval 0
    tr ' ' '\n' <"$work/late.said" | sed -n 's/,$//; s/^\([a-z_]*=[0-9.]*\)$/\1/p' | sort | uniq -c | sed 's/^ *//' >"$work/late.values"
    check "G2: a late response is not taken for the next one" "bus_voltage=24.00 host_timeout=1000 left_max_current=30.0" \
        "$(sed 's/^[0-9]* //' "$work/late.values" | tr '\n' ' ' | sed 's/ $//')"
    check "G2: after it the values go on" 1 \
        "$(tail -n 1 "$work/late.said" | grep -c 'bus_voltage=24.00 V, left_max_current=30.0 A, host_timeout=1000 ms')"
    ended late

    begin later python3 -B tests/interop/stalling_gateway.py "$work/drive" 0 3
    url=tcp://127.0.0.1:$(first_line_of later)
    run late write "$url" zlac8015d left_acceleration_time=777 --timeout 200
    check "a write without a response is unknown" "1 1" "$(cat "$work/late.status") $(grep -c unknown "$work/late.complained")"
    sleep 3.5
    check "and is not carried out any more" "" "$(sed 1d "$work/later.out")"
    ended later
    ended sim
}

over_ethernet() {
    behind_gateways tcp
    behind_gateways mbap
    against_modbus_tcp
    late_network
    bad_names
}
