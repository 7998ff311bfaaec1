#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Windows: every header but posix/ by mingw, alone and after <windows.h>; then windows/serial.hpp, an example program and
# the command-line tool on wine, whose COM ports are pseudo-terminals of this machine. Installs missing packages (Debian,
# Ubuntu).
#   sh tests/windows.sh [headers] [port] [interrupt] [tool]     these parts only
#   JOBS       compilers at a time, 2 if not given
#   SERVOBUS   the tool of this machine; it is built if not given
#
# Wine cannot show: the removal of a real adapter, RTS and the parity of a real UART, the echo of a real bus, two
# programs on one port (a file stands for it), Ctrl-Break and the end of a console.
set -u
cd "$(dirname "$0")/.." || exit 1
[ $# -gt 0 ] || set -- headers port interrupt tool
root=$(pwd)

. tests/support/install.sh
command -v x86_64-w64-mingw32-g++ >/dev/null 2>&1 || install g++-mingw-w64-x86-64 || exit 1
command -v g++ >/dev/null 2>&1 || install g++ || exit 1
for program in wine wineserver socat python3; do
    command -v $program >/dev/null 2>&1 || { install wine64 wine socat python3 || exit 1; }
done

work=$(mktemp -d)
begun=""
export WINEPREFIX="$work/wine" WINEDEBUG=-all WINEDLLOVERRIDES="mscoree=;mshtml="
finish() {
    for one in $begun; do kill "$one" 2>/dev/null; done
    [ ! -d "$WINEPREFIX" ] || wineserver -k >/dev/null 2>&1
    rm -rf "$work"
}
trap finish EXIT
trap 'exit 2' INT TERM
checks=0
failed=0

check() { # NAME EXPECTED FOUND
    checks=$((checks + 1))
    if [ "$2" = "$3" ]; then
        echo "ok      $1"
    else
        echo "FAILED  $1: expected '$2', found '$3'"
        failed=$((failed + 1))
    fi
}
begin() { # COMMAND...: in the background, until the end; $last is its id
    "$@" >>"$work/begun.out" 2>&1 &
    last=$!
    begun="$begun $last"
}
until_true() { # COMMAND...: tries for a minute
    tries=0
    until "$@"; do
        tries=$((tries + 1))
        [ "$tries" -lt 600 ] || return 1
        sleep 0.1
    done
}

warnings="-Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wold-style-cast -Wshadow -Werror"
strict="-std=c++20 $warnings -Iinclude"
bare="$strict -fno-exceptions -fno-rtti"
windows_g="x86_64-w64-mingw32-g++"

built() { # NAME COMMAND...
    name=$1
    shift
    "$@" >"$work/log" 2>&1
    check "$name" 0 $?
    grep -m 5 -E 'FAILED|error|undefined' "$work/log"
}

public_headers() { find include/servobus -name '*.hpp' ! -path '*/posix/*' | sort | sed 's|^include/||'; }
headers() { find include/servobus -name '*.hpp' ! -path '*/posix/*' | sort | sed 's|^include/||'; }
# Compiles each header alone; prints those that do not compile.
each_header() {
    public_headers |
        xargs -P "${JOBS:-2}" -I{} sh -c 'header=$1; shift
            printf "#include <%s>\n" "$header" | "$@" -x c++ -fsyntax-only - >/dev/null 2>&1 || echo "$header"' \
            header {} $windows_g $bare
}
headers() {
    built "mingw: every header but posix/ compiles alone" python3 -B tests/headers.py --without posix $windows_g $bare
    # All of them in one file, since what its macros break does not depend on the others.
    echo '#include <windows.h>' >"$work/before.hpp"
    public_headers | sed 's|.*|#include <&>|' >"$work/all.cpp"
    built "mingw: every header but posix/ compiles after <windows.h>" \
        $windows_g $bare -include "$work/before.hpp" -fsyntax-only "$work/all.cpp"
    # Checks that the macros are defined, since otherwise the check above proves nothing.
    printf 'int near = 1;\n' | $windows_g $bare -include "$work/before.hpp" -x c++ -fsyntax-only - 2>"$work/log"
    check "mingw: a variable called near does not compile after <windows.h>" 1 $?
    built "mingw: after windows/serial.hpp there are winsock2.h and std::min, and no macro of ours" sh -c "
        printf '%s\n' '#include <servobus/windows/serial.hpp>' '#include <winsock2.h>' '#include <algorithm>' \
            '#if defined WIN32_LEAN_AND_MEAN || defined SERVOBUS_DEFINED_LEAN || defined SERVOBUS_DEFINED_NOMINMAX' \
            '#error a macro was left' '#endif' \
            'int least(int a, int b) { return std::min(a, b); }' | $windows_g $bare -x c++ -fsyntax-only -"
    for header in clock serial tcp mbap; do
        built "mingw: the example in windows/$header.hpp compiles" sh -c "
            { printf '#include <servobus/servobus.hpp>\n#include <servobus/windows/$header.hpp>\nint example() {\n'
              sed -n 's|^//     ||p' include/servobus/windows/$header.hpp
              printf 'return 0;\n}\n'; } | $windows_g $bare -Wno-unused -x c++ -fsyntax-only -"
    done
    for program in stepper servo; do
        built "mingw: the example $program compiles" $windows_g $strict -fsyntax-only examples/$program/main.cpp
    done
}

wine_begins() {
    [ ! -d "$WINEPREFIX" ] || return 0
    mkdir "$WINEPREFIX"
    # It lists all that it has, on its standard error, when a terminal that it has opened hangs up.
    wineserver -p 2>"$work/wineserver"
    timeout 300 wineboot -i >"$work/wineboot" 2>&1
    check "wine begins" 0 $?
    if [ -n "${SERVOBUS:-}" ]; then
        cp "$SERVOBUS" "$work/servobus"
    else
        built "the tool" g++ -std=c++20 -O1 -Iinclude examples/servobus/*.cpp examples/servobus/*/*.cpp -o "$work/servobus"
    fi
    begin "$work/servobus" sim zlac8015d --link "$work/drive"
    until_true test -e "$work/drive" || check "the simulated drive is there" yes no
    ln -s "$work/peer_line" "$WINEPREFIX/dosdevices/com12"
    ln -s "$work/drive" "$WINEPREFIX/dosdevices/com3"
    ln -s "$work/drive" "$WINEPREFIX/dosdevices/com15"
    ln -s "$work/tapped" "$WINEPREFIX/dosdevices/com14"
}
in_wine() { # FILE PROGRAM ARGUMENT...: its output goes to FILE
    file=$1
    shift
    timeout 180 wine "$@" 2>"$file.err" | tr -d '\r' >"$file"
}
# Counts the checks that a program of these tests prints.
counted() { # NAME FILE COUNT
    cat "$2"
    checks=$((checks + $(grep -cE '^(ok|FAILED) ' "$2")))
    failed=$((failed + $(grep -c '^FAILED ' "$2")))
    check "$1: the program has made all its checks" "$3" "$(grep -cE '^(ok|FAILED) ' "$2")"
}
port() {
    wine_begins
    built "mingw: the port's test" $windows_g $bare -O1 -static tests/windows/port.cpp -o "$work/port.exe"
    built "the peer" g++ $strict -O1 tests/windows/peer.cpp -o "$work/peer"
    begin "$work/peer" "$work/peer_line"
    until_true test -e "$work/peer_line" || check "the peer is there" yes no
    in_wine "$work/bytes" "$work/port.exe" bytes COM12
    counted "bytes on COM12" "$work/bytes" 71
    in_wine "$work/drives" "$work/port.exe" drive COM3
    counted "a drive on COM3" "$work/drives" 9
    in_wine "$work/look" "$work/port.exe" look '\\.\COM3'
    check 'a drive on COM3, named with its prefix' "ok      it responds" "$(cat "$work/look")"
}

tap() { # begins to record the frames between the program and the drive
    : >"$work/frames"
    rm -f "$work/tapped"
    socat -x "pty,raw,echo=0,link=$work/tapped" "$work/drive,raw,echo=0" 2>"$work/frames" &
    tapping=$!
    begun="$begun $tapping"
    until_true test -e "$work/tapped"
}
no_tap() {
    kill "$tapping"
    wait "$tapping" 2>/dev/null
}
# What the program wrote last to the drive: of the frames to it, the last write.
last_write() { grep -A 1 '^>' "$work/frames" | grep -E '^ 01 (06|10) ' | tail -n 1; }
stopped() { # NAME STATUS
    check "S8: $1 ends the program with an error" 1 "$2"
    no_tap
    check "S8: $1: it has said so" 1 "$(tr -d '\r' <"$work/out" | grep -c 'wheels: *interrupted')"
    check "S8: $1: the wheels did turn" 1 "$(grep -c '^ 01 10 20 88 00 02 04 00 14 ff ec' "$work/frames")"
    check "S8: $1: the last write is the stop, 07h to 200Eh" " 01 06 20 0e 00 07 a2 0b" "$(last_write)"
    check "S8: $1: the wheels stand and are released" \
        "status_word=left_released+right_released (0x0000) left_actual_speed=0.0 r/min right_actual_speed=0.0 r/min" \
        "$("$work/servobus" read "$work/drive" zlac8015d status_word left_actual_speed right_actual_speed | tr '\n' ' ' |
            sed 's/ $//')"
}
turning() { grep -q 'turning' "$work/out" && [ "$(sed -n '/turning/,$p' "$work/out" | grep -c left)" -gt 0 ]; }

