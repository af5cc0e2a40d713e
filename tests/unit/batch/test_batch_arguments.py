"""What a batch refuses, with what would be right; and its outputs."""

from __future__ import annotations

import copy
import pickle
import queue
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest
from batch_rig import block_between
from raises_naming import raises_naming

import tool0
from tool0.scene import Box, Scene, SceneObject, Sphere

SCENE = Scene(
    (
        SceneObject(
            name="cube",
            geometry=Box(size=(0.04, 0.04, 0.04)),
            pose=tool0.Pose(xyz=(0.5, 0.3, 0.02)),
            mass=0.1,
        ),
        SceneObject(
            name="wall",
            geometry=Box(size=(0.1, 0.1, 0.1)),
            pose=tool0.Pose(xyz=(0.0, 0.8, 0.05)),
        ),
    )
)


@pytest.fixture(scope="module")
def batch() -> Iterator[tool0.Batch]:
    with tool0.Batch(3, scene=SCENE) as batch:
        yield batch


def test_threads_that_use_one_batch_at_once_are_refused() -> None:
    """Not all of them: one goes on, and the batch remains usable."""
    outcomes: queue.SimpleQueue[str] = queue.SimpleQueue()

    def use(call: Callable[[], object]) -> None:
        for _ in range(20):
            try:
                call()
            except tool0.ControlError as error:
                outcomes.put(str(error))
            else:
                outcomes.put("")

    with tool0.Batch(2, description=tool0.DescriptionConfig(gripper=None)) as batch:
        calls = [lambda: batch.step(50)] * 3 + [batch.reset, lambda: batch.position]
        threads = [threading.Thread(target=use, args=(call,)) for call in calls]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        batch.reset()
        batch.step()
        assert batch.time.tolist() == [batch.control_period] * 2
    texts = [outcomes.get() for _ in range(100)]
    assert "" in texts
    assert any("another thread is using this batch" in text for text in texts)


@pytest.mark.parametrize("copied", [pickle.dumps, copy.deepcopy, copy.copy])
def test_a_batch_cannot_be_pickled(
    batch: tool0.Batch, copied: Callable[[object], object]
) -> None:
    with pytest.raises(TypeError, match="make one where it is needed"):
        copied(batch)


def changed(**fields: object) -> Scene:
    cube, wall = SCENE.objects
    return Scene((replace(cube, **fields), wall))  # type: ignore[arg-type]


MADE_WRONG: list[tuple[dict[str, object], tuple[str, ...]]] = [
    ({"n": 0}, ("1 or more", "got 0")),
    ({"n": -3}, ("1 or more", "got -3")),
    ({"n": 2.5}, ("whole number", "2.5")),
    ({"n": True}, ("whole number", "True")),
    ({"n": 2, "threads": 3}, ("threads", "1 … 2", "got 3")),
    ({"n": 2, "threads": 0}, ("threads", "1 … 2", "got 0")),
    ({"n": 2, "scene": [SCENE]}, ("2", "got 1")),
    ({"n": 2, "scene": [SCENE, changed(name="box")]}, ("scene 1", "box", "cube")),
    (
        {"n": 2, "scene": [SCENE, changed(geometry=Sphere(radius=0.02))]},
        ("'cube'", "scene 1", "another shape"),
    ),
    ({"n": 2, "scene": [SCENE, changed(mass=None)]}, ("'cube'", "scene 1", "no mass")),
    ({"n": 1, "dt": 0.0}, ("above 0 s",)),
]


@pytest.mark.parametrize(("options", "shown"), MADE_WRONG)
def test_what_no_batch_can_be(
    options: dict[str, object], shown: tuple[str, ...]
) -> None:
    with raises_naming(tool0.ConfigError, *shown):
        tool0.Batch(**options)  # type: ignore[arg-type]


