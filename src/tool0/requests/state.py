"""Requests about the whole robot: state, streams, time and safety."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from msgspec import Meta, Struct, field, structs

from tool0.description.catalogue import Part
from tool0.description.forward_kinematics import joint_positions, link_pose
from tool0.description.model import JointLimits
from tool0.description.packages import BUNDLED
from tool0.description.robot import (
    CatalogueRobot,
    RobotDescription,
    load_description,
)
from tool0.description.transform import Transform
from tool0.description.urdf import read_model
from tool0.errors import ControlError
from tool0.requests.table import JointPositions, Name, Request, answer, handles
from tool0.runtime.bus import WasFrozen
from tool0.runtime.notifications import frozen_text
from tool0.runtime.simulation import MAX_SNAPSHOT_RATE, MIN_SNAPSHOT_RATE, Simulation
from tool0.sensing.snapshot import Snapshot

if TYPE_CHECKING:
    from xml.dom.minidom import Document

logger = logging.getLogger(__name__)


class LimitsInfo(Struct, frozen=True, kw_only=True):
    """Limits of a joint; None where there is no limit."""

    lower: float | None
    upper: float | None
    velocity: float | None
    effort: float | None
    acceleration: float | None
    """Of planned motions."""
    jerk: float | None
    """Of planned motions."""

    @property
    def limits(self) -> JointLimits:
        """The limits as values of the model: infinite where there are none."""
        given = {k: v for k, v in structs.asdict(self).items() if v is not None}
        return JointLimits(**given)


class SimulationInfo(Struct, frozen=True, kw_only=True):
    """What does not change while a bring-up runs."""

    engine: str
    """Name of the physics engine: mujoco or gazebo."""
    control_period: float
    """Simulated time of a tick [s]."""
    is_realtime: bool
    """Whether time passes by itself."""
    spawn_z: float
    """Height of the robot's root above the world's origin [m]."""
    ground: float | None
    """Height of the ground in the robot's root [m]; None without ground."""
    grasp_assist: bool
    """Whether grasp assist attaches gripped objects."""
    joint_limits: dict[str, LimitsInfo]
    """Limits of each driven joint [rad | m], [rad/s | m/s], [N·m | N], and so on."""
    defined_controllers: dict[str, str]
    """Controllers of the YAML, loaded or not: name → type."""
    parameters: dict[str, Any]
    """The whole YAML, as plain values."""
    warnings: tuple[str, ...]
    """Findings about the YAML."""


class CatalogueRobotInfo(Struct, frozen=True, kw_only=True):
    """An arm with its gripper."""

    name: str
    """Its name in a cell; empty for a single robot."""
    arm: str
    """The arm's folder."""
    gripper: str | None
    """The gripper's folder; None without one."""
    prefix: str
    """Prefix of the names of its links and joints."""


class NamespaceInfo(Struct, frozen=True, kw_only=True):
    """A robot of a cell that has a namespace of its own in ROS."""

    name: str
    """Of the robot, and of the namespace."""
    urdf: str
    """The robot alone, with the names that it has alone."""


class DescriptionInfo(Struct, frozen=True, kw_only=True):
    """The robot's description."""

    urdf: str
    """The robot as one URDF document."""
    source: str
    """The xacro or URDF file it was read from."""
    robots: tuple[CatalogueRobotInfo, ...]
    """Its arms and grippers of the catalogue; none for your own file."""
    namespaces: tuple[NamespaceInfo, ...]
    """The robots of a cell with namespaces; otherwise none."""
    packages: dict[str, str]
    """``file://`` URIs of the ROS packages inside tool0, which the URDF refers to."""


def described_by(info: DescriptionInfo, document: Document) -> RobotDescription:
    """Return the robot in another process, or of another time.

    Args:
        info: What the bring-up said.
        document: Its URDF, which may have other paths of meshes.

    Raises:
        ModelError: If the document is no robot.
    """
    robots = tuple(
        CatalogueRobot(
            name=robot.name,
            arm=Part(kind="arm", folder=Path(robot.arm)),
            gripper=None
            if robot.gripper is None
            else Part(kind="gripper", folder=Path(robot.gripper)),
            prefix=robot.prefix,
        )
        for robot in info.robots
    )
    return RobotDescription(
        model=read_model(document),
        source=Path(info.source),
        robots=robots,
        _document=document,
    )


