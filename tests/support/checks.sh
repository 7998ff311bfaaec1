# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# For scripts whose checks are commands, read by `. tests/support/checks.sh` in the project's root. It wants `log`, a
# file for what a command prints.
checks=0
failed=0

check() { # NAME COMMAND...
    name=$1
    shift
    checks=$((checks + 1))
    if "$@" >"$log" 2>&1; then
        echo "ok      $name"
    else
        echo "FAILED  $name"
        tail -n 40 "$log"
        failed=$((failed + 1))
    fi
}
