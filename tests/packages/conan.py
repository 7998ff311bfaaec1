# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""A stand-in for `conan create`: runs a recipe and its test_package with functions that do what those of Conan 2 do for
a library of headers.   conan.py RECIPE-FOLDER WORK-FOLDER [CPPSTD]
"""
import fnmatch
import hashlib
import importlib.util
import shutil
import subprocess
import sys
import tarfile
import types
from pathlib import Path


class ConanException(Exception):
    pass


class Settings(types.SimpleNamespace):
    pass


class CppInfo:
    def __init__(self):
        self.includedirs, self.libdirs, self.bindirs, self.properties = ["include"], ["lib"], ["bin"], {}

    def set_property(self, name, value):
        self.properties[name] = value


class Info:
    cleared = False

    def clear(self):
        self.cleared = True


class ConanFile:
    def run(self, command, env=None):
        assert env in (None, "conanrun"), env
        subprocess.run(command, shell=True, check=True)

    def requires(self, reference):
        self.required = reference


def check_min_cppstd(conanfile, least):
    if int(conanfile.settings.cppstd) < int(least):
        raise ConanException(f"C++{least} is needed, not C++{conanfile.settings.cppstd}")


def check_sha256(_, path, expected):
    if hashlib.sha256(Path(path).read_bytes()).hexdigest() != expected:
        raise ConanException(f"sha256 of {path} is not {expected}")


def unzip(_, path, destination=".", strip_root=False):
    with tarfile.open(path) as tar:
        for entry in tar.getmembers():
            if strip_root:
                entry.name = entry.name.partition("/")[2]
            if entry.name:
                tar.extract(entry, destination)


def copy(_, pattern, src, dst):
    for path in sorted(Path(src).rglob("*")):
        name = path.relative_to(src)
        if path.is_file() and fnmatch.fnmatch(str(name), pattern):
            target = Path(dst) / name
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, target)


class CMake:
    def __init__(self, conanfile):
        self.file = conanfile

    def configure(self):
        subprocess.run(["cmake", "-S", self.file.source_folder, "-B", self.file.build_folder,
                        f"-DCMAKE_PREFIX_PATH={self.file.generators_folder}"], check=True)

    def build(self):
        subprocess.run(["cmake", "--build", self.file.build_folder], check=True)


def module(name, **members):
    made = types.ModuleType(name)
    made.__dict__.update(members)
    made.__path__ = []
    sys.modules[name] = made


module("conan", ConanFile=ConanFile)
module("conan.tools")
module("conan.tools.build", check_min_cppstd=check_min_cppstd, can_run=lambda conanfile: True)
module("conan.tools.files", check_sha256=check_sha256, copy=copy, unzip=unzip)
module("conan.tools.layout", basic_layout=lambda conanfile: None)
module("conan.tools.cmake", CMake=CMake, cmake_layout=lambda conanfile: None)


def load(path):
    spec = importlib.util.spec_from_file_location(f"recipe_{path.parent.name}", path)
    loaded = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(loaded)
    return next(member() for member in vars(loaded).values()
                if isinstance(member, type) and issubclass(member, ConanFile) and member is not ConanFile)


def create(recipe_folder, work, cppstd):
    """The recipe, packed: work/package is its package. Each folder is its own, so that a recipe cannot mix them up."""
    recipe = load(recipe_folder / "conanfile.py")
    recipe.settings, recipe.cpp_info, recipe.info = Settings(cppstd=cppstd), CppInfo(), Info()
    for name in ("export_sources", "source", "package"):
        (work / name).mkdir(parents=True)
        setattr(recipe, f"{name}_folder", str(work / name))
    exported = recipe.exports_sources if isinstance(recipe.exports_sources, tuple) else (recipe.exports_sources,)
    for pattern in exported:
        copy(recipe, pattern, recipe_folder, recipe.export_sources_folder)
    for step in ("layout", "validate", "package_id", "source", "package", "package_info"):
        getattr(recipe, step)()
    assert recipe.package_type == "header-library" and recipe.info.cleared and recipe.no_copy_source
    assert not recipe.cpp_info.libdirs and not recipe.cpp_info.bindirs
    return recipe


def cmake_deps(recipe, folder):
    """The files of CMakeDeps: a target by the names that the recipe sets."""
    folder.mkdir(parents=True)
    name, target = (recipe.cpp_info.properties[f"cmake_{kind}_name"] for kind in ("file", "target"))
    include = ";".join(str(Path(recipe.package_folder) / path) for path in recipe.cpp_info.includedirs)
    (folder / f"{name}-config.cmake").write_text(
        f'add_library({target} INTERFACE IMPORTED)\ntarget_include_directories({target} INTERFACE "{include}")\n')


def test_package(recipe, recipe_folder, work):
    test = load(recipe_folder / "test_package/conanfile.py")
    test.settings = Settings(cppstd=20)
    test.tested_reference_str = f"{recipe.name}/{recipe.version}"
    test.source_folder, test.build_folder = str(recipe_folder / "test_package"), str(work / "test_build")
    test.generators_folder = str(work / "generators")
    test.cpp = types.SimpleNamespace(build=types.SimpleNamespace(bindir=test.build_folder))
    assert "CMakeDeps" in test.generators
    cmake_deps(recipe, work / "generators")
    for step in ("requirements", "layout", "build", "test"):
        getattr(test, step)()
    assert test.required == test.tested_reference_str


try:
    folders = [Path(argument).resolve() for argument in sys.argv[1:3]]
    made = create(*folders, cppstd=int(sys.argv[3]) if len(sys.argv) > 3 else 20)
    test_package(made, *folders)
    print(f"{made.name}/{made.version}")
except ConanException as refused:
    sys.exit(f"ERROR: {refused}")
