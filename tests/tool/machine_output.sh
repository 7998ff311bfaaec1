# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Part of tests/tool.sh: --csv, --json and --log of read and watch. records.py judges the records. If this machine
# does not allow a case, a line that begins with "NOT RUN" reports it.

records() { python3 -B "$parts/records.py" "$@" >"$dir/err" 2>&1; }
# without_times FILE: the records with T for the times, which no test knows before
without_times() {
    sed -E 's/[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9:]{8}\.[0-9]{3}Z/T/
        s/^(T,[^,]*,)[0-9]+/\1T/; s/("unix_ms":)[0-9]+/\1T/' "$1"
}
records_are() { [ "$(without_times "$1")" = "$2" ]; }
# json REGISTERS ERRORS: a line without its times
json() { printf '{"time":"T","unix_ms":T,"registers":{%s},"errors":{%s}}' "$1" "$2"; }
# recorded NAME STATUS RECORDS ARGUMENTS...: what the tool prints, without the times
recorded() {
    name=$1 expected=$2 wanted=$3
    shift 3
    run "$@"
    if status_is "$expected" && records_are "$dir/out" "$wanted"; then
        ok "$name"
    else
        not_ok "$name (status $status)"
    fi
}

# What is refused before anything is sent: there is no such port.

fails "--csv and --json together" 2 "--csv and --json exclude each other" \
    read /dev/no-such-port zlac8015d bus_voltage --csv --json
fails "a register twice has no columns" 2 "bus_voltage is given twice" \
    watch /dev/no-such-port zlac8015d bus_voltage 0x20A1 --csv
fails "nor has a word twice" 2 "0x2089 is given twice" read /dev/no-such-port raw 0x2088:2 0x2089 --json
fails "--csv takes no value" 2 "--csv takes no value" read /dev/no-such-port zlac8015d bus_voltage --csv=1
fails "--log needs one" 2 "--log needs a value" read /dev/no-such-port zlac8015d bus_voltage --log
fails "write has no records" 2 "unknown option '--csv'" write /dev/no-such-port zlac8015d left_max_current=1 --csv
fails "backup has none" 2 "unknown option '--json'" backup /dev/no-such-port zlac8015d --json

# The formats

check "a zlac8015d" start_sim zlac8015d
run write "$drive" zlac8015d left_max_current=12.5 left_target_speed=-7 --yes
columns="bus_voltage (V),left_max_current (A),motor_temperature_left (degC),motor_temperature_right (degC)"
recorded "CSV: units in the header, plain numbers, codes by number" 0 \
    "time,error,unix_time (ms),$columns,mode_of_operation,left_target_speed (counts)
T,,T,24.00,12.5,31,32,0,-7" \
    read "$drive" zlac8015d bus_voltage left_max_current motor_temperature mode_of_operation left_target_speed --csv
cp "$dir/out" "$dir/one.csv"
check "it is CSV, and loads into ModbusScope" records csv "$dir/one.csv" 1
state='"status_word":{"value":0,"text":"left_released+right_released"}'
recorded "JSON: numbers with units, codes with their names" 0 \
    "$(json '"bus_voltage":{"value":24.00,"unit":"V"},"mode_of_operation":{"value":0,"text":"undefined"},'"$state")" \
    read "$drive" zlac8015d bus_voltage mode_of_operation status_word --json
recorded "words without a map: a column each" 0 "time,error,unix_time (ms),0x20A1,0x2088,0x2089
T,,T,2400,65529,0" read "$drive" raw 0x20A1 0x2088:2 --csv
recorded "and in JSON" 0 \
    "$(json '"0x2088":{"value":65529},"0x2089":{"value":0}' '')" \
    read "$drive" raw 0x2088:2 --json
TZ=Asia/Tokyo "$tool" read "$drive" zlac8015d bus_voltage --csv >"$dir/out" 2>"$dir/err"
check "times are UTC, whatever the time zone" records recent "$dir/out"
if localedef -i de_DE -f UTF-8 "$dir/de_DE.UTF-8" 2>/dev/null; then
    LOCPATH=$dir LC_ALL=de_DE.UTF-8 "$tool" read "$drive" zlac8015d bus_voltage --csv >"$dir/out" 2>"$dir/err"
    check "numbers have a point in every locale" grep -q ',24\.00$' "$dir/out"
