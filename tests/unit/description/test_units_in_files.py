"""One way to write units in every file, and values that must be in another unit."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tool0.description.cell_file import load_cell
from tool0.description.config import DescriptionConfig
from tool0.description.rigid_model import read_rigid_model
from tool0.description.scene import Scene, SceneObject, bin_walls
from tool0.description.scene_file import load_scene
from tool0.description.shapes import Box, Compound, Cylinder, Solid, Sphere
from tool0.description.transform import Pose
from tool0.errors import ConfigError
from tool0.programs.files import read_program
from tool0.protocol.program import MoveLinearStep

ANGLE = math.pi / 6.0
Read = Callable[[Path, str], Pose]


def in_scene(file: Path, pose: str) -> Pose:
    file.write_text(f"objects: [{{name: a, sphere: {{radius: 10mm}}, pose: {pose}}}]")
    return load_scene(file).objects[0].pose


def in_scene_of_cell(file: Path, pose: str) -> Pose:
    file.write_text(
        "robots: [{name: a, arm: ur5}]\n"
        f"scene: {{objects: [{{name: a, sphere: {{radius: 10mm}}, pose: {pose}}}]}}"
    )
    scene = load_cell(file).scene
    assert scene is not None
    assert isinstance(scene, Scene)
    return scene.objects[0].pose


def in_cell(file: Path, pose: str) -> Pose:
    file.write_text(f"robots: [{{name: a, arm: ur5, base: {pose}}}]")
    described = load_cell(file).robots[0].description
    x, y, z = described.base_xyz or ()
    roll, pitch, yaw = described.base_rpy or ()
    return Pose(xyz=(x, y, z), rpy=(roll, pitch, yaw))


def in_program(file: Path, pose: str) -> Pose:
    file.write_text(f"name: p\nsteps: [{{kind: move_linear, pose: {pose}}}]")
    (step,) = read_program(file).program.steps
    assert isinstance(step, MoveLinearStep)
    assert step.pose is not None
    return Pose(xyz=step.pose.xyz, rpy=step.pose.rpy)


every_file = pytest.mark.parametrize(
    "read", [in_scene, in_scene_of_cell, in_cell, in_program]
)


@every_file
@pytest.mark.parametrize(
    "angle",
    [
        *("30deg", "30 deg", "deg(30)", "!degrees 30", f"{ANGLE}rad"),
        *(f"rad({ANGLE})", f"!radians {ANGLE}", f"{ANGLE}"),
    ],
)
def test_an_angle_is_written_alike_in_every_file(
    read: Read, angle: str, tmp_path: Path
) -> None:
    pose = read(tmp_path / "a.yaml", f"{{xyz: [0, 0, 0], rpy: [0, {angle}, 0]}}")
    assert pose.rpy == pytest.approx((0.0, ANGLE, 0.0), abs=1e-15)


@every_file
@pytest.mark.parametrize("length", ["400mm", "400 mm", "0.4m", "0.4", "4e-1"])
def test_a_length_is_written_alike_in_every_file(
    read: Read, length: str, tmp_path: Path
) -> None:
    pose = read(tmp_path / "a.yaml", f"{{xyz: [0, {length}, 0], rpy: [0, 0, 0]}}")
    assert pose.xyz == pytest.approx((0.0, 0.4, 0.0))


@every_file
@pytest.mark.parametrize(
    ("xyz", "rpy", "said"),
    [
        ("[0, 30deg, 0]", "[0, 0, 0]", "'deg' is not a unit here"),
        ("[0, !degrees 30, 0]", "[0, 0, 0]", "'deg' is not a unit here"),
        ("[0, 0, 0]", "[0, 30mm, 0]", "'mm' is not a unit here"),
        ("[0, 0, 0]", "[0, 3cm, 0]", "'cm' is not a unit here"),
    ],
)
def test_a_wrong_unit_is_named_with_its_line(
    read: Read, xyz: str, rpy: str, said: str, tmp_path: Path
) -> None:
    with pytest.raises(ConfigError, match=said) as error:
        read(tmp_path / "a.yaml", f"{{xyz: {xyz}, rpy: {rpy}}}")
    assert error.value.location is not None
    assert error.value.location.line is not None


def test_every_length_and_angle_of_a_scene_has_units(tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text(
        "objects:\n"
        "  - {name: box, box: {size: [40mm, 0.04, 4e-2]}}\n"
        "  - {name: can, cylinder: {radius: 30mm, length: 100 mm}}\n"
        "  - {name: tray, bin: {size: [300mm, 200mm, 100mm], wall: 4mm}}\n"
        "cameras:\n"
        "  - name: above\n"
        "    field_of_view: 45deg\n"
        "    near: 10mm\n"
        "    pose: {xyz: [0, 0, 1200mm], look_at: [100mm, 0, 0], up: [0, 1, 0]}\n"
    )
    scene = load_scene(file)
    box, can, floor, *_ = (item.geometry for item in scene.objects)
    assert box == Box(size=(0.04, 0.04, 0.04))
    assert can == Cylinder(radius=0.03, length=0.1)
    assert floor == Box(size=(0.3, 0.2, 0.004))
    (camera,) = scene.cameras
    assert (camera.near, camera.pose.xyz[2]) == (0.01, 1.2)
    assert camera.field_of_view == pytest.approx(math.pi / 4.0)


@pytest.mark.parametrize("value", ["mass: 30mm", "friction: 30deg"])
def test_what_is_neither_length_nor_angle_has_no_unit(
    value: str, tmp_path: Path
) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text(f"objects: [{{name: a, sphere: {{radius: 0.1}}, {value}}}]")
    with pytest.raises(ConfigError, match="must be a number, got '30"):
        load_scene(file)


# ---- values that must be in another unit ---------------------------------------------


def test_a_pose_in_degrees_is_refused() -> None:
    said = "rpy: 180 rad is no plausible angle; did you mean 180deg = 3.142 rad?"
    for angles in ((180, 0, 0), [0, 180.0, 0], np.array([0, 0, 180], np.float32)):
        with pytest.raises(ConfigError) as error:
            Pose(rpy=angles)  # type: ignore[arg-type]
        assert str(error.value) == said
    with pytest.raises(ConfigError, match="base_rpy: -90 rad"):
        DescriptionConfig(base_rpy=(0, 0, -90))


def test_what_is_no_list_of_angles_is_left() -> None:
    others: tuple[Any, ...] = (None, 180, "180", np.array(180.0), 1j, [None, "x"])
    for other in others:
        assert Pose(rpy=other).rpy is other


@pytest.mark.parametrize(
    "angle", [math.tau, -3.0 * math.pi, math.nan, math.inf, 10**400, sys.float_info.min]
)
def test_other_angles_are_left(angle: float) -> None:
    assert Pose(rpy=(0.0, 0.0, angle)).rpy[2] is angle


@pytest.mark.parametrize(
    "solid",
    [
        Box(size=(40, 60, 40)),
        Cylinder(radius=30, length=100),
        Sphere(radius=25),
        Compound(parts=((Box(size=(40, 40, 40)), Pose()),)),
    ],
)
@pytest.mark.parametrize("mass", [None, 0.1])
def test_a_body_in_mm_is_refused(solid: Solid, mass: float | None) -> None:
    with pytest.raises(ConfigError, match=r"size of the \w+ of .* is \d+ x .* mean"):
        SceneObject(name="part", geometry=solid, mass=mass)


def test_a_bin_in_mm_is_refused() -> None:
    with pytest.raises(
        ConfigError, match="the size of bin 'tray' is 300 x 200 x 100 m"
    ):
        bin_walls("tray", size=(300, 200, 100))


@pytest.mark.parametrize(
    "size", [(30.0, 30.0, 10.0), (200.0, 200.0, 0.1), (12.0, 0.2, 6.0)]
)
def test_floors_and_walls_are_as_large_as_rooms(
    size: tuple[float, float, float],
) -> None:
    SceneObject(name="ground", geometry=Box(size=size))


def test_models_of_others_may_turn_more_than_once() -> None:
    model = read_rigid_model(
        '<robot name="thing"><link name="body">'
        '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'
        "<collision>"
        '<origin rpy="0 0 90"/><geometry><box size="1 1 1"/></geometry>'
        "</collision></link></robot>"
    )
    assert model.geometry == Box(size=(1.0, 1.0, 1.0))
