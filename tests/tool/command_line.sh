# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Part of tests/tool.sh: help, manual page and completion, which are made from the table of the commands. What they must
# have is taken from elsewhere: from the pages and the other tests, which write command lines, and from what the command
# line accepts.
# shellcheck shell=sh

pages="$parts/../../examples/servobus/README.md $parts/../../README.md"
others=$(ls "$parts"/*.sh | grep -v command_line)
"$tool" --help >"$dir/help"
"$tool" manual >"$dir/servobus.1"
"$tool" completion bash >"$dir/completion"
completed() { bash "$parts/words.bash" "$dir/completion" "$tool" ':=' "$1" >"$dir/out" 2>"$dir/err"; }
# Options of a command in the manual page: those of its own and those that it shares.
in_manual() {
    awk -v command="$1" '
        /^\.SH/ { ours = 0 }
        /^\.SS/ { ours = index($0, "\\fB" command "\\fR") > 0 }
        /^For / { gsub(",", " "); ours = index(" " $0 ".", " " command " ") > 0 || index($0, " " command ".") > 0 }
        ours && /^\\fB\\-\\-/ { print }' "$dir/servobus.1" | sed 's/\\fR.*//; s/\\fB//; s/\\//g' | sort
}
all_commands=$(sed -n 's/^\.SS "\\fB\([a-z]*\)\\fR.*/\1/p' "$dir/servobus.1")

# Commands that pages and tests write, with the words after `servobus`, `"$tool"`, run, succeeds and fails.
written=$({
    grep -ohE '(^    |`)(\./)?servobus [a-z]+ ' $pages | grep -oE '[a-z]+ $'
    grep -ohE '("\$tool"|^ *run) [a-z]+ ' $others | grep -oE '[a-z]+ $'
} | sort -u)
check "pages and tests write most commands" [ "$(echo "$written" | wc -l)" -ge 10 ]
for command in $written; do
    check "$command is in the manual page" sh -c "echo '$all_commands' | grep -qx '$command'"
done
for command in $all_commands; do
    check "$command is in --help" grep -qE "^  servobus $command( |\$)" "$dir/help"
    completed "servobus $command"
    check "$command is completed" grep -qw -- "$command" "$dir/out"
    check "$command: is in the tool's page" grep -q "servobus $command" $pages
    run "$command"
    check "$command is a command" sh -c "! grep -q 'unknown command' '$dir/err'"
    in_manual "$command" >"$dir/options"
    for option in $(cat "$dir/options"); do
        run "$command" "$option"
        check "$command $option is accepted" sh -c "! grep -q 'unknown option' '$dir/err'"
    done
    run "$command" --help
    check "$command --help: status 0" status_is 0
    check "$command --help has its options and no other" sh -c "grep -oE '^  --[a-z-]+' '$dir/out' | tr -d ' ' | sort |
        diff - '$dir/options'"
    completed "servobus $command --"
    check "$command: its options are completed and no other" sh -c "tr ' ' '\n' <'$dir/out' | grep -vx -e --help | sort |
        diff - '$dir/options'"
    run help "$command"
    check "help $command is the same" sh -c "'$tool' '$command' --help | diff - '$dir/out'"
done
run read --help
check "read --help has not what only others take" sh -c "! grep -qE -e '--(yes|faults|interval)' '$dir/out'"
check "read --help says what PORT is" grep -q '^PORT  *a serial device' "$dir/out"
check "and no word that it does not take" sh -c "! grep -q '^VALUE' '$dir/out'"
run write PORT zlac8015d left_max_current=1 --help
check "--help after other words is the command's" grep -q '^servobus write ' "$dir/out"
run fly --help
check "--help of what is no command is that of all" sh -c "diff '$dir/out' '$dir/help'"
# Options that pages and tests write.
options_written() {
    cat "$parts/../../examples/servobus/README.md"
    grep -h '^    servobus ' $pages
    grep -hE '"\$tool"|^ *(run|succeeds|fails|refused|start_sim) ' $others | sed 's/.*"\$tool"//'
}
for option in $(options_written | grep -oE '(^|[ `"])--[a-z]+(-[a-z]+)*' | grep -oE -e '--.*' | sort -u); do
    case $option in
    --help | --version)
        check "$option is in the manual page" grep -qF -e "$(echo "$option" | sed 's/-/\\-/g')" "$dir/servobus.1"
        ;;
    --colour) ;; # wrong on purpose
    *)
        check "$option is in the manual page" grep -qF "fB$(echo "$option" | sed 's/-/\\-/g')\\fR" "$dir/servobus.1"
        check "$option is in --help" grep -q -e "^  $option " "$dir/help"
        ;;
    esac
