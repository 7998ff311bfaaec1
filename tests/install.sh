#!/bin/sh
# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Installs what the work tree has: the .deb packages and the zip for Windows that CPack makes, twice the same bytes;
# lintian's judgement; dpkg puts them into a copy of this machine, where the tool, its manual page, its completion and the
# headers are used, and removes them; cmake --install. Installs missing packages (Debian, Ubuntu).   sh tests/install.sh
#   JOBS   compilers at a time, 2 if not given
set -u
cd "$(dirname "$0")/.." || exit 1

. tests/support/install.sh

need() { # COMMAND PACKAGE...
    command=$1
    shift
    command -v "$command" >/dev/null 2>&1 || must_install "$@"
}
need git git
need g++ g++ libc6-dev
need cmake cmake
need dpkg-shlibdeps dpkg-dev
need lintian lintian
need man man-db
need groff groff
need pkg-config pkg-config
need unzip unzip
need x86_64-w64-mingw32-g++ g++-mingw-w64-x86-64
need wine wine64 wine
[ -e /usr/share/bash-completion/bash_completion ] || must_install bash-completion

work=$(mktemp -d)
export WINEPREFIX="$work/wine" WINEDEBUG=-all WINEDLLOVERRIDES="mscoree=;mshtml="
finish() {
    [ ! -d "$WINEPREFIX" ] || wineserver -k >/dev/null 2>&1
    rm -rf "$work"
}
trap finish EXIT
trap 'exit 2' INT TERM
log=$work/log
. tests/support/checks.sh

. tests/support/work_tree.sh
again=$work/elsewhere/again
mkdir "$work/elsewhere" && git clone -q "$tree" "$again" || exit 1
version=$(sed -n 's/^project(servobus VERSION \([0-9.]*\) .*/\1/p' CMakeLists.txt)
architecture=$(dpkg --print-architecture)

# Only the tool is compiled, and not optimised: the example programs are in no package.
packed() { # TREE OUT OPTION...: the packages, in OUT
    source=$1
    out=$2
    shift 2
    cmake -S "$source" -B "$source/build" -DSERVOBUS_TESTS=OFF -DCMAKE_BUILD_TYPE=Release \
        -DCMAKE_CXX_FLAGS_RELEASE=-O0 "$@" &&
        cmake --build "$source/build" -j "${JOBS:-2}" --target servobus_tool &&
        (cd "$source/build" && cpack -D CPACK_PACKAGE_DIRECTORY="$out")
}
same() { # FOLDER FOLDER COUNT
    ls -l "$1"
    diff -r "$1" "$2" && [ "$(find "$1" -maxdepth 1 -type f | wc -l)" = "$3" ]
}

# ---- the packages for Debian
check "CPack makes the .deb packages" packed "$tree" "$work/debs"
elsewhere() { (cd / && export TZ=Asia/Tokyo LC_ALL=C && packed "$@"); }
check "from another clone and time zone" elsewhere "$again" "$work/debs2"
rm -rf "$work/debs/_CPack_Packages" "$work/debs2/_CPack_Packages"
check "the same bytes" same "$work/debs" "$work/debs2" 4
tool_deb=$work/debs/servobus_${version}_$architecture.deb
headers_deb=$work/debs/libservobus-dev_${version}_all.deb
for deb in "$tool_deb" "$headers_deb"; do
    check "lintian has neither an error nor a warning: ${deb##*/}" \
        lintian --allow-root --no-cfg --fail-on error,warning "$deb"
done
field() { # FIELD VALUE DEB
    dpkg-deb -f "$3" "$1"
    dpkg-deb -f "$3" "$1" | grep -qE -e "$2"
}
check "the tool depends on the C and C++ libraries" field Depends '^libc6 .*libstdc\+\+6 ' "$tool_deb"
check "the headers depend on nothing" sh -c "[ -z \"\$(dpkg-deb -f '$headers_deb' Depends)\" ]"
of_its_time() {
    when=$(date -d "@$(git -C "$tree" log -1 --format=%ct)" '+%Y-%m-%d %H:%M')
    dpkg-deb -c "$tool_deb" >"$work/found" && ! grep -vF " $when ./" "$work/found" && ! grep -v ' root/root ' "$work/found"
}
check "its files are of the commit's time, and root's" of_its_time

# A copy of this machine, whose changes are lost: an overlay over its root, in a mount namespace. Nothing that runs
# beside this test finds what is installed here.
cat >"$work/copy.sh" <<'END'
set -eu
work=$1
mkdir "$work/layer" && mount -t tmpfs tmpfs "$work/layer"
mkdir "$work/layer/upper" "$work/layer/work" "$work/layer/root"
root=$work/layer/root
mount -t overlay overlay -o "lowerdir=/,upperdir=$work/layer/upper,workdir=$work/layer/work" "$root"
mkdir -p "$root$work" && mount --rbind "$work" "$root$work"
mount --rbind /dev "$root/dev" && mount --rbind /proc "$root/proc"
shift
exec chroot "$root" "$@"
END
in_a_copy() { # COMMAND...
    if [ "$(id -u)" = 0 ]; then
        unshare --mount sh "$work/copy.sh" "$work" "$@"
    else
        unshare --mount --map-root-user sh "$work/copy.sh" "$work" "$@"
    fi
}
if in_a_copy true 2>/dev/null; then
    where=in_a_copy
else
    echo "install.sh: this system allows no copy: the packages are installed on the machine itself, and removed"
    where=env
fi
rm -rf "$work/layer"
$where sh "$work/tree/tests/packages/installed.sh" "$work" "$version" "$tool_deb" "$headers_deb" >"$work/installed" 2>&1
check "dpkg installs, uses and removes the packages: all checks were made" \
    grep -qx 'installed.sh: 21 checks' "$work/installed"
