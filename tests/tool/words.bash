# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# What bash would complete a command line with, from the function of the script alone:
#   bash tests/tool/words.bash SCRIPT TOOL BREAKS LINE [TYPE]
# The line is broken into words at blanks and at each run of the characters in BREAKS, as readline does it with
# COMP_WORDBREAKS. TYPE is COMP_TYPE: 9 for the first tab, which is the default, 63 for the list after a second. Prints
# the options of compopt, if there are any, then the candidates, all in one line.
. "$1" || exit 2
tool=$2 breaks=$3 line=$4
compopt() { said+=("$*"); } # the builtin works only while readline completes
said=()
COMP_WORDS=()
word="" kind=blank
for ((i = 0; i < ${#line}; i++)); do
    c=${line:i:1}
    case $c in
    ' ') now=blank ;;
    *) if [[ $breaks == *"$c"* ]]; then now=break; else now=word; fi ;;
    esac
    if [ $now != $kind ] && [ $kind != blank ]; then COMP_WORDS+=("$word"); word=""; fi
    [ $now = blank ] || word+=$c
    kind=$now
done
COMP_WORDS+=("$word") # empty after a blank
COMP_TYPE=${5:-9} COLUMNS=80
COMP_CWORD=$((${#COMP_WORDS[@]} - 1)) COMP_LINE=$line COMP_POINT=${#line}
_servobus "$tool" "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD - 1]}"
echo "${said[*]}${said[*]:+: }${COMPREPLY[*]}"
