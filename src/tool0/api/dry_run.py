"""Dry run of a program: execution in a separate simulation, from the current state."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final, final

from msgspec.structs import replace

from tool0.description.parts import find_arms
from tool0.description.scene_state import Contact
from tool0.description.transform import from_quaternion, to_pose
from tool0.protocol.channel import Channel
from tool0.protocol.control_box import SetSpeedSlider
from tool0.protocol.goals import CancelGoal
from tool0.protocol.objects import ObjectInfo, ReadContacts, info_of
from tool0.protocol.program import Program
from tool0.protocol.programs import ProgramRun, ReadRuns, RunProgram
from tool0.protocol.reproduction import ReadReproduction
from tool0.protocol.state import Snapshot
from tool0.simulation.handlers.reproduction import restarted
from tool0.simulation.handlers.table import answer
from tool0.simulation.simulation import Simulation

ENGINE: Final = "mujoco"
LOOK: Final = 0.02
"""Time between two checks of the contacts [s]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class TouchReport:
    """A contact of the robot that did not exist at the start of the program."""

    first: str
    """Name of the first body: a link or an object."""
    second: str
    """Name of the second body: a link or an object."""
    time: float
    """Time from the start of the program to the first contact [s]."""
    force: float
    """Maximum contact force [N]."""
    is_of_arm: bool
    """Whether a link of an arm, rather than only the gripper, is in contact."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class JointPeak:
    """The arm joint that came closest to its limit, and the joint's maximum value."""

    joint: str
    """Name of the joint."""
    value: float
    """Maximum absolute value of the velocity [rad/s] or the effort [N·m]."""
    share: float
    """Maximum absolute value as a fraction of the joint's limit."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class DryRun:
    """Result of a program's dry run."""

    end: ProgramRun
    """State of the run at its end, with the duration of the run."""
    touches: tuple[TouchReport, ...]
    """New contacts, in the order in which they began."""
    speed: JointPeak
    """The joint that came closest to its velocity limit."""
    effort: JointPeak
    """The joint that came closest to its effort limit."""

    @property
    def has_collided(self) -> bool:
        """Whether a link of an arm touched another body or another link."""
        return any(touch.is_of_arm for touch in self.touches)


def dry_run(
    channel: Channel,
    program: Program,
    *,
    timeout: float,
    when_passed: Callable[[ProgramRun], None],
) -> DryRun:
    """Run a program in a separate simulation; see ``Programs.dry_run``."""
    snapshot, model = channel.snapshot, channel.description.model
    start = replace(
        channel.call(ReadReproduction()),
        engine=ENGINE,
        engine_options={},
        initial_position={
            joint.name: joint.limits.clamp(snapshot.positions[joint.name])
            for joint in model.movable_joints
            if joint.mimic is None
        },
        scene=tuple(_present(snapshot)),
    )
    meshes = {mesh.uri: Path(mesh.path) for mesh in start.meshes}
    with tempfile.TemporaryDirectory(prefix="tool0-dry-run-") as folder:
        simulation = restarted(start, Path(folder), meshes)
        try:
            for box in snapshot.control_boxes:
                slider = SetSpeedSlider(arm=box.arm, fraction=box.speed_slider)
                answer(simulation, slider)
            goal = answer(simulation, RunProgram(program=program)).goal
            observer = _Observer(simulation)
            while (run := _run(simulation, -goal)).state in {"running", "paused"}:
                when_passed(run)
                if run.time > timeout:
                    answer(simulation, CancelGoal(goal=goal))
                simulation.loop.run(LOOK)
                observer.look(run.time)
            return observer.outcome(run)
        finally:
            simulation.close()


def _run(simulation: Simulation, number: int) -> ProgramRun:
    return next(run for run in answer(simulation, ReadRuns()) if run.run == number)


def _present(snapshot: Snapshot) -> Iterator[ObjectInfo]:
    """Yield the objects of the scene at their current poses."""
    for item, state in zip(snapshot.scene, snapshot.objects, strict=True):
        pose = to_pose(from_quaternion(state.position, state.quat_wxyz))
        yield replace(info_of(item), pose=pose)


@final
class _Observer:
    """Collects new contacts and the maximum speeds and efforts."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        model = simulation.description.model
        joints = [joint for arm in find_arms(model).values() for joint in arm.joints]
        self._own = model.link_by_name.keys()
        self._links = {joint.child for joint in joints}
        self._limits = {
            joint.name: (joint.limits.velocity, joint.limits.effort) for joint in joints
        }
        self._known = {_pair(item) for item in answer(simulation, ReadContacts())}
        self._touches: dict[frozenset[str], TouchReport] = {}
        self._speed = self._effort = JointPeak(
            joint=joints[0].name, value=0.0, share=0.0
        )
        self._states = simulation.subscribe()

    def look(self, time: float) -> None:
        """Check the present contacts and the snapshots since the previous check."""
        for contact in answer(self._simulation, ReadContacts()):
            pair = _pair(contact)
            if pair not in self._known and not pair.isdisjoint(self._own):
                self._note(contact, pair, time)
        for state in self._states.pending():
            places = zip(state.joint_names, state.velocity, state.effort, strict=True)
            for name, velocity, effort in places:
                if name in self._limits:
                    fastest, strongest = self._limits[name]
                    self._speed = _larger(self._speed, name, velocity, fastest)
                    self._effort = _larger(self._effort, name, effort, strongest)

    def _note(self, contact: Contact, pair: frozenset[str], time: float) -> None:
        before = self._touches.get(pair)
        force = math.hypot(*contact.force)
        self._touches[pair] = TouchReport(
            first=contact.first,
            second=contact.second,
            time=time if before is None else before.time,
            force=force if before is None else max(force, before.force),
            is_of_arm=not pair.isdisjoint(self._links),
        )

    def outcome(self, end: ProgramRun) -> DryRun:
        """Return the collected observations with the final state of the run."""
        return DryRun(
            end=end,
            touches=tuple(self._touches.values()),
            speed=self._speed,
            effort=self._effort,
        )


def _pair(contact: Contact) -> frozenset[str]:
    return frozenset((contact.first, contact.second))


def _larger(before: JointPeak, joint: str, value: float, limit: float) -> JointPeak:
    share = abs(value) / limit
    if share <= before.share:
        return before
    return JointPeak(joint=joint, value=abs(value), share=share)
