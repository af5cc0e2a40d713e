"""Simple models of URDF and SDF: what is read of them, and what is refused."""

import math
from pathlib import Path

import numpy as np
import pytest

from tool0.description.rigid_model import MAX_FRICTION, read_rigid_model
from tool0.description.scene import LONGEST_MODEL
from tool0.description.shapes import Box, Compound, Cylinder, Geometry, Mesh, Sphere
from tool0.description.transform import Pose, Transform, to_transform
from tool0.errors import ConfigError, DescriptionError, Tool0Error

BOX = '<geometry><box size="0.1 0.2 0.3"/></geometry>'
INERTIAL = '<inertial><mass value="0.5"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'
SDF_BOX = "<geometry><box><size>0.1 0.2 0.3</size></box></geometry>"


def urdf(inside: str) -> str:
    return f'<?xml version="1.0"?><robot name="thing">{inside}</robot>'


def urdf_link(
    collision: str = BOX, inertial: str = INERTIAL, visual: str = "", beside: str = ""
) -> str:
    return urdf(
        f'<link name="body">{inertial}<collision>{collision}</collision>{visual}</link>'
        + beside
    )


def sdf(inside: str) -> str:
    return f"<sdf version='1.6'><model name='thing'>{inside}</model></sdf>"


def sdf_link(collision: str = SDF_BOX, more: str = "", beside: str = "") -> str:
    return sdf(
        f"<link name='body'><collision name='shape'>{collision}</collision>{more}"
        f"</link>{beside}"
    )


def pose(*numbers: float) -> Transform:
    return to_transform(Pose(xyz=numbers[:3], rpy=numbers[3:]))  # type: ignore[arg-type]


def assert_same(actual: Transform, expected: Transform) -> None:
    np.testing.assert_allclose(actual.matrix, expected.matrix, atol=1e-12)


def test_a_link_of_urdf_is_read() -> None:
    visual = (
        f'<visual>{BOX}<material name="m"><color rgba="1 0 0.5 1"/></material></visual>'
    )
    extension = '<gazebo reference="body"><mu1>0.4</mu1><mu2>9</mu2></gazebo>'
    moved = f'<origin xyz="0 0 0.1" rpy="0 0 1"/>{BOX}'
    model = read_rigid_model(urdf_link(moved, visual=visual, beside=extension))
    assert (model.name, model.link) == ("thing", "body")
    assert model.geometry == Box(size=(0.1, 0.2, 0.3))
    assert (model.mass, model.friction) == (0.5, 0.4)
    assert model.rgba == (1.0, 0.0, 0.5, 1.0)
    assert_same(model.T_model_link, Transform())
    assert_same(model.T_model_shape, pose(0, 0, 0.1, 0, 0, 1))


def test_a_link_of_sdf_is_read() -> None:
    model = read_rigid_model(
        sdf_link(
            f"<pose>0 0 0.1 0 0 1</pose>{SDF_BOX}"
            "<surface><friction><ode><mu>0.4</mu><mu2>9</mu2></ode></friction></surface>",
            "<pose>0 1 0 0 2 0</pose><inertial><mass>0.5</mass></inertial>"
            "<visual name='v'><material><ambient>0 0 0 1</ambient>"
            "<diffuse>1 0 0.5</diffuse></material></visual>",
            "<pose>3 0 0 0 0 0</pose>",
        )
    )
    assert (model.name, model.link, model.collisions) == (
        "thing",
        "body",
        ("shape",),
    )
    assert model.geometry == Box(size=(0.1, 0.2, 0.3))
    assert (model.mass, model.friction) == (0.5, 0.4)
    assert model.rgba == (1.0, 0.0, 0.5, 1.0)
    T_model_link = pose(0, 1, 0, 0, 2, 0)
    assert_same(model.T_model_link, T_model_link)
    assert_same(model.T_model_shape, T_model_link @ pose(0, 0, 0.1, 0, 0, 1))
    assert_same(model.placement, pose(3, 0, 0, 0, 0, 0))


@pytest.mark.parametrize(
    ("in_urdf", "in_sdf", "expected"),
    [
        (
            '<cylinder radius="0.1" length="0.2"/>',
            "<cylinder><radius>0.1</radius><length>0.2</length></cylinder>",
            Cylinder(radius=0.1, length=0.2),
        ),
        (
            '<sphere radius="0.1"/>',
            "<sphere><radius>0.1</radius></sphere>",
            Sphere(radius=0.1),
        ),
    ],
)
def test_shapes_are_read(in_urdf: str, in_sdf: str, expected: Geometry) -> None:
    of_urdf = read_rigid_model(urdf_link(f"<geometry>{in_urdf}</geometry>"))
    of_sdf = read_rigid_model(sdf_link(f"<geometry>{in_sdf}</geometry>"))
    assert of_urdf.geometry == of_sdf.geometry == expected


