# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Help, manual page and completion, which are made from the table of the commands.

What they must have is taken from elsewhere: from the pages and the other tests, which write command lines, and from
what the command line accepts.
"""
import ast
import csv
import re
import shutil
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from programs import Tool, play_tool, scene
from terminal import Terminal

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PAGES = [(ROOT / page).read_text() for page in ("examples/servobus/README.md", "README.md")]
OTHERS = [path.read_text() for path in sorted(HERE.glob("*.py")) if path.name != "command_line.py"]
WRONG_ON_PURPOSE = {"--colour", "--dryrun", "--jsno"}
DEVICES = "zlac8015d", "yako-closed-loop", "yako-open-loop", "c630s"


class Documented(Tool):
    """A stage with the texts that are made from the table of the commands."""

    def __enter__(self):
        super().__enter__()
        self.help = self.start("--help").wait().out
        self.manual = self.start("manual").wait().out
        self.write("completion", self.start("completion bash").wait().out)
        return self

    def commands(self) -> list[str]:
        return re.findall(r'^\.SS "\\fB([a-z]*)\\fR', self.manual, re.M)

    def options(self, command: str) -> list[str]:
        """Those of a command in the manual page: its own and those that it shares."""
        found, is_ours = [], False
        for line in self.manual.splitlines():
            if line.startswith(".SH"):
                is_ours = False
            elif line.startswith(".SS"):
                is_ours = rf"\fB{command}\fR" in line
            elif line.startswith("For "):
                is_ours = command in re.findall("[a-z]+", line)
            elif is_ours and (option := re.match(r"\\fB(\\-\\-.*?)\\fR", line)):
                found.append(option[1].replace("\\", ""))
        return sorted(found)

    def completed(self, line: str, breaks: str = ":=", kind: str = "9") -> str:
        """What bash would complete the line with; with the kind 63 what it lists."""
        words = ["bash", str(HERE / "words.bash"), "completion", self.path, breaks, line, kind]
        return self.run([], program=words).out.strip("\n")


@scene()
def written_commands(tool: Documented):
    """Commands that pages write after `servobus`, and that the other tests run."""
    written = set(re.findall(r'\.(?:run|start)\(f?"([a-z]+) ', "\n".join(OTHERS)))
    for page in PAGES:
        written |= set(re.findall(r"(?:^    |`)(?:\./)?servobus ([a-z]+) ", page, re.M))
    tool.check("pages and tests write most commands", len(written) >= 10, written)
    for command in sorted(written):
        tool.check(f"{command} is in the manual page", command in tool.commands())


def texts_of(source: str) -> list[str]:
    """The strings of a test. A command line is one of them, or a part of one."""
    constants = [node.value for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Constant)]
    return [value for value in constants if isinstance(value, str)]


@scene()
def written_options(tool: Documented):
    """Options that the tool's page writes, the command lines of both pages, and those of the other tests."""
    option = "(--[a-z0-9]+(?:-[a-z]+)*)"
    written = set(re.findall(f'(?:^|[ `"]){option}', PAGES[0], re.M))
    for line in re.findall("^    servobus .*", PAGES[1], re.M):
        written |= set(re.findall(f'[ `"]{option}', line))
    for source in OTHERS:
        written |= set(re.findall(rf'(?:\.run\(|\.says\("[^"]*", )"{option}', source))
        written |= {one for text in texts_of(source) for one in re.findall(f" {option}", text)}
    for one in sorted(written - WRONG_ON_PURPOSE):
        escaped = one.replace("-", "\\-")
        if one in ("--help", "--version"):
            tool.check(f"{one} is in the manual page", escaped in tool.manual)
        else:
            tool.check(f"{one} is in the manual page", rf"fB{escaped}\fR" in tool.manual)
            tool.check(f"{one} is in --help", re.search(f"^  {one} ", tool.help, re.M))


# What the command line accepts


@scene()
def every_command(tool: Documented):
    for command in tool.commands():
        options = tool.options(command)
        tool.check(f"{command} is in --help", re.search(f"^  servobus {command}( |$)", tool.help, re.M))
        tool.check(f"{command} is completed", command in tool.completed(f"servobus {command}").split())
        tool.check(f"{command}: is in the tool's page", any(f"servobus {command}" in page for page in PAGES))
        tool.run(command)
        tool.err_lacks(f"{command} is a command", "unknown command")
        for option in options:
            tool.run([command, option])
            tool.err_lacks(f"{command} {option} is accepted", "unknown option")
        help_of = tool.run([command, "--help"])
        tool.status_is(f"{command} --help: status 0", 0)
        named = sorted(re.findall("^  (--[a-z0-9-]+)", help_of.out, re.M))
        tool.is_equal(f"{command} --help has its options and no other", named, options)
        candidates = sorted(set(tool.completed(f"servobus {command} --").split()) - {"--help"})
        tool.is_equal(f"{command}: its options are completed and no other", candidates, options)
        tool.check(f"help {command} is the same", tool.run(["help", command]).out == help_of.out)


