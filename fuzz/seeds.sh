#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Makes the seeds in fuzz/corpus/ again; inputs that fuzzing found stay: found_*, and those named by their hash.
#   sh fuzz/seeds.sh
set -eu
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"${CXX:-g++}" -std=c++20 -O1 fuzz/seeds.cpp -o "$work/seeds"
[ ! -d fuzz/corpus ] || find fuzz/corpus -type f ! -name 'found_*' ! -regex '.*/[0-9a-f]*' -delete
"$work/seeds"
for folder in fuzz/corpus/*; do echo "$(basename "$folder"): $(find "$folder" -type f | wc -l)"; done
