"""The controllers of the YAML as a page lists them, and why one cannot be driven."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Literal, cast

from tool0.control.manager import ControllerStatus
from tool0.description.model import Joint, JointType
from tool0.interfaces.panel.protocol import ControllerInfo

_DRIVABLE = "/JointTrajectoryController"
_State = Literal["unloaded", "initialized", "running", "stopped"]


def controller_infos(
    defined: Mapping[str, str],
    loaded: Sequence[ControllerStatus],
    joints: Mapping[str, Joint],
) -> list[ControllerInfo]:
    """Return every controller in the order of the YAML.

    Args:
        defined: Name → type, loaded or not.
        loaded: What the manager says of those that are.
        joints: Each joint with its limits.
    """
    status_of = {status.name: status for status in loaded}
    return [
        _unloaded(name, kind)
        if name not in status_of
        else _loaded(status_of[name], joints)
        for name, kind in defined.items()
    ]


def _unloaded(name: str, kind: str) -> ControllerInfo:
    return ControllerInfo(
        name=name,
        type=kind,
        state="unloaded",
        interface=None,
        joints=[],
        undrivable=_wrong_type(kind) or "It is not loaded: load and start it.",
    )


def _loaded(status: ControllerStatus, joints: Mapping[str, Joint]) -> ControllerInfo:
    claimed = [joint for _, joints in status.claimed for joint in joints]
    return ControllerInfo(
        name=status.name,
        type=status.type,
        state=cast(_State, status.state),  # the manager's words are these
        interface=status.claimed[0][0] if status.claimed else None,
        joints=claimed,
        undrivable=_wrong_type(status.type)
        or _not_running(status.state)
        or _unlimited([joints[name] for name in claimed]),
    )


def _wrong_type(kind: str) -> str | None:
    if kind.endswith(_DRIVABLE):
        return None
    if kind.endswith("/JointStateController"):
        return "It moves nothing: it only publishes joint states."
    name = kind.rpartition("/")[2]
    return f"Sliders drive a JointTrajectoryController; this is a {name}."


def _not_running(state: str) -> str | None:
    return None if state == "running" else f"It is {state}, not running: start it."


def _unlimited(joints: Sequence[Joint]) -> str | None:
    for joint in joints:
        if joint.type is JointType.CONTINUOUS:
            continue
        if not math.isfinite(joint.limits.upper - joint.limits.lower):
            return (
                f"Joint '{joint.name}' has no position limits, so a slider has no ends."
            )
    return None
