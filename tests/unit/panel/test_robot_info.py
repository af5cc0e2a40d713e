from dataclasses import replace
from pathlib import Path
from urllib.error import HTTPError
from urllib.request import Request, urlopen
from xml.dom.minidom import parseString

import pytest

import tool0
from tool0.description.config import DescriptionConfig
from tool0.description.loading import assemble, load_description, load_robot
from tool0.description.model import Joint, JointType, Link
from tool0.description.parts import base_of
from tool0.description.scene import SceneObject
from tool0.description.shapes import Box, Compound, Mesh
from tool0.description.transform import Pose
from tool0.panel.robot_info import RobotFiles, object_info, robot_info
from tool0.panel.server import Panel


def mesh_paths(urdf: str | bytes) -> set[str]:
    elements = parseString(urdf).getElementsByTagName("mesh")
    return {element.getAttribute("filename") for element in elements}


def test_every_mesh_of_the_urdf_is_served(panel: Panel, robot: tool0.Robot) -> None:
    with urlopen(panel.url + "robot.urdf") as response:
        urdf = response.read()
    paths = mesh_paths(urdf)
    files = {
        visual.geometry.path
        for link in robot.description.model.links
        for visual in link.visuals
        if isinstance(visual.geometry, Mesh)
    }
    assert len(paths) == len(files) > 20
    served = {urlopen(panel.url + path[1:]).read() for path in paths}
    assert served == {file.read_bytes() for file in files}
    assert len(urdf) + sum(map(len, served)) < 2 << 20


@pytest.mark.slow
def test_only_the_paths_of_meshes_differ_from_the_robot_s_urdf() -> None:
    description = assemble()
    text = RobotFiles(description).urdf.decode()
    before = description.urdf.splitlines()
    different = [
        pair
        for pair in zip(before, text.splitlines(), strict=True)
        if pair[0] != pair[1]
    ]
    assert different
    assert all("<mesh filename=" in line for pair in different for line in pair)


def test_a_robot_of_a_cell_is_told_from_the_others() -> None:
    cell = DescriptionConfig(robots=("a=ur5e+2f85@0,0.4,0", "b=ur3e@0,-0.4,0"))
    description = load_description(cell)
    joints = [joint.name for joint in description.model.movable_joints]
    one, other = robot_info(description, joints, None, {}).robots
    assert (one.name, one.title, one.prefix) == ("a", "ur5e + 2f85", "a_")
    assert (one.base, one.tip, one.gripper) == ("a_base_link", "a_tool0", "a")
    assert (other.title, other.base, other.gripper) == ("ur3e", "b_base_link", None)
    assert sorted(one.joints + other.joints) == sorted(joints)
    assert all(name.startswith("b_") for name in other.joints)


def test_a_robot_begins_above_what_carries_two() -> None:
    arms = DescriptionConfig(robots=("a=ur5@0,0.4,0", "b=ur5@0,-0.4,0"))
    model = load_description(arms).model
    on_torso = [
        replace(joint, parent="torso") if joint.parent == "world" else joint
        for joint in model.joints
    ]
    lift = Joint(name="lift", type=JointType.FIXED, parent="world", child="torso")
    links = (*model.links, Link(name="torso"))
    model = replace(model, links=links, joints=(lift, *on_torso))
    assert [base_of(model, name) for name in "ab"] == ["a_base_link", "b_base_link"]


def test_a_cached_file_is_not_sent_again(panel: Panel) -> None:
    for path in ("robot.urdf", "meshes/0.stl"):
        with urlopen(panel.url + path) as response:
            etag = response.headers["etag"]
            assert response.headers["cache-control"] == "no-cache"
        request = Request(panel.url + path, headers={"If-None-Match": etag})
        with pytest.raises(HTTPError) as answer:
            urlopen(request)
        assert answer.value.code == 304
        answer.value.close()


def test_meshes_of_another_robot_and_of_objects_are_served(tmp_path: Path) -> None:
    for name in ("a.STL", "b.obj", "scene.stl"):
        (tmp_path / name).write_bytes(b"x")
    file = tmp_path / "mine.urdf"
    shapes = "".join(
        f"<{kind}><geometry><mesh filename='{name}'/></geometry></{kind}>"
        for kind, name in (("visual", "a.STL"), ("collision", "b.obj"))
    )
    file.write_text(f"<robot name='mine'><link name='one'>{shapes}</link></robot>")
    description = load_robot(file)
    mesh = Mesh(uri="scene.stl", path=tmp_path / "scene.stl")
    thing = SceneObject(name="thing", geometry=mesh)
    files = RobotFiles(description)
    files.set_objects([thing])
    assert {path: file.name for path, file in files.meshes.items()} == {
        "/meshes/0.stl": "a.STL",
        "/meshes/1.obj": "b.obj",
        "/meshes/2.stl": "scene.stl",
    }
    assert mesh_paths(files.urdf) == {"/meshes/0.stl", "/meshes/1.obj"}
    assert object_info(thing, files).shape.url == "/meshes/2.stl"
    assert str(tmp_path) not in files.urdf.decode()


def test_a_page_gets_the_parts_of_an_object(tmp_path: Path) -> None:
    path = tmp_path / "part.stl"
    pose = Pose(xyz=(1.0, 2.0, 3.0), rpy=(0.1, 0.2, 0.3))
    mesh, box = Mesh(uri="part.stl", path=path), Box(size=(1.0, 1.0, 1.0))
    solid = Compound(parts=((box, Pose()), (mesh, pose)))
    thing = SceneObject(name="thing", geometry=solid)
    files = RobotFiles(assemble())
    files.set_objects([thing])
    shape = object_info(thing, files).shape
    assert shape.kind == "compound"
    first, second = shape.parts or ()
    assert (first.shape.kind, first.shape.size) == ("box", box.size)
    assert files.meshes[second.shape.url or ""] == path
    assert (second.xyz, second.rpy) == (pose.xyz, pose.rpy)


def test_the_mesh_of_an_object_added_again_has_another_path(
    tmp_path: Path,
) -> None:
    path = tmp_path / "part.stl"
    part = SceneObject(name="part", geometry=Mesh(uri="part.stl", path=path))
    twin = SceneObject(name="twin", geometry=Mesh(uri="part.stl", path=path))
    files = RobotFiles(assemble())

    def url() -> str | None:
        return object_info(part, files).shape.url

    files.set_objects([part])
    first = url()
    files.set_objects([part, twin])
    assert url() == first
    files.set_objects([])
    assert first not in files.meshes
    files.set_objects([part])  # its file may have changed
    assert url() != first
    assert files.meshes[url() or ""] == path
