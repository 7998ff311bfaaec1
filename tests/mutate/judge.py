# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Builds the tests that include a changed header, in a copy of the tree, and finds one that detects the change."""
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
from dataclasses import dataclass
from pathlib import Path

CXX = os.environ.get("CXX", "g++").split()
# As in tests/cmake/unit.cmake, but without warnings: an unused name must not count as detected.
FLAGS = "-std=c++20 -w -D_GLIBCXX_ASSERTIONS -DDOCTEST_CONFIG_SUPER_FAST_ASSERTS -Iinclude -I.".split()
FLAGS += os.environ.get("CXXFLAGS", "").split()
PARTS = ("include", "tests", "examples")

# A test program needs seconds at most, but a changed loop may never end. A program that uses up this processor time,
# or runs for this wall time, counts as hanging. The limits are far beyond the time of the slowest machine, so no test
# passes or fails because of its speed.
PROCESSOR_SECONDS = 60
WALL_SECONDS = 300
MEMORY_BYTES = 4 << 30
# As tests/run.sh plays it: under the default interpretation of each manual.
ENVIRONMENT = {"SERVOBUS_INTERPRETATIONS": "default", **os.environ}

# The messages of compilers when a rule of the library refuses a program, not the grammar of the language.
RULES = re.compile(
    r"""static.assert(ion)?.failed | static_assert
      | not.a.constant.expression | constant.expression.*is.not | non-constant.condition | overflow.in.constant
      | must.be.initialized.by.a.constant | call.to.consteval | call.to.(non-|non-.)constexpr | used.before.its
      | constexpr.(loop|evaluation|.*limit) | constraints.not.satisfied | does.not.satisfy | undefined.reference""",
    re.X,
)


class Unsound(Exception):
    """The unchanged tree does not build or fails a test, so no verdict is meaningful."""


@dataclass
class Verdict:
    kind: str  # "stillborn", "compiler", "tests" or "survived"
    by: str


def includes(root, file, seen):
    """Adds to `seen` all files of the tree that `file` includes."""
    for quote, name in re.findall(r'^[ \t]*#[ \t]*include[ \t]*([<"])([^>"]+)', (root / file).read_text(), re.M):
        beside = [str(Path(file).parent / name)] if quote == '"' else []
        for candidate in beside + ["include/" + name, name]:
            candidate = os.path.normpath(candidate)
            if (root / candidate).is_file():
                if candidate not in seen:
                    seen.add(candidate)
                    includes(root, candidate, seen)
                break
    return seen


def limits():
    resource.setrlimit(resource.RLIMIT_CPU, (PROCESSOR_SECONDS, PROCESSOR_SECONDS + 10))
    if "sanitize" not in " ".join(FLAGS):  # a sanitizer reserves more address space
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))


class Tests:
    """The sources of the tests, what each includes, and which are tried first for a header."""

    def __init__(self, root, first):
        self.root = root
        self.sources = sorted(
            str(p.relative_to(root)) for part in ("run", "static") for p in (root / "tests" / part).rglob("*.cpp")
        )
        self.sources.remove("tests/run/main.cpp")
        busy = (root / "tests/run/busy.txt").read_text().splitlines()
        self.busy = {f"tests/run/{line.split()[0]}.cpp" for line in busy if line and not line.startswith("#")}
        self.includes = {s: includes(root, s, set()) for s in [*self.sources, "tests/sim/main.cpp"]}
        self.first = {}
        for line in first.read_text().splitlines():
            if line and not line.startswith("#"):
                header, *names = line.split()
                self.first["include/servobus/" + header] = [f"tests/run/{n}.cpp" for n in names]

    def problems(self):
        for header, sources in self.first.items():
            for source in sources:
                if header not in self.includes.get(source, ()):
                    yield f"first.txt: {source} does not see {header}"

    def level(self, source):
        """The optimisation level of this source."""
        return "-O1" if source in self.busy else "-O0"

    def likely(self, header):
        return self.first.get(header, [])

    def others(self, header):
        """The other sources that include the header, small ones first: they compile faster."""
        see = [s for s in self.sources if header in self.includes[s] and s not in self.likely(header)]
        return sorted(see, key=lambda s: ((self.root / s).stat().st_size, s))


