import math
import os
import socket
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from fake_robot import ABORTED, ARM, GRIPPED, SUCCEEDED, FakeGripper, FakeRobot
from served import serving, use_folder
from tool0.interfaces.socket.client import RemoteRobot

from tool0.control.goal import GoalStatus
from tool0.control.trajectory import TrajectoryPoint
from tool0.errors import (
    ControlError,
    GoalRejectedError,
    GoalTimeoutError,
    ModelError,
    TransportError,
)

POINT = TrajectoryPoint([0.0, -1.0, 1.0], time_from_start=2.0)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return use_folder(monkeypatch, tmp_path)


@pytest.fixture
def robot() -> FakeRobot:
    return FakeRobot()


@pytest.fixture
def remote(robot: FakeRobot) -> Iterator[RemoteRobot]:
    with serving(robot), RemoteRobot() as remote:
        yield remote


def test_finds_the_process(remote: RemoteRobot) -> None:
    assert (remote.name, remote.pid) == ("tool0", os.getpid())


def test_state_is_the_robot_s(robot: FakeRobot, remote: RemoteRobot) -> None:
    state = remote.joint_state
    assert state.time == remote.time == robot.time
    assert state.position == robot.joint_state.position
    assert state.velocity == robot.joint_state.velocity
    assert state.effort == robot.joint_state.effort
    assert (state.is_paused, state.fault) == (False, None)
    assert remote.summary() == robot.summary()


def test_controllers_are_the_robot_s(robot: FakeRobot, remote: RemoteRobot) -> None:
    fields = ("name", "type", "state", "claimed")
    for near, far in zip(robot.controllers(), remote.controllers(), strict=True):
        assert [getattr(near, f) for f in fields] == [getattr(far, f) for f in fields]


def test_every_verb_reaches_the_robot(robot: FakeRobot, remote: RemoteRobot) -> None:
    remote.load("a")
    remote.unload("b")
    remote.switch(["a"], ["b", "c"], strict=False)
    remote.pause()
    remote.step(5)
    remote.resume()
    remote.reset()
    remote.emergency_stop(engaged=True)
    remote.emergency_stop(engaged=False)
    assert robot.calls == [
        ("load", "a"),
        ("unload", "b"),
        ("switch", (("a",), ("b", "c"), False)),
        ("pause", None),
        ("step", 5),
        ("resume", None),
        ("reset", None),
        ("estop", True),
        ("estop", False),
    ]


def test_a_trajectory_arrives_whole(robot: FakeRobot, remote: RemoteRobot) -> None:
    points = [
        TrajectoryPoint([0.0, 0.1, 0.2], [0.1] * 3, [0.0] * 3, time_from_start=1.0),
        POINT,
    ]
    asked = {
        "joint_names": ARM,
        "stamp": 12.5,
        "path_tolerance": {"elbow_joint": 0.1},
        "goal_tolerance": {"elbow_joint": -1.0},
        "goal_time_tolerance": 0.5,
    }
    goal = remote.controller("arm_controller").follow(points, **asked)  # type: ignore[arg-type]
    assert goal.wait(timeout=10.0) == goal.result == SUCCEEDED
    assert robot.calls == [("arm_controller", {"points": tuple(points), **asked})]


def test_what_is_left_out_stays_out(robot: FakeRobot, remote: RemoteRobot) -> None:
    remote.controller("arm_controller").follow([])
    ((_, asked),) = robot.calls
    assert asked.pop("points") == ()
    assert set(asked.values()) == {None}


def test_query_state_gives_the_point(robot: FakeRobot, remote: RemoteRobot) -> None:
    near = robot.controller("arm_controller").query_state(1.0)
    assert remote.controller("arm_controller").query_state(1.0) == near


def test_outcomes_are_values(robot: FakeRobot, remote: RemoteRobot) -> None:
    robot.outcome = ABORTED
    assert remote.controller("arm_controller").follow([POINT]).wait() == ABORTED
    robot.outcome = GRIPPED
    assert remote.gripper.move(opening=0.04, effort=5.0).wait() == GRIPPED
    asked = {"opening": 0.04, "speed": None, "force": None, "effort": 5.0}
    assert robot.calls[-1] == ("jaw_controller", asked)


def test_what_a_gripper_does_is_told_with_the_state_and_alone(
    robot: FakeRobot, remote: RemoteRobot
) -> None:
    near = robot.gripper.state
    far = remote.gripper.wait(timeout=1.0)
    assert (far.motion, far.opening, far.width, far.gobj) == (
        near.motion,
        near.opening,
        near.width,
        near.gobj,
    )
    assert remote.joint_state.grippers == {"jaw": far}


