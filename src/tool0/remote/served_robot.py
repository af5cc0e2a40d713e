"""What the server asks of a robot: the façade of ``runtime/``, seen from here.

``RemoteRobot`` offers the same, so that a program does not care which one it holds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from tool0.control.goal import GoalStatus, Result
from tool0.control.tolerances import ToleranceOverride
from tool0.control.trajectory import TrajectoryPoint


class ServedJoints(Protocol):
    """The measured state, by joint name."""

    @property
    def position(self) -> Mapping[str, float]: ...
    @property
    def velocity(self) -> Mapping[str, float]: ...
    @property
    def effort(self) -> Mapping[str, float]: ...


class ServedStatus(Protocol):
    """One row of ``controllers list``."""

    @property
    def name(self) -> str: ...
    @property
    def type(self) -> str: ...
    @property
    def state(self) -> str:
        """``running``, ``stopped`` or ``initialized``."""

    @property
    def claimed(self) -> Sequence[str]:
        """The joints it claims while it runs."""


class ServedGoal(Protocol):
    """A goal in progress, as ``runtime/`` hands it out."""

    @property
    def status(self) -> GoalStatus: ...
    @property
    def result(self) -> Result | None: ...
    def when_finished(self, callback: Callable[..., None]) -> None:
        """Call ``callback`` once when the goal ends, from any thread."""

    def cancel(self) -> None: ...


class ServedMotion(Protocol):
    """Where a trajectory wants the joints to be at one instant."""

    @property
    def joint_names(self) -> Sequence[str]: ...
    @property
    def positions(self) -> Sequence[float]: ...


class ServedController(Protocol):
    """A handle on one controller."""

    def follow(
        self,
        points: Sequence[TrajectoryPoint],
        *,
        joint_names: Sequence[str] | None = None,
        stamp: float | None = None,
        path_tolerance: Mapping[str, ToleranceOverride] | None = None,
        goal_tolerance: Mapping[str, ToleranceOverride] | None = None,
        goal_time_tolerance: float | None = None,
    ) -> ServedGoal: ...
    def query_state(self, time: float) -> ServedMotion: ...


class ServedGripper(Protocol):
    """The gripper, in units a person thinks in."""

    def move(
        self,
        *,
        opening: float | None = None,
        position: float | None = None,
        speed: float | None = None,
        effort: float | None = None,
    ) -> ServedGoal: ...


class ServedRobot(Protocol):
    """A robot that runs, here or in another process."""

    @property
    def time(self) -> float:
        """Simulated time [s]."""

    @property
    def joint_state(self) -> ServedJoints: ...
    @property
    def gripper(self) -> ServedGripper: ...
    def controllers(self) -> Sequence[ServedStatus]: ...
    def controller(self, name: str) -> ServedController: ...
    def load(self, name: str) -> None: ...
    def unload(self, name: str) -> None: ...
    def switch(
        self,
        *,
        start: Sequence[str] = (),
        stop: Sequence[str] = (),
        strict: bool = True,
    ) -> None: ...
    def pause(self) -> None: ...
    def resume(self) -> None: ...
    def step(self, n: int = 1) -> None: ...
    def reset(self) -> None: ...
    def emergency_stop(self, engaged: bool) -> None: ...
    def summary(self) -> Mapping[str, object]: ...
