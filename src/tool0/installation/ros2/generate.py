"""Builds message packages from definitions, in a ROS 2 that was installed from PyPI.

usage: PYTHON generate.py DEFINITIONS PREFIX WORK

``PYTHON`` is the Python of the ROS 2 in ``PREFIX``.  ``DEFINITIONS`` contains one
folder per package, with msg/, srv/ and action/.  The wheels contain ROS 2's generators,
headers and libraries.  The compilers in the variables CC and CXX compile the generated
sources.  For each package, the standard output contains ``STEPS`` lines, one after each
step.

The script runs without tool0.  The script imports only the standard library and rosidl.
"""

from __future__ import annotations

import importlib
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from contextlib import redirect_stdout
from pathlib import Path

STEPS = 7
"""Number of lines that are printed for a package."""
_FLAGS = ("-O1", "-fPIC", "-pipe", "-w")
_LIBRARIES = (
    *("rosidl_runtime_c", "rosidl_typesupport_c", "rosidl_typesupport_fastrtps_c"),
    *("rosidl_typesupport_fastrtps_cpp", "rcutils", "fastcdr"),
    "rosidl_typesupport_introspection_c",
)
_STATIC = re.compile(r"^static [\w ]*?(\w+)(?:\[\])? =", re.MULTILINE)
"""Pattern of a static definition at the top level of a C file."""
_KINDS = ("msg", "srv", "action")
_GENERATOR = "rosidl_generator_c"
_TYPESUPPORT = "rosidl_typesupport_c"
_FASTRTPS = "rosidl_typesupport_fastrtps_c"
_INTROSPECTION = "rosidl_typesupport_introspection_c"
_MANIFEST = """\
<package format="3">
  <name>{0}</name>
  <version>0.0.0</version>
  <description>{0} as tool0 defines it</description>
  <maintainer email="tool0@example.org">The tool0 authors</maintainer>
  <license>Apache-2.0</license>
  <member_of_group>rosidl_interface_packages</member_of_group>
</package>
"""


def main(definitions: Path, prefix: Path, work: Path) -> None:
    """Build all packages in parallel, using all processors."""
    folders = sorted(definitions.iterdir(), key=_size, reverse=True)
    library = prefix / "lib"
    libraries = [
        *(library / f"lib{name}.so" for name in _LIBRARIES),
        *library.glob("lib*__rosidl_generator_*.so"),
        *library.glob("lib*__rosidl_typesupport_c.so"),
        *library.glob("lib*__rosidl_typesupport_fastrtps_c.so"),
        *library.glob("lib*__rosidl_typesupport_introspection_c.so"),
    ]
    with ProcessPoolExecutor(len(os.sched_getaffinity(0))) as workers:
        made = [
            workers.submit(make_package, folder, prefix, work, libraries)
            for folder in folders
        ]
        for future in made:
            future.result()


def _size(folder: Path) -> int:
    return sum(file.stat().st_size for file in folder.glob("*/*"))


def make_package(
    definitions: Path, prefix: Path, work: Path, libraries: Iterable[Path]
) -> None:
    """Build the package that is defined in the folder with the package's name.

    Args:
        definitions: The folder that defines the package.
        prefix: The root folder of the ROS 2.
        work: Folder for intermediate files.
        libraries: Libraries from other packages against which this package is linked.
    """
    package = definitions.name
    with Path(os.devnull).open("w") as nowhere, redirect_stdout(nowhere):
        write_sources(definitions, prefix, work)
    _step_done(package)
    objects = compile_sources(package, prefix, work)
    install(package, prefix, work)
    link(package, prefix, objects, libraries)
    _step_done(package)


def _step_done(package: str) -> None:
    print(package, flush=True)


# --- the sources ---


def write_sources(definitions: Path, prefix: Path, work: Path) -> None:
    """Write the C, C++ and Python sources of a package into folders of ``work``."""
    _parse_once()
    from rosidl_adapter import convert_to_idl

    package = definitions.name
    share, include = work / "share" / package, work / "include" / package
    files = sorted(file.relative_to(definitions) for file in definitions.glob("*/*.*"))
    for file in files:
        convert_to_idl(definitions, package, file, share)
        shutil.copyfile(definitions / file, share / file)
    (share / "package.xml").write_text(_MANIFEST.format(package))
    names = [file.with_suffix("").as_posix() for file in files]
    arguments = {
        "package_name": package,
        "idl_tuples": [f"{share}:{name}.idl" for name in names],
        "include_paths": [
            f"{folder.name}:{folder}"
            for folder in sorted(prefix.joinpath("share").iterdir())
            if any(folder.joinpath(kind).is_dir() for kind in _KINDS)
        ],
        "type_description_tuples": [f"{n}.idl:{share / n}.json" for n in names],
        "target_dependencies": [],
    }

    def generate(generator: str, function: str, output: Path, *more: object) -> None:
        file = work / f"{package}.{generator}.json"
        template = prefix / "share" / generator / "resource"
        where = {"output_dir": str(output), "template_dir": str(template)}
        file.write_text(json.dumps(arguments | where))
        getattr(importlib.import_module(generator), function)(str(file), *more)

    generate("rosidl_generator_type_description", "generate_type_hash", share)
    generate(_GENERATOR, "generate_c", include)
    generate(_FASTRTPS, "generate_typesupport_fastrtps_c", include)
    # the files have the same names as files of other generators
    introspection = work / "introspection" / package
    generate(_INTROSPECTION, "generate_c", introspection)
    generate(_TYPESUPPORT, "generate_c", include, [_FASTRTPS, _INTROSPECTION])
    python = work / "python" / package
    generate("rosidl_generator_py", "generate_py", python, [_TYPESUPPORT])
    (python / "__init__.py").touch()
    for generator in (_GENERATOR, _FASTRTPS, _INTROSPECTION):
        _write_visibility(package, prefix, generator, include / "msg")


