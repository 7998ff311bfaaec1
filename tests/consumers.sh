#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Programs that use the library as their authors would.   sh tests/consumers.sh PART...
#   copied   a copy of include/
#   cmake    built and installed; add_subdirectory, find_package, FetchContent
#   meson    built and installed; a subproject, pkg-config
set -eu
cd "$(dirname "$0")/.."
root=$(pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
[ $# -gt 0 ] || set -- copied cmake meson

cat >"$work/main.cpp" <<'PROGRAM'
#include <servobus/servobus.hpp>
#include <servobus/device/zlac8015d.hpp>
int main() { return servobus::modbus::write_frame(1, 0x200E, 7).size == 8 ? 0 : 1; }
PROGRAM

copied() {
    mkdir "$work/copied"
    cp -r include/servobus "$work/main.cpp" "$work/copied/"
    (cd "$work/copied" && g++ -std=c++20 -I. main.cpp -o main && ./main)
}

cmake_consumer() { # NAME CMAKE-LINES
    mkdir "$work/$1"
    printf '%s\n' 'cmake_minimum_required(VERSION 3.18)' "project($1 CXX)" "$2" \
        'add_executable(user main.cpp)' 'target_link_libraries(user PRIVATE servobus::servobus)' >"$work/$1/CMakeLists.txt"
    cp "$work/main.cpp" "$work/$1/"
    cmake -S "$work/$1" -B "$work/$1/build" -G Ninja -DCMAKE_PREFIX_PATH="$work/prefix"
    cmake --build "$work/$1/build"
    "$work/$1/build/user"
}
# The tests are built by other checks.
cmake_builds() {
    cmake -S . -B "$work/cmake" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS_RELEASE=-O2 -DCMAKE_CXX_STANDARD=23 \
        -DSERVOBUS_TESTS=OFF -DCMAKE_INSTALL_PREFIX="$work/prefix"
    cmake --build "$work/cmake" -j "${JOBS:-2}"
    cmake --install "$work/cmake"
    sh tests/version.sh "$work/prefix/share/pkgconfig/servobus.pc"
    cmake_consumer by_subdirectory "add_subdirectory($root servobus)"
    cmake_consumer by_find_package 'find_package(servobus REQUIRED)'
    cmake_consumer by_fetch_content "include(FetchContent)
FetchContent_Declare(servobus SOURCE_DIR $root)
FetchContent_MakeAvailable(servobus)"
}

meson_builds() {
    meson setup "$work/meson" . --prefix "$work/meson_prefix"
    meson compile -C "$work/meson" servobus servobus_manual servobus_completion wheels
    meson test -C "$work/meson" --list | grep -q servobus_tests
    meson install -C "$work/meson" --no-rebuild
    sh tests/version.sh "$work/meson_prefix/share/pkgconfig/servobus.pc"
    mkdir -p "$work/meson_user/subprojects"
    ln -s "$root" "$work/meson_user/subprojects/servobus"
    cp "$work/main.cpp" "$work/meson_user/"
    printf '%s\n' "project('user', 'cpp', default_options: ['cpp_std=c++20'])" \
        "executable('user', 'main.cpp', dependencies: dependency('servobus', fallback: 'servobus'))" \
        >"$work/meson_user/meson.build"
    meson setup "$work/meson_user/build" "$work/meson_user"
    meson compile -C "$work/meson_user/build"
    "$work/meson_user/build/user"
    flags=$(PKG_CONFIG_PATH="$work/meson_prefix/share/pkgconfig" pkg-config --cflags servobus)
    # shellcheck disable=SC2086
    g++ -std=c++20 $flags "$work/main.cpp" -o "$work/by_pkg_config"
    "$work/by_pkg_config"
}

for part in "$@"; do
    case $part in
    copied) copied ;;
    cmake) cmake_builds ;;
    meson) meson_builds ;;
    *) echo "consumers.sh: there is no part $part"; exit 2 ;;
    esac
done
echo "consumers.sh: passed ($*)"
