"""Programs as people teach them: a pick by ten waypoints, and a search."""

from __future__ import annotations

import math
from collections.abc import Mapping

import tool0
from tool0 import (
    GripperStep,
    MoveJointStep,
    MoveLinearStep,
    Program,
    SetOutputStep,
    ToolPose,
    UntilStep,
)
from tool0.scene import Pose

TOOL = Pose(xyz=(0.0, 0.0, 0.1418))
"""The middle between the pads in the flange, 45 mm apart [m]."""
TABLE = -0.02
"""Height of the table's top [m]."""
FAST = 2.0
"""Of the joints [rad/s]."""


def taught(robot: tool0.Robot, x: float, y: float, z: float) -> Mapping[str, float]:
    """Return the joint positions that put the pads there, from above [m, rad]."""
    pose = Pose(xyz=(x, y, z), rpy=(math.pi, 0.0, 0.0))
    near = robot.poses()["home"].positions
    arm = {name: near[name] for name in robot.arm.joint_names}
    return robot.arm.inverse_kinematics(pose, tool=TOOL, near=arm)[0].positions


def taught_pick(robot: tool0.Robot, name: str = "pick") -> Program:
    """Return a program that takes the cube into the bin, in ten moves."""
    x, y, z = robot.scene.pose("cube").position
    bx, by, _ = tool0.find_bin(robot.scene.objects, "bin").center

    def joints(*place: float, blend: float = 0.0) -> MoveJointStep:
        return MoveJointStep(
            joints=dict(taught(robot, *place)),
            speed=FAST,
            acceleration=4.0,
            blend=blend,
        )

    def line(*place: float, blend: float = 0.0) -> MoveLinearStep:
        return MoveLinearStep(
            joints=dict(taught(robot, *place)), speed=0.5, acceleration=2.5, blend=blend
        )

    return Program(
        name=name,
        steps=(
            GripperStep(opening="open"),
            joints(x - 0.05, y - 0.05, z + 0.2, blend=0.03),
            line(x, y, z + 0.12, blend=0.02),
            line(x, y, z + 0.05, blend=0.01),
            line(x, y, z),
            GripperStep(opening="closed", force=60.0, must_hold=True),
            line(x, y, z + 0.12, blend=0.03),
            joints((x + bx) / 2.0, (y + by) / 2.0, z + 0.22, blend=0.05),
            joints(bx, by, z + 0.2, blend=0.02),
            line(bx, by, z + 0.12),
            GripperStep(opening=0.07),
            line(bx, by, z + 0.22, blend=0.02),
            MoveJointStep(named_pose="home", speed=FAST, acceleration=4.0),
        ),
    )


def at(x: float, y: float, z: float) -> ToolPose:
    """Return a pose that looks down [m]."""
    return ToolPose(xyz=(x, y, z), rpy=(math.pi, 0.0, 0.0))


def search(**changes: object) -> Program:
    """Return a program that feels for the table, and goes up again.

    When it has found it, it sets output 5.
    """
    until = {"direction": (0.0, 0.0, -1.0), "distance": 0.1, "speed": 0.03} | changes
    return Program(
        name="search",
        tool=ToolPose(xyz=TOOL.xyz),
        steps=(
            GripperStep(opening="closed"),
            MoveJointStep(pose=at(0.5, 0.0, 0.05), speed=2.0, acceleration=4.0),
            UntilStep(**until),  # type: ignore[arg-type]
            SetOutputStep(output=5),
            MoveLinearStep(pose=at(0.5, 0.1, 0.06)),
        ),
    )
