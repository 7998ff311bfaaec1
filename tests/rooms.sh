#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Checks that the folders of headers form layers (tests/rooms.py), and that this check finds violations.
#   sh tests/rooms.sh
set -u
cd "$(dirname "$0")/.." || exit 1
command -v python3 >/dev/null 2>&1 || { echo "rooms.sh: python3 is needed"; exit 1; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0

# breaks HEADER LINE MESSAGE: with LINE added to HEADER the check must fail with MESSAGE.
breaks() {
    rm -rf "$work/include"
    cp -r include "$work/include"
    echo "$2" >>"$work/include/servobus/$1"
    if python3 -B tests/rooms.py "$work/include" >"$work/said" || ! grep -qF "$3" "$work/said"; then
        echo "rooms.sh: $2 in $1 is not found:"
        cat "$work/said"
        failed=1
    fi
}

python3 -B tests/rooms.py || failed=1
breaks line/port.hpp '#include <servobus/control/step.hpp>' \
    'line/port.hpp includes control/step.hpp: line may include core modbus'
breaks modbus/pdu.hpp '#include <servobus/registers/reg.hpp>' 'modbus/pdu.hpp includes registers/reg.hpp'
breaks core/slice.hpp '#include <servobus/core/bytes.hpp>' 'circle: core/bytes.hpp -> core/slice.hpp -> core/bytes.hpp'
breaks control/facade.hpp '#include <servobus/line/detail/arbiter.hpp>' 'a detail/ is for its own room'
breaks device/yako/common.hpp 'using servobus::detail::sound_row;' 'device/yako/common.hpp uses servobus::detail'
[ "$failed" = 0 ] && echo "rooms.sh: passed" || echo "rooms.sh: FAILED"
exit "$failed"
