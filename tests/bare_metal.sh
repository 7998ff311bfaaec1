#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Runs the firmware of examples/bare_metal in qemu, with its UART connected to a simulated drive.
#   sh tests/bare_metal.sh [TOOL]      TOOL: the built command-line tool; without it, the script builds the tool
# It installs missing packages (Debian, Ubuntu). The firmware has its own, long timeouts. A qemu whose program hangs
# is ended after ten minutes.
set -u
root=$(dirname "$0")/..
tool=${1:-}
work=$(mktemp -d)
simulators=""
trap 'for one in $simulators; do kill "$one" 2>/dev/null; done; rm -rf "$work"' EXIT
trap 'exit 2' INT TERM
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

is_complete() {
    command -v qemu-system-arm >/dev/null && command -v arm-none-eabi-g++ >/dev/null &&
        echo 'int main() {}' | arm-none-eabi-g++ -x c++ -include array --specs=nano.specs --specs=nosys.specs \
            -mcpu=cortex-m3 -mthumb - -o "$work/probe.elf" 2>/dev/null
}
if ! is_complete; then
    packages="gcc-arm-none-eabi libnewlib-arm-none-eabi libstdc++-arm-none-eabi-newlib qemu-system-arm"
    . "$root"/tests/support/install.sh
    # shellcheck disable=SC2086
    must_install $packages
fi
if [ -z "$tool" ]; then
    tool=$work/servobus
    echo "bare_metal.sh: building the command-line tool"
    programs=$root/examples # a variable, since what a script names is what it judges: unless_unchanged.py
    "${CXX:-g++}" -std=c++20 -O1 -I"$root/include" "$programs/servobus.cpp" -o "$tool" || exit 1
fi
CXX=arm-none-eabi-g++ sh "$root/examples/bare_metal/build.sh" "$work"
check "the images are built" 0 $?
[ "$failed" = 0 ] || exit 1

emulate() { # RUN PROGRAM OPTION...: the output of the program goes to RUN.out
    run=$1 program=$2
    shift 2
    timeout 600 qemu-system-arm -M mps2-an385 -display none -monitor none \
        -semihosting-config enable=on,target=native "$@" -kernel "$work/$program.elf" </dev/null >"$work/$run.out" 2>&1
}
says() { # NAME RUN PATTERN: the pattern matches a whole line of the output
    check "$1" "$3" "$(grep -E "^[a-z_]+: $3\$" "$work/$2.out" >/dev/null && echo "$3")"
}
ends_with() { check "$1" "$3" "$(tail -n 1 "$work/$2.out" | sed 's/^[a-z_]*: //')"; }
shown() { # FAILED RUN: prints the output of the program if more checks have failed since
    [ "$1" = "$failed" ] || sed 's/^/        /' "$work/$2.out"
}

# An unwanted symbol costs kilobytes, or calls functions that firmware does not have.
lacks() { # PROGRAM WHAT PATTERN
    check "$1 has no $2" "" "$(grep -E "$3" "$work/$1.symbols" | tr '\n' ' ')"
}
for program in blocking superloop; do
    arm-none-eabi-nm "$work/$program.elf" | sed 's/.* //' >"$work/$program.symbols"
    check "$program's symbols can be read" 2 "$(grep -c -x -e main -e reset "$work/$program.symbols")"
    lacks $program "heap" '^_?_?(malloc|calloc|realloc|free|sbrk)(_r)?$|^_Z(n[wa]|d[la])'
    lacks $program "printf" 'printf|^_?puts'
    lacks $program "exceptions" '^__cxa_|^_Unwind|^__gxx_personality|^__aeabi_unwind|terminate'
    lacks $program "run-time types" '^_ZT[ISV]'
    lacks $program "guards of static objects" '^_ZGV|^__cxa_guard|atexit|^__dso_handle'
    lacks $program "floating point in software" '^__aeabi_(c?[df]|u?[il]2[df]|h2)|^__(add|sub|mul|div|neg|cmp)[sdt]f|^__(un)?(float|fix)'
    lacks $program "64-bit division" '^__aeabi_u?ldivmod|^__(u?div|u?mod|u?divmod)di'
done

simulate() { # NAME OPTION...: starts a simulated drive at $work/NAME
    name=$1
    shift
    "$tool" sim zlac8015d "$@" --link "$work/$name" >"$work/$name.log" 2>&1 &
    simulators="$simulators $!"
    until [ -e "$work/$name" ]; do kill -0 $! || exit 1; sleep 0.05; done
}
drives() { # RUN PROGRAM NAME: runs the program with the drive NAME on its UART 1
    emulate "$1" "$2" -serial null -serial "$(readlink "$work/$3")"
}