cat "$work/installed"
checks=$((checks + $(grep -cE '^(ok|FAILED) ' "$work/installed")))
failed=$((failed + $(grep -c '^FAILED ' "$work/installed")))
check "and this machine has nothing of them" sh -c "! dpkg -s servobus libservobus-dev >/dev/null 2>&1"

# ---- cmake --install
installs() { # BUILD FILE...: these files, and no other but headers
    build=$1
    shift
    rm -rf "$work/prefix" && cmake --install "$build" --prefix "$work/prefix" &&
        (cd "$work/prefix" && find . -type f ! -path './include/servobus/*' | sort >"$work/found") &&
        [ -e "$work/prefix/include/servobus/servobus.hpp" ] &&
        printf '%s\n' "$@" ./share/cmake/servobus/servobus-config-version.cmake ./share/pkgconfig/servobus.pc \
            ./share/cmake/servobus/servobus-config.cmake ./share/cmake/servobus/servobus-targets.cmake | sed '/^$/d' | sort |
        diff - "$work/found"
}
check "cmake --install: headers, tool, manual page and completion" installs "$tree/build" ./bin/servobus \
    ./share/man/man1/servobus.1.gz ./share/bash-completion/completions/servobus
check "its tool runs" sh -c "[ \"\$('$work/prefix/bin/servobus' --version)\" = 'servobus $version' ]"
cp "$work/prefix/bin/servobus" "$work/servobus" # to compare with the one for Windows
in_prefix() {
    PKG_CONFIG_PATH="$work/prefix/share/pkgconfig" pkg-config --cflags servobus
    [ "$(cd "$(PKG_CONFIG_PATH="$work/prefix/share/pkgconfig" pkg-config --variable=includedir servobus)" && pwd)" = \
        "$work/prefix/include" ]
}
check "its pkg-config file leads to its headers" in_prefix
configured() { # BUILD OPTION...
    build=$1
    shift
    cmake -S "$tree" -B "$build" -DSERVOBUS_TESTS=OFF "$@"
}
check "without building anything" configured "$work/unbuilt"
check "cmake --install: headers" installs "$work/unbuilt" ""
check "without the examples" configured "$work/headers" -DSERVOBUS_EXAMPLES=OFF
check "cmake --install: headers" installs "$work/headers" ""
headers_alone() {
    (cd "$work/headers" && cpack -D CPACK_PACKAGE_DIRECTORY="$work/debs3") &&
        cmp "$work/debs3/${headers_deb##*/}" "$headers_deb" && [ ! -e "$work/debs3/${tool_deb##*/}" ]
}
check "CPack: the package of the headers alone, the same" headers_alone
# The modes that ar gives to a package's three parts, which dpkg does not read, are all that a umask changes.
parts_of() { (mkdir "$2" && cd "$2" && ar x "$1" && sha256sum *); }
other_umask() {
    (umask 077 && configured "$work/umask" -DSERVOBUS_EXAMPLES=OFF && cd "$work/umask" &&
        cpack -D CPACK_PACKAGE_DIRECTORY="$work/debs4") &&
        parts_of "$headers_deb" "$work/parts" >"$work/found" && parts_of "$work/debs4/${headers_deb##*/}" "$work/parts4" |
        diff "$work/found" -
}
check "CPack: by another umask, the same content" other_umask

# ---- the zip for Windows
zip_name=servobus-$version-windows-x86_64
mingw=-DCMAKE_TOOLCHAIN_FILE=$tree/examples/packages/windows/mingw.cmake
zipped() { # TREE OUT
    rm -rf "$1/build" && packed "$1" "$2" "$mingw"
}
check "CPack makes the zip for Windows" zipped "$tree" "$work/zip"
# From the same program, since the compiler takes its time.
zipped_again() {
    (umask 077 && cd "$tree/build" && export TZ=Asia/Tokyo LC_ALL=C && cpack -D CPACK_PACKAGE_DIRECTORY="$work/zip2")
}
check "the zip again, in another umask and time zone" zipped_again
rm -rf "$work/zip/_CPack_Packages" "$work/zip2/_CPack_Packages"
check "the same bytes" same "$work/zip" "$work/zip2" 2
unpacked() {
    unzip -q "$work/zip/$zip_name.zip" -d "$work/unpacked" && cd "$work/unpacked" &&
        find . -type f | sort >"$work/found" &&
        printf '%s\n' "./$zip_name/LICENSE.txt" "./$zip_name/README.md" "./$zip_name/servobus.exe" | diff - "$work/found" &&
        cmp "$zip_name/LICENSE.txt" "$tree/LICENSE" && cmp "$zip_name/README.md" "$tree/examples/servobus/README.md"
}
check "it has the tool, its page and the license" unpacked
systems_own() {
    x86_64-w64-mingw32-objdump -p "$work/unpacked/$zip_name/servobus.exe" | sed -n 's/.*DLL Name: //p' | tee "$work/found"
    ! grep -viE '^(kernel32|msvcrt|ws2_32|advapi32|setupapi|user32|shell32|ole32|api-ms-.*)\.dll$' "$work/found" &&
        grep -qi kernel32 "$work/found"
}
check "the program needs no library but those of Windows" systems_own
on_wine() {
    mkdir "$WINEPREFIX" && timeout 300 wineboot -i
    cd "$work/unpacked/$zip_name" && [ "$(timeout 120 wine ./servobus.exe --version | tr -d '\r')" = "servobus $version" ] &&
        timeout 120 wine ./servobus.exe map c630s | tr -d '\r' >"$work/found" && "$work/servobus" map c630s |
        diff - "$work/found"
}
check "it runs on wine" on_wine

echo "install.sh: $checks checks, $failed failed"
[ "$failed" = 0 ]
