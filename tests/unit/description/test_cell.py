"""Cells: several robots of the catalogue in one model."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from raises_naming import raises_naming

import tool0
from tool0.description.camera import default_cameras
from tool0.description.cell_file import load_cell, parse_robots
from tool0.description.config import Cell, CellRobot, DescriptionConfig
from tool0.description.forward_kinematics import link_poses
from tool0.description.loading import assemble, load_description
from tool0.description.parts import find_arms, find_grippers, joints_of
from tool0.description.robot import RobotDescription
from tool0.description.scene import Scene
from tool0.description.shapes import Cylinder
from tool0.description.urdf import read_model
from tool0.description.xml_source import parse_text
from tool0.errors import ConfigError, DescriptionError

TWO = ("left=ur5+2f85@0,0.4,0", "right=ur5@0,-400mm,200mm,0,0,90deg")
FULL = """
robots:
  - name: left
    arm: ur5
    gripper: 2f85
    base: {xyz: [0, 0.4, 0]}
    mount: {xyz: [0, 0, 11mm], rpy: [0, 0, 90deg]}
    initial_pose: up
    controllers_file: left.yaml
    gripper_model: linkage
    pedestal_height: 50mm
    kinematics_params: params/left.yaml
    safety_limits: true
  - {name: right, arm: ./own_arm, initial_pose: {elbow_joint: 90deg}}
