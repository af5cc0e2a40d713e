"""Finds meshes that are missing or that cannot be displayed."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path

from tool0.description.finding import Finding, short
from tool0.description.shapes import MESH_SUFFIXES
from tool0.lint.packages import PackageIndex, nearest_file
from tool0.lint.robot.elements import Subject
from tool0.lint.robot.facts import Robot

_UNRESOLVED = "unresolved-uri"
_REMOTE = ("model", "http", "https")
"""URI schemes of meshes that Gazebo and RViz download.  A downloaded mesh has no local
path that could be checked."""


def mesh_findings(robot: Robot) -> Iterator[Finding]:
    """Yield findings about meshes that cannot be loaded, one for each folder."""
    done: set[str] = set()
    for link in robot.root.children("link"):
        for mesh in link.descendants("mesh"):
            uri = mesh["filename"]
            at = Subject(uri, mesh.location)
            scale = mesh.vector("scale")
            if scale is not None and not all(scale):
                yield at.error(
                    "zero-scale",
                    "the <mesh> has a scale of zero, so it is flat, or a point",
                    'write scale="0.001 0.001 0.001" for a mesh in mm, or no scale',
                )
            if uri not in done:
                done.add(uri)
                yield from _uri(at, robot.packages, done)


def _uri(at: Subject, packages: PackageIndex, done: set[str]) -> Iterator[Finding]:
    uri = at.key
    if not uri:
        yield at.error(
            _UNRESOLVED,
            "the <mesh> names no file, so ROS refuses the whole robot_description",
            'write filename="package://PACKAGE/meshes/FILE"',
        )
        return
    if "$(" in uri or "${" in uri:
        if _is_first("$", done):
            yield at.error(
                _UNRESOLVED,
                f"'{short(uri)}' is xacro, which nothing expands in a plain URDF",
                "expand the file with xacro first, or write package://PACKAGE/PATH",
            )
        return
    suffix = os.path.splitext(uri)[1].lower()  # noqa: PTH122  # of a URI
    if suffix not in MESH_SUFFIXES:
        yield at.error(
            "unsupported-mesh",
            f"Gazebo and RViz read no mesh such as '{short(uri)}': the link is "
            "neither seen nor touched",
            f"convert it to one of {', '.join(MESH_SUFFIXES)}",
        )
    scheme, separator, rest = uri.partition("://")
    if not separator:
        yield from _plain(at, done)
    elif scheme == "file":
        yield from _exists(Path("/" + rest.lstrip("/")), at, done)
    elif scheme == "package":
        name, _, inside = rest.partition("/")
        folder = packages.get(name)
        if folder is not None:
            yield from _exists(folder / inside, at, done)
        elif _is_first(f"package://{name}/", done):
            yield packages.unknown(name, f"'{short(uri)}'", at.location)
    elif scheme not in _REMOTE:
        yield at.error(
            _UNRESOLVED,
            f"nothing reads '{short(scheme)}://' in '{short(uri)}'",
            "write package://PACKAGE/PATH or file:///PATH",
        )


def _plain(at: Subject, done: set[str]) -> Iterator[Finding]:
    uri = at.key
    if re.match(r"\w+:/", uri):
        yield at.error(
            _UNRESOLVED,
            f"'{short(uri)}' lacks a slash: it is neither a path nor a URI",
            f"write {short(uri.replace(':/', '://', 1))}",
        )
    elif uri.startswith("/"):
        yield from _exists(Path(uri), at, done)
    elif _is_first(".", done):
        yield at.warning(
            "relative-mesh",
            f"paths such as '{short(uri)}' have no base folder: RViz does not find "
            "them, and Gazebo looks in the folder that it was started in",
            "write package://PACKAGE/PATH",
        )


def _exists(path: Path, at: Subject, done: set[str]) -> Iterator[Finding]:
    if os.path.isfile(path):  # noqa: PTH113  # Path.is_file may raise
        return
    folder = path.parent
    if not folder.is_dir():
        if _is_first(f"{folder}/", done):
            yield at.error(
                _UNRESOLVED,
                f"there is no folder '{short(str(folder))}' on this machine, so the "
                "links with its meshes are neither seen nor touched",
                "write package://PACKAGE/PATH, and put the files into the package",
            )
        return
    close = nearest_file(path)
    yield at.error(
        _UNRESOLVED,
        f"there is no file '{short(path.name)}' in '{short(str(folder))}', so the link "
        "is neither seen nor touched",
        f"there is '{close}'; write that" if close else "check the path",
    )


def _is_first(key: str, done: set[str]) -> bool:
    """Return whether ``key`` is new, and add it to ``done``."""
    is_new = key not in done
    done.add(key)
    return is_new