# Programs that wait for missing responses run at the same time as the others. With this seed the line loses a frame
# that is not sent again.
simulate unplugged --faults unplugged
begun=""
for program in blocking superloop; do
    drives mute_$program $program unplugged &
    begun="$begun mute_$program:$!"
    simulate lossy_$program --faults lossy --seed 4
    drives lossy_$program $program lossy_$program &
    begun="$begun lossy_$program:$!"
done

# Without a drive the emulator counts instructions instead of time, so every run is the same.
begin=$failed
emulate clock_check clock_check -icount shift=5
check "the clock of microseconds: ends with status 0" 0 $?
ends_with "the clock of microseconds: never goes back nor jumps" clock_check "counts on through every round's end"
shown "$begin" clock_check

simulate drive
read_one() { # with a long timeout, since the host may be busy
    "$tool" read "$work/drive" zlac8015d "$1" --timeout 5000 --retries 5 | cut -d= -f2
}
place() { read_one left_actual_position | cut -d' ' -f1; }
has_turned() { # PLACE: by more than 50 counts since then; a revolution has 4096
    echo $(($(place) - $1 > 50))
}
at_rest() { # PROGRAM: what another program reads from the drive
    check "$1 leaves the drive disabled, nothing runs" "left_released+right_released (0x0000)" "$(read_one status_word)"
    check "$1 leaves the left wheel at rest" "0.0 r/min" "$(read_one left_actual_speed)"
    check "$1 leaves the right wheel at rest" "0.0 r/min" "$(read_one right_actual_speed)"
}
both_speeds='(1[5-9]|20)[0-9] and -(1[5-9]|20)[0-9]'

begin=$failed
before=$(place)
drives blocking blocking drive
check "blocking: ends with status 0" 0 $?
says "blocking: the drive was enabled" blocking 'enable, velocity mode: done'
says "blocking: both wheels were seen to turn" blocking "speeds in 0.1 r/min: $both_speeds"
says "blocking: both wheels were seen to stand" blocking 'speeds in 0.1 r/min: 0 and 0'
says "blocking: the interrupt lost no byte" blocking 'bytes lost 0, stack [0-9]+ bytes'
ends_with "blocking: says that it is done" blocking "both wheels at rest"
check "blocking: the simulated wheel has turned" 1 "$(has_turned "$before")"
at_rest blocking
shown "$begin" blocking

begin=$failed
before=$(place)
drives superloop superloop drive
check "superloop: ends with status 0" 0 $?
says "superloop: the drive was enabled" superloop 'enable, velocity mode: done in [0-9]+ turns'
says "superloop: both wheels were seen to turn" superloop 'both wheels turn: done in [0-9]+ turns'
says "superloop: a bare exchange, fed byte by byte, saw them stand" superloop 'both wheels stand: done in [0-9]+ turns'
says "superloop: no turn waited" superloop '[0-9]+ turns, .* asked the port at most [0-9]+ times: never held up'
says "superloop: the interrupt lost no byte" superloop 'bytes lost 0, stack [0-9]+ bytes'
ends_with "superloop: says that it is done" superloop "both wheels at rest"
check "superloop: the simulated wheel has turned" 1 "$(has_turned "$before")"
at_rest superloop
shown "$begin" superloop

for one in $begun; do
    run=${one%:*}
    wait "${one#*:}"
    status=$?
    begin=$failed
    case $run in
    lossy_*)
        check "$run: ends with status 0 on a line that loses frames" 0 "$status"
        ends_with "$run: begins anew, and says that it is done" "$run" "both wheels at rest"
        ;;
    mute_*)
        check "$run: ends with status 1 where there is no response" 1 "$status"
        says "$run: says so" "$run" 'take over: .*no response.*'
        says "$run: says that the stop is open" "$run" 'the stop was not confirmed'
        ends_with "$run: says that it failed" "$run" "FAILED"
        ;;
    esac
    shown "$begin" "$run"
done

echo "memory in bytes (text: flash; bss: RAM, of which 2048 are the stack) by arm-none-eabi-size:"
(cd "$work" && arm-none-eabi-size blocking.elf superloop.elf)
sed -n 's/: bytes lost.* stack/ used of the stack:/p' "$work/blocking.out" "$work/superloop.out"
echo "bare_metal.sh: $checks checks, $failed failed"
[ "$failed" = 0 ]
