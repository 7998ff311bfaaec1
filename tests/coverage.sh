#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Builds and runs the tests with clang's source coverage; installs missing packages first (Debian, Ubuntu).
# Prints for each header of the library the share of its lines and branches that ran, and then those that did not run
# and are not explained in coverage_left_out.txt. The status is 1 if there are any, or if an explanation is obsolete.
#     sh tests/coverage.sh [FILE...]   only these headers, such as line/line.hpp modbus/pdu.hpp
#   CXX        a clang++, whose branches are those of the source; those of g++ belong to the machine code
#   CXXFLAGS   flags after the usual ones
#   BUILD      where to build; a temporary directory if not given
#   JOBS       compilers at a time, 2 if not given
# The counts of all sources and of all uses of a template are added: a line ran if it ran for one of its types.
# coverage.md explains what is counted and how to read it.
set -u
cd "$(dirname "$0")/.." || exit 1

. tests/support/install.sh

if [ -n "${BUILD:-}" ]; then
    build=$BUILD
    mkdir -p "$build" || exit 1
else
    build=$(mktemp -d)
    trap 'rm -rf "$build"' EXIT
fi

CXX=${CXX:-clang++}
command -v "${CXX%% *}" >/dev/null 2>&1 || must_install "$(echo "${CXX%% *}" | sed 's/^clang++/clang/')" libc6-dev
version=$($CXX -dumpversion | cut -d. -f1)
links_profile() {
    echo 'int main() {}' | $CXX -x c++ -fprofile-instr-generate - -o "$build/probe" 2>/dev/null
}
links_profile || must_install "libclang-rt-$version-dev"
tools=$(dirname "$(readlink -f "$(command -v "${CXX%% *}")")")
command -v "$tools/llvm-cov" >/dev/null 2>&1 || must_install "llvm-$version"
command -v python3 >/dev/null 2>&1 || must_install python3
if ! echo '#include <doctest/doctest.h>' | $CXX -x c++ -std=c++20 -fsyntax-only - 2>/dev/null; then
    must_install doctest-dev
fi

# Names of sources are plain, so that word splitting is harmless.
flags="-std=c++20 -O1 -fprofile-instr-generate -fcoverage-mapping -D_GLIBCXX_ASSERTIONS"
flags="$flags -DDOCTEST_CONFIG_SUPER_FAST_ASSERTS -Iinclude -I. ${CXXFLAGS:-}"
sources=$(ls tests/run/*.cpp tests/run/*/*.cpp tests/static/*.cpp)
objects=""
for source in $sources; do
    objects="$objects $build/$(echo "${source%.cpp}" | tr / _).o"
done
rm -f $objects
echo "coverage.sh: building $(echo "$sources" | wc -l) sources with $CXX"
echo "$sources" | xargs -P "${JOBS:-2}" -I{} sh -c '
    source=$1; build=$2; shift 2
    "$@" -c "$source" -o "$build/$(echo "${source%.cpp}" | tr / _).o" || exit 1' \
    compile {} "$build" $CXX $flags || exit 1
$CXX $flags $objects -o "$build/tests" || exit 1

LLVM_PROFILE_FILE="$build/raw" "$build/tests" || exit 1
"$tools/llvm-profdata" merge -sparse "$build/raw" -o "$build/profile" &&
    "$tools/llvm-cov" export -format=lcov -instr-profile="$build/profile" "$build/tests" >"$build/lines" &&
    "$tools/llvm-cov" export -format=text -instr-profile="$build/profile" "$build/tests" >"$build/branches" || exit 1

exec python3 -B tests/coverage.py "$build/lines" "$build/branches" "$@"
