"""Checks a package.xml, the packages that files use, and missing packages."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from tool0.description.finding import Finding, error_at, warning_at
from tool0.description.xml_source import parse_file
from tool0.errors import DescriptionError, SourceLocation, is_typo
from tool0.lint.packages import PackageIndex, Packages
from tool0.lint.robot.elements import Tag
from tool0.lint.sources import FileKind, Source, finding_of

DEPENDENCIES = ("depend", "exec_depend", "run_depend", "build_depend", "test_depend")
_REQUIRED = ("name", "version", "description", "maintainer", "license")
_USES = re.compile(r"\$\(find +([\w-]+) *\)|package://([\w-]+)/")
_CHOICES = ("xacro:if", "xacro:unless")
_GAZEBO_PLUGIN = "libgazebo_ros_control.so"
_MOST = 4
"""Largest number of undeclared packages that a finding lists with the place of their
use."""
MISSING_PACKAGE = ("unresolved-find", "unknown-package", "missing-package")
_MEANT = re.compile(r"did you mean '([\w-]+)'")
_NO_PACKAGE = re.compile(r"there is no ROS package '([\w-]+)'")


def declared_dependencies(package: Path) -> frozenset[str]:
    """Return the dependencies that the package.xml in a folder declares."""
    try:
        root = Tag(parse_file(package / "package.xml").documentElement)
    except DescriptionError:
        return frozenset()
    return _dependencies(root)


def _dependencies(root: Tag) -> frozenset[str]:
    return frozenset(item.text for item in root.children() if item.tag in DEPENDENCIES)


def package_findings(
    file: Path, sources: Iterable[Source], given: Packages
) -> Iterator[Finding]:
    """Yield the faults of a package.xml, based on the checked files."""
    try:
        root = Tag(parse_file(file).documentElement)
    except DescriptionError as error:
        yield finding_of(error, "bad-xml", file)
        return
    if root.tag != "package":
        message = 'a package.xml begins with <package format="3">'
        yield error_at(SourceLocation(file, 1), "bad-package", "", message)
        return
    for tag in _REQUIRED:
        if not root.child(tag):
            yield error_at(
                root.location,
                "bad-package",
                tag,
                f"<{tag}> is missing, so catkin refuses the package",
                f"add <{tag}>",
            )
    reached = _reached(_dependencies(root), PackageIndex(given))
    lacking = [
        (used, where)
        for used, where in sorted(_used(file.parent, sources).items())
        if used not in reached and used != root.child("name").text
    ]
    if lacking:
        uses = [
            f"'{used}' (at {_inside(file.parent, where)})" for used, where in lacking
        ]
        first = ", ".join(uses[:_MOST])
        more = f" and {len(uses) - _MOST} more" if len(uses) > _MOST else ""
        yield warning_at(
            root.location,
            "missing-dependency",
            ", ".join(used for used, _ in lacking),
            f"the files use {first}{more}, and package.xml names no package that needs "
            "it: rosdep does not install it on another machine",
            "add "
            + " ".join(f"<exec_depend>{used}</exec_depend>" for used, _ in lacking),
        )


def _inside(folder: Path, where: SourceLocation) -> SourceLocation:
    file = where.file
    return replace(where, file=file.relative_to(folder)) if file else where


def _reached(declared: Iterable[str], packages: PackageIndex) -> set[str]:
    """Return the declared packages and, if known, the packages that they declare."""
    found: set[str] = set()
    waiting = list(declared)
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            with suppress(DescriptionError):
                waiting += declared_dependencies(packages.find(name))
    return found


def _used(folder: Path, sources: Iterable[Source]) -> dict[str, SourceLocation]:
    """Return the packages that files in a folder use, with the place of first use."""
    found: dict[str, SourceLocation] = {}
    for source in sources:
        if source.kind not in (FileKind.LAUNCH, FileKind.XACRO, FileKind.URDF):
            continue
        if source.path.is_relative_to(folder):
            try:
                root = Tag(parse_file(source.path).documentElement)
            except DescriptionError:
                continue  # the error is reported where the file is checked
            for name, where in _uses(root):
                found.setdefault(name, where)
    return found


def _uses(root: Tag) -> Iterator[tuple[str, SourceLocation]]:
    """Yield the packages that a file uses, whatever its arguments are."""
    waiting = [root]
    while waiting:
        tag = waiting.pop()
        if tag.tag in _CHOICES:
            continue  # may be only for machines that have the package
        waiting += reversed(list(tag.children()))
        texts = [*(value for _, value in tag.attributes), tag.text]
        for match in _USES.finditer("\n".join(texts)):
            yield match[1] or match[2], tag.location
        package = tag.written("pkg")
        if tag.tag in ("node", "test") and "$" not in package:
            yield package, tag.location
        if _GAZEBO_PLUGIN in tag.written("filename"):
            yield "gazebo_ros_control", tag.location


def judge_missing_package(finding: Finding) -> Finding | str:
    """Return the finding with its correct severity, or a note instead.

    If a package is missing on this machine, a file in a package is not at fault; the
    result is then a note.  A separate finding reports a package that the file's
    package.xml does not list.  If the file is in no package, the finding is a warning.
    If the package's name may be a misspelling, the finding is an error.
    """
    lacking, file = _missing_package(finding), finding.location.file
    if lacking is None or file is None:
        return finding
    meant = _MEANT.search(finding.text)
    if meant is not None and is_typo(lacking, meant[1]):
        return finding
    folder = next(
        (f for f in file.absolute().parents if (f / "package.xml").is_file()), None
    )
    if folder is None:
        return replace(finding, severity="warning")
    return f"{file}: '{lacking}' is not on this machine; its files were not checked"


def _missing_package(finding: Finding) -> str | None:
    """Return the package that the finding reports as missing, if any."""
    if finding.rule in MISSING_PACKAGE:
        return finding.key
    match = _NO_PACKAGE.search(finding.message)
    return None if match is None else match[1]