Q = np.tile([0.0, -1.5, 1.5, -1.5, -1.5, 0.0], (3, 1))
NAN = Q.copy()
NAN[1, 4] = np.nan
FAR = Q.copy()
FAR[2, 2] = 9.0

WRONG_CALLS: list[tuple[Callable[[tool0.Batch], object], type, tuple[str, ...]]] = [
    (
        lambda b: b.command(Q[:2], duration=0.1),
        tool0.ControlError,
        ("'positions'", "(2, 6)", "(3, 6)", "elbow_joint"),
    ),
    (
        lambda b: b.command(Q[:, :5], duration=0.1),
        tool0.ControlError,
        ("'positions'", "(3, 5)", "(3, 6)"),
    ),
    (
        lambda b: b.command(NAN, duration=0.1),
        tool0.ControlError,
        ("'positions'", "nan", "[1, 4]", "finite"),
    ),
    (
        lambda b: b.command("up", duration=0.1),
        tool0.ControlError,
        ("'positions'", "numbers", "up"),
    ),
    (
        lambda b: b.command(FAR, duration=0.1),
        tool0.GoalRejectedError,
        ("copy 2", "elbow_joint", "9", "limits"),
    ),
    (
        lambda b: b.command(Q, velocities=NAN, duration=0.1),
        tool0.ControlError,
        ("'velocities'", "[1, 4]"),
    ),
    (
        lambda b: b.command(Q, duration=0.0),
        tool0.ControlError,
        ("'duration'", "above 1e-06", "0.0"),
    ),
    (
        lambda b: b.command(Q, duration=float("nan")),
        tool0.ControlError,
        ("'duration'", "nan"),
    ),
    (
        lambda b: b.command(Q, duration=1e-7),
        tool0.ControlError,
        ("'duration'", "above 1e-06", "1e-07"),
    ),
    (
        lambda b: b.command(Q[:, :1], duration=0.1, joints=["elbow"]),
        tool0.ControlError,
        ("'elbow'", "elbow_joint"),
    ),
    (
        lambda b: b.command(Q[:, :1], duration=0.1, joints=["elbow_joint"]),
        tool0.GoalRejectedError,
        ("1 of 6", "allow_partial_joints_goal"),
    ),
    (
        lambda b: b.command(Q, duration=0.1, which=[3]),
        tool0.ControlError,
        ("copy 3", "0 … 2"),
    ),
    (
        lambda b: b.command(Q, duration=0.1, which=[True, False]),
        tool0.ControlError,
        ("mask", "(2,)", "(3,)"),
    ),
    (
        lambda b: b.command(Q, duration=0.1, which=[0.5]),
        tool0.ControlError,
        ("'which'", "float64"),
    ),
    (
        lambda b: b.follow(Q[:, None], [0.2, 0.1]),
        tool0.ControlError,
        ("'times'", "each above"),
    ),
    (
        lambda b: b.follow(Q[:, None], [0.1, 0.2]),
        tool0.ControlError,
        ("'positions'", "(3, 1, 6)", "(3, 2, 6)"),
    ),
    (lambda b: b.move_gripper(0.2), tool0.ModelError, ("0.2", "0.085")),
    (
        lambda b: b.move_gripper([0.01, 0.02]),
        tool0.ControlError,
        ("'opening'", "(2,)", "(3,)"),
    ),
    (
        lambda b: b.move_gripper(0.01, force=1e4),
        tool0.ControlError,
        ("force", "10000", "N"),
    ),
    (
        lambda b: b.move_gripper(0.01, speed=[0.1, np.nan, 0.1]),
        tool0.ControlError,
        ("'speed'", "nan", "[1]"),
    ),
    (
        lambda b: b.move_gripper(0.01, gripper="hand"),
        tool0.ControlError,
        ("'hand'", "gripper"),
    ),
    (lambda b: b.tool_pose("left"), tool0.ControlError, ("'left'", "arm")),
    (lambda b: b.place("cub", [0, 0, 1]), tool0.ControlError, ("'cub'", "'cube'")),
    (
        lambda b: b.place("cube", [0, 1]),
        tool0.ControlError,
        ("'position'", "(2,)", "(3, 3)"),
    ),
    (
        lambda b: b.place("cube", [0, 0, 1], [0, 0, 0, 0]),
        tool0.ControlError,
        ("'quat'", "zero"),
    ),
    (lambda b: b.set_mass("cube", 0.0), tool0.ControlError, ("copy 0", "above 0 kg")),
    (lambda b: b.set_mass("wall", 1.0), tool0.ControlError, ("'wall'", "fixed")),
    (
        lambda b: b.set_friction("cube", [0.1, -0.1, 0.1]),
        tool0.ControlError,
        ("copy 1", "friction"),
    ),
    (
        lambda b: b.reset(position=np.full(12, 9.0)),
        tool0.LimitsError,
        ("shoulder_pan_joint", "copy 0", "9.0"),
    ),
    (
        lambda b: b.reset(position=np.zeros(6)),
        tool0.ControlError,
        ("'position'", "(6,)", "(3, 12)"),
    ),
    (lambda b: b.step(-1), tool0.ControlError, ("'ticks'", "-1")),
    (lambda b: b.step(1, which=[3]), tool0.ControlError, ("copy 3", "0 … 2")),
    (lambda b: b.run(-1.0), tool0.ControlError, ("'duration'", "-1.0")),
    (lambda b: b.render(3, "overview"), tool0.ControlError, ("copy 3", "0 … 2")),
    (lambda b: b.render(0, "nowhere"), tool0.RenderError, ("'nowhere'",)),
    (lambda b: b.segment_all("nowhere"), tool0.RenderError, ("'nowhere'",)),
    (
        lambda b: b.set_colour(b.object_names[0], [2.0, 0.0, 0.0, 1.0]),
        tool0.ControlError,
        ("'rgba'", "0 … 1"),
    ),
    (lambda b: b.set_look(brightness=9.0), tool0.ConfigError, ("9.0", "up to 3")),
    (
        lambda b: b.set_camera("overview", [0.0] * 3, [0.0] * 4),
        tool0.ControlError,
        ("'quat' has a zero row",),
    ),
]


