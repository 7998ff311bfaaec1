#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Builds the reference as HTML: a start page, the API with the pages of the library, and the register map of each drive
# with a filter.
#
#   sh examples/reference/make.sh OUT
#   SERVOBUS=PATH sh examples/reference/make.sh OUT    with a tool that is built already
#
# OUT/index.html is the start page. It needs doxygen (1.9.4 or newer), python3 and a compiler (CXX); what is missing is
# installed with apt-get on Debian or Ubuntu. A comment of a public header that doxygen cannot read is an error. The
# same headers give the same bytes.
set -u
out=${1:?usage: sh examples/reference/make.sh OUT}
mkdir -p "$out" && out=$(cd "$out" && pwd) || exit 1
tool=${SERVOBUS:-}
[ -z "$tool" ] || tool=$(cd "$(dirname "$tool")" && pwd)/$(basename "$tool")
cd "$(dirname "$0")/../.." || exit 1
here=examples/reference

missing=""
command -v doxygen >/dev/null 2>&1 || missing="$missing doxygen"
command -v python3 >/dev/null 2>&1 || missing="$missing python3"
command -v "${CXX:-g++}" >/dev/null 2>&1 || missing="$missing g++"
if [ -n "$missing" ]; then
    . tests/support/install.sh
    must_install $missing
fi
CXX=${CXX:-g++}

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
version=$(sed -n 's/^project(servobus VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
[ -n "$version" ] || { echo "make.sh: CMakeLists.txt has no version"; exit 1; }

# Only what an earlier run wrote is replaced.
if [ -n "$(ls -A "$out")" ] && ! grep -qF '<title>servobus: reference</title>' "$out/index.html" 2>/dev/null; then
    echo "make.sh: $out is neither empty nor an earlier reference"
    exit 1
fi
rm -rf "$out/api" "$out/index.html" "$out"/map_*.html

echo "make.sh: the API"
mkdir -p "$out/api"
python3 -B $here/comments.py include/servobus "$work/include/servobus" && cp $here/api.dox "$work/include/" &&
    python3 -B $here/pages.py include/servobus "$work/include" || exit 1
{
    cat $here/Doxyfile
    echo "INPUT               = \"$work/include\""
    echo "STRIP_FROM_PATH     = \"$work/include\""
    echo "STRIP_FROM_INC_PATH = \"$work/include\""
    echo "OUTPUT_DIRECTORY    = \"$out/api\""
    echo "PROJECT_NUMBER      = $version"
    echo "GENERATE_TAGFILE    = \"$work/tags\""
    echo "WARN_LOGFILE        = \"$work/warnings\""
} >"$work/Doxyfile"
doxygen "$work/Doxyfile"
status=$?
if [ "$status" -ne 0 ] || [ -s "$work/warnings" ]; then
    sed "s|$work/||" "$work/warnings"
    echo "make.sh: doxygen failed, or has warnings"
    exit 1
fi

# The page of a folder has the hash of its whole path in its name: each gets the name of the folder.
for page in "$out"/api/dir_*.html; do
    folder=$(sed -n 's|.*<title>servobus: \(.*\) Directory Reference</title>.*|\1|p' "$page" | tr / _)
    [ -n "$folder" ] || { echo "make.sh: $page has no title"; exit 1; }
    echo "s/$(basename "$page" .html)/dir_$folder/g" >>"$work/folders"
    mv "$page" "$out/api/dir_$folder.html"
done
(cd "$out/api" && find . \( -name '*.html' -o -name '*.js' \) -exec sed -i -f "$work/folders" {} +) || exit 1

echo "make.sh: the maps"
if [ -z "$tool" ]; then
    tool=$work/servobus
    "$CXX" -std=c++20 -O0 -Iinclude examples/servobus/*.cpp examples/servobus/*/*.cpp -o "$tool" || exit 1
fi
"$CXX" -std=c++20 -O0 -Iinclude $here/values.cpp -o "$work/values" && "$work/values" >"$work/values.tsv" || exit 1
python3 -B $here/maps.py "$out" "$version" "$tool" "$work/values.tsv" "$work/tags" || exit 1
echo "make.sh: $(find "$out" -name '*.html' | wc -l) pages, $(du -sh "$out" | cut -f 1); begin with $out/index.html"