done
check "no line of --help is longer than 80 columns" sh -c "! grep -E '.{81}' '$dir/help'"

# The manual page

check "manual: its version is that of --version" grep -qF ".TH SERVOBUS 1 \"\" \"$("$tool" --version)\"" "$dir/servobus.1"
check "manual: plain text of its own characters" sh -c "! LC_ALL=C grep -n '[^ -~]' '$dir/servobus.1'"
fails "manual takes no words" 2 "manual takes no words" manual read
if command -v groff >/dev/null 2>&1; then
    groff -man -Tutf8 -ww -P-c -P-b -P-u "$dir/servobus.1" >"$dir/page" 2>"$dir/err"
    check "manual: groff has no warning" [ ! -s "$dir/err" ]
    check "manual: an apostrophe is one" grep -q "the register's content" "$dir/page"
    check "manual: a tilde is one" grep -qF '~/.bashrc' "$dir/page"
    check "manual: a hyphen is one that can be typed" grep -q -e '--dry-run' "$dir/page"
    words_of() { sed 's/^[a-z]*: //' "$1" | tr -d '.:,' | tr 'A-Z' 'a-z' | tr -s ' ' '\n' | sort -u; }
    words_of "$dir/page" >"$dir/words"
    check "manual: all words of --help are in it" [ "$(words_of "$dir/help" | comm -13 "$dir/words" - | tr "\n" " ")" = "" ]
fi
if command -v man >/dev/null 2>&1 && [ "$(man --version 2>/dev/null | cut -c1-4)" = "man " ]; then
    man --warnings -l "$dir/servobus.1" >"$dir/page" 2>"$dir/err"
    check "manual: man has no warning" [ ! -s "$dir/err" -a -s "$dir/page" ]
fi

# Completion

fails "completion takes a shell" 2 "completion takes one shell: bash" completion
fails "completion of a shell that has none" 2 "no completion for 'tcsh'; bash has one" completion tcsh
check "completion: bash reads the script" bash -n "$dir/completion"
# completes LINE EXPECTED [EXPECTED-WITHOUT-BREAKS]: what takes the place of the last word
completes() {
    bash "$parts/words.bash" "$dir/completion" "$tool" ':=' "$1" >"$dir/out" 2>"$dir/err"
    check "completion: $1" [ "$(cat "$dir/out")" = "$2" ]
    bash "$parts/words.bash" "$dir/completion" "$tool" '' "$1" >"$dir/out" 2>"$dir/err"
    check "completion without word breaks: $1" [ "$(cat "$dir/out")" = "${3-$2}" ]
}
# offers LINE WORD...: these are among the candidates
offers() {
    completed "$1"
    line=$1
    shift
    for word in "$@"; do check "completion: $line offers $word" sh -c "tr ' ' '\n' <'$dir/out' | grep -qxF -e '$word'"; done
}
completes "servobus sc" "scan"
completes "servobus --v" "--version"
completes "servobus help res" "restore"
completes "servobus fly " ""
completes "servobus map " "zlac8015d yako-closed-loop yako-open-loop c630s"
completes "servobus read p " "zlac8015d yako-closed-loop yako-open-loop c630s raw"
completes "servobus backup p " "zlac8015d yako-closed-loop yako-open-loop c630s"
completes "servobus alarms " "c630s"
completes "servobus completion " "bash"
completes "servobus map zlac8015d " ""
completes "servobus read tcp://10.0.0.1:4001 za" ""
completes "servobus read tcp://10.0.0.1:4001 zl" "zlac8015d"
completes "servobus read mbap://[::1] zlac8015d:3 bus_v" "bus_voltage"
completes "servobus read tc" "-o nospace: tcp://"
completes "servobus scan mbap:" "-o nospace: //" "-o nospace: mbap://"
completes "servobus read ./dri" "-o default: "
completes "servobus restore p c630s:1 " "-o default: "
completes "servobus backup p c630s > " "-o default: "
completes "servobus read p zlac8015d bus_voltage --log " "-o default: "
completes "servobus read p zlac8015d:1 software_v" "software_version"
completes "servobus read p zlac8015d software_version software_v" ""
completes "servobus read p --retries 2 zlac8015d bus_v" "bus_voltage"
completes "servobus read p --retries=2 zlac8015d bus_v" "bus_voltage"
completes "servobus read p raw " ""
completes "servobus write p zlac8015d:1 left_max_c" "-o nospace: left_max_current="
completes "servobus write p zlac8015d bus_v" "-o nospace: "
completes "servobus write p zlac8015d left_max_current=" ""
completes "servobus write p zlac8015d control_word=qu" "quick_stop" "control_word=quick_stop"
completes "servobus write p yako-closed-loop rs485_format=" "8N1 8N2 8E1 8O1" \
    "rs485_format=8N1 rs485_format=8N2 rs485_format=8E1 rs485_format=8O1"
