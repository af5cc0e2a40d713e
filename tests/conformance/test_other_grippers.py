"""Speed, force, opening and detection of every gripper but the usual one."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.grasping import CUBES, SHAKEN, hold_and_shake
from conformance_types import BringUp

import tool0
from tool0.description.grasp_frames import grasp_frame, pad_links
from tool0.description.scene import SceneObject
from tool0.description.shapes import Box
from tool0.description.transform import Pose

AWAY = (2.0, 0.0, 1.0)
SYMMETRY = 5e-4
"""Of the pads about the middle of the gripper at most [m]."""

GRIPPERS = [name for name in CUBES if name != "2f85"]


@pytest.fixture(scope="module", params=GRIPPERS)
def gripper(request: pytest.FixtureRequest, engine: str) -> str:
    name: str = request.param
    if engine != "mujoco" and name == "2f140":
        pytest.skip("it is a larger 2f85, which is tested there")
    return name


def apart(robot: tool0.Robot) -> tuple[float, float]:
    """Return the distance of the pads' faces, and how far off their middle is [m]."""
    model, geometry = robot.description.model, robot.gripper.geometry
    names = pad_links(model, geometry)
    base = robot.pose(model.joint(geometry.joint).parent).matrix
    left, right = (robot.pose(name).matrix for name in names)
    thick = model.link(names[0]).collisions[0].geometry.size[1]  # type: ignore[union-attr]
    across = -left[:3, 1]
    middle = (left[:3, 3] + right[:3, 3]) / 2.0 - base[:3, 3]
    return float((right[:3, 3] - left[:3, 3]) @ across) - thick, float(middle @ across)


def test_it_opens_and_closes_to_half_a_millimetre(
    bring_up: BringUp, gripper: str
) -> None:
    robot = bring_up(gripper=gripper, initial_pose="ready")
    widest = robot.gripper.geometry.max_opening
    for share in (0.0, 1.0, 0.5, 0.1, 0.7):
        goal = robot.gripper.move(opening=share * widest)
        assert goal.wait(10.0).status is tool0.GoalStatus.SUCCEEDED
        robot.run(0.5)
        distance, middle = apart(robot)
        assert robot.gripper.opening == pytest.approx(share * widest, abs=5e-4)
        assert distance == pytest.approx(share * widest, abs=5e-4)
        assert abs(middle) <= SYMMETRY
        assert robot.gripper.state.gobj == 3
    velocities = []
    for _ in range(100):
        robot.run(0.01)
        velocities.append(robot.joint_state.velocity[robot.gripper.geometry.joint])
    assert np.sqrt(np.mean(np.square(velocities))) <= 1e-4


def test_the_pads_move_at_the_speed(bring_up: BringUp, gripper: str) -> None:
    robot = bring_up(gripper=gripper, initial_pose="ready")
    geometry = robot.gripper.geometry
    widest = geometry.max_opening
    for speed in geometry.speed:
        for start, end in ((widest, 0.0), (0.0, widest)):
            robot.gripper.move(opening=start).wait(5.0)
            robot.gripper.move(opening=end, speed=speed)
            robot.run(0.4 * widest / speed)
            before = robot.gripper.opening
            robot.run(0.002 / speed)
            rate = abs(robot.gripper.opening - before) * speed / 0.002
            assert rate == pytest.approx(speed, rel=0.1), (speed, end)


@pytest.mark.parametrize("share", [0.2, 0.9])
def test_force_and_grip_are_those_of_the_command(
    bring_up: BringUp, gripper: str, share: float
) -> None:
    robot = bring_up(gripper=gripper, initial_pose="ready")
    robot.contacts()  # Gazebo looks at them from the first call on
    geometry, model = robot.gripper.geometry, robot.description.model
    width = share * geometry.max_opening
    block = Box(size=(0.04, width, 0.04))
    robot.scene.add(
        SceneObject(name="block", geometry=block, pose=Pose(xyz=AWAY), mass=0.1)
    )
    for force in (geometry.force[0], sum(geometry.force) / 2.0, geometry.force[1]):
        robot.gripper.move(opening=min(geometry.max_opening, width + 0.001)).wait(5.0)
        frame = robot.pose("tool0") @ grasp_frame(model, geometry, width, "tool0")
        robot.scene.place("block", frame.position, frame.quat_wxyz)
        across = np.array(frame.rotation)[:, 1]
        robot.gripper.move(opening=0.0, force=force)
        robot.run(0.4)
        for _ in range(5):
            robot.run(0.003)
            pads = [
                abs(float(np.dot(contact.force, across)))
                for contact in robot.contacts()
                if "block" in (contact.first, contact.second)
            ]
            assert pads == pytest.approx([force, force], rel=0.1)
        state = robot.gripper.state
        assert (state.motion, state.gobj) == ("holding_inside", 2)
        assert state.width == pytest.approx(width, abs=2e-3)
    robot.scene.place("block", AWAY)
    robot.run(1.0)
    assert robot.gripper.state.gobj == 3


