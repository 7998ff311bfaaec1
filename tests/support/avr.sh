# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# For scripts that compile C++20 for AVR, read by `. tests/support/avr.sh` after install.sh. Needs arm-none-eabi-g++.
#   clang_avr   a clang++ for AVR, which needs a newer one than the default of Debian 12; empty if there is none
#   libstdcpp   the options for its C++ headers. Debian has none for AVR and RISC-V; those of ARM's libstdc++ work, since
#               they use only the compiler's own macros.

clang_avr=""
for candidate in clang++-19 clang++-20 clang++-21 clang++-18; do
    [ -n "$clang_avr" ] || ! command -v $candidate >/dev/null 2>&1 || clang_avr=$candidate
done
if [ -z "$clang_avr" ] && install clang-19; then clang_avr=clang++-19; fi

search_path() { # PATTERN
    arm-none-eabi-g++ -v -x c++ -E - </dev/null 2>&1 |
        sed -n '/^#include </,/^End/p' | grep -E "^ .*$1" | sed 's/^ / -isystem /' | tr -d '\n'
}
libstdcpp=$(search_path '/c\+\+/')
