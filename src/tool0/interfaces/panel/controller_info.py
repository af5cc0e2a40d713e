"""The controllers of the YAML as a page lists them, and which sliders can drive."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Literal, cast

from tool0.control.manager import ControllerStatus
from tool0.description.model import Joint, JointType
from tool0.interfaces.panel.protocol import ControllerInfo

_State = Literal["unloaded", "initialized", "running", "stopped"]


def controller_infos(
    defined: Mapping[str, str],
    loaded: Sequence[ControllerStatus],
    joints: Mapping[str, Joint],
) -> list[ControllerInfo]:
    """Return every controller in the order of the YAML.

    Args:
        defined: Name → type, loaded or not.
        loaded: The manager's status of those that are.
        joints: Each joint with its limits.
    """
    status_of = {status.name: status for status in loaded}
    return [
        _info(name, kind, status_of.get(name), joints) for name, kind in defined.items()
    ]


def _info(
    name: str, kind: str, status: ControllerStatus | None, joints: Mapping[str, Joint]
) -> ControllerInfo:
    claims = () if status is None else status.claimed
    claimed = [joint for _, names in claims for joint in names]
    state = "unloaded" if status is None else cast(_State, status.state)
    return ControllerInfo(
        name=name,
        type=kind,
        state=state,
        interface=claims[0][0] if claims else None,
        joints=claimed,
        undrivable=_obstacle(kind, state, [joints[joint] for joint in claimed]),
    )


def _obstacle(kind: str, state: _State, joints: Sequence[Joint]) -> str | None:
    """Return why sliders cannot drive a controller of these joints."""
    if kind.endswith("/JointStateController"):
        return "It moves nothing: it only publishes joint states."
    if not kind.endswith("/JointTrajectoryController"):
        name = kind.rpartition("/")[2]
        return f"Sliders drive a JointTrajectoryController; this is a {name}."
    if state == "unloaded":
        return "It is not loaded: load and start it."
    if state != "running":
        return f"It is {state}, not running: start it."
    for joint in joints:
        is_limited = math.isfinite(joint.limits.upper - joint.limits.lower)
        if joint.type is not JointType.CONTINUOUS and not is_limited:
            return (
                f"Joint '{joint.name}' has no position limits, so a slider has no ends."
            )
    return None
