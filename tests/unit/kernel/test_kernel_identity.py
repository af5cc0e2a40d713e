"""The kernel and the Python reference give the same results, to the bit."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from ur5_rig import ARM_JOINTS

import tool0
from tool0 import TrajectoryPoint
from tool0.description.config import DescriptionConfig
from tool0.description.shapes import Box
from tool0.errors import Tool0Error
from tool0.kernel import library
from tool0.protocol.controllers import Role
from tool0.simulation.config import ControlConfig, SimulationConfig
from tool0.simulation.core import Core

pytestmark = pytest.mark.slow

Record = list[object]
Scenario = Callable[[Any, Record], None]

POSITION = """
arm:
  type: position_controllers/JointTrajectoryController
  joints: [shoulder_pan_joint, shoulder_lift_joint, elbow_joint, wrist_1_joint,
           wrist_2_joint, wrist_3_joint]
  constraints: {goal_time: 0.5, elbow_joint: {trajectory: 0.05, goal: 0.01}}
"""
ROS2 = """
arm:
  ros__parameters:
    type: joint_trajectory_controller/JointTrajectoryController
    joints: [shoulder_pan_joint, shoulder_lift_joint, elbow_joint, wrist_1_joint,
             wrist_2_joint, wrist_3_joint]
    command_interfaces: [COMMANDED]
    state_interfaces: [position, velocity]
    allow_trajectory_replacement: SPLICED
    cmd_timeout: 0.8
    gains:
      shoulder_pan_joint: {p: 20, i: 1, ff_velocity_scale: 0.9}
      shoulder_lift_joint: {p: 20, i: 1, i_clamp: 0.1, ff_velocity_scale: 1}
      elbow_joint: {p: 20, d: 0.1, u_clamp_max: 0.1, error_deadband: 0.001,
                    i: 5, ff_velocity_scale: 1}
      wrist_1_joint: {p: 10, i: 1, u_clamp_min: -0.05, ff_velocity_scale: 1,
                      antiwindup_strategy: conditional_integration}
      wrist_2_joint: {p: 10, i: 1, u_clamp_max: 0.05, ff_velocity_scale: 1,
                      antiwindup_strategy: back_calculation}
      wrist_3_joint: {p: 10}
    constraints:
      goal_time: 0.5
      stopped_velocity_tolerance: 0.05
      elbow_joint: {trajectory: 0.05, goal: 0.01}
      wrist_1_joint: {trajectory: 0.1, goal: 0.002}
"""
FORWARD = """
arm:
  type: effort_controllers/JointGroupPositionController
  joints: [shoulder_pan_joint, shoulder_lift_joint, elbow_joint, wrist_1_joint,
           wrist_2_joint, wrist_3_joint]
  shoulder_pan_joint: {pid: {p: 4000, i: 100, d: 200, i_clamp: 1}}
  shoulder_lift_joint: {pid: {p: 10000, i: 100, d: 200, i_clamp: 1}}
  elbow_joint: {pid: {p: 2000, i: 100, d: 200, i_clamp: 1}}
  wrist_1_joint: {pid: {p: 500, i: 100, d: 5, i_clamp: 1, antiwindup: true}}
  wrist_2_joint: {pid: {p: 500, i: 100, d: 5, i_clamp: 1}}
  wrist_3_joint: {pid: {p: 10, i: 0, d: 0.1}}
