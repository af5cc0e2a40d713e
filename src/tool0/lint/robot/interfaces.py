"""The names of ros_control's joint interfaces, and the misspelt ones."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import final

from tool0.description.model import Interface
from tool0.errors import SourceLocation, nearest_name

_PACKAGE = "hardware_interface/"
_NAMES = {item.value.removeprefix(_PACKAGE): item.value for item in Interface}
_KNOWN = (
    *_NAMES.values(),
    _PACKAGE + "JointStateInterface",
    _PACKAGE + "PosVelJointInterface",
    _PACKAGE + "PosVelAccJointInterface",
)
"""Those that DefaultRobotHWSim drives, and others that a robot's own driver may."""
_LONGEST = 100


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class InterfaceFacts:
    """One <hardwareInterface>."""

    written: str
    meant: str | None
    """``hardware_interface/…``; None if it is unclear."""
    in_actuator: bool
    """Written in <actuator>: read only if <joint> names none, and deprecated."""
    location: SourceLocation

    @property
    def is_known(self) -> bool:
        """Whether ROS knows it as it is written."""
        return is_interface(self.written)


def is_interface(text: str) -> bool:
    """Return whether ROS knows ``text``, with its package's name or without."""
    return text in _KNOWN or _PACKAGE + text in _KNOWN


def meant_interface(text: str) -> str | None:
    """Return the interface that ``text`` means or may mean, or None."""
    bare = text.strip().strip("\"'").strip()
    if len(bare) > _LONGEST:
        return None
    name = re.split(r"[/\\:.]+", bare)[-1]
    for known in _KNOWN:
        if known == bare or known.removeprefix(_PACKAGE) == name:
            return known
    close = nearest_name(name, _NAMES, cutoff=0.8)
    return _NAMES[close] if close else nearest_name(bare, _NAMES.values(), cutoff=0.8)
