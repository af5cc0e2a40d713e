"""Scenes in YAML files, read into values."""

import math
from pathlib import Path

import pytest

from tool0.description.camera import Camera, looking
from tool0.description.scene import PALETTE, STILL_RGBA, Scene, SceneObject
from tool0.description.scene_file import load_scene
from tool0.description.shapes import Box, Compound, Cylinder, Mesh, Sphere
from tool0.description.transform import Pose
from tool0.errors import ConfigError, SourceLocation

FULL = """
objects:
  - name: table
    box: {size: [0.6, 0.8, 0.04]}
    pose: {xyz: [0.6, 0, -0.02], rpy: [0, 0, deg(90)]}
    rgba: [0.1, 0.2, 0.3, 0.4]
  - {name: can, cylinder: {radius: 0.03, length: 0.1}, mass: 0.2, friction: 0.6}
  - {name: ball, sphere: {radius: 0.02}, mass: 1, pose: {xyz: [1, 2, 3]}}
  - {name: part, mesh: {file: shapes/part.stl, scale: [1, 1, 0.001]}}
"""


def scene_of(text: str, folder: Path) -> Scene:
    path = folder / "scene.yaml"
    path.write_text(text)
    return load_scene(path)


def test_it_reads_every_key(tmp_path: Path) -> None:
    mesh = tmp_path / "shapes" / "part.stl"
    mesh.parent.mkdir()
    mesh.touch()  # its file counts from the YAML's folder; the engine reads it
    assert scene_of(FULL, tmp_path).objects == (
        SceneObject(
            name="table",
            geometry=Box(size=(0.6, 0.8, 0.04)),
            pose=Pose(xyz=(0.6, 0.0, -0.02), rpy=(0.0, 0.0, math.pi / 2)),
            rgba=(0.1, 0.2, 0.3, 0.4),
        ),
        SceneObject(
            name="can",
            geometry=Cylinder(radius=0.03, length=0.1),
            mass=0.2,
            friction=0.6,
            rgba=PALETTE[0],
        ),
        SceneObject(
            name="ball",
            geometry=Sphere(radius=0.02),
            mass=1.0,
            pose=Pose(xyz=(1.0, 2.0, 3.0)),
            rgba=PALETTE[1],
        ),
        SceneObject(
            name="part",
            geometry=Mesh(
                uri="shapes/part.stl", path=mesh.absolute(), scale=(1.0, 1.0, 0.001)
            ),
            rgba=STILL_RGBA,
        ),
    )


EVERY_CAMERA_KEY = """
cameras:
  - name: palm
    link: tool0
    pose: {xyz: [0, 0, 0.1], rpy: [0, 0, deg(90)]}
    width: 320
    height: 200
    field_of_view: deg(60)
    near: 0.02
    far: 3
  - {name: above, pose: {xyz: [0.5, 0, 1], look_at: [0.5, 0, 0], up: [1, 0, 0]}}
  - {name: side, pose: {xyz: [0, 2, 1], look_at: [0, 0, 0]}}
"""


def test_it_reads_every_key_of_cameras(tmp_path: Path) -> None:
    assert scene_of(EVERY_CAMERA_KEY, tmp_path).cameras == (
        Camera(
            name="palm",
            link="tool0",
            pose=Pose(xyz=(0.0, 0.0, 0.1), rpy=(0.0, 0.0, math.pi / 2)),
            width=320,
            height=200,
            field_of_view=math.radians(60.0),
            near=0.02,
            far=3.0,
        ),
        Camera(
            name="above",
            pose=looking((0.5, 0.0, 1.0), (0.5, 0.0, 0.0), (1.0, 0.0, 0.0)),
        ),
        Camera(name="side", pose=looking((0.0, 2.0, 1.0), (0.0, 0.0, 0.0))),
    )


