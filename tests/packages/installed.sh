# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Part of tests/install.sh, which runs it as root in a copy of the machine: installs the packages, uses what they have
# as a user does, and removes them.
#   sh tests/packages/installed.sh WORK VERSION TOOL.deb HEADERS.deb
set -u
work=$1 version=$2 tool_deb=$3 headers_deb=$4
here=$(dirname "$0")
checks=0

check() { # NAME COMMAND...
    name=$1
    shift
    checks=$((checks + 1))
    if "$@" >"$work/said" 2>&1; then
        echo "ok      $name"
    else
        echo "FAILED  $name"
        tail -n 20 "$work/said"
    fi
}
says() { # EXPECTED COMMAND...
    expected=$1
    shift
    found=$("$@" 2>&1)
    echo "$found"
    [ "$found" = "$expected" ]
}
machine() { find /usr /etc /opt /var/lib/dpkg/info ! -path '/usr/share/info/dir*' | sort; }

machine >"$work/before"
# Images of Debian for containers leave manual pages and documents out.
check "dpkg installs both" dpkg --path-include='/usr/share/man/*' --path-include='/usr/share/doc/*' \
    -i "$tool_deb" "$headers_deb"
check "their files are as they were packed" sh -c '[ -z "$(dpkg -V servobus libservobus-dev)" ] && [ -z "$(dpkg -C)" ]'
for file in /usr/share/doc/servobus/copyright /usr/share/doc/servobus/changelog.gz /usr/share/doc/servobus/README.md \
    /usr/share/doc/libservobus-dev/copyright /usr/share/doc/libservobus-dev/changelog.gz; do
    check "$file" test -s $file
done
has_license() {
    sed 's/^ \.$//; s/^ //' /usr/share/doc/servobus/copyright | tail -n "$(wc -l <"$work/tree/LICENSE")" |
        diff - "$work/tree/LICENSE"
}
check "the license is in copyright" has_license

check "servobus is in the path" says /usr/bin/servobus sh -c 'command -v servobus'
check "servobus --version" says "servobus $version" servobus --version
check "servobus map" sh -c '[ "$(servobus map c630s | wc -l)" = 464 ]'
simulated() {
    servobus sim zlac8015d --link "$work/drive" >"$work/path" &
    drive=$!
    tries=0
    until [ -e "$work/drive" ] || [ $tries = 100 ]; do tries=$((tries + 1)); sleep 0.1; done
    says "bus_voltage=24.00 V" servobus read "$work/drive" zlac8015d bus_voltage
    status=$?
    kill $drive && wait $drive
    return $status
}
check "a simulated drive, and a read of it" simulated

check "man finds the page" says /usr/share/man/man1/servobus.1.gz man -w servobus
check "man shows it without a warning" sh -c '[ -z "$(MANWIDTH=80 man --warnings servobus 2>&1 >'"$work/page"')" ] &&
    grep -q -e "--dry-run" '"$work/page"
check "man -k knows what it is" sh -c 'lexgrog /usr/share/man/man1/servobus.1.gz | grep -q "motor drives"'

script=/usr/share/bash-completion/completions/servobus
check "completion" says bus_voltage \
    bash "$here/../tool/words.bash" $script servobus ':=' 'servobus read p zlac8015d:1 bus_v'
check "bash-completion loads it by the command's name" says "complete -F _servobus servobus" \
    bash --norc -c '. /usr/share/bash-completion/bash_completion; _completion_loader servobus; complete -p servobus'

mkdir "$work/user"
cat >"$work/user/main.cpp" <<'END'
#include <servobus/device/zlac8015d.hpp>
#include <servobus/servobus.hpp>
int main() { return servobus::modbus::write_frame(1, 0x200E, 7).size == 8 ? 0 : 1; }
END
printf '%s\n' 'cmake_minimum_required(VERSION 3.18)' 'project(user CXX)' "find_package(servobus $version REQUIRED)" \
    'add_executable(user main.cpp)' 'target_link_libraries(user PRIVATE servobus::servobus)' >"$work/user/CMakeLists.txt"
by_find_package() {
    cmake -S "$work/user" -B "$work/user/build" && cmake --build "$work/user/build" && "$work/user/build/user" &&
        grep -qx 'servobus_DIR:PATH=/usr/share/cmake/servobus' "$work/user/build/CMakeCache.txt"
}
check "a program by find_package" by_find_package
by_pkg_config() {
    says "$version" pkg-config --modversion servobus && flags=$(pkg-config --cflags servobus) &&
        g++ -std=c++20 $flags "$work/user/main.cpp" -o "$work/user/user" && "$work/user/user"
}
check "a program by pkg-config" by_pkg_config

check "dpkg removes both" dpkg -P servobus libservobus-dev
machine >"$work/after"
check "and leaves nothing" diff "$work/before" "$work/after"
echo "installed.sh: $checks checks"
