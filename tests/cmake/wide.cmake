# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# The checks of .ci/run beside the fast ones. .ci/run installs what they need; most install what they lack themselves.
# Those with OF are left out where nothing changed that they judge; tests/README.md says what notices their mistakes then.
set(python ${Python3_EXECUTABLE} -B)
set(strict -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wold-style-cast -Wshadow -Werror)
set(bare ${strict} -fno-exceptions -fno-rtti)

# Other compilers and machines.
function(suite config label)
  check(suite.${config} LABELS suite ${ARGN} ENVIRONMENT JOBS=1
        COMMAND sh tests/configured.sh ${config} ${CMAKE_CURRENT_BINARY_DIR}/${config} ${label})
endfunction()
suite(s390x unit COST 60
      OF tests/config/s390x.cmake tests/run/core tests/run/modbus tests/run/registers tests/run/explain)
suite(i386 unit COST 100
      OF tests/config/i386.cmake tests/run/core tests/run/modbus tests/run/registers tests/run/explain)
suite(gcc11 compile COST 50)
suite(clang compile COST 50)

# Headers
check(headers.gcc11 LABELS compile COST 5
      COMMAND ${python} tests/headers.py --together --without windows g++-11 -std=c++20 ${bare})
check(headers.clang LABELS compile COST 5
      COMMAND ${python} tests/headers.py --together --without windows clang++ -std=c++2b ${bare})
check(headers.clang19 LABELS compile COST 38
      COMMAND ${python} tests/headers.py --without windows clang++-19 -stdlib=libc++ -std=c++2c ${bare})
check(headers.arm LABELS compile target COST 5
      COMMAND ${python} tests/headers.py --together --without windows --without posix
              arm-none-eabi-g++ -std=c++20 -mcpu=cortex-m0plus -mthumb -Os ${bare})
foreach(judge g++ clang-tidy)
  check(headers.no_warnings.${judge} LABELS compile COST 90 ENVIRONMENT JOBS=1 COMMAND ${python} tests/warnings/programs.py ${judge})
endforeach()
check(headers.no_warnings.cppcheck LABELS compile COST 49 ENVIRONMENT JOBS=1 COMMAND ${python} tests/warnings/programs.py cppcheck
      OF tests/warnings ALONE)
check(headers.refuse_cpp17 LABELS compile COST 8 COMMAND ${python} tests/old_standards.py)
check(headers.rooms LABELS compile COMMAND ${python} tests/rooms.py)
check(tool.rooms LABELS compile COMMAND ${python} tests/tool_rooms.py)
check(rings LABELS docs COMMAND ${python} tests/rings.py)
# One table of a CRC takes more steps than these to compute.
check(headers.no_table_unasked.gcc LABELS compile
      COMMAND g++ -std=c++20 -Iinclude -fsyntax-only -fconstexpr-ops-limit=2000 -x c++ include/servobus/servobus.hpp)
check(headers.no_table_unasked.clang LABELS compile
      COMMAND clang++ -std=c++20 -Iinclude -fsyntax-only -fconstexpr-steps=1000 -x c++ include/servobus/servobus.hpp)

# Peers, in real time; one that cannot be installed is skipped. docs.readme_commands runs the main job.
foreach(peer libmodbus with_pymodbus with_modbus_serial values tshark mbpoll modbus_tcp late_network addresses)
  check(peers.${peer} LABELS peers REAL_TIME COST 10 COMMAND ${python} tests/interop/${peer}.py ${tool}
      OF include/servobus/client include/servobus/server include/servobus/posix tests/interop)
endforeach()
foreach(scheme tcp mbap)
  check(peers.gateways_${scheme} LABELS peers REAL_TIME COST 15
        COMMAND ${python} tests/interop/gateways.py ${tool} ${scheme}
      OF include/servobus/client include/servobus/server include/servobus/posix tests/interop)
endforeach()
check(tool.probe_of_others LABELS tool REAL_TIME COST 70 ENVIRONMENT "PROBED=yako-closed-loop c630s"
      COMMAND ${python} tests/tool/probe.py ${tool}
      OF examples/servobus/probe examples/servobus/interpretations)
