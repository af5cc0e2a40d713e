"""What an edge may ask of the loop: one frozen value per request."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import final

from tool0.control.config import ControllerConfig
from tool0.control.goal import Goal
from tool0.control.manager import Strictness
from tool0.control.trajectory import TrajectoryGoal
from tool0.description.scene import SceneObject
from tool0.hardware.drive_limits import DriveLimits
from tool0.hardware.engine import ObjectState
from tool0.sensing.force_torque_sensor import ForceTorqueSensor


@final
@dataclass(frozen=True, slots=True)
class LoadController:
    name: str
    config: ControllerConfig | None = None
    """Its parameters; None for those of the bring-up."""


@final
@dataclass(frozen=True, slots=True)
class UnloadController:
    name: str


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class SwitchControllers:
    start: tuple[str, ...] = ()
    stop: tuple[str, ...] = ()
    strictness: Strictness = Strictness.STRICT


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class FollowTrajectory:
    """A goal with an outcome, as ROS's action takes it."""

    controller: str
    goal: TrajectoryGoal
    bounds: Mapping[str, DriveLimits] = field(default_factory=dict)
    """Joint → what bounds its drive until the joint's next goal."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class CommandTrajectory:
    """A trajectory without an outcome, as ROS's topic takes it."""

    controller: str
    goal: TrajectoryGoal


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class MoveJoints:
    """Goals along smooth motions, of every trajectory controller that it concerns."""

    positions: Mapping[str, float]
    """Joint → where to [rad | m]."""
    speed: float
    """Part of each joint's largest velocity."""
    controller: str | None = None
    """The one whose joints they are; None for whichever claim them."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class SteerJoints:
    """A smooth motion of one trajectory controller, without an outcome."""

    controller: str
    positions: Mapping[str, float]
    """Joint → where to [rad | m]."""
    speed: float
    """Part of each joint's largest velocity."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class CommandGripper:
    controller: str
    position: float
    """[rad | m]"""
    max_effort: float | None = None
    """[N·m | N]; None takes the controller's own."""
    bounds: DriveLimits | None = None
    """What bounds the joint's drive until its next goal."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class CommandJoints:
    """Set-points of a forwarding controller, in the order of its joints."""

    controller: str
    values: tuple[float, ...]


@final
@dataclass(frozen=True, slots=True)
class CancelGoal:
    goal: Goal


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class QueryState:
    """What a trajectory controller will want at ``time`` [s]."""

    controller: str
    time: float


@final
@dataclass(frozen=True, slots=True)
class ReadController:
    """The present state of a controller that reports one."""

    controller: str


@final
@dataclass(frozen=True, slots=True)
class ReadSpec:
    """The parameters of a loaded controller."""

    controller: str


@final
@dataclass(frozen=True, slots=True)
class ReadContacts:
    """What presses on what, in the last step."""


@final
@dataclass(frozen=True, slots=True)
class StartSensor:
    """Sample once now, and then in the tick."""

    sensor: ForceTorqueSensor


@final
@dataclass(frozen=True, slots=True)
class StopSensor:
    """Sample no more; a sensor that does not is left alone."""

    sensor: ForceTorqueSensor


@final
@dataclass(frozen=True, slots=True)
class SpawnObject:
    """Put a further object into the scene, at its pose and at rest."""

    item: SceneObject


@final
@dataclass(frozen=True, slots=True)
class DeleteObject:
    """Take an object out of the scene."""

    name: str


@final
@dataclass(frozen=True, slots=True)
class PlaceObject:
    """Put an object somewhere, moving so; a reset puts it back where it began."""

    state: ObjectState


@final
@dataclass(frozen=True, slots=True)
class SetPaused:
    paused: bool


@final
@dataclass(frozen=True, slots=True)
class Step:
    """Run ``ticks`` control periods while paused."""

    ticks: int = 1


@final
@dataclass(frozen=True, slots=True)
class SetSpeed:
    """Run at ``factor`` times real time."""

    factor: float


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Reset:
    """Start again in the initial pose or in ``position``, objects where they began."""

    position: Mapping[str, float] = field(default_factory=dict)
    keep_time: bool = False
    """Whether simulated time goes on, as after ROS's ``reset_world``."""


@final
@dataclass(frozen=True, slots=True)
class EmergencyStop:
    engaged: bool


CoreCommand = (
    LoadController
    | UnloadController
    | SwitchControllers
    | FollowTrajectory
    | CommandTrajectory
    | MoveJoints
    | SteerJoints
    | CommandGripper
    | CommandJoints
    | CancelGoal
    | QueryState
    | ReadController
    | ReadSpec
    | ReadContacts
    | StartSensor
    | StopSensor
    | SpawnObject
    | DeleteObject
    | PlaceObject
    | Reset
    | EmergencyStop
)
"""Answered by the core: engine, drives and controllers."""

LoopCommand = SetPaused | Step | SetSpeed
"""Answered by the loop itself: they are about time."""

Command = CoreCommand | LoopCommand