class ReadDescription(Request[DescriptionInfo], frozen=True):
    """The robot's description as URDF."""


class ReadInfo(Request[SimulationInfo], frozen=True):
    """What does not change while a bring-up runs."""


class ReadSnapshot(Request[Snapshot], frozen=True):
    """The newest state of the whole robot."""


class ReadLinkPose(Request[Transform], frozen=True):
    """The measured frame of a link."""

    link: Name
    relative_to: str | None = None
    """The link in whose frame it is; the root, if left out."""


class ReadSummary(Request[dict[str, Any]], frozen=True):
    """A summary of the run in plain values."""


@handles(ReadInfo)
def _info(simulation: Simulation, request: ReadInfo) -> SimulationInfo:
    return SimulationInfo(
        engine=simulation.engine.name,
        control_period=simulation.loop.control_period,
        is_realtime=simulation.loop.is_realtime,
        spawn_z=simulation.spawn_z,
        ground=simulation.ground,
        grasp_assist=simulation.grasp_assist,
        joint_limits={
            name: LimitsInfo(
                **{key: _finite(value) for key, value in asdict(limits).items()}
            )
            for name, limits in simulation.joint_limits.items()
        },
        defined_controllers=dict(simulation.defined_controllers),
        parameters=dict(simulation.parameters),
        warnings=tuple(map(str, simulation.warnings)),
    )


@handles(ReadDescription)
def _description(simulation: Simulation, request: ReadDescription) -> DescriptionInfo:
    description = simulation.description
    return DescriptionInfo(
        urdf=description.urdf,
        source=str(description.source),
        robots=tuple(
            CatalogueRobotInfo(
                name=robot.name,
                arm=str(robot.arm.folder),
                gripper=None if robot.gripper is None else str(robot.gripper.folder),
                prefix=robot.prefix,
            )
            for robot in description.robots
        ),
        namespaces=tuple(_namespaces(simulation)),
        packages={
            folder.name: folder.as_uri()
            for folder in BUNDLED.iterdir()
            if (folder / "package.xml").is_file()
        },
    )


def _namespaces(simulation: Simulation) -> Iterator[NamespaceInfo]:
    cell = simulation.description.cell
    for robot in cell.robots if cell is not None and cell.namespaces else ():
        alone = load_description(robot.description, spawn_z=simulation.spawn_z)
        yield NamespaceInfo(name=robot.name, urdf=alone.urdf)


handles(ReadSnapshot)(lambda sim, _: sim.snapshot)


@handles(ReadLinkPose)
def _link_pose(simulation: Simulation, request: ReadLinkPose) -> Transform:
    return link_pose(
        simulation.description.model,
        simulation.snapshot.positions,
        request.link,
        relative_to=request.relative_to,
    )


handles(ReadSummary)(lambda sim, _: sim.summary())


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


class Subscribe(Request[None], frozen=True):
    """Receive every snapshot as a ``snapshot`` message, and events as they happen.

    A second request changes the rate.  A slow reader loses the oldest snapshots; the
    next one says how many.
    """

    rate: Annotated[float, Meta(ge=MIN_SNAPSHOT_RATE, le=MAX_SNAPSHOT_RATE)] = 125.0
    """Snapshots per simulated second [Hz]: the next divisor of the control rate."""


class Unsubscribe(Request[None], frozen=True):
    """Receive no more snapshots and events."""


class SubscribeView(Request[None], frozen=True):
    """Receive ``view``, ``scene``, ``status``, ``frame`` and ``notice``: the panel.

    Frames come at most 60 times a second of wall time, the newest only.  A second
    request changes what they have.
    """

    contacts: bool = False
    """Whether frames have the contacts and their forces."""
    wrenches: bool = False
    """Whether frames have the wrench on each tool."""


