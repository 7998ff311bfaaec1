# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# cpu_seconds FILE: of the programs that a script has run, from what `times` has printed into FILE.
cpu_seconds() {
    awk 'NR == 2 { split($1, u, /[ms]/); split($2, s, /[ms]/)
                   printf "%d", u[1] * 60 + u[2] + s[1] * 60 + s[2] }' "$1"
}
