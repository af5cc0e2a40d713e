"""Pick an object from above and place it in a bin."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, final

from tool0.cli.pick_demo.grasps import (
    CLEARANCE,
    Bin,
    Grasp,
    find_grasps,
    finger_reach,
    half_height,
)
from tool0.cli.pick_demo.monitor import GraspMonitor
from tool0.control.goal import GoalStatus
from tool0.description.transform import Transform, Vector3
from tool0.errors import ControlError, ModelError, Tool0Error
from tool0.hardware.limits import DriveLimits
from tool0.runtime.joint_motion import require_speed
from tool0.sensing.grasp import grasp_frame
from tool0.sensing.snapshot import Snapshot

if TYPE_CHECKING:
    from tool0.api.controller import GoalHandle
    from tool0.api.robot import Robot

LIFT = 0.15
"""Height at which an object is carried, above its pick and its place position [m]."""
DROP = 0.015
"""Height above the floor of the bin at which it is released [m]."""
MOTION_TIMEOUT = 20.0
"""Longest duration of a motion, simulated [s]."""
SETTLE_TIMEOUT = 1.0
"""Longest time for an object in the bin to come to rest [s]."""


@final
class PickFailure(Exception):  # noqa: N818  # of the task, not of a program
    """Why a pick ended early.  It ends up in the report."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class PickOptions:
    """The parameters of a pick."""

    force: float = 60.0
    """At each pad [N]."""
    speed: float = 0.7
    """Of joints between two poses, part of the fastest."""
    linear_speed: float = 0.25
    """On the straight lines down and up [m/s]."""
    pad_speed: float = 0.15
    """Of the pads towards each other [m/s]."""

    def __post_init__(self) -> None:
        require_speed(self.speed)


