#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# The hardware interface of examples/ros2_control, against stand-ins for the public headers of ros2_control (Humble,
# Jazzy and Rolling): it compiles, its package builds, its files agree, and it behaves as the controller manager needs,
# over a simulated drive in virtual time and over a pseudo-terminal in real time. Installs missing packages (Debian,
# Ubuntu).
#   sh tests/ros2_control.sh            everything
#   sh tests/ros2_control.sh virtual    all but the pseudo-terminal
#   sh tests/ros2_control.sh terminal   the pseudo-terminal alone
#   BUILD   where to build; a temporary directory if not given
set -u
cd "$(dirname "$0")/.." || exit 1

. tests/support/install.sh

command -v g++ >/dev/null 2>&1 || install g++ || exit 1
command -v clang++ >/dev/null 2>&1 || install clang libc6-dev || exit 1
command -v cmake >/dev/null 2>&1 || install cmake || exit 1
echo '#include <doctest/doctest.h>' | g++ -x c++ -std=c++20 -fsyntax-only - 2>/dev/null || install doctest-dev || exit 1
python3 -c 'import yaml' 2>/dev/null || install python3-yaml || exit 1

if [ -n "${BUILD:-}" ]; then
    build=$BUILD
    mkdir -p "$build" || exit 1
else
    build=$(mktemp -d)
fi
simulator=""
clean_up() {
    [ -z "$simulator" ] || kill "$simulator" 2>/dev/null
    [ -n "${BUILD:-}" ] || rm -rf "$build"
}
trap clean_up EXIT

strict="-Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wold-style-cast -Wshadow -Werror"
common="-std=c++20 -O1 $strict -D_GLIBCXX_ASSERTIONS -Iinclude -I. -isystem tests/ports/stubs/ros2"
humble="$common -isystem tests/ports/stubs/ros2_humble"
# Jazzy deprecates the only form of the exported interfaces that Humble has. Rolling has one form of on_init left.
jazzy="$common -isystem tests/ports/stubs/ros2_jazzy -DSTAND_IN_JAZZY -Wno-deprecated-declarations"
rolling="$common -isystem tests/ports/stubs/ros2_rolling -isystem tests/ports/stubs/ros2_jazzy -DSTAND_IN_JAZZY
    -Wno-deprecated-declarations"
sanitized="-fsanitize=address,undefined -fno-sanitize-recover=all"
plugin=examples/ros2_control/servobus_zlac8015d_system.cpp
log=$build/log
. tests/support/checks.sh

in_virtual_time() { # NAME COMPILER OPTION...
    name_of_test=$1
    shift
    "$@" "tests/ros2_control/$name_of_test.cpp" "$build/main.o" -o "$build/$name_of_test" && "$build/$name_of_test"
}
package_builds() {
    cmake -S . -B "$build/servobus" -DSERVOBUS_TESTS=OFF -DSERVOBUS_EXAMPLES=OFF &&
        cmake --install "$build/servobus" --prefix "$build/prefix" &&
        cmake -S examples/ros2_control -B "$build/package" -DCMAKE_PREFIX_PATH="$build/prefix" \
            -DCMAKE_INSTALL_PREFIX="$build/installed" -DCMAKE_BUILD_TYPE=Debug \
            -Dament_cmake_DIR="$PWD/tests/ros2_control/cmake" -Dpluginlib_DIR="$PWD/tests/ros2_control/cmake" \
            -Dhardware_interface_DIR="$PWD/tests/ros2_control/cmake" -Drclcpp_DIR="$PWD/tests/ros2_control/cmake" \
            -Drclcpp_lifecycle_DIR="$PWD/tests/ros2_control/cmake" &&
        cmake --build "$build/package" && cmake --install "$build/package" &&
        [ -e "$build/installed/lib/libservobus_ros2_control.so" ] &&
        [ -e "$build/installed/share/servobus_ros2_control/launch/robot.launch.py" ]
}
on_a_terminal() {
    g++ $humble tests/ros2_control/terminal.cpp $plugin -o "$build/terminal" &&
        g++ -std=c++20 -O1 -Iinclude examples/simulated_drive/main.cpp -o "$build/simulated_drive" || return 1
    "$build/simulated_drive" "$build/drive" &
    simulator=$!
    for _ in 1 2 3 4 5 6 7 8 9 10; do
        [ -e "$build/drive" ] || sleep 0.2
    done
    python3 -B tests/ros2_control/described.py --describe "$build/drive" >"$build/description" &&
        "$build/terminal" "$build/description" "$simulator"
    ended=$?
    kill "$simulator"
    simulator=""
    return $ended
}

part=${1:-all}
if [ "$part" != terminal ]; then
    check "the runner" g++ $humble -c tests/run/main.cpp -o "$build/main.o"
    for source in driving lifecycle; do
        check "g++, Humble: $source" in_virtual_time $source g++ $humble
    done
    for source in losses hostile; do
        check "clang++ with sanitizers, Jazzy: $source" in_virtual_time $source clang++ $jazzy $sanitized
    done
    check "g++, Rolling: lifecycle" in_virtual_time lifecycle g++ $rolling
    check "g++, Jazzy: the plugin compiles" g++ $jazzy -fsyntax-only $plugin
    check "clang++, Rolling: the plugin compiles" clang++ $rolling -fsyntax-only $plugin
    if command -v g++-11 >/dev/null 2>&1; then # the compiler of Ubuntu 22.04, which Humble is for
        check "g++ 11, Humble: the plugin compiles" g++-11 $humble -fsyntax-only $plugin
    fi
    check "clang++, Humble: the plugin compiles" clang++ $humble -fsyntax-only $plugin
    check "the package builds and installs" package_builds
    check "the files agree" python3 -B tests/ros2_control/described.py
fi
if [ "$part" != virtual ]; then
    check "a simulated drive on a pseudo-terminal" on_a_terminal
fi

echo "ros2_control.sh: $checks checks, $failed failed"
[ "$failed" = 0 ]
