"""An arm with a gripper that performs a task in steps."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, final

from tool0.api.grasps import Bin, Grasp
from tool0.cli.demos.monitor import GraspMonitor
from tool0.description.drive_limits import DriveLimits
from tool0.description.grasp_frames import grasp_frame
from tool0.description.transform import Transform, Vector3
from tool0.errors import (
    CollisionError,
    ConfigError,
    ModelError,
    PlanningError,
    Tool0Error,
)
from tool0.protocol.goals import GoalResult, GoalStatus
from tool0.protocol.planning import PlanTarget
from tool0.protocol.request import SLOWEST

if TYPE_CHECKING:
    from tool0.api.controller import GoalHandle
    from tool0.api.robot import Robot

MOTION_TIMEOUT = 20.0
"""Longest duration of a motion [simulated s]."""
SETTLE_TIMEOUT = 1.0
"""Longest time for an object in the bin to come to rest [simulated s]."""
RELEASE = 0.04
"""Difference between the gripper's opening and the width of a released object [m]."""


@final
class TaskFailure(Exception):  # noqa: N818  # of the task, not of a program
    """Failure of a task; the report contains the message as the reason."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class PickOptions:
    """Parameters of a pick."""

    force: float = 60.0
    """Gripping force at each pad [N]."""
    speed: float = 0.7
    """Speed of the joints between two poses, as a fraction of the maximum."""
    linear_speed: float = 0.25
    """Speed of the tool on the straight lines downward and upward [m/s]."""
    pad_speed: float = 0.15
    """Closing speed of the pads relative to each other [m/s]."""
    lift: float = 0.15
    """Height at which the object is carried, above the pick and place positions [m]."""

    def __post_init__(self) -> None:
        if not SLOWEST <= self.speed <= 1.0:
            raise ConfigError(f"speed must be in [{SLOWEST}, 1], got {self.speed}")


@final
class Hand:
    """An arm with a gripper; a failed step raises TaskFailure."""

    def __init__(
        self,
        robot: Robot,
        options: PickOptions,
        monitor: GraspMonitor,
        name: str | None = None,
    ) -> None:
        """Select the arm and gripper ``name``, or the robot's only arm and gripper.

        Raises:
            ControlError: If the arm or the gripper does not exist, or if the gripper
                does not support the force or the speed.
        """
        self.arm = robot.arm if name is None else robot.arms[name]
        self.gripper = robot.gripper if name is None else robot.grippers[name]
        self._model = robot.description.model
        self._robot = robot
        self._home = self.arm.joints
        self.options = options
        self._monitor = monitor
        DriveLimits(
            gripper=self.gripper.geometry,
            speed=options.pad_speed,
            force=options.force,
        )

    def open(self, width: float | None = None) -> GoalHandle:
        """Open the pads fully, or far enough to release an object of ``width`` [m]."""
        widest = self.gripper.geometry.max_opening
        return self.gripper.move(
            opening=widest if width is None else min(widest, width + RELEASE)
        )

    def grip(self) -> None:
        """Close the pads until they hold an object."""
        options = self.options
        self.gripper.move(opening=0.0, speed=options.pad_speed, force=options.force)
        self._monitor.until(
            lambda: self.gripper.state.motion != "moving", MOTION_TIMEOUT
        )
        self.check_hold()

    def check_hold(self) -> None:
        """Raise TaskFailure if the gripper does not hold an object."""
        state = self.gripper.state
        if state.motion != "holding_inside":
            raise TaskFailure(
                f"the gripper holds nothing: {state.motion}, "
                f"open {1000 * state.opening:.1f} mm"
            )

    def move_to(self, pose: Transform, tool: Transform) -> None:
        """Move ``tool``, a frame fixed to the flange, to a pose in the root frame.

        If the direct path is blocked, the tool moves around the obstacles.
        """
        self.finish(self._or_around(lambda: self.start(pose, tool), pose, tool))

    def start(self, pose: Transform, tool: Transform) -> GoalHandle:
        """Start to move ``tool``, a frame fixed to the flange, to a pose."""
        return self.arm.move_to(pose, tool=tool, speed=self.options.speed)

    def go_around(
        self, grasps: Sequence[Grasp], others: Sequence[PlanTarget] = ()
    ) -> Grasp:
        """Move around obstacles to one of the grasps, and return this grasp.

        The selected grasp is the reachable grasp with the smallest motion of the
        joints.  The ``others`` are the targets of arms that move at the same time.
        """
        refused: Tool0Error | None = None
        for grasp in self._by_distance(grasps):
            target = self.arm.target(grasp.pose, tool=self.tool_for(grasp.width))
            try:
                plan = self._robot.plan([target, *others], speed=self.options.speed)
            except (CollisionError, PlanningError) as error:
                refused = refused or error
                continue
            for goal in self._robot.execute(plan):
                self.finish(goal)
            return grasp
        raise TaskFailure(f"there is no way: {refused}")

    def move_linear(self, pose: Transform, tool: Transform) -> None:
        """Move ``tool`` to a pose along a straight line, or around obstacles."""

        def start() -> GoalHandle:
            speed = self.options.linear_speed
            return self.arm.move_linear(pose, tool=tool, speed=speed)

        self.finish(self._or_around(start, pose, tool))

    def _or_around(
        self, start: Callable[[], GoalHandle], pose: Transform, tool: Transform
    ) -> GoalHandle:
        """Start a motion; if it would collide, move around obstacles instead."""
        try:
            return start()
        except CollisionError as refused:
            try:
                plan = self.arm.plan(pose, tool=tool, speed=self.options.speed)
            except (CollisionError, PlanningError):
                raise refused from None
            return self.arm.execute(plan)

    def move_home(self) -> None:
        """Move the joints back to their initial positions."""
        for goal in self._robot.move_joints(self._home, speed=self.options.speed):
            self.finish(goal)

    def finish(self, goal: GoalHandle) -> None:
        """Wait until a goal has succeeded."""
        if not self._monitor.until(lambda: goal.result is not None, MOTION_TIMEOUT):
            goal.cancel()
            raise TaskFailure(f"the motion is not done after {MOTION_TIMEOUT:g} s")
        result = goal.result
        if result is not None and result.status is not GoalStatus.SUCCEEDED:
            why = f": {result.error_string}" if isinstance(result, GoalResult) else ""
            raise TaskFailure(f"the goal was {result.status.name}{why}")

    def put(self, into: Bin, grasps: Sequence[Grasp], height: float) -> None:
        """Carry the object to a bin, release it, and retreat.

        Args:
            into: The bin.
            grasps: Grasps with the orientations that are allowed at the release; the
                positions of the grasps are ignored.
            height: Height of the middle of the pads above the bin's floor [m].
        """
        self._monitor.begin("carrying")
        x, y, bottom = into.center
        place = self.nearest((x, y, bottom + height + self.options.lift), grasps)
        self.move_to(place.pose, self.tool_for(place.width))
        self.release(into, place, height)

    def release(self, into: Bin, place: Grasp, height: float) -> None:
        """Lower the object from ``place`` into a bin, release it, and retreat.

        For ``height``, see ``put``.
        """
        monitor, tool, above = self._monitor, self.tool_for(place.width), place.pose
        x, y, bottom = into.center
        self.check_hold()
        monitor.begin("lowering")
        self.move_linear(replace(above, position=(x, y, bottom + height)), tool)
        self.check_hold()
        monitor.begin("letting go")
        monitor.stop_slip()
        self.finish(self.open(place.width))
        monitor.begin("leaving")
        self.move_linear(above, tool)
        if not monitor.until(lambda: into.holds(monitor.pose()), SETTLE_TIMEOUT):
            x, y, z = monitor.pose().position
            raise TaskFailure(f"it is at ({x:.3f}, {y:.3f}, {z:.3f}), not in the bin")

    def nearest(self, position: Vector3, grasps: Sequence[Grasp]) -> Grasp:
        """Return the grasp that needs the least motion when shifted to ``position``."""
        moved = [
            replace(grasp, pose=replace(grasp.pose, position=position))
            for grasp in grasps
        ]
        return self._by_distance(moved)[0]

    def _by_distance(self, grasps: Sequence[Grasp]) -> list[Grasp]:
        """Return the reachable grasps, sorted by the distance that the joints move."""
        found: list[tuple[float, Grasp]] = []
        refused: Tool0Error | None = None
        for grasp in grasps:
            tool = self.tool_for(grasp.width)
            try:
                solutions = self.arm.inverse_kinematics(grasp.pose, tool=tool)
            except ModelError as error:
                refused = error
                continue
            found.append((solutions[0].distance, grasp))
        if not found:
            raise TaskFailure(f"it cannot be reached: {refused}")
        return [grasp for _, grasp in sorted(found, key=lambda each: each[0])]

    def tool_for(self, width: float) -> Transform:
        """Return the frame between the pads at an opening [m], in the flange frame."""
        return grasp_frame(self._model, self.gripper.geometry, width, self.arm.tip)
