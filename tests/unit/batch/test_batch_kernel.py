"""What the kernel executes of a batch, and what Python does: the result is the same."""

from __future__ import annotations

import gc
import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest
from batch_rig import Beside
from numpy.typing import NDArray
from promised import require_gl

import tool0
from tool0.hardware.engine import JointState
from tool0.kernel import library
from tool0.simulation.core import Core

pytestmark = pytest.mark.slow

Array = NDArray[np.float64]
POSITION = "hardware_interface/PositionJointInterface"
CONTROLLERS = """
arm_controller:
  type: position_controllers/JointTrajectoryController
  joints: [shoulder_pan_joint, shoulder_lift_joint, elbow_joint,
           wrist_1_joint, wrist_2_joint, wrist_3_joint]
gripper_controller:
  type: position_controllers/JointTrajectoryController
  joints: [finger_joint]
"""

needs_kernel = pytest.mark.skipif(
    library.load() is None, reason="no compiled kernel in this installation"
)


@pytest.fixture
def python_ticks(monkeypatch: pytest.MonkeyPatch) -> list[Core]:
    """The cores whose ticks Python executed, in order."""
    found: list[Core] = []
    finish = Core._finish_tick  # also of a tick that the kernel began

    def counted(core: Core, state: JointState, n_steps: int) -> None:
        found.append(core)
        finish(core, state, n_steps)

    monkeypatch.setattr(Core, "_finish_tick", counted)
    return found


def moved(batch: tool0.Batch) -> tuple[Array, ...]:
    """Move arms and grippers in several ways; return what came of it."""
    columns = [batch.joint_names.index(joint) for joint in batch.arm_joints]
    rng = np.random.default_rng(4)
    found: list[Array] = []
    for k in range(6):
        change = rng.uniform(-0.01, 0.01, (batch.n, len(columns)))
        q = batch.position[:, columns] + change
        velocities = rng.uniform(-0.2, 0.2, q.shape) if k % 2 else None
        batch.command(q, velocities=velocities, duration=0.02 + 0.01 * k)
        batch.move_gripper(rng.uniform(0.0, 0.08, batch.n), force=30.0 + 10 * k)
        if k == 4:
            batch.reset([1])
        batch.run(0.045)
        found += [batch.time, batch.position, batch.velocity, batch.effort]
        found += [batch.object_position, batch.object_angular]
    return tuple(found)


@needs_kernel
def test_the_kernel_executes_every_ordinary_tick(python_ticks: list[Core]) -> None:
    with tool0.Batch(3, scene="table_and_cubes") as batch:
        moved(batch)
    assert python_ticks == []


@needs_kernel
def test_python_gives_the_same(
    monkeypatch: pytest.MonkeyPatch, python_ticks: list[Core]
) -> None:
    with tool0.Batch(2, scene="table_and_cubes") as batch:
        compiled = moved(batch)
    monkeypatch.setenv(library.VARIABLE, "python")
    with tool0.Batch(2, scene="table_and_cubes") as batch:
        reference = moved(batch)
    assert len(python_ticks) == 2 * 6 * 45
    for one, other in zip(compiled, reference, strict=True):
        assert np.array_equal(one, other)


@needs_kernel
def test_fast_joints_whose_mobility_is_due(python_ticks: list[Core]) -> None:
    """The governor gets a mobility between two steps of the kernel."""
    with Beside(2) as beside:
        columns = [beside.batch.joint_names.index(j) for j in beside.batch.arm_joints]
        for sign in (1.0, -1.0):
            q = beside.batch.position[:, columns]
            q[:, 0] += sign * 1.2  # within 0.3 s: faster than a drive can
            beside.command(q, duration=0.3)
            beside.run(0.25)
            beside.check()
            assert np.abs(beside.batch.velocity[:, columns]).max() > 2.0
    assert not set(python_ticks) & set(beside.batch._cores)


