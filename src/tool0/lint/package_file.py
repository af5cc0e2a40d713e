"""A package.xml, and the packages that files use or that this machine lacks."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from xml.dom.minidom import Element

from tool0.description.finding import Finding, error_at, warning_at
from tool0.description.xml_source import (
    LocatedElement,
    children,
    locate,
    parse_file,
    text_of,
)
from tool0.errors import DescriptionError, SourceLocation
from tool0.lint.packages import PackageIndex
from tool0.lint.sources import FileKind, Source

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
        root = parse_file(package / "package.xml").documentElement
    except DescriptionError:
        return frozenset()
    if root is None:
        return frozenset()
    return frozenset(
        text_of(item) for item in children(root) if item.tagName in DEPENDENCIES
    )


def package_findings(
    file: Path, sources: Iterable[Source], given: Mapping[str, Path]
) -> Iterator[Finding]:
    """Yield what is wrong with a package.xml.

    Args:
        file: The package.xml.
        sources: The files to check, of which those below it count.
        given: Name → folder of the packages beside it.
    """
    try:
        root = parse_file(file).documentElement
    except DescriptionError as error:
        yield error_at(
            error.location or SourceLocation(file),
            "bad-xml",
            "",
            error.message,
        )
        return
    if not isinstance(root, LocatedElement) or root.tagName != "package":
        yield error_at(
            SourceLocation(file, 1),
            "bad-package",
            "",
            'a package.xml begins with <package format="3">',
        )
        return
    present = {item.tagName for item in children(root)}
    here = root.location or SourceLocation(file)
    for tag in _REQUIRED:
        if tag not in present:
            yield error_at(
                here,
                "bad-package",
                tag,
                f"<{tag}> is missing, so catkin refuses the package",
                f"add <{tag}>",
            )
    name = next((text_of(item) for item in children(root, "name")), "")
    declared = {
        text_of(item) for item in children(root) if item.tagName in DEPENDENCIES
    }
    reached, is_whole = _reached(declared, PackageIndex(given))
    for used, where in sorted(_used(file.parent, sources).items()):
        if used in declared or used == name:
            continue
        if used in reached:
            comes: str | None = f"today it comes with '{reached[used]}', which is named"
        elif not is_whole and used not in given:
            comes = (
                "unless a package that is named brings it, rosdep does not install it"
            )
        else:
            comes = None
        finding_at = warning_at if comes else error_at
        yield finding_at(
            here,
            "missing-dependency",
            used,
            f"{where} uses '{used}', which package.xml does not name: "
            + (comes or "rosdep does not install it; on another machine it is missing"),
            f"add <exec_depend>{used}</exec_depend>",
        )


def _reached(
    declared: Iterable[str], packages: PackageIndex
) -> tuple[dict[str, str], bool]:
    """Return what is installed indirectly, by which dependency, and if all is known."""
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
        if not source.path.is_relative_to(folder):
            continue
        try:
            root = parse_file(source.path).documentElement
        except DescriptionError:
            continue  # reported where the file is checked
        for name, element in _uses(root):
            where = locate(element) or SourceLocation(source.path)
            found.setdefault(name, where)
    return found


def _uses(root: Element | None) -> Iterator[tuple[str, Element]]:
    """Yield the packages that a file uses whatever its arguments are."""
    waiting = [] if root is None else [root]
    while waiting:
        element = waiting.pop()
        if element.tagName in _CHOICES:
            continue  # perhaps only for machines with that package
        waiting += reversed(list(children(element)))
        texts = [*(value for _, value in element.attributes.items()), text_of(element)]
        for match in _USES.finditer("\n".join(texts)):
            yield match[1] or match[2], element
        if element.tagName in ("node", "test") and "$" not in element.getAttribute(
            "pkg"
        ):
            yield element.getAttribute("pkg"), element
        if _GAZEBO_PLUGIN in element.getAttribute("filename"):
            yield "gazebo_ros_control", element


def judge_missing_package(finding: Finding) -> Finding | str:
    """Return the finding with the severity that it deserves, or a note instead of it.

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
