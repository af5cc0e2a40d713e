"""The gripper as a person thinks of it: by its opening."""

from __future__ import annotations

import math
import time
from numbers import Real
from typing import TYPE_CHECKING, final

from tool0.description.model import ParallelGripper
from tool0.errors import ControlError, GoalTimeoutError
from tool0.hardware.drive_bounds import DriveBounds
from tool0.runtime.bus import SNAPSHOT_PERIOD
from tool0.runtime.grasp import GraspState, judge, wanted_openings
from tool0.runtime.gripper_motion import opening_motion

if TYPE_CHECKING:
    from tool0.runtime.bus import Bus
    from tool0.runtime.handles import GoalHandle
    from tool0.runtime.loop import Loop
    from tool0.runtime.robot import Robot

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
        bounds = DriveBounds(
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
                points = opening_motion(geometry, self._start(opening), opening, speed)
                return controller.follow(
                    points, joint_names=[joint], bounds={joint: bounds}
                )
        raise ControlError(
            f"no running controller drives '{joint}'; start a JointTrajectory"
            "Controller or a GripperActionController that claims it"
        )

    def _start(self, end: float) -> float:
        """Return from which opening [m] a motion to ``end`` begins.

        Where it is; but what is squeezed is not let go of for a squeeze in the same
        direction.
        """
        now = self.opening
        wanted = wanted_openings(self._robot.snapshot, self.geometry)
        ahead = 0.0 if wanted is None else wanted[0] - now
        if ahead * (end - now) <= 0.0:
            return now
        return end if abs(ahead) > abs(end - now) else now + ahead


def _require_numbers(*, opening: float, **settings: float | None) -> None:
    """Refuse texts and arrays here: the loop could only fail of them."""
    given = {what: value for what, value in settings.items() if value is not None}
    for what, value in {"opening": opening, **given}.items():
        if not isinstance(value, Real):
            raise ControlError(f"{what} must be one number, got {value!r}")
