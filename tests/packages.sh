#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# The packages that examples/packages/make.sh makes of the work tree: twice the same bytes, refused from a dirty tree,
# the version that of CMakeLists.txt, and each used as its ecosystem uses it. What stands in for an ecosystem that
# cannot be installed here is in tests/packages/, and examples/packages/README.md says so. Installs missing packages
# (Debian, Ubuntu).   sh tests/packages.sh
set -u
cd "$(dirname "$0")/.." || exit 1

. tests/support/install.sh

need() { # COMMAND PACKAGE...
    command=$1
    shift
    command -v "$command" >/dev/null 2>&1 || must_install "$@"
}
need git git
need g++ g++
need clang++ clang libc6-dev
need arm-none-eabi-g++ gcc-arm-none-eabi libnewlib-arm-none-eabi libstdc++-arm-none-eabi-newlib
need x86_64-w64-mingw32-g++ g++-mingw-w64-x86-64
need cmake cmake
need unzip unzip
need arduino-builder arduino-builder arduino-ctags
[ -e /usr/share/arduino/hardware/arduino/avr ] || must_install arduino-core-avr
[ -e /usr/lib/avr/include/avr/io.h ] && command -v avr-g++ >/dev/null 2>&1 || must_install gcc-avr avr-libc binutils-avr
# Debian's own Python: it is the one that has Debian's modules.
debian_python=/usr/bin/python3
$debian_python -c 'import yaml' 2>/dev/null || must_install python3 python3-yaml
$debian_python -c 'import kconfiglib' 2>/dev/null || must_install python3-kconfiglib
. tests/support/avr.sh
[ -n "$clang_avr" ] || { echo "packages.sh: no clang for AVR can be installed"; exit 1; }

