"""Speed and force of the grip are real: told by contacts, not by the command."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conformance_types import BringUp
from ur5_rig import GRIPPER

import tool0
from tool0.control.default_controllers import controllers_yaml
from tool0.description.grasp_frames import grasp_frame
from tool0.description.loading import assemble
from tool0.description.scene import Scene, SceneObject
from tool0.description.shapes import Box
from tool0.description.transform import Pose, Transform

SPEEDS = (0.02, 0.05, 0.10, 0.15)  # [m/s]
FORCES = (20.0, 60.0, 120.0, 235.0)  # [N]
WIDTHS = (0.02, 0.045, 0.08)  # [m]
AWAY = (2.0, 0.0, 1.0)
BY_POSITION = """
gripper_controller:
  type: position_controllers/GripperActionController
  joint: finger_joint
  goal_tolerance: 0.002
"""


@pytest.fixture(params=["trajectory", "action", "position interface"])
def options(
    request: pytest.FixtureRequest, engine: str, tmp_path: Path
) -> dict[str, object]:
    """Return how to bring up a gripper with each kind of controller."""
    if request.param == "trajectory":
        return {}
    if engine != "mujoco":
        pytest.skip("controllers know no engine: one of them will do")
    if request.param == "action":
        return {"gripper_action": True}
    file = tmp_path / "position.yaml"
    file.write_text(BY_POSITION)
    interface = "hardware_interface/PositionJointInterface"
    return {"controllers_file": file, "transmission_hw_interface": interface}


def some(values: tuple[float, ...], options: dict[str, object]) -> tuple[float, ...]:
    """Return all values for the default, and the ends for other controllers."""
    return (values[0], values[-1]) if options else values


def block(width: float, name: str = "", mass: float | None = 0.1) -> SceneObject:
    return SceneObject(
        name=name or f"block{width}",
        geometry=Box(size=(0.04, width, 0.04)),
        pose=Pose(xyz=AWAY if name != "right" else (*AWAY[:2], 2.0)),
        mass=mass,
    )


def between_the_pads(robot: tool0.Robot, opening: float) -> Transform:
    """Return the frame midway between the pads, y from pad to pad."""
    geometry, model = robot.gripper.geometry, robot.description.model
    return robot.pose("tool0") @ grasp_frame(model, geometry, opening, "tool0")


def put_between(robot: tool0.Robot, item: SceneObject, width: float) -> np.ndarray:
    """Put ``item`` between the pads, and return the direction from pad to pad."""
    frame = between_the_pads(robot, width)
    robot.scene.place(item.name, frame.position, frame.quat_wxyz)
    return np.array(frame.rotation)[:, 1]


def squeeze(robot: tool0.Robot, item: str, axis: np.ndarray) -> list[float]:
    """Return how hard each pad presses on ``item`` [N]."""
    return [
        abs(float(np.dot(contact.force, axis)))
        for contact in robot.contacts()
        if item in (contact.first, contact.second)
    ]


def test_the_force_between_the_pads_settles_at_the_command(
    bring_up: BringUp, options: dict[str, object]
) -> None:
    robot = bring_up(initial_pose="ready", **options)
    robot.contacts()  # Gazebo looks at them from the first call on
    for width in some(WIDTHS, options):
        item = robot.scene.add(block(width))
        for force in some(FORCES, options):
            robot.gripper.move(opening=min(0.085, width + 0.003))
            robot.gripper.wait(3.0)
            axis = put_between(robot, item, width)
            robot.gripper.move(opening=0.0, force=force)
            robot.run(0.3)
            for _ in range(10):
                robot.run(0.003)
                pads = squeeze(robot, item.name, axis)
                assert pads == pytest.approx([force, force], rel=0.1), (width, force)
        robot.gripper.move(opening=0.085).wait(3.0)
        robot.scene.remove(item.name)


def test_the_pads_close_and_open_at_the_speed(
    bring_up: BringUp, options: dict[str, object]
) -> None:
    robot = bring_up(initial_pose="ready", **options)
    for speed in some(SPEEDS, options):
        for start, end in ((0.085, 0.0), (0.0, 0.085)):
            robot.gripper.move(opening=start).wait(3.0)
            robot.gripper.move(opening=end, speed=speed)
            robot.run(0.012 / speed)
            rates = []
            for _ in range(3):
                before = robot.gripper.opening
                robot.run(0.002 / speed)
                rates.append(abs(robot.gripper.opening - before) * speed / 0.002)
            assert rates == pytest.approx([speed] * 3, rel=0.1), (speed, end)


def seen(robot: tool0.Robot, duration: float) -> str:
    """Run, and return what the gripper does then."""
    robot.run(duration)
    return robot.gripper.state.motion


def test_what_it_does_is_known_within_a_fifth_of_a_second(
    bring_up: BringUp, options: dict[str, object]
) -> None:
    item = block(0.084, mass=None)
    robot = bring_up(initial_pose="ready", scene=Scene((item,)), **options)
    gripper = robot.gripper
    gripper.move(opening=0.085)
    assert gripper.wait(3.0).gobj == 3
    # 1 mm from full opening
    put_between(robot, item, 0.084)
    gripper.move(opening=0.0, force=60.0)
    assert gripper.state.motion == "moving"
    assert seen(robot, 0.2) == "holding_inside"
    assert gripper.state.gobj == 2
    assert gripper.state.width == pytest.approx(0.084, abs=1e-3)
    assert {seen(robot, 0.003) for _ in range(60)} == {"holding_inside"}
    # pulled out
    robot.scene.place(item.name, AWAY)
    assert seen(robot, 0.05) == "moving"
    # on nothing
    while gripper.opening > 5e-3:
        assert seen(robot, 0.02) == "moving"
    assert seen(robot, 0.2) == "at_target"
    assert gripper.state.width is None


def test_opening_against_something_is_told(bring_up: BringUp) -> None:
    walls = [block(0.02, name, mass=None) for name in ("left", "right")]
    robot = bring_up(initial_pose="ready", scene=Scene(tuple(walls)))
    gripper = robot.gripper
    gripper.move(opening=0.0).wait(3.0)
    frame = between_the_pads(robot, 0.06)
    across = np.array(frame.rotation)[:, 1]
    for wall, side in zip(walls, (-1.0, 1.0), strict=True):
        place = np.array(frame.position) + side * 0.058 * across
        robot.scene.place(wall.name, place.tolist(), frame.quat_wxyz)
    gripper.move(opening=0.085)
    assert gripper.wait(3.0).gobj == 1
    assert {seen(robot, 0.02) for _ in range(20)} == {"holding_outside"}


@pytest.mark.parametrize("allow_stalling", [True, False])
def test_an_action_that_meets_something_ends_as_in_ros(
    bring_up: BringUp, tmp_path: Path, allow_stalling: bool
) -> None:
    file = tmp_path / "action.yaml"
    allow = f"stall_timeout: 0.3\n  allow_stalling: {str(allow_stalling).lower()}"
    controllers = controllers_yaml(assemble(), gripper_action=True)
    file.write_text(controllers.replace("stall_timeout: 1.0", allow))
    item = block(0.045, mass=None)
    robot = bring_up(initial_pose="ready", scene=Scene((item,)), controllers_file=file)
    robot.gripper.move(opening=0.06).wait(3.0)
    put_between(robot, item, 0.045)
    result = robot.controller(GRIPPER).command_gripper(0.8).wait(3.0)
    assert isinstance(result, tool0.GripperResult)
    succeeded, aborted = tool0.GoalStatus.SUCCEEDED, tool0.GoalStatus.ABORTED
    assert result.status is (succeeded if allow_stalling else aborted)
    assert (result.stalled, result.reached_goal) == (True, False)
    assert robot.gripper.wait(1.0).motion == "holding_inside"


def test_another_squeeze_never_lets_go(
    bring_up: BringUp, options: dict[str, object]
) -> None:
    item = block(0.045)
    robot = bring_up(initial_pose="ready", scene=Scene((item,)), **options)
    robot.contacts()
    robot.gripper.move(opening=0.048)
    robot.gripper.wait(3.0)
    axis = put_between(robot, item, 0.045)
    weaker = 0.0
    for force in (20.0, 60.0, 120.0):
        robot.gripper.move(opening=0.0, force=force)
        for _ in range(100):
            robot.run(0.002)
            pads = squeeze(robot, item.name, axis)
            assert min(pads, default=0.0) >= 0.9 * weaker
        weaker = force
    robot.gripper.move(opening=0.0, force=20.0)
    for _ in range(100):
        robot.run(0.002)
        assert min(squeeze(robot, item.name, axis), default=0.0) >= 0.6 * 20.0