@scene()
def help_texts(tool: Documented):
    read = tool.run("read --help").out
    others = [option for option in ("--yes", "--faults", "--interval") if option in read]
    tool.check("read --help has not what only others take", not others)
    tool.check("read --help says what PORT is", re.search("^PORT  *a serial device", read, re.M))
    tool.check("and no word that it does not take", not re.search("^VALUE", read, re.M))
    tool.run("write PORT zlac8015d left_max_current=1 --help")
    is_of_write = re.search("^servobus write ", tool.last.out, re.M)
    tool.check("--help after other words is the command's", is_of_write)
    tool.check("--help of what is no command is that of all", tool.run("fly --help").out == tool.help)
    too_long = [line for line in tool.help.splitlines() if len(line) > 80]
    tool.check("no line of --help is longer than 80 columns", not too_long, too_long)


# The manual page


def words_of(text: str) -> set[str]:
    return set(re.sub("[.:,]", "", re.sub("^[a-z]*: ", "", text, flags=re.M)).lower().split())


@scene()
def manual_page(tool: Documented):
    version = tool.run("--version").out.strip()
    tool.check("manual: its version is that of --version", f'.TH SERVOBUS 1 "" "{version}"' in tool.manual)
    strange = re.findall(r"[^ -~\n]", tool.manual)
    tool.check("manual: plain text of its own characters", not strange, strange)
    tool.fails("manual takes no words", "manual read", 2, "manual takes no words")
    tool.write("servobus.1", tool.manual)
    if shutil.which("groff"):
        page = tool.run("-man -Tutf8 -ww -P-c -P-b -P-u servobus.1", program=["groff"])
        tool.check("manual: groff has no warning", page.err == "")
        tool.out_has("manual: an apostrophe is one", "the register's content")
        tool.out_has("manual: a tilde is one", "~/.bashrc")
        tool.out_has("manual: a hyphen is one that can be typed", "--dry-run")
        missing = words_of(tool.help) - words_of(page.out)
        tool.check("manual: all words of --help are in it", not missing, missing)
    if shutil.which("man") and tool.run("--version", program=["man"]).out.startswith("man "):
        page = tool.run("--warnings -l servobus.1", program=["man"])
        tool.check("manual: man has no warning", page.err == "" and page.out != "")


# Completion


@scene()
def completion(tool: Documented):
    for name, words, text in [
        ("completion takes a shell", "completion", "completion takes one shell: bash"),
        ("completion of a shell that has none", "completion tcsh", "no completion for 'tcsh'; bash has one"),
    ]:
        tool.fails(name, words, 2, text)
    tool.run("-n completion", program=["bash"])
    tool.status_is("completion: bash reads the script", 0)


# A line, what takes the place of its last word, and what does where bash breaks no words at : and =.
COMPLETIONS = [
    ("servobus sc", "scan"),
    ("servobus --v", "--version"),
    ("servobus help res", "restore"),
    ("servobus fly ", ""),
    ("servobus map ", "c630s yako-closed-loop yako-open-loop zlac8015d"),
    ("servobus read p ", "c630s yako-closed-loop yako-open-loop zlac8015d raw"),
    ("servobus backup p ", "c630s yako-closed-loop yako-open-loop zlac8015d"),
    ("servobus alarms ", "c630s yako-closed-loop yako-open-loop zlac8015d"),
    ("servobus alarms c630s ", ""),
    ("servobus completion ", "bash"),
    ("servobus map zlac8015d bus_v", "bus_voltage"),
    ("servobus map zlac8015d software_version ", ""),
    ("servobus map fly ", ""),
    ("servobus map zlac8015d --l", "--long"),
    ("servobus read tcp://10.0.0.1:4001 za", "-o default: "),
    ("servobus read tcp://10.0.0.1:4001 zl", "zlac8015d"),
    ("servobus read mbap://[::1] zlac8015d:3 bus_v", "bus_voltage"),
    ("servobus read tc", "-o nospace: tcp://"),
    ("servobus scan mbap:", "-o nospace: //", "-o nospace: mbap://"),
    ("servobus read ./dri", "-o default: "),
    ("servobus restore p c630s:1 ", "-o default: "),
    ("servobus backup p c630s > ", "-o default: "),
    ("servobus read p zlac8015d bus_voltage --log ", "-o default: "),
    ("servobus read p zlac8015d:1 software_v", "software_version"),
    ("servobus read p zlac8015d software_version software_v", ""),
    ("servobus read p --retries 2 zlac8015d bus_v", "bus_voltage"),
    ("servobus read p --retries=2 zlac8015d bus_v", "bus_voltage"),
    ("servobus read p raw ", "-o nospace: coil: discrete: holding: input:"),
    ("servobus read p raw:3 in", "-o nospace: input:"),
    ("servobus read p raw coil:1", "-o nospace: "),
    ("servobus write p raw ", "-o nospace: coil: holding:"),
    ("servobus read p fly ", ""),
    ("servobus write p zlac8015d:1 left_max_c", "-o nospace: left_max_current="),
    ("servobus write p zlac8015d bus_v", "-o nospace: "),
    ("servobus write p zlac8015d left_max_current=", ""),
    ("servobus write p zlac8015d control_word=qu", "quick_stop", "control_word=quick_stop"),
    ("servobus write p yako-closed-loop rs485_format=", "8N1 8N2 8E1 8O1",
     "rs485_format=8N1 rs485_format=8N2 rs485_format=8E1 rs485_format=8O1"),
    ("servobus read p zlac8015d --format 8N", "8N1 8N2"),
    ("servobus read p zlac8015d --format=8E", "8E1", "--format=8E1"),
    ("servobus sim zlac8015d --echo ", "on off"),
    ("servobus sim zlac8015d --faults ", "-o nospace: late lossy noisy doubled cut unplugged none"),
    ("servobus sim zlac8015d --faults late,l", "-o nospace: late,lossy"),
    ("servobus scan p --format=8N1,8O", "-o nospace: 8N1,8O1", "-o nospace: --format=8N1,8O1"),
    ("servobus restore p c630s f --dry-run --d", ""),
    ("servobus restore p c630s f --d", "--dry-run"),
]


