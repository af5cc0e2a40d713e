"""Copies whose objects differ in size, from the start or later."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from batch_rig import Beside, block_between
from promised import require_gl
from raises_naming import raises_naming

import tool0
from tool0.errors import ConfigError, ControlError
from tool0.scene import Box, Compound, Cylinder, Pose, Scene, SceneObject, Sphere

FACTORS = (0.8, 1.0, 1.2)
EDGES = np.array([[0.03 * f, 0.03 * f, 0.04] for f in FACTORS])
"""Of a block between the pads [m]: as high as the post allows."""


def around(factor: float = 1.0, pads: tool0.Transform | None = None) -> Scene:
    """Return one object of each kind, of other sizes than with 1."""
    block = SceneObject(
        name="block",
        geometry=Box(size=(0.05 * factor, 0.04, 0.03 / factor)),
        pose=Pose(xyz=(0.5, 0.2, 0.3), rpy=(0.2, 0.1, 0.4)),
        mass=0.2,
    )
    can = SceneObject(
        name="can",
        geometry=Cylinder(radius=0.03 * factor, length=0.1 / factor),
        pose=Pose(xyz=(0.5, 0.35, 0.3)),
        mass=0.3,
    )
    ball = SceneObject(
        name="ball",
        geometry=Sphere(radius=0.03 * factor),
        pose=Pose(xyz=(0.5, 0.5, 0.3)),
        mass=0.1,
    )
    shelf = SceneObject(
        name="shelf",
        geometry=Box(size=(0.2 * factor, 0.8, 0.02)),
        pose=Pose(xyz=(0.5, 0.3, 0.1), rpy=(0.05, 0.0, 0.0)),
    )
    tee = SceneObject(
        name="tee",
        geometry=Compound(
            parts=(
                (Box(size=(0.1, 0.02, 0.02)), Pose()),
                (Box(size=(0.02, 0.02, 0.1)), Pose(xyz=(0.0, 0.0, 0.05))),
            )
        ),
        pose=Pose(xyz=(0.5, -0.3, 0.3)),
        mass=0.1,
    )
    return Scene((block, can, ball, shelf, tee))


def resize(batch: tool0.Batch, *factors: float) -> None:
    """Give the objects the sizes of ``around`` in each copy."""
    f = np.array(factors)
    same = np.ones(len(f))
    batch.set_size("block", np.stack([0.05 * f, 0.04 * same, 0.03 / f], axis=1))
    batch.set_size("can", np.stack([0.03 * f, 0.1 / f], axis=1))
    batch.set_size("ball", 0.03 * f)
    batch.set_size("shelf", np.stack([0.2 * f, 0.8 * same, 0.02 * same], axis=1))


def seen(batch: tool0.Batch) -> list[bytes]:
    """Return what each copy is measured to be, to the bit."""
    arrays = (batch.position, batch.object_position, batch.object_quat)
    arrays += (batch.velocity, batch.object_linear, batch.object_angular)
    return [b"".join(values[i].tobytes() for values in arrays) for i in range(batch.n)]


def blocks() -> list[Scene]:
    """Return a block between the pads on a post, in three sizes."""
    with tool0.bringup(realtime=False) as robot:
        pads = robot.arm.pose() @ robot.gripper.tcp()
    post, block = block_between(pads, 0.2).objects
    return [
        Scene((post, replace(block, geometry=Box(size=(x, y, z)))))
        for x, y, z in EDGES.tolist()
    ]


@pytest.mark.slow
def test_a_copy_is_a_bring_up_with_a_scene_of_that_size() -> None:
    with Beside(3, scene=blocks()) as beside:
        beside.move_gripper([0.02] * 3, force=[40.0] * 3)
        beside.run(0.6)
        beside.check()
        width = beside.batch.opening()
        assert (np.diff(width) > 0.004).all()
        assert (beside.batch.pad_forces() > 5.0).all()


@pytest.mark.slow
def test_sizes_set_later_are_as_if_compiled() -> None:
    made = blocks()

    def squeezed(scene: Scene | list[Scene], *, changes: bool) -> list[bytes]:
        with tool0.Batch(3, scene=scene) as batch:
            if changes:
                batch.set_size("block", EDGES)
            batch.move_gripper(0.02, force=30.0)
            batch.run(0.6)
            columns = [batch.joint_names.index(j) for j in batch.arm_joints]
            q = batch.position[:, columns]
            batch.command(q - [0, 0.2, 0, 0, 0, 0], duration=0.3)
            batch.run(0.3)
            return seen(batch)

    compiled = squeezed(made, changes=False)
    assert squeezed(made[1], changes=True) == compiled
    assert len(set(compiled)) == 3


def test_every_kind_of_shape_falls_as_if_compiled() -> None:
    made = [around(factor) for factor in FACTORS[::2]]
    with tool0.Batch(2, scene=made) as compiled, tool0.Batch(2, scene=around()) as one:
        resize(one, *FACTORS[::2])
        for name in ("block", "can", "ball", "shelf"):
            np.testing.assert_array_equal(
                one.object_size(name), compiled.object_size(name)
            )
        assert one.object_size("ball").shape == (2,)
        assert one.object_size("can").shape == (2, 2)
        for batch in (compiled, one):
            batch.run(0.4)
        assert (one.object_linear[:, :3] != 0.0).any(axis=-1).all()
        assert seen(one) == seen(compiled)
        one.reset()
        one.run(0.4)
        assert seen(one) == seen(compiled)  # a reset keeps sizes


def test_saved_copies_have_their_sizes() -> None:
    with tool0.Batch(2, scene=around()) as batch, tool0.Batch(1, scene=around()) as one:
        resize(batch, 0.8, 1.2)
        batch.run(0.2)
        state = batch.save()
        sizes = batch.object_size("block")
        batch.run(0.2)
        later = seen(batch)
        resize(batch, 1.3, 0.7)
        batch.restore(state)
        np.testing.assert_array_equal(batch.object_size("block"), sizes)
        batch.run(0.2)
        assert seen(batch) == later
        one.restore(state, source=1)
        np.testing.assert_array_equal(one.object_size("block"), sizes[1:])
        one.run(0.2)
        assert seen(one) == later[1:]


@pytest.mark.slow
def test_images_show_the_sizes() -> None:
    require_gl()
    made = [around(factor) for factor in (0.7, 1.4)]
    with tool0.Batch(2, scene=made) as compiled, tool0.Batch(2, scene=around()) as one:
        camera = "scene"
        whole = one.segment_all(camera)
        resize(one, 0.7, 1.4)
        drawn = one.segment_all(camera)
        for shown, right in zip(drawn, compiled.segment_all(camera), strict=True):
            np.testing.assert_array_equal(shown, right)
        ball = one.object_names.index("ball")
        smaller, larger = ((image == ball).sum() for image in drawn)
        assert smaller < (whole[0] == ball).sum() < larger
        rgb = one.render(1, camera).rgb.astype(int)
        right = compiled.render(1, camera).rgb.astype(int)
        assert np.abs(rgb - right).max() <= 1  # the shadows' map depends on the extent


@pytest.fixture(scope="module")
def batch() -> tool0.Batch:
    with tool0.Batch(2, scene=around()) as batch:
        yield batch


@pytest.mark.parametrize(
    ("name", "size", "shown"),
    [
        ("block", [0.1, 0.1], ("'size'", "(2,)", "(2, 3)")),
        ("block", [[0.1, 0.1, 0.1], [0.1, 0.0, 0.1]], ("copy 1", "'block'", "above 0")),
        ("ball", [0.1, np.nan], ("'size'", "nan", "[1]")),
        ("can", [20.0, 30.0], ("copy 0", "'can'", "40 x 40 x 30 m")),
        ("tee", [0.1, 0.1, 0.1], ("'tee'", "compound", "boxes, cylinders and spheres")),
        ("blok", [0.1, 0.1, 0.1], ("'blok'", "'block'")),
    ],
)
def test_wrong_sizes_are_refused(
    batch: tool0.Batch, name: str, size: object, shown: tuple[str, ...]
) -> None:
    before = batch.object_size("block")
    with raises_naming(ControlError, *shown):
        batch.set_size(name, size)
    assert batch.object_size("block") is before


def test_scenes_of_other_shapes_are_refused() -> None:
    first = around()
    ball = replace(first.objects[0], geometry=Sphere(radius=0.02))
    tee = replace(
        first.objects[4], geometry=Compound(parts=((Sphere(radius=0.02), Pose()),))
    )
    for objects in ((ball, *first.objects[1:]), (*first.objects[:4], tee)):
        with raises_naming(ConfigError, "scene 1", "another shape", "size of boxes"):
            tool0.Batch(2, scene=[first, Scene(objects)])


def test_sizes_need_the_cpu() -> None:
    pytest.importorskip("mujoco_warp")
    with tool0.Batch(2, scene="table_and_cubes", device="warp:cpu") as batch:
        edges = batch.object_size("red cube")
        assert edges.shape == (2, 3)
        with raises_naming(ControlError, "Batch.set_size", "device='cpu'"):
            batch.set_size("red cube", 0.9 * edges)
