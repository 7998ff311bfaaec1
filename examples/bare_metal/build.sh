#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Builds the images: sh examples/bare_metal/build.sh FOLDER      CXX: arm-none-eabi-g++ if not given
set -eu
into=${1:?usage: sh examples/bare_metal/build.sh FOLDER}
here=$(dirname "$0")
for program in blocking superloop clock_check; do
    "${CXX:-arm-none-eabi-g++}" -mcpu=cortex-m3 -mthumb -Os -std=c++20 -ffreestanding -fno-exceptions -fno-rtti \
        -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wold-style-cast -Wshadow -Werror \
        -ffunction-sections -fdata-sections -I"$here/../../include" "$here/start.cpp" "$here/$program.cpp" \
        -nostartfiles --specs=nano.specs -Wl,--gc-sections -T "$here/mps2_an385.ld" -o "$into/$program.elf"
done
