# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The wrong programs of this folder, each with one mistake that the compiler must refuse.

programs.py refused PROGRAM COMPILER FLAG...   it does not compile, and the error contains the words after `// EXPECT:`,
                                               and those after `// FIGURES:` if there are any
programs.py all COMPILER FLAG...               so for each of them
programs.py sizes COMPILER FLAG...             prints for each the size of its error and if the first line says the rule
programs.py sizes --of FOLDER COMPILER         fails if an error in FOLDER, a record of as_before.sh, breaks a bound which
                                               errors.txt does not list, or if a line there is more than is needed
programs.py page                               makes README.md, the page of compile errors
programs.py page --check                       fails if README.md is not that page, or control.cpp lacks a mend

The size is of the compiler's whole output in characters, with paths from the project's folder.
"""
import itertools
import re
import subprocess
import sys
import tempfile
import textwrap
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
HEAD = """# Compile errors and their mends

Search this page for words of the compiler's error, which is often a dozen lines long: the headings are those words, in the
order of the alphabet. Below each stand the mistakes that lead to it, and the code that compiles in their place. `drive` is a
client of a ZLAC8015D, `zlac` is `servobus::zlac8015d`, `units` is `servobus::units`, `tank` is the device of
[served.hpp](served.hpp). [plan_errors.hpp](../../include/servobus/bus/detail/plan_errors.hpp) explains the figures of a
plan's errors.

