# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# The command-line tool of Windows on wine beside the one of this machine, both at the simulated drive of windows.sh:
# the same output, errors and status. Read by windows.sh.

# run AS TOOL ARGUMENT...: its output, errors and status. PORT among the arguments is the drive's port. The clock in
# the output becomes T.
run() {
    as=$1 port=$work/drive
    [ "$2" = linux ] || port=COM15
    which=$2
    shift 2
    left=$#
    while [ "$left" -gt 0 ]; do
        word=$1
        [ "$word" != PORT ] || word=$port
        shift
        set -- "$@" "$word"
        left=$((left - 1))
    done
    if [ "$which" = linux ]; then
        timeout 60 "$work/servobus" "$@" <"${input:-/dev/null}" >"$work/$as.said" 2>"$work/$as.complained"
    else
        timeout 60 sh tests/windows/on_wine.sh "$@" <"${input:-/dev/null}" >"$work/$as.said" 2>"$work/$as.complained"
    fi
    echo $? >"$work/$as.status"
    sed -i "s|$port|PORT|g; s|^[0-9]*\.[0-9]\{3\} |T |; s|[-0-9]\{10\}T[0-9:.]\{12\}Z|T|; s|T,\([^,]*\),[0-9]\{13\}|T,\1,T|; s|\"unix_ms\":[0-9]*|T|" \
        "$work/$as.said" "$work/$as.complained"
}
differs() { # NAME KIND A B
    checks=$((checks + 1))
    failed=$((failed + 1))
    echo "FAILED  $1: $2"
    diff "$3" "$4" | head -n 5
}
# Each call of a port passes through wine's server. On a busy machine a request and its response may both have passed
# before the tool sees that the request has left. Then the line discards the response, since it cannot tell it from an
# echo (G3), and the tool says: no response. So what ends with these words is tried three times.
alike() { # NAME STATUS ARGUMENT...: both say the same, and end with this status
    name="the tool: $1" expected=$2
    shift 2
    run linux linux "$@"
    for attempt in 1 2 3; do
        run windows windows "$@"
        grep -q 'no response' "$work/windows.complained" || break
        ! grep -q 'no response' "$work/linux.complained" || break
        echo "$name: no response, attempt $attempt" >>"$SERVOBUS_EXE.again"
    done
    for kind in said complained; do
        cmp -s "$work/linux.$kind" "$work/windows.$kind" && continue
        differs "$name" $kind "$work/linux.$kind" "$work/windows.$kind"
        return
    done
    check "$name" "$expected $expected" "$(cat "$work/linux.status") $(cat "$work/windows.status")"
}
typed() { # TEXT: what the next commands read
    input=$work/typed
    printf '%s' "$1" >"$input"
}