@scene()
def listed_sentences(tool: Documented):
    """A list of registers has a sentence for each; what is inserted has none."""
    listed = tool.completed("servobus map zlac8015d left_max_", kind="63")
    tool.check("a list has names and sentences", re.search("left_max_current  +[A-Z][a-z]+ ", listed), listed)
    inserted = tool.completed("servobus map zlac8015d left_max_")
    tool.check("a tab inserts names alone", all(word.startswith("left_max_") for word in inserted.split()), inserted)
    alone = tool.completed("servobus map zlac8015d left_max_current", kind="63")
    tool.is_equal("one alone is inserted without its sentence", alone, "left_max_current")
    written = tool.completed("servobus write /dev/null zlac8015d left_target_", kind="63")
    tool.check("for a write too", re.search("left_target_speed=  +[A-Z]", written), written)


@scene()
def completed_lines(tool: Documented):
    for line, expected, *unbroken in COMPLETIONS:
        tool.is_equal(f"completion: {line}", tool.completed(line), expected)
        without = unbroken[0] if unbroken else expected
        tool.is_equal(f"completion without word breaks: {line}", tool.completed(line, breaks=""), without)
    for line, *words in [
        ("servobus ", "map", "restore", "--help"),
        ("servobus read ", "tcp://", "mbap://"),
        ("servobus write p yako-closed-loop input_polarity=", "x0", "x1"),
        ("servobus write p yako-closed-loop input_polarity=x0+", "x0+x1"),
    ]:
        candidates = tool.completed(line).split()
        for word in words:
            tool.check(f"completion: {line} offers {word}", word in candidates)


@scene(*DEVICES)
def completed_registers(tool: Documented, device: str):
    registers = list(csv.DictReader(tool.start(f"map {device}").wait().out.splitlines()))
    for what, command, without, head, suffix in [
        ("shown", "map", None, "", ""),
        ("read", "read p", "wo", "", ""),
        ("written", "write p", "ro", "-o nospace: ", "="),
    ]:
        expected = head + " ".join(row["name"] + suffix for row in registers if row["access"] != without)
        candidates = tool.completed(f"servobus {command} {device} ")
        tool.is_equal(f"completion: every register of {device} that can be {what}", candidates, expected)


@scene(
    ("servobus wri\tp zlac8015d:1 control_w\tqu\t", "servobus write p zlac8015d:1 control_word=quick_stop "),
    ("servobus read tcp://h:1 zl\tbus_v\t--log=help\t", "servobus read tcp://h:1 zlac8015d bus_voltage --log=help "),
)
def typed(tool: Documented, keys: str, expected: str):
    """As a person types it."""
    prompt = "typed> "
    (tool.folder / "bin").mkdir()
    (tool.folder / "bin/servobus").symlink_to(tool.path)
    tool.write("help", "")
    tool.write(
        "rc",
        f"PATH={tool.folder}/bin:$PATH\n. <(servobus completion bash)\nbind 'set bell-style none'\nPS1='{prompt}'\n",
    )
    bash = ["bash", "--noprofile", "--rcfile", "rc", "-i"]
    with Terminal(bash, tool.folder, {"TERM": "dumb"}) as terminal:
        terminal.shows(prompt)
        terminal.type(keys + "|")  # which comes once the completions before it have ended
        terminal.shows("|")
        terminal.process.kill()
    shown = terminal.shown.splitlines()[-1].removeprefix(prompt)
    tool.is_equal(f"typed in bash: {expected}", shown, expected + "|")


play_tool(Documented)
