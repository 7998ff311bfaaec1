# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""What the bytes on the line show of a failure.

The request's own echo, another protocol, bytes that are no response; a port that this user may not open; several
registers of which some fail.
"""
import os
import shutil
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from any_device import Device, on_terminal
from odd_peer import odd_peer
from programs import Tool, play_tool, scene

ECHO = "what came is the request's own echo: try --echo on"
NO_ECHO = "the request did not come back as echo: try --echo off"


def complains(tool: Tool, name: str, text: str):
    """The last run has status 1, no output, and one line of complaint, which is this."""
    is_so = tool.last.status == 1 and tool.last.out == "" and tool.last.err == f"servobus: {text}\n"
    tool.check(name, is_so, f"expected {text}\n{tool.found()}")


TWO = "a request to node 1 had two responses: two devices have this address"
STRAY = "3 bytes came beside the responses: another program or master sends on this line, or it picks up noise"


@scene()
def beside_the_responses(tool: Tool):
    """What comes after a response is counted and said: a second response, or the bytes of somebody else."""
    tool.write("meter.csv", "address,name,type,access\n1,first,u16,ro\n2,second,u16,ro\n")
    device = Device()
    device.holding[1:3] = [300, 2400]
    with on_terminal(device) as port:
        for words, said in [("read", "first=300"), ("watch", "first=300"), ("doctor", "")]:
            device.follows, device.stray = 0.0, b""
            registers = {"read": "first second", "watch": "first", "doctor": ""}[words]
            on = f"{words} {port} meter.csv {registers} --timeout 500"
            # What follows a response comes between two rounds.
            on += " --count 3 --interval 200" if words == "watch" else ""
            tool.run(on)
            heard = tool.last.out + tool.last.err
            tool.check(f"{words}: nothing is said where nothing came", said in heard and "came beside" not in heard
                       and "two responses" not in heard, tool.found())
            device.follows = 0.005
            tool.run(on)
            tool.check(f"{words}: two responses to a request", TWO in tool.last.out + tool.last.err, tool.found())
            device.stray = b"\x55\x01\x66"
            tool.run(on)
            heard = tool.last.out + tool.last.err
            tool.check(f"{words}: bytes of somebody else", "came beside the responses: another program or master" in heard,
                       tool.found())
            device.stray = b"\x00\xff"
            tool.run(on)
            heard = tool.last.out + tool.last.err
            tool.check(f"{words}: what a driver gives as it is switched is nothing", "came beside" not in heard, tool.found())
        device.follows, device.stray = 0.005, b"\x55\x01\x66"
        tool.run(f"read {port} meter.csv first --timeout 500")
        tool.err_has("read: after one response", f"servobus: warning: {STRAY}")
        tool.status_is("read: what was read is read", 0)


@scene()
def doubled_responses(tool: Tool):
    with tool.simulated("zlac8015d --faults doubled --seed 1"):
        tool.run("doctor drive zlac8015d:1 --timeout 2000")
        tool.out_has("doctor of a drive: two responses to a request", f"refused  {TWO}")
    with tool.simulated("zlac8015d"):
        tool.run("doctor drive zlac8015d:1 --timeout 2000")
        tool.check("and not where each has one", TWO not in tool.last.out, tool.found())


@scene()
def driver_of_the_kernel(tool: Tool):
    """--rs485 is for a port whose driver the kernel switches; a pseudo-terminal has none."""
    with tool.simulated("zlac8015d"):
        for how in ["on", "rts-on-send", "rts-after-send", "rts-after-send,1", "rts-after-send,1,0", "on,0,0"]:
            tool.fails(f"--rs485 {how}", f"read drive zlac8015d bus_voltage --rs485 {how}", 1,
                       "cannot open drive: the port cannot switch an RS-485 driver so: ")
        tool.fails("scan", "scan drive --nodes 1 --rs485 on", 1, "the port cannot switch an RS-485 driver so: ")
        for how in ["off", "rts", "on,", "on,1,2,3", "on,x", "on,-1", "on,1001", "rts-after-send,1,"]:
            tool.fails(f"--rs485 {how}", f"read drive zlac8015d bus_voltage --rs485 {how}", 2,
                       f"--rs485 takes on, rts-on-send or rts-after-send, with ,BEFORE,AFTER in ms (0..1000), not '{how}'")
            tool.exits(f"scan --rs485 {how}", f"scan drive --rs485 {how}", 2)
    tool.fails("a gateway", "read mbap://127.0.0.1:1 raw 0 --rs485 on", 2,
               "the gateway switches the driver of its line, not --rs485")


@scene()
def local_echo(tool: Tool):
    """An adapter that receives what it sends."""
    with tool.simulated("zlac8015d --echo on"):
        for name, words, text in [
            ("read: the request's own echo", "read drive zlac8015d bus_voltage", f"bus_voltage: {ECHO}"),
            ("read: the echo alone", "read drive zlac8015d:9 bus_voltage --timeout 100 --retries 0",
             f"bus_voltage: {ECHO}"),
            ("read: an echo that is a well-formed response", "read drive raw 0x0212 --baud 115200", f"0x0212: {ECHO}"),
            ("G3: write: the request's own echo, as the read after it shows", "write drive zlac8015d left_max_current=13",
             "left_max_current: unknown, what came is the request's own echo: try --echo on"),
            ("G3: write: nothing is sent after an echo", "write drive zlac8015d node_address=2",
             f"node_address: not sent, {ECHO}"),
        ]:
            tool.run(words)
            complains(tool, name, text)
        tool.run("watch drive zlac8015d bus_voltage --count 2 --interval 10")
        rounds = [line for line in tool.last.lines if line.endswith(f"bus_voltage=({ECHO})")]
        tool.check("watch: the request's own echo, in each round", len(rounds) == 2)
        tool.err_has("watch: and at the end", f"no response in any round: {ECHO}")


@scene()
def no_local_echo(tool: Tool):
    with tool.simulated("zlac8015d"):
        for name, words, text in [
            ("read: no echo", "read drive zlac8015d bus_voltage --echo on", f"bus_voltage: {NO_ECHO}"),
            ("read: a response in place of the echo", "read drive raw 0x20A1:4 --echo on --baud 115200",
             f"0x20A1:4: {NO_ECHO}"),
        ]:
            tool.run(words)
            complains(tool, name, text)
        tool.run("watch drive zlac8015d bus_voltage --count 1 --interval 10 --echo on")
        tool.err_has("watch: no echo", f"no response in any round: {NO_ECHO}")


@scene()
def several_registers(tool: Tool):
    with tool.simulated("zlac8015d"):
        tool.run("read drive raw 0x3000 0x20A1 0x3001:2 0x2088 --baud 115200")
        refused = "refused, exception 2 (illegal data address)"
        tool.is_equal("read: each register that failed is named with its reason", tool.last.err,
                      f"servobus: 0x3000: {refused}; 0x3001:2: {refused}\n")
        tool.out_is("read: the others are printed", "0x20A1=2400 (0x0960)", "0x2088=0 (0x0000)")
        tool.status_is("read: and the status is 1", 1)
        tool.run("read drive zlac8015d:9 bus_voltage status_word --timeout 20 --retries 0")
        complains(tool, "read: no response to any", "bus_voltage: no response; status_word: no response")


RESPONSE = "01 03 02 09 60"
QUICK = "--retries 0 --timeout 200"


def read_from(tool: Tool, scheme: str, response: str, device: str, options: str) -> int:
    with odd_peer(response) as port:
        tool.run(f"read {scheme}://127.0.0.1:{port} {device} bus_voltage {options}")
    return port


@scene()
def gateway(tool: Tool):
    read_from(tool, "mbap", f"nnnn 0000 0005 {RESPONSE}", "zlac8015d", "")
    tool.out_is("mbap: the peer works", "bus_voltage=24.00 V")


@scene(
    ("mbap: RTU frames", f"{RESPONSE} BE 3C", "--retries 0"),
    ("mbap: RTU frames that are shorter than a header", "01 83 02 C0 F1", QUICK),
    ("mbap: a wrong length", f"nnnn 0000 FFFF {RESPONSE}", "--retries 0"),
)
def gateway_of_another_protocol(tool: Tool, name: str, response: str, options: str):
    port = read_from(tool, "mbap", response, "zlac8015d", options)
    complains(tool, name, f"bus_voltage: what came is no Modbus TCP: try tcp://127.0.0.1:{port}")


@scene(
    (*("mbap: another number", "mbap", f"FFFF 0000 0005 {RESPONSE}", "zlac8015d", QUICK),
     "11 bytes came, none a response of node 1"),
    (*("a glitch in front of a response", "tcp", f"55 55 55 55 55 55 {RESPONSE} BE 3C", "zlac8015d", QUICK),
     "13 bytes came, none a response of node 1"),
    ("a glitch", "tcp", "55", "zlac8015d:7", QUICK, "1 byte came, none a response of node 7"),
    ("a wrong CRC stays one", "tcp", f"{RESPONSE} BE 3D", "zlac8015d", "--retries 0", "wrong CRC"),
)
def gateway_with_odd_bytes(tool: Tool, name: str, scheme: str, response: str, device: str, options: str, text: str):
    read_from(tool, scheme, response, device, options)
    complains(tool, name, f"bus_voltage: {text}")


@scene()
def port_that_may_not_be_opened(tool: Tool):
    """Root may open any, but for one without its capabilities."""
    is_root = os.getuid() == 0
    unprivileged = ["setpriv", "--bounding-set=-all", "--inh-caps=-all"] if is_root else []
    if os.environ.get("ON_WINE"):
        return tool.say("left out: Windows has no groups of a port")
    if subprocess.run([*unprivileged, "true"], stderr=subprocess.DEVNULL).returncode != 0:
        return tool.say("left out: this machine lets root keep its capabilities")
    read = dict(words="read drive zlac8015d bus_voltage", program=[*unprivileged, tool.path])
    with tool.simulated("zlac8015d"):
        terminal = (tool.folder / "drive").resolve()
        if is_root:
            shutil.chown(terminal, group="tty")
        terminal.chmod(0o060)
        group = terminal.group()
        tool.run(**read)
        if group == "root":
            tool.say("left out: a pseudo-terminal has no group of its own here")
        else:
            complains(
                tool,
                "a port of another group",
                f"cannot open drive: no permission for the port; the group {group} may use it: "
                f"sudo usermod -aG {group} $USER, then log out and in again",
            )
        # The owner may not, although its program has the group: why is not known.
        grouped = ["setpriv", f"--regid={group}", "--keep-groups", *unprivileged[1:]] if is_root else []
        if grouped and group != "root":
            tool.run(words=read["words"], program=[*grouped, tool.path])
            complains(tool, "a port of the own group", "cannot open drive: no permission for the port")
        terminal.chmod(0)
        tool.run(**read)
        complains(tool, "a port that its group may not use either",
                  "cannot open drive: no permission for the port; only its owner may use it, and the administrator")


@scene()
def no_serial_device(tool: Tool):
    tool.run("read /dev/null zlac8015d bus_voltage")
    complains(tool, "no serial device: the system's reason",
              "cannot open /dev/null: no serial device, or not with these settings: Inappropriate ioctl for device")


play_tool()
