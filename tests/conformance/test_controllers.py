"""Every type of controller on the real arm, by every interface."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from conformance_types import BringUp
from flat_options import configured
from ur5_rig import ARM_JOINTS, AWAY, HOME, point, positions

import tool0
from tool0.errors import ControlError

INTERFACES = {
    "effort": "hardware_interface/EffortJointInterface",
    "position": "hardware_interface/PositionJointInterface",
    "velocity": "hardware_interface/VelocityJointInterface",
}
JOINTS = ", ".join(ARM_JOINTS)
GAINS = {  # effort needs torque, velocity only a rate per error
    "effort": "{p: 2000, i: 100, d: 40, i_clamp: 60}",
    "velocity": "{p: 20, i: 0, d: 0}",
}


def write_yaml(folder: Path, interface: str) -> Path:
    """Write all types that fit the interface; the names say what they are."""
    lines = [
        "states: {type: joint_state_controller/JointStateController, publish_rate: 50}",
        "trajectory:",
        f"  type: {interface}_controllers/JointTrajectoryController",
        f"  joints: [{JOINTS}]",
        "  stop_trajectory_duration: 0.2",
        "group:",
        f"  type: {interface}_controllers/JointGroup{interface.title()}Controller",
        f"  joints: [{JOINTS}]",
        "single:",
        f"  type: {interface}_controllers/Joint{interface.title()}Controller",
        "  joint: wrist_3_joint",
    ]
    if interface == "velocity":
        lines[5:5] = [
            "  velocity_ff: {" + ", ".join(f"{j}: 1.0" for j in ARM_JOINTS) + "}"
        ]
    if interface in GAINS:
        gains = ", ".join(f"{joint}: {GAINS[interface]}" for joint in ARM_JOINTS[:4])
        small = "{p: 50, d: 0.5}" if interface == "effort" else GAINS[interface]
        weak = ", ".join(f"{joint}: {small}" for joint in ARM_JOINTS[4:])
        lines[5:5] = ["  gains: {" + gains + ", " + weak + "}"]
    path = folder / f"{interface}.yaml"
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture(scope="module", params=INTERFACES)
def interface(request: pytest.FixtureRequest) -> str:
    name: str = request.param
    return name


@pytest.fixture(scope="module")
def shared_robot(
    engine: str, interface: str, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[tool0.Robot]:
    """Bring a robot up, for all tests of an interface."""
    options = configured(
        engine=engine,
        realtime=False,
        controllers_file=write_yaml(tmp_path_factory.mktemp("yaml"), interface),
        controllers="states trajectory",
        stopped_controllers="group single",
        transmission_hw_interface=INTERFACES[interface],
    )
    with tool0.bringup(**options) as robot:
        yield robot


@pytest.fixture
def robot(shared_robot: tool0.Robot) -> tool0.Robot:
    """Return it as if just brought up, with its trajectory controller running."""
    robot = shared_robot
    running = {status.name for status in robot.controllers() if status.is_running}
    robot.switch(stop=sorted(running & {"trajectory", "group", "single"}))
    robot.reset()
    robot.switch(start=["trajectory"])
    return robot


def test_each_claims_its_joints_by_its_interface(
    robot: tool0.Robot, interface: str
) -> None:
    status = {item.name: item for item in robot.controllers()}
    assert status["states"].claimed == ()
    for name in ("trajectory", "group"):
        assert status[name].claimed == ((INTERFACES[interface], ARM_JOINTS),)
    assert status["single"].claimed == ((INTERFACES[interface], ("wrist_3_joint",)),)


def test_a_trajectory_controller_arrives_by_every_interface(
    robot: tool0.Robot,
) -> None:
    for target in (AWAY, HOME):
        goal = robot.controller("trajectory").follow([point(target, 1.5, [0.0] * 6)])
        robot.run(1.5)
        robot.run(0.5)
        # A steady droop remains of the effort controller alone.
        assert positions(robot)[:6] == pytest.approx(target, abs=0.02)
        assert goal.status in (
            tool0.GoalStatus.SUCCEEDED,
            tool0.GoalStatus.ABORTED,  # effort: its velocity tolerance is 0.01 rad/s
        )


@pytest.mark.parametrize("interface", ["position", "velocity"], indirect=True)
def test_servos_track_to_two_milliradians(robot: tool0.Robot) -> None:
    arm = robot.controller("trajectory")
    goal = arm.follow([point(AWAY, 1.0, [0.0] * 6), point(HOME, 2.0, [0.0] * 6)])
    worst = 0.0
    while not goal.status.is_terminal:
        robot.run(0.005)
        worst = max(worst, *map(abs, arm.state.error.positions))
    assert goal.status is tool0.GoalStatus.SUCCEEDED
    assert worst <= 2e-3


@pytest.mark.parametrize("interface", ["position"], indirect=True)
def test_a_group_of_positions_goes_where_it_is_told(robot: tool0.Robot) -> None:
    robot.switch(start=["group"], stop=["trajectory"])
    robot.run(1.0)
    assert positions(robot)[:6] == pytest.approx(HOME, abs=1e-3)
    there = (1.0, *HOME[1:5], 1.5)
    robot.controller("group").command(there)
    speeds = []
    for _ in range(100):
        robot.run(0.01)
        speeds.append(max(map(abs, robot.joint_state.velocity.values())))
    assert 3.0 < max(speeds) < 3.14 * 1.25  # at its speed limit: it did not jump
    robot.controller("group").command(AWAY)
    robot.run(3.0)
    assert positions(robot)[:6] == pytest.approx(AWAY, abs=1e-3)


@pytest.mark.parametrize("interface", ["velocity"], indirect=True)
def test_a_group_of_velocities_turns_as_it_is_told(robot: tool0.Robot) -> None:
    robot.switch(start=["group"], stop=["trajectory"])
    wanted = [0.2, 0.1, -0.1, 0.2, -0.3, 0.5]
    robot.controller("group").command(wanted)
    robot.run(1.0)
    speeds = list(robot.joint_state.velocity.values())[:6]
    assert speeds == pytest.approx(wanted, abs=0.01)
    robot.controller("group").command([0.0] * 6)
    robot.run(1.5)
    assert max(map(abs, robot.joint_state.velocity.values())) < 1e-3


@pytest.mark.parametrize("interface", ["effort"], indirect=True)
def test_a_group_of_efforts_pushes_as_it_is_told(robot: tool0.Robot) -> None:
    robot.switch(start=["group"], stop=["trajectory"])
    robot.controller("group").command([0.0, -40.0, -12.0, 0.0, 0.0, 0.5])
    robot.run(0.005)  # before a wrist comes to its speed limit
    effort = list(robot.joint_state.effort.values())[:6]
    assert effort == pytest.approx([0.0, -40.0, -12.0, 0.0, 0.0, 0.5])


def test_a_single_joint_leaves_the_others_braked(
    robot: tool0.Robot, interface: str
) -> None:
    robot.switch(start=["single"], stop=["trajectory"])
    robot.run(0.5)
    before = positions(robot)[:6]
    robot.controller("single").command(
        {"position": 0.5, "velocity": 0.5, "effort": 0.2}[interface]
    )
    robot.run(1.0)
    after = positions(robot)[:6]
    assert after[5] > 0.4
    assert np.abs(after - before)[:5].max() <= 1e-3


def test_set_points_are_checked_and_the_old_ones_stay(
    robot: tool0.Robot, interface: str
) -> None:
    robot.switch(start=["group"], stop=["trajectory"])
    group = robot.controller("group")
    for bad in ([0.0] * 5, [0.0] * 7, [float("nan")] * 6, [float("inf")] * 6, []):
        with pytest.raises(ControlError):
            group.command(bad)
    robot.run(0.5)
    assert positions(robot)[:6] == pytest.approx(HOME, abs=1e-2)


@pytest.mark.parametrize("wrong", ["position", "velocity"])
def test_a_controller_for_another_interface_is_refused_when_loaded(
    bring_up: BringUp, tmp_path: Path, wrong: str
) -> None:
    with pytest.raises(tool0.Tool0Error) as error:
        bring_up(controllers_file=write_yaml(tmp_path, wrong), controllers="trajectory")
    assert wrong in str(error.value)
