"""A simulated robot with all of its parts, on which the request handlers operate."""

from __future__ import annotations

import contextlib
import math
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Protocol, TypeVar, cast, final

from tool0.description.camera import Camera
from tool0.description.finding import Finding
from tool0.description.model import JointLimits, ParallelGripper
from tool0.description.parts import find_grippers
from tool0.errors import ControlError, did_you_mean
from tool0.kinematics.only_part import only_part
from tool0.programs.store import ProgramStore
from tool0.protocol.bus import Bus, Subscription
from tool0.protocol.fork_guard import OwnProcess
from tool0.protocol.goal_registry import GoalRegistry
from tool0.protocol.goals import Goal
from tool0.protocol.state import (
    MAX_SNAPSHOT_RATE,
    MIN_SNAPSHOT_RATE,
    SNAPSHOT_PERIOD,
    Snapshot,
)
from tool0.sensing.cameras import Cameras
from tool0.sensing.collisions import CollisionFinder
from tool0.sensing.force_torque import ForceTorqueSensors
from tool0.simulation.executor import Executor
from tool0.simulation.journal import Journal
from tool0.simulation.loop import POLL_PERIOD, Loop
from tool0.simulation.program_runs import ProgramRuns
from tool0.simulation.setup import Setup
from tool0.simulation.summary import RunSummary

if TYPE_CHECKING:
    from tool0.kinematics.chain import ArmChain


class Service(Protocol):
    """An object that is owned by a simulation and closed with it."""

    def close(self) -> None: ...


ServiceType = TypeVar("ServiceType", bound=Service)