scene: {objects: [{name: ball, sphere: {radius: 0.02}}]}
namespaces: true
"""


def described(*robots: str) -> RobotDescription:
    return load_description(DescriptionConfig(robots=robots))


def cell_of(text: str, folder: Path) -> Path:
    path = folder / "press.yaml"
    path.write_text(text)
    return path


def test_the_short_form_names_arm_gripper_and_base() -> None:
    left, right = parse_robots(TWO).robots
    assert left.name == "left"
    assert left.description == DescriptionConfig(
        arm="ur5", gripper="2f85", base_xyz=(0.0, 0.4, 0.0)
    )
    assert right.description == DescriptionConfig(
        arm="ur5",
        gripper=None,
        base_xyz=(0.0, -0.4, 0.2),
        base_rpy=(0.0, 0.0, math.radians(90.0)),
    )


def test_a_file_gives_every_key(tmp_path: Path) -> None:
    cell = load_cell(cell_of(FULL, tmp_path))
    assert (cell.name, cell.namespaces) == ("press", True)
    assert isinstance(cell.scene, Scene)
    assert [item.name for item in cell.scene.objects] == ["ball"]
    left, right = cell.robots
    assert left.description == DescriptionConfig(
        arm="ur5",
        gripper="2f85",
        base_xyz=(0.0, 0.4, 0.0),
        mount_xyz=(0.0, 0.0, 0.011),
        mount_rpy=(0.0, 0.0, math.radians(90.0)),
        gripper_model="linkage",
        pedestal_height=0.05,
        kinematics_params=tmp_path / "params/left.yaml",
        safety_limits=True,
    )
    assert left.initial_pose == "up"
    assert left.controllers_file == tmp_path / "left.yaml"
    assert right.description.arm == str(tmp_path / "own_arm")
    assert right.description.gripper is None
    assert right.initial_pose == {"elbow_joint": math.radians(90.0)}
    assert right.location is not None
    assert (right.location.file, right.location.line) == (tmp_path / "press.yaml", 14)


def test_a_scene_is_a_file_beside_the_cell_or_a_built_in_one(tmp_path: Path) -> None:
    beside = tmp_path / "things.yaml"
    beside.write_text("objects: []")
    robots = "robots: [{name: a, arm: ur5}]\n"
    found = load_cell(cell_of(f"{robots}scene: things.yaml", tmp_path))
    assert found.scene == beside
    found = load_cell(cell_of(f"{robots}scene: table_and_bin", tmp_path))
    assert Path(str(found.scene)).name == "table_and_bin.yaml"


def test_the_robots_are_one_model_below_one_world() -> None:
    description = described(*TWO)
    model = description.model
    assert model.root == "world"
    assert [(item.name, item.prefix) for item in description.robots] == [
        ("left", "left_"),
        ("right", "right_"),
    ]
    assert description.title == "left: ur5 + 2f85, right: ur5"
    names = {joint.name for joint in model.joints}
    alone = assemble(prefix="left_").model, assemble(gripper=None).model
    assert names == {
        *(joint.name for joint in alone[0].joints),
        *(f"right_{joint.name}" for joint in alone[1].joints),
    }
    poses = link_poses(model)
    assert poses["left_base_link"].position == pytest.approx((0.0, 0.4, 0.0))
    assert poses["right_base_link"].position == pytest.approx((0.0, -0.4, 0.2))
    assert poses["right_base_link"].rotate((1, 0, 0)) == pytest.approx((0, 1, 0))


def test_each_robot_is_as_it_is_alone() -> None:
    model = described("left=ur5+2f85@0,0.4,0", "right=ur5@0,-0.4,0").model
    alone = assemble(prefix="left_", base_xyz=(0, 0.4, 0)).model
    for link in alone.links:
        assert model.link(link.name) == link
    for joint in alone.joints:
        assert model.joint(joint.name) == joint
    assert set(alone.transmissions) < set(model.transmissions)
    assert model.grippers == alone.grippers


def test_its_urdf_is_one_document_that_reads_back() -> None:
    description = described(*TWO)
    assert description.urdf.count('<link name="world"') == 1
    assert read_model(parse_text(description.urdf)) == description.model


def test_parts_have_the_names_of_their_robots() -> None:
    model = described(*TWO).model
    assert list(find_arms(model)) == ["left", "right"]
    assert list(find_grippers(model)) == ["left"]
    assert joints_of(model, "right") == tuple(
        f"right_{joint.name}" for joint in assemble(gripper=None).model.movable_joints
    )
    assert len(joints_of(model, "left")) == len(assemble().model.movable_joints)
    single = assemble().model
    assert (list(find_arms(single)), list(find_grippers(single))) == (
        ["arm"],
        ["gripper"],
    )


def test_every_pedestal_reaches_the_ground() -> None:
    model = described(*TWO).model
    for name, height in (("left", 0.1), ("right", 0.3)):
        shapes = model.link(f"{name}_pedestal").visuals
        ends = [
            shape.origin.xyz[2] - shape.geometry.length / 2
            for shape in shapes
            if isinstance(shape.geometry, Cylinder)
        ]
        assert ends == pytest.approx([-height] * 2)


@pytest.mark.slow
def test_a_pedestal_is_as_wide_as_the_base_on_it() -> None:
    model = described("small=ur3", "large=ur20@1,0,0").model
    for name in ("small", "large"):
        base = model.link(f"{name}_base_link_inertia").collisions
        widest = max(
            shape.geometry.radius
            for shape in base
            if isinstance(shape.geometry, Cylinder)
        )
        column, foot = (
            shape.geometry.radius
            for shape in model.link(f"{name}_pedestal").collisions
            if isinstance(shape.geometry, Cylinder)
        )
        assert column == widest < foot


def test_every_flange_has_a_camera_and_one_sees_all_bases() -> None:
    left, right, scene = default_cameras(described(*TWO).model)
    assert (left.name, left.link) == ("left_wrist", "left_tool0")
    assert (right.name, right.link) == ("right_wrist", "right_tool0")
    eight = described(*(f"r{k}=ur5@0,{k},0" for k in range(8))).model
    for cameras, model in ((scene, described(*TWO).model), (None, eight)):
        camera = cameras or default_cameras(eight)[-1]
        T_camera_root = camera.T_link_camera.inverse()
        for name, pose in link_poses(model).items():
            if name.endswith("base_link"):
                x, y, z = T_camera_root.apply(pose.position)
                up = math.tan(camera.field_of_view / 2.0)
                assert abs(y / z) < up
                assert abs(x / z) < up * camera.width / camera.height


def test_the_namespaces_are_kept(tmp_path: Path) -> None:
    path = cell_of("robots: [{name: a, arm: ur5}]\nnamespaces: true", tmp_path)
    description = load_description(DescriptionConfig(cell=path))
    assert description.cell is not None
    assert description.cell.namespaces
    assert description.source == path
    assert description.model.name == "press"
    assert described(*TWO).cell == parse_robots(TWO)
    short = load_description(DescriptionConfig(robots=TWO, namespaces=True)).cell
    assert short == replace(parse_robots(TWO), namespaces=True)


# ---- refused -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("robots", "shown"),
    [
        (["left=ur6+2f85"], ["'left'", "'ur6'", "ur5"]),
        (["left=ur5+2f86"], ["'left'", "'2f86'", "'2f85'"]),
    ],
    ids=str,
)
def test_an_unknown_part_names_the_robot_and_the_nearest(
    robots: list[str], shown: list[str]
) -> None:
    with raises_naming(DescriptionError, *shown):
        described(*robots)


def test_an_unknown_part_of_a_file_names_its_line(tmp_path: Path) -> None:
    path = cell_of("robots:\n  - {name: a, arm: ur55}", tmp_path)
    with raises_naming(DescriptionError, "press.yaml:2", "'a'", "'ur55'"):
        load_description(DescriptionConfig(cell=path))


@pytest.mark.parametrize(
    ("robots", "shown"),
    [
        ([], ["no robot"]),
        (["a=ur5", "a=ur5@1,0,0"], ["two robots", "'a'"]),
        (["a=ur5", "a_=ur5@1,0,0"], ["'a_'", "no '_' at the end"]),
        (["2nd=ur5"], ["'2nd'", "a letter first"]),
        (["a b=ur5"], ["'a b'"]),
        (["left"], ["'left'", "NAME=ARM"]),
        (["left="], ["'left='", "NAME=ARM"]),
        (["left=ur5+"], ["'left=ur5+'", "NAME=ARM"]),
        (["left=ur5@0,1"], ["'left=ur5@0,1'", "X,Y,Z"]),
        (["left=ur5@0,1,2deg"], ["'2deg'", "mm"]),
        (["left=ur5@0,1,0,0,0,90"], ["'90'", "90deg"]),
    ],
    ids=str,
)
def test_robots_that_are_written_wrongly(robots: list[str], shown: list[str]) -> None:
    with raises_naming(ConfigError, *shown):
        described(*robots)


@pytest.mark.parametrize(
    ("text", "line", "shown"),
    [
        ("robots: []", 1, "no robot"),
        ("scene: table_and_bin", 1, "no robot"),
        ("robots:\n- {name: a, arm: ur5, grip: 2f85}", 2, "'gripper'"),
        ("robots:\n- {name: a}", 2, "'arm'"),
        ("robots:\n- {name: a, arm: ur5}\n- {name: a, arm: ur5}", 3, "'a'"),
        ("robots:\n- {name: a-b, arm: ur5}", 2, "'a-b'"),
        ("robots:\n- {name: a, arm: ur5, base: {xyz: [0, 1]}}", 2, "3 numbers"),
        ("robots:\n- {name: a, arm: ur5, base: {xyz: [0, 1, x]}}", 2, "'x'"),
        ("robots:\n- {name: a, arm: ur5, base: {at: 1}}", 2, "'robots[0]/base/at'"),
        ("robots:\n- {name: a, arm: ur5}\nscene: table_and_bim", 3, "table_and_bin"),
        ("robots:\n- {name: a, arm: ur5}\nname_spaces: 1", 3, "'namespaces'"),
    ],
    ids=str,
)
def test_mistakes_in_a_file_have_a_line(
    text: str, line: int, shown: str, tmp_path: Path
) -> None:
    path = cell_of(text, tmp_path)
    with raises_naming(ConfigError, f"press.yaml:{line}:", shown):
        load_cell(path)


def test_overlapping_bases_name_both_and_the_distance() -> None:
    with raises_naming(ConfigError, "'a'", "'b'", "0.200 m", "0.240 m"):
        described("a=ur5@0,0,0", "b=ur5@0.2,0,0")
    described("a=ur5@0,0,0", "b=ur5@0.241,0,0")
    described("a=ur5@0,0,0", "b=ur5@0,0,1.5,180deg,0,0")  # one hangs above the other


def test_bases_without_pedestals_may_be_closer() -> None:
    def at(name: str, y: float) -> CellRobot:
        config = DescriptionConfig(
            arm="ur5", gripper=None, base_xyz=(0, y, 0), pedestal_height=0.0
        )
        return CellRobot(name=name, description=config)

    close = Cell(robots=(at("a", 0.0), at("b", 0.16)))
    load_description(DescriptionConfig(cell=close))
    with raises_naming(ConfigError, "0.140 m", "0.149 m"):
        close = Cell(robots=(at("a", 0.0), at("b", 0.14)))
        load_description(DescriptionConfig(cell=close))


def test_prefixes_that_make_two_links_equal_name_both_robots() -> None:
    gripper = assemble().model.grippers[0]
    assert gripper.joint  # the link below is one of its links
    link = next(
        link.name for link in assemble().model.links if link.name.endswith("_base_link")
    )
    other = f"a_{link.removesuffix('_base_link')}"
    with raises_naming(ConfigError, "'a'", f"'{other}'", f"link 'a_{link}'"):
        described("a=ur5+2f85", f"{other}=ur5@1,0,0")


@pytest.mark.parametrize(
    "given",
    [
        {"arm": "ur5"},
        {"gripper": None},
        {"prefix": "a_"},
        {"args": {"safety_limits": "true"}},
        {"tf_prefix": "a"},
        {"robot": "my.urdf"},
    ],
    ids=str,
)
def test_options_of_one_robot_are_refused_with_several(given: dict[str, Any]) -> None:
    for several in ({"cell": "cell.yaml"}, {"robots": TWO}):
        with raises_naming(ConfigError, next(iter(given))):
            DescriptionConfig(**several, **given)  # type: ignore[arg-type]


def test_namespaces_need_several_robots() -> None:
    for given in ({}, {"arm": "ur5"}, {"robot": "my.urdf"}):
        with raises_naming(ConfigError, "namespaces", "robots"):
            DescriptionConfig(namespaces=True, **given)  # type: ignore[arg-type]


def test_a_robot_of_a_cell_is_one_of_the_catalogue() -> None:
    for given in ({"prefix": "x_"}, {"robot": "my.urdf"}, {"robots": TWO}):
        with raises_naming(ConfigError, "'a'", next(iter(given))):
            config = DescriptionConfig(**given)  # type: ignore[arg-type]
            CellRobot(name="a", description=config)


def test_a_start_pose_that_does_not_exist_names_the_robot_and_its_line(
    tmp_path: Path,
) -> None:
    robots = "robots:\n- {name: a, arm: ur5, initial_pose: "
    for pose, shown in (("hom", "'home'"), ("{elbow: 1}", "'a_elbow_joint'")):
        path = cell_of(f"{robots}{pose}}}", tmp_path)
        with raises_naming(ConfigError, "press.yaml:2", "robot 'a'", shown):
            tool0.bringup(cell=path, realtime=False)
