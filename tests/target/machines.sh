#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Builds the programs of examples/robot, lift and press in a superloop for a Cortex-M0+, arm-none-eabi-g++ -Os, and prints
# what each takes. Fails if floating point, a 64-bit division, the heap or unwinding is linked.
#   sh tests/target/machines.sh
set -eu
cd "$(dirname "$0")/../.."
. tests/target/measure.sh

unwanted='__aeabi_[df][a-z0-9]|__aeabi_u?ldivmod|__u?divdi3|__u?moddi3|malloc|_Unwind|printf'
status=0
build nothing cortex-m0plus
without=$(size_of '$1 + $2')
printf '%-12s%16s\n' "program" "bytes of flash"
number_of=0
for machine in robot lift press; do
    number_of=$((number_of + 1))
    build machines cortex-m0plus "-DMACHINE=$number_of"
    if arm-none-eabi-nm "$work/program.elf" | grep -E " ($unwanted)"; then
        echo "FAILED  in $machine: linked, but not to be" >&2
        status=1
    fi
    printf '%-12s%16s\n' "$machine" "$(($(size_of '$1 + $2') - without))"
done
exit $status
