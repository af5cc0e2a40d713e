"""The gripper by both of its controllers, with the files that people have."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
import pytest
from ur5_rig import ARM_JOINTS, GRIPPER, POST, POST_GRIPPER, point

import tool0

OPENINGS = {"open": 0.085, "half": 0.0425, "closed": 0.0}  # [m]
CLOSED = 0.8133  # [rad]
BY_TRAJECTORY, BY_ACTION = "post, trajectory", "post, action"
FILES = {"ours": None, BY_TRAJECTORY: [POST], BY_ACTION: [POST, POST_GRIPPER]}
MIMIC_ERROR = 3e-4  # [rad]
SPEED = 0.06  # [m/s] of the pads
PADS = ("left_inner_finger_pad", "right_inner_finger_pad")
WEIGHT = 0.08
"""Of the fingers at the drive, which carries it beside what is commanded [N·m]."""


@pytest.fixture(scope="module", params=FILES)
def shared_by_files(
    engine: str, request: pytest.FixtureRequest
) -> Iterator[tool0.Robot]:
    """Bring a robot up with some of the FILES, for all tests with these."""
    with tool0.bringup(
        control=tool0.ControlConfig(controllers_file=FILES[request.param]),
        simulation=tool0.SimulationConfig(engine=engine),
        realtime=False,
    ) as robot:
        yield robot


@pytest.fixture
def with_files(shared_by_files: tool0.Robot) -> tool0.Robot:
    """Return it as if just brought up."""
    shared_by_files.reset()
    return shared_by_files


def random_targets(n: int) -> list[float]:
    return np.random.default_rng(19).uniform(0.0, CLOSED, n).tolist()


def finger(robot: tool0.Robot) -> float:
    return robot.joint_state.position["finger_joint"]


@pytest.mark.parametrize(
    ("shared_by_files", "pose"),
    list(zip(FILES, OPENINGS, strict=True)),
    indirect=["shared_by_files"],
)
def test_at_rest_nothing_trembles(with_files: tool0.Robot, pose: str) -> None:
    robot = with_files
    robot.reset(robot.poses()[pose].positions)
    robot.gripper.move(opening=OPENINGS[pose])
    robot.run(2.0)
    squares = []
    for _ in range(300):
        robot.run(0.01)
        velocity = robot.joint_state.velocity
        squares.append([velocity[j] ** 2 for j in velocity if j not in ARM_JOINTS])
    rms = np.sqrt(np.mean(squares, axis=0))
    assert len(rms) == 6
    assert rms.max() <= 1e-4  # [rad/s]


@pytest.mark.parametrize("shared_by_files", [BY_TRAJECTORY, BY_ACTION], indirect=True)
def test_every_goal_in_range_succeeds_with_the_post_s_controllers(
    with_files: tool0.Robot, request: pytest.FixtureRequest
) -> None:
    controller = with_files.controller(GRIPPER)
    for target in random_targets(19):  # 6 of 19 were aborted by the original
        if BY_TRAJECTORY in request.node.name:
            goal = controller.follow([point([target], 1.0)])
            assert goal.wait(10.0).status is tool0.GoalStatus.SUCCEEDED
            continue
        result = controller.command_gripper(target).wait(10.0)
        assert result.status is tool0.GoalStatus.SUCCEEDED
        assert isinstance(result, tool0.GripperResult)
        assert (result.reached_goal, result.stalled) == (True, False)
        assert result.position == pytest.approx(target, abs=0.002)


def test_it_opens_and_closes_to_the_millimetre(with_files: tool0.Robot) -> None:
    robot = with_files
    for opening in (0.0, 0.085, 0.04, 0.01, 0.06):
        goal = robot.gripper.move(opening=opening)
        assert goal.wait(10.0).status is tool0.GoalStatus.SUCCEEDED
        robot.run(1.0)
        assert robot.gripper.opening == pytest.approx(opening, abs=1e-3)


def test_cancelling_holds_the_fingers_where_they_are(with_files: tool0.Robot) -> None:
    robot = with_files
    goal = robot.gripper.move(opening=0.0)
    robot.run(0.05)
    goal.cancel()
    assert goal.status is tool0.GoalStatus.PREEMPTED
    robot.run(1.5)
    rest = finger(robot)
    assert 0.0 < rest < 0.7
    robot.run(1.0)
    assert finger(robot) == pytest.approx(rest, abs=1e-3)


def test_mimic_joints_follow_in_motion_and_at_rest(robot: tool0.Robot) -> None:
    followers = [
        (joint.name, joint.mimic.multiplier)
        for joint in robot.description.model.movable_joints
        if joint.mimic is not None
    ]
    assert len(followers) == 5
    worst = 0.0
    for opening in (0.01, 0.08, 0.03):
        robot.gripper.move(opening=opening)
        for _ in range(400):
            robot.run(0.002)
            position = robot.joint_state.position
            for name, multiplier in followers:
                error = position[name] - multiplier * position["finger_joint"]
                worst = max(worst, abs(error))
    assert worst <= MIMIC_ERROR


@pytest.mark.parametrize("shared_by_files", [BY_ACTION], indirect=True)
def test_the_fingers_are_never_faster_than_their_drive(with_files: tool0.Robot) -> None:
    robot = with_files
    limit = robot.description.model.joint("finger_joint").limits.velocity
    fastest = 0.0
    for target, _ in itertools.product((CLOSED - 1e-3, 0.0), range(2)):
        robot.controller(GRIPPER).command_gripper(target)
        for _ in range(300):
            robot.run(0.002)
            fastest = max(fastest, abs(robot.joint_state.velocity["finger_joint"]))
    assert 0.5 * limit < fastest <= 1.1 * limit


def strongest(robot: tool0.Robot, duration: float) -> float:
    """Run, and return the largest effort of the drive [N·m]."""
    most = 0.0
    for _ in range(round(duration / 0.005)):
        robot.run(0.005)
        most = max(most, abs(robot.joint_state.effort["finger_joint"]))
    return most


def test_an_effort_bound_is_kept_and_lifted(robot: tool0.Robot) -> None:
    bound = 0.2
    robot.gripper.move(opening=0.0, effort=bound)
    assert 0.5 * bound < strongest(robot, 1.5) <= bound + WEIGHT
    robot.gripper.move(opening=0.085).wait(10.0)
    robot.gripper.move(opening=0.0)
    assert strongest(robot, 1.5) > 2.0 * bound


@pytest.mark.parametrize("shared_by_files", [BY_ACTION], indirect=True)
def test_fingers_rest_at_their_stops_and_leave_them_no_faster_than_told(
    with_files: tool0.Robot,
) -> None:
    robot = with_files
    joint = robot.description.model.joint("finger_joint")
    geometry = robot.gripper.geometry
    for target, stop in ((0.0, joint.limits.upper), (0.085, joint.limits.lower)):
        robot.gripper.move(opening=target, speed=SPEED)
        fastest = 0.0
        for _ in range(900):
            robot.run(0.002)
            q = robot.joint_state.position[joint.name]
            qd = robot.joint_state.velocity[joint.name]
            fastest = max(fastest, abs(qd) * geometry.lever(q))
            assert (q - stop) * (1.0 if target == 0.0 else -1.0) < 1e-3
        assert 0.95 * SPEED < fastest < 1.1 * SPEED


def between_pads(robot: tool0.Robot) -> float:
    """Return the distance between the faces of the pads, by all joints between [m]."""
    links = robot.description.model.link_by_name
    left, right = (robot.pose(pad).matrix for pad in PADS)
    thick = links[PADS[0]].collisions[0].geometry.size[1]  # type: ignore[union-attr]
    normal = -left[:3, 1]
    return float((right[:3, 3] - left[:3, 3]) @ normal) - thick


def test_the_opening_is_that_of_the_formula_over_the_whole_range(
    robot: tool0.Robot,
) -> None:
    seen = []
    for opening in (0.0, 0.085):
        goal = robot.gripper.move(opening=opening)
        while goal.status is tool0.GoalStatus.ACTIVE:
            robot.run(0.004)
            seen.append(between_pads(robot))
            angle = robot.joint_state.position["finger_joint"]
            assert abs(seen[-1] - robot.gripper.geometry.opening(angle)) <= 5e-4
    assert np.ptp(seen) >= 0.084
