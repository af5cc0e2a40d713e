"""Arms that a program takes: from its controllers and back, and what moves them."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest

import tool0
from tool0.control.arm.model import Placement
from tool0.description.config import DescriptionConfig
from tool0.errors import ControlError, RequestError
from tool0.protocol.arm_motion import ServoJoints, StartForceMode
from tool0.protocol.control_box_state import RobotMode
from tool0.protocol.controllers import Role
from tool0.scene import Box
from tool0.simulation.config import ControlConfig, SimulationConfig

DOWN = (0.0, -1.57, 1.57, -1.57, -1.57, 0.0)
REST = ((0.0,) * 6,)
Z = (False, False, True, False, False, False)
CELL = DescriptionConfig(robots=("left=ur5e", "right=ur3e+hande@1,0,0"))


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(gripper=None, realtime=False) as robot:
        robot.run(0.3)  # until it stands still
        yield robot


def states(robot: tool0.Robot) -> dict[str, str]:
    return {status.name: status.state for status in robot.controllers()}


def move(robot: tool0.Robot, positions: tuple[float, ...], duration: float) -> None:
    """Move the taken arm and wait."""
    motion = robot.arm.motion
    motion.execute_path([duration], [positions], REST)
    robot.run(duration + 0.1)
    assert motion.state.is_done


def test_a_taken_arm_is_moved_by_a_controller_of_its_own(robot: tool0.Robot) -> None:
    """Although the drives of the default robot only offer efforts."""
    before = states(robot)
    motion = robot.arm.motion
    assert motion.state.mode == "free"
    motion.take("test")
    motion.take("another name")
    assert robot.arm.control_box.state.taken_by == "another name"
    assert states(robot) == {
        **before,
        "eff_joint_traj_controller": "stopped",
        "arm_motion": "running",
    }
    status = next(item for item in robot.controllers() if item.name == "arm_motion")
    assert status.type == "tool0/ArmMotionController"
    assert status.role is Role.MOTION
    assert status.joints == set(robot.arm.joint_names)
    assert motion.state.mode == "hold"
    motion.release()
    motion.release()
    assert states(robot) == before
    assert robot.arm.control_box.state.taken_by == ""


def test_only_a_program_can_start_and_stop_it(robot: tool0.Robot) -> None:
    robot.arm.motion.take()
    with pytest.raises(ControlError, match=r"tool0's own.*return_arm"):
        robot.switch(stop=["arm_motion"])
    with pytest.raises(ControlError, match="'Python' moves the arm 'arm'"):
        robot.switch(start=["eff_joint_traj_controller"])
    with pytest.raises(ControlError, match="already loaded"):
        robot.load("arm_motion")
    with pytest.raises(ControlError, match="still running"):
        robot.unload("arm_motion")
    assert states(robot)["arm_motion"] == "running"


def test_what_is_not_taken_cannot_be_moved(robot: tool0.Robot) -> None:
    motion = robot.arm.motion
    for refused in (
        lambda: motion.execute_path([1.0], [DOWN], REST),
        lambda: motion.servo_joints(DOWN),
        motion.stop,
        motion.start_freedrive,
    ):
        with pytest.raises(ControlError, match="no program moves the arm 'arm'"):
            refused()
    robot.emergency_stop()
    with pytest.raises(ControlError, match="emergency stop"):
        motion.take()


def test_wrong_values_are_refused_with_what_would_be_right(
    robot: tool0.Robot,
) -> None:
    motion = robot.arm.motion
    motion.take()
    with pytest.raises(RequestError, match="'after' and 'at' need each other"):
        motion.execute_path([1.0], [DOWN], REST, after=1)
    with pytest.raises(ControlError, match=r"path 1 is not executed.*none"):
        motion.execute_path([1.0], [DOWN], REST, after=1, at=0.5)
    with pytest.raises(RequestError, match="positions"):
        motion.servo_joints(DOWN[:5])
    with pytest.raises(RequestError, match="gain"):
        motion.servo_joints(DOWN, gain=10.0)
    with pytest.raises(ControlError, match=r"elbow_joint' is beyond its limits \["):
        motion.servo_joints((0.0, 0.0, 4.0, 0.0, 0.0, 0.0))
    with pytest.raises(ControlError, match="beyond its limits ±"):
        motion.speed_joints((9.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    with pytest.raises(RequestError, match="limits"):
        motion.start_force_mode((0.0,) * 6, Z, limits=(0.0,) * 6)
    assert motion.state.mode == "hold"


def test_the_setpoint_is_continuous_from_mode_to_mode(robot: tool0.Robot) -> None:
    motion = robot.arm.motion
    motion.take()
    start = np.array(motion.state.setpoint.positions)
    last = motion.state
    steps = {
        0: lambda: motion.execute_path([1.0], [start + 0.4], REST),
        20: lambda: motion.servo_joints(tuple(start + 0.1)),
        40: lambda: motion.speed_joints((0.2, -0.2, 0.1, 0.0, 0.3, 0.0), 2.0),
        60: lambda: motion.speed_tool((0.05, 0.0, 0.1, 0.0, 0.0, 0.0), 0.5),
        80: lambda: motion.execute_path([0.5], [start], REST),
        90: lambda: motion.stop(5.0),
    }
    modes = []
    for k in range(130):
        if k in steps:
            steps[k]()
            assert motion.state.setpoint.positions == last.setpoint.positions
            modes.append(motion.state.mode)
        robot.run(0.01)
        now = motion.state
        moved = np.subtract(now.setpoint.positions, last.setpoint.positions)
        mean = np.add(now.setpoint.velocities, last.setpoint.velocities) / 2
        assert np.abs(moved - 0.01 * mean).max() < 40.0 * 0.01**2
        last = now
    assert modes == ["path", "servo", "speed", "speed", "path", "stop"]
    assert last.is_done
    assert not any(last.setpoint.velocities)
    position = [robot.snapshot.positions[name] for name in robot.arm.joint_names]
    assert position == pytest.approx(last.setpoint.positions, abs=1e-3)


@pytest.mark.slow
def test_a_velocity_of_the_tool_moves_it_straight(robot: tool0.Robot) -> None:
    """Ramps of 0.24 s before and after 1 s with the twist of a point off the flange."""
    motion = robot.arm.motion
    motion.take()
    move(robot, DOWN, 2.0)
    model = robot.simulation.core.arms.find("arm").motion.spec.model
    lever = np.array([0.05, 0.0, 0.1])

    def tcp() -> Placement:
        return model.place(np.array(motion.state.setpoint.positions), lever)

    before = tcp()
    tool = (*lever, 0.0, 0.0, 0.0)
    motion.speed_tool((0.06, 0.08, 0.05, 0.0, 0.0, 0.12), 0.5, 1.0, tcp=tool)
    robot.run(1.5)
    after = tcp()
    moved = after.position - before.position
    assert moved == pytest.approx([0.06, 0.08, 0.05], abs=1e-5)
    R = after.rotation @ before.rotation.T
    assert math.atan2(R[1, 0], R[0, 0]) == pytest.approx(0.12, abs=1e-5)
    assert R[2] == pytest.approx([0.0, 0.0, 1.0], abs=1e-5)
    assert motion.state.setpoint.velocities == pytest.approx((0.0,) * 6, abs=1e-12)


def test_paths_are_executed_by_the_kernel(robot: tool0.Robot) -> None:
    motion, core = robot.arm.motion, robot.simulation.core
    motion.take()
    assert core.program() is None  # the first tick is Python's
    robot.run(0.01)
    assert core.program() is not None
    number = motion.execute_path([1.0], [DOWN], REST)
    robot.run(0.01)
    assert core.program() is not None
    again = motion.execute_path([1.0], [DOWN], REST, after=number, at=0.7)
    assert (number, again) == (1, 2)
    robot.run(0.5)
    assert core.program() is not None
    assert motion.state.path == 1
    assert motion.state.path_time == pytest.approx(0.51)
    motion.servo_joints(DOWN)
    assert core.program() is None


def test_an_arm_that_moves_stops_before_it_is_released(robot: tool0.Robot) -> None:
    motion = robot.arm.motion
    motion.take()
    motion.execute_path([1.0], [DOWN], REST)
    robot.run(0.5)
    motion.release()
    assert states(robot)["arm_motion"] == "running"
    with pytest.raises(ControlError, match="stops and is released"):
        motion.servo_joints(DOWN)
    robot.run(0.5)
    assert "arm_motion" not in states(robot)
    assert states(robot)["eff_joint_traj_controller"] == "running"
    motion.take()
    motion.speed_joints((0.5, 0, 0, 0, 0, 0), 10.0)
    robot.run(0.2)
    motion.release()
    robot.reset()  # which ends the motion
    robot.run(0.01)
    assert states(robot)["eff_joint_traj_controller"] == "running"
    motion.take()
    motion.speed_joints((0.5, 0, 0, 0, 0, 0), 10.0)
    robot.run(0.2)
    motion.release()
    motion.take()  # which ends the return
    robot.run(1.0)
    assert motion.state.mode == "stop"
    assert states(robot)["arm_motion"] == "running"


def test_stops_end_a_motion(robot: tool0.Robot) -> None:
    motion, box = robot.arm.motion, robot.arm.control_box
    motion.take()
    motion.execute_path([1.0], [DOWN], REST)
    robot.run(0.4)
    robot.emergency_stop()
    robot.run(0.3)
    robot.emergency_stop(False)
    robot.run(0.1)
    assert motion.state.mode == "hold"
    assert motion.state.path == 0  # its path is not executed any more
    for again in (
        lambda: motion.execute_path([1.0], [DOWN], REST),
        lambda: motion.servo_joints(DOWN),
    ):
        with pytest.raises(ControlError, match=r"emergency stop was engaged; take it"):
            again()
    motion.take()
    motion.execute_path([1.0], [DOWN], REST)
    robot.run(0.2)
    box.stop_protectively("test")
    assert motion.state.mode == "free"
    assert "arm_motion" not in states(robot)
    robot.run(0.5)
    assert max(map(abs, robot.snapshot.velocity)) < 1e-3


def test_a_reset_ends_a_motion(robot: tool0.Robot) -> None:
    motion = robot.arm.motion
    motion.take()
    for start in (
        lambda: motion.execute_path([1.0], [DOWN], REST),
        lambda: motion.servo_joints(DOWN),
        motion.start_freedrive,
    ):
        start()
        robot.run(0.2)
        robot.reset()
        robot.run(0.1)
        assert motion.state.mode == "hold"
        assert robot.arm.control_box.state.robot_mode is RobotMode.RUNNING


def test_the_arms_of_a_cell_are_taken_one_by_one() -> None:
    with tool0.bringup(description=CELL, realtime=False) as robot:
        left, right = robot.arms["left"].motion, robot.arms["right"].motion
        left.take()
        running = {s.name for s in robot.controllers() if s.is_running}
        assert "left_arm_motion" in running
        assert any(name.startswith("right") for name in running)
        right.take()
        start = np.array(right.state.setpoint.positions)
        assert left.execute_path([0.5], [np.add(DOWN, 0.1)], REST) == 1
        right.speed_joints((0.1,) * 6, 1.0)
        robot.run(0.3)
        assert left.state.mode == "path"
        assert right.state.mode == "speed"
        moved = np.subtract(right.state.setpoint.positions, start)
        assert moved == pytest.approx(0.1 * 0.3 - 0.005)
        left.release()
        robot.run(0.4)
        assert left.state.mode == "free"
        assert right.state.mode == "speed"
        with pytest.raises(ControlError, match="left, right"):
            robot.channel.call(ServoJoints(positions=DOWN))


# ---- forces ------------------------------------------------------------------------


def force_on(robot: tool0.Robot, name: str) -> float:
    """Return the downward force on an object [N]."""
    contacts = robot.simulation.loop.call(robot.simulation.engine.world.contacts)
    signs = [(c.force[2], (c.second == name) - (c.first == name)) for c in contacts]
    return -sum(force * sign for force, sign in signs)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("force", "options"),
    [
        (5.0, {}),
        (20.0, {"control": ControlConfig(control_period=0.008)}),
        (50.0, {"control": ControlConfig(control_period=0.002), "ros2_control": True}),
        (10.0, {"simulation": SimulationConfig(dt=0.002)}),
    ],
    ids=["1 kHz", "125 Hz", "ROS 2", "steps of 2 ms"],
)
def test_force_mode_holds_a_force_on_a_table(
    force: float, options: dict[str, object]
) -> None:
    """From free air: within the speed limit, without lifting off again."""
    with tool0.bringup(gripper=None, realtime=False, **options) as robot:
        motion = robot.arm.motion
        with motion.taken():
            move(robot, DOWN, 2.0)
            x, y, z = robot.arm.pose().position
            robot.scene.add("table", Box(size=(0.4, 0.4, 0.02)), xyz=(x, y, z - 0.06))
            limits = (0.01, 0.01, 0.05, 0.1, 0.1, 0.1)
            wrench = (0.0, 0.0, -force, 0.0, 0.0, 0.0)
            motion.start_force_mode(wrench, Z, limits=limits)
            fastest = 0.0
            while force_on(robot, "table") == 0.0:
                assert robot.time < 6.0
                height = robot.arm.pose().position[2]
                robot.run(0.02)
                speed = (height - robot.arm.pose().position[2]) / 0.02
                fastest = max(fastest, speed)
            assert 0.02 < fastest < 0.052
            robot.run(0.5)
            for _ in range(10):
                robot.run(0.02)
                assert force_on(robot, "table") == pytest.approx(force, abs=0.5)
            assert motion.state.force_mode
            assert motion.state.mode == "path"
            now = robot.arm.pose().position
            assert math.hypot(now[0] - x, now[1] - y) < 0.002
            motion.end_force_mode()
            robot.run(0.1)
            assert motion.state.mode == "stop"
            assert not motion.state.force_mode
            measured = [robot.snapshot.positions[j] for j in robot.arm.joint_names]
            assert motion.state.setpoint.positions == pytest.approx(measured, abs=0.005)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("force", "speed", "options"),
    [
        (20.0, 0.05, {"gripper": "2f85"}),
        (50.0, 0.02, {"control": ControlConfig(control_period=0.008)}),
        (
            5.0,
            0.05,
            {
                "gripper": "2f85",
                "ros2_control": True,
                "control": ControlConfig(control_period=0.008),
            },
        ),
        (20.0, 0.05, {"simulation": SimulationConfig(dt=0.002)}),
    ],
    ids=["2F-85", "125 Hz", "2F-85 at 125 Hz", "steps of 2 ms"],
)
def test_force_mode_holds_a_force_while_the_tool_slides(
    force: float, speed: float, options: dict[str, object]
) -> None:
    """The friction is as large as the force.  Neither it nor the springs that hold the
    tool against it change the force: they did, and it took 10 s to recover."""
    with tool0.bringup(**{"gripper": None, "realtime": False, **options}) as robot:
        reach = 0.15 if options.get("gripper") else 0.0
        motion = robot.arm.motion
        with motion.taken():
            move(robot, DOWN, 2.0)
            x, y, z = robot.arm.pose().position
            top = z - reach - 0.01
            robot.scene.add("table", Box(size=(0.4, 0.4, 0.02)), xyz=(x, y, top - 0.01))
            tcp = (0.0, 0.0, reach, 0.0, 0.0, 0.0)
            wrench = (0.0, 0.0, -force, 0.0, 0.0, 0.0)
            limits = (0.1, 0.1, 0.05, 0.5, 0.5, 0.5)
            motion.start_force_mode(wrench, Z, limits=limits, tcp=tcp)
            robot.run(1.5)
            assert force_on(robot, "table") == pytest.approx(force, abs=0.5)
            duration = 0.04 / speed
            motion.speed_tool((speed, 0.0, 0.0, 0.0, 0.0, 0.0), 0.5, duration, tcp=tcp)
            robot.run(duration + 0.5)
            assert math.dist((x, y), robot.arm.pose().position[:2]) > 0.03
            for _ in range(10):
                robot.run(0.02)
                assert force_on(robot, "table") == pytest.approx(force, abs=0.5)


def test_a_push_does_not_turn_the_tool(robot: tool0.Robot) -> None:
    """Along an axis in which the arm is far heavier than its wrist."""
    motion = robot.arm.motion
    motion.take()
    move(robot, DOWN, 2.0)
    before = np.array(robot.arm.pose().matrix)
    motion.start_force_mode(
        (40.0, 0.0, 0.0, 0.0, 0.0, 0.0), (True, False, False, False, False, False)
    )
    robot.run(1.0)
    moved = np.array(robot.arm.pose().matrix) - before
    assert abs(moved[0, 3]) > 0.05
    assert np.abs(moved[1:3, 3]).max() < 1e-3
    assert np.abs(moved[:3, :3]).max() < 0.02


@pytest.mark.slow
def test_force_mode_follows_a_path_along_the_other_axes(robot: tool0.Robot) -> None:
    motion = robot.arm.motion
    motion.take()
    move(robot, DOWN, 2.0)
    wrench = (0.0, 0.0, -20.0, 0.0, 0.0, 0.0)
    motion.start_force_mode(wrench, Z, limits=(0.1, 0.1, 0.05, 0.5, 0.5, 0.5))
    z = robot.arm.pose().position[2]
    motion.execute_path([1.0], [np.add(DOWN, (0.3, 0, 0, 0, 0, 0))], REST)
    robot.run(1.2)
    assert motion.state.is_done
    turned = robot.snapshot.positions[robot.arm.joint_names[0]]
    assert turned == pytest.approx(0.3, abs=0.003)
    assert z - robot.arm.pose().position[2] == pytest.approx(0.055, abs=0.01)


def test_the_axes_of_a_force_can_follow_the_tool(robot: tool0.Robot) -> None:
    """Kind 1: y points from the TCP to the frame's origin, here 1 m away in x."""
    motion = robot.arm.motion
    motion.take()
    move(robot, DOWN, 2.0)
    x, y, z = robot.arm.pose(relative_to="base").position
    request = StartForceMode(
        frame=(x + 1.0, y, z, 0.0, 0.0, 0.0),
        selection=(False, True, False, False, False, False),
        wrench=(0.0, 20.0, 0.0, 0.0, 0.0, 0.0),
        limits=(0.05,) * 6,
        kind=1,
    )
    robot.channel.call(request)
    robot.run(0.5)
    moved = np.subtract(robot.arm.pose(relative_to="base").position, (x, y, z))
    assert moved[0] > 0.01
    assert np.abs(moved[1:]).max() < 0.002