def test_opening_against_walls_is_told(bring_up: BringUp, gripper: str) -> None:
    robot = bring_up(gripper=gripper, initial_pose="ready")
    geometry, model = robot.gripper.geometry, robot.description.model
    middle = 0.6 * geometry.max_opening
    robot.gripper.move(opening=0.0).wait(5.0)
    frame = robot.pose("tool0") @ grasp_frame(model, geometry, middle, "tool0")
    across = np.array(frame.rotation)[:, 1]
    for name, side in (("left", -1.0), ("right", 1.0)):
        away = side * (middle / 2.0 + 0.04)
        place = np.array(frame.position) + away * across
        wall = SceneObject(
            name=name, geometry=Box(size=(0.03, 0.02, 0.02)), pose=Pose(xyz=AWAY)
        )
        robot.scene.add(wall)
        robot.scene.place(name, place.tolist(), frame.quat_wxyz)
    robot.gripper.move(opening=geometry.max_opening)
    assert robot.gripper.wait(5.0).gobj == 1


def test_positions_of_the_joint_have_its_unit(bring_up: BringUp, gripper: str) -> None:
    robot = bring_up(gripper=gripper)
    geometry = robot.gripper.geometry
    unit = next(iter(geometry.quantity.units))
    joint = robot.description.model.joint(geometry.joint)
    robot.gripper.move(position=joint.limits.upper / 2.0).wait(5.0)
    reached = robot.joint_state.position[joint.name]
    assert reached == pytest.approx(joint.limits.upper / 2.0, abs=1e-3)
    with pytest.raises(tool0.ModelError, match=rf"outside \[0\.0000, .*\] {unit}"):
        robot.gripper.move(position=1.1 * joint.limits.upper)


def test_an_action_takes_positions_of_the_joint(
    bring_up: BringUp, gripper: str
) -> None:
    robot = bring_up(gripper=gripper, initial_pose="ready", gripper_action=True)
    geometry = robot.gripper.geometry
    half = geometry.position(geometry.max_opening / 2.0)
    result = robot.controller("gripper_controller").command_gripper(half).wait(5.0)
    assert isinstance(result, tool0.GripperResult)
    assert (result.reached_goal, result.stalled) == (True, False)
    robot.run(0.5)
    assert apart(robot)[0] == pytest.approx(geometry.max_opening / 2.0, abs=5e-4)


def test_something_heavy_is_held_and_shaken(engine: str, gripper: str) -> None:
    size = max(CUBES[gripper]) / 1e3
    description = tool0.DescriptionConfig(gripper=gripper)
    held = hold_and_shake(engine, Box(size=(size,) * 3), 0.5, description=description)
    assert held.failure is None
    assert held.acceleration >= SHAKEN
    assert held.slip <= 1e-4
    assert held.shaken <= 5e-3


def test_a_reset_takes_the_fingers_back(bring_up: BringUp, gripper: str) -> None:
    robot = bring_up(gripper=gripper, initial_pose="half")
    geometry = robot.gripper.geometry
    robot.gripper.move(opening=0.0).wait(5.0)
    robot.reset()
    distance, middle = apart(robot)
    assert distance == pytest.approx(geometry.max_opening / 2.0, abs=1e-4)
    assert abs(middle) <= 1e-5
    robot.run(1.0)
    assert apart(robot)[0] == pytest.approx(geometry.max_opening / 2.0, abs=5e-4)
