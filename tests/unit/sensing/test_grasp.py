"""What the gripper does, told from snapshots of the physics."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator

import pytest
from msgspec import structs
from ur5_rig import ARM, ARM_JOINTS, GRIPPER, POST, POST_GRIPPER

import tool0
from tool0.description.scene import Scene, SceneObject
from tool0.description.shapes import Box, Cylinder
from tool0.description.transform import Pose
from tool0.protocol.gripper import GraspState
from tool0.sensing.grasp import WINDOW, GraspDetector

pytestmark = pytest.mark.slow

FILES = {
    "ours": None,
    "post, trajectory": [POST],
    "post, action": [POST, POST_GRIPPER],
}
MIDDLE = (0.5487, 0.1091, 0.003)
"""Between the pads in the pose ``ready``, in world [m]."""

Observed = tuple[tool0.Robot, "Watch"]


class Watch:
    """Shows a robot's snapshots to a detector, as somebody who watches would."""

    def __init__(self, robot: tool0.Robot) -> None:
        self.robot = robot
        self.detector = GraspDetector(robot.gripper.geometry)
        self.state = self.detector.observe(robot.snapshot)

    def run(self, duration: float, period: float = 0.016) -> list[str]:
        """Run, and return the motions, each once while it stays."""
        seen: list[str] = []
        for _ in range(round(duration / period)):
            self.robot.run(period)
            self.state = self.detector.observe(self.robot.snapshot)
            seen.append(self.state.motion)
        return [motion for motion, _ in itertools.groupby(seen)]


def box(name: str, size: tuple[float, float, float], x: float = 0.0) -> SceneObject:
    """Return a box that stands still, ``x`` beside the middle of the pads [m]."""
    place = Pose(xyz=(MIDDLE[0] + x, MIDDLE[1], MIDDLE[2]))
    return SceneObject(name=name, geometry=Box(size=size), pose=place)


TABLE = SceneObject(
    name="table",
    geometry=Box(size=(0.4, 0.6, 0.04)),
    pose=Pose(xyz=(0.6, 0.0, MIDDLE[2] - 0.06)),
)
"""So low that the tips of fingers that open do not touch it."""


def loose(width: float) -> SceneObject:
    """Return a box on the table."""
    place = Pose(xyz=(MIDDLE[0], MIDDLE[1], MIDDLE[2] - 0.01))
    shape = Box(size=(width, width, 0.06))
    return SceneObject(name="box", geometry=shape, pose=place, mass=0.2)


@pytest.fixture
def watching() -> Iterator[Callable[..., Watch]]:
    robots: list[tool0.Robot] = []

    def bring_up(*objects: SceneObject, **options: object) -> Watch:
        robots.append(
            tool0.bringup(
                realtime=False,
                initial_pose="ready",
                scene=Scene(objects),
                **options,  # type: ignore[arg-type]
            )
        )
        return Watch(robots[-1])

    yield bring_up
    for robot in robots:
        robot.close()


@pytest.mark.parametrize("files", FILES.values(), ids=FILES)
def test_a_gripper_that_meets_nothing_moves_and_arrives(watching, files) -> None:
    watch = watching(controllers_file=files)
    assert watch.state.motion == "at_target"
    for opening in (0.0, 0.085, 0.02, 0.06, 0.055):
        watch.robot.gripper.move(opening=opening)
        assert watch.run(2.5) == ["moving", "at_target"]
        assert watch.state.opening == pytest.approx(opening, abs=2e-3)
        assert watch.state.width is None


@pytest.mark.parametrize("files", FILES.values(), ids=FILES)
@pytest.mark.parametrize("width", [0.02, 0.05])
def test_a_box_between_the_pads_is_held_and_measured(watching, width, files) -> None:
    watch = watching(TABLE, loose(width), controllers_file=files)
    for force in (20.0, 100.0):
        watch.robot.gripper.move(opening=0.0, force=force)
        assert watch.run(2.5) == ["moving", "holding_inside"]
        assert watch.state.width == pytest.approx(width, abs=1e-3)
        watch.robot.gripper.move(opening=0.085)
        assert watch.run(2.5) == ["moving", "at_target"]


def test_a_target_just_inside_of_the_box_is_enough(watching) -> None:
    watch = watching(box("box", (0.04, 0.04, 0.04)))
    watch.robot.gripper.move(opening=0.037, speed=0.02)
    assert watch.run(4.0) == ["moving", "holding_inside"]


def test_it_is_told_while_a_slow_motion_still_goes_on(watching) -> None:
    watch = watching(box("box", (0.06, 0.06, 0.04)))
    watch.robot.controller(GRIPPER).move({"finger_joint": 0.8}, speed=0.05)
    assert watch.run(6.0) == ["moving", "holding_inside"]
    finger = watch.robot.snapshot.setpoints()["finger_joint"]
    assert finger.position < 0.6 < finger.target, "the motion is under way"


def test_what_is_in_the_way_outside_is_told_without_a_width(watching) -> None:
    walls = [box(f"wall{x}", (0.02, 0.1, 0.04), x) for x in (-0.06, 0.06)]
    start = tool0.SimulationConfig(allow_penetration=True)  # walls in open fingers
    watch = watching(*walls, simulation=start)
    watch.robot.gripper.move(opening=0.0)
    watch.run(2.0)
    watch.robot.gripper.move(opening=0.085)
    assert watch.run(2.5) == ["moving", "holding_outside"]
    assert watch.state.width is None