@pytest.mark.parametrize(("call", "kind", "shown"), WRONG_CALLS)
def test_wrong_calls_change_nothing(
    batch: tool0.Batch,
    call: Callable[[tool0.Batch], object],
    kind: type[Exception],
    shown: tuple[str, ...],
) -> None:
    batch.reset()
    batch.step(3)
    before = batch.position
    with raises_naming(kind, *shown):
        call(batch)
    assert np.array_equal(batch.position, before)
    batch.run(0.05)
    moved = batch.position
    batch.reset()
    batch.step(53)
    assert np.array_equal(batch.position, moved)


def test_shapes_and_read_only_outputs(batch: tool0.Batch) -> None:
    n, n_joints = 3, len(batch.joint_names)
    assert (batch.n, batch.dt, batch.control_period) == (n, 0.001, 0.001)
    assert batch.object_names == ("cube", "wall")
    shapes = {
        (n,): [batch.time, batch.diverged, batch.opening()],
        (n, n_joints): [batch.position, batch.velocity, batch.effort],
        (n, 2): [batch.pad_forces()],
        (n, 2, 3): [batch.object_position, batch.object_linear, batch.object_angular],
        (n, 2, 4): [batch.object_quat],
        (n, 3): [batch.tool_pose()[0], batch.tcp_pose()[0]],
        (n, 4): [batch.tool_pose()[1], batch.tcp_pose()[1]],
    }
    for shape, arrays in shapes.items():
        for array in arrays:
            assert array.shape == shape
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 0
    with tool0.Batch(1) as empty:
        assert empty.object_position.shape == (1, 0, 3)
        assert empty.object_quat.shape == (1, 0, 4)


