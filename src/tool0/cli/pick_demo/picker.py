"""Takes an object from above, and puts it into a bin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, final

from tool0.cli.pick_demo.bin import Bin
from tool0.cli.pick_demo.grips import CLEARANCE, Grip, grips, half_height, reach_below
from tool0.cli.pick_demo.witness import Witness
from tool0.control.goal import GoalStatus
from tool0.description.kinematics import Transform
from tool0.description.model import Vector3
from tool0.errors import ModelError, Tool0Error
from tool0.hardware.drive_limits import DriveLimits
from tool0.runtime.joint_motion import require_speed
from tool0.sensing.pads import grasp_frame

if TYPE_CHECKING:
    from tool0.api.controller import GoalHandle
    from tool0.api.robot import Robot

LIFT = 0.15
"""How high above where it was taken and where it is placed an object is carried [m]."""
DROP = 0.015
"""Above the floor of the bin at which it is let go [m]."""
PATIENCE = 20.0
"""Longest duration of a motion, simulated [s]."""
REST = 1.0
"""How long an object in the bin may take to come to rest [s]."""


@final
class PickFailure(Exception):  # noqa: N818  # of the task, not of a program
    """Why a pick ended early.  It is reported, and goes no further."""


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

    def __post_init__(self) -> None:
        require_speed(self.speed)


@final
class Picker:
    """Does one pick with a robot that has one arm and one gripper."""

    def __init__(
        self, robot: Robot, item: str, options: PickOptions, witness: Witness
    ) -> None:
        """Look at where the object is now.

        Args:
            robot: Who picks.
            item: An upright box, cylinder or sphere.
            options: How.
            witness: Lets time pass, and measures.

        Raises:
            ControlError: If there is no such object, it cannot be gripped at all, or
                the gripper has no such force or speed.
        """
        geometry = robot.gripper.geometry
        DriveLimits(gripper=geometry, speed=options.pad_speed, force=options.force)
        self._robot = robot
        self._options = options
        self._witness = witness
        thing, pose = robot.scene[item], witness.pose()
        self._ways = grips(thing, pose, geometry.max_opening)
        self._floor = pose.position[2] - half_height(thing, pose)
        reach = reach_below(robot.description.model, geometry)
        top = 2.0 * pose.position[2] - self._floor
        # Farther down the fingers would meet the table, or what is high their knuckles.
        self._height = max(
            pose.position[2], top - reach, self._floor + reach + CLEARANCE
        )
        """Of the middle of the pads, when they take it [m]."""
        self._tool = Transform()
        self.width: float | None = None
        """Of what was gripped, as the gripper's joint tells [m]."""
        self.force: float | None = None
        """That a pad exerts on it when it is lifted [N]."""

    def take(self, lift: float = LIFT) -> None:
        """Go there, grip it, and lift it by ``lift`` [m], or raise PickFailure."""
        robot, witness, options = self._robot, self._witness, self._options
        gripper, arm = robot.gripper, robot.arm
        x, y, _ = self._ways[0].pose.position
        way = self._nearest((x, y, self._height + lift), self._ways)
        self._tool = tool = self._tool_for(way.width)
        above = way.pose
        down = replace(above, position=(x, y, self._height))

        witness.begin("approaching")
        opening = gripper.move(opening=gripper.geometry.max_opening)
        self._finish(arm.move_to(above, tool=tool, speed=options.speed))
        self._finish(opening)
        witness.begin("going down")
        self._finish(arm.move_linear(down, tool=tool, speed=options.linear_speed))
        witness.begin("gripping")
        gripper.move(opening=0.0, speed=options.pad_speed, force=options.force)
        witness.until(lambda: gripper.state.motion != "moving", PATIENCE)
        self.check_hold()
        self.width, self.force = gripper.state.width, witness.pressing()
        witness.hold()
        witness.begin("lifting")
        self._finish(arm.move_linear(above, tool=tool, speed=options.linear_speed))
        self.check_hold()

    def put(self, into: Bin) -> None:
        """Carry what was taken to a bin, and let it go, or raise PickFailure."""
        robot, witness, options = self._robot, self._witness, self._options
        gripper, arm, tool = robot.gripper, robot.arm, self._tool

        witness.begin("carrying")
        x, y, bottom = into.center
        height = bottom + self._height - self._floor + DROP
        above = self._nearest((x, y, height + LIFT), self._ways).pose
        down = replace(above, position=(x, y, height))
        self._finish(arm.move_to(above, tool=tool, speed=options.speed))
        self.check_hold()
        witness.begin("lowering")
        self._finish(arm.move_linear(down, tool=tool, speed=options.linear_speed))
        self.check_hold()
        witness.begin("letting go")
        witness.release()
        self._finish(gripper.move(opening=gripper.geometry.max_opening))
        witness.begin("leaving")
        self._finish(arm.move_linear(above, tool=tool, speed=options.linear_speed))
        if not witness.until(lambda: into.holds(witness.pose()), REST):
            x, y, z = witness.pose().position
            raise PickFailure(f"it is at ({x:.3f}, {y:.3f}, {z:.3f}), not in the bin")

    def check_hold(self) -> None:
        """Raise PickFailure unless the gripper holds something."""
        state = self._robot.gripper.state
        if state.motion != "holding_inside":
            raise PickFailure(
                f"the gripper holds nothing: {state.motion}, "
                f"open {1000 * state.opening:.1f} mm"
            )

    def _nearest(self, position: Vector3, ways: Sequence[Grip]) -> Grip:
        """Return the way, moved there, that turns the arm's joints least."""
        best: tuple[float, Grip] | None = None
        refused: Tool0Error | None = None
        for way in ways:
            pose = replace(way.pose, position=position)
            try:
                solutions = self._robot.arm.inverse_kinematics(
                    pose, tool=self._tool_for(way.width)
                )
            except ModelError as error:
                refused = error
                continue
            if best is None or solutions[0].distance < best[0]:
                best = solutions[0].distance, replace(way, pose=pose)
        if best is None:
            raise PickFailure(f"it cannot be reached from above: {refused}")
        return best[1]

    def _tool_for(self, width: float) -> Transform:
        robot = self._robot
        return grasp_frame(
            robot.description.model, robot.gripper.geometry, width, robot.arm.tip
        )

    def _finish(self, goal: GoalHandle) -> None:
        """Let time pass until a goal has succeeded."""
        if not self._witness.until(lambda: goal.result is not None, PATIENCE):
            goal.cancel()
            raise PickFailure(f"the motion is not done after {PATIENCE:g} s")
        result = goal.result
        if result is not None and result.status is not GoalStatus.SUCCEEDED:
            raise PickFailure(f"the goal was {result.status.name}")