root=$(pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
log=$work/log
. tests/support/checks.sh

. tests/support/work_tree.sh
version=$(sed -n 's/^project(servobus VERSION \([0-9.]*\) .*/\1/p' CMakeLists.txt)
make_in() { # TREE OUT
    sh "$1/examples/packages/make.sh" "$2"
}
listed() { # FOLDER: names, modes, times and sums
    (cd "$1" && find . -type f -printf '%p %m %T@\n' | sort && find . -type f -exec sha256sum {} + | sort)
}

# ---- made twice
out=$work/out
check "packages are made" make_in "$tree" "$out"
elsewhere_again() {
    mkdir "$work/elsewhere" && git clone -q "$tree" "$work/elsewhere/again" &&
        git -C "$work/elsewhere/again" config core.autocrlf true &&
        (umask 077 && cd / && TZ=Asia/Tokyo LC_ALL=C make_in "$work/elsewhere/again" "$work/again") &&
        listed "$out" >"$work/first" && listed "$work/again" >"$work/second" &&
        [ "$(wc -l <"$work/first")" -ge 30 ] && diff "$work/first" "$work/second"
}
check "from another clone, umask, time zone and line endings: the same bytes, modes and times" elsewhere_again
made_over() {
    make_in "$tree" "$out" && listed "$out" >"$work/second" && diff "$work/first" "$work/second"
}
check "over those of an earlier run: the same" made_over
by_default() {
    sh "$work/elsewhere/again/examples/packages/make.sh" &&
        listed "$work/elsewhere/again/build/packages" >"$work/second" && diff "$work/first" "$work/second"
}
check "without OUT: in build/packages, which git ignores" by_default
of_another_time() {
    SOURCE_DATE_EPOCH=1000000000 make_in "$tree" "$work/timed" &&
        [ "$(stat -c %Y "$work/timed/single/servobus.hpp")" = 1000000000 ] &&
        unzip -Zs "$work/timed/servobus-$version-arduino.zip" | grep -q '01-Sep-09 ' &&
        tar tvzf "$work/timed/servobus-$version.tar.gz" --utc | grep -q '2001-09-09 01:46' &&
        ! tar tvzf "$work/timed/servobus-$version.tar.gz" --utc | grep -qv '2001-09-09 01:46'
}
check "SOURCE_DATE_EPOCH is the time of all files" of_another_time

# ---- refused: one line on standard error, this status, and OUT as it was
refused() { # STATUS TEXT COMMAND...
    status=$1
    text=$2
    shift 2
    "$@" >"$work/said" 2>"$work/line"
    got=$?
    cat "$work/said" "$work/line"
    [ "$got" = "$status" ] || { echo "status $got, not $status"; return 1; }
    [ ! -s "$work/said" ] && [ "$(wc -l <"$work/line")" = 1 ] && grep -qF -e "make.sh: $text" "$work/line" || return 1
    listed "$out" >"$work/second" && diff "$work/first" "$work/second" || return 1
    [ -z "$(find "$work" -maxdepth 1 -name '.*-*')" ] || { echo "a folder is left"; return 1; }
}
dirty() { # TEXT COMMAND...: the tree after the command
    text=$1
    shift
    "$@" || return 1
    refused 2 "the tree is dirty: commit or remove $text" make_in "$tree" "$out"
    result=$?
    git -C "$tree" reset -q --hard && git -C "$tree" clean -q -f -d && return $result
}
changed() { echo "// changed" >>"$tree/include/servobus/servobus.hpp"; }
staged() { changed && git -C "$tree" add -A; }
removed() { rm "$tree/README.md"; }
untracked() { echo "#pragma once" >"$tree/include/servobus/new.hpp"; }
two_changes() { changed && untracked; }
check "refused: a changed file" dirty include/servobus/servobus.hpp changed
check "refused: a change that is staged" dirty include/servobus/servobus.hpp staged
check "refused: a file that was removed" dirty README.md removed
check "refused: a file that git does not know" dirty include/servobus/new.hpp untracked
check "refused: two changes, in one line" dirty "include/servobus/servobus.hpp and 1 more" two_changes
echo "something else" >"$work/file"
mkdir "$work/foreign" && echo "something else" >"$work/foreign/notes.txt"
check "refused: OUT is a file" refused 1 "$work/file is not a folder" make_in "$tree" "$work/file"
check "refused: OUT in a file" refused 1 "$work/file/out cannot be written" make_in "$tree" "$work/file/out"
check "refused: OUT where nothing can be written" refused 1 "/proc/out cannot be written" make_in "$tree" /proc/out
check "refused: OUT with other files" refused 1 "$work/foreign has files that are not of an earlier run" \
    make_in "$tree" "$work/foreign"
check "refused: two folders" refused 2 "usage:" sh "$tree/examples/packages/make.sh" "$out" "$out"
check "refused: a folder without a name" refused 2 "usage:" make_in "$tree" ""
check "refused: an unknown option" refused 2 "usage:" sh "$tree/examples/packages/make.sh" --fast
for time in today 4354819200; do
    check "refused: the time $time" refused 2 "SOURCE_DATE_EPOCH is not a number of seconds until 2107: $time" \
        env SOURCE_DATE_EPOCH=$time sh "$tree/examples/packages/make.sh" "$out"
done
no_room() { (ulimit -f 64 && make_in "$tree" "$out"); }
check "refused: a file that cannot be written whole" refused 1 "$out cannot be written" no_room
# At whatever point it is stopped: OUT is as it was, and nothing is left beside it.
stopped() {
    for seconds in 0.2 0.4 0.6 0.8 1.0 1.2; do
        timeout "$seconds" sh "$tree/examples/packages/make.sh" "$out" >"$work/said" 2>"$work/line"
        got=$?
        listed "$out" >"$work/second" && diff "$work/first" "$work/second" || return 1
        [ -z "$(find "$work" -maxdepth 1 -name '.*-*')" ] || { echo "a folder is left"; return 1; }
        [ $got = 0 ] || [ ! -s "$work/line" ] || [ "$(cat "$work/line")" = "make.sh: stopped" ] ||
            { cat "$work/line"; return 1; }
    done
}
check "stopped by a signal: OUT as it was" stopped
mkdir "$work/bin" && for tool in sh dirname; do ln -s "$(command -v $tool)" "$work/bin/$tool"; done
ln -s "$(python3 -c 'import sys; print(sys.executable)')" "$work/bin/python3"
check "refused: no git" refused 1 "git is needed" \
    env PATH="$work/bin" sh "$tree/examples/packages/make.sh" "$out"
unpacked=$work/unpacked/servobus-$version
mkdir "$work/unpacked" && tar xzf "$out/servobus-$version.tar.gz" -C "$work/unpacked"
check "refused: the unpacked source archive, which is no checkout" \
    refused 2 "$unpacked is not a git checkout with a commit" make_in "$unpacked" "$out"
git -C "$work/unpacked" init -q
check "refused: a folder in another checkout" \
    refused 2 "$unpacked is not a git checkout of its own" make_in "$unpacked" "$out"

# ---- the version
unpack() { # OUT VERSION FOLDER
    mkdir "$3" "$3/arduino" && unzip -q "$1/servobus-$2-arduino.zip" -d "$3/arduino" &&
        for kind in platformio zephyr esp-idf; do
            mkdir "$3/$kind" && tar xzf "$1/servobus-$2-$kind.tar.gz" -C "$3/$kind" || return 1
        done
}
manifests() { # OUT VERSION FOLDER
    $debian_python -B tests/packages/manifests.py "$2" "$3/arduino/servobus" "$3/platformio/servobus" \
        "$3/zephyr/servobus" "$3/esp-idf/servobus" "$1/vcpkg/servobus"
}
check "each archive can be unpacked" unpack "$out" "$version" "$work/used"
check "the manifests have their form, and version $version" manifests "$out" "$version" "$work/used"
another_version() {
    sed -i 's/^project(servobus VERSION [0-9.]* /project(servobus VERSION 7.8.9 /' "$tree/CMakeLists.txt" &&
        commit "Another version" && make_in "$tree" "$work/out789" && git -C "$tree" reset -q --hard HEAD~ || return 1
    unpack "$work/out789" 7.8.9 "$work/used789" && manifests "$work/out789" 7.8.9 "$work/used789" &&
        grep -q '^    version = "7.8.9"$' "$work/out789/conan/conanfile.py" &&
        grep -q '^// servobus 7.8.9: ' "$work/out789/single/servobus_yako.hpp" &&
        grep -q '^#define SERVOBUS_SINGLE_HEADER_VERSION 7008009$' "$work/out789/single/servobus_yako.hpp" || return 1
    # Nothing else says the version: the old one is only in what the commit itself has in other files.
    (cd "$work/out789" && ! find . -name "*$version*" | grep .) &&
        ! grep -rlF "$version" "$work/out789/vcpkg/servobus/vcpkg.json" "$work/out789/vcpkg/servobus/portfile.cmake" \
            "$work/out789/conan/conanfile.py" "$work/out789/single"
}
check "another version in CMakeLists.txt: that of all packages" another_version

# ---- single headers
strict="-std=c++20 -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror -fno-exceptions -fno-rtti -I$out/single -I."
alone() { # COMPILER HEADER [DRIVE COMMANDS]
    $1 $strict "-DSINGLE_HEADER=<$2>" ${3:+"-DDRIVE=$3" "-DCOMMANDS=$4"} \
        -c tests/packages/single/alone.cpp -o "$work/alone.o"
}
linked() { # COMPILER LINK-OPTIONS
    for source in one two; do
        $1 $strict -c tests/packages/single/$source.cpp -o "$work/$source.o" || return 1
    done
    $1 "$work/one.o" "$work/two.o" $2 -o "$work/single"
}
for compiler in g++ clang++ "arm-none-eabi-g++ -mcpu=cortex-m4 -mthumb" x86_64-w64-mingw32-g++; do
    by=${compiler%% *}
    check "$by: servobus.hpp alone" alone "$compiler" servobus.hpp
    check "$by: servobus_zlac8015d.hpp alone" alone "$compiler" servobus_zlac8015d.hpp zlac8015d::drive zlac8015d
    check "$by: servobus_yako.hpp alone" alone "$compiler" servobus_yako.hpp yako::closed_loop::drive yako
    check "$by: servobus_c630s.hpp alone" alone "$compiler" servobus_c630s.hpp c630s::drive c630s
    case $by in
    arm-*) check "$by: all in two orders, linked" linked "$compiler" --specs=nosys.specs ;;
    x86_64-w64-*) check "$by: all in two orders, linked" linked "$compiler" "" ;;
    *)
        check "$by: servobus_posix.hpp alone" alone "$compiler" servobus_posix.hpp
        check "$by: all in two orders, linked" linked "$compiler" ""
        check "$by: the program of both sources runs" "$work/single"
        ;;
    esac