class Bench:
    """A copy of the tree in which one header at a time is changed. Each thread has its own copy."""

    def __init__(self, tests, work, main_object, baseline):
        self.tests = tests
        self.work = Path(tempfile.mkdtemp(dir=work))
        self.main_object = main_object
        self.baseline = baseline
        for part in PARTS:
            shutil.copytree(tests.root / part, self.work / part)
        self.program = self.work / "program"

    def run(self, command, **options):
        """Runs a command. Returns its status and its output, both streams in one."""
        done = subprocess.run(
            ["timeout", "-k", "10", str(WALL_SECONDS), *map(str, command)],
            cwd=self.work, env=ENVIRONMENT, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            text=True, errors="replace", **options,
        )  # fmt: skip
        return done.returncode, done.stdout

    def try_compile(self, source, object_file):
        return self.run([*CXX, *FLAGS, self.tests.level(source), "-c", source, "-o", object_file])

    def compile(self, source, object_file):
        """Compiles a source that must compile."""
        status, words = self.try_compile(source, object_file)
        if status != 0:
            raise Unsound(f"{source} does not compile:\n{words}")

    def link(self, object_file):
        return self.run([*CXX, *FLAGS, self.main_object, object_file, "-o", self.program])

    def tokens_of(self, header):
        return self.run([*CXX, *FLAGS, "-E", "-P", header])[1]

    def judge(self, site, likely_only=False):
        """Finds what detects the change."""
        header = self.work / site.file
        source = header.read_text()
        before = self.tokens_of(site.file)
        header.write_text(source[: site.start] + site.new + source[site.end :])
        try:
            if self.tokens_of(site.file) == before:
                return Verdict("stillborn", "left out by the preprocessor")
            tried = self.tests.likely(site.file)
            if not likely_only:
                tried = tried + self.tests.others(site.file)
            for test in tried:
                verdict = self.try_test(test)
                if verdict:
                    return verdict
            return (None if likely_only else self.try_programs(site.file)) or Verdict("survived", "")
        finally:
            header.write_text(source)

    def try_test(self, source):
        object_file = self.program.with_suffix(".o")
        status, words = self.try_compile(source, object_file)
        if status == 0:
            status, words = self.link(object_file)
        if status == 124:
            return Verdict("compiler", f"{source}: it does not end")
        if status < 0 or "terminated program" in words:
            raise Unsound(f"the compiler was stopped from outside at {source}:\n{words}")
        if status != 0:
            rule = next((line for line in words.splitlines() if RULES.search(line) and " | " not in line), None)
            kind = "compiler" if rule else "stillborn"
            if kind == "compiler":
                self.baseline.require(source)
            said = rule or next((line for line in words.splitlines() if "error" in line), "no compiler's error")
            return Verdict(kind, f"{source}: {short(said)}")
        status, words = self.run([self.program, "--abort-after=1"], preexec_fn=limits)
        if status == 0:
            return None
        self.baseline.require(source)
        if status in (124, 137, -signal.SIGXCPU, -signal.SIGKILL):  # by `timeout`, or by the limit
            return Verdict("tests", f"{source}: it hangs")
        case = re.search(r"^TEST CASE: +(.*)$", words, re.M)
        return Verdict("tests", f"{source}: {case[1] if case else f'status {status}'}")

    def try_programs(self, header):
        """The slower tests: the simulation, the programs that must not compile, the command-line tool. Each once."""
        work = self.work
        if header in self.tests.includes["tests/sim/main.cpp"]:
            status, words = self.run([*CXX, *FLAGS, "-O1", "tests/sim/main.cpp", "-o", self.program])
            if status == 0:
                status, words = self.run([self.program, "--seeds", "40"], preexec_fn=limits)
            if status != 0:
                return Verdict("tests", "tests/sim.sh: " + short(words))
        status, words = self.run(
            [sys.executable, "-B", "tests/fail/programs.py", "all", *CXX, "-std=c++20", "-Iinclude", "-fsyntax-only"]
        )
        if status != 0:
            return Verdict("tests", "tests/fail/: " + short(words))
        if not self.tests.likely(header) and not self.tests.others(header):
            status, words = self.run([*CXX, *FLAGS, "examples/servobus.cpp", "-o", self.program])
            if status != 0:
                return Verdict("tests", "examples/servobus: " + short(words))
            for part in sorted((work / "tests/tool").glob("*.py")):
                status, words = self.run([sys.executable, "-B", part, self.program], preexec_fn=limits)
                if status != 0:
                    failed = [line for line in words.splitlines() if line.startswith("FAILED")]
                    return Verdict("tests", f"tests/tool/{part.name}: {short(failed[0] if failed else words)}")
        return None


def short(words):
    """The first line of a program's output, without the folders."""
    line = next((one for one in words.splitlines() if one.strip()), "")
    line = re.sub(r"[^\s(<]*/([^\s/:]+\.[ch]pp:\d+)[:\d]*", r"\1", " ".join(line.split()))
    return line if len(line) <= 110 else line[:107] + "..."


class Baseline:
    """A test that fails on the unchanged tree proves nothing: each is run there before its result counts."""

    def __init__(self, bench):
        self.lock = threading.Lock()
        self.bench = bench
        self.passed = set()

    def require(self, source):
        with self.lock:
            if source in self.passed:
                return
            object_file = self.bench.program.with_suffix(".o")
            self.bench.compile(source, object_file)
            status, words = self.bench.link(object_file)
            if status == 0:
                status, words = self.bench.run([self.bench.program], preexec_fn=limits)
            if status != 0:
                raise Unsound(f"{source} fails without any change:\n{words}")
            self.passed.add(source)
