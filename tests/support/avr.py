# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""What compiles C++20 for AVR. Needs arm-none-eabi-g++. As a program, it prints what a shell evaluates."""
import re
import shlex
import shutil

from checks import install, must


def clang_avr():
    """A clang++ for AVR, which needs a newer one than the default of Debian 12; empty if there is none."""
    found = next(filter(shutil.which, ("clang++-19", "clang++-20", "clang++-21", "clang++-18")), "")
    return found or ("clang++-19" if install("clang-19") else "")


def search_path(pattern):
    """Options for the folders of arm-none-eabi-g++ whose names have the pattern."""
    said = must("arm-none-eabi-g++", "-v", "-x", "c++", "-E", "-")
    folders = re.search(r"^#include <.*?^End", said, re.M | re.S)[0].splitlines()
    return [word for line in folders if re.search(f"^ .*{pattern}", line) for word in ("-isystem", line.strip())]


def libstdcpp():
    """Options for its C++ headers. Debian has none for AVR and RISC-V; those of ARM's libstdc++ work, since they use
    only the compiler's own macros.
    """
    return search_path(r"/c\+\+/")


if __name__ == "__main__":
    print(f"\nclang_avr={clang_avr()}\nlibstdcpp={shlex.quote(' '.join(libstdcpp()))}")
