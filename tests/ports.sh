#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# The ports of examples/ports: each compiles for the host and, if the compiler is installed, for a Cortex-M0+ and M4,
# and keeps the contract of line/port.hpp over a fake of its vendor's API. Installs missing packages (Debian,
# Ubuntu).   sh tests/ports.sh
# The Arduino port is also compiled against the real core of Debian, the STM32 ports against the real HAL from npm.
#   BUILD   where to build; a temporary directory if not given
#   PORTS   only these, by the names of their test programs, and without the vendors' real headers
set -u
cd "$(dirname "$0")/.." || exit 1

. tests/support/install.sh

command -v g++ >/dev/null 2>&1 || install g++ || exit 1
command -v clang++ >/dev/null 2>&1 || install clang libc6-dev || exit 1
echo '#include <doctest/doctest.h>' | g++ -x c++ -std=c++20 -fsyntax-only - 2>/dev/null || install doctest-dev || exit 1
command -v arm-none-eabi-g++ >/dev/null 2>&1 ||
    install gcc-arm-none-eabi libnewlib-arm-none-eabi libstdc++-arm-none-eabi-newlib

if [ -n "${BUILD:-}" ]; then
    build=$BUILD
    mkdir -p "$build" || exit 1
else
    build=$(mktemp -d)
    trap 'rm -rf "$build"' EXIT
fi

strict="-Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wold-style-cast -Wshadow -Werror"
bare="-std=c++20 $strict -fno-exceptions -fno-rtti -Iinclude -I. -Iexamples/ports"
host="$bare -O1 -D_GLIBCXX_ASSERTIONS -DDOCTEST_CONFIG_NO_EXCEPTIONS_BUT_WITH_ALL_ASSERTS"
log=$build/log
. tests/support/checks.sh
skipped=0

# The stepped program by DMA, as its comment tells a user to make it.
sed 's/stm32_hal_it/stm32_hal_dma/' examples/ports/stm32_stepped.cpp >"$build/stm32_stepped_dma.cpp"

# The stubs of the vendor's declarations that a test program or a header needs.
stubs_of() {
    case $1 in
    arduino_stream) echo "-isystem tests/ports/stubs/arduino" ;;
    esp_idf_uart) echo "-isystem tests/ports/stubs/esp_idf" ;;
    freertos_waiting) echo "-isystem tests/ports/stubs/freertos -isystem tests/ports/stubs/stm32_hal" ;;
    rp2040_uart) echo "-isystem tests/ports/stubs/rp2040" ;;
    stm32_*) echo "-isystem tests/ports/stubs/stm32_hal" ;;
    zephyr_uart) echo "-isystem tests/ports/stubs/zephyr" ;;
    esac
}

keeps_contract() { # PORT
    g++ $host $(stubs_of "$1") "tests/ports/$1.cpp" "$build/main.o" -o "$build/$1" && "$build/$1"
}

# A client and a line over the port, for a core that has no heap, no exceptions and no atomic instructions: the object
# may use only functions of the vendor and the compiler's arithmetic.
fits_core() { # CORE PORT SOURCE
    arm-none-eabi-g++ $bare -Os -mthumb "-mcpu=$1" $(stubs_of "$2") \
        -c "$3" -o "$build/$2.o" || return 1
    if arm-none-eabi-nm -C "$build/$2.o" |
        grep -E ' U (malloc$|free$|abort$|operator |__cxa_|__gxx_|__atomic_|_Unwind|__aeabi_[df])|GLOBAL__sub_I'; then
        echo "the object needs what a small core does not have"
        return 1
    fi
}

check "the runner" g++ $host -c tests/run/main.cpp -o "$build/main.o"
for port in ${PORTS:-arduino_stream esp_idf_uart freertos_waiting rp2040_uart stm32_hal zephyr_uart}; do
    check "g++: $port keeps the contract" keeps_contract "$port"
    check "clang++: $port compiles" clang++ $host $(stubs_of "$port") -fsyntax-only "tests/ports/$port.cpp"
done
if command -v arm-none-eabi-g++ >/dev/null 2>&1; then
    for core in cortex-m0plus cortex-m4; do
        for port in arduino_stream esp_idf_uart freertos_waiting rp2040_uart stm32_hal_dma stm32_hal_it zephyr_uart; do
            check "$core: $port in a program" fits_core $core $port tests/ports/bare/$port.cpp
        done
        check "$core: the stepped program, by interrupt" fits_core $core stm32_stepped examples/ports/stm32_stepped.cpp
        check "$core: the stepped program, by DMA" fits_core $core stm32_stepped_dma "$build/stm32_stepped_dma.cpp"
    done
