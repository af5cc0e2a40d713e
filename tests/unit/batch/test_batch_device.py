"""A batch on a device of MuJoCo Warp, beside one on the CPU."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from batch_rig import block_between, device_under_test, has_warp, needs_warp
from numpy.typing import NDArray
from promised import require_gl

import tool0

N = 4
TICKS = 50
REACH = 0.05
"""Way of a joint that it goes in 0.1 s [rad]."""
POSITION, VELOCITY, EFFORT = 2e-6, 2e-4, 1e-2
"""Largest differences while the arm moves freely [rad | m], [rad/s | m/s], [N·m | N].
Single precision, and 1e-6 of 4000 N·m/rad."""

SCENE = "table_and_cubes"
BLOCKS = [block_between(tool0.Transform(), mass) for mass in (0.1, 0.2)]
POSITIONS = "hardware_interface/PositionJointInterface"
SERVOS = """
arm_controller:
  type: position_controllers/JointTrajectoryController
  joints: [shoulder_pan_joint, shoulder_lift_joint, elbow_joint,
           wrist_1_joint, wrist_2_joint, wrist_3_joint]
gripper_controller:
  type: position_controllers/JointTrajectoryController
  joints: [finger_joint]
"""
FIELDS = (
    "body_mass",
    "body_subtreemass",
    "body_inertia",
    "body_invweight0",
    "dof_invweight0",
    "geom_friction",
    "pair_friction",
)
MOVABLE = ("red cube", "green cube", "blue cube", "can", "ball")
Array = NDArray[np.float64]


def columns_of_arm(batch: tool0.Batch) -> list[int]:
    return [batch.joint_names.index(joint) for joint in batch.arm_joints]


def test_an_unknown_device_is_refused() -> None:
    with pytest.raises(tool0.ConfigError, match=r"unknown device 'gpu'; valid: 'cpu'"):
        tool0.Batch(1, device="gpu")


@pytest.mark.skipif(has_warp(), reason="MuJoCo Warp is installed")
def test_a_gpu_needs_mujoco_warp() -> None:
    match = r"'cuda' needs MuJoCo Warp, .*pip install '\.\[gpu\]'"
    with pytest.raises(tool0.EngineUnavailableError, match=match):
        tool0.Batch(1, device="cuda")


@needs_warp
def test_a_device_that_is_absent_is_refused() -> None:
    match = r"no device 'cuda:99': Warp finds cpu.*NVIDIA's driver"
    with pytest.raises(tool0.EngineUnavailableError, match=match):
        tool0.Batch(1, device="cuda:99")


@needs_warp
@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"threads": 2}, "threads are those of device='cpu'"),
        ({"scene": BLOCKS}, "all copies have the same scene"),
        (
            {"control": tool0.ControlConfig(gripper_action=True)},
            "controller 'gripper_controller' cannot run on a GPU",
        ),
    ],
)
def test_what_a_gpu_cannot_run_is_refused(
    options: dict[str, object], match: str
) -> None:
    with pytest.raises(tool0.ConfigError, match=match):
        tool0.Batch(2, device="warp:cpu", **options)  # type: ignore[arg-type]


@needs_warp
def test_servos_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "controllers.yaml"
    path.write_text(SERVOS, encoding="utf-8")
    with pytest.raises(tool0.ConfigError, match="'arm_controller' cannot run on a GPU"):
        tool0.Batch(
            2,
            device="warp:cpu",
            description=tool0.DescriptionConfig(transmission_hw_interface=POSITIONS),
            control=tool0.ControlConfig(
                controllers_file=path, controllers="arm_controller gripper_controller"
            ),
        )


@needs_warp
def test_brakes_are_refused() -> None:
    with pytest.raises(tool0.ConfigError, match="brakes of finger_joint cannot run"):
        tool0.Batch(
            1,
            device="warp:cpu",
            control=tool0.ControlConfig(controllers="eff_joint_traj_controller"),
        )


@pytest.fixture(scope="module")
def device() -> str:
    return device_under_test()


def test_moving_arms_agree_with_those_of_the_cpu(device: str) -> None:
    with (
        tool0.Batch(N, scene=SCENE) as host,
        tool0.Batch(N, scene=SCENE, device=device) as other,
    ):
        columns = [host.joint_names.index(joint) for joint in host.arm_joints]
        home = host.position[:, columns]
        rng = np.random.default_rng(1)
        fastest = 0.0
        for k in range(3):
            q = home + rng.uniform(-0.1, 0.1, home.shape)
            opening, force = rng.uniform(0.0, 0.08, N), rng.uniform(30.0, 100.0, N)
            points = np.stack([home, q], axis=1)
            start = home[0].tolist()
            for batch in (host, other):
                if k == 0:
                    batch.command(q, duration=0.05)
                elif k == 1:
                    batch.follow(points, [0.02, 0.05], velocities=np.zeros_like(points))
                else:
                    pose = batch.position[0].copy()
                    pose[columns[0]] = start[0] + 0.3
                    batch.reset([1, 2], pose)
                    batch.command(q, duration=0.05, which=[0, 1, 3])
                batch.move_gripper(opening, force=force)
                batch.step(TICKS // 2)
                fastest = max(fastest, abs(batch.velocity).max())
                batch.step(TICKS // 2)
            np.testing.assert_array_equal(other.time, host.time)
            np.testing.assert_allclose(other.position, host.position, atol=POSITION)
            np.testing.assert_allclose(other.velocity, host.velocity, atol=VELOCITY)
            np.testing.assert_allclose(other.effort, host.effort, atol=EFFORT)
            np.testing.assert_allclose(other.opening(), host.opening(), atol=POSITION)
            for mine, its in zip(other.tcp_pose(), host.tcp_pose(), strict=True):
                np.testing.assert_allclose(mine, its, atol=POSITION)
        assert np.ptp(host.position[:, columns], axis=0).min() > 0.01  # they moved
        assert fastest > 0.9 * 3.14  # [rad/s]: the governor has acted
        assert not other.diverged.any()


def test_grips_agree_with_those_of_the_cpu(device: str) -> None:
    with tool0.Batch(1) as batch:
        x, y, z = batch.tcp_pose()[0][0].tolist()
    scene = block_between(tool0.Transform(position=(x, y, z)), 0.2)
    found = []
    for name in ("cpu", device):
        with tool0.Batch(2, scene=scene, device=name) as batch:
            batch.move_gripper(0.0, force=[40.0, 80.0])
            batch.run(0.7)
            forces = batch.pad_forces(), batch.opening(), batch.object_position
            found.append(forces)
    (host, *its_host), (other, *its_other) = found
    assert host.min(axis=1) == pytest.approx([40.0, 80.0], rel=0.1)  # it is held
    np.testing.assert_allclose(other, host, rtol=0.02)
    for mine, its in zip(its_other, its_host, strict=True):
        np.testing.assert_allclose(mine, its, atol=2e-4)


def test_a_copy_that_diverges_stands_still(device: str) -> None:
    with tool0.Batch(3, scene=SCENE, device=device) as batch:
        batch.step(2)
        worlds = batch._copies._worlds  # type: ignore[attr-defined]
        velocity = worlds.velocity.numpy()
        velocity[1, 0] = np.nan
        worlds.velocity.assign(velocity)
        batch.step(5)
        assert batch.diverged.tolist() == [False, True, False]
        np.testing.assert_allclose(batch.time, [0.007, 0.002, 0.007])
        assert np.isfinite(batch.position).all()
        before = batch.position[1]
        batch.step(3)
        np.testing.assert_array_equal(batch.position[1], before)
        batch.reset([1])
        assert not batch.diverged.any()
        batch.step(2)
        np.testing.assert_allclose(batch.time, [0.012, 0.002, 0.012])


def test_a_pile_freezes_its_copy_alone(
    device: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Room for the objects at rest, 84 rows, and not for a pile of them.
    monkeypatch.setattr("tool0.engines.mujoco.warp_worlds.ROWS", 96)
    monkeypatch.setattr("tool0.engines.mujoco.warp_worlds.ROWS_PER_CONTACT", 0)
    found = []
    for is_piled in (False, True):
        with tool0.Batch(2, scene=SCENE, device=device) as batch:
            batch.step(5)
            place = batch.object_position[1, 1]
            for name in batch.object_names[1:] if is_piled else ():
                batch.place(name, place, which=[1])
            batch.step(10)
            found.append((batch.time, batch.position, batch.object_position))
            assert batch.diverged.tolist() == [False, is_piled]
    undisturbed, (time, position, objects) = found
    np.testing.assert_allclose(time, [0.015, 0.005])
    np.testing.assert_allclose(objects[1, 1:] - place, 0.0, atol=1e-6)  # it stands
    for mine, its in zip(undisturbed, (time, position, objects), strict=True):
        np.testing.assert_array_equal(mine[0], its[0])


def test_limits_of_iterations_are_no_divergence(device: str) -> None:
    with tool0.Batch(1, scene=SCENE, device=device) as batch:
        batch.step()
        overflows = pytest.importorskip("mujoco_warp").OverflowType
        data = batch._copies._worlds._data  # type: ignore[attr-defined]
        data.overflow.fill_(int(overflows.ITERATIONS | overflows.LS_ITERATIONS))
        batch.step(5)
        assert not batch.diverged.any()
        data.overflow.fill_(int(overflows.CCD))
        batch.step()
        assert batch.diverged.all()


def test_masses_and_frictions_are_those_of_the_cpu(device: str) -> None:
    with (
        tool0.Batch(3, scene=SCENE) as host,
        tool0.Batch(3, scene=SCENE, device=device) as other,
    ):
        for batch in (host, other):
            for name in ("red cube", "can"):
                batch.set_mass(name, [0.4, 9.0, 0.03], which=[0, 2])
            batch.set_mass("red cube", 0.2, which=[0])
            batch.set_friction("red cube", [9.0, 0.3, 2.5], which=[1, 2])
            batch.set_friction("table", 0.7)
        model = other._copies._worlds._model  # type: ignore[attr-defined]
        for name in FIELDS:
            compiled = [
                getattr(core.engine.model, name)  # type: ignore[attr-defined]
                for core in host._cores
            ]
            np.testing.assert_allclose(
                getattr(model, name).numpy(), compiled, rtol=2e-6, atol=1e-9
            )


def test_wrong_masses_and_frictions_are_refused(device: str) -> None:
    with tool0.Batch(2, scene=SCENE, device=device) as batch:
        with pytest.raises(tool0.ControlError, match="object 'table' is fixed"):
            batch.set_mass("table", 1.0)
        with pytest.raises(tool0.ControlError, match=r"copy 1: .*mass"):
            batch.set_mass("can", [1.0, -1.0])


def test_arrays_on_the_device_are_those_of_the_host(device: str) -> None:
    with tool0.Batch(2, scene=SCENE, device=device) as batch:
        batch.command(batch.position[:, columns_of_arm(batch)] + REACH, duration=0.1)
        batch.place("can", [0.4, 0.4, 0.5])
        batch.step(20)
        arrays = batch.device_arrays
        movable = [batch.object_names.index(name) for name in MOVABLE]
        for mine, its in (
            (arrays.position, batch.position),
            (arrays.velocity, batch.velocity),
            (arrays.effort, batch.effort),
            (arrays.object_position, batch.object_position[:, movable]),
            (arrays.object_quat, batch.object_quat[:, movable]),
            (arrays.object_linear, batch.object_linear[:, movable]),
            (arrays.diverged, batch.diverged),
        ):
            np.testing.assert_array_equal(mine.numpy(), its)
        assert abs(batch.object_linear).max() > 0.05  # the can falls
        before = batch.position
        batch.step()
        assert not np.array_equal(arrays.position.numpy(), before)  # no copies


@pytest.mark.parametrize("has_velocities", [True, False])
def test_commands_on_the_device_are_those_of_the_host(
    device: str, has_velocities: bool
) -> None:
    warp = pytest.importorskip("warp")
    with (
        tool0.Batch(N, device=device) as host,
        tool0.Batch(N, device=device) as other,
    ):
        home = host.position[:, columns_of_arm(host)].astype(np.float32)
        rng = np.random.default_rng(2)
        for which in (None, [0, 2], [1, 3]):
            q = home + rng.uniform(-REACH, REACH, home.shape).astype(np.float32)
            qd = rng.uniform(-0.1, 0.1, home.shape).astype(np.float32)
            speeds = qd if has_velocities else None
            host.command(q, velocities=speeds, duration=0.06, which=which)
            with warp.ScopedDevice(device.removeprefix("warp:")):
                other.command(
                    warp.array(q),
                    velocities=warp.array(qd) if has_velocities else None,
                    duration=0.06,
                    which=which,
                )
            for batch in (host, other):
                batch.step(40)
                batch.move_gripper(0.03, which=[1])  # what the host adds, stays
                batch.step(30)
            np.testing.assert_allclose(other.position, host.position, atol=POSITION)
        assert np.ptp(host.position, axis=0).min() > 0.005  # they moved


def test_tensors_of_pytorch_share_the_memory(device: str) -> None:
    torch = pytest.importorskip("torch")
    with tool0.Batch(2, scene=SCENE, device=device) as batch:
        position = torch.from_dlpack(batch.device_arrays.position)
        quat = torch.from_dlpack(batch.device_arrays.object_quat)
        q = position[:, columns_of_arm(batch)] + REACH
        batch.command(q, duration=0.1)
        batch.step(300)
        np.testing.assert_array_equal(position.cpu(), batch.position)
        np.testing.assert_allclose(
            position[:, columns_of_arm(batch)].cpu(), q, atol=0.01
        )
        assert quat.shape == (2, len(MOVABLE), 4)


def test_wrong_arrays_on_the_device_are_refused(device: str) -> None:
    warp = pytest.importorskip("warp")
    name = device.removeprefix("warp:")
    with tool0.Batch(2, device=device) as batch, warp.ScopedDevice(name):
        q = batch.position[:, columns_of_arm(batch)]
        for array, match in (
            (warp.array(q[:, :5], dtype=float), r"shape \(2, 5\); it must be \(2, 6\)"),
            (warp.array(q, dtype=warp.float64), "must be float32, got float64"),
        ):
            with pytest.raises(tool0.ControlError, match=match):
                batch.command(array, duration=0.1)
        good = warp.array(q, dtype=float)
        with pytest.raises(tool0.ControlError, match="'velocities' must be on the"):
            batch.command(good, velocities=q.tolist(), duration=0.1)
        q = q.copy()
        q[1, 2] = np.nan
        batch.command(warp.array(q, dtype=float), duration=0.1)
        batch.step(2)
        assert batch.diverged.tolist() == [False, True]
        assert np.isfinite(batch.position).all()


def test_arrays_on_a_device_need_one() -> None:
    with (
        tool0.Batch(1) as batch,
        pytest.raises(tool0.ControlError, match="works on a GPU only"),
    ):
        batch.device_arrays  # noqa: B018


def test_a_step_of_some_copies_needs_the_cpu(device: str) -> None:
    with (
        tool0.Batch(2, device=device) as batch,
        pytest.raises(tool0.ControlError, match="works with device='cpu' only"),
    ):
        batch.step(which=[1])


def test_images_are_those_of_the_cpu(device: str) -> None:
    require_gl()
    images = []
    for name in ("cpu", device):
        with tool0.Batch(2, scene=SCENE, device=name) as batch:
            position = batch.position.copy()
            position[1, 0] += 0.5
            batch.reset(position=position)
            batch.place("red cube", [0.3, 0.5, 0.9], which=[1])
            images.append([batch.render(i, "wrist").rgb for i in range(2)])
    host, other = np.array(images, dtype=np.int64)
    assert abs(host[0] - host[1]).mean() > 1.0  # the copies differ
    assert abs(host - other).mean() < 0.5