else
    echo "NOT RUN: a locale with a decimal comma, since localedef(1) cannot make one"
fi

# Every register of each drive, as read prints it
like_read() { # DEVICE
    "$tool" map "$1" >"$dir/map"
    # power_on_time counts seconds meanwhile.
    all=$(awk -F, 'NR > 1 && $5 != "wo" && $2 != "power_on_time" { print $2 }' "$dir/map")
    "$tool" read "$drive" "$1" $all >"$dir/read"
    "$tool" read "$drive" "$1" $all --csv >"$dir/all.csv"
    check "$1: each column of CSV is what read prints" records like_read csv "$dir/all.csv" "$dir/read" "$dir/map"
    "$tool" read "$drive" "$1" $all --json >"$dir/all.json"
    check "$1: and each one of JSON" records like_read json "$dir/all.json" "$dir/read" "$dir/map"
}
like_read zlac8015d

# Errors

recorded "an error is named, and has nan for its columns" 1 "time,error,unix_time (ms),0x20A1,0x3000,0x3001,0x2089
T,0x3000:2: refused exception 2 (illegal data address),T,2400,nan,nan,0" \
    read "$drive" raw 0x20A1 0x3000:2 0x2089 --csv
check "as on standard error" err_has "0x3000:2: refused, exception 2 (illegal data address)"
check "in one line" err_lines_are 1
check "its row is CSV" records csv "$dir/out" 1
recorded "JSON has null, and the error beside it" 1 \
    "$(json '"0x3000":{"value":null},"0x2089":{"value":0}' \
        '"0x3000":"refused, exception 2 (illegal data address)"')" \
    read "$drive" raw 0x3000 0x2089 --json
check "its line is JSON" records json "$dir/out" 1
recorded "no response: every error is named" 1 "time,error,unix_time (ms),bus_voltage (V),left_max_current (A)
T,bus_voltage: no response; left_max_current: no response,T,nan,nan" \
    read "$drive" zlac8015d:9 bus_voltage left_max_current --csv --timeout 20 --retries 0
check "standard error has the first" err_has "bus_voltage: no response"
check "and no other" err_lines_are 1
recorded "no response in JSON: a code has no name" 1 \
    "$(json '"mode_of_operation":{"value":null,"text":null}' '"mode_of_operation":"no response"')" \
    read "$drive" zlac8015d:9 mode_of_operation --json --timeout 20 --retries 0
"$tool" read "$drive" zlac8015d bus_voltage --csv >/dev/full 2>"$dir/err"
status=$?
check "standard output that cannot be written (status $status)" status_is 1
check "is said once" err_has "cannot write standard output: No space left on device"

# watch

run watch "$drive" zlac8015d bus_voltage left_actual_speed --csv --count 3 --interval 30
check "watch --csv: status 0" status_is 0
check "a row a round" records csv "$dir/out" 3
check "a header once" grep -qxF "time,error,unix_time (ms),bus_voltage (V),left_actual_speed (r/min)" "$dir/out"
spread() { awk -F, 'NR == 2 { first = $3 } END { exit !($3 - first >= 40) }' "$1"; }
check "the times are those of the rounds" spread "$dir/out"
run watch "$drive" zlac8015d bus_voltage status_word --json --count 3 --interval 10
check "watch --json: an object a round" records json "$dir/out" 3

"$tool" watch "$drive" zlac8015d bus_voltage --csv --interval 10 --timeout 20 --retries 0 \
    >"$dir/cut.csv" 2>/dev/null &
watcher=$!
ends_with() { tail -n 1 "$1" | grep -qE "$2"; }
check "rows come" until_true ends_with "$dir/cut.csv" ',,[0-9]*,24.00$'
kill -USR1 "$sim"
check "an unplugged drive is a row with an error" \
    until_true ends_with "$dir/cut.csv" 'bus_voltage: no response,[0-9]*,nan$'