def test_a_gripper_that_tells_later_that_it_holds_has_not_arrived(watching) -> None:
    """As a real one: its pads stand still before it tells that they push."""
    watch = watching(box("box", (0.04, 0.04, 0.04)))
    watch.robot.gripper.move(opening=0.0)
    detector = GraspDetector(watch.robot.gripper.geometry)
    late = 0.15 + WINDOW  # after the pads have met the box
    met, told = math.inf, []
    for _ in range(150):
        watch.run(0.016)
        snapshot = watch.robot.snapshot
        if snapshot.gripping:
            met = min(met, snapshot.time)
        if snapshot.time < met + late:
            nothing = (0.0,) * len(snapshot.effort)
            snapshot = structs.replace(snapshot, effort=nothing, gripping=())
        told.append(detector.observe(snapshot).motion)
    assert [motion for motion, _ in itertools.groupby(told)] == [
        *("moving", "holding_inside")
    ]


def test_a_slow_motion_of_nothing_is_a_motion(watching) -> None:
    watch = watching()
    watch.robot.controller(GRIPPER).move({"finger_joint": 0.3}, speed=0.01)
    assert watch.run(5.0) == ["moving"]


def test_a_delayed_trajectory_is_no_grip(watching) -> None:
    watch = watching()
    point = tool0.TrajectoryPoint([0.4], time_from_start=0.5)
    stamp = watch.robot.time + 2.0
    watch.robot.controller(GRIPPER).follow([point], stamp=stamp)
    assert watch.run(4.0) == ["moving", "at_target"]


def test_a_grip_is_held_while_the_arm_moves(watching) -> None:
    watch = watching(TABLE, loose(0.04))
    watch.robot.gripper.move(opening=0.0, force=60.0)
    assert watch.run(2.0) == ["moving", "holding_inside"]
    home = watch.robot.poses()["home"].positions
    watch.robot.move_joints({name: home[name] for name in ARM_JOINTS}, speed=1.0)
    assert watch.run(2.0) == ["holding_inside"]
    assert watch.robot.snapshot.objects[1].position[2] > MIDDLE[2] + 0.2


def test_without_a_controller_that_wants_a_position_it_is_idle(watching) -> None:
    watch = watching()
    watch.robot.switch(stop=[GRIPPER])
    assert watch.run(0.5) == ["idle"]
    watch.robot.switch(start=[GRIPPER], stop=[ARM])
    assert watch.run(0.5) == ["at_target"]


def test_a_reset_begins_anew(watching) -> None:
    watch = watching(box("box", (0.04, 0.04, 0.04)))
    watch.robot.gripper.move(opening=0.0)
    watch.run(2.0)
    assert watch.state.motion == "holding_inside"
    watch.robot.reset()
    state = watch.detector.observe(watch.robot.snapshot)
    assert state == GraspState(motion="at_target", opening=watch.robot.gripper.opening)
    watch.robot.gripper.move(opening=0.0)
    assert watch.run(2.0) == ["moving", "holding_inside"]


def test_an_observer_who_looks_seldom_sees_the_same(watching) -> None:
    watch = watching(box("box", (0.04, 0.04, 0.04)))
    watch.robot.gripper.move(opening=0.0)
    assert watch.run(3.0, period=2.0 * WINDOW) == ["moving", "holding_inside"]
    for _ in range(3):  # paused, say
        assert watch.detector.observe(watch.robot.snapshot) == watch.state


@pytest.mark.parametrize(("depth", "wraps"), [(0.0, False), (0.022, True)])
def test_what_fingers_wrap_around_has_no_width(depth: float, wraps: bool) -> None:
    rod = SceneObject(
        name="rod",
        geometry=Cylinder(radius=0.022, length=0.12),
        pose=Pose(
            xyz=(MIDDLE[0], MIDDLE[1], MIDDLE[2] + depth), rpy=(math.pi / 2.0, 0.0, 0.0)
        ),
    )
    with tool0.bringup(
        description=tool0.DescriptionConfig(gripper_model="linkage"),
        initial_pose="ready",
        scene=Scene((rod,)),
        realtime=False,
    ) as robot:
        robot.gripper.move(opening=0.0, force=100.0)
        state = robot.gripper.wait(2.0)
    assert state.motion == "holding_inside"
    if wraps:
        assert state.width is None
    else:
        assert state.width == pytest.approx(0.044, abs=0.001)


@pytest.mark.parametrize("block", [None, 0.03])
def test_fingers_that_jam_on_a_table_hold_nothing(watching, block) -> None:
    """The pads advance while they close: here the table stops them half way."""
    top = MIDDLE[2] - 0.012
    table = SceneObject(
        name="table",
        geometry=Box(size=(0.4, 0.6, 0.04)),
        pose=Pose(xyz=(0.6, 0.0, top - 0.02)),
    )
    objects = [table]
    if block is not None:
        shape = Box(size=(block, block, block))
        place = Pose(xyz=(MIDDLE[0], MIDDLE[1], top + block / 2))
        objects.append(SceneObject(name="block", geometry=shape, pose=place, mass=0.1))
    watch = watching(*objects)
    watch.robot.gripper.move(opening=0.0, force=60.0)
    assert set(watch.run(3.0)) == {"moving", "blocked"}
    assert watch.state.motion == "blocked"
    assert watch.state.opening > 0.032
    assert (watch.state.width, watch.state.gobj) == (None, 0)
    assert watch.robot.gripper.state == watch.state
    watch.robot.gripper.move(opening=0.085)
    assert watch.run(2.5)[-1] == "at_target"
