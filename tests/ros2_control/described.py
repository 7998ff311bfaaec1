# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""The package's files agree with each other: plugin description, URDF, controllers, launch file and page.

    python3 -B tests/ros2_control/described.py                    checks
    python3 -B tests/ros2_control/described.py --describe PORT    prints the description of <ros2_control> for a test program
"""
import py_compile
import re
import sys
import tempfile
import xml.etree.ElementTree as xml
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "examples/ros2_control"
checks = failed = 0


def check(name: str, condition, found: object = ""):
    global checks, failed
    checks += 1
    failed += 0 if condition else 1
    print(f"ok      {name}" if condition else f"FAILED  {name}\n        {found}")


def is_equal(name: str, found, expected):
    check(name, found == expected, f"found {found!r}, expected {expected!r}")


def robot(port: str) -> xml.Element:
    """The URDF with its argument; its properties are not needed in <ros2_control>."""
    return xml.fromstring((PACKAGE / "urdf/robot.urdf.xacro").read_text().replace("$(arg port)", port))


def describe(port: str):
    control = robot(port).find("ros2_control")
    print("name", control.get("name"))
    for parameter in control.find("hardware").iter("param"):
        print("param", parameter.get("name"), parameter.text)
    for component in [*control.iter("joint"), *control.iter("sensor")]:
        print(component.tag, component.get("name"))
        for one in component:
            print(one.tag.removesuffix("_interface"), one.get("name"))


def check_files():
    for path in sorted([*PACKAGE.rglob("*.xml"), *PACKAGE.rglob("*.xacro")]):
        try:
            xml.parse(path)
            check(f"{path.name} is well-formed", True)
        except xml.ParseError as error:
            check(f"{path.name} is well-formed", False, error)
    with tempfile.TemporaryDirectory() as folder:
        try:
            py_compile.compile(str(PACKAGE / "launch/robot.launch.py"), cfile=f"{folder}/launch.pyc", doraise=True)
            check("the launch file compiles", True)
        except py_compile.PyCompileError as error:
            check("the launch file compiles", False, error)


def check_names():
    library = xml.parse(PACKAGE / "servobus_hardware.xml").getroot()
    described = library.find("class")
    source = (PACKAGE / "servobus_zlac8015d_system.cpp").read_text()
    exported, base = re.search(r"PLUGINLIB_EXPORT_CLASS\(\s*([\w:]+)\s*,\s*([\w:]+)\s*\)", source).groups()
    is_equal("the description has the exported class", described.get("type"), exported)
    is_equal("and its base", described.get("base_class_type"), base)
    build = (PACKAGE / "CMakeLists.txt").read_text()
    check("the described library is built", f"add_library({library.get('path')} SHARED" in build, library.get("path"))
    control = robot("/dev/null").find("ros2_control")
    is_equal("the URDF names the described plugin", control.find("hardware/plugin").text, described.get("name"))
    package = xml.parse(PACKAGE / "package.xml").getroot()
    name = package.find("name").text
    check("the package's name is the project's", f"project({name} " in build, name)
    launch = (PACKAGE / "launch/robot.launch.py").read_text()
    is_equal("and the launch file's", re.search(r'FindPackageShare\("(\w+)"\)', launch).group(1), name)
    for needed in re.findall(r"find_package\((\w+) ", build):
        check(f"package.xml has {needed}", any(d.text == needed for d in package if d.tag.endswith("depend")))
    for executed in re.findall(r'package="(\w+)"', launch):
        check(f"package.xml has {executed}", any(d.text == executed for d in package if d.tag == "exec_depend"))


def check_controllers():
    all_of_them = yaml.safe_load((PACKAGE / "config/controllers.yaml").read_text())
    manager = all_of_them["controller_manager"]["ros__parameters"]
    driver = all_of_them["diff_drive_controller"]["ros__parameters"]
    whole = robot("/dev/null")
    joints = [joint.get("name") for joint in whole.find("ros2_control").iter("joint")]
    is_equal("the controller's joints are the URDF's", driver["left_wheel_names"] + driver["right_wheel_names"], joints)
    kinematic = {f"{w.get('side')}_wheel_joint" for w in whole.findall("{http://www.ros.org/wiki/xacro}wheel")}
    is_equal("the robot has the joints of <ros2_control>", kinematic, set(joints))
    properties = {p.get("name"): float(p.get("value")) for p in whole.iter("{http://www.ros.org/wiki/xacro}property")}
    for name, value in properties.items():
        is_equal(f"{name} is the URDF's", driver[name], value)
    launch = (PACKAGE / "launch/robot.launch.py").read_text()
    spawned = re.findall(r'executable="spawner", arguments=\["(\w+)"\]', launch)
    is_equal("the spawned controllers have a type", sorted(spawned), sorted(k for k in manager if k != "update_rate"))
    parameters = {p.get("name"): p.text for p in whole.find("ros2_control/hardware").iter("param")}
    check("the controller's timeout ends before the drive's",
          driver["cmd_vel_timeout"] * 1000 < int(parameters["command_timeout_ms"]))


def check_page():
    page = (PACKAGE / "README.md").read_text()
    text = next(line for line in page.splitlines() if line and not line.startswith("#"))
    check("the page's first line says stand-in", "stand-in" in text, text)
    header = (PACKAGE / "parameters.hpp").read_text()
    rows = dict(re.findall(r"^\| `(\w+)` \| ([^|]*) \|", page, re.M))
    names = re.findall(r'\{"(\w+)", &parameters::', header) + ["port"]
    is_equal("the page has each parameter", sorted(rows), sorted(names))
    members = dict(re.findall(r"(\w+) = ([\w.]+);", header.split("struct parameters {")[1].split("};")[0]))
    for name, value in members.items():
        if not name.endswith("counts_per_turn"):
            is_equal(f"with the default of {name}", rows.get(name, "").strip(), value)


if sys.argv[1:2] == ["--describe"]:
    describe(sys.argv[2])
else:
    check_files()
    check_names()
    check_controllers()
    check_page()
    print(f"{checks} checks, {failed} failed")
    sys.exit(1 if failed else 0)