interrupt() {
    wine_begins
    built "mingw: the example wheels" $windows_g $strict -O1 -static examples/wheels/main.cpp -o "$work/wheels.exe"
    built "mingw: what interrupts it" $windows_g $bare -O1 -static tests/windows/interrupt.cpp -o "$work/interrupt.exe"
    echo no | in_wine "$work/out" "$work/wheels.exe" COM3
    check "S8: without the typed consent nothing is sent" 1 "$(grep -c 'Nothing was sent' "$work/out")"

    tap
    timeout 200 python3 tests/windows/terminal.py wine "$work/wheels.exe" COM14 >"$work/out" 2>&1
    stopped "Ctrl-C on a terminal" $?

    tap
    : >"$work/out"
    mkfifo "$work/keys"
    (cd "$work" && exec timeout 180 wine interrupt.exe turn wheels.exe COM14) <"$work/keys" >"$work/out" 2>&1 &
    program=$!
    echo MOVE >"$work/keys"
    until_true turning || check "the wheels turn" yes no
    : >"$work/turn"
    wait "$program"
    stopped "a Ctrl-C of the console" $?
}

. tests/windows/tool.sh

for part in "$@"; do
    case $part in
    headers | port | interrupt | tool) echo "# $part"; $part ;;
    *) echo "windows.sh: there is no part $part"; exit 2 ;;
    esac
done
echo "windows.sh: $checks checks, $failed failed"
[ "$failed" = 0 ]