def test_servos_whose_masses_are_due(tmp_path: Path, python_ticks: list[Core]) -> None:
    """Servos get new masses every 64 steps, between two steps of the kernel."""
    servos = tool0.DescriptionConfig(transmission_hw_interface=POSITION)
    file = tmp_path / "controllers.yaml"
    file.write_text(CONTROLLERS)
    control = tool0.ControlConfig(
        controllers_file=file, controllers="arm_controller gripper_controller"
    )
    with Beside(2, description=servos, control=control) as beside:
        rng = np.random.default_rng(2)
        columns = [beside.batch.joint_names.index(j) for j in beside.batch.arm_joints]
        for _ in range(3):
            q = beside.batch.position[:, columns]
            beside.command(q + rng.uniform(-0.1, 0.1, q.shape), duration=0.1)
            beside.move_gripper(rng.uniform(0.0, 0.08, 2).tolist())
            beside.run(0.15)
            beside.check()
    if library.load() is not None:
        assert python_ticks == []


def test_joints_that_are_fast(python_ticks: list[Core]) -> None:
    """The governor gets new mobilities between two steps of the kernel."""
    with Beside(2) as beside:
        rng = np.random.default_rng(3)
        columns = [beside.batch.joint_names.index(j) for j in beside.batch.arm_joints]
        home = beside.batch.position[:, columns]
        for k in range(6):
            target = home + rng.uniform(-0.6, 0.6, home.shape)
            beside.command(target, duration=0.15, which=[1] if k % 2 else None)
            beside.run(0.1)
            beside.check()
        beside.batch.restore(beside.batch.save())
        beside.run(0.1)
        beside.check()
        assert np.abs(beside.batch.velocity[:, columns]).max() > 2.0
    if library.load() is not None:
        assert python_ticks == []


def test_motions_of_joints_that_turn_without_end() -> None:
    """A target goes the shortest way round, from wherever the joint is."""
    description = tool0.DescriptionConfig(arm="ur3e", gripper=None)
    with Beside(2, description=description) as beside:
        batch = beside.batch
        joint = batch.arm_joints.index("wrist_3_joint")
        columns = [batch.joint_names.index(j) for j in batch.arm_joints]
        q = batch.position[:, columns]
        for target in (3.0, -3.0, 7.0, -20.0):
            q[:, joint] = target
            beside.command(q, duration=0.2)
            beside.run(0.12)
            beside.check()
        turned = batch.position[:, batch.joint_names.index("wrist_3_joint")]
        assert (np.abs(turned) < 12.0).all()


def test_long_trajectories_and_what_replaces_them() -> None:
    with Beside(2) as beside:
        batch = beside.batch
        columns = [batch.joint_names.index(joint) for joint in batch.arm_joints]
        steps = np.random.default_rng(1).uniform(-0.01, 0.01, (2, 40, 6))
        path = batch.position[:, None, columns] + steps.cumsum(axis=1)
        beside.follow(path, (0.01 * np.arange(1, 41)).tolist())
        beside.run(0.255)
        beside.check()
        beside.command(path[:, 0], duration=0.05)
        beside.run(0.1)
        beside.check()