kill -USR1 "$sim"
check "and its values come again" until_true ends_with "$dir/cut.csv" ',,[0-9]*,24.00$'
kill -INT "$watcher"
wait "$watcher"
status=$?
check "an interrupt ends it with status 0" status_is 0
check "all rows are whole" records csv "$dir/cut.csv" 3+

"$tool" watch "$drive" zlac8015d bus_voltage left_max_current --csv --interval 10 >"$dir/lost.csv" 2>"$dir/err" &
watcher=$!
check "rows come" until_true test -s "$dir/lost.csv"
stop_sim
wait "$watcher"
status=$?
check "a lost port ends watch (status $status)" status_is 1
check "which says so" err_has "the port is gone"
check "after the row that has it" ends_with "$dir/lost.csv" 'left_max_current: [^,]+,[0-9]*,[^,]*,nan$'
check "all rows are whole, so is that one" records csv "$dir/lost.csv" 1+

# --log

start_sim zlac8015d
log=$dir/log.csv
logged() { run "$@" --log "$log"; }
succeeds "--log: standard output is as without it" "bus_voltage=24.00 V" \
    read "$drive" zlac8015d bus_voltage --log "$log"
logged read "$drive" zlac8015d bus_voltage --csv
check "with --csv too" out_is "bus_voltage=24.00 V"
check "each appends a row, and only the first a header" records_are "$log" "time,error,unix_time (ms),bus_voltage (V)
T,,T,24.00
T,,T,24.00"
logged watch "$drive" zlac8015d bus_voltage --count 2 --interval 10
check "watch --log: a line a round as without it" [ "$(grep -c '^[0-9.]* bus_voltage=24.00 V$' "$dir/out")" -eq 2 ]
check "and nothing else" [ "$(wc -l <"$dir/out")" -eq 2 ]
check "its rows are appended" records csv "$log" 4
logged read "$drive" zlac8015d:9 bus_voltage --timeout 20 --retries 0
check "no response: status 1" status_is 1
check "in one line" err_lines_are 1
check "is a row too" records_are "$log" "time,error,unix_time (ms),bus_voltage (V)
T,,T,24.00
T,,T,24.00
T,,T,24.00
T,,T,24.00
T,bus_voltage: no response,T,nan"
run read "$drive" zlac8015d bus_voltage --json --log "$dir/log.json"
check "--json --log: standard output is for people" out_is "bus_voltage=24.00 V"
run read "$drive" zlac8015d left_max_current --json --log "$dir/log.json"
check "JSON of other registers" status_is 0
check "goes into the same file" [ "$(wc -l <"$dir/log.json")" -eq 2 ]
: >"$dir/empty"
run read "$drive" zlac8015d bus_voltage --log "$dir/empty"
check "an empty file gets a header" records csv "$dir/empty" 1
ln -s "$log" "$dir/linked"
run read "$drive" zlac8015d bus_voltage --log "$dir/linked"
check "a link is followed" records csv "$log" 6

# Logs that are refused. No port is opened for them.
is_kept() { cmp -s "$1" "$dir/before"; }
# refused NAME STATUS WORDS LOG ARGUMENTS...
refused() {
    what=$1 expected=$2 words=$3 into=$4
    shift 4
    if [ -f "$into" ]; then cp "$into" "$dir/before"; fi
    fails "$what" "$expected" "$words" "$@" --log "$into"
    if [ -f "$into" ]; then check "and stays as it was" is_kept "$into"; fi
}
nowhere=/dev/no-such-port
refused "a log of other columns" 2 "it has other columns" "$log" read $nowhere zlac8015d left_max_current
refused "of more" 2 "it has other columns" "$log" read $nowhere zlac8015d bus_voltage left_max_current
refused "of JSON, for CSV" 2 "it has other columns" "$dir/log.json" read $nowhere zlac8015d bus_voltage
refused "of CSV, for JSON" 2 "it is no log of --json" "$log" watch $nowhere zlac8015d bus_voltage --json
head -c -1 "$log" >"$dir/torn"
refused "whose last line has no end" 2 "its last line has no end" "$dir/torn" read $nowhere zlac8015d bus_voltage
mkdir "$dir/folder"
refused "a folder" 1 "cannot write $dir/folder: Is a directory" "$dir/folder" read $nowhere zlac8015d bus_voltage
refused "in no folder" 1 "No such file or directory" "$dir/none/log" read $nowhere zlac8015d bus_voltage
ln -s "$dir/nothing" "$dir/dangling"
refused "a link to nothing" 1 "No such file or directory" "$dir/dangling" read $nowhere zlac8015d bus_voltage
mkfifo "$dir/fifo"
refused "a FIFO" 1 "it is no regular file" "$dir/fifo" read $nowhere zlac8015d bus_voltage
refused "a device" 1 "it is no regular file" /dev/full read $nowhere zlac8015d bus_voltage
fails "the port itself" 1 "cannot write $drive: it is no regular file" \
    read "$drive" zlac8015d bus_voltage --log "$drive"
