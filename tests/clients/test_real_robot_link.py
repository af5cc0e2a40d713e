"""A real robot and a network that fails: it comes to rest, and nothing resumes."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap
from collections.abc import Callable, Iterator
from contextlib import closing

import pytest
from raises_naming import raises_naming
from real_robot_rig import RealRobotRig, real_robot
from ros import Bringup
from waits import until

import tool0
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


@pytest.mark.parametrize("fault", ["hold", "cut"])
def test_a_lost_link_brings_the_arm_to_rest_for_good(
    rig: RealRobotRig, fault: str
) -> None:
    """``hold`` is a pulled cable, ``cut`` resets the connections."""
    rig.enable()
    with rig.twin() as twin:
        here = rig.robot.joint_state.position[PAN]
        (goal,) = rig.robot.move_joints({PAN: here + 1.5}, speed=0.15)
        until(lambda: twin.joint_state.velocity[PAN] > 0.2, "motion")
        assert rests_after(twin, getattr(rig.proxy, fault)) < LONGEST
        place = twin.joint_state.position[PAN]
        assert place < here + 1.4
        until(lambda: not is_connected(rig), "the loss")
        assert goal.wait(10.0).status is not GoalStatus.SUCCEEDED
        assert "connection to the robot was lost" in rig.state.motion_failure
        with raises_naming(ControlError, "not reached", "network"):
            rig.robot.move_joints({PAN: 0.0})
        rig.proxy.mend()
        until(lambda: is_connected(rig), "the link")
        until(lambda: rig.robot.time > 1.0, "states")
        with raises_naming(ControlError, "only reads", "enable"):
            rig.robot.move_joints({PAN: 0.0})
        assert twin.joint_state.position[PAN] == pytest.approx(place, abs=1e-3)
        assert rig.robot.joint_state.position[PAN] == pytest.approx(place, abs=2e-3)


def test_a_slow_network_does_not_stop_a_motion(rig: RealRobotRig) -> None:
    rig.enable()
    rig.proxy.jitter = 0.03
    (goal,) = rig.robot.move_joints({PAN: 0.0}, speed=0.3)
    assert goal.wait(60.0).status is GoalStatus.SUCCEEDED, rig.state.motion_failure
    rig.proxy.jitter = 0.0
    with rig.twin() as twin:
        until(lambda: abs(twin.joint_state.position[PAN]) < 2e-3, "the goal")


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