commands() {
    alike "--help" 0 --help
    alike "--version" 0 --version
    alike "map" 0 map c630s
    alike "alarms" 0 alarms c630s
    typed '> 01 03 20 A1 00 01 DE 28
< 01 03 02 09 60 BE 3C

01 06 20 0E 00 08 E2 0F
# a comment
01 06 20 0E 00 08 E2 0E
no frame
'
    alike "explain: requests, responses, a bad CRC" 1 explain zlac8015d
    alike "explain --hex" 1 explain zlac8015d --hex
    input=""
    alike "read" 0 read PORT zlac8015d bus_voltage 0x20A9 left_actual_position left_faults status_word host_timeout
    alike "read --csv" 0 read PORT zlac8015d bus_voltage left_actual_position motor_temperature --csv
    alike "read --json" 0 read PORT zlac8015d bus_voltage left_actual_position motor_temperature --json
    alike "read: no such register" 2 read PORT zlac8015d bus_volt
    alike "read: no such option" 2 read PORT zlac8015d bus_voltage --bauds 9600
    alike "read: no response" 1 read PORT zlac8015d:9 bus_voltage
    alike "read: an exception" 1 read PORT raw 0x3000 --baud 115200
    alike "read: no such port" 1 read COM77 zlac8015d bus_voltage
    alike "write" 0 write PORT zlac8015d left_max_current=12.5 right_max_current=11
    alike "write: a value outside the range" 2 write PORT zlac8015d left_max_current=1000
    alike "write: no consent" 1 write PORT zlac8015d control_word=enable
    typed "write$(printf '\r\n.')"
    alike "write: typed consent" 0 write PORT zlac8015d control_word=enable
    input=""
    alike "write: a stop needs none" 0 write PORT zlac8015d control_word=stop
    alike "watch" 0 watch PORT zlac8015d bus_voltage host_timeout --count 3 --interval 20
    alike "watch --csv" 0 watch PORT zlac8015d bus_voltage left_actual_position --count 3 --interval 20 --csv
    alike "watch --json" 0 watch PORT zlac8015d bus_voltage left_actual_position --count 3 --interval 20 --json
    # Wine's port has rates and formats. That of Linux is a pseudo-terminal, which has none, and is scanned once.
    run windows windows scan PORT --baud 115200 --format 8N1,8N2 --nodes 1-3 --timeout 500
    check "the tool: scan" "0 115200 8N1 1 zlac8015d 115200 8N2 1 zlac8015d" \
        "$(cat "$work/windows.status") $(tr '\n' ' ' <"$work/windows.said" | sed 's/ *$//')"
    alike "scan: no device responds" 1 scan PORT --baud 115200 --format 8N1 --nodes 2-3 --timeout 500
    alike "backup to standard output" 0 backup PORT zlac8015d
    run windows windows read "$work" zlac8015d bus_voltage
    check "the tool: a port that is a folder" "1 1" \
        "$(cat "$work/windows.status") $(grep -c "^servobus: cannot open $work: " "$work/windows.complained")"
}

files() {
    run linux linux backup PORT zlac8015d "$work/by_linux"
    run windows windows backup PORT zlac8015d "$work/by_windows"
    check "the tool: backup into a file" "0 0" "$(cat "$work/linux.status") $(cat "$work/windows.status")"
    check "the tool: both files are byte for byte the same" "" "$(cmp "$work/by_linux" "$work/by_windows" 2>&1)"
    check "the tool: it has all parameters" 1 "$([ "$(wc -l <"$work/by_windows")" -gt 80 ] && echo 1)"
    run windows windows backup PORT zlac8015d "$work/by_windows"
    check "the tool: a file that exists is replaced" "0" "$(cat "$work/windows.status")$(cmp "$work/by_linux" "$work/by_windows" 2>&1)"
    check "the tool: no draft is left" 0 "$(find "$work" -maxdepth 1 -name '*.part' | wc -l)"

    for pair in "linux by_windows" "windows by_linux"; do
        # shellcheck disable=SC2086
        set -- $pair
        run linux linux write PORT zlac8015d left_max_current=10 right_max_current=9
        alike "restore --dry-run of $2" 0 restore PORT zlac8015d "$work/$2" --dry-run
        run restored "$1" restore PORT zlac8015d "$work/$2" --yes
        check "the tool: $1 restores $2" "0 left_max_current=12.5 A right_max_current=11.0 A" \
            "$(cat "$work/restored.status") $(tr '\n' ' ' <"$work/restored.said" | sed 's/ $//')"
    done
    sed 's/$/\r/' "$work/by_linux" >"$work/changed"
    alike "restore refuses changed line ends" 2 restore PORT zlac8015d "$work/changed" --yes

    alike "backup: a folder" 1 backup PORT zlac8015d "$work"
    alike "backup: FILE is the port" 2 backup PORT zlac8015d PORT
    alike "backup: in a folder that does not exist" 1 backup PORT zlac8015d "$work/none/file"
    run windows windows backup PORT zlac8015d NUL
    check "the tool: backup into NUL" 0 "$(cat "$work/windows.status")"
    for pair in 'COM3 \\.\COM3' '\\.\COM3 com3'; do
        # shellcheck disable=SC2086
        set -- $pair
        run windows windows backup "$1" zlac8015d "$2"
        check "the tool: backup from $1 into $2" "2 servobus: $2 is the port" \
            "$(cat "$work/windows.status") $(cat "$work/windows.complained")"
    done

    rm -f "$work/log"
    run linux linux watch PORT zlac8015d bus_voltage --count 2 --interval 20 --log "$work/log"
    run windows windows watch PORT zlac8015d bus_voltage --count 2 --interval 20 --log "$work/log"
    check "the tool: --log appends to what Linux began" "0 5" "$(cat "$work/windows.status") $(wc -l <"$work/log")"
    check "the tool: with no other line ends" 0 "$(grep -c "$(printf '\r')" "$work/log")"
    alike "--log: other columns" 2 read PORT zlac8015d status_word --log "$work/log"
    alike "--log: a folder" 1 read PORT zlac8015d status_word --log "$work"
    printf 'half a line' >"$work/half"
    alike "--log: a line without an end" 2 read PORT zlac8015d status_word --log "$work/half"
    for name in COM3 '\\.\COM12' NUL; do
        run windows windows read PORT zlac8015d status_word --log "$name"
        check "the tool: --log into $name" "1 servobus: cannot write $name: it is no regular file" \
            "$(cat "$work/windows.status") $(cat "$work/windows.complained")"
    done
    run windows windows read PORT zlac8015d:9 status_word --log "$work/new"
    check "the tool: a row that says so is kept" 2 "$(wc -l <"$work/new")"
    run windows windows read COM77 zlac8015d status_word --log "$work/none"
    check "the tool: a log without a row is removed" no "$(test -e "$work/none" && echo yes || echo no)"
    wine "$work/servobus.exe" sim zlac8015d >"$work/windows.said" 2>"$work/windows.complained"
    echo $? >"$work/windows.status"
    check "the tool: sim is refused" \
        "1 servobus: a simulated drive needs a pseudo-terminal, which Windows does not have" \
        "$(cat "$work/windows.status") $(cat "$work/windows.complained")"
}

