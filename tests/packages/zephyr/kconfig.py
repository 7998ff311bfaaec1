# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Reads a module's Kconfig after stand-ins for Zephyr's symbols of C++: CONFIG_SERVOBUS needs C++20, and brings the
headers of a full C++ library.   kconfig.py KCONFIG
"""
import sys
import tempfile

import kconfiglib

ZEPHYR = """
config CPP
	bool "C++ support"

choice
	prompt "C++ standard"
	depends on CPP
	default STD_CPP11
config STD_CPP11
	bool "C++11"
config STD_CPP17
	bool "C++17"
config STD_CPP20
	bool "C++20"
config STD_CPP2B
	bool "C++23"
endchoice

config REQUIRES_FULL_LIBCPP
	bool

"""


def full_library(kconfig, standard, cpp="y"):
    kconfig.unset_values()
    for symbol, value in (("CPP", cpp), (standard, "y"), ("SERVOBUS", "y")):
        kconfig.syms[symbol].set_value(value)
    on = kconfig.syms["SERVOBUS"].str_value
    assert kconfig.syms["REQUIRES_FULL_LIBCPP"].str_value == on
    return on


with tempfile.NamedTemporaryFile("w", suffix=".kconfig") as top:
    top.write(ZEPHYR + f'source "{sys.argv[1]}"\n')
    top.flush()
    read = kconfiglib.Kconfig(top.name, warn_to_stderr=False)
    assert not read.warnings, read.warnings
    seen = {standard: full_library(read, standard) for standard in ("STD_CPP11", "STD_CPP17", "STD_CPP20", "STD_CPP2B")}
    assert seen == {"STD_CPP11": "n", "STD_CPP17": "n", "STD_CPP20": "y", "STD_CPP2B": "y"}, seen
    assert full_library(read, "STD_CPP20", cpp="n") == "n"
