"""Whether ROS 1 could be spoken here, which, and what is missing."""

from __future__ import annotations

import importlib
import importlib.util
import os
import sys
import warnings
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, final

from tool0.errors import RosUnavailableError
from tool0.installation.ros1.generation import package_names
from tool0.installation.ros1.library import DEBIAN, DEFAULT_MASTER, import_ros
from tool0.installation.ros1.messages import is_generated
from tool0.installation.ros1.packages import (
    PARTS,
    Part,
    lacks,
    package_prefix,
    package_version,
)

_NAME: Final = "/tool0_status"
"""Under which the master is asked."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Readiness:
    """What ``tool0 ros1 status`` tells."""

    rospy: Path | None = None
    """The folder it is imported from."""
    version: str | None = None
    """Of rospy."""
    source: str | None = None
    """Whose packages they are."""
    master: str
    """Where one is expected."""
    is_master_up: bool = False
    """Whether it answers."""
    missing: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Part → what of it is not there; a part that is whole is not named."""
    messages: dict[str, str] = field(default_factory=dict)
    """Package of messages → ``installed``, or ``ours``."""
    remedies: tuple[str, ...] = ()
    """What to do about it."""

    @property
    def can_run(self) -> bool:
        """Whether ``tool0 bringup --ros1`` works, given a master."""
        needed = (part.name for part in PARTS if part.is_needed)
        return self.rospy is not None and self.missing.keys().isdisjoint(needed)

    def why_not(self, parts: Iterable[str]) -> str | None:
        """Return why these parts cannot all be used, None if they can."""
        gaps = [
            f"no {', '.join(self.missing[part])}"
            for part in parts
            if part in self.missing
        ]
        return "; ".join([*gaps, *self.remedies]) if gaps else None

    def as_json(self) -> dict[str, object]:
        """Return what JSON can hold."""
        return {
            "can_run": self.can_run,
            "rospy": None if self.rospy is None else str(self.rospy),
            "version": self.version,
            "source": self.source,
            "master": self.master,
            "is_master_up": self.is_master_up,
            "parts": {part.name: part.name not in self.missing for part in PARTS},
            "missing": {name: list(what) for name, what in self.missing.items()},
            "messages": self.messages,
            "remedies": list(self.remedies),
        }

    def rows(self) -> list[tuple[str, str]]:
        """Return names and values for people."""
        return [
            ("master", f"{self.master}, {_up(self.is_master_up)}"),
            *((part.name, self._about(part)) for part in PARTS),
            *((name, _whose(kind)) for name, kind in self.messages.items()),
            *(("to do", text) for text in self.remedies),
        ]

    def _about(self, part: Part) -> str:
        missing = self.missing.get(part.name, ())
        if part.name == "rospy" and not missing:
            return f"{self.version or 'unknown version'}, {self.source}, {self.rospy}"
        if not missing:
            return "there"
        found_none = len(missing) == _count(part)
        what = "none" if found_none else f"incomplete, no {', '.join(missing)}"
        return f"{what}; for {part.purpose}"


def readiness() -> Readiness:
    """Look what is there; nothing is started.  It imports rospy."""
    master = os.environ.get("ROS_MASTER_URI", DEFAULT_MASTER)
    everything = {part.name: _all_of(part) for part in PARTS}
    try:
        import_ros()
        _import_rospy()
    except RosUnavailableError as error:
        return Readiness(master=master, missing=everything, remedies=(str(error),))
    found = {part.name: lacks(part) for part in PARTS}
    missing = {name: what for name, what in found.items() if what}
    return Readiness(
        rospy=rospy_folder(),
        version=package_version("rospy"),
        source=whose(),
        master=master,
        is_master_up=_is_up(),
        missing=missing,
        messages={name: _whose_messages(name) for name in package_names()},
        remedies=(_remedy(missing),) if missing else (),
    )


def rospy_folder() -> Path | None:
    """Return where rospy would be imported from."""
    spec = importlib.util.find_spec("rospy")
    return None if spec is None or spec.origin is None else Path(spec.origin).parent


def whose() -> str | None:
    """Return whose ROS is importable: ``Debian's``, ``RoboStack``, a distribution."""
    folder = rospy_folder()
    if folder is None:
        return None
    if folder.parent == DEBIAN:
        return "the distribution's"
    if (Path(sys.prefix) / "conda-meta").is_dir():
        return "RoboStack"
    return f"ROS {os.environ.get('ROS_DISTRO', 'of a workspace')}"


def own_command(parts: Iterable[Part]) -> str | None:
    """Return what installs the parts in a ROS that is not the distribution's."""
    distro = os.environ.get("ROS_DISTRO", "noetic")
    names = (name.replace("_", "-") for part in parts for name in part.ros)
    packages = " ".join(f"ros-{distro}-{name}" for name in dict.fromkeys(names))
    if whose() == "RoboStack":
        return f"mamba install -c conda-forge -c robostack-{distro} {packages}"
    prefix = package_prefix("rospy")
    if prefix is not None and prefix.is_relative_to("/opt/ros"):
        return f"sudo apt-get install {packages}"
    return f"install in the workspace that rospy is from: {packages}"


def _remedy(missing: dict[str, tuple[str, ...]]) -> str:
    if whose() != "the distribution's":
        return own_command(p for p in PARTS if p.name in missing) or ""
    return f"tool0 ros1 install{' --rviz' if 'rviz' in missing else ''}"


def _import_rospy() -> None:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # its own affair
            importlib.import_module("rospy")
    except ImportError as error:
        raise RosUnavailableError(
            f"rospy is in '{rospy_folder()}' but cannot be imported ({error}); install "
            f"what it misses into '{sys.prefix}', such as: pip install rospkg"
        ) from None


def _is_up() -> bool:
    from tool0.installation.ros1.master import Master

    try:
        return Master(_NAME).is_there
    except RosUnavailableError:
        return False  # its address is none


def _up(is_up: bool) -> str:
    return "answers" if is_up else "does not answer: start roscore, or add --roscore"


def _whose_messages(package: str) -> str:
    spec = importlib.util.find_spec(package)
    if spec is None or spec.origin is None:
        return "ours"
    return "ours" if is_generated(str(Path(spec.origin).parents[1])) else "installed"


def _whose(kind: str) -> str:
    return "installed" if kind == "installed" else "not installed: tool0 makes its own"


def _all_of(part: Part) -> tuple[str, ...]:
    definitions = (f"{name}/msg" for name in part.definitions)
    return (*part.modules, *part.programs, *part.nodes, *definitions)


def _count(part: Part) -> int:
    return len(_all_of(part))
