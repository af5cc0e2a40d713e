"""What the server shows and drives, seen from the server: a simulation, or a view."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Protocol, final

from tool0.interfaces.panel.protocol import (
    ClientMessage,
    Frame,
    Mode,
    NoticeCode,
    RobotInfo,
    Scene,
    Severity,
    Status,
    Stream,
)
from tool0.interfaces.panel.robot_files import RobotFiles


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Happening:
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


class PanelSource(Protocol):
    """A robot that pages see.

    Only ``carry_out`` may take time and is called from threads of its own; the rest is
    called by the server's thread alone.
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

    def happenings(self) -> Sequence[Happening]:
        """Return what happened since the last call."""

    def check(self, message: Stream) -> None:
        """Raise Tool0Error for a stream that can never be carried out."""

    def displaced_by(self, message: ClientMessage) -> Collection[str]:
        """Return the streams that a request puts an end to, by ``stream_key``."""

    def carry_out(self, message: ClientMessage) -> None:
        """Do what a page asks for, or raise Tool0Error."""

    def close(self) -> None:
        """Let go of what it reads."""


def stream_key(message: Stream) -> str:
    """Return what the newest of a stream replaces: its controller's, or the pose's."""
    return getattr(message, "controller", "")