"""


@pytest.fixture(autouse=True)
def _needs_the_kernel() -> None:
    status = library.kernel_status()
    if status.library is None:
        pytest.fail(f"no compiled kernel: {status.reason}")


def numbers(robot: Any) -> list[str]:
    """Return the state as exact text: signs of zeros count."""
    snapshot = robot.snapshot
    state = (*snapshot.position, *snapshot.velocity, *snapshot.effort)
    objects = [
        x
        for item in snapshot.objects
        for x in (*item.position, *item.quat_wxyz, *item.linear, *item.angular)
    ]
    errors = [
        x
        for setpoint in snapshot.controller_setpoints.values()
        for x in setpoint.state().error.positions
    ]
    return [float(x).hex() for x in (snapshot.time, *state, *objects, *errors)]


def recorded(
    monkeypatch: pytest.MonkeyPatch, scenario: Scenario, kernel: str, **options: Any
) -> Record:
    """Run a scenario with the kernel, or by Python alone."""
    if kernel:
        monkeypatch.setenv(library.VARIABLE, kernel)
    else:
        monkeypatch.delenv(library.VARIABLE, raising=False)
    record: Record = []
    with tool0.bringup(realtime=False, **options) as robot:
        scenario(robot, record)
        record.append(numbers(robot))
    return record


def assert_identical(
    monkeypatch: pytest.MonkeyPatch, scenario: Scenario, **options: Any
) -> None:
    compiled = recorded(monkeypatch, scenario, "", **options)
    reference = recorded(monkeypatch, scenario, "python", **options)
    assert compiled == reference
    assert len(compiled) > 1


def trajectories(robot: Any, record: Record) -> None:
    """Send random goals, and let most of them end."""
    send_goals(robot, record, random.Random(1), count=8, rest=1.0)


def send_goals(
    robot: Any, record: Record, rng: random.Random, *, count: int, rest: float
) -> None:
    """Send random goals to the trajectory controllers: some are replaced, some fail.

    ``rest`` [s] is how long some of them have after their end.
    """
    names = [
        status.name
        for status in robot.snapshot.controllers
        if status.is_running and status.role is Role.TRAJECTORY
    ]
    for _ in range(count):
        controller = robot.controller(rng.choice(names))
        n_joints = len(robot.snapshot.controller_setpoints[controller.name].joint_names)
        start = robot.snapshot.controller_setpoints[controller.name].state().desired
        points, time = [], 0.0
        for _ in range(rng.choice((1, 1, 2, 25))):
            time += rng.uniform(0.01, 0.2 * rest)
            target = [q + rng.uniform(-0.3, 0.3) for q in start.positions]
            velocities = rng.choice((None, [0.0] * n_joints))
            points.append(
                TrajectoryPoint(target, velocities, time_from_start=round(time, 3))
            )
        try:
            goal = controller.follow(points)
        except Tool0Error as error:
            record.append(str(error))
            continue
        robot.run(rng.choice((0.02, 0.05, min(time, rest), min(time, rest) + rest)))
        if rng.random() < 0.2:
            goal.cancel()
        record.append((goal.status, getattr(goal.result, "error_string", None)))
        record.append(numbers(robot))


def too_fast(robot: Any, record: Record) -> None:
    """Send goals that no drive can follow: speeds are governed."""
    rng, up = random.Random(3), (0.0, -1.57, 0.0, -1.57, 0.0, 0.0)
    for _ in range(4):
        robot.reset(dict(zip(ARM_JOINTS, up, strict=True)))
        target = [q + rng.uniform(-1.2, 1.2) for q in up]
        robot.controller("eff_joint_traj_controller").follow(
            [TrajectoryPoint(target, time_from_start=rng.uniform(0.1, 0.3))],
            path_tolerance=dict.fromkeys(ARM_JOINTS, -1.0),
        )
        for _ in range(5):
            robot.run(0.05)
            record.append(numbers(robot))
    speeds = [abs(float.fromhex(x)) for numbers in record[:-1] for x in numbers[13:19]]
    assert 2.5 < max(speeds) < 1.1 * 3.15


def grips(robot: Any, record: Record) -> None:
    """Grip a cube with limits of speed and force, and squeeze and release it."""
    tcp = robot.gripper.tcp(relative_to="world").position
    robot.scene.add("cube", Box(size=(0.04, 0.04, 0.04)), xyz=tuple(tcp), mass=0.1)
    for opening, speed, force in (
        (0.0, 0.05, 40.0),
        (0.0, 0.1, 100.0),
        (0.05, 0.1, 20.0),
    ):
        goal = robot.gripper.move(opening=opening, speed=speed, force=force)
        goal.wait(5.0)
        robot.run(0.3)
        record.append((goal.status, numbers(robot)))


def stops(robot: Any, record: Record) -> None:
    """Engage and release the emergency stop during a motion; switch; reset."""
    goals = robot.move_joints({"shoulder_pan_joint": 1.0, "elbow_joint": 1.0})
    robot.run(0.3)
    robot.emergency_stop()
    robot.run(0.3)
    record.append((goals[0].status, numbers(robot)))
    robot.emergency_stop(False)
    robot.run(0.3)
    record.append(numbers(robot))
    robot.reset()
    robot.run(0.2)
    record.append(numbers(robot))


def resets(robot: Any, record: Record) -> None:
    """Reset in the middle of motions and grips, with other gains in between."""
    for p in (None, 900.0, None, 1100.0):
        if p is not None:
            arm = robot.controller("eff_joint_traj_controller")
            arm.set_gains("elbow_joint", p=p)
        robot.move_joints({"shoulder_pan_joint": 0.5, "elbow_joint": 1.2})
        robot.gripper.move(opening=0.03, force=50.0)
        robot.run(0.15)
        record.append(numbers(robot))
        robot.reset({"elbow_joint": 1.0})
        robot.run(0.1)
        record.append(numbers(robot))


def sensing(robot: Any, record: Record) -> None:
    """Sample a sensor while joints move, at two rates, with and without a payload."""
    for rate, mass in ((125.0, None), (500.0, 2.5), (1000.0, None)):
        robot.force_torque.start(rate=rate)
        if mass is not None:
            robot.arm.control_box.set_payload(mass, (0.01, 0.0, 0.1))
        else:
            robot.arm.control_box.clear_payload()
        robot.move_joints({"shoulder_pan_joint": 0.5, "elbow_joint": 1.2})
        robot.run(0.3)
        robot.move_joints({"shoulder_pan_joint": -0.5, "elbow_joint": 0.7})
        robot.run(0.3)
        samples = robot.force_torque.samples()
        record.append([item.raw_force + item.raw_torque for item in samples])
        assert len(samples) == round(0.6 * rate) + 1
        record.append(numbers(robot))


def payloads(robot: Any, record: Record) -> None:
    """Change payload and speed slider while servos hold and move the arm."""
    for k, mass in enumerate((3.0, 0.0, 1.5, 6.0)):
        robot.arm.control_box.set_payload(mass, (0.0, 0.02, 0.1))
        robot.arm.control_box.set_speed_slider(0.2 + 0.2 * k)
        robot.run(0.2)
        robot.move_joints({"shoulder_pan_joint": 0.3 * k, "elbow_joint": 1.2})
        robot.run(0.3)
        record.append(numbers(robot))
    robot.arm.control_box.stop()
    robot.run(0.3)
    robot.arm.control_box.play()
    robot.run(0.3)


def pushes(robot: Any, record: Record) -> None:
    """Push links and an object for a while, also at once, while a sensor samples."""
    robot.force_torque.start(rate=200.0)
    robot.move_joints({"elbow_joint": 0.5})
    for name, duration in (
        ("wrist_3_link", 0.0334),
        ("red cube", 0.05),
        ("forearm_link", None),
    ):
        robot.apply_wrench(
            name, force=(8.0, 2.0, 5.0), torque=(0.1, 0.0, 0.0), duration=duration
        )
        robot.run(0.013)
        record.append(numbers(robot))
        robot.apply_wrench("tool0", force=(0.0, 3.0, 0.0), duration=0.02)
        robot.run(0.1)
        record.append((robot.force_torque.samples(), numbers(robot)))
    robot.clear_wrenches()
    robot.run(0.1)


def test_of_wrenches_that_are_applied(monkeypatch: pytest.MonkeyPatch) -> None:
    assert_identical(
        monkeypatch, pushes, simulation=SimulationConfig(scene="table_and_cubes")
    )


def test_python_executes_no_tick_while_a_wrench_acts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    ticks: list[Core] = []
    tick = Core.tick
    monkeypatch.setattr(Core, "tick", lambda core: ticks.append(core) or tick(core))
    with tool0.bringup(realtime=False) as robot:
        robot.force_torque.start(rate=125.0)
        robot.apply_wrench("tool0", force=(1.0, 0.0, 0.0), duration=0.4)
        robot.run(0.5)
    assert len(ticks) <= 4  # at its start and at its end


def paths(robot: Any, record: Record) -> None:
    """Take the arm: follow paths at several speeds, replace them, and stop."""
    rng, motion = random.Random(5), robot.arm.motion
    robot.run(0.1)
    motion.take()
    for k in range(6):
        start = motion.state.setpoint.positions
        count = rng.choice((1, 2, 40))
        times = [0.03 * (n + 1) + (n + 1) / count for n in range(count)]
        ends = [[q + rng.uniform(-0.02, 0.02) for q in start] for _ in times]
        rest = [[0.0] * 6] * count
        smooth = rng.choice((rest, ()))
        path = motion.execute_path(times, ends, rest, smooth)
        robot.run(rng.choice((0.05, 0.2)))
        robot.arm.control_box.set_speed_slider(rng.choice((0.3, 0.77, 1.0)))
        if k % 2:
            path = motion.execute_path(times, ends, rest, after=path, at=0.6)
        robot.run(rng.choice((0.1, 0.5, 3.0)))
        record.append((motion.state, numbers(robot)))
        motion.stop(along_path=bool(k % 3))
        robot.run(0.7)
        record.append((path, motion.state, numbers(robot)))
    motion.release()
    robot.run(0.1)


@pytest.mark.parametrize(
    "scenario", [trajectories, too_fast, grips, stops, resets, sensing, paths]
)
def test_of_the_default_robot(
    monkeypatch: pytest.MonkeyPatch, scenario: Scenario
) -> None:
    assert_identical(monkeypatch, scenario)


@pytest.mark.parametrize(
    "options",
    [
        {"description": DescriptionConfig(arm="ur10e", gripper="hande")},
        {
            "description": DescriptionConfig(
                robots=("left=ur5e+2f140", "right=ur3e+hande@1,0,0")
            )
        },
        {"control": ControlConfig(control_period=0.004)},
        {"control": ControlConfig(gripper_action=True)},
        {"simulation": SimulationConfig(dt=0.002)},
    ],
    ids=["hande", "cell", "four steps a tick", "gripper action", "2 ms"],
)
def test_of_trajectories(
    monkeypatch: pytest.MonkeyPatch, options: dict[str, Any]
) -> None:
    assert_identical(monkeypatch, trajectories, **options)


@pytest.mark.parametrize(
    "options",
    [
        {"ros2_control": True},
        {"control": ControlConfig(control_period=0.004)},
    ],
    ids=["ROS 2", "four steps a tick"],
)
def test_of_paths(monkeypatch: pytest.MonkeyPatch, options: dict[str, Any]) -> None:
    assert_identical(monkeypatch, paths, **options)


def test_of_grips_by_an_action(monkeypatch: pytest.MonkeyPatch) -> None:
    control = ControlConfig(gripper_action=True)
    assert_identical(monkeypatch, grips, control=control)
    assert_identical(monkeypatch, resets, control=control)


@pytest.mark.parametrize("yaml", [POSITION, FORWARD], ids=["position", "forward"])
def test_of_other_controllers(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, yaml: str
) -> None:
    file = tmp_path / "controllers.yaml"
    file.write_text(yaml)

    def commands(robot: Any, record: Record) -> None:
        if yaml is POSITION:
            trajectories(robot, record)
            return
        for k in range(5):
            robot.controller("arm").command(
                [0.1 * k, -1.5, 1.5, -0.1 * k, 0.2 * k, 9.0]
            )
            robot.run(0.4)
            record.append(numbers(robot))

    control = ControlConfig(controllers_file=file, controllers="arm")
    interface = "Position" if yaml is POSITION else "Effort"
    description = DescriptionConfig(
        transmission_hw_interface=f"hardware_interface/{interface}JointInterface"
    )
    assert_identical(monkeypatch, commands, control=control, description=description)
    if yaml is POSITION:
        assert_identical(
            monkeypatch, payloads, control=control, description=description
        )


@pytest.mark.parametrize(
    ("commanded", "spliced"), [("position", "false"), ("velocity", "true")]
)
def test_of_trajectories_of_ros_2(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, commanded: str, spliced: str
) -> None:
    """Goals and messages, also of the future, at several speeds."""
    file = tmp_path / "controllers.yaml"
    file.write_text(ROS2.replace("COMMANDED", commanded).replace("SPLICED", spliced))

    def motions(robot: Any, record: Record) -> None:
        arm, rng = robot.controller("arm"), random.Random(3)
        for k in range(5):
            if commanded == "position":
                arm.scale_speed(rng.choice((1.0, 1.0, 0.5, 0.3)))
            send_goals(robot, record, rng, count=3, rest=1.0)
            motion = robot.snapshot.controller_setpoints["arm"].state().desired
            point = TrajectoryPoint(
                [q + rng.uniform(-0.1, 0.1) for q in motion.positions],
                time_from_start=0.3,
            )
            arm.command_trajectory([point], stamp=rng.choice((None, robot.time + 0.1)))
            robot.run(rng.choice((0.05, 0.2, 1.5)))
            record.append(numbers(robot))
            if k == 3:
                robot.reset()

    control = ControlConfig(controllers_file=file, controllers="arm")
    description = DescriptionConfig(ros2_control=True)
    assert_identical(monkeypatch, motions, control=control, description=description)


def test_of_grippers_and_forwarding_controllers_of_ros_2(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With speeds and forces of the drive, and brakes until the first effort."""

    def motions(robot: Any, record: Record) -> None:
        hand = robot.controller("robotiq_gripper_controller")
        for position, force, speed in ((0.7, None, 0.05), (0.2, 20.0, None)):
            hand.command_gripper(position, force, max_velocity=speed)
            robot.run(0.4)
            record.append(numbers(robot))
        hand.command_gripper(0.8, max_velocity=0.02)
        robot.run(0.1)
        hand.command_gripper(0.3).cancel()
        robot.run(0.3)
        running = "joint_trajectory_controller"
        for kind, size in (("velocity", 0.2), ("position", -0.7), ("effort", 5.0)):
            name = f"forward_{kind}_controller"
            robot.load(name)
            robot.switch(start=[name], stop=[running])
            robot.run(0.1)
            record.append(numbers(robot))
            robot.controller(name).command([size] * 6)
            robot.run(0.3)
            record.append(numbers(robot))
            running = name

    description = DescriptionConfig(ros2_control=True)
    assert_identical(monkeypatch, motions, description=description)


def test_of_scaled_trajectories(monkeypatch: pytest.MonkeyPatch) -> None:
    def scaled(robot: Any, record: Record) -> None:
        box = robot.arm.control_box
        for fraction in (0.5, 0.13, 1.0):
            robot.move_joints({"elbow_joint": fraction, "wrist_1_joint": 1.0})
            robot.run(0.2)
            box.set_speed_slider(fraction)
            robot.run(0.5)
            box.pause()
            robot.run(0.4)
            record.append((box.state.speed_scaling, numbers(robot)))
            box.set_payload(2.0, (0.0, 0.01, 0.08))
            box.play()
            robot.run(1.0)
            record.append((box.state.speed_scaling, numbers(robot)))

    assert_identical(monkeypatch, scaled, ros2_control=True)


def test_of_many_goals(monkeypatch: pytest.MonkeyPatch) -> None:
    def many(robot: Any, record: Record) -> None:
        send_goals(robot, record, random.Random(7), count=250, rest=0.05)

    assert_identical(monkeypatch, many)