class ViewShown(Request[None], frozen=True):
    """Report that a page has drawn the robot; ``tool0 demo`` starts then."""


@handles(Subscribe)
@handles(Unsubscribe)
@handles(SubscribeView)
@handles(ViewShown)
def _only_on_connections(simulation: Simulation, request: Any) -> None:
    raise ControlError("streams are for connections; here, use robot.subscribe()")


# ---- time and safety ----------------------------------------------------------------


class Pause(Request[None], frozen=True):
    """Pause simulated time."""


class Resume(Request[None], frozen=True):
    """Let simulated time run."""


class Step(Request[float], frozen=True):
    """Run control periods while paused; the response is the time then [s]."""

    ticks: Annotated[int, Meta(ge=1, le=1_000_000)] = 1


class Run(Request[None], frozen=True):
    """Let simulated time pass; without real time, only this request advances it."""

    duration: Annotated[float, Meta(ge=0.0)]
    """[s]"""


class SetSpeed(Request[None], frozen=True):
    """Change the speed of a simulation in real time."""

    factor: Annotated[float, Meta(gt=0.0, le=1000.0)]
    """Simulated seconds per wall second."""


class Reset(Request[None], frozen=True):
    """Return to the initial pose; goals are PREEMPTED, objects go to their start."""

    position: JointPositions = field(default_factory=dict)
    """Joint → position instead of the initial one [rad | m]."""
    keep_time: bool = False
    """Whether simulated time continues."""
    allow_penetration: bool = False
    """Whether ``position`` may put a link into something."""


class EmergencyStop(Request[None], frozen=True):
    """Brake every joint at once, or release the brakes; goals are PREEMPTED."""

    engaged: bool = True


class StopMotions(Request[None], frozen=True):
    """Stop every motion, without brakes: nothing goes on by itself.

    Goals are PREEMPTED, programs end, and arms that were taken are given back.  The
    simulation does so itself when its process was frozen for a second or more.
    """


handles(Pause, in_tick=True)(lambda sim, _: sim.loop.set_paused(True))
handles(Resume, in_tick=True)(lambda sim, _: sim.loop.set_paused(False))


@handles(Step, in_tick=True)
def _step(simulation: Simulation, request: Step) -> float:
    simulation.loop.step(request.ticks)
    return simulation.loop.time


handles(Run)(lambda sim, request: sim.loop.run(request.duration))
handles(SetSpeed, in_tick=True)(lambda sim, request: sim.loop.set_speed(request.factor))


def _check_pose(simulation: Simulation, request: Reset) -> None:
    """Raise PenetrationError for a pose that cannot be."""
    if not request.position or request.allow_penetration:
        return
    usual = simulation.setup.assembly.position
    position = joint_positions(simulation.description.model, request.position, usual)
    simulation.collisions.require_pose(position, usual, simulation.snapshot.scene)


@handles(Reset, in_tick=True, prepare=_check_pose)
def _reset(simulation: Simulation, request: Reset, checked: None) -> None:
    simulation.loop.reset(request.position, request.keep_time)


handles(EmergencyStop, in_tick=True, urgent=True)(
    lambda sim, request: sim.core.set_stopped(request.engaged)
)


@handles(StopMotions, in_tick=True)
def _stop_motions(simulation: Simulation, request: StopMotions) -> None:
    core = simulation.core
    for goal in simulation.goals.active():
        if not simulation.program_runs.cancel(goal):
            core.cancel(goal)
    for arm in core.arm_motions.specs:
        if not simulation.program_runs.is_ending(arm):
            core.arm_motions.give_back(arm, core.state)
    core.stop_trajectories()


def stop_after_freezes(simulation: Simulation) -> None:
    """Let every motion end when the process did not run for a while.

    Who moved the robot, and what it saw, may have changed meanwhile.
    """

    def stop(duration: float) -> None:
        simulation.bus.announce(WasFrozen(duration, simulation.loop.time))
        logger.warning("%s", frozen_text(duration))
        answer(simulation, StopMotions())

    simulation.loop.when_frozen = stop
