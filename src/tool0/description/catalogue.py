"""Catalogue of the built-in arms and grippers, and of your own parts.

Each part is a folder with YAML files.  The folders of the built-in parts are in
``arms`` and ``grippers`` of ``tool0_description/config``.  A folder contains
kinematics, limits, masses, appearance, poses and display names.  A gripper's folder
also contains the gripper's xacro macro.  A file that is missing from a folder is
replaced by the file that all arms, or all grippers, share.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, final

from tool0.description.packages import find_package
from tool0.errors import ConfigError, DescriptionError, did_you_mean
from tool0.user_data import expanded

NO_GRIPPER = "none"
"""Value given instead of a gripper's name if there is no gripper."""

PartKind = Literal["arm", "gripper"]

_FIRST_FILE: Mapping[PartKind, str] = {
    "arm": "default_kinematics.yaml",
    "gripper": "macro.xacro",
}
"""The file by which a folder is recognized as an arm or a gripper."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class DisplayName:
    """Display name of a link or joint in English and Chinese."""

    en: str
    zh: str


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class CataloguePart:
    """An arm or a gripper, defined by a folder."""

    kind: PartKind
    folder: Path

    @property
    def name(self) -> str:
        """Name of the part, such as ``ur5``, which is also the name of the folder."""
        return self.folder.name

    @property
    def is_built_in(self) -> bool:
        return self.folder.parent == shared_folder(self.kind)

    def file(self, name: str) -> Path:
        """Return the path of a file of the part, or of the file shared by its kind."""
        own = self.folder / name
        return own if own.is_file() else shared_folder(self.kind) / name

    def load(self, what: str) -> Mapping[str, Any]:  # Any: any YAML value
        """Return the mapping in ``<what>.yaml``; empty if there is no such file.

        Raises:
            ConfigError: If the file cannot be read, or does not contain the mapping
                ``what``.
        """
        from tool0.description.yaml_tree import read_verbatim  # only with files

        path = self.file(f"{what}.yaml")
        if not path.is_file():
            return {}
        root = read_verbatim(path).root
        entry = root.find(what)
        if entry is None or not entry.is_mapping:
            raise ConfigError(f"there is no mapping '{what}'", root.location)
        return {name: child.plain() for name, child in entry.children.items()}


def arms() -> tuple[str, ...]:
    """Return the names of the built-in arms."""
    return _names("arm")


def grippers() -> tuple[str, ...]:
    """Return the names of the built-in grippers."""
    return _names("gripper")


def find_part(kind: PartKind, name: str) -> CataloguePart:
    """Return a built-in part by its name, or your own part by its folder.

    ``name`` is a folder if it contains a slash.

    Raises:
        DescriptionError: If there is no part of this name.
    """
    if os.sep in name or "/" in name:
        folder = expanded(name).absolute()
        first = _FIRST_FILE[kind]
        if not (folder / first).is_file():
            problem = f"there is no {first}" if folder.is_dir() else "no such folder"
            raise DescriptionError(
                f"{kind} '{name}': {problem}; give a folder like {shared_folder(kind)}/"
                f"{_names(kind)[0]}"
            )
        return CataloguePart(kind=kind, folder=folder)
    none = (NO_GRIPPER,) if kind == "gripper" else ()
    check_choice(kind, name, (*_names(kind), *none))
    return CataloguePart(kind=kind, folder=shared_folder(kind) / name)


def shared_folder(kind: PartKind) -> Path:
    """Return the folder of the built-in parts of a kind and their shared files."""
    return find_package("tool0_description") / "config" / f"{kind}s"


def check_choice(what: str, name: str, valid: tuple[str, ...]) -> None:
    """Raise DescriptionError unless ``name`` is one of the ``valid`` names."""
    if name not in valid:
        hint = did_you_mean(name, valid)
        lists_all = hint.startswith("; valid")
        more = "" if lists_all else f" (there are: {', '.join(valid)})"
        raise DescriptionError(f"unknown {what} '{name}'{hint}{more}")


def _names(kind: PartKind) -> tuple[str, ...]:
    found = shared_folder(kind).glob(f"*/{_FIRST_FILE[kind]}")
    return tuple(sorted(path.parent.name for path in found))
