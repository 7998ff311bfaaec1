# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Checks the manifests of unpacked packages: their form by what their formats document, and the version.

manifests.py VERSION ARDUINO PLATFORMIO ZEPHYR ESP_IDF VCPKG     the folders of the packages
"""
import json
import re
import sys
from pathlib import Path

import yaml

VERSION = sys.argv[1]
ARDUINO, PLATFORMIO, ZEPHYR, ESP_IDF, VCPKG = map(Path, sys.argv[2:])
wrong = []


def expect(holds, line):
    if not holds:
        wrong.append(line)


def arduino():
    lines = (ARDUINO / "library.properties").read_text().splitlines()
    have = dict(line.split("=", 1) for line in lines)
    expect(len(have) == len(lines), "library.properties: a line twice")
    for field in ("name", "version", "author", "maintainer", "sentence", "paragraph", "category", "url", "architectures"):
        expect(field in have, f"library.properties: no {field}")
    expect(have["version"] == VERSION, f"library.properties: version {have['version']}")
    expect(re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_.\- ]*", have["name"]), "library.properties: name")
    expect(have["architectures"] == "*" and "depends" not in have, "library.properties: architectures, depends")
    for header in have["includes"].split(","):
        expect((ARDUINO / "src" / header).is_file(), f"library.properties: includes {header}, which is not in src")
    for line in (ARDUINO / "keywords.txt").read_text().splitlines():
        expect(re.fullmatch(r"\w+\t(KEYWORD1|KEYWORD2|LITERAL1)", line), f"keywords.txt: {line}")
    expect(not (ARDUINO / "src/servobus/posix").exists(), "arduino: headers for an operating system")
    for sketch in ARDUINO.glob("examples/*/*.ino"):
        expect(sketch.stem == sketch.parent.name, f"{sketch} is not called like its folder")


def platformio():
    manifest = json.loads((PLATFORMIO / "library.json").read_text())
    known = {"$schema", "name", "version", "description", "keywords", "homepage", "repository", "authors", "license",
             "frameworks", "platforms", "headers", "examples", "dependencies", "export", "scripts", "build"}
    expect(set(manifest) <= known, f"library.json: {set(manifest) - known}")
    expect(re.fullmatch("[a-z0-9]+(-[a-z0-9]+)*", manifest["name"]) and len(manifest["name"]) <= 50, "library.json: name")
    expect(manifest["version"] == VERSION and len(VERSION) <= 20, f"library.json: version {manifest['version']}")
    expect(0 < len(manifest["description"]) <= 255, "library.json: description")
    expect(all(re.fullmatch("[a-z0-9]+(-[a-z0-9]+)*", word) for word in manifest["keywords"]), "library.json: keywords")
    expect(all(author["name"] for author in manifest["authors"]), "library.json: authors")
    expect(manifest["frameworks"] == "*" and manifest["platforms"] == "*", "library.json: frameworks, platforms")
    for header in manifest["headers"]:
        expect((PLATFORMIO / "include" / header).is_file(), f"library.json: no header {header}")
    for example in manifest["examples"]:
        for name in example["files"]:
            expect((PLATFORMIO / example["base"] / name).is_file(), f"library.json: no example {name}")
    expect(set(manifest["build"]) == {"srcFilter"}, "library.json: build")
    expect(not list(PLATFORMIO.glob("src")) and not list(PLATFORMIO.glob("include/**/*.cpp")), "platformio: sources")


def zephyr():
    manifest = yaml.safe_load((ZEPHYR / "zephyr/module.yml").read_text())
    expect(set(manifest) == {"name", "build"} and manifest["name"] == "servobus", "module.yml: fields")
    expect(set(manifest["build"]) == {"cmake", "kconfig"}, "module.yml: build")
    expect((ZEPHYR / manifest["build"]["cmake"] / "CMakeLists.txt").is_file(), "module.yml: build.cmake")
    expect((ZEPHYR / manifest["build"]["kconfig"]).is_file(), "module.yml: build.kconfig")


def esp_idf():
    manifest = yaml.safe_load((ESP_IDF / "idf_component.yml").read_text())
    expect(set(manifest) == {"version", "description", "license", "dependencies"}, "idf_component.yml: fields")
    expect(manifest["version"] == VERSION, f"idf_component.yml: version {manifest['version']}")
    expect(manifest["dependencies"] == {"idf": ">=5.0"}, "idf_component.yml: dependencies")
    expect((ESP_IDF / "CMakeLists.txt").is_file(), "esp-idf: no CMakeLists.txt")


def vcpkg():
    manifest = json.loads((VCPKG / "vcpkg.json").read_text())
    expect(manifest["name"] == VCPKG.name == "servobus", "vcpkg.json: name")
    expect(manifest["version"] == VERSION, f"vcpkg.json: version {manifest['version']}")
    expect({(needed["name"], needed["host"]) for needed in manifest["dependencies"]} ==
           {("vcpkg-cmake", True), ("vcpkg-cmake-config", True)}, "vcpkg.json: dependencies")
    expect((VCPKG / f"servobus-{VERSION}.tar.gz").is_file(), "vcpkg: no archive")


for check in (arduino, platformio, zephyr, esp_idf, vcpkg):
    check()
for folder in (ARDUINO, PLATFORMIO, ZEPHYR, ESP_IDF):
    for name in ("LICENSE", "README.md"):
        expect((folder / name).is_file(), f"{folder.name}: no {name}")
    left = [path for path in folder.rglob("*") if path.is_file() and re.search("@[A-Z0-9_]+@", path.read_text())]
    expect(not left, f"a value is missing in {left}")
print("\n".join(wrong) or f"manifests of {VERSION}")
sys.exit(1 if wrong else 0)
