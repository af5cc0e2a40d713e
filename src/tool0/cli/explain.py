"""``tool0 explain``: which launch file does what, and where its arguments end up."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from tool0.errors import ConfigError, DescriptionError

if TYPE_CHECKING:
    from tool0.description.finding import Finding
    from tool0.lint.launch.explanation import Item
    from tool0.lint.packages import PackageIndex

OK, HAS_ERRORS = 0, 1


def explain(
    words: Annotated[
        tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="WORD")
    ],
    format: Literal["text", "json"] = "text",
) -> int:
    """Show what a ROS 1 launch file includes, starts, sets and does with arguments.

    tool0 explain FILE.launch [name:=value …], or PACKAGE FILE.launch [name:=value …].
    Status 1 if there are errors in the files.

    Args:
        words: The launch file, or its package and its name; then its arguments.
        format: For people or for programs.
    """
    from tool0.lint.launch.argument_flow import argument_flow
    from tool0.lint.launch.explanation import contents
    from tool0.lint.launch.reader import read_launch
    from tool0.lint.launch.xacro_files import xacro_robots
    from tool0.lint.packages import PackageIndex, packages_around

    names = [word for word in words if ":=" not in word]
    file = _file(names)
    pairs = [word.split(":=", 1) for word in words if ":=" in word]
    given = {name: value for name, value in pairs if name and value}  # as roslaunch
    packages = PackageIndex(packages_around(file))
    launch = read_launch(file, given, packages)
    robots = xacro_robots(launch, packages)
    tree, arguments = contents(launch, robots), argument_flow(launch, robots)
    if format == "json":
        print(json.dumps(_json(tree, arguments, launch.findings)))
    else:
        from tool0.cli.explain_text import text_of

        print(text_of(tree, arguments, launch.findings, packages), end="")
    errors = [finding for finding in launch.findings if finding.severity == "error"]
    return HAS_ERRORS if errors else OK


def _file(names: list[str]) -> Path:
    """Return the launch file that the words name."""
    match names:
        case [name]:
            file = Path(name)
            if file.is_file():
                return file.absolute()
            raise ConfigError(f"there is no file '{name}'; check the path")
        case [package, name]:
            return _in_package(package, name)
    raise ConfigError(
        f"expected a launch file, or a package and a file in it, got {len(names)} names"
    )


def _in_package(package: str, name: str) -> Path:
    """Return the file of a package, wherever it lies in it, as roslaunch does."""
    from tool0.lint.packages import PackageIndex, packages_around

    packages: PackageIndex = PackageIndex(packages_around(Path.cwd() / name))
    try:
        folder = packages.find(package)
    except DescriptionError as error:
        raise ConfigError(error.message) from None
    if (folder / name).is_file():
        return (folder / name).absolute()
    try:
        found = sorted(path for path in folder.rglob(name) if path.is_file())
    except (NotImplementedError, ValueError):  # an absolute path, or none
        found = []
    if len(found) == 1:
        return found[0].absolute()
    several = ": " + ", ".join(map(str, found)) if found else ""
    count = "several files" if found else "no file"
    raise ConfigError(f"{count} '{name}' in package '{package}' ({folder}){several}")


def _json(
    contents: Item, arguments: tuple[Item, ...], findings: tuple[Finding, ...]
) -> dict[str, object]:
    return {
        "contents": _as_json(contents),
        "arguments": [_as_json(item) for item in arguments],
        "findings": [finding.as_json() for finding in findings],
    }


def _as_json(item: Item) -> dict[str, object]:
    return {
        "kind": item.kind,
        "name": item.name,
        "value": item.value,
        "file": None if item.location.file is None else str(item.location.file),
        "line": item.location.line,
        "note": item.note,
        "items": [_as_json(inner) for inner in item.items],
    }