def _parse_once() -> None:
    """Make the generators share parse results.

    Without sharing, each generator would parse every file.
    """
    from rosidl_parser import parser
    from rosidl_parser.definition import IdlFile, IdlLocator

    parse = parser.parse_idl_file
    parsed: dict[Path, IdlFile] = {}

    def parse_once(locator: IdlLocator) -> IdlFile:
        path = locator.get_absolute_path()
        if path not in parsed:
            parsed[path] = parse(locator)
        return parsed[path]

    parser.parse_idl_file = parse_once


def _write_visibility(package: str, prefix: Path, generator: str, folder: Path) -> None:
    """Write the header that declares the visible functions of a library."""
    name = f"{generator}__visibility_control.h"
    template = prefix / "share" / generator / "resource" / f"{name}.in"
    text = template.read_text()
    text = text.replace("@PROJECT_NAME_UPPER@", package.upper())
    folder.mkdir(exist_ok=True)
    (folder / name).write_text(text.replace("@PROJECT_NAME@", package))


# --- the libraries ---


def compile_sources(package: str, prefix: Path, work: Path) -> Path:
    """Compile the sources of a package, and return the folder of the object files."""
    import numpy

    headers = prefix / "include"
    folders = [
        work / "include",
        work / "introspection",
        *sorted(folder for folder in headers.iterdir() if folder.is_dir()),
        headers,  # headers of fastcdr
        Path(numpy.get_include()),
        Path(sysconfig.get_path("include")),
    ]
    flags = [*_FLAGS, f'-DROS_PACKAGE_NAME="{package}"', *(f"-I{f}" for f in folders)]
    generated, python = work / "include" / package, work / "python" / package
    introspection = work / "introspection" / package
    c = sorted(generated.glob("*/detail/*.c"))
    descriptions = [file for file in c if file.stem.endswith("__description")]
    types = [file for file in c if file not in descriptions]
    units = {
        "types.c": _included(types) + _joined(descriptions),
        "introspection.c": _included(introspection.glob("*/detail/*.c")),
        "typesupport.cpp": _included(generated.glob("**/*.cpp")),
        "python.c": _included(python.glob("*/*_s.c")),
        "module.c": _included(python.glob("_*_s.ep.*.c")),
    }
    objects = work / "objects" / package
    objects.mkdir(parents=True)
    for name, text in units.items():
        objects.joinpath(name).write_text(text)
        compiler = "CXX" if name.endswith(".cpp") else "CC"
        _run(compiler, *flags, "-c", name, cwd=objects)
        _step_done(package)
    return objects


def _included(files: Iterable[Path]) -> str:
    return "".join(f'#include "{file}"\n' for file in sorted(files))


def _joined(files: Iterable[Path]) -> str:
    """Return the joined text of all files.  Static names are made unique."""
    texts = []
    for number, file in enumerate(files):
        text = file.read_text(encoding="utf-8")
        names = "|".join(_STATIC.findall(text))
        texts.append(re.sub(rf"\b({names})\b", rf"\1__{number}", text))
    return "".join(texts)


def link(package: str, prefix: Path, objects: Path, libraries: Iterable[Path]) -> None:
    """Link the package's libraries into ``prefix``."""
    library = prefix / "lib"
    own: list[Path] = []
    options = ("-shared", "-Wl,--as-needed", "-Wl,--allow-shlib-undefined")

    def linked(target: Path, *units: str) -> Path:
        rpath = f"-Wl,-rpath,$ORIGIN/{os.path.relpath(library, target.parent)}"
        files = [*(objects / f"{unit}.o" for unit in units), *own, *libraries]
        _run("CXX", *options, rpath, "-o", str(target), *map(str, files))
        return target

    def name(part: str) -> Path:
        return library / f"lib{package}__{part}.so"

    own.append(linked(name(_GENERATOR), "types", "introspection", "typesupport"))
    for part in (_TYPESUPPORT, _FASTRTPS, _INTROSPECTION):
        name(part).symlink_to(own[0].name)
    own.append(linked(name("rosidl_generator_py"), "python"))
    suffix = sysconfig.get_config_var("EXT_SUFFIX")
    module = f"{package}_s__{_TYPESUPPORT}{suffix}"
    linked(Path(sysconfig.get_path("platlib"), package, module), "module")


def install(package: str, prefix: Path, work: Path) -> None:
    """Copy the Python package and the definitions into ``prefix``."""
    shutil.copytree(
        work / "python" / package,
        Path(sysconfig.get_path("platlib"), package),
        ignore=shutil.ignore_patterns("*.c"),
    )
    share = prefix / "share"
    shutil.copytree(work / "share" / package, share / package)
    index = share / "ament_index" / "resource_index"
    index.joinpath("packages", package).touch()
    files = sorted(
        file.relative_to(share / package).as_posix()
        for file in share.joinpath(package).glob("*/*")
        if file.suffix != ".json"
    )
    index.joinpath("rosidl_interfaces", package).write_text("\n".join(files))


def _run(compiler: str, *arguments: str, cwd: Path | None = None) -> None:
    """Run the compiler that the environment variable ``compiler`` specifies."""
    command = [*shlex.split(os.environ[compiler]), *arguments]
    done = subprocess.run(command, cwd=cwd, check=False, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{os.environ[compiler]}: {done.stderr}")


if __name__ == "__main__":
    main(*(Path(word).absolute() for word in sys.argv[1:]))
