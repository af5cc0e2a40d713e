"""The gripper as a person thinks of it: by its opening."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, final

from tool0.control.trajectory import TrajectoryPoint
from tool0.description.model import ParallelGripper
from tool0.errors import ControlError

if TYPE_CHECKING:
    from tool0.runtime.handles import GoalHandle
    from tool0.runtime.robot import Robot

RAMP = 0.005
"""Way over which the pads speed up and slow down, each [m]: a guess, no datasheet
tells; it keeps the fingers from overshooting at full speed."""
SPACING = 0.005
"""Way between the points of a planned motion [m]."""


@final
class Gripper:
    """Moves one parallel gripper through whichever controller claims its joint."""

    def __init__(self, geometry: ParallelGripper, robot: Robot) -> None:
        self.geometry = geometry
        self._robot = robot

    @property
    def opening(self) -> float:
        """Distance between the pads [m], 0 closed."""
        position = self._robot.joint_state.position[self.geometry.joint]
        return max(0.0, self.geometry.opening(position))

    def move(
        self,
        *,
        opening: float,
        speed: float | None = None,
        effort: float | None = None,
        force: float | None = None,
    ) -> GoalHandle:
        """Send the pads to ``opening`` and return the goal.

        Args:
            opening: Distance between the pads [m], 0 … ``geometry.max_opening``.
            speed: Of the pads towards each other [m/s], within ``geometry.speed``;
                the fastest, if left out.  Needs a trajectory controller: a gripper
                action knows no speed.
            effort: Largest torque of the driven joint [N·m], as ``max_effort`` of
                ROS's GripperCommand; what the drive can do, if left out.
            force: Largest force at each pad [N], within ``geometry.force``, instead of
                ``effort``.  It is what something of the width ``opening`` is gripped
                with; the linkage's lever is shorter at wider openings, so something
                wider is gripped harder: between the pads of a 2F-85 that are sent to
                0, by 3 % at 40 mm and 31 % at 85 mm.

        Raises:
            ModelError: If ``opening`` is out of reach.
            ControlError: If no running controller takes the command.
        """
        target = self.geometry.position(opening)
        if force is not None:
            effort = self._torque(force, target, effort)
        joint = self.geometry.joint
        for status in self._robot.controllers():
            claimed = {name for _, joints in status.claimed for name in joints}
            if status.state != "running" or joint not in claimed:
                continue
            controller = self._robot.controller(status.name)
            if status.type.endswith("/GripperActionController"):
                if speed is not None:
                    raise ControlError(
                        f"'{status.name}' is a {status.type}, which knows no speed; "
                        "use a JointTrajectoryController, or leave speed out"
                    )
                return controller.command_gripper(target, effort)
            if status.type.endswith("/JointTrajectoryController"):
                points = self._plan(opening, self._speed(speed))
                _check_effort(effort)
                goal = controller.follow(points, joint_names=[joint])
                self._robot.cap_effort(joint, effort)  # not for a goal that is refused
                return goal
        raise ControlError(
            f"no running controller drives '{joint}'; start a JointTrajectory"
            "Controller or a GripperActionController that claims it"
        )

    def _torque(self, force: float, position: float, effort: float | None) -> float:
        """Return what the joint needs [N·m] for ``force`` [N] where it is to go."""
        if effort is not None:
            raise ControlError(
                f"give a force ({force} N) or an effort ({effort} N·m), not both"
            )
        weakest, strongest = self.geometry.force
        if not weakest <= force <= strongest:
            raise ControlError(f"force {force} N is outside [{weakest}, {strongest}] N")
        return force * self.geometry.lever(position)

    def _speed(self, speed: float | None) -> float:
        slowest, fastest = self.geometry.speed
        if speed is None:
            return fastest
        if not slowest <= speed <= fastest:
            raise ControlError(
                f"speed {speed} m/s is outside [{slowest}, {fastest}] m/s"
            )
        return speed

    def _plan(self, opening: float, speed: float) -> list[TrajectoryPoint]:
        """Return points along which the pads ramp up, cruise and ramp down.

        The linkage turns a steady opening into an unsteady angle, so points lie close.
        """
        widest = self.geometry.max_opening
        start = min(self.opening, widest)
        way = opening - start
        ramp = min(RAMP, abs(way) / 2.0)
        speed *= math.sqrt(ramp / RAMP)  # a short way ends before full speed
        n_points = max(2, math.ceil(abs(way) / SPACING))
        points = []
        for k in range(1, n_points + 1):
            done = abs(way) * k / n_points
            at, rate = _ramped(done, abs(way), ramp, speed)
            reached = start + math.copysign(done, way)
            q = self.geometry.position(min(max(0.0, reached), widest))  # rounding
            qd = -math.copysign(rate, way) / self.geometry.lever(q)
            points.append(TrajectoryPoint([q], [qd], time_from_start=max(at, 1e-3 * k)))
        return points


def _check_effort(effort: float | None) -> None:
    if effort is not None and not 0.0 < effort < math.inf:
        raise ControlError(f"effort must be above 0 and finite, got {effort}")


def _ramped(done: float, way: float, ramp: float, speed: float) -> tuple[float, float]:
    """Return when [s] ``done`` of ``way`` [m] is behind, and how fast then [m/s].

    Constant acceleration over ``ramp`` at both ends, reaching ``speed`` between.
    """
    if ramp <= 0.0:
        return 0.0, 0.0
    ramp_time = 2.0 * ramp / speed
    if done < ramp:
        return ramp_time * math.sqrt(done / ramp), speed * math.sqrt(done / ramp)
    cruise_time = ramp_time + (min(done, way - ramp) - ramp) / speed
    left = way - done
    if left >= ramp:
        return cruise_time, speed
    slow = math.sqrt(max(0.0, left / ramp))
    return cruise_time + ramp_time * (1.0 - slow), speed * slow