@pytest.mark.parametrize("opening", [0.0, 0.02, 0.085])
def test_a_gripper_position_is_its_opening(
    opening: float, robot: FakeRobot, remote: RemoteRobot
) -> None:
    position = FakeGripper.geometry.position(opening)
    remote.gripper.move(position=position)
    assert math.isclose(robot.calls[-1][1]["opening"], opening, abs_tol=1e-12)


def test_the_open_end_of_the_joint_is_fully_open(
    robot: FakeRobot, remote: RemoteRobot
) -> None:
    remote.gripper.move(position=0.0)
    assert robot.calls[-1][1]["opening"] == FakeGripper.geometry.max_opening


@pytest.mark.parametrize("position", [-0.1, 0.9, 4.5, 2 * math.pi, math.nan])
def test_a_gripper_position_out_of_reach_is_refused(
    position: float, robot: FakeRobot, remote: RemoteRobot
) -> None:
    with pytest.raises(ModelError, match="outside"):
        remote.gripper.move(position=position)
    assert robot.calls == []


def test_opening_and_position_exclude_each_other(remote: RemoteRobot) -> None:
    with pytest.raises(TransportError, match=r"'opening' .* or 'position'"):
        remote.gripper.move(opening=0.01, position=0.1)
    with pytest.raises(TransportError, match=r"'opening' .* or 'position'"):
        remote.gripper.move()


def test_an_error_is_raised_here_as_it_was_there(remote: RemoteRobot) -> None:
    arm = remote.controller("arm_controller")
    with pytest.raises(GoalRejectedError, match="did you mean 'elbow_joint'") as caught:
        arm.follow([POINT], joint_names=["elbow"])
    assert caught.value.code == GoalRejectedError.INVALID_JOINTS
    with pytest.raises(GoalRejectedError, match="NaN"):
        arm.follow([TrajectoryPoint([math.nan] * 3)])
    with pytest.raises(ControlError, match="did you mean 'arm_controller'"):
        remote.controller("arm_control").follow([POINT])
    assert remote.time > 0.0


def test_waiting_can_time_out_and_go_on(robot: FakeRobot, remote: RemoteRobot) -> None:
    robot.outcome = None
    goal = remote.controller("arm_controller").follow([POINT])
    with pytest.raises(GoalTimeoutError):
        goal.wait(timeout=0.0)
    assert goal.status is GoalStatus.ACTIVE
    assert goal.result is None
    robot.goals[0].goal.finish(SUCCEEDED)
    assert goal.wait(timeout=10.0) == SUCCEEDED


def test_a_cancel_ends_the_wait(robot: FakeRobot, remote: RemoteRobot) -> None:
    robot.outcome = None
    goal = remote.controller("arm_controller").follow([POINT])
    with pytest.raises(GoalTimeoutError):
        goal.wait(timeout=0.0)
    goal.cancel()
    assert goal.wait(timeout=10.0).status is GoalStatus.PREEMPTED


def test_a_wait_ends_when_the_bringup_does(robot: FakeRobot) -> None:
    robot.outcome = None
    with serving(robot) as server:
        remote = RemoteRobot()
        goal = remote.controller("arm_controller").follow([POINT])
        closer = threading.Thread(target=server.close)
        closer.start()
        with pytest.raises(TransportError, match=r"ended|gone"):
            goal.wait(timeout=10.0)
        closer.join()
        with pytest.raises(TransportError, match=r"ended|gone"):
            remote.pause()
        remote.close()


def test_nobody_there_says_what_to_do() -> None:
    with pytest.raises(
        TransportError, match=r"no bringup named 'tool0' .*`tool0 bring"
    ):
        RemoteRobot()


def test_nobody_there_names_those_that_are(robot: FakeRobot) -> None:
    with serving(robot, "left"), pytest.raises(TransportError, match="running: left"):
        RemoteRobot("right")


def test_the_socket_of_a_dead_process_counts_as_nobody(folder: Path) -> None:
    folder.mkdir(mode=0o700)
    with socket.socket(socket.AF_UNIX) as dead:
        dead.bind(str(folder / "tool0.sock"))
    with pytest.raises(TransportError, match="no bringup named 'tool0'"):
        RemoteRobot()


def test_two_bringups_are_told_apart() -> None:
    left, right = FakeRobot(time=1.0), FakeRobot(time=2.0)
    with (
        serving(left, "left"),
        serving(right, "right"),
        RemoteRobot("left") as near,
        RemoteRobot("right") as far,
    ):
        assert (near.time, far.time) == (1.0, 2.0)
