"""The gripper as a person thinks of it: by its opening."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from numbers import Real
from typing import TYPE_CHECKING, final

from tool0.control.trajectory import TrajectoryPoint
from tool0.description.model import ParallelGripper
from tool0.errors import ControlError, GoalTimeoutError
from tool0.hardware.drive_limits import DriveLimits
from tool0.runtime.bus import SNAPSHOT_PERIOD
from tool0.runtime.gripper_motion import opening_motion
from tool0.sensing.grasp import GraspState, judge, wanted_openings

if TYPE_CHECKING:
    from tool0.runtime.bus import Bus
    from tool0.runtime.handles import GoalHandle
    from tool0.runtime.loop import Loop
    from tool0.runtime.robot import Robot

SQUEEZED = 0.001
"""How far inside of where the pads are they must be wanted to squeeze something [m]."""
_PATIENCE = 0.05  # [wall s] between looks at whether the loop still lives


@final
class Gripper:
    """Moves one parallel gripper through whichever controller claims its joint."""

    def __init__(
        self, geometry: ParallelGripper, robot: Robot, loop: Loop, bus: Bus
    ) -> None:
        self.geometry = geometry
        self._robot = robot
        self._loop = loop
        self._bus = bus

    @property
    def opening(self) -> float:
        """Distance between the pads [m], 0 closed."""
        position = self._robot.joint_state.position[self.geometry.joint]
        return max(0.0, self.geometry.opening(position))

    @property
    def state(self) -> GraspState:
        """What it does now: it moves, has arrived, or holds something, how wide.

        Told from the last tenth of a second; the simulation does not wait for it.
        """
        return judge(self.geometry, self._bus.history())

    def wait(self, timeout: float | None = None) -> GraspState:
        """Wait until it no longer moves, and return what it does then.

        What is held with another force does not move: that takes no time here.

        Args:
            timeout: Longest wait [s]: of wall time if the simulation runs in real
                time, else of simulated time, which passes meanwhile.

        Raises:
            GoalTimeoutError: If it still moves then.
        """
        loop, bus = self._loop, self._bus
        limit = math.inf if timeout is None else timeout
        start, wall_start = loop.steps, time.monotonic()
        while (state := self.state).motion == "moving":
            loop.check()
            if loop.is_closed:
                raise ControlError("the simulation was closed")
            if loop.is_realtime:
                waited = time.monotonic() - wall_start
            else:
                waited = (loop.steps - start) * loop.control_period
            if not waited < limit:
                raise GoalTimeoutError(f"the gripper still moves after {timeout} s")
            if loop.is_realtime:
                bus.newer_than(bus.latest, min(_PATIENCE, limit - waited))
            else:
                # Less than half a tick would be none, and the wait without end.
                left = min(SNAPSHOT_PERIOD, limit - waited)
                loop.run(max(loop.control_period, left))
        return state

    def move(
        self,
        *,
        opening: float,
        speed: float | None = None,
        force: float | None = None,
        effort: float | None = None,
    ) -> GoalHandle:
        """Send the pads to ``opening`` and return the goal.

        Speed and force are settings of the drive, as on the real gripper: they hold
        until another goal moves its joint.

        Args:
            opening: Distance between the pads [m], 0 … ``geometry.max_opening``.
            speed: Of the pads towards each other [m/s], within ``geometry.speed``;
                the fastest, if left out.
            force: Largest force at each pad [N], within ``geometry.force``: with it
                something in the way is gripped.  The strongest, if left out.
            effort: Instead of a force the largest torque of the driven joint [N·m], as
                ``max_effort`` of ROS's GripperCommand.

        Raises:
            ModelError: If ``opening`` is out of reach.
            ControlError: If speed, force or effort are, or are no numbers, or no
                running controller takes the command; nothing has changed then.
        """
        _require_numbers(opening=opening, speed=speed, force=force, effort=effort)
        geometry, robot = self.geometry, self._robot
        target, joint = geometry.position(opening), geometry.joint
        speed = geometry.speed[1] if speed is None else speed
        bounds = DriveLimits(
            gripper=geometry,
            speed=speed,
            force=geometry.force[1] if force is None and effort is None else force,
            effort=effort,
        )
        for status in robot.controllers():
            claimed = {name for _, joints in status.claimed for name in joints}
            if status.state != "running" or joint not in claimed:
                continue
            controller = robot.controller(status.name)
            if status.type.endswith("/GripperActionController"):
                most = robot.joint_limits[joint].effort if force is not None else effort
                return controller.command_gripper(target, most, bounds=bounds)
            if status.type.endswith("/JointTrajectoryController"):
                points = self._plan(opening, speed)
                return controller.follow(
                    points, joint_names=[joint], bounds={joint: bounds}
                )
        raise ControlError(
            f"no running controller drives '{joint}'; start a JointTrajectory"
            "Controller or a GripperActionController that claims it"
        )

    def _plan(self, end: float, speed: float) -> list[TrajectoryPoint]:
        """Return the way to ``end`` [m], from where the pads are.

        What is squeezed is not let go of for a squeeze in the same direction.  For a
        way back it is let go of at once: the controller wants the pads inside of it,
        and would squeeze on, all that the new goal allows, until its way from there
        has come out again.
        """
        now = self.opening
        wanted = wanted_openings(self._robot.snapshot, self.geometry)
        ahead = 0.0 if wanted is None else wanted[0] - now
        if ahead * (end - now) > 0.0:
            start = end if abs(ahead) > abs(end - now) else now + ahead
            return opening_motion(self.geometry, start, end, speed)
        way = opening_motion(self.geometry, now, end, speed)
        if abs(ahead) <= SQUEEZED:
            return way
        at_once = self._robot.control_period
        here = self._robot.joint_state.position[self.geometry.joint]
        later = [
            replace(point, time_from_start=point.time_from_start + at_once)
            for point in way
        ]
        return [TrajectoryPoint([here], [0.0], time_from_start=at_once), *later]


def _require_numbers(*, opening: float, **settings: float | None) -> None:
    """Refuse texts and arrays here: the loop could only fail of them."""
    given = {what: value for what, value in settings.items() if value is not None}
    for what, value in {"opening": opening, **given}.items():
        if not isinstance(value, Real):
            raise ControlError(f"{what} must be one number, got {value!r}")
