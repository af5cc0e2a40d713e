"""Meshes that are not there, or that nothing draws."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import final
from xml.dom.minidom import Element

from tool0.description.finding import Finding, error_at, short, warning_at
from tool0.description.shapes import MESH_SUFFIXES
from tool0.description.xml_source import children
from tool0.errors import SourceLocation
from tool0.lint.packages import PackageIndex, nearest_file
from tool0.lint.robot.elements import attribute, descendants, place, vector

_SCHEMES = ("package", "file", "model", "http", "https")
_REMOTE = ("model", "http", "https")
"""Gazebo and RViz download these, so that no local path can be checked."""


def mesh_findings(root: Element, packages: Mapping[str, Path]) -> Iterator[Finding]:
    """Yield the meshes that cannot be loaded; each file and each package once."""
    meshes = _Meshes(PackageIndex(packages))
    for link in children(root, "link"):
        for element in descendants(link):
            if element.tagName == "mesh":
                yield from meshes.check(element)


@final
class _Meshes:
    """The meshes of one robot; each file and each package is reported once."""

    def __init__(self, packages: PackageIndex) -> None:
        self._packages = packages
        self._done: set[str] = set()

    def check(self, mesh: Element) -> Iterator[Finding]:
        """Yield what is wrong with one <mesh>."""
        location = place(mesh)
        scale = vector(mesh, "scale")
        if scale is not None and not all(scale):
            yield error_at(
                location,
                "zero-scale",
                attribute(mesh, "filename"),
                "the <mesh> has a scale of zero, so it is flat, or a point",
                'write scale="0.001 0.001 0.001" for a mesh in mm, or no scale',
            )
        uri = attribute(mesh, "filename")
        if uri not in self._done:
            self._done.add(uri)
            yield from self._uri(uri, location)

    def _uri(self, uri: str, location: SourceLocation) -> Iterator[Finding]:
        if not uri:
            message, remedy = (
                "the <mesh> names no file, so ROS refuses the whole robot_description",
                'write filename="package://PACKAGE/meshes/FILE"',
            )
            yield _unresolved(uri, location, message, remedy)
            return
        if "$(" in uri or "${" in uri:
            message, remedy = (
                f"'{short(uri)}' is xacro, which nothing expands in a plain URDF",
                "expand the file with xacro first, or write package://PACKAGE/PATH",
            )
            yield _unresolved(uri, location, message, remedy)
            return
        suffix = os.path.splitext(uri)[1].lower()  # noqa: PTH122  # of a URI
        if suffix not in MESH_SUFFIXES:
            yield error_at(
                location,
                "unsupported-mesh",
                uri,
                f"Gazebo and RViz read no mesh such as '{short(uri)}': the link is "
                "neither seen nor touched",
                f"convert it to one of {', '.join(MESH_SUFFIXES)}",
            )
        yield from self._file(uri, location)

    def _file(self, uri: str, location: SourceLocation) -> Iterator[Finding]:
        scheme, separator, rest = uri.partition("://")
        if not separator:
            yield from _plain(uri, location)
        elif scheme == "package":
            yield from self._in_package(uri, rest, location)
        elif scheme == "file":
            yield from _exists(Path("/" + rest.lstrip("/")), uri, location)
        elif scheme not in _REMOTE:
            yield _unresolved(
                uri,
                location,
                f"nothing reads '{short(scheme)}://' in '{short(uri)}'",
                "write package://PACKAGE/PATH or file:///PATH",
            )

    def _in_package(
        self, uri: str, rest: str, location: SourceLocation
    ) -> Iterator[Finding]:
        name, _, inside = rest.partition("/")
        folder = self._packages.get(name)
        if folder is not None:
            yield from _exists(folder / inside, uri, location)
        elif f"package://{name}/" not in self._done:
            self._done.add(f"package://{name}/")
            yield self._packages.unknown(name, f"'{short(uri)}'", location)


def _plain(uri: str, location: SourceLocation) -> Iterator[Finding]:
    if re.match(r"\w+:/", uri):
        yield _unresolved(
            uri,
            location,
            f"'{short(uri)}' lacks a slash: it is neither a path nor a URI",
            f"write {short(uri.replace(':/', '://', 1))}",
        )
    elif uri.startswith("/"):
        yield from _exists(Path(uri), uri, location)
    else:
        yield warning_at(
            location,
            "relative-mesh",
            uri,
            f"the path '{short(uri)}' counts from nowhere: RViz does not find it, "
            "and Gazebo looks in the folder that it was started in",
            "write package://PACKAGE/PATH",
        )


def _exists(path: Path, uri: str, location: SourceLocation) -> Iterator[Finding]:
    if os.path.isfile(path):  # noqa: PTH113  # Path.is_file may raise
        return
    close = nearest_file(path)
    yield _unresolved(
        uri,
        location,
        f"there is no file '{short(str(path))}' ('{short(uri)}'), so the link is "
        "neither seen nor touched",
        f"there is '{close}'; write that" if close else "check the path",
    )


def _unresolved(
    uri: str, location: SourceLocation, message: str, remedy: str
) -> Finding:
    return error_at(
        location,
        "unresolved-uri",
        uri,
        message,
        remedy,
    )
