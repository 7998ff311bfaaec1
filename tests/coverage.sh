#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Builds and runs the tests with clang's source coverage; installs what is missing first (Debian, Ubuntu).
# Prints for each header of the library which part of its lines and branches ran, and then what did not.
#     sh tests/coverage.sh [FILE...]   what did not run only in these headers, such as line.hpp modbus/pdu.hpp
#   CXX        a clang++; its branches are the source's, while those of g++ are the machine's code's
#   CXXFLAGS   flags behind the usual ones
#   BUILD      where to build; a temporary directory if not given
#   JOBS       compilers at a time, 2 if not given
# Counts of all sources and of all uses of a template are added up: a line ran if it ran for one of its types.
# coverage.md says what is left out, and how to read what is said not to have run.
set -u
cd "$(dirname "$0")/.." || exit 1

install() {
    echo "coverage.sh: installing $* with apt-get"
    as_root=""
    [ "$(id -u)" = 0 ] || as_root=sudo
    $as_root apt-get update -qq
    DEBIAN_FRONTEND=noninteractive $as_root apt-get install -y -qq --no-install-recommends "$@" >/dev/null || {
        echo "coverage.sh: $* could not be installed"
        exit 1
    }
}

if [ -n "${BUILD:-}" ]; then
    build=$BUILD
    mkdir -p "$build" || exit 1
else
    build=$(mktemp -d)
    trap 'rm -rf "$build"' EXIT
fi

CXX=${CXX:-clang++}
command -v "${CXX%% *}" >/dev/null 2>&1 || install "$(echo "${CXX%% *}" | sed 's/^clang++/clang/')" libc6-dev
version=$($CXX -dumpversion | cut -d. -f1)
links_profile() {
    echo 'int main() {}' | $CXX -x c++ -fprofile-instr-generate - -o "$build/probe" 2>/dev/null
}
links_profile || install "libclang-rt-$version-dev"
tools=$(dirname "$(readlink -f "$(command -v "${CXX%% *}")")")
command -v "$tools/llvm-cov" >/dev/null 2>&1 || install "llvm-$version"
command -v python3 >/dev/null 2>&1 || install python3
if ! echo '#include <doctest/doctest.h>' | $CXX -x c++ -std=c++20 -fsyntax-only - 2>/dev/null; then
    install doctest-dev
fi

# Names of sources are plain, so that word splitting is harmless.
flags="-std=c++20 -O1 -fprofile-instr-generate -fcoverage-mapping -D_GLIBCXX_ASSERTIONS"
flags="$flags -DDOCTEST_CONFIG_SUPER_FAST_ASSERTS -Iinclude -I. ${CXXFLAGS:-}"
sources=$(ls tests/run/*.cpp tests/static/*.cpp)
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

python3 -B - "$build/lines" "$build/branches" "$@" <<'END'
import collections, json, pathlib, re, sys

root = str(pathlib.Path("include/servobus").resolve()) + "/"
lines = collections.defaultdict(dict)  # header -> line -> how often it ran
# header -> place -> how often it was true, and false
branches = collections.defaultdict(lambda: collections.defaultdict(lambda: [0, 0]))

header = None
for record in open(sys.argv[1]):
    key, _, value = record.strip().partition(":")
    if key == "SF":
        path = str(pathlib.Path(value).resolve())
        header = path.removeprefix(root) if path.startswith(root) else None
    elif key == "DA" and header:
        line, ran = map(int, value.split(",")[:2])
        lines[header][line] = lines[header].get(line, 0) + ran
for file in json.load(open(sys.argv[2]))["data"][0]["files"]:
    path = str(pathlib.Path(file["filename"]).resolve())
    if not path.startswith(root):
        continue
    for branch in file["branches"]:
        ran = branches[path.removeprefix(root)][tuple(branch[:4])]
        ran[0] += branch[4]
        ran[1] += branch[5]


def left_out(source):
    """Lines that no program can run: consteval functions, those that only name a rule, closing braces."""
    lines = {n for n, text in enumerate(source.splitlines(), 1) if text.strip() in ("}", "};")}
    for m in re.finditer(r"\bconsteval\b|\bvoid \w+\(\) \{\}", source):
        depth, end = 0, m.start()
        for end in range(m.start(), len(source)):
            depth += {"{": 1, "(": 1, "}": -1, ")": -1}.get(source[end], 0)
            if depth == 0 and source[end] == ";":
                break
            # The braces of a member's initializer end no function.
            if depth == 0 and source[end] == "}" and not re.match(r"\s*[,{(]", source[end + 1 :]):
                break
        lines.update(range(source.count("\n", 0, m.start()) + 1, source.count("\n", 0, end) + 2))
    return lines


def share(some, of):
    return f"{100 * some / of:6.1f} %  {some:5} of {of:5}" if of else "      -" + 17 * " "


def sums(headers):
    ran = sum(n > 0 for h in headers for n in lines[h].values())
    taken = sum((n > 0) for h in headers for ways in branches[h].values() for n in ways)
    return share(ran, sum(len(lines[h]) for h in headers)) + share(
        taken, 2 * sum(len(branches[h]) for h in headers)
    )


headers = sorted(str(p.relative_to(root)) for p in pathlib.Path(root).rglob("*.hpp"))
sources = {h: (pathlib.Path(root) / h).read_text() for h in headers}
for header, source in sources.items():
    text = source.splitlines()
    never = left_out(source)
    lines[header] = {n: ran for n, ran in lines[header].items() if n not in never}
    branches[header] = {
        place: ways
        for place, ways in branches[header].items()
        if place[0] not in never and "if constexpr" not in text[place[0] - 1]
    }
print(f"{'header':40}{'lines':>8}{'branches':>28}")
for header in headers:
    print(f"{header:40}{sums([header])}")
print(f"{'all':40}{sums(headers)}")

wanted = sys.argv[3:] or headers
for header in wanted:
    if not lines[header]:
        continue
    text = sources[header].splitlines()
    for line, ran in sorted(lines[header].items()):
        if ran == 0:
            print(f"{header}:{line}: not run: {text[line - 1].strip()}")
        else:
            for (first, column, last, end), ways in sorted(branches[header].items()):
                if first == line and 0 in ways:
                    condition = " ".join(text[first - 1 : last]).strip()
                    if first == last:
                        condition = text[first - 1][column - 1 : end - 1]
                    never = "neither" if ways == [0, 0] else "never false" if ways[0] else "never true"
                    print(f"{header}:{line}: {never}: {condition}")
END
