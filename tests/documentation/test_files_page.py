"""docs/reference/files.md has every key that is read, and its examples are read."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path
from typing import get_args

import msgspec
import pytest
from document import blocks

from tool0.control.dialect import Dialect
from tool0.control.joint_limits import joint_limit_parameters
from tool0.control.ros1.dialect import ROS1
from tool0.control.ros2.dialect import ROS2
from tool0.description.camera import Camera
from tool0.description.catalogue import find_part
from tool0.description.cell_file import load_cell
from tool0.description.config import DescriptionConfig
from tool0.description.scene import SceneObject
from tool0.description.scene_file import load_scene
from tool0.description.shapes import SHAPES
from tool0.description.yaml_tree import read_mapping
from tool0.lint.check import check
from tool0.programs.files import read_program
from tool0.protocol.program import Program, Step, ToolPose
from tool0.recording.episodes import EpisodeRow

PAGE = Path(__file__).parents[2] / "docs/reference/files.md"
TEXT = PAGE.read_text(encoding="utf-8")
NOT_OF_A_CELL = {"prefix", "tf_prefix", "srdf", "robot", "cell", "robots", "namespaces"}
NOT_OF_A_CELL |= {"args", "relax_inertia", "ros2_control"}


def section(title: str) -> str:
    level = "###" if f"\n### {title}\n" in TEXT else "##"
    _, found, rest = TEXT.partition(f"\n{level} {title}\n")
    assert found, title
    return re.split(rf"\n#{{2,{len(level)}}} ", rest)[0]


def keys_in(text: str) -> set[str]:
    """Return the words in code, each part of a path by itself."""
    code = re.findall(r"`([^`\n]+)`", text)
    return {word for item in code for word in re.split(r"[/\s]", item)}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for block in blocks(PAGE):
        assert block.language == "yaml"
        (tmp_path / block.title).write_text(block.text, encoding="utf-8")
    solid = "solid part\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 9 0 0\n"
    end = "vertex 0 9 0\nendloop\nendfacet\nendsolid part\n"
    (tmp_path / "part.stl").write_text(solid + end, encoding="ascii")
    (tmp_path / "right.yaml").write_text("{}", encoding="utf-8")
    return tmp_path


def test_the_examples_are_read(folder: Path) -> None:
    scene = load_scene(folder / "scene.yaml")
    assert {item.name for item in scene.objects} >= {"can", "mug", "tray.floor"}
    assert [camera.name for camera in scene.cameras] == ["above", "palm"]
    assert [robot.name for robot in load_cell(folder / "cell.yaml").robots] == [
        "left",
        "right",
    ]
    program = read_program(folder / "pick.yaml").program
    assert program.tool.xyz == pytest.approx((0.0, 0.0, 0.1418))
    findings = check(folder / "controllers.yaml").findings
    assert not findings


def test_every_key_of_scenes_cells_and_programs_is_on_the_page() -> None:
    objects = {item.name for item in fields(SceneObject)} - {"geometry"}
    assert objects | {*SHAPES, "bin", "shapes"} <= keys_in(section("Objects"))
    cameras = {item.name for item in fields(Camera)} - {"location"}
    assert cameras <= keys_in(section("Cameras"))
    robots = {item.name for item in fields(DescriptionConfig)} - NOT_OF_A_CELL
    robots -= {"base_xyz", "base_rpy", "mount_xyz", "mount_rpy"}
    assert robots <= keys_in(section("Cells"))
    named = keys_in(section("Programs"))
    for kind in (Program, ToolPose, *get_args(Step)):
        assert {item.name for item in msgspec.structs.fields(kind)} <= named, kind
        tag = kind.__struct_config__.tag
        assert tag is None or str(tag) in named
    rows = keys_in(section("Recordings and data sets"))
    assert {item.name for item in msgspec.structs.fields(EpisodeRow)} <= rows


@pytest.mark.parametrize(
    ("dialect", "title"), [(ROS1, "ros_control"), (ROS2, "ros2_control")]
)
def test_every_parameter_of_controllers_is_on_the_page(
    dialect: Dialect, title: str
) -> None:
    text = section(title)
    # The gains and the gripper's parameters of ROS 2 are those of ROS 1.
    named = keys_in(text) | (keys_in(section("ros_control")) if "2" in title else set())
    for kind in dialect.types:
        assert f"`{kind}`" in text
        for parameter in dialect.parameters_of(kind):
            missing = {*parameter.split("/")} - {"*"} - named
            assert not missing, (kind, parameter)
    assert joint_limit_parameters() <= keys_in(section("ros_control"))


def test_the_keys_of_gains_are_those_of_the_built_in_folders() -> None:
    file = find_part("arm", "ur5").folder / "gains.yaml"
    assert set(read_mapping(file).children) <= keys_in(section("Gains"))


def defaults_in(text: str, heading: str) -> dict[str, str]:
    """Return parameter → default, of the rows of a table."""
    _, found, rest = text.partition(f"| {heading} | default | meaning |\n")
    assert found, heading
    table: dict[str, str] = {}
    for row in rest.partition("\n\n")[0].splitlines()[1:]:
        cells = [cell.strip() for cell in row.strip("|").split("|")]
        names = re.findall(r"`([^`]+)`", cells[0])
        stem = names[0].rpartition("/")[0]
        names = [name.replace("…", stem).replace("JOINT", "*") for name in names]
        values = cells[1].split(", ")
        values *= 1 if len(values) == len(names) else len(names)
        table |= dict(zip(names, values, strict=True))
    return table


TRAJECTORY = "parameter of a trajectory controller"
GRIPPER = "parameter of a gripper's controller"


@pytest.mark.parametrize(
    ("dialect", "title", "heading", "kind"),
    [
        (
            ROS1,
            "ros_control",
            TRAJECTORY,
            "effort_controllers/JointTrajectoryController",
        ),
        (ROS1, "ros_control", GRIPPER, "effort_controllers/GripperActionController"),
        (
            ROS2,
            "ros2_control",
            TRAJECTORY,
            "joint_trajectory_controller/JointTrajectoryController",
        ),
    ],
    ids=["ros1-trajectory", "ros1-gripper", "ros2-trajectory"],
)
def test_the_defaults_of_controllers_are_those_of_the_code(
    dialect: Dialect, title: str, heading: str, kind: str
) -> None:
    values = dialect.values_of(kind)
    compared = 0
    for name, written in defaults_in(section(title), heading).items():
        value = values.get(name)
        if not written or name.endswith("/p"):  # not used; of the sample
            continue
        if isinstance(value, bool):
            assert written == str(value).lower(), name
        elif isinstance(value, float) and abs(value) < 1e300 and written != "required":
            assert float(written) == value, name
        else:
            continue
        compared += 1
    assert compared >= 4


def test_the_defaults_of_steps_are_those_of_the_code() -> None:
    _, _, rest = section("Programs").partition("| kind | key | value | default |")
    step, defaults = "", {}
    for row in rest.partition("\n\n")[0].splitlines()[2:]:
        kind, key, _, default, _ = (c.strip() for c in row.strip("|").split("|"))
        step = kind.strip("`") or step
        names = re.findall(r"`(\w+)`", key)
        values = default.split(", ")
        values *= 1 if len(values) == len(names) else len(names)
        defaults |= {(step, n): v for n, v in zip(names, values, strict=True)}
    compared = 0
    for kind in get_args(Step):
        tag = str(kind.__struct_config__.tag)
        for item in msgspec.structs.fields(kind):
            written = defaults.get((tag, item.name))
            if isinstance(item.default, bool):
                assert written in (str(item.default).lower(), ""), (tag, item.name)
            elif isinstance(item.default, float) and written != "":
                assert float(written or "nan") == item.default, (tag, item.name)
            else:
                continue
            compared += 1
    assert compared > 10