# Over gateways of this machine: socat, and the one of the tests for Modbus TCP.
through_gateway() { # SCHEME
    rm -f "$work/gateway"
    case $1 in
    tcp) socat -d -d TCP-LISTEN:0,bind=127.0.0.1,reuseaddr "OPEN:$work/drive,raw,echo=0" 2>"$work/gateway" & ;;
    mbap) python3 -B tests/interop/mbap_gateway.py "$work/drive" >"$work/gateway" 2>&1 & ;;
    esac
    gateway=$!
    begun="$begun $gateway"
    until_true grep -qs '[0-9]$' "$work/gateway" || check "the gateway is there" yes no
    at=$(sed -n 's/.*listening on .*:\([0-9]*\)$/\1/p; s/^\([0-9]*\)$/\1/p' "$work/gateway" | head -n 1)
    run windows windows read "$1://127.0.0.1:$at" zlac8015d bus_voltage left_max_current
    check "the tool: read over $1" "0 bus_voltage=24.00 V left_max_current=12.5 A" \
        "$(cat "$work/windows.status") $(tr '\n' ' ' <"$work/windows.said" | sed 's/ $//')"
    kill "$gateway" 2>/dev/null
    wait "$gateway" 2>/dev/null
}
network() {
    through_gateway tcp
    through_gateway mbap
    alike "tcp: nobody listens" 1 read tcp://127.0.0.1:9 zlac8015d bus_voltage
    alike "mbap: an address without a host" 2 read mbap://:502 zlac8015d bus_voltage
    run windows windows read tcp://no-such-host.invalid:4001 zlac8015d bus_voltage
    check "the tool: a host name that does not resolve" "1 1" \
        "$(cat "$work/windows.status") $(grep -c '^servobus: cannot open tcp://no-such-host.invalid:4001: ' "$work/windows.complained")"
    # A gateway that ends in the middle of a response.
    printf '\001\003\002' >"$work/part"
    rm -f "$work/gateway"
    socat -d -d TCP-LISTEN:0,bind=127.0.0.1 "SYSTEM:head -c 8 >/dev/null; cat $work/part" 2>"$work/gateway" &
    begun="$begun $!"
    until_true grep -qs 'listening on' "$work/gateway"
    at=$(sed -n 's/.*listening on .*:\([0-9]*\)$/\1/p' "$work/gateway" | head -n 1)
    run windows windows read "tcp://127.0.0.1:$at" zlac8015d bus_voltage --retries 0
    check "the tool: a connection lost in a response" "1 1" \
        "$(cat "$work/windows.status") $(grep -c 'bus_voltage: the port is gone: ' "$work/windows.complained")"
}

