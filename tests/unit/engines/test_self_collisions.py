"""Which links of a robot collide with each other, and with which shapes."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from tool0.description.model import (
    Collision,
    Inertial,
    Joint,
    JointType,
    Link,
    RobotModel,
)
from tool0.description.shapes import Mesh, Sphere
from tool0.description.transform import Pose, Vector3
from tool0.description.urdf import read_model
from tool0.description.xml_source import parse_text
from tool0.engines.mujoco.convex_parts import convex_parts
from tool0.engines.mujoco.engine import MujocoEngine

BALL = (
    '<link name="{name}"><inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" '
    'izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial><collision><geometry>'
    '<sphere radius="0.2"/></geometry></collision></link>'
)
WHEEL = (
    '<joint name="{name}" type="continuous"><parent link="{parent}"/>'
    '<child link="{child}"/><limit effort="1" velocity="1"/></joint>'
)
FLAG = '<gazebo reference="{}"><selfCollide>true</selfCollide></gazebo>'


@pytest.mark.parametrize(
    ("flags", "touching"),
    [
        ("", set()),
        (FLAG.format("tip"), set()),
        (FLAG.format("tip") + FLAG.format("base"), {("base", "tip")}),
        ("<self_collide>true</self_collide>", {("base", "tip")}),
        ("<gazebo><self_collide>1</self_collide></gazebo>", {("base", "tip")}),
        ("<gazebo><self_collide>0</self_collide></gazebo>", set()),
    ],
)
def test_links_collide_with_each_other_as_in_gazebo(
    flags: str, touching: set[tuple[str, str]]
) -> None:
    links = "".join(BALL.format(name=name) for name in ("base", "middle", "tip"))
    joints = WHEEL.format(name="a", parent="base", child="middle")
    joints += WHEEL.format(name="b", parent="middle", child="tip")
    text = f'<robot name="r">{links}{joints}{flags}</robot>'
    model = read_model(parse_text(text))
    # a joint connects the other pairs
    assert _touching(MujocoEngine(model, ground=None)) == touching


def _write_stl(file: Path, boxes: list[tuple[Vector3, Vector3]]) -> None:
    """Write boxes, each by two corners, as one mesh."""
    faces = ("013 032", "457 476", "015 054", "237 276", "026 064", "137 175")
    triangles = []
    for lower, upper in boxes:
        corners = [
            (x, y, z)
            for z in (lower[2], upper[2])
            for y in (lower[1], upper[1])
            for x in (lower[0], upper[0])
        ]
        triangles += [
            struct.pack(
                "<12fH", 0, 0, 0, *(v for k in face for v in corners[int(k)]), 0
            )
            for pair in faces
            for face in pair.split()
        ]
    file.write_bytes(
        bytes(80) + struct.pack("<I", len(triangles)) + b"".join(triangles)
    )


def test_a_concave_mesh_that_collides_with_links_is_cut_into_convex_parts(
    tmp_path: Path,
) -> None:
    # A tube with a housing at each end, on one side: the hull fills the space between.
    file = tmp_path / "link.stl"
    tube = ((0.0, 0.0, 0.0), (0.5, 0.05, 0.05))
    housings = [((x, 0.05, 0.0), (x + 0.1, 0.15, 0.05)) for x in (0.0, 0.4)]
    _write_stl(file, [tube, *housings])
    mesh = Mesh(uri=str(file), path=file)
    parts = convex_parts(mesh)
    boxes = sorted(
        tuple(map(tuple, np.round((part.min(axis=0), part.max(axis=0)), 3).tolist()))
        for part in parts
    )
    assert len(boxes) == 3
    (_, left), (start, middle), (right, _) = boxes
    assert middle[1] == 0.05  # the tube alone
    assert 0.1 <= left[0] == start[0] <= 0.15
    assert 0.35 <= middle[0] == right[0] <= 0.4
    box = tmp_path / "box.stl"
    _write_stl(box, [tube])
    assert len(convex_parts(Mesh(uri=str(box), path=box))) == 1

    between = Link(
        name="tip",
        inertial=Inertial(mass=1.0, ixx=0.1, iyy=0.1, izz=0.1),
        collisions=(
            Collision(geometry=Sphere(radius=0.02), origin=Pose(xyz=(0.25, 0.1, 0.02))),
        ),
        self_collide=True,
    )
    arm = Link(name="arm", collisions=(Collision(geometry=mesh),), self_collide=True)
    joints = (
        Joint(name="a", type=JointType.FIXED, parent="world", child="arm"),
        Joint(name="b", type=JointType.CONTINUOUS, parent="world", child="tip"),
    )
    model = RobotModel(
        name="r", root="world", links=(Link(name="world"), arm, between), joints=joints
    )
    assert _touching(MujocoEngine(model, ground=None)) == set()


def _touching(engine: MujocoEngine) -> set[tuple[str, ...]]:
    zeros = [0.0] * len(engine.read().position)
    engine.reset(zeros)
    engine.write(zeros)
    engine.step()
    return {tuple(sorted((c.first, c.second))) for c in engine.world.contacts()}
