"""Finds controllers that packages export as pluginlib plugins."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import final

from tool0.description.packages import crawl
from tool0.lint.packages import Packages

_NONE: Packages = MappingProxyType({})
_IN_MANIFEST = re.compile(r"""\bplugin\s*=\s*["']\$\{prefix\}/([^"']+)["']""")
_IN_CMAKE = re.compile(
    r"""\bpluginlib_export_plugin_description_file\s*\(\s*\S+\s+["']?([^\s"')]+)"""
)
_CLASS = re.compile(r"<class\s([^>]*)>")
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_LARGEST = 1_000_000
"""Size of the largest file that is searched for plugins [bytes]."""


@final
class PluginIndex:
    """Plugin types in a workspace and in the packages of ROS_PACKAGE_PATH."""

    def __init__(self, packages: Packages = _NONE) -> None:
        """Store the packages of the workspace.  No file is read yet."""
        self._folders = tuple(packages.values())

    def __contains__(self, type_name: str) -> bool:
        """Return whether a package exports this controller type."""
        return any(
            type_name in _exported_by(folder) for folder in self._folders
        ) or any(type_name in types for types in map(_exported_by, _installed()))


def _installed() -> Iterator[Path]:
    for entry in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep):
        if entry:
            yield from crawl(Path(entry).expanduser())


@cache
def _exported_by(package: Path) -> frozenset[str]:
    """Return the names of the plugins that a package exports.

    The plugin description is named in package.xml in ROS 1, and in CMakeLists.txt in
    ROS 2.
    """
    manifest, cmake = _text(package / "package.xml"), _text(package / "CMakeLists.txt")
    files = {*_IN_MANIFEST.findall(manifest), *_IN_CMAKE.findall(cmake)}
    return frozenset(
        name for file in files for name in _described(_text(package / file))
    )


def _described(xml: str) -> Iterator[str]:
    for match in _CLASS.finditer(_COMMENT.sub("", xml)):
        # a plugin without a name is found by its class
        for attribute in ("name", "type"):
            found = re.search(rf"""\b{attribute}\s*=\s*["']([^"']+)["']""", match[1])
            if found is not None:
                yield found[1]
                break


def _text(file: Path) -> str:
    try:
        if file.stat().st_size > _LARGEST:
            return ""
        return file.read_text(encoding="utf-8", errors="replace")
    except (OSError, ValueError):
        return ""
