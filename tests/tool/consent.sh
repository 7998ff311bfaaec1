# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Part of tests/tool.sh: restore asks for consent if standard input is a terminal. script(1) provides one.

# at_terminal ANSWER ARGUMENTS...
at_terminal() {
    answer=$1
    shift
    { sleep 1; echo "$answer"; } | script -qec "'$tool' $*" /dev/null >"$dir/out" 2>&1
    status=$?
    : >"$dir/err"
}

if command -v script >/dev/null; then
    start_sim zlac8015d
    "$tool" backup "$drive" zlac8015d "$dir/good" 2>/dev/null
    "$tool" write "$drive" zlac8015d left_max_current=12.5 >/dev/null 2>&1
    at_terminal yes restore "$drive" zlac8015d "$dir/good"
    check "any other word is none" grep -q 'not confirmed, nothing was written' "$dir/out"
    check "and status 1" status_is 1
    check "the count of writes is printed before the question" \
        sh -c "grep -n 'EEPROM\|Type restore' '$dir/out' | head -n 1 | grep -q EEPROM"
    check "progress is a line that moves" grep -q 'reading: 86 of 86' "$dir/out"
    succeeds "nothing indeed" "left_max_current=12.5 A" read "$drive" zlac8015d left_max_current
    at_terminal restore restore "$drive" zlac8015d "$dir/good"
    check "typed consent" status_is 0
    succeeds "and it is done" "left_max_current=30.0 A" read "$drive" zlac8015d left_max_current
    "$tool" write "$drive" zlac8015d left_max_current=12.5 >/dev/null 2>&1
    at_terminal '' restore "$drive" zlac8015d "$dir/good" --yes
    check "--yes is not asked" sh -c "! grep -q 'Type restore' '$dir/out'"
    check "and done" status_is 0
else
    echo "skipped, there is no script(1)"
fi
