"""A package.xml, packages that files use, and packages missing on this machine."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

from tool0.description.finding import Finding, Severity, error_at
from tool0.description.xml_source import parse_file
from tool0.errors import DescriptionError, SourceLocation
from tool0.lint.packages import PackageIndex, Packages
from tool0.lint.robot.elements import Tag
from tool0.lint.sources import FileKind, Source, finding_of

DEPENDENCIES = ("depend", "exec_depend", "run_depend", "build_depend", "test_depend")
_REQUIRED = ("name", "version", "description", "maintainer", "license")
_USES = re.compile(r"\$\(find +([\w-]+) *\)|package://([\w-]+)/")
_CHOICES = ("xacro:if", "xacro:unless")
_GAZEBO_PLUGIN = "libgazebo_ros_control.so"
_RULES = ("unresolved-find", "unknown-package", "missing-package")
_NO_PACKAGE = re.compile(r"there is no ROS package '([\w-]+)'")


def declared_dependencies(package: Path) -> frozenset[str]:
    """Return the dependencies that the package in a folder declares."""
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
    """Yield the faults of a package.xml, given the checked files."""
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
    declared = _dependencies(root)
    reached, is_whole = _reached(declared, PackageIndex(given))
    for used, where in sorted(_used(file.parent, sources).items()):
        if used in declared or used == root.child("name").text:
            continue
        severity: Severity = "warning"
        if used in reached:
            reason = f"today it comes with '{reached[used]}', which is named"
        elif not is_whole and used not in given:
            reason = "unless a listed package depends on it, rosdep does not install it"
        else:
            severity = "error"
            reason = "rosdep does not install it; on another machine it is missing"
        yield error_at(
            root.location,
            "missing-dependency",
            used,
            f"{where} uses '{used}', which package.xml does not name: {reason}",
            f"add <exec_depend>{used}</exec_depend>",
            severity=severity,
        )


def _reached(
    declared: Iterable[str], packages: PackageIndex
) -> tuple[dict[str, str], bool]:
    """Return indirect package → its dependency, and whether all packages are known."""
    by: dict[str, str] = {}
    waiting, is_whole = [(name, name) for name in sorted(declared)], True
    while waiting:
        name, first = waiting.pop()
        try:
            further = declared_dependencies(packages.find(name))
        except DescriptionError:
            is_whole = False
            continue
        for other in sorted(further - by.keys()):
            by[other] = first
            waiting.append((other, first))
    return by, is_whole


def _used(folder: Path, sources: Iterable[Source]) -> dict[str, SourceLocation]:
    """Return the packages that files below a folder use, and where first."""
    found: dict[str, SourceLocation] = {}
    for source in sources:
        if source.kind not in (FileKind.LAUNCH, FileKind.XACRO, FileKind.URDF):
            continue
        if source.path.is_relative_to(folder):
            try:
                root = Tag(parse_file(source.path).documentElement)
            except DescriptionError:
                continue  # reported where the file is checked
            for name, where in _uses(root):
                found.setdefault(name, where)
    return found


def _uses(root: Tag) -> Iterator[tuple[str, SourceLocation]]:
    """Yield the packages that a file uses with any arguments."""
    waiting = [root]
    while waiting:
        tag = waiting.pop()
        if tag.tag in _CHOICES:
            continue  # perhaps only for machines with that package
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
    """Return the finding with its proper severity, or a note instead.

    A missing package that the file's own package.xml declares is no fault of the file.
    For a file outside any package it is a warning, unless the name is a typo.
    """
    lacking, file = _missing_package(finding), finding.location.file
    if lacking is None or file is None:
        return finding
    folder = next(
        (f for f in file.absolute().parents if (f / "package.xml").is_file()), None
    )
    if folder is not None and lacking in declared_dependencies(folder):
        return f"{file}: '{lacking}' is not on this machine; its files were not checked"
    if folder is None and "did you mean" not in finding.text:
        return replace(finding, severity="warning")
    return finding


def _missing_package(finding: Finding) -> str | None:
    """Return the package that the finding reports as missing, if any."""
    if finding.rule in _RULES:
        return finding.key
    match = _NO_PACKAGE.search(finding.message)
    return None if match is None else match[1]
