# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Part of tests/tool.sh: files that restore refuses before it sends anything.

start_sim zlac8015d
"$tool" backup "$drive" zlac8015d "$dir/good" 2>/dev/null
"$tool" write "$drive" zlac8015d left_max_current=12.5 >/dev/null 2>&1 # so that a restore would change it
"$tool" backup "$drive" zlac8015d "$dir/held" 2>/dev/null

# refused NAME WORDS: $dir/bad is refused, and the drive is as it was
refused() {
    fails "a file that $1 is refused" 2 "$2" restore "$drive" zlac8015d "$dir/bad" --yes
    "$tool" backup "$drive" zlac8015d 2>/dev/null | cmp -s - "$dir/held"
    check "and the drive is as it was" [ $? -eq 0 ]
}
# edited SCRIPT...: $dir/bad is the good file, edited, with a matching checksum
edited() {
    sed "$@" "$dir/good" >"$dir/bad"
    fix_checksum zlac8015d "$dir/bad"
}

echo "left_max_current=300" >"$dir/bad"
refused "is no backup" "it is no backup file"
: >"$dir/bad"
refused "is empty" "it is no backup file"
edited 's/device=zlac8015d/device=c630s/'
refused "is of another drive" "it is of a c630s, not of a zlac8015d"
edited 's/format=1/format=2/'
refused "has another format" "it has format '2', not 1"
edited 's/^left_max_current=/left_most_current=/'
refused "has an unknown name" "zlac8015d has no register 'left_most_current'"
edited '/^left_max_current=/d; s/rows=88/rows=87/'
refused "lacks a name" "left_max_current is missing"
edited '/^left_max_current=/d'
refused "lacks a row" "left_max_current is missing"
edited 's/rows=88/rows=89/'
refused "has another number of rows" "another number of rows than its 88"
edited 's/^left_max_current=[0-9]*/left_max_current=301/'
refused "has a value out of range" "left_max_current: 301 is outside 0 .. 300"
edited 's/^left_max_current=[0-9]*/left_max_current=30.0/'
refused "has no whole number" "left_max_current: '30.0' is no whole number"
edited 's/^left_max_current=/left_max_current /'
refused "has another line" "is no name=number"
edited 's/^left_max_current=.*/bus_voltage=2400/'
refused "has a read-only register" "bus_voltage is ro, no parameter"
edited 's/^left_max_current=.*/&\n&/; s/rows=88/rows=89/'
refused "has a register twice" "left_max_current is there twice"
sed 's/^left_max_current=[0-9]*/left_max_current=299/' "$dir/good" >"$dir/bad"
refused "was edited" "it was changed or damaged: its checksum is"
sed '$d' "$dir/good" >"$dir/bad"
refused "has no last line" "it is truncated"
head -c 1000 "$dir/good" >"$dir/bad"
refused "is cut" "it is truncated"
head -c -1 "$dir/good" >"$dir/bad"
refused "lacks its last character" "it is truncated"
sed 's/$/\r/' "$dir/good" >"$dir/bad"
refused "has other line ends" "its line ends were changed"
rm "$dir/bad"
refused "does not exist" "cannot read $dir/bad: No such file"
mkdir "$dir/bad"
refused "is a folder" "cannot read $dir/bad"
rmdir "$dir/bad"
edited 's/^left_max_current=.*/&\ncontrol_word=8/; s/rows=88/rows=89/'
run restore "$drive" zlac8015d "$dir/bad"
check "S8: nothing is written before consent" out_is ""
check "S8: and it says so" err_has "not confirmed, nothing was written"
run restore "$drive" zlac8015d "$dir/bad" --yes
check "S7: a trigger in a file is skipped" out_is "left_max_current=30.0 A"
check "and counted" err_has "skipped: 3 rows"
edited 's/^left_max_current=[0-9]*/left_max_current=?/'
"$tool" write "$drive" zlac8015d left_max_current=12.5 >/dev/null 2>&1
run restore "$drive" zlac8015d "$dir/bad" --yes
check "a register marked ? is left alone" out_is ""
check "and said" err_has ", 1 marked ?"
fails "restore takes a file" 2 "restore takes PORT DEVICE[:NODE] FILE" restore "$drive" zlac8015d
fails "restore needs a map" 2 "not raw" restore "$drive" raw "$dir/good"
fails "backup needs a map" 2 "not raw" backup "$drive" raw "$dir/none"
fails "backup takes no interval" 2 "unknown option '--interval'" backup "$drive" zlac8015d --interval 5
