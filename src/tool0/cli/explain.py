"""``tool0 explain``: the contents of a launch file, and the uses of its arguments."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, final

from tool0.cli.parameters import AsJson, Option
from tool0.cli.text import print_json
from tool0.errors import ConfigError, DescriptionError

if TYPE_CHECKING:
    from tool0.cli.outputs import ExplainOutput, ItemOutput
    from tool0.description.finding import Finding
    from tool0.lint.launch.explanation import Item
    from tool0.lint.launch.model import LaunchFile
    from tool0.lint.packages import PackageIndex

OK, HAS_ERRORS = 0, 1
WIDTH = 100
"""Width of the output [columns]."""
EMPTY = "''"
_LEAST = 40
"""Minimum width of the text, even deep in the tree [columns]."""
_FIND = "$(find\N{NO-BREAK SPACE}"


def explain(
    words: Annotated[
        tuple[str, ...],
        Option(is_positional=True, metavar="[PACKAGE] FILE [ARGUMENT:=VALUE ...]"),
    ],
    as_json: AsJson = False,
) -> int:
    """Show the includes and settings of a launch file of ROS 1 (XML) or ROS 2 (Python).

    The command also shows where the value of each argument is used.  Exit status: 1 if
    the files contain errors.

    Args:
        words: The launch file, or its package and file name, followed by arguments for
            the launch file.
        as_json: Print one JSON object.
    """
    from tool0.description.packages import packages_around
    from tool0.lint.launch.argument_flow import argument_flow
    from tool0.lint.launch.explanation import contents
    from tool0.lint.launch.reader import read_launch
    from tool0.lint.launch.xacro_files import xacro_robots
    from tool0.lint.packages import PackageIndex

    names = [word for word in words if ":=" not in word]
    file = _file(names)
    pairs = [word.split(":=", 1) for word in words if ":=" in word]
    given = {name: value for name, value in pairs if name and value}  # like roslaunch
    packages = PackageIndex(packages_around(file))
    launch = read_launch(file, given, packages)
    robots = xacro_robots(launch, packages)
    tree, arguments = contents(launch, robots), argument_flow(launch, robots)
    if as_json:
        print_json(_json(tree, arguments, launch))
    else:
        print(text_of(tree, arguments, launch, packages), end="")
    errors = [finding for finding in launch.findings if finding.severity == "error"]
    return HAS_ERRORS if errors else OK


def _file(names: list[str]) -> Path:
    """Return the launch file that is given by one or two words."""
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
    """Return a package's file from any folder of the package, as roslaunch does."""
    from tool0.description.packages import packages_around
    from tool0.lint.packages import PackageIndex

    packages: PackageIndex = PackageIndex(packages_around(Path.cwd() / name))
    try:
        folder = packages.find(package)
    except DescriptionError as error:
        raise ConfigError(error.message) from None
    if (folder / name).is_file():
        return (folder / name).absolute()
    try:
        found = sorted(path for path in folder.rglob(name) if path.is_file())
    except (NotImplementedError, ValueError):  # the name is an absolute path, or empty
        found = []
    if len(found) == 1:
        return found[0].absolute()
    several = ": " + ", ".join(map(str, found)) if found else ""
    count = "several files" if found else "no file"
    raise ConfigError(f"{count} '{name}' in package '{package}' ({folder}){several}")


def _json(
    contents: Item, arguments: tuple[Item, ...], launch: LaunchFile
) -> ExplainOutput:
    return {
        "contents": _as_json(contents),
        "arguments": [_as_json(item) for item in arguments],
        "findings": [finding.as_json() for finding in launch.findings],
        "notes": list(launch.notes),
    }


def _as_json(item: Item) -> ItemOutput:
    return {
        "kind": item.kind,
        "name": item.name,
        "value": item.value,
        "file": None if item.location.file is None else str(item.location.file),
        "line": item.location.line,
        "note": item.note,
        "items": [_as_json(inner) for inner in item.items],
    }


def text_of(
    contents: Item,
    arguments: tuple[Item, ...],
    launch: LaunchFile,
    packages: PackageIndex,
) -> str:
    """Return the whole text: tree, uses of arguments, findings and notes."""
    writer = _Writer(packages)
    lines = [writer.path(contents.name), *writer.tree(contents.items, "")]
    for file in arguments:
        lines += ["", f"Arguments of {writer.path(file.name)}"]
        for argument in file.items:
            lines += writer.argument(argument, file.name)
    if launch.findings:
        lines += ["", _count(launch.findings)]
    remarks = [f"{finding.severity}: {finding}" for finding in launch.findings]
    for remark in (*remarks, *(f"note: {note}" for note in launch.notes)):
        lines += textwrap.wrap(
            remark,
            WIDTH,
            subsequent_indent="  ",
            break_long_words=False,
            break_on_hyphens=False,
        )
    return "".join(f"{line.rstrip()}\n" for line in lines)


