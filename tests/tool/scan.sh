# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Part of tests/tool.sh: servobus scan, and adapters with a local echo.
# shellcheck shell=sh

out_has() { grep -qxF -- "$1" "$dir/out"; }
err_mentions() { grep -qF -- "$1" "$dir/err"; }

fails "scan: no port named" 2 "scan takes one PORT" scan
fails "scan: no such port" 1 "cannot open" scan /dev/no-such-port
fails "scan: addresses that no device has" 2 "--nodes takes addresses from 1 to 247" scan "$drive" --nodes 0-5
fails "scan: a rate that does not exist" 2 "--baud takes rates" scan "$drive" --baud 9600,12

for found in "zlac8015d 115200 8N1 5 zlac8015d" "yako-closed-loop 115200 8N1 3 yako" \
    "yako-open-loop 115200 8N1 1 yako" "c630s 57600 8N2 2 c630s"; do
    # shellcheck disable=SC2086
    set -- $found
    start_sim "$1" --node "$4"
    run scan "$drive" --baud "$2" --format "$3" --nodes 1-6
    check "scan: $1 is found and named" status_is 0
    check "scan: $1 alone" out_is "$2 $3 $4 $5"
    check "scan: shows how far it is" err_mentions "6 of 6"
    stop_sim
done

# A pseudo-terminal has no rate: at each one the same drive would be found again.
start_sim zlac8015d --node 2
run scan "$drive" --nodes 1-3
check "scan: a simulator is scanned once" out_is "- - 2 zlac8015d"
check "scan: and ends with status 0" status_is 0
check "scan: it says why" err_mentions "is a pseudo-terminal, which has no rate and no format: scanning once"
check "scan: nothing is scanned at a second rate" [ "$(grep -c ' 3 of 3$' "$dir/err")" -eq 1 ]
run scan "$drive" --nodes 2 --baud 115200 --format 8N1
check "scan: one rate is shown as it was given" out_is "115200 8N1 2 zlac8015d"
check "scan: without a remark" sh -c "! grep -q pseudo-terminal '$dir/err'"
stop_sim

start_sim zlac8015d --node 5
run scan "$drive" --baud 115200 --format 8N1 --nodes 1-4
check "G27: no response is reported" status_is 1
check "and said" err_mentions "no device responds"
stop_sim

# G24: after a change of its address the scan finds the drive. No write goes to an address that is not certain.
start_sim zlac8015d
run write "$drive" zlac8015d node_address=9
check "G24: an address is changed" status_is 0
run write "$drive" zlac8015d save_parameters=save_all --yes
run scan "$drive" --baud 115200 --format 8N1 --nodes 1-10
check "G24: scan finds the drive, at its old or new address" [ "$(wc -l <"$dir/out")" -eq 1 ]
stop_sim

# An adapter with a local echo.
start_sim zlac8015d --echo on
run scan "$drive" --baud 115200 --format 8N1 --nodes 2-3 # no drive is there, so nothing but the echo arrives
check "G3: an echo is no response" err_mentions "try --echo on"
run scan "$drive" --baud 115200 --format 8N1 --nodes 1-3 --echo on
check "G4: without its echo the drive is found" out_has "115200 8N1 1 zlac8015d"
succeeds "G4: and read" "bus_voltage=24.00 V" read "$drive" zlac8015d bus_voltage --echo on
succeeds "G4: and written" "left_max_current=12.5 A" write "$drive" zlac8015d left_max_current=12.5 --echo on
run write "$drive" zlac8015d left_max_current=13
check "G3: an echo acknowledges nothing" status_is 1
check "G3: what came may be an echo" err_mentions "unknown, what came may be the request's own echo"
stop_sim