@needs_kernel
def test_the_kernel_starts_trajectories_and_goals_of_grippers(
    python_ticks: list[Core], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Goals that arrive, that are replaced on the way, and states taken in between."""

    def moved_by_goals() -> list[Array]:
        rng = np.random.default_rng(5)
        found: list[Array] = []
        with tool0.Batch(2, control=control) as batch:
            columns = [batch.joint_names.index(joint) for joint in batch.arm_joints]
            for k in range(5):
                change = rng.uniform(-0.003, 0.003, (2, 5, 6)).cumsum(axis=1)
                path = batch.position[:, None, columns] + change
                velocities = rng.uniform(-0.1, 0.1, path.shape) if k % 2 else None
                times = (0.013 * np.arange(1, 6)).tolist()
                batch.follow(path, times, velocities=velocities)
                batch.move_gripper(rng.uniform(0.0, 0.08, 2), force=40.0 + 10 * k)
                batch.run(0.4 if k == 1 else 0.045)
                found += [batch.position, batch.velocity, batch.effort]
        return found

    control = tool0.ControlConfig(gripper_action=True)
    compiled = moved_by_goals()
    assert python_ticks == []
    monkeypatch.setenv(library.VARIABLE, "python")
    for one, other in zip(compiled, moved_by_goals(), strict=True):
        assert np.array_equal(one, other)


def test_implausible_motions_are_refused() -> None:
    with tool0.Batch(2) as batch:
        columns = [batch.joint_names.index(joint) for joint in batch.arm_joints]
        q = batch.position[:, columns]
        before = batch.position
        velocities = np.zeros_like(q)
        velocities[1, 2] = 1e12
        with pytest.raises(tool0.GoalRejectedError, match="copy 1"):
            batch.command(q, velocities=velocities, duration=1.0)
        assert np.array_equal(batch.position, before)
        batch.run(0.01)
        with tool0.bringup(realtime=False) as robot:
            robot.run(0.01)
            assert batch.position[1].tolist() == list(robot.snapshot.position)


@pytest.mark.parametrize(
    "options",
    [{}, {"arm": "ur3e", "base_xyz": (0.1, 0.2, 0.3), "base_rpy": (0.4, 0.0, 1.0)}],
)
def test_inverse_kinematics_of_poses_that_are_measured(
    options: dict[str, object],
) -> None:
    description = tool0.DescriptionConfig(**options)  # type: ignore[arg-type]
    rng = np.random.default_rng(0)
    with tool0.Batch(20, description=description) as batch:
        columns = [batch.joint_names.index(joint) for joint in batch.arm_joints]
        start = batch.position.copy()
        start[:, columns] += rng.uniform(-0.3, 0.3, (20, 6))
        batch.reset(position=start)
        wanted = batch.tool_pose()
        away = start.copy()
        away[:, columns] += rng.uniform(-0.1, 0.1, (20, 6))
        batch.reset(position=away)
        found = batch.inverse_kinematics(*wanted)
        np.testing.assert_allclose(found, start[:, columns], atol=1e-6)
        some = batch.inverse_kinematics(*wanted, which=[3])
        np.testing.assert_array_equal(some[3], found[3])
        assert np.isnan(np.delete(some, 3, axis=0)).all()
        assert np.isnan(batch.inverse_kinematics([9.0, 0, 0], [1.0, 0, 0, 0])).all()
        with pytest.raises(tool0.ControlError, match="'quat' has a zero row"):
            batch.inverse_kinematics([0.3, 0.0, 0.3], [0.0] * 4)


def test_images_show_the_present_state() -> None:
    require_gl()
    with tool0.Batch(2, scene="table_and_cubes") as batch:
        columns = [batch.joint_names.index(joint) for joint in batch.arm_joints]
        batch.command(batch.position[:, columns] + 0.3, duration=0.1, which=[1])
        batch.run(0.1)
        one, other = (batch.render(i, "scene") for i in range(2))
        assert one.time == other.time == batch.time[0]
        assert one.rgb.shape == other.rgb.shape
        assert np.abs(one.rgb.astype(int) - other.rgb).max() > 50
        for image, again in zip(batch.render_all("scene"), (one, other), strict=True):
            np.testing.assert_array_equal(image.rgb, again.rgb)
        (only,) = batch.render_all("scene", which=[1])
        np.testing.assert_array_equal(only.depth, other.depth)


def native_threads() -> int:
    return len(list(Path("/proc/self/task").iterdir()))


def settled_threads() -> int:
    """Return the number of threads once those of closed batches have ended."""
    gc.collect()
    found = [-1]
    while len(found) < 5 or len(set(found[-5:])) > 1:
        time.sleep(0.05)  # they are detached
        found.append(native_threads())
    return found[-1]


@pytest.mark.slow
@needs_kernel
def test_threads_end_with_the_batch() -> None:
    before = settled_threads()
    with tool0.Batch(3, threads=3) as batch:
        batch.step(2)
        assert native_threads() == before + 2
        del batch
    assert settled_threads() == before


@needs_kernel
@pytest.mark.filterwarnings("ignore:.*multi-threaded, use of fork:DeprecationWarning")
def test_a_forked_process_steps_without_the_threads_of_its_parent() -> None:
    with tool0.Batch(4, threads=3) as batch:
        for n in range(1, 31):  # the threads are at another place at each fork
            batch.step(5)
            child = os.fork()
            if child == 0:
                signal.alarm(30)  # ends it, should it wait for a thread
                batch.step(5)
                is_done = np.allclose(batch.time, 0.005 * (n + 1), atol=1e-9)
                batch.close()
                os._exit(0 if is_done else 1)
            _, status = os.waitpid(child, 0)
            assert status == 0
        assert np.allclose(batch.time, 0.005 * n, atol=1e-9)