def _count(findings: tuple[Finding, ...]) -> str:
    counts = []
    for severity in ("error", "warning"):
        number = sum(finding.severity == severity for finding in findings)
        if number:
            counts.append(f"{number} {severity}{'s' if number > 1 else ''}")
    return ", ".join(counts)


@final
class _Writer:
    """Writes items, with paths relative to their packages."""

    def __init__(self, packages: PackageIndex) -> None:
        self._packages = packages
        known = {str(f): name for name, f in packages.folders().items()}
        self._folders = dict(sorted(known.items(), key=lambda item: -len(item[0])))

    def path(self, name: str) -> str:
        """Return a file's name, as ``package/path`` if the file is in a package."""
        around = self._packages.around(Path(name)) if name.startswith("/") else None
        if around is None:
            return name
        package, folder = around
        return f"{package}/{Path(name).relative_to(folder)}"

    def argument(self, item: Item, file: str) -> Iterator[str]:
        """Yield the lines of an argument: its value, its origin and its uses."""
        head = f"  {item.name}"
        if item.value is not None:
            head += f" = {self._value(item.value) or EMPTY}"
        place = "" if item.location.file is None else _place(item, file)
        origin = ", ".join(part for part in (place, item.note) if part)
        yield from _wrapped(head, "      ")
        yield from _wrapped(f"  {'│' if item.items else ' '} {origin}", "      ")
        yield from self.uses(item.items, "  ", file)

    def uses(self, items: tuple[Item, ...], indent: str, around: str) -> Iterator[str]:
        """Yield the lines of an argument's uses.

        Args:
            items: The uses.
            indent: The text before each line.
            around: The text and the file of the line above.  A file name that occurs
                here is not repeated.
        """
        places = [_place(item, around) for item in items]
        width = max(map(len, places), default=0)
        for item, place in zip(items, places, strict=True):
            text = f"{place:{width}}  {item.name}{_note(item)}"
            yield from _branch(text, indent, item, is_last=item is items[-1])
            below = indent + ("   " if item is items[-1] else "│  ")
            yield from self.uses(item.items, below, f"{item.location.file} {item.name}")

    def tree(self, items: tuple[Item, ...], indent: str) -> Iterator[str]:
        """Yield the lines of items and their children."""
        lines = [str(item.location.line or "") for item in items]
        digits = max(map(len, lines), default=0)
        kinds = max((len(item.kind) for item in items), default=0)
        for item, line in zip(items, lines, strict=True):
            text = f"{line:>{digits}}  {item.kind:{kinds}}  {self._full(item)}"
            yield from _branch(text, indent, item, is_last=item is items[-1])
            below = indent + ("   " if item is items[-1] else "│  ")
            yield from self.tree(item.items, below)

    def _full(self, item: Item) -> str:
        is_file = item.kind in ("include", "xacro")
        text = self.path(item.name) if is_file else item.name
        if item.value is not None:
            sign = " = " if item.kind in ("param", "xacro arg", "env") else "  "
            if item.kind == "remap":
                sign = " -> "
            text += sign + (self._value(item.value) or EMPTY)
        return text + _note(item)

    def _value(self, value: str) -> str:
        """Return a value with package folders in the notation of roslaunch."""
        value = " ".join(value.split())
        for folder, name in self._folders.items():
            value = value.replace(f"{folder}/", f"$(find {name})/")
        return value


def _place(item: Item, around: str) -> str:
    """Return the line number, with the file name unless ``around`` contains it."""
    line, name = item.location.line, Path(str(item.location.file)).name
    if name in around:
        return "" if line is None else f"line {line}"
    return name if line is None else f"{name}:{line}"


def _note(item: Item) -> str:
    return f"  [{item.note}]" if item.note else ""


def _branch(text: str, indent: str, item: Item, *, is_last: bool) -> Iterator[str]:
    below = indent + ("   " if is_last else "│  ")
    bar = "│" if item.items else " "
    yield from _wrapped(
        f"{indent}{'└─' if is_last else '├─'} {text}", f"{below}{bar}   "
    )


def _wrapped(text: str, indent: str) -> Iterator[str]:
    """Yield lines that fit the width; all except the first start with ``indent``."""
    if len(text) <= WIDTH:
        yield text
        return
    width = max(WIDTH, len(indent) + _LEAST)
    start = len(text) - len(text.lstrip(" │├└─"))
    lines = textwrap.wrap(
        text[start:].replace(
            "$(find ", _FIND
        ),  # prevents a line break inside "$(find "
        width,
        initial_indent=text[:start],
        subsequent_indent=indent,
        break_on_hyphens=False,
    )
    yield from (line.replace(_FIND, "$(find ") for line in lines)
