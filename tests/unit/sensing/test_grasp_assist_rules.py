"""When the cheat holds on, and when it lets go."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from ur5_rig import BETWEEN_PADS, EDGE

import tool0
from tool0.description.scene import Scene, SceneObject
from tool0.description.shapes import Box
from tool0.description.transform import Pose

ASSISTED = tool0.SimulationConfig(grasp_assist=True)
TWO_HANDS = """<robot name="hands" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:include filename="$(find tool0_description)/config/grippers/2f85/macro.xacro"/>
<link name="wall"/>
<xacro:tool0_gripper prefix="lower_" parent="wall"
    folder="$(find tool0_description)/config/grippers/2f85">
  <origin xyz="0 0 0"/>
</xacro:tool0_gripper>
<xacro:tool0_gripper prefix="upper_" parent="wall"
    folder="$(find tool0_description)/config/grippers/2f85">
  <origin xyz="0 0 0.36" rpy="3.1416 0 1.5708"/>
</xacro:tool0_gripper>
</robot>"""
TWO_CONTROLLERS = "".join(
    f"""
{hand}:
  type: effort_controllers/JointTrajectoryController
  joints: [{hand}_finger_joint]
  gains: {{{hand}_finger_joint: {{p: 600, d: 5.4}}}}
"""
    for hand in ("lower", "upper")
)


def block(name: str, z: float, mass: float | None) -> SceneObject:
    x, y, _ = BETWEEN_PADS
    return SceneObject(
        name=name,
        geometry=Box(size=(EDGE, EDGE, EDGE)),
        pose=Pose(xyz=(x, y, z)),
        mass=mass,
    )


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    """A block on a post, gripped, and the post gone."""
    z = BETWEEN_PADS[2]
    scene = Scene((block("post", z - EDGE, None), block("soap", z, 0.2)))
    with tool0.bringup(
        realtime=False, scene=scene, initial_pose="ready", simulation=ASSISTED
    ) as robot:
        robot.gripper.move(opening=0.0, force=40.0)
        robot.run(1.0)
        robot.scene.remove("post")
        yield robot


def is_attached(robot: tool0.Robot) -> bool:
    robot.run(0.02)
    base = "robotiq_arg2f_base_link"
    return any({c.first, c.second} == {base, "soap"} for c in robot.contacts())


def test_it_holds_on_while_the_grip_changes(robot: tool0.Robot) -> None:
    assert is_attached(robot)
    robot.gripper.move(opening=0.0, force=200.0)
    robot.run(0.5)
    assert is_attached(robot)
    robot.emergency_stop()
    robot.run(0.2)
    robot.emergency_stop(False)
    robot.run(0.2)
    assert is_attached(robot)


def test_it_lets_go_as_soon_as_the_gripper_is_to_open(robot: tool0.Robot) -> None:
    robot.gripper.move(opening=0.05)
    robot.run(0.016)
    assert not is_attached(robot)


def test_it_takes_no_notice_of_what_is_taken_away(robot: tool0.Robot) -> None:
    robot.scene.remove("soap")
    robot.run(0.5)
    assert robot.gripper.opening < 0.5 * EDGE  # and nothing complained


def test_what_stands_fast_is_attached_to_nothing() -> None:
    post = block("soap", BETWEEN_PADS[2], None)
    with tool0.bringup(
        realtime=False,
        scene=Scene((post,)),
        initial_pose="ready",
        simulation=ASSISTED,
    ) as robot:
        robot.gripper.move(opening=0.0, force=40.0)
        robot.run(1.0)
        assert robot.gripper.state.motion == "holding_inside"
        assert not is_attached(robot)


def test_what_one_gripper_holds_another_takes_over_when_it_lets_go(
    tmp_path: Path,
) -> None:
    robot_file, controllers = tmp_path / "hands.xacro", tmp_path / "hands.yaml"
    robot_file.write_text(TWO_HANDS)
    controllers.write_text(TWO_CONTROLLERS)
    with tool0.bringup(
        robot=robot_file,
        controllers_file=controllers,
        controllers=["lower", "upper"],
        initial_pose={"lower_finger_joint": 0.4, "upper_finger_joint": 0.4},
        simulation=replace(ASSISTED, spawn_z=1.0),
        realtime=False,
    ) as robot:
        shape = Box(size=(EDGE, EDGE, 2 * EDGE))
        robot.scene.add("rod", shape, xyz=(0.0, 0.0, 0.19), mass=0.1)
        hands = dict(zip(("lower", "upper"), robot.grippers.values(), strict=True))
        for hand in hands.values():
            hand.move(opening=0.0, force=40.0)
        robot.run(0.6)
        assert {hand.state.motion for hand in hands.values()} == {"holding_inside"}
        (first,) = holders(robot)
        hands[first].move(opening=0.085)
        robot.run(0.3)
        assert holders(robot) == hands.keys() - {first}


def holders(robot: tool0.Robot) -> set[str]:
    """Return the hands whose base the rod is fixed to."""
    robot.run(0.02)
    return {
        name.removesuffix("_robotiq_arg2f_base_link")
        for contact in robot.contacts()
        for name in (contact.first, contact.second)
        if name.endswith("base_link")
    }