@final
class Picker:
    """Does one pick with a robot that has one arm and one gripper."""

    def __init__(
        self, robot: Robot, item: str, options: PickOptions, monitor: GraspMonitor
    ) -> None:
        """Find the grasps of the object where it is now.

        Args:
            robot: The robot.
            item: An upright box, cylinder or sphere.
            options: Force and speeds.
            monitor: Advances time, and measures.

        Raises:
            ControlError: If there is no such object, it cannot be gripped at all, or
                the gripper has no such force or speed.
        """
        geometry = robot.gripper.geometry
        DriveLimits(gripper=geometry, speed=options.pad_speed, force=options.force)
        self._robot = robot
        self._options = options
        self._monitor = monitor
        thing, pose = robot.scene[item], monitor.pose()
        self._grasps = find_grasps(thing, pose, geometry.max_opening)
        self._floor = pose.position[2] - half_height(thing, pose)
        reach = finger_reach(robot.description.model, geometry)
        top = 2.0 * pose.position[2] - self._floor
        # Lower, the fingers would touch the table, or the knuckles a tall object.
        self._height = max(
            pose.position[2], top - reach, self._floor + reach + CLEARANCE
        )
        """Of the middle of the pads, when they take it [m]."""
        self._tool = Transform()
        self.width: float | None = None
        """Width of the gripped object, from the gripper's joint [m]."""
        self.force: float | None = None
        """That a pad exerts on it when it is lifted [N]."""

    def take(self, lift: float = LIFT) -> None:
        """Go there, grip it, and lift it by ``lift`` [m], or raise PickFailure."""
        robot, monitor, options = self._robot, self._monitor, self._options
        gripper, arm = robot.gripper, robot.arm
        x, y, _ = self._grasps[0].pose.position
        grasp = self._nearest((x, y, self._height + lift), self._grasps)
        self._tool = tool = self._tool_for(grasp.width)
        above = grasp.pose
        down = replace(above, position=(x, y, self._height))

        monitor.begin("approaching")
        opening = gripper.move(opening=gripper.geometry.max_opening)
        self._finish(arm.move_to(above, tool=tool, speed=options.speed))
        self._finish(opening)
        monitor.begin("going down")
        self._finish(arm.move_linear(down, tool=tool, speed=options.linear_speed))
        monitor.begin("gripping")
        gripper.move(opening=0.0, speed=options.pad_speed, force=options.force)
        monitor.until(lambda: gripper.state.motion != "moving", MOTION_TIMEOUT)
        self.check_hold()
        self.width, self.force = gripper.state.width, monitor.pad_force()
        monitor.start_slip()
        monitor.begin("lifting")
        self._finish(arm.move_linear(above, tool=tool, speed=options.linear_speed))
        self.check_hold()

    def put(self, into: Bin) -> None:
        """Carry the object to a bin and release it, or raise PickFailure."""
        robot, monitor, options = self._robot, self._monitor, self._options
        gripper, arm, tool = robot.gripper, robot.arm, self._tool

        monitor.begin("carrying")
        x, y, bottom = into.center
        height = bottom + self._height - self._floor + DROP
        above = self._nearest((x, y, height + LIFT), self._grasps).pose
        down = replace(above, position=(x, y, height))
        self._finish(arm.move_to(above, tool=tool, speed=options.speed))
        self.check_hold()
        monitor.begin("lowering")
        self._finish(arm.move_linear(down, tool=tool, speed=options.linear_speed))
        self.check_hold()
        monitor.begin("letting go")
        monitor.stop_slip()
        self._finish(gripper.move(opening=gripper.geometry.max_opening))
        monitor.begin("leaving")
        self._finish(arm.move_linear(above, tool=tool, speed=options.linear_speed))
        if not monitor.until(lambda: into.holds(monitor.pose()), SETTLE_TIMEOUT):
            x, y, z = monitor.pose().position
            raise PickFailure(f"it is at ({x:.3f}, {y:.3f}, {z:.3f}), not in the bin")

    def check_hold(self) -> None:
        """Raise PickFailure unless the gripper holds something."""
        state = self._robot.gripper.state
        if state.motion != "holding_inside":
            raise PickFailure(
                f"the gripper holds nothing: {state.motion}, "
                f"open {1000 * state.opening:.1f} mm"
            )

    def _nearest(self, position: Vector3, grasps: Sequence[Grasp]) -> Grasp:
        """Return the grasp, moved to ``position``, that moves the joints least."""
        best: tuple[float, Grasp] | None = None
        refused: Tool0Error | None = None
        for grasp in grasps:
            pose = replace(grasp.pose, position=position)
            try:
                solutions = self._robot.arm.inverse_kinematics(
                    pose, tool=self._tool_for(grasp.width)
                )
            except ModelError as error:
                refused = error
                continue
            if best is None or solutions[0].distance < best[0]:
                best = solutions[0].distance, replace(grasp, pose=pose)
        if best is None:
            raise PickFailure(f"it cannot be reached from above: {refused}")
        return best[1]

    def _tool_for(self, width: float) -> Transform:
        robot = self._robot
        return grasp_frame(
            robot.description.model, robot.gripper.geometry, width, robot.arm.tip
        )

    def _finish(self, goal: GoalHandle) -> None:
        """Wait until a goal has succeeded, or raise PickFailure."""
        if not self._monitor.until(lambda: goal.result is not None, MOTION_TIMEOUT):
            goal.cancel()
            raise PickFailure(f"the motion is not done after {MOTION_TIMEOUT:g} s")
        result = goal.result
        if result is not None and result.status is not GoalStatus.SUCCEEDED:
            raise PickFailure(f"the goal was {result.status.name}")


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class PickReport:
    """One pick and place.  Values that were never reached are None."""

    success: bool
    """Whether the object is in the bin."""
    failure: str | None = None
    """In which phase it failed, and why."""
    item: str
    """The object."""
    start: tuple[float, float, float]
    """Start position of the object, in the root [m]."""
    end: tuple[float, float, float] | None
    """Final position [m]; None if it was removed."""
    force: float
    """Requested force at each pad [N]."""
    grip_force: float | None = None
    """Force of a pad when the object was lifted [N]."""
    peak_force: float
    """The largest that a pad exerted, of samples at 125 Hz: pads that meet a rigid
    object must also stop the rotor of their drive [N]."""
    width: float | None = None
    """Width of the held object, from the gripper's joint [m]."""
    slip: float | None = None
    """Largest slip between the pads while it was held [m]."""
    duration: float
    """Simulated [s]."""
    phases: Mapping[str, float] = field(default_factory=dict)
    """Phase → its duration, simulated [s]."""

    def to_text(self) -> str:
        """Return it as a line for people."""
        x, y, _ = self.start
        what = f"'{self.item}' from ({x:.3f}, {y:.3f})"
        if not self.success:
            return f"{what}: FAILED {self.failure}"
        words = [f"{what}: in the bin after {self.duration:.1f} s"]
        if self.width is not None:
            words.append(f"{1e3 * self.width:.1f} mm wide")
        if self.slip is not None:
            words.append(f"slip {1e3 * self.slip:.2f} mm")
        if self.grip_force is not None:
            words.append(f"gripped with {self.grip_force:.0f} N")
        words.append(f"peak {self.peak_force:.0f} N")
        return ", ".join(words)


def pick_and_place(
    robot: Robot,
    item: str,
    into: Bin,
    options: PickOptions | None = None,
    on_snapshot: Callable[[Snapshot], None] = lambda snapshot: None,
) -> PickReport:
    """Pick an object from above, place it in a bin, and report what was measured.

    The object is held by friction alone, unless the robot has grasp assist.

    Args:
        robot: With one arm that has analytic inverse kinematics, and one gripper.
        item: The name of an upright box, cylinder or sphere that can move.
        into: Where it goes.
        options: Force and speeds.
        on_snapshot: Called with each snapshot, for recording.

    Raises:
        ControlError: If there is no such object, or it cannot be gripped at all.
        EngineError: If the physics fails.
    """
    options = options or PickOptions()
    monitor = GraspMonitor(robot, item, on_snapshot)
    try:
        picker = Picker(robot, item, options, monitor)
        start, begun, failure = monitor.pose().position, robot.time, None
        try:
            picker.take()
            picker.put(into)
        except (PickFailure, ControlError, ModelError) as error:
            failure = f"while {monitor.phase}: {error}"
        monitor.begin("")
        return PickReport(
            success=failure is None,
            failure=failure,
            item=item,
            start=start,
            end=monitor.pose().position if item in robot.scene else None,
            force=options.force,
            grip_force=picker.force,
            peak_force=monitor.peak_force,
            width=picker.width,
            slip=monitor.slip,
            duration=robot.time - begun,
            phases=monitor.phases,
        )
    finally:
        monitor.close()
