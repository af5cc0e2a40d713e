"""A real robot and a network that fails: it comes to rest, and nothing resumes."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import textwrap
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing

import pytest
from link_proxy import End, LinkProxy
from raises_naming import raises_naming
from real_robot_rig import RealRobotRig, real_robot
from ros import Bringup
from waits import until

import tool0
from tool0.engines.real_robot.engine import LOST
from tool0.errors import ControlError
from tool0.protocol.goals import GoalStatus

PAN = "shoulder_pan_joint"
LONGEST = 0.6
"""From a cut to rest on a busy machine [s]; benchmarks/real_robot.py measures it."""


pytestmark = pytest.mark.flaky(reruns=3)  # three programs in real time on two cores


@pytest.fixture(scope="module")
def rig() -> Iterator[RealRobotRig]:
    with real_robot() as made:
        yield made


def is_connected(rig: RealRobotRig) -> bool:
    link = rig.state.link
    return link is not None and link.is_connected


def rests_after(twin: tool0.Robot, cut: Callable[[], None]) -> float:
    """Return the simulated time from a cut until the robot rests for a while [s]."""
    states = twin.subscribe(rate=125)
    cut()
    start, moved = twin.time, twin.time
    while twin.time < moved + 0.5:
        state = states.next(5.0)
        assert state is not None
        if abs(state.velocity[state.joint_names.index(PAN)]) > 0.01:
            moved = state.time
        assert moved - start < 5.0, "it does not come to rest"
    states.close()
    return moved - start


FAULTS: Mapping[str, Callable[[LinkProxy], None]] = {
    "cable pulled": LinkProxy.hold,
    "connections reset": LinkProxy.cut,
    "clients told of an end": lambda proxy: proxy.half_close(End.CLIENT),
    "servers told of an end": lambda proxy: proxy.half_close(End.SERVER),
}
LASTING = {"cable pulled", "connections reset"}
"""Those that keep new connections away."""


@pytest.mark.parametrize("fault", FAULTS)
def test_a_lost_link_brings_the_arm_to_rest_for_good(
    rig: RealRobotRig, fault: str
) -> None:
    rig.enable()
    with rig.twin() as twin:
        here = rig.robot.joint_state.position[PAN]
        (goal,) = rig.robot.move_joints({PAN: here + 1.5}, speed=0.15)
        until(lambda: twin.joint_state.velocity[PAN] > 0.2, "motion")
        assert rests_after(twin, lambda: FAULTS[fault](rig.proxy)) < LONGEST
        place = twin.joint_state.position[PAN]
        assert place < here + 1.4
        until(lambda: LOST in rig.state.motion_failure, "the loss")
        assert goal.wait(10.0).status is not GoalStatus.SUCCEEDED
        if fault in LASTING:
            with raises_naming(ControlError, "not reached", "network"):
                rig.robot.move_joints({PAN: 0.0})
        rig.proxy.mend()
        until(lambda: is_connected(rig), "the link")
        with raises_naming(ControlError, "only reads", "enable"):
            rig.robot.move_joints({PAN: 0.0})
        assert twin.joint_state.position[PAN] == pytest.approx(place, abs=1e-3)
        assert rig.robot.joint_state.position[PAN] == pytest.approx(place, abs=2e-3)


def test_a_link_that_is_too_slow_for_the_states_stops_the_arm(
    rig: RealRobotRig,
) -> None:
    rig.enable()
    with rig.twin() as twin:
        here = rig.robot.joint_state.position[PAN]
        (goal,) = rig.robot.move_joints({PAN: here - 1.5}, speed=0.15)
        until(lambda: twin.joint_state.velocity[PAN] < -0.2, "motion")
        assert rests_after(twin, lambda: throttle(rig.proxy)) < 2.0 * LONGEST
        place = twin.joint_state.position[PAN]
        assert place > here - 1.4
        assert goal.wait(10.0).status is not GoalStatus.SUCCEEDED
        rig.proxy.cut()
        until(lambda: not is_connected(rig), "the loss")
        rig.proxy.rate = math.inf
        rig.proxy.mend()
        until(lambda: is_connected(rig), "the link")
        with raises_naming(ControlError, "only reads", "enable"):
            rig.robot.move_joints({PAN: 0.0})
        assert twin.joint_state.position[PAN] == pytest.approx(place, abs=1e-3)


def throttle(proxy: LinkProxy) -> None:
    proxy.rate = 20e3  # a seventh of what the states need


def test_a_slow_network_does_not_stop_a_motion(rig: RealRobotRig) -> None:
    rig.enable()
    rig.proxy.delay, rig.proxy.jitter = 0.01, 0.03
    (goal,) = rig.robot.move_joints({PAN: 0.0}, speed=0.3)
    assert goal.wait(60.0).status is GoalStatus.SUCCEEDED, rig.state.motion_failure
    rig.proxy.delay = rig.proxy.jitter = 0.0
    with rig.twin() as twin:
        until(lambda: abs(twin.joint_state.position[PAN]) < 2e-3, "the goal")


def test_a_gripper_that_is_unplugged_is_told_and_left_alone(rig: RealRobotRig) -> None:
    ensure_enabled(rig)
    gripper = rig.robot.gripper
    gripper.move(opening=0.05)
    assert gripper.wait(10.0).motion == "at_target"
    rig.proxy.cut(63352)
    until(lambda: "63352" in gripper_problem(rig), "the loss")
    with raises_naming(ControlError, "the gripper does not move", "63352"):
        gripper.move(opening=0.02)
    (goal,) = rig.robot.move_joints({PAN: 0.1}, speed=0.3)  # the arm still does
    assert goal.wait(30.0).status is GoalStatus.SUCCEEDED
    rig.proxy.mend()
    until(lambda: not gripper_problem(rig), "the gripper")
    assert gripper.opening == pytest.approx(0.05, abs=2e-3)
    gripper.move(opening=0.02)
    assert gripper.wait(10.0).motion == "at_target"


def test_a_gripper_without_power_is_told(rig: RealRobotRig) -> None:
    rig.box.power_off()
    until(lambda: "no power" in gripper_problem(rig), "the loss of power")
    with raises_naming(ControlError, "the gripper does not move", "switch the robot"):
        rig.robot.gripper.move(opening=0.06)
    rig.box.release_brakes()
    until(lambda: "not activated" in gripper_problem(rig), "power")


def gripper_problem(rig: RealRobotRig) -> str:
    link = rig.state.link
    assert link is not None
    return link.gripper_problem


def ensure_enabled(rig: RealRobotRig) -> None:
    link = rig.state.link
    assert link is not None
    if not link.is_enabled:
        rig.enable()


def test_a_robot_that_was_restarted_is_only_read() -> None:
    with real_robot() as rig:
        rig.enable()
        options = ("--ur", "--ur-active-gripper", "--arm", "ur5", "--ur-host", rig.host)
        rig.simulated.close()
        until(lambda: not is_connected(rig), "the loss")
        before = rig.robot.time
        with closing(Bringup(os.environ, *options)) as again:
            again.wait()
            until(lambda: is_connected(rig), "the link")
            until(lambda: rig.robot.time > before + 0.5, "states")
            with raises_naming(ControlError, "only reads", "enable"):
                rig.robot.move_joints({PAN: 0.0})
            rig.enable()
            (goal,) = rig.robot.move_joints({PAN: 0.2}, speed=0.3)
            assert goal.wait(30.0).status is GoalStatus.SUCCEEDED


def test_the_arm_rests_when_tool0_is_killed() -> None:
    with real_robot() as rig:
        rig.robot.close()
        program = f"""
            import tool0
            with tool0.bringup(arm="ur5", hardware="{rig.host}") as robot:
                box = robot.arm.control_box
                box.enable_motion(box.state.link.serial_number)
                robot.move_joints({{"{PAN}": 2.0}}, speed=0.5)[0].wait()
        """
        client = subprocess.Popen([sys.executable, "-c", textwrap.dedent(program)])
        with rig.twin() as twin:
            until(lambda: twin.joint_state.velocity[PAN] > 0.1, "motion")
            assert rests_after(twin, client.kill) < LONGEST
            assert twin.joint_state.position[PAN] < 1.9
        client.wait()