@pytest.mark.slow
def test_freedrive_follows_a_push_and_stays(robot: tool0.Robot) -> None:
    motion, box = robot.arm.motion, robot.arm.control_box
    motion.take()
    move(robot, DOWN, 2.0)
    motion.start_freedrive()
    assert box.state.robot_mode is RobotMode.BACKDRIVE
    start = np.array(robot.arm.pose().position)
    robot.run(1.0)
    assert robot.arm.pose().position == pytest.approx(start, abs=1e-3)
    robot.apply_wrench("tool0", force=(0.0, 20.0, 0.0), duration=0.5)
    robot.run(1.5)
    moved = robot.arm.pose().position - start
    assert moved[1] > 0.03
    still = robot.arm.pose().position
    robot.run(1.0)
    assert robot.arm.pose().position == pytest.approx(still, abs=1e-3)
    with pytest.raises(ControlError, match="in freedrive; end that"):
        motion.start_force_mode((0.0,) * 6, Z)
    motion.end_force_mode()  # there is none
    assert motion.state.mode == "freedrive"
    motion.end_freedrive()
    assert box.state.robot_mode is RobotMode.RUNNING
    robot.run(0.5)
    assert robot.arm.pose().position == pytest.approx(still, abs=2e-3)


@pytest.mark.slow
def test_freedrive_keeps_locked_axes(robot: tool0.Robot) -> None:
    motion = robot.arm.motion
    motion.take()
    move(robot, DOWN, 2.0)
    motion.start_freedrive((False, True, False, False, False, False))
    start = np.array(robot.arm.pose().position)
    robot.apply_wrench("tool0", force=(20.0, 20.0, 20.0), duration=1.0)
    robot.run(1.5)
    moved = robot.arm.pose().position - start
    assert moved[1] > 0.03
    assert np.abs(moved[[0, 2]]).max() < 0.002
    motion.release()
    robot.run(0.3)
    assert states(robot)["eff_joint_traj_controller"] == "running"


