"""Pick an object from above and place it in a bin."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, final

from tool0.control.goal import GoalStatus
from tool0.demo.bin import Bin
from tool0.demo.grips import CLEARANCE, Grip, grips, half_height, reach_below
from tool0.demo.report import PickReport
from tool0.demo.witness import Witness
from tool0.description.kinematics import Transform
from tool0.errors import ControlError, ModelError, Tool0Error
from tool0.runtime.bus import Snapshot
from tool0.runtime.pads import grasp_frame

if TYPE_CHECKING:
    from tool0.runtime.handles import GoalHandle
    from tool0.runtime.robot import Robot

LIFT = 0.15
"""How high above where it was taken and where it is placed an object is carried [m]."""
DROP = 0.015
"""Above the floor of the bin at which it is let go [m]."""
PATIENCE = 20.0
"""Longest duration of a motion, simulated [s]."""
REST = 1.0
"""How long an object in the bin may take to come to rest [s]."""


class _Failure(Exception):  # noqa: N818
    """Why a pick ends; never seen outside."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class PickOptions:
    """How a pick is done."""

    force: float = 60.0
    """At each pad [N]."""
    speed: float = 0.7
    """Of joints between two poses, part of the fastest."""
    linear_speed: float = 0.25
    """On the straight ways down and up [m/s]."""
    pad_speed: float = 0.15
    """Of the pads towards each other [m/s]."""


def pick_and_place(
    robot: Robot,
    item: str,
    into: Bin,
    options: PickOptions | None = None,
    on_snapshot: Callable[[Snapshot], None] = lambda snapshot: None,
) -> PickReport:
    """Take an object from above and let it go in a bin; report how it went.

    Nothing of the task is known to the physics: the object is held by friction alone
    (unless the robot has grasp assist).

    Args:
        robot: With one arm that has analytic inverse kinematics, and one gripper.
        item: The name of an upright box, cylinder or sphere that can move.
        into: Where it goes.
        options: How.
        on_snapshot: Called with each snapshot meanwhile, for who records them.

    Raises:
        ControlError: If there is no such object, or it cannot be gripped at all.
    """
    witness = Witness(robot, robot.gripper, item, on_snapshot)
    task = _Pick(robot, item, into, options or PickOptions(), witness)
    try:
        return task.run()
    finally:
        witness.close()


@final
class _Pick:
    def __init__(
        self, robot: Robot, item: str, into: Bin, options: PickOptions, witness: Witness
    ) -> None:
        self._robot = robot
        self._item = robot.scene[item]
        self._into = into
        self._options = options
        self._witness = witness
        self._width: float | None = None
        self._start = witness.pose()
        self._begun = robot.time
        largest = robot.gripper.geometry.max_opening
        self._grips = grips(self._item, self._start, largest)
        self._depth = reach_below(robot.description.model, robot.gripper.geometry)

    def run(self) -> PickReport:
        failure = None
        try:
            self._steps()
        except (_Failure, ControlError, ModelError) as error:
            failure = f"while {self._witness.phase}: {error}"
        self._witness.begin("")
        return PickReport(
            success=failure is None,
            failure=failure,
            item=self._item.name,
            start=self._start.position,
            end=self._witness.pose().position,
            force=self._options.force,
            peak_force=self._witness.peak_force,
            width=self._width,
            slip=self._witness.slip,
            duration=self._robot.time - self._begun,
            phases=self._witness.phases,
        )

    def _steps(self) -> None:
        robot, witness, options = self._robot, self._witness, self._options
        gripper, arm = robot.gripper, robot.arm
        widest = gripper.geometry.max_opening
        grip = self._nearest(self._grips)
        tool = self._tool(grip.width)
        x, y, z = self._start.position
        floor = z - half_height(self._item, self._start)
        height = max(z, floor + self._depth + CLEARANCE)
        take = replace(grip.pose, position=(x, y, height))

        witness.begin("approaching")
        opening = gripper.move(opening=widest)
        self._finish(arm.move_to(_above(take), tool=tool, speed=options.speed))
        self._finish(opening)
        witness.begin("going down")
        self._finish(arm.move_linear(take, tool=tool, speed=options.linear_speed))
        witness.begin("gripping")
        gripper.move(opening=0.0, speed=options.pad_speed, force=options.force)
        witness.until(lambda: gripper.state.motion != "moving", PATIENCE)
        self._check_hold()
        self._width = gripper.state.width
        witness.hold()
        witness.begin("lifting")
        self._finish(
            arm.move_linear(_above(take), tool=tool, speed=options.linear_speed)
        )
        self._check_hold()

        witness.begin("carrying")
        x, y, bottom = self._into.center
        target = (x, y, bottom + height - floor + DROP)
        ways = [replace(item.pose, position=target) for item in self._grips]
        place = self._nearest([Grip(_above(way), grip.width) for way in ways]).pose
        self._finish(arm.move_to(place, tool=tool, speed=options.speed))
        self._check_hold()
        witness.begin("lowering")
        down = replace(place, position=target)
        self._finish(arm.move_linear(down, tool=tool, speed=options.linear_speed))
        self._check_hold()
        witness.begin("letting go")
        witness.release()
        self._finish(gripper.move(opening=widest))
        witness.begin("leaving")
        self._finish(arm.move_linear(place, tool=tool, speed=options.linear_speed))
        if not witness.until(lambda: self._into.holds(witness.pose()), REST):
            x, y, z = witness.pose().position
            raise _Failure(f"it is at ({x:.3f}, {y:.3f}, {z:.3f}), not in the bin")

    def _nearest(self, ways: Sequence[Grip]) -> Grip:
        """Return the way that the arm reaches with the least turning of its joints."""
        best: tuple[float, Grip] | None = None
        refused: Tool0Error | None = None
        for way in ways:
            try:
                solutions = self._robot.arm.inverse_kinematics(
                    _above(way.pose), tool=self._tool(way.width)
                )
            except ModelError as error:
                refused = error
                continue
            if best is None or solutions[0].distance < best[0]:
                best = solutions[0].distance, way
        if best is None:
            raise _Failure(f"no way to take it is within reach: {refused}")
        return best[1]

    def _tool(self, width: float) -> Transform:
        robot = self._robot
        return grasp_frame(
            robot.description.model, robot.gripper.geometry, width, robot.arm.tip
        )

    def _finish(self, goal: GoalHandle) -> None:
        """Let time pass until a goal has succeeded."""
        if not self._witness.until(lambda: goal.result is not None, PATIENCE):
            goal.cancel()
            raise _Failure(f"the motion is not done after {PATIENCE:g} s")
        result = goal.result
        if result is not None and result.status is not GoalStatus.SUCCEEDED:
            raise _Failure(f"the goal was {result.status.name}")

    def _check_hold(self) -> None:
        state = self._robot.gripper.state
        if state.motion != "holding_inside":
            raise _Failure(
                f"the gripper holds nothing: {state.motion}, "
                f"open {1000 * state.opening:.1f} mm"
            )


def _above(pose: Transform) -> Transform:
    x, y, z = pose.position
    return replace(pose, position=(x, y, z + LIFT))
