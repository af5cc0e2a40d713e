"""The contacts of copies are those of single bring-ups, as arrays."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from batch_rig import Beside, block_between, device_under_test, needs_warp
from raises_naming import raises_naming

import tool0
from tool0.errors import ControlError
from tool0.scene import Box, Cylinder, Scene, SceneObject

G = 9.81
MASSES = (0.1, 0.3)
FLOOR = -0.1
"""Height of the ground in the root [m]."""


def thing(name: str, z: float, mass: float) -> SceneObject:
    return SceneObject(
        name=name,
        geometry=Box(size=(0.06, 0.06, 0.04)),
        pose=tool0.Pose(xyz=(0.5, 0.3, FLOOR + z)),
        mass=mass,
    )


def stack(mass: float) -> Scene:
    """Return a block on a shelf on the ground, and a can that lies beside them."""
    can = SceneObject(
        name="can",
        geometry=Cylinder(radius=0.03, length=0.1),
        pose=tool0.Pose(xyz=(0.5, -0.4, FLOOR + 0.03), rpy=(1.5707963, 0.0, 0.0)),
        mass=0.2,
    )
    return Scene((thing("shelf", 0.02, 2.0), thing("block", 0.06, mass), can))


@pytest.fixture(scope="module")
def resting() -> Iterator[tool0.Batch]:
    with tool0.Batch(2, scene=[stack(mass) for mass in MASSES]) as batch:
        assert len(batch.contacts()) == 0  # no step yet
        assert not batch.in_contact("block").any()
        batch.run(0.5)
        yield batch


def test_they_are_those_of_bring_ups() -> None:
    with tool0.bringup(realtime=False) as robot:
        pads = robot.arm.pose() @ robot.gripper.tcp()
    scenes = [block_between(pads, mass) for mass in (0.05, 0.2)]
    with Beside(2, scene=scenes) as beside:
        beside.move_gripper([0.02] * 2, force=[40.0] * 2)
        beside.run(0.6)
        found = beside.batch.contacts()
        wanted = [
            (i, contact)
            for i, robot in enumerate(beside.robots)
            for contact in robot.contacts()
        ]
        assert len(found) == len(wanted) >= 4
        for row, (copy, contact) in enumerate(wanted):
            assert found.copy[row] == copy
            assert (found.first[row], found.second[row]) == (
                contact.first,
                contact.second,
            )
            for name in ("point", "force", "torque"):
                values = getattr(found, name)[row]
                np.testing.assert_allclose(values, getattr(contact, name), atol=1e-12)
        pads_of_both = beside.batch.pad_names()
        assert beside.batch.in_contact(pads_of_both[0], "block").all()
        pressed = beside.batch.contacts(pads_of_both, "block")
        along = (pressed.force * pressed.normal).sum(axis=1).reshape(2, 2)
        np.testing.assert_allclose(along, beside.batch.pad_forces(), rtol=1e-3)


def test_they_carry_the_weight(resting: tool0.Batch) -> None:
    found = resting.contacts("shelf", "block")
    assert found.copy.tolist() == [0, 1]
    assert set(found.first) == {"shelf"}
    assert set(found.second) == {"block"}
    np.testing.assert_allclose(found.force[:, 2], np.multiply(G, MASSES), rtol=1e-3)
    np.testing.assert_allclose(found.normal, [[0.0, 0.0, 1.0]] * 2, atol=1e-3)
    np.testing.assert_allclose(found.point, [[0.5, 0.3, FLOOR + 0.04]] * 2, atol=1e-3)
    assert (found.distance > -1e-4).all()
    assert (found.distance < 0.0).all()
    below = resting.contacts("ground", ["shelf", "can"])
    carried = [(2.0 + mass) * G for mass in MASSES]
    assert below.copy.tolist() == [0, 0, 1, 1]
    on_shelf = below.force[below.second == "shelf"]
    np.testing.assert_allclose(on_shelf[:, 2], carried, rtol=1e-3)


def test_the_named_one_is_the_first(resting: tool0.Batch) -> None:
    down = resting.contacts("block", "shelf")
    up = resting.contacts("shelf", "block")
    assert set(down.first) == {"block"}
    np.testing.assert_array_equal(down.copy, up.copy)
    for name in ("force", "torque", "normal"):
        np.testing.assert_array_equal(getattr(down, name), -getattr(up, name))
    for name in ("point", "distance"):
        np.testing.assert_array_equal(getattr(down, name), getattr(up, name))
    every = resting.contacts("block")
    np.testing.assert_array_equal(every.force, down.force)
    one = resting.contacts("block", which=[1])
    assert one.copy.tolist() == [1]
    assert len(resting.contacts(which=[])) == 0
    assert len(resting.contacts("block", "can")) == 0


def test_who_touches_whom(resting: tool0.Batch) -> None:
    assert resting.in_contact("block", "shelf").all()
    assert resting.in_contact("shelf", "block").all()
    assert resting.in_contact("ground").all()
    assert not resting.in_contact("block", ["ground", "can"]).any()
    assert resting.in_contact(["can", "block"], "ground").all()
    assert not resting.in_contact(resting.link_names, resting.object_names).any()


def test_copies_differ_and_a_reset_ends_contacts() -> None:
    with tool0.Batch(2, scene=stack(0.1)) as batch:
        batch.place("block", [[0.5, 0.3, FLOOR + 0.06], [0.5, 0.3, 0.5]])
        batch.run(0.1)
        assert batch.in_contact("block", "shelf").tolist() == [True, False]
        batch.reset([0])
        assert batch.in_contact("shelf").tolist() == [False, True]
        assert set(batch.contacts().copy) == {1}


def test_wrong_names_are_refused(resting: tool0.Batch) -> None:
    with raises_naming(ControlError, "Batch.contacts", "'blok'", "'block'"):
        resting.contacts("blok")
    with raises_naming(ControlError, "Batch.in_contact", "'wrist_4_link'"):
        resting.in_contact("block", ["shelf", "wrist_4_link"])
    with raises_naming(ControlError, "Batch.contacts", "copy 2"):
        resting.contacts(which=[2])
    with pytest.raises(ValueError, match="read-only"):
        resting.contacts().force[0] = 0.0


@needs_warp
def test_who_touches_whom_on_a_device() -> None:
    scene = stack(0.1)
    with tool0.Batch(2, scene=scene, device=device_under_test()) as batch:
        batch.place("block", [[0.5, 0.3, FLOOR + 0.06], [0.5, 0.3, 0.5]])
        assert not batch.in_contact("shelf").any()
        batch.run(0.1)
        assert batch.in_contact("block", "shelf").tolist() == [True, False]
        assert batch.in_contact("shelf", "block").tolist() == [True, False]
        assert batch.in_contact("shelf", "ground").all()
        assert not batch.in_contact("can", "shelf").any()
        batch.reset([1])
        assert batch.in_contact("can").tolist() == [True, False]
        with raises_naming(ControlError, "Batch.contacts", "device='cpu'"):
            batch.contacts()