endings() {
    wine "$work/servobus.exe" watch COM15 zlac8015d bus_voltage --interval 20 --log "$work/shared" >"$work/watch" 2>&1 &
    watcher=$!
    begun="$begun $watcher"
    until_true test -s "$work/shared" || check "watch goes on" yes no
    run windows windows read COM3 zlac8015d bus_voltage --log "$work/shared"
    check "the tool: a log has one writer" "1 servobus: cannot write $work/shared: another program has it open" \
        "$(cat "$work/windows.status") $(cat "$work/windows.complained")"
    kill -INT "$watcher"
    wait "$watcher"
    check "the tool: Ctrl-C ends watch with status 0" 0 $?
    check "the tool: its last line is whole" "" "$(tail -c 1 "$work/watch" | tr -d '\n')"

    "$work/servobus" sim zlac8015d --link "$work/pulled" >"$work/pulled.sim" 2>&1 &
    pulled=$!
    begun="$begun $pulled"
    until_true test -e "$work/pulled"
    ln -sfn "$work/pulled" "$WINEPREFIX/dosdevices/com13"
    wine "$work/servobus.exe" watch COM13 zlac8015d bus_voltage --interval 20 >"$work/pulled.said" 2>"$work/pulled.err" &
    watcher=$!
    begun="$begun $watcher"
    until_true grep -qs bus_voltage "$work/pulled.said"
    kill "$pulled"
    wait "$watcher"
    check "the tool: a port that is pulled ends watch with status 1" 1 $?
    check "the tool: and it says so" "servobus: the port is gone" "$(tail -n 1 "$work/pulled.err" | cut -d : -f 1,2)"
}

tool() {
    wine_begins
    export SERVOBUS="$work/servobus" SERVOBUS_EXE="$work/servobus.exe" ON_WINE=1
    set -- examples/servobus/*.cpp examples/servobus/*/*.cpp
    mkdir -p "$work/exe"
    for source in "$@"; do echo "$source $work/exe/$(basename "$source").o"; done |
        xargs -P "${JOBS:-2}" -L 1 sh -c "$windows_g $strict -O1 -c \$0 -o \$1 || exit 255" >"$work/log" 2>&1
    built "mingw: the tool" $windows_g -static "$work"/exe/*.o -lws2_32 -o "$work/servobus.exe"
    grep -m 5 error "$work/log"
    check "it needs no library but those of Windows" "KERNEL32.dll WS2_32.dll msvcrt.dll" \
        "$(x86_64-w64-mingw32-objdump -p "$work/servobus.exe" | sed -n 's/.*DLL Name: //p' | sort | tr '\n' ' ' | sed 's/ $//')"
    commands
    files
    network
    endings
    # The parts of its own tests that need nothing of Linux.
    for own in offline zlac8015d devices refused_files parameters listen; do
        for attempt in 1 2 3; do
            sh tests/tool.sh tests/windows/on_wine.sh "$own" >"$work/part" 2>&1
            status=$?
            [ "$status" != 0 ] && grep -aq '^ .*: unknown, no response' "$work/part" || break
            grep -a '^ .*: unknown, no response' "$work/part" | cut -c 1-100 >>"$SERVOBUS_EXE.again"
        done
        check "its own tests on wine: $own" 0 "$status"
        grep -a -A 50 '^FAILED' "$work/part" | cut -c 1-200
        tail -n 1 "$work/part"
    done
    [ ! -e "$SERVOBUS_EXE.again" ] || cat "$SERVOBUS_EXE.again"
}