completes "servobus read p zlac8015d --format 8N" "8N1 8N2"
completes "servobus read p zlac8015d --format=8E" "8E1" "--format=8E1"
completes "servobus sim zlac8015d --echo " "on off"
completes "servobus sim zlac8015d --faults " "-o nospace: late lossy noisy doubled cut unplugged none"
completes "servobus sim zlac8015d --faults late,l" "-o nospace: late,lossy"
completes "servobus scan p --format=8N1,8O" "-o nospace: 8N1,8O1" "-o nospace: --format=8N1,8O1"
completes "servobus restore p c630s f --dry-run --d" ""
completes "servobus restore p c630s f --d" "--dry-run"
offers "servobus " map restore --help
offers "servobus read " tcp:// mbap://
offers "servobus write p yako-closed-loop input_polarity=" x0 x1
offers "servobus write p yako-closed-loop input_polarity=x0+" x0+x1
# has_registers PREFIX SUFFIX WITHOUT: the candidates are the registers of the map but those of this access
has_registers() {
    sed "s/^$1//" "$dir/out" | tr ' ' '\n' >"$dir/lines"
    "$tool" map "$device" | awk -F, -v without="$3" -v suffix="$2" 'NR > 1 && $5 != without { print $2 suffix }' |
        diff - "$dir/lines"
}
for device in zlac8015d yako-closed-loop yako-open-loop c630s; do
    completed "servobus read p $device "
    check "completion: every register of $device that can be read" has_registers "" "" wo
    completed "servobus write p $device "
    check "completion: every register of $device that can be written" has_registers "-o nospace: " = ro
done
# As a person types it.
here=$(cd "$parts" && pwd)
mkdir -p "$dir/bin" && ln -sf "$(realpath "$tool")" "$dir/bin/servobus"
printf '%s\n' "PATH=$dir/bin:\$PATH" ". <(servobus completion bash)" "bind 'set bell-style none'" >"$dir/rc"
typed() { # KEYS EXPECTED
    (cd "$dir" && timeout 60 python3 -B "$here/typed.py" "$dir/rc" "$1") >"$dir/out" 2>"$dir/err"
    check "typed in bash: $2" [ "$(cat "$dir/out")" = "$2|" ]
}
tab=$(printf '\t')
typed "servobus wri${tab}p zlac8015d:1 control_w${tab}qu${tab}" "servobus write p zlac8015d:1 control_word=quick_stop "
typed "servobus read tcp://h:1 zl${tab}bus_v${tab}--log=help${tab}" "servobus read tcp://h:1 zlac8015d bus_voltage --log=help "
