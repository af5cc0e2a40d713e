"""Laws and drives as Warp kernels, on the CPU, beside those of Python."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

wp = pytest.importorskip("warp", reason="MuJoCo Warp: pip install '.[gpu]'")

import tool0  # noqa: E402
from tool0.control.trajectory import TrajectoryGoal  # noqa: E402
from tool0.description.drive_limits import DriveLimits  # noqa: E402
from tool0.description.loading import load_description  # noqa: E402
from tool0.description.model import SafetyController  # noqa: E402
from tool0.description.robot import RobotDescription  # noqa: E402
from tool0.hardware.engine import JointState  # noqa: E402
from tool0.kernel.device import DeviceControl, DeviceState  # noqa: E402
from tool0.motion.gripper import direct_path  # noqa: E402
from tool0.protocol.trajectories import TrajectoryPoint  # noqa: E402
from tool0.simulation.executor import Executor  # noqa: E402
from tool0.simulation.paths import trajectory_points  # noqa: E402
from tool0.simulation.setup import Setup  # noqa: E402

N = 4
TICKS = 200
FAST = 4.0
"""More than the largest speed of each joint [rad/s]."""
FAST_TOLERANCE = 0.03
"""Of the largest effort, where the governor acts on random velocities: with the inverse
of masses in single precision.  Real motions agree better (test_batch_device.py)."""
TOLERANCE = 3e-5
"""Of the largest effort of a joint: 2e-7 rad of single precision at 4000 N·m/rad."""


def described(gripper: str, *, is_soft: bool = False) -> RobotDescription:
    robot = load_description(tool0.DescriptionConfig(gripper=gripper))
    if not is_soft:
        return robot
    joints = tuple(
        replace(
            joint,
            safety=SafetyController(
                soft_lower_limit=joint.limits.lower + 0.15,
                soft_upper_limit=joint.limits.upper - 0.15,
                k_position=20.0,
                k_velocity=15.0,
            ),
        )
        if joint.mimic is None and np.isfinite(joint.limits.lower)
        else joint
        for joint in robot.model.joints
    )
    return replace(robot, model=replace(robot.model, joints=joints))


class Side:
    """Controllers and drives of N robots whose states are prescribed, both ways."""

    def __init__(self, robot: RobotDescription) -> None:
        setup = Setup.of(robot, tool0.ControlConfig(), tool0.SimulationConfig())
        self.cores = [setup.make_core(setup.make_engine()) for _ in range(N)]
        core = self.cores[0]
        self.names = [s.name for s in core.manager.list() if s.state == "running"]
        self.gripper = robot.model.grippers[0]
        n_joints = len(core.state.position)
        self.home = np.tile(core.state.position, (N, 1))
        motors = [bounds.joint for bounds in core.hardware.table.bounds]
        self.state = DeviceState(
            wp.zeros(N, dtype=int, device="cpu"),
            wp.array(self.home, dtype=float, device="cpu"),
            wp.zeros((N, n_joints), dtype=float, device="cpu"),
            wp.zeros((N, len(motors)), dtype=float, device="cpu"),
            wp.zeros(N, dtype=int, device="cpu"),
        )
        self.device = DeviceControl(
            dict(zip(self.names, core.manager.running_controllers, strict=True)),
            core.hardware,
            robot.model.grippers,
            self.state,
            position=self.home,
            motor_joints=motors[::-1],
            period=core.control_period,
            device="cpu",
        )
        self.effort = np.zeros_like(self.home)
        self.most = np.full(n_joints, np.inf)
        for bounds in core.hardware.table.bounds:
            self.most[bounds.joint] = bounds.effort

    def command(self, name: str, duration: float, rng: np.random.Generator) -> None:
        spec = Executor(self.cores[0]).trajectory_controller(name).spec
        q = self.home[
            :, [self.cores[0].engine.joint_names.index(j) for j in spec.joints]
        ]
        q = q + rng.uniform(0.0, 0.002, q.shape)
        for core, target in zip(self.cores, q.tolist(), strict=True):
            points = [TrajectoryPoint(target, time_from_start=duration)]
            Executor(core).command_trajectory(
                name, TrajectoryGoal(points=points, joint_names=spec.joints)
            )
        self._start(name, q, duration)

    def grip(self, force: float, rng: np.random.Generator) -> None:
        gripper, joint, name = self.gripper, self.gripper.joint, self.names[-1]
        limits = DriveLimits(gripper=gripper, speed=0.1, force=force)
        openings = rng.uniform(0.9, 1.0, N) * gripper.max_opening
        for core, end in zip(self.cores, openings.tolist(), strict=True):
            executor = Executor(core)
            setpoint = executor.trajectory_controller(name).query_state(core.time)
            path = direct_path(
                gripper, setpoint.positions[0], end, 0.1, core.control_period
            )
            goal = TrajectoryGoal(points=trajectory_points(path), joint_names=(joint,))
            executor.command_trajectory(name, goal, {joint: limits})
        self.device.grip(
            np.arange(N),
            self.names.index(name),
            0,
            gripper,
            openings=openings,
            speeds=np.full(N, 0.1),
            forces=np.full(N, force),
        )

    def _start(self, name: str, q: np.ndarray, duration: float) -> None:
        self.device.start(
            np.arange(N),
            self.names.index(name),
            range(q.shape[1]),
            now=np.array([core.time for core in self.cores]),
            times=np.full((N, 1), duration),
            positions=q[:, None],
            velocities=None,
        )

    def tick(self, position: np.ndarray, velocity: np.ndarray) -> np.ndarray:
        """Execute a tick in these states; return the efforts by Python."""
        rows = zip(self.cores, position, velocity, self.effort, strict=True)
        for i, (core, q, qd, effort) in enumerate(rows):
            state = JointState(core.time, q.tolist(), qd.tolist(), effort.tolist())
            core.manager.update(state, core.control_period)
            self.effort[i] = core.hardware.efforts(state)
            core.ticks += 1
        self.device.upload()
        self.state.position.assign(position)
        self.state.velocity.assign(velocity)
        self.device.launch_laws()
        self.device.launch_drives()
        self.state.steps.assign(self.state.steps.numpy() + 1)
        return self.effort

    def error(self) -> float:
        """Return the largest difference of efforts, relative to the largest effort."""
        return float((np.abs(self.device.effort - self.effort) / self.most).max())


@pytest.mark.parametrize(
    ("gripper", "is_soft"), [("2f85", False), ("2f85", True), ("hande", False)]
)
def test_efforts_are_those_of_python(gripper: str, is_soft: bool) -> None:
    side = Side(described(gripper, is_soft=is_soft))
    rng = np.random.default_rng(3)
    arm, hand = side.names[-2:]
    n_free = n_bound = 0
    for k in range(TICKS):
        if k % 60 == 10:
            side.command(arm, 0.03, rng)
        if k % 60 == 20:
            side.grip(60.0 + k / 4.0, rng)
        if k == 150:  # without limits again
            side.command(hand, 0.03, rng)
        drift = rng.uniform(-1.0, 1.0, side.home.shape) * 1e-3
        speed = rng.uniform(-1.0, 1.0, side.home.shape) * (FAST if k % 7 == 0 else 0.02)
        position = (side.home + drift).astype(np.float32).astype(np.float64)
        velocity = speed.astype(np.float32).astype(np.float64)
        efforts = side.tick(position, velocity)
        drives = np.isfinite(side.most)
        is_bound = np.abs(efforts[:, drives]) >= 0.999 * side.most[drives]
        n_bound, n_free = n_bound + is_bound.sum(), n_free + (~is_bound).sum()
        most = FAST_TOLERANCE if k % 7 == 0 else TOLERANCE
        assert side.error() < most, f"tick {k}"
    assert n_free > 100
    assert n_bound > 10
    np.testing.assert_array_equal(
        side.state.motors.numpy()[:, ::-1],
        side.device.effort[:, drives].astype(np.float32),
    )


def test_a_restart_forgets_all_of_the_chosen_robots() -> None:
    side = Side(described("2f85"))
    rng = np.random.default_rng(3)
    side.grip(60.0, rng)
    for _ in range(20):
        side.tick(side.home + 1e-3, np.full_like(side.home, 0.01))
    kept = side.device.effort
    side.device.restart(np.array([1, 2]), side.home[:2])
    after = side.device.effort
    assert (after[[1, 2]] == 0.0).all()
    assert (after[[0, 3]] == kept[[0, 3]]).all()
    side.state.steps.assign(np.array([20, 0, 0, 20], dtype=np.int32))
    for i in (1, 2):
        side.cores[i].reset({}, keep_time=False)
    side.effort[1:3] = 0.0
    side.tick(side.home, np.zeros_like(side.home))
    assert side.error() < TOLERANCE