def test_an_object_may_have_several_shapes(tmp_path: Path) -> None:
    (mug,) = scene_of(
        """
objects:
- name: mug
  mass: 0.3
  shapes:
  - {cylinder: {radius: 0.04, length: 0.1}}
  - {box: {size: [1, 2, 3]}, pose: {xyz: [0.05, 0, 0], rpy: [0, 0, deg(90)]}}
""",
        tmp_path,
    ).objects
    handle = Pose(xyz=(0.05, 0.0, 0.0), rpy=(0.0, 0.0, math.pi / 2))
    assert mug.geometry == Compound(
        parts=(
            (Cylinder(radius=0.04, length=0.1), Pose()),
            (Box(size=(1.0, 2.0, 3.0)), handle),
        )
    )
    assert mug.mass == 0.3


@pytest.mark.parametrize("text", ["", "# nothing\n", "objects:\n", "objects: []\n"])
def test_an_empty_file_is_an_empty_scene(text: str, tmp_path: Path) -> None:
    assert scene_of(text, tmp_path) == Scene()


HEAD = "objects:\n- {name: first, sphere: {radius: 1}}\n"
CAMERAS = "cameras:\n- {name: first}\n"
BALL = "sphere: {radius: 1}"
SHAPES = HEAD + "- name: a\n  shapes:\n"
WRONG: list[tuple[str, int, str]] = [  # text, line of the error, what it names
    ("thing: 1", 1, "objects"),
    ("object: []", 1, "'objects'"),
    ("objects: 3", 1, "'objects'"),
    (HEAD + "- 3", 3, "'objects[1]'"),
    ("- 3", 1, ""),
    (HEAD + "- {", 4, ""),
    (HEAD + f"- name: a\n  {BALL}\n  weight: 3", 5, "'objects[1]/weight'"),
    (HEAD + f"- name: a\n  {BALL}\n  frction: 3", 5, "'friction'"),
    (HEAD + "- name: a\n  sphere:\n    radus: 1", 5, "'radius'"),
    (HEAD + f"- {{name: a, {BALL}, pose: {{xy: [0, 0]}}}}", 3, "'xyz'"),
    (HEAD + f"- name: a\n  mass: 1\n  mass: 2\n  {BALL}", 5, "'objects[1]/mass'"),
    (HEAD + f"- {{{BALL}}}", 3, "'name'"),
    (HEAD + f"- {{name: 3, {BALL}}}", 3, "name"),
    (HEAD + f"- {{name: a/b, {BALL}}}", 3, "'a/b'"),
    (HEAD + f"- {{name: first, {BALL}}}", 3, "scene.yaml:2"),
    (HEAD + "- {name: a}", 3, "'a'"),
    (HEAD + f"- {{name: a, {BALL}, box: {{size: [1, 1, 1]}}}}", 3, "box and sphere"),
    (HEAD + "- {name: a, box: [1, 1, 1]}", 3, "box"),
    (HEAD + "- {name: a, box: {}}", 3, "'size'"),
    (HEAD + "- {name: a, box: {size: [1, 1]}}", 3, "3 numbers"),
    (HEAD + "- name: a\n  box:\n    size: [1, -1, 1]", 4, "1, -1, 1"),
    (HEAD + "- {name: a, box: {size: [1, .nan, 1]}}", 3, "size"),
    (HEAD + "- {name: a, sphere: {radius: big}}", 3, "radius"),
    (HEAD + f"- {{name: a, {BALL}, mass: 0}}", 3, "mass of object 'a'"),
    (HEAD + f"- {{name: a, {BALL}, friction: -1}}", 3, "friction of object 'a'"),
    (HEAD + f"- {{name: a, {BALL}, rgba: [1, 1, 1]}}", 3, "4 numbers"),
    (HEAD + f"- {{name: a, {BALL}, rgba: [1, 1, 255, 1]}}", 3, "rgba of object 'a'"),
    (HEAD + f"- {{name: a, {BALL}, pose: {{xyz: [0, 0, .inf]}}}}", 3, "xyz[2]"),
    (HEAD + "- {name: a, bin: {size: [1, 1, 1]}, mass: 1}", 3, "'a'"),
    (HEAD + "- name: a\n  bin:\n    size: [0.1, 0.1, 0.1]\n    wall: 0.05", 4, "0.05"),
    (f"objects:\n- {{name: a.left, {BALL}}}\n- {{name: a, bin: {{size: [1, 1, 1]}}}}",
     3, "'a.left'"),
    (HEAD + "- {name: a, mesh: {}}", 3, "'file'"),
    (HEAD + "- {name: a, mesh: {file: b.stl}}", 3, "b.stl"),
    (HEAD + "- {name: a, mesh: {file: b.step}}", 3, "b.step"),
    (HEAD + "- {name: a, mesh: {file: 'http://b.stl'}}", 3, "'http://'"),
    (HEAD + "- {name: a, shapes: 3}", 3, "a list"),
    (HEAD + "- name: a\n  shapes: []", 4, "of object 'a' is empty"),
    (SHAPES + f"  - {{{BALL}}}\n  {BALL}", 3, "sphere and shapes"),
    (SHAPES + f"  - {{{BALL}}}\n  - {{}}", 6, "shape 2 of object 'a' has no shape"),
    (SHAPES + f"  - {{{BALL}}}\n  - {BALL}\n    mass: 1", 7, "shapes[1]/mass"),
    (SHAPES + f"  - {BALL}\n    pose: {{xy: [0, 0]}}", 6, "'xyz'"),
    (SHAPES + f"  - {BALL}\n  - sphere: {{radius: -1}}", 6, "shape 2 of object 'a'"),
    (SHAPES + "  - shapes: []", 5, "shapes[0]/shapes"),
    (SHAPES + "  - mesh: {file: b.stl}", 5, "b.stl"),
    ("cameras: 3", 1, "'cameras'"),
    (CAMERAS + "- 3", 3, "'cameras[1]'"),
    (CAMERAS + "- {width: 3}", 3, "'name'"),
    (CAMERAS + "- {name: a, fov: 1}", 3, "fov"),
    (CAMERAS + "- {name: first}", 3, "scene.yaml:2"),
    (CAMERAS + "- {name: a,\n   width: 0.5}", 4, "width"),
    (CAMERAS + "- {name: a, width: 0}", 3, "width"),
    (CAMERAS + "- name: a\n  pose: {look_at: [0, 0, 0], rpy: [0, 0, 0]}", 4, "rpy"),
    (CAMERAS + "- {name: a, pose: {up: [1, 0, 0]}}", 3, "up"),
    (CAMERAS + "- name: a\n  pose: {xyz: [0, 0, 1], look_at: [0, 0, 0]}", 4, "up"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "line", "named"), WRONG)