`programs.py` makes this page from the programs beside it, which the tests compile with g++ and clang++. The first error
says the rule, and the whole output is less than 3 kB, or 6 kB for a plan; [errors.txt](errors.txt) has the exceptions.
"""
LIST = HERE / "errors.txt"
JUDGED = ("clang++-14", "g++-11", "g++-12")  # of others the words and sizes are not known
MOST, MOST_OF_A_PLAN = 3000, 6000
STEP = 100  # a line of the list is a multiple: numbers of lines, which the output has too, change with every edit


@dataclass
class Program:
    name: str
    title: str = ""
    expected: str = ""
    figures: str = ""
    mend: str = ""
    wrong: str = ""


def read(path):
    """A comment is the title; then come EXPECT and MEND, whose text may go on in further comments."""
    program = Program(path.name)
    code = None
    titles = []
    is_mend = False
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("// EXPECT: "):
            program.expected = line[len("// EXPECT: ") :]
        elif line.startswith("// FIGURES: "):
            program.figures = line[len("// FIGURES: ") :]
        elif line.startswith("// MEND: "):
            program.mend = line[len("// MEND: ") :]
            is_mend = True
            continue
        elif is_mend and line.startswith("// "):
            program.mend += ("\n" if line[3] in " }" else " ") + line[3:]
            continue
        elif line.startswith("#include"):
            code = code or []
        elif code is not None:
            code.append(line)
        elif line.startswith("// ") and not line.startswith("// SPDX"):
            titles.append(line[3:])
        is_mend = False
    program.title = " ".join(titles).removesuffix(".")
    if not program.expected or not program.mend:
        sys.exit(f"{path.name}: it needs a line \"// EXPECT: \" and one \"// MEND: \"")
    marked = max(i for i, line in enumerate(code) if line.endswith("// wrong"))
    first = marked
    while first > 0 and not re.match(r" *(\(void\)|constexpr auto|inline constexpr)", code[first]):
        first -= 1
    while not code[first] or code[first] == "using namespace servobus;":
        first += 1
    lines = [re.sub(r" *// wrong$", "", line) for line in code[first : marked + 1]]
    program.wrong = textwrap.dedent("\n".join(re.sub(r"^( *)\(void\)", r"\1", line) for line in lines))
    return program


def all_programs():
    return [read(path) for path in sorted(HERE.glob("*.cpp")) if path.name != "control.cpp"]


def page(programs):
    text = HEAD
    by_words = sorted(programs, key=lambda p: (p.expected.casefold(), p.figures, p.name))
    for expected, alike in itertools.groupby(by_words, key=lambda p: p.expected):
        text += f"\n## `{expected}`\n"
        for p in alike:
            figures = f", with the figures `{p.figures}`" if p.figures else ""
            text += (f"\n[{p.title}]({p.name}){figures}:\n\n```cpp\n{p.wrong}\n// compiles:\n"
                     f"{p.mend.removeprefix('(void)')}\n```\n")
    return text


def plain(code):
    """Without blanks, and without the numbers that keep the names of control.cpp apart."""
    return re.sub(r"(gain|request|frame|plan)_[0-9]+", r"\1", re.sub(r"[ \n]", "", code))


def check_page(programs):
    control = plain((HERE / "control.cpp").read_text(encoding="utf-8"))
    wrong = [f"control.cpp does not have the mend of {p.name}" for p in programs if plain(p.mend) not in control]
    if (HERE / "README.md").read_text(encoding="utf-8") != page(programs):
        wrong.append("README.md is out of date: python3 tests/fail/programs.py page")
    for line in wrong:
        print(f"FAILED  {line}")
    print(f"{len(programs)} wrong programs, {len(wrong)} failed")
    return 1 if wrong or not programs else 0


def output_of(path, command):
    """Of a compiler, or of as_before.sh, which always succeeds."""
    done = subprocess.run([*command, str(path)], capture_output=True, text=True, errors="replace", check=False)
    return done.stdout + done.stderr


def compiler_name(compiler):
    """`g++-12`, `clang++-14`: the wording of errors changes with the version."""
    version = subprocess.run([compiler, "--version"], capture_output=True, text=True, check=True).stdout
    kind = "clang++" if "clang" in version else "g++"
    return f"{kind}-{re.search(r' ([0-9]+)[.]', version)[1]}"


@dataclass
class Error:
    size: int
    says_rule: bool
    most: int

    def is_listed(self):
        return self.size >= self.most or not self.says_rule

    def line(self, compiler, name):
        return f"{compiler} {-(-self.size // STEP) * STEP} {'rule' if self.says_rule else 'no-rule'} {name}"


def error_of(program, said, compiler):
    """clang++ words the first line itself where a constant is none, and says in notes of that error why."""
    first = re.search(r"^.* error: .*$", said, re.M)
    rest = said[first.start() :]
    if compiler.startswith("clang"):
        following = re.search(r"\n.* error: ", rest)
        rest = rest[: following.start()] if following else rest
    else:
        rest = first[0]
    said = said.replace(f"{HERE.parents[1]}/", "")
    return Error(len(said), program.expected in rest, MOST_OF_A_PLAN if "poll_plan" in program.wrong else MOST)


def commands(command, folder):
    """As CMake has them, a function from a program: for clang++ what all programs include is precompiled."""
    if not compiler_name(command[0]).startswith("clang"):
        return lambda program: command
    header = [*command, f"-I{HERE}", "-w", "-x", "c++-header", str(HERE / "all.hpp"), "-o", f"{folder}/all.pch"]
    subprocess.run([word for word in header if word != "-fsyntax-only"], check=True)
    is_alone = re.compile(r"^// ALONE", re.M)
    return lambda program: (command if is_alone.search((HERE / program.name).read_text("utf-8")) else
                            [*command, "-include-pch", f"{folder}/all.pch"])


def sizes(command):
    compiler = compiler_name(command[0])
    with tempfile.TemporaryDirectory() as folder:
        command_of = commands(command, folder)
        errors = {p.name: error_of(p, output_of(HERE / p.name, command_of(p)), compiler) for p in all_programs()}
    for name, error in sorted(errors.items(), key=lambda item: -item[1].size):
        print(f"{error.size:6} of {error.most}  {'rule' if error.says_rule else 'no-rule':7}  {name}")
    print("what errors.txt lists of it:")
    for name, error in errors.items():
        if error.is_listed():
            print(error.line(compiler, name))


def recorded(folder, name):
    """What as_before.sh has kept, unless a file is newer that was compiled."""
    record = folder / name.removesuffix(".cpp")
    files = record.with_suffix(".files")
    words = record.with_suffix(".words")
    if not words.exists():
        return None
    made = record.with_suffix(".command").stat().st_mtime
    compiled = [HERE.parents[1] / line for line in files.read_text("utf-8").splitlines()]
    if any(not p.exists() or p.stat().st_mtime > made for p in compiled):
        return None
    return words.read_text("utf-8", "replace")


def check_sizes(folder, command):
    compiler = compiler_name(command)
    rows = [line.split() for line in LIST.read_text("utf-8").splitlines() if line and line[0] != "#"]
    if compiler not in JUDGED:
        print(f"the errors of {compiler} are not judged")
        return 0
    listed = {row[3]: row for row in rows if row[0] == compiler}
    wrong = []
    programs = all_programs()
    for p in programs:
        said = recorded(folder, p.name)
        row = listed.pop(p.name, None)
        if said is None:
            wrong.append(f"{p.name} was not compiled as it is now: ctest -R '^fail'")
            continue
        error = error_of(p, said, compiler)
        if row is None:
            if error.is_listed():
                wrong.append(f"{p.name}: less than {error.most} characters, and the rule first; it is {error}")
            continue
        most = int(row[1])
        if not error.is_listed():
            wrong.append(f"{p.name} keeps the bounds: remove it from {LIST.name}")
        elif error.size > most or (row[2] == "rule" and not error.says_rule):
            wrong.append(f"{p.name} was better: {' '.join(row)}; it is {error}")
        elif error.size <= most - 2 * STEP or (row[2] != "rule" and error.says_rule):
            wrong.append(f"{p.name} is better than in {LIST.name}: {error.line(compiler, p.name)}")
    wrong += [f"there is no {name}, which {LIST.name} has" for name in listed]
    for line in wrong:
        print(f"FAILED  {line}")
    print(f"{len(programs)} errors of {compiler}, {len(wrong)} failed")
    return 1 if wrong or not programs else 0


def refused(path, command):
    program = read(Path(path))
    said = output_of(path, command)
    if "error: " not in said:
        print(f"FAILED  {path} compiles, or nothing was compiled:\n{said}")
        return 1
    is_error = re.compile(r"(error|note)[: ]|in call to|expansion of|static assertion")
    shown = [line for line in said.splitlines() if is_error.search(line)]
    for expected in filter(None, (program.expected, program.figures)):
        line = next((line for line in shown if expected in line), None)
        if line is None:
            print(f"FAILED  {path}: the error does not say \"{expected}\":\n{said}")
            return 1
        print(line)
    return 0


match sys.argv[1:]:
    case ["refused", path, *command] if command:
        sys.exit(refused(path, command))
    case ["all", *command] if command:
        sys.exit(max(refused(HERE / p.name, command) for p in all_programs()))
    case ["sizes", "--of", folder, compiler]:
        sys.exit(check_sizes(Path(folder), compiler))
    case ["sizes", *command] if command:
        sizes(command)
    case ["page"]:
        (HERE / "README.md").write_text(page(all_programs()), encoding="utf-8")
    case ["page", "--check"]:
        sys.exit(check_page(all_programs()))
    case _:
        sys.exit(__doc__)