fails "no such port" 1 "No such file or directory" read $nowhere zlac8015d bus_voltage --log "$dir/unmade"
check "leaves no empty log" [ ! -e "$dir/unmade" ]
: >"$dir/before"
: >"$dir/kept"
run read $nowhere zlac8015d bus_voltage --log "$dir/kept"
check "but an empty file that was there before" is_kept "$dir/kept"
if [ "$(id -u)" -ne 0 ]; then
    cp "$log" "$dir/protected"
    chmod 444 "$dir/protected"
    refused "that may not be written" 1 "Permission denied" "$dir/protected" read $nowhere zlac8015d bus_voltage
elif chmod 711 "$dir" && cp "$tool" "$dir/servobus" && chmod 755 "$dir/servobus" && cp "$log" "$dir/protected" &&
    as_user="setpriv --reuid=65534 --regid=65534 --clear-groups" && $as_user test -x "$dir/servobus"; then
    $as_user "$dir/servobus" read $nowhere zlac8015d bus_voltage --log "$dir/protected" >"$dir/out" 2>"$dir/err"
    status=$?
    check "that may not be written (status $status)" status_is 1
    check "it says so" err_has "cannot write $dir/protected: Permission denied"
else
    echo "NOT RUN: a log that may not be written, since setpriv(1) is not permitted"
fi

# Two programs, one log
"$tool" watch "$drive" zlac8015d bus_voltage --interval 10 --log "$dir/shared" >/dev/null 2>&1 &
watcher=$!
check "a log is being written" until_true test -s "$dir/shared"
fails "two programs do not write one log" 1 "cannot write $dir/shared: another program logs into it" \
    read $nowhere zlac8015d bus_voltage --log "$dir/shared"
kill -INT "$watcher"
wait "$watcher"
check "which stays whole" records csv "$dir/shared" 1+

# A file that cannot grow: a row does not fit, and what was written of it is taken back.
(ulimit -f 1 &&
    timeout 20 "$tool" watch "$drive" zlac8015d bus_voltage --interval 1 --log "$dir/grown" >/dev/null 2>&1)
status=$?
check "a log that cannot grow ends watch (status $status)" status_is 1
check "and has whole rows only" records csv "$dir/grown" 5+
(ulimit -f 1 && "$tool" read "$drive" zlac8015d bus_voltage --log "$dir/grown" 2>&1 >"$dir/out" | cat >"$dir/err")
check "it says why" err_has "cannot write $dir/grown: File too large"
check "in one line" err_lines_are 1
stop_sim

# Other drives: pairs, negative codes, a parameter number
check "a yako-closed-loop" start_sim yako-closed-loop
run write "$drive" yako-closed-loop homing_method=mechanical_stop_1 home_offset=-70000 pair_word_order=low_first
recorded "a pair is one column, a negative code its number" 0 \
    "time,error,unix_time (ms),home_offset (pulse),homing_method,actual_speed (counts)
T,,T,-70000,-1,0" read "$drive" yako-closed-loop home_offset homing_method actual_speed --csv
like_read yako-closed-loop
stop_sim
check "a c630s" start_sim c630s
recorded "a parameter number is called by its name" 0 "time,error,unix_time (ms),target_speed (r/min)
T,,T,200" read "$drive" c630s P06-03 --csv
like_read c630s
