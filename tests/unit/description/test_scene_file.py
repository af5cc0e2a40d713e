import math
from pathlib import Path

import pytest

from tool0.description.scene import PALETTE, STILL_RGBA, Scene, SceneObject
from tool0.description.scene_file import load_scene
from tool0.description.shapes import Box, Cylinder, Mesh, Sphere
from tool0.description.transform import Pose
from tool0.errors import ConfigError

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


def test_it_knows_where_each_object_is_written(tmp_path: Path) -> None:
    text = (
        "objects:\n- {name: a, sphere: {radius: 1}}\n- {name: b, sphere: {radius: 1}}"
    )
    locations = scene_of(text, tmp_path).locations
    assert {name: place.line for name, place in locations.items()} == {"a": 2, "b": 3}


@pytest.mark.parametrize("text", ["", "# nothing\n", "objects:\n", "objects: []\n"])
def test_an_empty_file_is_an_empty_scene(text: str, tmp_path: Path) -> None:
    assert scene_of(text, tmp_path) == Scene()


HEAD = "objects:\n- {name: first, sphere: {radius: 1}}\n"
BAD = {
    "no file of objects": (
        "thing: 1",
        1,
        "unknown key 'thing'; valid: cameras, objects",
    ),
    "near miss": ("object: []", 1, "did you mean 'objects'"),
    "no list": ("objects: 3", 1, "'objects' must be a list, got 3"),
    "no mapping": (HEAD + "- 3", 3, r"'objects\[1\]' must be a mapping, got 3"),
    "not a mapping at all": ("- 3", 1, "expected a mapping"),
    "not YAML": (HEAD + "- {", 4, "not YAML"),
    "unknown key": (
        HEAD + "- name: a\n  sphere: {radius: 1}\n  weight: 3",
        5,
        r"unknown key 'objects\[1\]/weight'",
    ),
    "misspelt key": (
        HEAD + "- name: a\n  sphere: {radius: 1}\n  frction: 3",
        5,
        "did you mean 'friction'",
    ),
    "misspelt size": (
        HEAD + "- name: a\n  sphere:\n    radus: 1",
        5,
        r"unknown key 'objects\[1\]/sphere/radus'; did you mean 'radius'",
    ),
    "misspelt pose": (
        HEAD + "- {name: a, sphere: {radius: 1}, pose: {xy: [0, 0]}}",
        3,
        "did you mean 'xyz'",
    ),
    "key twice": (
        HEAD + "- name: a\n  mass: 1\n  mass: 2\n  sphere: {radius: 1}",
        5,
        r"'objects\[1\]/mass' stands twice",
    ),
    "no name": (HEAD + "- {sphere: {radius: 1}}", 3, "lacks 'name'"),
    "name no text": (HEAD + "- {name: 3, sphere: {radius: 1}}", 3, "must be a text"),
    "bad name": (HEAD + "- {name: a/b, sphere: {radius: 1}}", 3, "cannot name"),
    "same name": (
        HEAD + "- {name: first, sphere: {radius: 1}}",
        3,
        r"two objects are called 'first', the other at .*scene.yaml:2",
    ),
    "no shape": (HEAD + "- {name: a}", 3, "'a' has no shape; give it one of box"),
    "two shapes": (
        HEAD + "- {name: a, sphere: {radius: 1}, box: {size: [1, 1, 1]}}",
        3,
        "'a' has box and sphere",
    ),
    "shape no mapping": (HEAD + "- {name: a, box: [1, 1, 1]}", 3, "must be a mapping"),
    "no size": (HEAD + "- {name: a, box: {}}", 3, "lacks 'size', a list of 3"),
    "two sizes": (HEAD + "- {name: a, box: {size: [1, 1]}}", 3, "a list of 3 numbers"),
    "negative size": (
        HEAD + "- name: a\n  box:\n    size: [1, -1, 1]",
        4,
        "each edge of the box of object 'a' must be above 0 m and finite, got 1, -1, 1",
    ),
    "NaN size": (HEAD + "- {name: a, box: {size: [1, .nan, 1]}}", 3, "finite number"),
    "text for size": (HEAD + "- {name: a, sphere: {radius: big}}", 3, "a number, got"),
    "zero mass": (
        HEAD + "- {name: a, sphere: {radius: 1}, mass: 0}",
        3,
        "mass of object 'a' must be above 0 kg",
    ),
    "negative friction": (
        HEAD + "- {name: a, sphere: {radius: 1}, friction: -1}",
        3,
        "friction of object 'a' must be 0 or more",
    ),
    "pale": (
        HEAD + "- {name: a, sphere: {radius: 1}, rgba: [1, 1, 1]}",
        3,
        "a list of 4 numbers",
    ),
    "too bright": (
        HEAD + "- {name: a, sphere: {radius: 1}, rgba: [1, 1, 255, 1]}",
        3,
        "rgba of object 'a' must be four numbers within 0 … 1",
    ),
    "infinite pose": (
        HEAD + "- {name: a, sphere: {radius: 1}, pose: {xyz: [0, 0, .inf]}}",
        3,
        r"'objects\[1\]/pose/xyz\[2\]' must be a finite number",
    ),
    "bin with a mass": (
        HEAD + "- {name: a, bin: {size: [1, 1, 1]}, mass: 1}",
        3,
        "bin 'a' stands still; leave out its mass",
    ),
    "bin of walls alone": (
        HEAD + "- name: a\n  bin:\n    size: [0.1, 0.1, 0.1]\n    wall: 0.05",
        4,
        "the walls of bin 'a' must be above 0 m and leave room inside, got wall 0.05",
    ),
    "bin and another": (
        HEAD
        + "- {name: a.left, sphere: {radius: 1}}\n- {name: a, bin: {size: [1, 1, 1]}}",
        4,
        "two objects are called 'a.left'",
    ),
    "no mesh file": (HEAD + "- {name: a, mesh: {}}", 3, "lacks 'file'"),
    "absent mesh": (HEAD + "- {name: a, mesh: {file: b.stl}}", 3, "there is no mesh"),
    "strange mesh": (HEAD + "- {name: a, mesh: {file: b.step}}", 3, "convert it"),
    "strange place": (
        HEAD + "- {name: a, mesh: {file: 'http://b.stl'}}",
        3,
        "nothing reads 'http://'",
    ),
}


@pytest.mark.parametrize(("text", "line", "message"), BAD.values(), ids=BAD)
def test_what_is_wrong_is_told_with_file_and_line(
    text: str, line: int, message: str, tmp_path: Path
) -> None:
    with pytest.raises(ConfigError, match=message) as caught:
        scene_of(text, tmp_path)
    assert str(caught.value).startswith(f"{tmp_path / 'scene.yaml'}:{line}: ")


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"none\.yaml: cannot read the file"):
        load_scene(tmp_path / "none.yaml")


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
    with pytest.raises(ConfigError, match="'table_and_bn'; did you mean"):
        load_scene("table_and_bn")
    monkeypatch.chdir(tmp_path)  # a person's own file of this name comes first
    Path("table_and_bin").write_text("objects: []")
    assert load_scene("table_and_bin") == Scene()
