"""The gripper of a robot that runs in another process."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Final, final

from tool0.interfaces.socket.requests import Call, RemoteGoal, Start

_GLANCE: Final = 0.02
"""Time between looks at a gripper that moves [wall s]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class RemoteGrasp:
    """What a gripper does: ``tool0.sensing.grasp.GraspState``."""

    motion: str
    opening: float
    """[m]"""
    width: float | None
    """Of what is held between the pads [m]."""
    gobj: int


@final
class RemoteGripper:
    """The gripper of another process."""

    def __init__(self, call: Call, start: Start) -> None:
        self._call = call
        self._start = start

    def move(
        self,
        *,
        opening: float | None = None,
        position: float | None = None,
        speed: float | None = None,
        force: float | None = None,
        effort: float | None = None,
    ) -> RemoteGoal:
        return self._start(
            "gripper.move",
            opening=opening,
            position=position,
            speed=speed,
            force=force,
            effort=effort,
        )

    @property
    def state(self) -> RemoteGrasp:
        return RemoteGrasp(**self._call("gripper.state"))

    def wait(self, timeout: float) -> RemoteGrasp:
        """Return what it does once it moves no longer, or after ``timeout`` wall s."""
        end = time.monotonic() + timeout
        while (state := self.state).motion == "moving" and time.monotonic() < end:
            time.sleep(_GLANCE)
        return state