@final
class Simulation:
    """Description, engine, controllers, loop and sensors of one running robot."""

    def __init__(
        self,
        *,
        setup: Setup,
        executor: Executor,
        loop: Loop,
        bus: Bus,
        ground: float | None = None,
        collisions: CollisionFinder,
        cameras: Mapping[str, Camera],
        warnings: Sequence[Finding] = (),
    ) -> None:
        description, config = setup.description, setup.choice.config
        self.setup = setup
        """Setup at the start.  A replay of the journal from this setup reproduces the
        current state."""
        self.description = description
        self.executor = executor
        self.core = core = executor.core
        """Core of the simulation.  Only the thread of the tick may use ``executor`` and
        ``core``."""
        self.engine = core.engine
        self.loop = loop
        self.bus = bus
        self.poses = setup.poses
        self.defined_controllers = config.types
        """Type of each controller in the YAML, in the order of the YAML."""
        self.parameters = config.parameters()
        """Content of the YAML as plain values."""
        self.joint_limits: Mapping[str, JointLimits] = core.hardware.limits
        """Limits of each driven joint from the YAML; limits that the YAML does not
        define are from the URDF."""
        self.spawn_z = setup.options.spawn_z
        """Height of the robot's root above the world's origin [m]."""
        self.ground = ground
        """Height of the ground in the robot's root frame [m]; None if there is no
        ground."""
        self.warnings = tuple(warnings)
        """Findings about the YAML of the controllers."""
        self.cameras = Cameras(
            description.model, cameras, ground, lambda: self.snapshot
        )
        self.collisions = collisions
        self.force_torque = ForceTorqueSensors(
            description,
            core.engine,
            control_period=loop.control_period,
            start=lambda sensor: loop.call(
                lambda: core.start_sensor(sensor), publishes=False
            ),
            stop=lambda sensor: loop.call(
                lambda: core.stop_sensor(sensor), publishes=False
            ),
        )
        self.goals = GoalRegistry()
        self.programs = ProgramStore(description.model.name)
        self.program_runs = ProgramRuns()
        """Program runs.  Only the thread of the tick may start or advance program
        runs."""
        loop.when_observed = self.program_runs.look
        self.journal = Journal(core, loop)
        """Journal of the requests that have changed the simulation since its start."""
        self._services: dict[object, Service] = {}
        self._lock = threading.Lock()
        self._wall_start = time.perf_counter()

    @property
    def snapshot(self) -> Snapshot:
        """Latest snapshot, which is at most one snapshot period old."""
        snapshot = self.bus.latest
        if snapshot is None:  # the loop publishes a snapshot first
            raise ControlError("no snapshot was published yet")
        return snapshot

    def subscribe(
        self,
        rate: float | None = None,
        *,
        keep_all: bool = False,
        most_kept: int | None = None,
        with_commands: bool = False,
        with_arms: bool = False,
        with_contacts: bool = False,
        forces_period: float = 0.0,
        latest_only: bool = False,
        when_published: Callable[[], None] | None = None,
    ) -> Subscription:
        """Return a reader of snapshots and events, or raise ControlError.

        ControlError is raised if the rate is out of range.

        Args:
            rate: Snapshots per second of simulated time [Hz]; None for the default
                rate.
            keep_all: Whether every snapshot is stored until it is read.
            most_kept: Number of unread snapshots above which the oldest snapshots are
                dropped if ``keep_all`` is True.
            with_commands: Whether the snapshots contain the commands of the joints.
            with_arms: Whether the snapshots contain the motion and the tool wrench of
                each arm.
            with_contacts: Whether the snapshots contain the contacts and the contact
                forces.
            forces_period: Simulated time between two snapshots with contacts and forces
                [s].  Each snapshot with contacts and forces takes 0.2 ms of the tick.
            latest_only: Whether only the latest snapshot is delivered; all events are
                always delivered.
            when_published: Function that is called for every snapshot, in the thread of
                the tick.
        """
        if rate is not None and not MIN_SNAPSHOT_RATE <= rate <= MAX_SNAPSHOT_RATE:
            raise ControlError(
                f"rate {rate} Hz is outside [{MIN_SNAPSHOT_RATE:g}, "
                f"{MAX_SNAPSHOT_RATE:g}] Hz"
            )
        subscription = self.bus.subscribe(
            SNAPSHOT_PERIOD if rate is None else 1.0 / rate,
            (lambda: None) if rate is None else self._update_snapshot_period,
            keep_all=keep_all,
            most_kept=most_kept,
            with_commands=with_commands,
            with_arms=with_arms,
            with_contacts=with_contacts,
            forces_period=forces_period,
            latest_only=latest_only,
            when_published=when_published,
        )
        if rate is not None:
            self._update_snapshot_period()
        return subscription

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.loop.time

    def refresh(self) -> None:
        """Publish a snapshot soon, even while time is stopped."""
        self.loop.refresh()

    def snapshot_with_arms(self) -> Snapshot:
        """Publish a snapshot with the motion of each arm, and return it."""
        return self.loop.snapshot_with_arms()

    def wait_until(self, is_over: Callable[[], bool], timeout: float | None) -> bool:
        """Advance time until ``is_over()`` is true; see ``protocol.backend.States``."""
        loop, bus = self.loop, self.bus
        limit = math.inf if timeout is None else timeout
        start, wall_start = loop.steps, time.monotonic()
        while not is_over():
            loop.check()
            if loop.is_closed:
                raise ControlError("the simulation was closed")
            if loop.is_realtime:
                left = limit - (time.monotonic() - wall_start)
            else:
                left = limit - (loop.steps - start) * loop.control_period
            if not left > 0.0:
                return False
            if loop.is_realtime:
                bus.newer_than(bus.latest, min(POLL_PERIOD, left))
            else:
                # A duration of less than half a tick would be rounded to 0 ticks, and
                # the wait would never end.
                loop.run(max(loop.control_period, min(SNAPSHOT_PERIOD, left)))
        return True

    def wait_for_goal(self, goal: Goal, timeout: float | None) -> bool:
        """Advance time until ``goal`` ends, as ``wait_until`` does."""
        return self.loop.wait_for_goal(goal, timeout)

    @property
    def process(self) -> OwnProcess:
        """Process that owns the simulation."""
        return self.bus.process

    def _update_snapshot_period(self) -> None:
        """Publish snapshots at the rate of the fastest subscriber."""
        bus, loop = self.bus, self.loop
        if not loop.is_closed:
            loop.call(lambda: loop.publish_every(bus.shortest_period), publishes=False)

    @property
    def grasp_assist(self) -> bool:
        """Whether grasp assist attaches gripped objects to the gripper."""
        return self.core.grasp_assist is not None

    def gripper(self, name: str | None) -> ParallelGripper:
        """Return a gripper by name, or the only gripper if no name is given.

        ControlError is raised if the gripper does not exist, or if several grippers
        exist and no name is given.
        """
        grippers = find_grippers(self.description.model)
        if name is None:
            return only_part(grippers, "gripper", self.description.model)
        if name not in grippers:
            hint = did_you_mean(name, set(grippers))
            raise ControlError(f"unknown gripper '{name}'{hint}")
        return grippers[name]

    @cached_property
    def arms(self) -> Mapping[str, ArmChain]:
        """Arms, by name.

        An arm has six revolute joints and ends at a link ``…tool0``.

        The joints have the applicable limits.
        """
        from tool0.kinematics.chain import find_chains  # loads numpy on demand

        return find_chains(self.description.model, self.joint_limits)

    def arm(self, name: str | None) -> ArmChain:
        """Return an arm by name, or the only arm if no name is given.

        ControlError is raised if the arm does not exist, or if several arms exist and
        no name is given.
        """
        arms = self.arms
        if name is not None:
            if name not in arms:
                raise ControlError(f"no arm '{name}'{did_you_mean(name, set(arms))}")
            return arms[name]
        return only_part(arms, "arm", self.description.model)

    def summary(self) -> RunSummary:
        """Return a summary of the run, as plain values for JSON."""
        snapshot, loop = self.snapshot, self.loop
        wall_time = time.perf_counter() - self._wall_start
        sim_time = loop.steps * loop.control_period
        rows = zip(
            snapshot.joint_names,
            snapshot.position,
            snapshot.velocity,
            snapshot.effort,
            strict=True,
        )
        return {
            "engine": self.engine.name,
            "sim_time": sim_time,
            "wall_time": wall_time,
            "real_time_factor": sim_time / wall_time,
            "steps": loop.steps,
            "overruns": loop.overruns,
            "controllers": [
                {
                    "name": status.name,
                    "type": status.type,
                    "state": status.state,
                    "claimed": [name for _, names in status.claimed for name in names],
                }
                for status in snapshot.controllers
            ],
            "joints": {
                name: {"position": position, "velocity": velocity, "effort": effort}
                for name, position, velocity, effort in rows
            },
            "max_drift": loop.max_drift,
            "warnings": [
                {
                    "file": str(item.location.file or "<string>"),
                    "line": item.location.line,
                    "key": item.key,
                    "message": item.text,
                }
                for item in self.warnings
            ],
        }

    def service(self, kind: Callable[[Simulation], ServiceType]) -> ServiceType:
        """Return the simulation's only service of a class.

        The service is created on first use.
        """
        with self._lock:
            found = self._services.get(kind)
            if found is None:
                found = self._services[kind] = kind(self)
        return cast(ServiceType, found)

    def close(self) -> None:
        """End the simulation; closing twice is allowed."""
        with contextlib.ExitStack() as exits:
            exits.callback(self.loop.close)
            exits.callback(self.cameras.close)
            for service in self._services.values():
                exits.callback(service.close)
