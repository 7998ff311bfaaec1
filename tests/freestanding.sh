#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Targets without an operating system: every header but posix/ and windows/ for ARM with -ffreestanding, the library for
# RISC-V (rv32imc), every header with the macros of an Arduino sketch, and the protocol core on an ATmega328P, built by
# clang and run in simavr. Installs missing packages (Debian, Ubuntu).   sh tests/freestanding.sh
#   INCLUDE   the folder of the library, include if not given
set -u
cd "$(dirname "$0")/.." || exit 1
include=${INCLUDE:-include}

. tests/support/install.sh

command -v g++ >/dev/null 2>&1 || install g++ || exit 1
command -v arm-none-eabi-g++ >/dev/null 2>&1 ||
    install gcc-arm-none-eabi libnewlib-arm-none-eabi libstdc++-arm-none-eabi-newlib || exit 1
command -v clang++ >/dev/null 2>&1 || install clang libc6-dev || exit 1
command -v simavr >/dev/null 2>&1 || install simavr
[ -e /usr/lib/avr/include/avr/io.h ] || install binutils-avr avr-libc gcc-avr
. tests/support/avr.sh

build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
strict="-Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wold-style-cast -Wshadow -Werror"
bare="-std=c++20 $strict -fno-exceptions -fno-rtti -I$include -I."
arm="arm-none-eabi-g++ $bare -mthumb -Os"
checks=0
failed=0
skipped=0

check() { # NAME COMMAND...
    name=$1
    shift
    checks=$((checks + 1))
    if "$@" >"$build/log" 2>&1; then
        echo "ok      $name"
    else
        echo "FAILED  $name"
        grep -E 'error|failed|undefined|passed' "$build/log" | head -n 12
        failed=$((failed + 1))
    fi
}
skip() { # NAME WHY
    echo "skipped $1: $2"
    skipped=$((skipped + 1))
}

headers() { find "$include/servobus" -name '*.hpp' ! -path '*/posix/*' ! -path '*/windows/*' | sort; }

# Compiles each header alone after these lines, and names all headers that do not compile.
each_header() { # LINES COMPILER FLAGS...
    lines=$1
    shift
    headers | while read -r header; do
        printf '%b#include <%s>\n' "$lines" "${header#"$include"/}" | "$@" -x c++ -fsyntax-only -Wno-unused-macros - \
            2>"$build/one" || { echo "error: $header"; grep -m 2 error "$build/one"; }
    done >"$build/wrong"
    cat "$build/wrong"
    [ ! -s "$build/wrong" ]
}
all_headers() { # LINES COMPILER FLAGS...
    lines=$1
    shift
    {
        printf '%b' "$lines"
        headers | sed "s|^$include/\(.*\)|#include <\1>|"
    } | "$@" -x c++ -fsyntax-only -
}

# Here and for AVR one source includes all headers, to save time. With the macros below each header compiles alone.
check "ARM, freestanding: all headers, Cortex-M0+" all_headers "" $arm -mcpu=cortex-m0plus -ffreestanding
check "ARM, freestanding: all headers, Cortex-M4" all_headers "" $arm -mcpu=cortex-m4 -ffreestanding
check "ARM, freestanding: umbrella, device, client" \
    $arm -mcpu=cortex-m0plus -ffreestanding -c tests/freestanding/device.cpp -o "$build/arm.o"

newlib=$(search_path '/arm-none-eabi/include$')
check "RISC-V rv32imc, clang++: umbrella, device, client" clang++ --target=riscv32-unknown-elf -march=rv32imc \
    -mabi=ilp32 $bare -Os -ffreestanding -nostdinc++ $libstdcpp $newlib -c tests/freestanding/device.cpp -o "$build/riscv.o"

# An Arduino sketch has its macros before the headers of the library. After these macros no standard C++ header
# compiles, such as <span>. So the standard headers that the library includes come first, as in a sketch that includes
# them first.
hostile='#include "tests/freestanding/arduino_macros.hpp"\n'
standard='#include "tests/freestanding/standard_headers.hpp"\n'
check "hostile macros, g++: all headers" all_headers "$standard$hostile" g++ $bare
check "hostile macros, ARM: all headers" all_headers "$standard$hostile" $arm -mcpu=cortex-m0plus
check "hostile macros, ARM: each header alone" each_header "$standard$hostile" $arm -mcpu=cortex-m0plus
# Checks that the macros are defined, since otherwise the checks above prove nothing.
check "hostile macros: a header with a bare min does not compile" sh -c \
    "! printf '%b#include <limits>\nint least() { return std::numeric_limits<int>::min(); }\n' '$standard$hostile' |
        g++ $bare -x c++ -fsyntax-only -"

avr_core() {
    $avr -c tests/freestanding/avr.cpp -o "$build/avr.o"
}
# Not by the compiler driver: it lets Debian's avr-ld (2.26) relax the code, which moves clang's jumps to wrong targets.
avr_link() {
    avr-ld -mavr5 --gc-sections -L/usr/lib/avr/lib/avr5 -L"$(dirname "$libgcc")" --start-group \
        -l:crtatmega328p.o "$build/avr.o" -lgcc -lm -lc -latmega328p --end-group \
        --defsym=__DATA_REGION_ORIGIN__=0x800100 -o "$build/avr.elf"
}
# The program ends by sleeping without interrupts. After a crash simavr would wait for a debugger forever, so there is
# a time limit, far above the time that the program needs.
avr_run() {
    timeout 300 simavr -m atmega328p -f 16000000 "$build/avr.elf" 2>&1 | tee "$build/avr.out"
    grep -q 'avr: [1-9][0-9]* passed, 0 failed' "$build/avr.out"
}
libgcc=$(find /usr/lib/gcc/avr -path '*/avr5/libgcc.a' 2>/dev/null | tail -n 1)
if [ -z "$clang_avr" ] || [ ! -e /usr/lib/avr/include/avr/io.h ]; then
    for name in "all headers" "core" "link" "run"; do skip "AVR: $name" "clang-19 or avr-libc cannot be installed"; done
else
    avr="$clang_avr --target=avr -mmcu=atmega328p $bare -Os -ffreestanding -nostdinc++ $libstdcpp -isystem /usr/lib/avr/include"
    # The simulated drives and the catalogues are for hosts.
    headers() { find "$include/servobus" -name '*.hpp' ! -path '*/posix/*' ! -path '*/windows/*' ! -path '*/sim/*' ! -name '*catalogue*' | sort; }
    check "AVR ATmega328P, $clang_avr: all headers for targets" all_headers "" $avr
    check "AVR ATmega328P, $clang_avr: the protocol core" avr_core
    if [ ! -e "$build/avr.o" ] || [ -z "$libgcc" ]; then
        skip "AVR: link" "no object, or no libgcc (gcc-avr)"
        skip "AVR: run" "not linked"
    else
        check "AVR ATmega328P: it links into flash and RAM" avr_link
        if command -v simavr >/dev/null 2>&1; then
            check "AVR ATmega328P: CRC, frames and transactions in simavr" avr_run
        else
            skip "AVR: run" "simavr cannot be installed"
        fi
    fi
fi

echo "freestanding.sh: $checks checks, $failed failed, $skipped skipped"
[ "$failed" = 0 ]
