# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Builds and runs the benchmarks and prints tables: ratios of times, how much of a line a bus uses, in virtual time and
over a pseudo-terminal, and instructions, which do not depend on the load of the machine.

Options go to Google Benchmark, such as `--benchmark_filter=transaction`.
"""
import sys

from measuring import built_benchmarks, show

show(built_benchmarks(), "--benchmark_min_time=0.1", *sys.argv[1:])
for others in (["bus.py"], ["bus.py", "--pty"], ["instructions.py"]):
    print()
    show(sys.executable, "-B", f"bench/{others[0]}", *others[1:])
