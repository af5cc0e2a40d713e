"""What the server shows and drives, seen from the server: a simulation, or a view."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, final

from tool0.interfaces.panel.protocol import (
    Frame,
    NoticeCode,
    RobotInfo,
    Scene,
    Severity,
    Status,
)
from tool0.interfaces.panel.robot_files import RobotFiles
from tool0.requests.messages import Mode


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Notification:
    """Something that people should be told."""

    severity: Severity
    code: NoticeCode
    text: str
    time: float | None = None
    """Simulated [s]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Facts:
    """What does not change while the server runs."""

    mode: Mode
    engine: str | None
    control_period: float | None
    """[s]"""
    grasp_assist: bool
    robot: RobotInfo
    files: RobotFiles


class ViewSource(Protocol):
    """A robot that pages see.

    It is read by the server's thread alone.
    """

    @property
    def facts(self) -> Facts: ...

    def scene(self) -> Scene:
        """Return what is around the robot in the newest frame that was returned.

        The same object until something comes or goes.
        """

    def frame(self) -> Frame:
        """Return where everything is: the same object while nothing changes."""

    def status(self, clients: int) -> Status:
        """Return what changes seldom, with the number of pages."""

    def notifications(self) -> Sequence[Notification]:
        """Return what happened since the last call."""

    def close(self) -> None:
        """Let go of what it reads."""