else
    echo "skipped arm-none-eabi-g++ is not there"
    skipped=18
fi

# Against the vendors' real headers, where Debian or npm have them (examples/ports/README.md says where not). The
# compiler must have read these, not the stubs.
against_arduino_core() { # SOURCE
    $clang_avr --target=avr -mmcu=atmega2560 $bare -Os -DF_CPU=16000000L -DARDUINO=10819 \
        -isystem $arduino_core/cores/arduino -isystem $arduino_core/variants/mega \
        -nostdinc++ -isystem /usr/lib/avr/include $libstdcpp -MD -c "$1" -o "$build/real.o" &&
        grep -q cores/arduino/HardwareSerial.h "$build/real.d"
}
# The HAL of the STM32F4 as CubeMX writes it, without its UART module, which no package has: that is a stub.
against_stm32_hal() { # SOURCE OPTION...
    source=$1
    shift
    hal=$build/package/stm32cubemx
    arm-none-eabi-g++ $bare -Os -mthumb -mcpu=cortex-m4 -DUSE_HAL_DRIVER -DSTM32F407xx -DHAL_UART_MODULE_ENABLED "$@" \
        -isystem tests/ports/stubs/stm32f4_uart -isystem "$hal/Core/Inc" \
        -isystem "$hal/Drivers/STM32F4xx_HAL_Driver/Inc" -isystem "$hal/Drivers/CMSIS/Device/ST/STM32F4xx/Include" \
        -isystem "$hal/Drivers/CMSIS/Include" -MD -c "$source" -o "$build/real.o" &&
        grep -q HAL_Driver/Inc/stm32f4xx_hal_gpio.h "$build/real.d" && ! grep -q stubs/stm32_hal/main.h "$build/real.d"
}
hal_package=@micro-os-plus/platform-stm32f4discovery@3.3.1
get_hal() {
    command -v npm >/dev/null 2>&1 || install npm || return 1
    (cd "$build" && npm pack --silent $hal_package && tar xzf micro-os-plus-platform-stm32f4discovery-3.3.1.tgz)
}
if [ -n "${PORTS:-}" ] || ! command -v arm-none-eabi-g++ >/dev/null 2>&1; then
    echo "skipped the vendors' real headers: PORTS is set, or arm-none-eabi-g++ is not there"
    skipped=$((skipped + 7))
else
    eval "$(python3 -B tests/support/avr.py | tail -n 2)" # clang_avr, libstdcpp
    arduino_core=/usr/share/arduino/hardware/arduino/avr
    [ -e $arduino_core ] && [ -e /usr/lib/avr/include/avr/io.h ] || install arduino-core-avr avr-libc
    if [ -n "$clang_avr" ] && [ -e $arduino_core ]; then
        check "real headers, Arduino AVR core: arduino_stream" against_arduino_core tests/ports/bare/arduino_stream.cpp
    else
        echo "skipped real headers, Arduino AVR core: arduino-core-avr or clang-19 cannot be installed"
        skipped=$((skipped + 1))
    fi
    if get_hal >"$build/log" 2>&1; then
        timers=-DHAL_TIM_MODULE_ENABLED
        check "real headers, STM32F4 HAL: interrupt" against_stm32_hal tests/ports/bare/stm32_hal_it.cpp $timers
        check "real headers, STM32F4 HAL: DMA" against_stm32_hal tests/ports/bare/stm32_hal_dma.cpp $timers
        check "real headers, STM32F4 HAL: stepped, interrupt" against_stm32_hal examples/ports/stm32_stepped.cpp $timers
        check "real headers, STM32F4 HAL: stepped, DMA" against_stm32_hal "$build/stm32_stepped_dma.cpp" $timers
        check "real headers, STM32F4 HAL without timers: DMA" against_stm32_hal tests/ports/bare/stm32_hal_dma.cpp
        check "real headers, STM32F4 HAL without timers: FreeRTOS over interrupt" \
            against_stm32_hal tests/ports/bare/freertos_waiting.cpp -isystem tests/ports/stubs/freertos
    else
        echo "skipped real headers, STM32F4 HAL: $hal_package cannot be got from npm"
        skipped=$((skipped + 6))
    fi
fi

# Each port must be in a test.
for header in examples/ports/*.hpp; do
    check "$header is in a test" grep -q "${header##*/}\"" tests/ports/*.cpp examples/ports/stm32_hal_it.hpp
done

echo "ports.sh: $checks checks, $failed failed, $skipped skipped"
[ "$failed" = 0 ]
