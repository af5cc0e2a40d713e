"""Whether ROS 1 can be used here, which, and what is missing."""

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
from tool0.installation.ros1.library import (
    DEFAULT_MASTER,
    import_ros,
    is_of_distribution,
    ros_origin,
    rospy_folder,
)
from tool0.installation.ros1.messages import is_generated
from tool0.installation.ros1.packages import (
    COMPONENTS,
    RosComponent,
    missing_of,
    package_prefix,
    package_version,
)

_CALLER: Final = "/tool0_status"
"""The name under which the master is called."""
_MESSAGES: Final = {
    "installed": "installed",
    "ours": "not installed: tool0 makes its own",
}


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Ros1Status:
    """What ``tool0 ros1 status`` prints."""

    rospy: Path | None = None
    """The folder it is imported from."""
    version: str | None = None
    """Of rospy."""
    source: str | None = None
    """Where its packages come from."""
    master: str
    """Where one is expected."""
    is_master_up: bool = False
    """Whether it answers."""
    missing: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Component → what of it is missing; complete ones are left out."""
    messages: dict[str, str] = field(default_factory=dict)
    """Package of messages → ``installed``, or ``ours``."""
    remedies: tuple[str, ...] = ()
    """What installs it."""

    @property
    def can_run(self) -> bool:
        """Whether ``tool0 bringup --ros1`` works, given a master."""
        needed = (part.name for part in COMPONENTS if part.is_needed)
        return self.rospy is not None and self.missing.keys().isdisjoint(needed)

    def why_not(self, names: Iterable[str]) -> str | None:
        """Return why these components cannot all be used, None if they can."""
        gaps = [
            f"no {', '.join(self.missing[name])}"
            for name in names
            if name in self.missing
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
            "parts": {part.name: part.name not in self.missing for part in COMPONENTS},
            "missing": {name: list(what) for name, what in self.missing.items()},
            "messages": self.messages,
            "remedies": list(self.remedies),
        }

    def rows(self) -> list[tuple[str, str]]:
        """Return names and values for people."""
        return [
            ("master", f"{self.master}, {_up(self.is_master_up)}"),
            *((part.name, self._about(part)) for part in COMPONENTS),
            *((name, _MESSAGES[kind]) for name, kind in self.messages.items()),
            *(("to do", text) for text in self.remedies),
        ]

    def _about(self, part: RosComponent) -> str:
        missing = self.missing.get(part.name, ())
        if part.name == "rospy" and not missing:
            return f"{self.version or 'unknown version'}, {self.source}, {self.rospy}"
        if not missing:
            return "there"
        found_none = len(missing) == len(part.contents)
        state = "none" if found_none else f"incomplete, no {', '.join(missing)}"
        return f"{state}; for {part.purpose}"


def ros1_status() -> Ros1Status:
    """Return the status; nothing is started.  It imports rospy."""
    master = os.environ.get("ROS_MASTER_URI", DEFAULT_MASTER)
    everything = {part.name: part.contents for part in COMPONENTS}
    try:
        import_ros()
        _import_rospy()
    except RosUnavailableError as error:
        return Ros1Status(master=master, missing=everything, remedies=(str(error),))
    found = {part.name: missing_of(part) for part in COMPONENTS}
    missing = {name: what for name, what in found.items() if what}
    return Ros1Status(
        rospy=rospy_folder(),
        version=package_version("rospy"),
        source=ros_origin(),
        master=master,
        is_master_up=_is_up(),
        missing=missing,
        messages={name: _messages_kind(name) for name in package_names()},
        remedies=(_remedy(missing),) if missing else (),
    )


def other_install_command(components: Iterable[RosComponent]) -> str | None:
    """Return what installs them in a ROS that is not the distribution's."""
    distro = os.environ.get("ROS_DISTRO", "noetic")
    names = (name.replace("_", "-") for one in components for name in one.ros)
    packages = " ".join(f"ros-{distro}-{name}" for name in dict.fromkeys(names))
    if ros_origin() == "RoboStack":
        return f"mamba install -c conda-forge -c robostack-{distro} {packages}"
    prefix = package_prefix("rospy")
    if prefix is not None and prefix.is_relative_to("/opt/ros"):
        return f"sudo apt-get install {packages}"
    return f"install in the workspace that rospy is from: {packages}"


def _remedy(missing: dict[str, tuple[str, ...]]) -> str:
    if not is_of_distribution():
        return other_install_command(p for p in COMPONENTS if p.name in missing) or ""
    return f"tool0 ros1 install{' --rviz' if 'rviz' in missing else ''}"


def _import_rospy() -> None:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # not ours to fix
            importlib.import_module("rospy")
    except ImportError as error:
        raise RosUnavailableError(
            f"rospy is in '{rospy_folder()}' but cannot be imported ({error}); install "
            f"what it lacks into '{sys.prefix}', such as: pip install rospkg"
        ) from None


def _is_up() -> bool:
    from tool0.installation.ros1.master import Master

    try:
        return Master(_CALLER).is_up
    except RosUnavailableError:
        return False  # its address is invalid


def _up(is_up: bool) -> str:
    return "answers" if is_up else "does not answer: start roscore, or add --roscore"


def _messages_kind(package: str) -> str:
    spec = importlib.util.find_spec(package)
    if spec is None or spec.origin is None:
        return "ours"
    return "ours" if is_generated(str(Path(spec.origin).parents[1])) else "installed"
