"""The gripper's registers while the simulation moves its fingers."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from robotiq_rig import ServedGripper, serving_gripper
from ur5_rig import BETWEEN_PADS, EDGE

import tool0
from tool0.description.scene import SceneObject
from tool0.description.shapes import Box
from tool0.description.transform import Pose
from tool0.devices.robotiq_registers import Activation, Fault, ObjectStatus

pytestmark = pytest.mark.slow

CUBE = SceneObject(
    name="cube",
    geometry=Box(size=(EDGE, EDGE, EDGE)),
    pose=Pose(xyz=BETWEEN_PADS),
    mass=0.1,
)
TABLE = SceneObject(
    name="table",
    geometry=Box(size=(0.4, 0.6, 0.04)),
    pose=Pose(xyz=(0.6, 0.0, BETWEEN_PADS[2] - EDGE / 2 - 0.02)),
)
FAST = 4.0  # simulated seconds per wall second


@pytest.fixture(scope="module")
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(initial_pose="ready", speed=FAST) as robot:
        yield robot


@pytest.fixture
def served(robot: tool0.Robot, tmp_path: Path) -> Iterator[ServedGripper]:
    with serving_gripper(robot, tmp_path) as served:
        yield served


@pytest.fixture
def activated(robot: tool0.Robot, tmp_path: Path) -> Iterator[ServedGripper]:
    with serving_gripper(robot, tmp_path, is_activated=True) as served:
        served.do(lambda: served.gripper.move_and_wait(0))
        yield served


@pytest.fixture
def cube(robot: tool0.Robot) -> Iterator[str]:
    """Put a cube on a table between the open pads."""
    robot.scene.add(TABLE)
    robot.scene.add(CUBE)
    yield CUBE.name
    for name in (CUBE.name, TABLE.name):
        if name in robot.scene:
            robot.scene.remove(name)


def test_it_must_be_activated_and_closes_and_opens_meanwhile(
    served: ServedGripper,
) -> None:
    gripper = served.gripper
    assert gripper.status.activation is Activation.RESET
    served.do(lambda: gripper.change(go_to=True, position=100))
    assert gripper.status.fault is Fault.ACTIVATION_NEEDED
    assert not gripper.status.goes_to

    served.do(lambda: gripper.change(activate=True))
    assert gripper.status.activation is Activation.IN_PROGRESS
    assert gripper.status.fault is Fault.ACTION_DELAYED
    served.wait_for_update(lambda: gripper.position > 200)
    served.wait_for_update(lambda: gripper.position < 20)
    served.wait_until(lambda: gripper.is_activated)
    assert gripper.status.fault is Fault.NONE
    assert gripper.status.goes_to

    served.do(gripper.wait)  # then it does what was delayed
    assert gripper.position == pytest.approx(100, abs=2)
    assert gripper.status.object_status is ObjectStatus.ARRIVED

    served.do(gripper.activate)  # which it is
    assert gripper.is_activated
    served.do(gripper.reset)
    assert not gripper.status.is_activated
    assert gripper.status.activation is Activation.RESET


@pytest.mark.slow
def test_it_detects_an_object_its_loss_and_a_release(
    activated: ServedGripper, cube: str
) -> None:
    gripper, robot = activated.gripper, activated.robot
    activated.do(lambda: gripper.change(speed=128, force=20))
    activated.do(lambda: gripper.move_and_wait(255))
    assert gripper.is_object_detected
    assert gripper.status.object_status is ObjectStatus.MET_CLOSING
    width = gripper.counts.opening(gripper.position)
    assert width == pytest.approx(EDGE, abs=0.002)
    weak = gripper.status.current
    assert 5 < weak < 30

    activated.do(lambda: gripper.change(force=255))  # of the motor, and of the grip
    activated.wait_until(lambda: gripper.is_motion_complete)
    assert gripper.is_object_detected
    assert gripper.status.current > 2 * weak

    robot.scene.remove(cube)
    activated.wait_until(lambda: gripper.status.object_status is ObjectStatus.ARRIVED)
    assert gripper.position == gripper.counts.closed
    activated.do(lambda: gripper.move_and_wait(0))
    assert gripper.status.object_status is ObjectStatus.ARRIVED
    assert gripper.position == gripper.counts.open


def test_stopping_and_deactivating_keep_a_grip(
    activated: ServedGripper, cube: str
) -> None:
    gripper = activated.gripper
    activated.do(lambda: gripper.move_and_wait(255))
    held = gripper.status.current
    for action in (gripper.stop, gripper.reset):
        activated.do(action)
        activated.sleep(0.3)
        assert gripper.status.current == pytest.approx(held, abs=3)


@pytest.mark.slow
def test_stopping_keeps_the_fingers_where_they_are(activated: ServedGripper) -> None:
    gripper = activated.gripper
    activated.do(lambda: gripper.change(speed=0))
    activated.do(lambda: gripper.move(255))
    activated.wait_for_update(lambda: gripper.position > 60)
    activated.do(gripper.stop)
    activated.wait_until(lambda: gripper.is_motion_complete)
    here = gripper.position
    assert 60 < here < 120
    activated.sleep(0.3)
    assert gripper.position == pytest.approx(here, abs=3)
    assert not gripper.status.goes_to


@pytest.mark.slow
@pytest.mark.parametrize("opening", [True, False])
def test_after_an_automatic_release_only_a_reset_helps(
    activated: ServedGripper, opening: bool
) -> None:
    gripper = activated.gripper
    activated.do(lambda: gripper.move_and_wait(180 if opening else 90))
    activated.do(
        lambda: gripper.change(release=True, release_opening=opening, go_to=False)
    )
    assert gripper.status.fault is Fault.RELEASE_IN_PROGRESS
    assert gripper.status.activation is Activation.RESET
    activated.wait_until(lambda: gripper.status.fault is Fault.RELEASE_COMPLETE)
    end = gripper.counts.open if opening else gripper.counts.closed
    assert gripper.position == end

    activated.do(lambda: gripper.change(release=False, go_to=True, position=128))
    activated.sleep(0.3)
    assert gripper.status.fault is Fault.RELEASE_COMPLETE
    assert gripper.position == end
    activated.do(lambda: gripper.change(go_to=False))
    activated.do(gripper.activate_and_wait)
    assert gripper.status.fault is Fault.NONE
    assert gripper.is_activated


def test_it_shows_what_others_do_and_goes_back_when_told_again(
    activated: ServedGripper,
) -> None:
    gripper, robot = activated.gripper, activated.robot
    activated.do(lambda: gripper.move_and_wait(200))
    robot.gripper.move(opening=0.08).wait(10.0)
    activated.wait_for_update(lambda: gripper.position < 30)
    activated.do(lambda: gripper.wait_until(lambda: not gripper.has_goal))
    activated.do(lambda: gripper.move_and_wait(200))
    assert gripper.position == pytest.approx(200, abs=2)


def test_it_loses_its_registers_with_its_power(activated: ServedGripper) -> None:
    gripper, robot = activated.gripper, activated.robot
    box = robot.arm.control_box
    box.power_off()
    activated.wait_until(lambda: not gripper.is_powered)
    assert not gripper.is_activated
    activated.do(lambda: gripper.change(activate=True))  # nobody hears it
    box.power_on()
    activated.wait_for_update(lambda: gripper.is_powered)
    assert not gripper.status.is_activated
    box.release_brakes()
    box.play()


def test_a_reset_of_the_simulation_ends_its_goal(activated: ServedGripper) -> None:
    gripper, robot = activated.gripper, activated.robot
    activated.do(lambda: gripper.move_and_wait(255))
    robot.reset()
    activated.wait_for_update(lambda: gripper.position < 10)
    activated.do(lambda: gripper.wait_until(lambda: not gripper.has_goal))
    activated.do(lambda: gripper.move_and_wait(255))
    assert gripper.position == 230


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "closed", "opened"),
    [("2f140", 230, 3), ("hande", 255, 0)],  # the 2F-85 is everywhere else
)
def test_other_grippers_open_and_close(
    name: str, closed: int, opened: int, tmp_path: Path
) -> None:
    with (
        tool0.bringup(gripper=name, speed=FAST) as robot,
        serving_gripper(robot, tmp_path, is_activated=True) as served,
    ):
        gripper = served.gripper
        for request, expected in ((255, closed), (0, opened), (128, 128)):
            served.do(lambda request=request: gripper.move_and_wait(request))
            assert gripper.status.object_status is ObjectStatus.ARRIVED
            assert gripper.position == pytest.approx(expected, abs=1)


def test_fingers_that_open_meet_what_is_around_them(activated: ServedGripper) -> None:
    gripper, robot = activated.gripper, activated.robot
    activated.do(lambda: gripper.move_and_wait(255))
    x, y, z = BETWEEN_PADS
    for name, side in (("left wall", 1.0), ("right wall", -1.0)):
        wall = Box(size=(0.02, 0.1, 0.03))
        robot.scene.add(name, wall, xyz=(x + side * 0.06, y, z))
    activated.do(lambda: gripper.move_and_wait(0))
    assert gripper.status.object_status is ObjectStatus.MET_OPENING
    assert gripper.counts.open + 10 < gripper.position < gripper.counts.closed - 10
    for name in ("left wall", "right wall"):
        robot.scene.remove(name)
    activated.wait_until(lambda: gripper.status.object_status is ObjectStatus.ARRIVED)
    assert gripper.position == gripper.counts.open