check(tool.troubles LABELS tool REAL_TIME COST 75 COMMAND ${python} tests/tool/troubles.py ${tool})
check(tool.line_texts LABELS tool REAL_TIME COST 50 COMMAND ${python} tests/tool/line_texts.py ${tool})
# A device of these tests is late where others compute.
set_tests_properties(tool.troubles tool.line_texts PROPERTIES RUN_SERIAL ON)
check(posix.portable LABELS posix REAL_TIME COST 70 COMMAND sh tests/portable.sh
      OF include/servobus/posix tests/run/posix examples/servobus/os examples/servobus/streams)

# A hostile line, and fuzzing: the same inputs in every run, for what a search finds must not turn an unrelated change red.
# As few runs as must have played each kind of event; `sh tests/sim.sh` has 1600.
check(sim.all LABELS sim COST 40 COMMAND sh tests/sim.sh --seeds 1000)
# The sanitizers that are left out here take a third of the compiler's work. The fuzzers have them.
check(sim.sanitizers LABELS sim COST 40 COMMAND sh tests/sim.sh --seeds 96
      ENVIRONMENT CXX=clang++ "CXXFLAGS=-fsanitize=address,undefined -fno-sanitize-recover=all -fno-sanitize=null,alignment,vptr,object-size,function"
      OF tests/sim.sh ALONE)
check(fuzz.all LABELS fuzz COST 70 ENVIRONMENT SEED=1 JOBS=1 COMMAND sh fuzz/run.sh 2)
# The lines that mutants and planted defects change are still there.
check(sim.defects LABELS sim COMMAND ${python} tests/sim/defects.py --list)
check(mutants.meaning LABELS unit COST 5 COMMAND ${python} tests/mutate/mutate.py --meaning --list)

# Small cores, and figures
check(target.ports LABELS target COST 28 COMMAND sh tests/ports.sh
      OF examples/ports tests/ports)
check(target.bare_metal LABELS target COST 18 COMMAND sh tests/bare_metal.sh ${tool}
      OF examples/bare_metal)
check(target.freestanding LABELS target COST 9 COMMAND ${python} tests/freestanding.py
      OF tests/freestanding)
check(target.programs LABELS target figures COST 60 COMMAND sh tests/target/run.sh)
check(target.server LABELS target figures COST 8 COMMAND sh tests/target/server.sh)
check(target.operations LABELS target figures COST 10 COMMAND sh tests/target/operations.sh)
check(target.axis LABELS target figures COST 5 COMMAND sh tests/target/axis.sh)
check(target.machines LABELS target COST 5 COMMAND sh tests/target/machines.sh)
check(figures.crc_sizes LABELS target figures COMMAND ${python} bench/sizes.py)
check(figures.instructions.gcc LABELS figures COST 10 COMMAND ${python} bench/instructions.py)
check(figures.instructions.clang LABELS figures COST 12 ENVIRONMENT CXX=clang++ COMMAND ${python} bench/instructions.py)
check(figures.compile_cost LABELS figures COST 19 COMMAND ${python} bench/compile_cost.py
      OF bench/compile_cost.py include/servobus/registers ALONE)
check(figures.include_cost LABELS figures COST 25 COMMAND ${python} bench/include_cost.py --bounds
      OF bench/include_cost.py include/servobus/control include/servobus/device ALONE)
check(figures.plan_cost LABELS figures COST 23 COMMAND ${python} bench/plan_cost.py
      OF bench/plan_cost.py include/servobus/bus include/servobus/line ALONE)
check(figures.bus LABELS figures COMMAND ${python} bench/bus.py)
check(figures.page LABELS figures docs COMMAND ${python} bench/readme.py --check)
check(figures.plots LABELS figures docs COMMAND ${python} bench/plot.py --check)

# ROS 2, against stand-ins
check(example.ros2_control LABELS example COST 45 COMMAND sh tests/ros2_control.sh virtual)
check(example.ros2_terminal LABELS example REAL_TIME COST 25 COMMAND sh tests/ros2_control.sh terminal)