done
check "g++: servobus.hpp computes no table of a CRC" sh -c \
    "echo '#include <servobus.hpp>' | g++ -std=c++20 -I$out/single -fsyntax-only -fconstexpr-ops-limit=2000 -x c++ -"
two_versions() {
    mkdir "$work/mixed" && cp "$out/single/servobus_yako.hpp" "$work/mixed/old.hpp" &&
        cp "$work/out789/single/servobus.hpp" "$work/mixed/new.hpp" &&
        ! printf '#include <old.hpp>\n#include <new.hpp>\n' |
        g++ -std=c++20 -I"$work/mixed" -fsyntax-only -x c++ - 2>"$work/said" &&
        grep -q 'servobus: single headers of two versions' "$work/said"
}
check "single headers of two versions: an error that says so" two_versions

# The README's programs, with single headers instead of those that they include.
readme_programs() { # COMPILER
    rm -f "$work"/program*.cpp
    awk -v work="$work" '/^```cpp$/ { inside = 1; file = sprintf("%s/program%d.cpp", work, NR); next }
                         /^```$/ { inside = 0 }
                         inside { print > file }' README.md
    count=0
    for program in "$work"/program*.cpp; do
        sed -i -E 's|<servobus/device/(\w+)\.hpp>|<servobus_\1.hpp>|
            s|<servobus/posix/serial\.hpp>|<servobus_posix.hpp>|; s|<servobus/servobus\.hpp>|<servobus.hpp>|' "$program"
        ! grep '<servobus/' "$program" || return 1
        $1 -std=c++20 -O1 -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror -I"$out/single" \
            -c "$program" -o "$work/program.o" || return 1
        count=$((count + 1))
    done
    [ "$count" -ge 3 ]
}
check "g++: the README's first programs with single headers" readme_programs g++
check "clang++: the README's first programs with single headers" readme_programs clang++
cannot_join() { # TEXT LINE: a header with this line at its end is refused
    echo "$2" >>"$tree/include/servobus/core/slice.hpp" && commit "A header that cannot be joined" &&
        refused 1 "$1" make_in "$tree" "$out"
    result=$?
    git -C "$tree" reset -q --hard HEAD~ && return $result
}
check "refused: a header with an include of ours after its code" \
    cannot_join "core/slice.hpp:" '#include <servobus/core/bytes.hpp>'
check "refused: a header with an include in quotes" cannot_join "core/slice.hpp:" '#include "bytes.hpp"'

# ---- Arduino: Debian's arduino-builder and AVR core. The compiler for the sketch is clang.
mkdir -p "$work/arduino/hardware" "$work/arduino/tools" "$work/arduino/bin"
cp -r /usr/share/arduino/hardware/arduino "$work/arduino/hardware/"
for tool in avr-gcc avr-gcc-ar avr-objcopy avr-size; do ln -s "$(command -v $tool)" "$work/arduino/bin/$tool"; done
ln -s "$root/tests/packages/arduino/cxx" "$work/arduino/bin/cxx"
sketch() { # LINE-OF-PLATFORM.LOCAL.TXT: builds the package's example, which has to find the library in the zip
    printf '%s\n' "compiler.path=$work/arduino/bin/" compiler.cpp.cmd=cxx \
        compiler.c.elf.extra_flags=-Wl,--no-relax "$@" >"$work/arduino/hardware/arduino/avr/platform.local.txt"
    rm -rf "$work/arduino/build" && mkdir "$work/arduino/build" &&
        CLANG_AVR=$clang_avr LIBSTDCPP=$libstdcpp arduino-builder -compile -hardware "$work/arduino/hardware" \
            -hardware /usr/share/arduino-builder -tools "$work/arduino/tools" -libraries "$work/used/arduino" \
            -fqbn arduino:avr:mega:cpu=atmega2560 -build-path "$work/arduino/build" -warnings all \
            "$work/used/arduino/servobus/examples/wheels/wheels.ino" >"$work/built" 2>&1
}
arduino_builds() {
    sketch compiler.cpp.extra_flags=-std=gnu++20 || { cat "$work/built"; return 1; }
    ! grep -E 'servobus/.*warning:' "$work/built" && avr-size "$work/arduino/build/wheels.ino.elf" &&
        [ "$(stat -c %s "$work/arduino/build/wheels.ino.hex")" -gt 20000 ]
}
check "arduino-builder: the example, from the zip by #include <servobus.h>" arduino_builds
arduino_needs_cpp20() { ! sketch && grep -q 'error.*servobus needs C++20: -std=gnu++20' "$work/built"; }
check "arduino-builder: without -std=gnu++20, an error that names it" arduino_needs_cpp20

sketch_drives() {
    g++ -std=gnu++20 -O1 -Wall -Wextra -Werror -isystem tests/ports/stubs/arduino -I"$work/used/arduino/servobus/src" \
        "-DSKETCH=\"$work/used/arduino/servobus/examples/wheels/wheels.ino\"" tests/packages/arduino/sketch.cpp \
        -o "$work/sketch" && "$work/sketch"
}
check "Arduino: the example with a simulated drive, restarted and out of reach" sketch_drives

# ---- PlatformIO: a stand-in, the include path that a library with include/ gets
check "PlatformIO: a program with the package's include path" g++ -std=gnu++20 -Wall -Wextra -Werror \
    -I"$work/used/platformio/servobus/include" -c tests/packages/user/main.cpp -o "$work/pio.o"
# After an Arduino.h that includes a standard header before it defines its macros; they are there again afterwards.
shim_in_program() { # COMPILER
    printf '%s\n' '#include "tests/freestanding/arduino_macros.hpp"' '#include <servobus.h>' \
        '#include <servobus/device/zlac8015d.hpp>' 'int least = min(1, 2), most = max(1, 2);' |
        $1 -std=gnu++20 -Wall -Wextra -Werror -I. -I"$work/used/platformio/servobus/include" -fsyntax-only -x c++ -
}
for compiler in g++ clang++ arm-none-eabi-g++; do
    check "$compiler: servobus.h after the macros of an Arduino.h" shim_in_program $compiler
done

# ---- Zephyr: stand-ins for its CMake and its symbols
user=$root/tests/packages/user/main.cpp
zephyr_app() { # CONFIGURATION
    cmake -S tests/packages/zephyr -B "$work/zephyr$1" "-DMODULE_CMAKE=$work/used/zephyr/servobus/zephyr" \
        "-DUSER_SOURCE=$user" -DCONFIG_SERVOBUS="$1" && cmake --build "$work/zephyr$1"
}
zephyr_on() { zephyr_app y && "$work/zephyry/app"; }
zephyr_off() { ! zephyr_app "" >"$work/said" 2>&1 && grep -q 'servobus/.*No such file' "$work/said"; }
check "Zephyr: an application with CONFIG_SERVOBUS" zephyr_on
check "Zephyr: without it, no header is found" zephyr_off
check "Zephyr: Kconfig asks for C++20 and a full library" \
    $debian_python -B tests/packages/zephyr/kconfig.py "$work/used/zephyr/servobus/zephyr/Kconfig"

# ---- ESP-IDF: stand-ins for its CMake; both with the package and with a checkout
esp_idf() { # COMPONENT
    cmake "-DCOMPONENT=$1" -P tests/packages/esp_idf/requirements.cmake >"$work/said" 2>&1
    cat "$work/said"
    grep -q 'registered: INCLUDE_DIRS;include' "$work/said" && rm -rf "$work/esp" &&
        cmake -S tests/packages/esp_idf -B "$work/esp" "-DCOMPONENT=$1" "-DUSER_SOURCE=$user" &&
        cmake --build "$work/esp" && "$work/esp/app"
}
check "ESP-IDF: the package as a component" esp_idf "$work/used/esp-idf/servobus"
check "ESP-IDF: the repository as a component" esp_idf "$tree"

# ---- vcpkg and Conan: stand-ins for their functions
vcpkg() { # PORT-FOLDER
    rm -rf "$work/vcpkg" && mkdir -p "$work/vcpkg/trees" "$work/vcpkg/packages" &&
        cmake "-DPORTFILE=$1/portfile.cmake" -DPORT=servobus "-DCURRENT_BUILDTREES_DIR=$work/vcpkg/trees" \
            "-DCURRENT_PACKAGES_DIR=$work/vcpkg/packages" -P tests/packages/vcpkg.cmake
}
vcpkg_installs() {
    vcpkg "$out/vcpkg/servobus" || return 1
    installed=$work/vcpkg/packages
    for file in include/servobus/servobus.hpp share/servobus/servobus-config.cmake share/servobus/copyright \
        share/servobus/usage share/pkgconfig/servobus.pc; do
        [ -s "$installed/$file" ] || { echo "no $file"; return 1; }
    done
    [ ! -e "$installed/debug" ] && [ ! -e "$installed/lib" ] && [ ! -e "$installed/bin" ] &&
        cmp LICENSE "$installed/share/servobus/copyright" &&
        mv "$installed" "$work/vcpkg/moved" && # vcpkg moves what it installs
        cmake -S examples/packages/conan/test_package -B "$work/vcpkg/user" \
            "-DCMAKE_PREFIX_PATH=$work/vcpkg/moved" &&
        cmake --build "$work/vcpkg/user" && "$work/vcpkg/user/user"
}
check "vcpkg: the port installs, and a program finds it" vcpkg_installs
mkdir "$work/damaged" && cp -r "$out/vcpkg/servobus" "$out/conan" "$work/damaged/"
for archive in "$work/damaged"/*/*.tar.gz; do echo >>"$archive"; done
vcpkg_refuses() {
    ! vcpkg "$work/damaged/servobus" >"$work/said" 2>&1 &&
        tr -s ' \n' ' ' <"$work/said" | grep -q 'not the archive that this port was made with'
}
check "vcpkg: another archive than the port's is refused" vcpkg_refuses
check "Conan: the recipe makes a package, and its test passes" \
    python3 -B tests/packages/conan.py "$out/conan" "$work/conan"
conan_refuses() { # FOLDER CPPSTD TEXT
    ! python3 -B tests/packages/conan.py "$1" "$work/conan$2" "$2" >"$work/said" 2>&1 &&
        grep -q "ERROR: .*$3" "$work/said"
}
check "Conan: another archive than the recipe's is refused" conan_refuses "$work/damaged/conan" 23 'sha256'
check "Conan: C++17 is refused" conan_refuses "$out/conan" 17 'C++20 is needed'

# ---- the source archive is the commit
whole() {
    git -C "$tree" archive HEAD | tar xf - -C "$work/whole" && diff -r "$work/whole" "$work/archived/servobus-$version"
}
mkdir "$work/whole" "$work/archived" && tar xzf "$out/servobus-$version.tar.gz" -C "$work/archived"
check "the source archive has the files of the commit" whole

echo "packages.sh: $checks checks, $failed failed"
[ "$failed" = 0 ]