def test_meshes_are_found(tmp_path: Path) -> None:
    file = tmp_path / "part.stl"
    file.touch()
    of_sdf = read_rigid_model(
        sdf_link(
            f"<geometry><mesh><uri>file://{file}</uri><scale>1 2 3</scale></mesh>"
            "</geometry>"
        )
    )
    of_urdf = read_rigid_model(
        urdf_link(f'<geometry><mesh filename="file://{file}"/></geometry>')
    )
    expected = Mesh(uri=f"file://{file}", path=file, scale=(1, 2, 3))
    assert of_sdf.geometry == expected
    assert isinstance(of_urdf.geometry, Mesh)
    assert of_urdf.geometry.path == file


@pytest.mark.parametrize(
    "text",
    [
        sdf_link(beside="<static>true</static>"),
        sdf_link(beside="<static>1</static>"),
        sdf_link(
            beside="<joint name='j' type='fixed'><parent>world</parent>"
            "<child>body</child></joint>"
        ),
        urdf_link(beside="<gazebo><static>true</static></gazebo>"),
        urdf_link(inertial="", beside="<gazebo><static>true</static></gazebo>"),
        urdf_link(
            beside='<link name="world"/><joint name="j" type="fixed">'
            '<parent link="world"/><child link="body"/></joint>'
        ),
    ],
)
def test_what_is_static_has_no_mass(text: str) -> None:
    model = read_rigid_model(text)
    assert model.mass is None
    assert model.link == "body"


def test_links_that_are_fixed_to_each_other_are_one_body() -> None:
    model = read_rigid_model(
        urdf(
            f'<link name="foot">{INERTIAL}</link>'
            f'<link name="top">{INERTIAL}<collision>{BOX}</collision></link>'
            '<joint name="j" type="fixed"><parent link="foot"/><child link="top"/>'
            '<origin xyz="0 0 1"/></joint>'
        )
    )
    assert model.link == "foot"
    assert model.mass == 1.0
    assert_same(model.T_model_shape, pose(0, 0, 1, 0, 0, 0))


def test_several_shapes_of_urdf_are_one_body_in_the_first_link_s_frame() -> None:
    model = read_rigid_model(
        urdf(
            '<link name="world"/><joint name="i" type="fixed"><parent link="world"/>'
            '<child link="foot"/><origin xyz="0 3 0"/></joint>'
            f'<link name="foot">{INERTIAL}<collision>{BOX}</collision>'
            f'<collision><origin xyz="0 0 2"/>{BOX}</collision></link>'
            f'<link name="top">{INERTIAL}<collision>{BOX}</collision></link>'
            '<joint name="j" type="fixed"><parent link="foot"/><child link="top"/>'
            '<origin xyz="0 0 1" rpy="0 0 1"/></joint>'
        )
    )
    box = Box(size=(0.1, 0.2, 0.3))
    assert isinstance(model.geometry, Compound)
    assert [shape for shape, _ in model.geometry.parts] == [box] * 3
    expected = [pose(0, 0, 0, 0, 0, 0), pose(0, 0, 2, 0, 0, 0), pose(0, 0, 1, 0, 0, 1)]
    for (_, actual), wanted in zip(model.geometry.parts, expected, strict=True):
        assert_same(to_transform(actual), wanted)
    assert_same(model.T_model_shape, pose(0, 3, 0, 0, 0, 0))
    assert model.link == "foot"
    assert model.collisions == ("foot_collision", "foot_collision_1", "top_collision")


def test_several_shapes_of_sdf_are_one_body_in_the_link_s_frame() -> None:
    model = read_rigid_model(
        sdf_link(
            SDF_BOX,
            "<pose>0 1 0 0 2 0</pose><collision name='ball'><pose>0 0 1 0 0 0</pose>"
            "<geometry><sphere><radius>0.1</radius></sphere></geometry>"
            "<surface><friction><ode><mu>0.4</mu></ode></friction></surface>"
            "</collision><inertial><mass>0.5</mass></inertial>",
        )
    )
    assert isinstance(model.geometry, Compound)
    (box, at_box), (ball, at_ball) = model.geometry.parts
    assert (box, ball) == (Box(size=(0.1, 0.2, 0.3)), Sphere(radius=0.1))
    assert_same(to_transform(at_box), Transform())
    assert_same(to_transform(at_ball), pose(0, 0, 1, 0, 0, 0))
    assert_same(model.T_model_shape, pose(0, 1, 0, 0, 2, 0))
    assert model.collisions == ("shape", "ball")
    assert (model.mass, model.friction) == (0.5, 0.4)


@pytest.mark.parametrize(
    ("text", "rgba"),
    [
        (
            urdf_link(beside="<gazebo><material>Gazebo/Red</material></gazebo>"),
            (1, 0, 0, 1),
        ),
        (
            sdf_link(
                more="<visual name='v'><material><script><name>Gazebo/Blue</name>"
                "</script></material></visual>"
            ),
            (0, 0, 1, 1),
        ),
        (sdf_link(), (0.7, 0.7, 0.7, 1)),
    ],
)
def test_colours_have_gazebos_names(
    text: str, rgba: tuple[float, float, float, float]
) -> None:
    assert read_rigid_model(text).rgba == rgba