def test_arrays_stay_as_they_are(batch: tool0.Batch) -> None:
    batch.reset()
    before = batch.position
    values = before.copy()
    batch.command(Q, duration=0.1)
    batch.run(0.1)
    assert np.array_equal(before, values)
    assert not np.array_equal(batch.position, values)


def test_poses_agree_with_a_single_robot(batch: tool0.Batch) -> None:
    batch.reset()
    batch.command(Q + np.arange(3)[:, None] / 10, duration=0.1)
    batch.move_gripper([0.02, 0.05, 0.08])
    batch.run(0.3)
    with tool0.bringup(realtime=False) as robot:
        for i in range(3):
            start = dict(zip(batch.joint_names, batch.position[i], strict=True))
            given = {name: start[name] for name in (*batch.arm_joints, "finger_joint")}
            robot.reset(given)
            expected = robot.arm.pose()
            frames = (expected, expected @ robot.gripper.tcp())
            found_frames = (batch.tool_pose(), batch.tcp_pose())
            for found, pose in zip(found_frames, frames, strict=True):
                np.testing.assert_allclose(found[0][i], pose.position, atol=1e-12)
                np.testing.assert_allclose(found[1][i], pose.quat_wxyz, atol=1e-12)
            assert batch.opening()[i] == robot.gripper.opening


def test_pad_forces_are_those_of_the_contacts() -> None:
    with tool0.bringup(realtime=False) as robot:
        scene = block_between(robot.arm.pose() @ robot.gripper.tcp(), 0.1)
    with (
        tool0.Batch(1, scene=scene) as batch,
        tool0.bringup(scene=scene, realtime=False) as robot,
    ):
        assert not batch.pad_forces().any()
        batch.move_gripper(0.02, force=40.0)
        batch.run(1.0)
        one, other = batch.pad_forces()[0]
        robot.gripper.move(opening=0.02, force=40.0)
        robot.run(1.0)
        felt = [
            np.linalg.norm(contact.force)
            for contact in robot.contacts()
            if "block" in (contact.first, contact.second)
            and "pad" in contact.first + contact.second
        ]
    np.testing.assert_allclose([one, other], 40.0, rtol=0.05)
    np.testing.assert_allclose(sorted([one, other]), sorted(felt), rtol=0.05)


def test_a_copy_that_diverges_stands_still_until_a_reset() -> None:
    with tool0.Batch(3, scene=SCENE) as batch, tool0.Batch(2, scene=SCENE) as two:
        world = batch._cores[1].engine.world
        world.place(
            tool0.ObjectState("cube", (0.5, 0.3, 1.0), (1.0, 0.0, 0.0, 0.0), (1e6,) * 3)
        )
        batch.run(0.1)
        two.run(0.1)
        assert batch.diverged.tolist() == [False, True, False]
        assert batch.time[1] < 0.1
        assert np.array_equal(batch.position[[0, 2]], two.position)
        batch.reset([1])
        assert not batch.diverged.any()
        batch.run(0.1)
        assert np.array_equal(batch.position[1], two.position[0])


def test_a_closed_batch_refuses() -> None:
    batch = tool0.Batch(1)
    batch.close()
    batch.close()
    with raises_naming(tool0.ControlError, "closed"):
        batch.step()


def test_no_chosen_copy_is_no_error() -> None:
    with tool0.Batch(2, scene=SCENE) as batch, tool0.Batch(1, scene=SCENE) as still:
        nobody = [False, False]
        batch.command(Q[:2], duration=0.1, which=nobody)
        batch.follow(Q[:2, None], [0.1], which=[])
        batch.move_gripper(0.02, which=nobody)
        batch.place("cube", [0.4, 0.0, 0.3], which=nobody)
        batch.reset(nobody)
        batch.run(0.05)
        still.run(0.05)
        assert np.array_equal(batch.position, still.position[[0, 0]])
        assert np.array_equal(batch.object_position, still.object_position[[0, 0]])
