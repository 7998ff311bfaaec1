# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""--csv, --json and --log of read and watch. records.py judges the records.

If this machine does not allow a case, a line that begins with "NOT RUN" reports it.
"""
import csv
import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from programs import Tool, play_tool, scene, until
from records import csv_records, must_be_csv, must_be_json, must_be_like_read, must_be_recent

NOWHERE = "/dev/no-such-port"
NO_RESPONSE = "--timeout 20 --retries 0"
TIMES = "time,error,unix_time (ms)"
VOLTAGE = f"{TIMES},bus_voltage (V)"


def without_times(text: str) -> list[str]:
    """The lines with T for the times, which no test knows before."""
    text = re.sub(r"\d{4}-\d\d-\d\dT[0-9:]{8}\.\d{3}Z", "T", text)
    text = re.sub(r"^(T,[^,]*,)\d+", r"\1T", text, flags=re.M)
    return re.sub(r'("unix_ms":)\d+', r"\1T", text).splitlines()


def json_line(registers: str, errors: str = "") -> str:
    return '{"time":"T","unix_ms":T,"registers":{%s},"errors":{%s}}' % (registers, errors)


class Recording(Tool):
    def recorded(self, name: str, words: str, status: int, *lines: str):
        """What the tool prints, without the times."""
        ended = self.run(words)
        found = without_times(ended.out)
        self.check(name, ended.status == status and found == list(lines), f"expected {lines}\n{self.found()}")

    def judged(self, name: str, judge, *arguments, **more):
        try:
            judge(*arguments, **more)
            wrong = ""
        except Exception as error:
            wrong = f"{type(error).__name__}: {error}"
        self.check(name, not wrong, wrong)

    def rows_are(self, name: str, file: str, rows: int, or_more: bool = False):
        self.judged(name, must_be_csv, self.read(file), rows, or_more)

    def err_is_one_line(self, name: str):
        self.check(name, len(self.last.err_lines) == 1)


@scene()
def refused_options(tool: Recording):
    """Before anything is sent: there is no such port."""
    for name, words, text in [
        ("--csv and --json together", f"read {NOWHERE} zlac8015d bus_voltage --csv --json",
         "--csv and --json exclude each other"),
        ("a register twice has no columns", f"watch {NOWHERE} zlac8015d bus_voltage 0x20A1 --csv",
         "bus_voltage is given twice"),
        ("nor has a word twice", f"read {NOWHERE} raw 0x2088:2 0x2089 --json", "0x2089 is given twice"),
        ("--csv takes no value", f"read {NOWHERE} zlac8015d bus_voltage --csv=1", "--csv takes no value"),
        ("--log needs one", f"read {NOWHERE} zlac8015d bus_voltage --log", "--log needs a value"),
        ("write has no records", f"write {NOWHERE} zlac8015d left_max_current=1 --csv", "unknown option '--csv'"),
        ("backup has none", f"backup {NOWHERE} zlac8015d --json", "unknown option '--json'"),
    ]:
        tool.fails(name, words, 2, text)


@scene()
def formats(tool: Recording):
    with tool.simulated("zlac8015d", named="a zlac8015d"):
        tool.run("write drive zlac8015d left_max_current=12.5 left_target_speed=-7 --yes")
        tool.recorded(
            "CSV: units in the header, plain numbers, codes by number",
            "read drive zlac8015d bus_voltage left_max_current motor_temperature mode_of_operation left_target_speed"
            " --csv",
            0,
            f"{VOLTAGE},left_max_current (A),motor_temperature_left (degC),motor_temperature_right (degC),"
            "mode_of_operation,left_target_speed (counts)",
            "T,,T,24.00,12.5,31,32,0,-7",
        )
        tool.judged("it is CSV, and loads into ModbusScope", must_be_csv, tool.last.out, 1)
        tool.recorded(
            "JSON: numbers with units, codes with their names",
            "read drive zlac8015d bus_voltage mode_of_operation status_word --json",
            0,
            json_line(
                '"bus_voltage":{"value":24.00,"unit":"V"},"mode_of_operation":{"value":0,"text":"undefined"},'
                '"status_word":{"value":0,"text":"left_released+right_released"}'
            ),
        )
        tool.recorded("words without a map: a column each", "read drive raw 0x20A1 0x2088:2 --csv", 0,
                      f"{TIMES},0x20A1,0x2088,0x2089", "T,,T,2400,65529,0")
        tool.recorded("and in JSON", "read drive raw 0x2088:2 --json", 0,
                      json_line('"0x2088":{"value":65529},"0x2089":{"value":0}'))
        words = "read drive zlac8015d bus_voltage --csv"
        tool.run(words, env={"TZ": "Asia/Tokyo"})
        tool.judged("times are UTC, whatever the time zone", must_be_recent, tool.last.out)
        german = ["localedef", "-i", "de_DE", "-f", "UTF-8", tool.folder / "de_DE.UTF-8"]
        if shutil.which("localedef") and subprocess.run(german, capture_output=True).returncode == 0:
            tool.run(words, env={"LOCPATH": str(tool.folder), "LC_ALL": "de_DE.UTF-8"})
            tool.check("numbers have a point in every locale", tool.last.lines[-1].endswith(",24.00"))
        else:
            tool.say("NOT RUN: a locale with a decimal comma, since localedef(1) cannot make one")


@scene()
def formats_of_other_drives(tool: Recording):
    """Pairs, negative codes, a parameter number."""
    with tool.simulated("yako-closed-loop", named="a yako-closed-loop"):
        tool.run(
            "write drive yako-closed-loop homing_method=mechanical_stop_1 home_offset=-70000 pair_word_order=low_first"
        )
        tool.recorded("a pair is one column, a negative code its number",
                      "read drive yako-closed-loop home_offset homing_method actual_speed --csv", 0,
                      f"{TIMES},home_offset (pulse),homing_method,actual_speed (counts)", "T,,T,-70000,-1,0")
    with tool.simulated("c630s", named="a c630s"):
        tool.recorded("a parameter number is called by its name", "read drive c630s P06-03 --csv", 0,
                      f"{TIMES},target_speed (r/min)", "T,,T,200")


@scene(
    ("zlac8015d", "left_max_current=12.5 left_target_speed=-7"),
    ("yako-closed-loop", "homing_method=mechanical_stop_1 home_offset=-70000 pair_word_order=low_first"),
    ("c630s", ""),
)
def like_read(tool: Recording, device: str, before: str):
    """Every register of the drive, as read prints it."""
    register_map = tool.start(f"map {device}").wait().out
    # power_on_time counts seconds meanwhile.
    names = [
        row["name"]
        for row in csv.DictReader(register_map.splitlines())
        if row["access"] != "wo" and row["name"] != "power_on_time"
    ]
    with tool.simulated(device):
        if before:
            tool.run(f"write drive {device} {before} --yes")
        words = f"read drive {device} {' '.join(names)}"
        read = tool.run(words).out
        for kind, name in [("csv", "each column of CSV is what read prints"), ("json", "and each one of JSON")]:
            tool.run(f"{words} --{kind}")
            tool.judged(f"{device}: {name}", must_be_like_read, kind, tool.last.out, read, register_map)


@scene()
def errors(tool: Recording):
    refused = "refused, exception 2 (illegal data address)"
    with tool.simulated("zlac8015d"):
        tool.recorded("an error is named, and has nan for its columns", "read drive raw 0x20A1 0x3000:2 0x2089 --csv",
                      1, f"{TIMES},0x20A1,0x3000,0x3001,0x2089",
                      "T,0x3000:2: refused exception 2 (illegal data address),T,2400,nan,nan,0")
        tool.err_has("as on standard error", f"0x3000:2: {refused}")
        tool.err_is_one_line("in one line")
        tool.judged("its row is CSV", must_be_csv, tool.last.out, 1)
        tool.recorded("JSON has null, and the error beside it", "read drive raw 0x3000 0x2089 --json", 1,
                      json_line('"0x3000":{"value":null},"0x2089":{"value":0}', f'"0x3000":"{refused}"'))
        tool.judged("its line is JSON", must_be_json, tool.last.out, 1)
        tool.recorded("no response: every error is named",
                      f"read drive zlac8015d:9 bus_voltage left_max_current --csv {NO_RESPONSE}", 1,
                      f"{VOLTAGE},left_max_current (A)",
                      "T,bus_voltage: no response; left_max_current: no response,T,nan,nan")
        tool.err_has("standard error has the first", "bus_voltage: no response")
        tool.err_is_one_line("and no other")
        tool.recorded("no response in JSON: a code has no name",
                      f"read drive zlac8015d:9 mode_of_operation --json {NO_RESPONSE}", 1,
                      json_line('"mode_of_operation":{"value":null,"text":null}', '"mode_of_operation":"no response"'))
        with open("/dev/full", "wb") as full:
            tool.run("read drive zlac8015d bus_voltage --csv", out=full)
        tool.status_is("standard output that cannot be written", 1)
        tool.err_has("is said once", "cannot write standard output: No space left on device")


# watch


@scene()
def watched(tool: Recording):
    with tool.simulated("zlac8015d"):
        tool.run("watch drive zlac8015d bus_voltage left_actual_speed --csv --count 3 --interval 30")
        tool.status_is("watch --csv: status 0", 0)
        tool.judged("a row a round", must_be_csv, tool.last.out, 3)
        tool.check("a header once", f"{VOLTAGE},left_actual_speed (r/min)" in tool.last.lines)
        times = [int(row[2]) for row in csv_records(tool.last.out)[1]]
        tool.check("the times are those of the rounds", times[-1] - times[0] >= 40, times)
        tool.run("watch drive zlac8015d bus_voltage status_word --json --count 3 --interval 10")
        tool.judged("watch --json: an object a round", must_be_json, tool.last.out, 3)


@scene()
def unplugged(tool: Recording):
    with tool.simulated("zlac8015d") as drive:
        watcher = tool.start(f"watch drive zlac8015d bus_voltage --csv --interval 10 {NO_RESPONSE}")

        def comes(name: str, pattern: str):
            tool.check(name, until(lambda: re.search(pattern + "\n$", watcher.out)), watcher.out[-2000:])

        value = r",,[0-9]*,24\.00"
        comes("rows come", value)
        drive.send(signal.SIGUSR1)
        comes("an unplugged drive is a row with an error", "bus_voltage: no response,[0-9]*,nan")
        drive.send(signal.SIGUSR1)
        comes("and its values come again", value)
        tool.ends(watcher, signal.SIGINT)
        tool.status_is("an interrupt ends it with status 0", 0)
        tool.judged("all rows are whole", must_be_csv, tool.last.out, 3, or_more=True)


@scene()
def lost_port(tool: Recording):
    with tool.simulated("zlac8015d") as drive:
        watcher = tool.start("watch drive zlac8015d bus_voltage left_max_current --csv --interval 10")
        tool.check("rows come", until(lambda: watcher.out), watcher.err)
        drive.stop()
        gone = r"left_max_current: the port is gone[^,]*,[0-9]*,nan,nan\n"
        tool.check("a lost port is a row with an error each round",
                   until(lambda: len(re.findall(gone, watcher.out)) > 1), watcher.out[-2000:])
        tool.ends(watcher, signal.SIGINT)
        tool.status_is("a port that is still gone at Ctrl-C is status 1", 1)
        tool.err_has("which says so", "the port is gone")
        last = re.search(r"left_max_current: [^,]+,[0-9]*,[^,]*,nan\n$", tool.last.out)
        tool.check("after the rows that have it", last)
        tool.judged("all rows are whole, so are those", must_be_csv, tool.last.out, 1, or_more=True)


# --log


@scene()
def logs(tool: Recording):
    read = "read drive zlac8015d bus_voltage"
    with tool.simulated("zlac8015d"):
        tool.says("--log: standard output is as without it", f"{read} --log log.csv", "bus_voltage=24.00 V")
        tool.run(f"{read} --csv --log log.csv")
        tool.out_is("with --csv too", "bus_voltage=24.00 V")
        rows = [VOLTAGE, "T,,T,24.00", "T,,T,24.00"]
        found = without_times(tool.read("log.csv"))
        tool.is_equal("each appends a row, and only the first a header", found, rows)
        tool.run("watch drive zlac8015d bus_voltage --count 2 --interval 10 --log log.csv")
        rounds = [line for line in tool.last.lines if re.fullmatch(r"[0-9.]* bus_voltage=24\.00 V", line)]
        tool.check("watch --log: a line a round as without it", len(rounds) == 2)
        tool.check("and nothing else", len(tool.last.lines) == 2)
        tool.rows_are("its rows are appended", "log.csv", 4)
        tool.exits("no response: status 1", f"read drive zlac8015d:9 bus_voltage {NO_RESPONSE} --log log.csv", 1)
        tool.err_is_one_line("in one line")
        rows += ["T,,T,24.00", "T,,T,24.00", "T,bus_voltage: no response,T,nan"]
        tool.is_equal("is a row too", without_times(tool.read("log.csv")), rows)
        tool.run(f"{read} --json --log log.json")
        tool.out_is("--json --log: standard output is for people", "bus_voltage=24.00 V")
        tool.exits("JSON of other registers", "read drive zlac8015d left_max_current --json --log log.json", 0)
        tool.check("goes into the same file", len(tool.lines("log.json")) == 2)
        tool.write("empty", "")
        tool.run(f"{read} --log empty")
        tool.rows_are("an empty file gets a header", "empty", 1)
        (tool.folder / "linked").symlink_to("log.csv")
        tool.run(f"{read} --log linked")
        tool.rows_are("a link is followed", "log.csv", 6)
        refused_logs(tool)


def refused_logs(tool: Recording):
    """No port is opened for them."""
    folder = tool.folder
    tool.write("torn", tool.read("log.csv")[:-1])
    (folder / "folder").mkdir()
    (folder / "dangling").symlink_to("nothing")
    os.mkfifo(folder / "fifo")
    for name, status, text, log, words in [
        ("a log of other columns", 2, "it has other columns", "log.csv", "zlac8015d left_max_current"),
        ("of more", 2, "it has other columns", "log.csv", "zlac8015d bus_voltage left_max_current"),
        ("of JSON, for CSV", 2, "it has other columns", "log.json", "zlac8015d bus_voltage"),
        ("of CSV, for JSON", 2, "it is no log of --json", "log.csv", "zlac8015d bus_voltage --json"),
        ("whose last line has no end", 2, "its last line has no end", "torn", "zlac8015d bus_voltage"),
        ("a folder", 1, "cannot write folder: Is a directory", "folder", "zlac8015d bus_voltage"),
        ("in no folder", 1, "No such file or directory", "none/log", "zlac8015d bus_voltage"),
        ("a link to nothing", 1, "No such file or directory", "dangling", "zlac8015d bus_voltage"),
        ("a FIFO", 1, "it is no regular file", "fifo", "zlac8015d bus_voltage"),
        ("a device", 1, "it is no regular file", "/dev/full", "zlac8015d bus_voltage"),
    ]:
        before = tool.read(log) if (folder / log).is_file() else None
        command = "watch" if "--json" in words else "read"
        tool.fails(name, f"{command} {NOWHERE} {words} --log {log}", status, text)
        if before is not None:
            tool.check("and stays as it was", tool.read(log) == before)
    tool.fails("the port itself", "read drive zlac8015d bus_voltage --log drive", 1,
               "cannot write drive: it is no regular file")
    read = f"read {NOWHERE} zlac8015d bus_voltage --log"
    tool.fails("no such port", f"{read} unmade", 1, "there is no such port")
    tool.check("leaves no empty log", not tool.exists("unmade"))
    tool.write("kept", "")
    tool.run(f"{read} kept")
    tool.check("but an empty file that was there before", tool.exists("kept") and tool.read("kept") == "")
    protected_log(tool, read)


def protected_log(tool: Recording, read: str):
    """As a user other than root, who may write everything."""
    shutil.copy(tool.folder / "log.csv", tool.folder / "protected")
    (tool.folder / "protected").chmod(0o444)
    shutil.copy(tool.path, tool.folder / "servobus")
    (tool.folder / "servobus").chmod(0o755)
    program = [str(tool.folder / "servobus")]
    if os.getuid() == 0:
        tool.folder.chmod(0o711)
        program = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", *program]
        if subprocess.run([*program[:-1], "test", "-x", program[-1]], stderr=subprocess.DEVNULL).returncode != 0:
            return tool.say("NOT RUN: a log that may not be written, since setpriv(1) is not permitted")
    tool.run(f"{read} {tool.folder}/protected", program=program)
    tool.status_is("that may not be written", 1)
    tool.err_has("it says so", f"cannot write {tool.folder}/protected: Permission denied")


@scene()
def two_programs_with_one_log(tool: Recording):
    with tool.simulated("zlac8015d"):
        watcher = tool.start("watch drive zlac8015d bus_voltage --interval 10 --log shared")
        is_written = until(lambda: tool.exists("shared") and tool.read("shared"))
        tool.check("a log is being written", is_written, watcher.err)
        tool.fails("two programs do not write one log", f"read {NOWHERE} zlac8015d bus_voltage --log shared", 1,
                   "cannot write shared: another program logs into it")
        tool.ends(watcher, signal.SIGINT)
        tool.rows_are("which stays whole", "shared", 1, or_more=True)


@scene()
def log_that_cannot_grow(tool: Recording):
    """A row does not fit, and what was written of it is taken back. The limit holds for files, not for pipes."""
    limited = '(ulimit -f 1; "$@" 2>&1 >/dev/null; echo "$?" >&3) 3>status | cat >&2'
    with tool.simulated("zlac8015d"):
        tool.run("watch drive zlac8015d bus_voltage --interval 1 --log grown", sh=limited)
        tool.is_equal("a log that cannot grow ends watch", tool.read("status"), "1\n")
        tool.rows_are("and has whole rows only", "grown", 5, or_more=True)
        tool.run("read drive zlac8015d bus_voltage --log grown", sh=limited)
        tool.err_has("it says why", "cannot write grown: File too large")
        tool.err_is_one_line("in one line")


play_tool(Recording)