def test_an_object_has_its_shape_where_the_model_says() -> None:
    model = read_rigid_model(sdf_link(f"<pose>0 0 0.1 0.1 0.2 0.3</pose>{SDF_BOX}"))
    T_root_model = pose(1, 2, 3, 0.4, 0.5, 0.6)
    item = model.scene_object("other", T_root_model)
    assert (item.name, item.mass) == ("other", 1.0)  # 1 kg is SDF's default
    assert_same(to_transform(item.pose), T_root_model @ model.T_model_shape)


def test_friction_beyond_reason_is_what_is_rough() -> None:
    text = sdf_link(
        f"{SDF_BOX}<surface><friction><ode><mu>1e15</mu></ode></friction></surface>"
    )
    assert read_rigid_model(text).friction == MAX_FRICTION


def sdf_geometry(inside: str) -> str:
    return sdf_link(f"<geometry>{inside}</geometry>")


HINGE = (
    '<link name="a"/><link name="b"/><joint name="hinge" type="continuous">'
    '<parent link="a"/><child link="b"/></joint>'
)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("", ""),
        ("\0", ""),
        ("<html/>", "<html>"),
        ("<sdf/>", "<model>"),
        ("<sdf><world name='w'/></sdf>", "<model>"),
        (sdf(""), "<link>"),
        (sdf("<link name='a'/><link name='b'/>"), "2 <link>"),
        (sdf("<link name='a'/>"), "<collision>"),
        (sdf("<include><uri>model://can</uri></include>"), "<include>"),
        ("<sdf><include><uri>model://can</uri></include></sdf>", "<include>"),
        (sdf_link(beside="<joint name='j' type='revolute'><parent>x</parent></joint>"),
         "'j'"),
        (sdf_geometry("<plane/>"), "plane"),
        (sdf_geometry(""), "<geometry>"),
        (sdf_geometry("<box><size>1 2</size></box>"), "2 numbers"),
        (sdf_geometry("<box><size>1 2 x</size></box>"), "'x'"),
        (sdf_geometry("<box><size>nan 1 1</size></box>"), "'nan'"),
        (sdf_geometry("<box><size>1e9 1 1</size></box>"), "100 m"),
        (sdf_link(beside="<pose>1e9 0 0 0 0 0</pose>"), "100 m"),
        (sdf_link(beside="<pose relative_to='x'>1 0 0 0 0 0</pose>"), "relative_to"),
        (sdf_link(more="<inertial><mass>1e9</mass></inertial>"), "1e+06 kg"),
        (sdf_geometry("<mesh><uri>model://x/y.dae</uri></mesh>"), "model://"),
        (sdf_geometry("<mesh><uri>/nowhere/y.dae</uri></mesh>"), "y.dae"),
        (sdf_geometry("<mesh><uri>/etc/passwd</uri></mesh>"), "/etc/passwd"),
        (urdf_link(inertial=""), "<inertial>"),
        (urdf_link(inertial=INERTIAL.replace("0.5", "-1")), "-1"),
        (urdf('<link name="a"/>'), "<collision>"),
        (sdf_link(more="<collision name='b'><pose>1e9 0 0 0 0 0</pose>"
                  f"{SDF_BOX}</collision>"), "100 m"),
        (urdf(HINGE), "'hinge'"),
        ("<a>" * 10_000, "500"),
        ("x" * (LONGEST_MODEL + 1), str(LONGEST_MODEL)),
        ("<!DOCTYPE a [<!ENTITY b 'c'>]><sdf>&b;</sdf>", "<!DOCTYPE"),
    ],
)  # fmt: skip
def test_what_is_no_simple_model_is_refused(text: str, named: str) -> None:
    with pytest.raises(Tool0Error) as error:
        read_rigid_model(text)
    assert named in str(error.value)


@pytest.mark.parametrize("mass", ["0", "-1"])
def test_a_mass_of_none_or_less_makes_no_object(mass: str) -> None:
    model = read_rigid_model(sdf_link(more=f"<inertial><mass>{mass}</mass></inertial>"))
    with pytest.raises(ConfigError):
        model.scene_object("thing", Transform())


@pytest.mark.parametrize(
    "tensor", ['ixx="1" iyy="1" izz="9"', 'ixx="0" iyy="0" izz="0"']
)
def test_an_inertia_that_no_body_has_is_replaced_with_a_warning(
    tensor: str, caplog: pytest.LogCaptureFixture
) -> None:
    """The engines take the inertia that follows from shape and mass."""
    text = urdf_link(
        inertial=f'<inertial>\n<mass value="0.5"/>\n<inertia {tensor}/></inertial>'
    )
    model = read_rigid_model(text)
    assert model == read_rigid_model(urdf_link())
    assert "link 'body'" in caplog.text
    assert "it is not used" in caplog.text


def test_cutting_a_text_anywhere_is_refused() -> None:
    text = sdf_link(more="<inertial><mass>0.5</mass></inertial>")
    for length in range(len(text)):
        with pytest.raises(DescriptionError):
            read_rigid_model(text[:length])
    assert math.isclose(read_rigid_model(text).mass or 0.0, 0.5)