def test_errors_have_file_and_line(
    text: str, line: int, named: str, tmp_path: Path
) -> None:
    with pytest.raises(ConfigError) as caught:
        scene_of(text, tmp_path)
    assert caught.value.location == SourceLocation(tmp_path / "scene.yaml", line)
    assert named in str(caught.value)


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError) as caught:
        load_scene(tmp_path / "none.yaml")
    assert "none.yaml" in str(caught.value)


def test_a_bin_is_floor_and_walls(tmp_path: Path) -> None:
    text = "objects:\n- {name: tray, bin: {size: [3, 2, 1], wall: 0.1}, friction: 0.4}"
    scene = scene_of(text, tmp_path)
    assert [item.name for item in scene.objects] == [
        f"tray.{part}" for part in ("floor", "front", "back", "left", "right")
    ]
    assert {item.friction for item in scene.objects} == {0.4}
    assert {place.line for place in scene.locations.values()} == {2}


def test_a_scene_that_comes_along_goes_by_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert "cube" in [item.name for item in load_scene("table_and_bin").objects]
    with pytest.raises(ConfigError) as caught:
        load_scene("table_and_bn")
    assert "'table_and_bin'" in str(caught.value)
    monkeypatch.chdir(tmp_path)  # a person's own file of this name comes first
    Path("table_and_bin").write_text("objects: []")
    assert load_scene("table_and_bin") == Scene()