# Windows. Several tests run the same programs, on one installation of wine.
set(mingw ${CMAKE_CURRENT_BINARY_DIR}/mingw)
check(windows.headers LABELS windows COST 10 COMMAND ${python} tests/windows/headers.py)
check(windows.programs LABELS windows COST 30 COMMAND ${python} tests/windows/programs.py ${mingw}
      OF include/servobus/windows tests/windows examples/servobus/os examples/servobus/streams)
check(windows.removed LABELS windows COMMAND ${CMAKE_COMMAND} -E rm -rf ${mingw}/wine)
set_tests_properties(windows.programs PROPERTIES FIXTURES_SETUP windows)
set_tests_properties(windows.removed PROPERTIES FIXTURES_CLEANUP windows)
function(check_on_wine name cost program)
  check(windows.${name} LABELS windows REAL_TIME COST ${cost}
        COMMAND ${python} tests/windows/${program}.py ${tool} ${mingw} ${ARGN}
      OF include/servobus/windows tests/windows examples/servobus/os examples/servobus/streams)
  set_tests_properties(windows.${name} PROPERTIES FIXTURES_REQUIRED windows)
endfunction()
check_on_wine(port 20 port)
check_on_wine(interrupt 20 interrupt)
check_on_wine(zip 10 zip)
foreach(part commands files network endings)
  check_on_wine(tool.${part} 20 tool ${part})
endforeach()
# Not `parameters`, which takes as long as all others: the tool's files on Windows are in tool.files.
check_on_wine(tests_of_the_tool.listen 50 tests_of_the_tool listen)
foreach(part offline zlac8015d devices refused_files device_files)
  check_on_wine(tests_of_the_tool.${part} 20 tests_of_the_tool ${part})
endforeach()

# Packages and builds
check(packages.made LABELS packages COST 40 COMMAND ${python} tests/packages/made.py
      OF CMakeLists.txt meson.build examples/packages tests/packages ALONE)
check(packages.single_headers LABELS packages COST 29 COMMAND ${python} tests/packages/single_headers.py
      OF CMakeLists.txt meson.build examples/packages tests/packages ALONE)
check(packages.frameworks LABELS packages COST 16 COMMAND ${python} tests/packages/frameworks.py
      OF CMakeLists.txt meson.build examples/packages tests/packages ALONE)
check(packages.recipes LABELS packages COST 10 COMMAND ${python} tests/packages/recipes.py
      OF CMakeLists.txt meson.build examples/packages tests/packages ALONE)
check(packages.debian LABELS packages COST 70 COMMAND ${python} tests/packages/debian.py
      OF CMakeLists.txt meson.build examples/packages tests/packages ALONE)
foreach(part copied cmake meson)
  check(packages.${part} LABELS packages COST 30 COMMAND ${python} tests/packages/consumers.py ${part}
      OF CMakeLists.txt meson.build examples/packages tests/packages ALONE)
endforeach()
check(packages.version LABELS packages COMMAND ${python} tests/packages/version.py)

# Pages
check(docs.reference LABELS docs COST 22 COMMAND ${python} tests/reference/check.py ${tool}
      OF tests/reference include/servobus/device)
check(docs.pages LABELS docs COST 9 COMMAND ${python} tests/docs/pages.py)
check(docs.readme_commands LABELS docs REAL_TIME COST 100 COMMAND ${python} tests/docs/readme_commands.py
      OF README.md examples/run.sh ALONE)
check(docs.header_examples LABELS docs COST 20 COMMAND ${python} tests/header_examples.py)
check(docs.comments LABELS docs COMMAND ${python} tests/docs/comments.py --check)
check(docs.example_lines LABELS docs COMMAND ${python} tests/docs/example_lines.py --check)
check(docs.promises LABELS docs COMMAND ${python} tests/docs/promises.py)
check(docs.mutants LABELS docs COMMAND ${python} tests/mutate/mutate.py --list --mutants 1)

check(style.format LABELS style COMMAND sh -c "git ls-files '*.hpp' '*.cpp' | xargs clang-format --dry-run --Werror")