def test_a_jogged_arm_that_is_released_rests_within_a_tenth_of_a_second(
    robot: tool0.Robot,
) -> None:
    motion = robot.arm.motion
    robot.run(1.0)
    motion.take()
    for speed in (0.01, 0.1, 0.25):
        motion.take()
        motion.speed_tool((0.0, 0.0, -speed, 0.0, 0.0, 0.0), speed / 0.025)
        robot.run(0.3)
        motion.release()
        robot.run(0.1)
        there = np.array(robot.arm.pose().position)
        for _ in range(20):  # its controllers take over, without a jump
            robot.run(0.025)
            moved = robot.arm.pose().position - there
            assert np.abs(moved).max() < 5e-4
        assert states(robot)["eff_joint_traj_controller"] == "running"


def test_the_wrench_is_external_filtered_and_tared(robot: tool0.Robot) -> None:
    motion = robot.arm.motion
    robot.arm.control_box.set_payload(1.0, (0.0, 0.0, 0.05))
    motion.take()
    move(robot, DOWN, 2.0)

    def force() -> np.ndarray:
        for _ in range(20):
            robot.run(0.02)
            wrench = motion.state.wrench
        R = np.array(robot.arm.pose().matrix)[:3, :3]
        return R @ wrench[:3]

    assert force() == pytest.approx([0.0, 0.0, 9.81], abs=0.05)  # nothing is there
    robot.arm.control_box.clear_payload()
    assert force() == pytest.approx([0.0, 0.0, 0.0], abs=0.05)
    robot.apply_wrench("tool0", force=(5.0, 0.0, -10.0))
    assert force() == pytest.approx([5.0, 0.0, -10.0], abs=0.2)
    motion.zero_wrench()
    assert force() == pytest.approx([0.0, 0.0, 0.0], abs=0.05)
    robot.clear_wrenches()
    assert force() == pytest.approx([-5.0, 0.0, 10.0], abs=0.2)
