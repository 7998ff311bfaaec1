# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# For scripts that need packages of Debian or Ubuntu, read by `. tests/support/install.sh` in the project's root.

# install PACKAGE...: by apt-get, and says so. Status 1 if it could not.
install() {
    echo "$(basename "$0"): installing $* with apt-get"
    as_root=""
    [ "$(id -u)" = 0 ] || as_root=sudo
    $as_root apt-get update -qq
    DEBIAN_FRONTEND=noninteractive $as_root apt-get install -y -qq --no-install-recommends "$@" >/dev/null || {
        echo "$(basename "$0"): $* could not be installed"
        return 1
    }
}

# must_install PACKAGE...: the same, and ends the script if it could not.
must_install() { install "$@" || exit 1; }
