# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Builds a program for a Cortex-M and counts each instruction that it executes in its job in qemu. run.sh,
# operations.sh, server.sh and axis.sh source this file. It works in $work, which is removed at the end.
missing=""
command -v arm-none-eabi-g++ >/dev/null 2>&1 ||
    missing="gcc-arm-none-eabi libnewlib-arm-none-eabi libstdc++-arm-none-eabi-newlib"
command -v qemu-system-arm >/dev/null 2>&1 || missing="$missing qemu-system-arm"
if [ -n "$missing" ]; then
    . tests/support/install.sh
    # shellcheck disable=SC2086
    must_install $missing
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
here=tests/target
strict="-Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wold-style-cast -Wshadow -Werror"

# The first line of a file of recorded figures names the compiler that they are of.
compiler="arm-none-eabi-g++ $(arm-none-eabi-g++ -dumpfullversion)"
# is_as_recorded FIGURES RECORDED FILE: sets `is_recorded` to 1 if the figures are the recorded ones, else to 0, and
# `tolerance` to what may differ: nothing with the compiler that FILE names, 3 % with another.
is_as_recorded() {
    slack=3
    ! head -n 1 "$3" | grep -qxF "# $compiler" || slack=0
    tolerance="exactly, with $compiler"
    [ "$slack" = 0 ] || tolerance="within $slack %, since $compiler is not the recorded compiler"
    is_recorded=1
    echo "$1 $2" | awk -v slack="$slack" '{
        if (NF == 0 || NF % 2) exit 1
        for (i = 1; 2 * i <= NF; ++i) {
            old = $(i + NF / 2)
            if (100 * $i > (100 + slack) * old || 100 * $i < (100 - slack) * old) exit 1
        }
    }' || is_recorded=0
}

compile() { # NAME OBJECT CORE FLAGS...
    text=$1 object=$2 core=$3
    shift 3
    # shellcheck disable=SC2086
    arm-none-eabi-g++ -std=c++20 -Os -mcpu="$core" -mthumb -ffreestanding -fno-exceptions -fno-rtti \
        -fno-unwind-tables -fno-asynchronous-unwind-tables -ffunction-sections -fdata-sections $strict -Wno-psabi "$@" \
        -Iinclude -c "$here/$text.cpp" -o "$object"
}
build() { # PROGRAM CORE FLAGS...: builds $work/program.elf. The board and its drive are compiled once for each choice of flags.
    program=$1 core=$2
    shift 2
    beside="$work/$(echo "$core$*" | tr -c 'a-z0-9A-Z\n' _)"
    compile "$program" "$work/program.o" "$core" "$@" || return 1
    for part in board drive; do
        [ -e "$beside.$part.o" ] || compile "$part" "$beside.$part.o" "$core" "$@" || return 1
    done
    arm-none-eabi-g++ -mcpu="$core" -mthumb "$work/program.o" "$beside.board.o" "$beside.drive.o" -nostartfiles \
        --specs=nano.specs -Wl,--gc-sections -T "$here/target.ld" -o "$work/program.elf"
}
size_of() { # EXPRESSION: the value of an awk expression of text, data and bss
    arm-none-eabi-size "$work/program.elf" | awk "NR == 2 { print $1 }"
}

run() { # runs the program; writes $work/stack, $work/requests and $work/addresses, one for each instruction
    qemu-system-arm -M mps2-an386 -semihosting-config enable=on,target=native -display none -serial null \
        -singlestep -d exec,nochain -D "$work/log" -kernel "$work/program.elf" 2>"$work/printed" </dev/null || return 1
    sed -n 's/^0*\([0-9]\)/\1/;1p' "$work/printed" >"$work/stack"
    sed -n 's/^0*\([0-9]\)/\1/;2p' "$work/printed" >"$work/requests"
    arm-none-eabi-nm -S --defined-only "$work/program.elf" | awk 'NF == 4 { print $1, $2, $4 }' >"$work/symbols"
    awk -F/ '/^Trace/ { print $2 }' "$work/log" >"$work/addresses"
}
# Functions outside the library: those of the simulated drive, which are never counted, and the four of the user.
drive='^(simulated_drive|_ZN15simulated_drive)'
drive_and_callbacks='^(uart_|clock_us|simulated_drive|_ZN15simulated_drive)'
callbacks_size() { # bytes of the four functions of the user
    arm-none-eabi-nm -S --defined-only "$work/program.elf" |
        awk "$number"' $4 ~ /^(uart_|clock_us)/ { bytes += number($2) } END { print bytes + 0 }'
}
# An awk function: the number of hexadecimal digits.
number='function number(hex,   n, i) {
    n = 0
    for (i = 1; i <= length(hex); ++i) n = 16 * n + index("0123456789abcdef", substr(hex, i, 1)) - 1
    return n
}'
# The instructions of the measured job without those of functions whose names match a pattern.
instructions() { # PATTERN
    awk -v others="$1" "$number"'
         FNR == NR {
             at = number($1); at -= at % 2
             if ($3 == "measured_job_begins") begin = at
             if ($3 == "measured_job_ends") end = at
             if ($3 ~ others) for (i = 0; i < number($2); i += 2) is_other[at + i] = 1
             next
         }
         { pc = number($1) }
         pc == begin { counts = 1 }
         pc == end { counts = 0 }
         counts && !(pc in is_other) { ++n }
         END { print n - 4 }' "$work/symbols" "$work/addresses" # without the marks and the calls of them
}
