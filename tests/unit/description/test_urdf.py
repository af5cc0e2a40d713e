import math
from pathlib import Path

import pytest

from tool0.description.config import DescriptionConfig
from tool0.description.loading import load_description
from tool0.description.model import JointLimits, JointType, RobotModel
from tool0.description.shapes import Box, Cylinder, Mesh, Sphere
from tool0.description.urdf import read_model
from tool0.description.xml_source import parse_text
from tool0.errors import ConfigError, DescriptionError, LimitsError, ModelError

INERTIA = (
    '<inertial><mass value="{mass}"/><inertia ixx="{xx}" ixy="{xy}" ixz="0" '
    'iyy="{yy}" iyz="0" izz="{zz}"/></inertial>'
)


def read(body: str, file: Path | None = Path("r.urdf")) -> RobotModel:
    return read_model(parse_text(f'<robot name="r">\n{body}\n</robot>', file))


def revolute(inside: str, name: str = "j", child: str = "b") -> str:
    return (
        f'<joint name="{name}" type="revolute"><parent link="a"/>'
        f'<child link="{child}"/>{inside}</joint>'
    )


def inertia(
    mass: object = 1, xx: object = 1, yy: object = 1, zz: object = 1, xy: object = 0
) -> str:
    body = INERTIA.format(mass=mass, xx=xx, yy=yy, zz=zz, xy=xy)
    return f'\n<link name="a">{body}</link>'


A, B, C = ('<link name="a"/>', '<link name="b"/>', '<link name="c"/>')
LIMIT = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'


def fixed(name: str, parent: str, child: str) -> str:
    return (
        f'<joint name="{name}" type="fixed"><parent link="{parent}"/>'
        f'<child link="{child}"/></joint>'
    )


@pytest.mark.parametrize(
    ("body", "kind", "line", "named"),
    [
        ("", ModelError, 1, "<link>"),
        (A + "\n<link/>", DescriptionError, 3, 'name'),
        (A + '\n<link name=" "/>', DescriptionError, 3, "name"),
        (A + "\n" + A, ModelError, 3, "r.urdf:2"),
        (A + B + "\n" + C, ModelError, 2, "'a', 'b', 'c'"),
        (A + B + fixed("j", "a", "b") + "\n" + fixed("j", "a", "b"), ModelError, 3,
         "'j'"),
        (A + B + "\n" + fixed("j", "x", "b"), ModelError, 3, "'x'"),
        (A + B + "\n" + fixed("j", "a", "bb"), ModelError, 3,
         "'b'"),
        (A + B + "\n<joint name='j' type='fixed'><child link='b'/></joint>",
         DescriptionError, 3, "<parent>"),
        (A + B + C + fixed("i", "a", "c") + "\n" + fixed("j", "b", "c"), ModelError, 3,
         "'c'"),
        (A + B + C + "\n" + fixed("i", "b", "c") + fixed("j", "c", "b"), ModelError, 3,
         "'i'"),
        (A + "\n" + fixed("j", "a", "a"), ModelError, 3, "'j'"),
        (inertia(mass=-1), ModelError, 3, "-1 kg"),
        (inertia(mass=0), ModelError, 3, "0 kg"),
        (inertia(mass="nan"), DescriptionError, 3, "'nan'"),
        (inertia(mass="one"), DescriptionError, 3, "'one'"),
        (inertia(mass="inf"), DescriptionError, 3, "'inf'"),
        (inertia(zz=2.1), ModelError, 3, "triangle"),
        (inertia(xx=-1), ModelError, 3, "positive definite"),
        (inertia(xx=0, yy=0, zz=0), ModelError, 3, "positive definite"),
        (inertia(xy=1.5), ModelError, 3, "positive definite"),
        (inertia(xy=0.9), ModelError, 3, "triangle"),
        (A + B + "\n" + revolute(""), LimitsError, 3, "<limit"),
        (A + B + "\n" + revolute(LIMIT.replace("-1", "2")), LimitsError, 3,
         "2.0"),
        (A + B + "\n" + revolute(LIMIT.replace('velocity="1"', 'velocity="-1"')),
         LimitsError, 3, "-1"),
        (A + B + "\n" + revolute(LIMIT.replace('effort="1"', "")), DescriptionError, 3,
         'effort'),
        (A + B + "\n" + revolute(LIMIT.replace('upper="1"', 'upper="nan"')),
         DescriptionError, 3, "'nan'"),
        (A + B + "\n" + revolute('<axis xyz="0 0 0"/>' + LIMIT), ModelError, 3,
         "'j'"),
        (A + B + "\n" + revolute('<axis xyz="0 1"/>' + LIMIT), DescriptionError, 3,
         "2 numbers"),
        (A + B + "\n" + revolute('<dynamics damping="-1"/>' + LIMIT), ModelError, 3,
         "damping -1"),
        (A + B + "\n" + revolute('<mimic joint="jj"/>' + LIMIT), ModelError, 3,
         "'jj'"),
        (A + B + "\n" + revolute('<mimic joint="j"/>' + LIMIT), ModelError, 3,
         "'j'"),
        (A + B + "\n" + revolute(
            '<safety_controller soft_lower_limit="1" soft_upper_limit="-1" '
            'k_velocity="0"/>' + LIMIT), LimitsError, 3, "soft"),
        (A + B + "\n" + revolute(LIMIT + LIMIT), DescriptionError, 3, "2 <limit>"),
        (A + B + "\n<joint name='j' type='hinge'/>", DescriptionError, 3,
         "'hinge'"),
    ],
)  # fmt: skip
def test_refuses_what_no_robot_could_be(
    body: str, kind: type[ModelError | DescriptionError], line: int, named: str
) -> None:
    with pytest.raises(kind) as caught:
        read(body)
    assert named in str(caught.value)
    assert str(caught.value.location) == f"r.urdf:{line}"


def test_refuses_chains_and_loops_of_mimics() -> None:
    def mimic(name: str, child: str, leader: str) -> str:
        return revolute(f'<mimic joint="{leader}"/>' + LIMIT, name, child)

    free = revolute(LIMIT, "i", "b")
    chain = A + B + C + '<link name="d"/>' + free
    for wrong in (
        chain + mimic("j", "c", "i") + mimic("k", "d", "j"),
        chain + mimic("j", "c", "k") + mimic("k", "d", "j"),
        A + B + C + fixed("i", "a", "b") + mimic("j", "c", "i"),  # a fixed leader
    ):
        with pytest.raises(ModelError):
            read(wrong)


@pytest.mark.parametrize(
    "shape",
    [
        '<cone radius="1"/>',
        '<capsule radius="1" length="1"/>',
        '<box size="1 0 0"/>',
        '<box size="1 1"/>',
        '<sphere radius="-1"/>',
        '<sphere radius="nan"/>',
        '<cylinder radius="1"/>',
        '<mesh filename="no.stl"/>',
        '<mesh filename="no.step"/>',
        '<mesh filename="package://no_package/a.stl"/>',
        '<mesh filename="here.stl" scale="1 0 1"/>',
        '<sphere radius="1"/><sphere radius="1"/>',
        "",
    ],
)
@pytest.mark.parametrize("role", ["visual", "collision"])
def test_refuses_shapes_that_nothing_can_draw(
    tmp_path: Path, role: str, shape: str
) -> None:
    (tmp_path / "here.stl").touch()
    body = f'<link name="a">\n<{role}><geometry>{shape}</geometry></{role}></link>'
    with pytest.raises(DescriptionError) as caught:
        read(body, tmp_path / "r.urdf")
    assert str(caught.value.location) == f"{tmp_path / 'r.urdf'}:3"


@pytest.mark.parametrize("text", ["<sdf/>", "<model><robot name='r'/></model>"])
def test_refuses_what_is_not_a_robot(text: str) -> None:
    with pytest.raises(DescriptionError):
        read_model(parse_text(text))


def test_reads_shapes_colours_and_places(tmp_path: Path) -> None:
    (tmp_path / "m.STL").touch()
    model = read(
        """<material name="red"><color rgba="1 0 0 1"/></material>
        <link name="a">
          <visual><origin xyz="1 2 3" rpy="0 0 1"/><geometry><box size="1 2 3"/>
            </geometry><material name="red"/></visual>
          <visual><geometry><mesh filename="m.STL" scale="1 1 -1"/></geometry>
            <material name="x"><color rgba="0 0 1 0.5"/></material></visual>
          <collision><geometry><cylinder radius="1" length="2"/></geometry></collision>
          <collision><geometry><sphere radius="3"/></geometry></collision>
        </link>""",
        tmp_path / "r.urdf",
    )
    first, second = model.links[0].visuals
    assert (first.geometry, first.rgba) == (Box(size=(1, 2, 3)), (1, 0, 0, 1))
    assert (first.origin.xyz, first.origin.rpy) == ((1, 2, 3), (0, 0, 1))
    mesh = Mesh(uri="m.STL", path=tmp_path / "m.STL", scale=(1, 1, -1))
    assert (second.geometry, second.rgba) == (mesh, (0, 0, 1, 0.5))
    shapes = [collision.geometry for collision in model.links[0].collisions]
    assert shapes == [Cylinder(radius=1, length=2), Sphere(radius=3)]


def test_reads_joints_depth_first_with_urdfs_defaults() -> None:
    model = read(
        C + B + '<link name="d"/>' + A
        + fixed("c_d", "c", "d")
        + '<joint name="a_b" type="continuous"><parent link="a"/><child link="b"/>'
        '<axis xyz="0 0 -2"/></joint>'
        + revolute('<limit effort="2" velocity="3"/><unheard_of/>', "a_c", "c")
    )  # fmt: skip
    assert model.root == "a"
    assert [joint.name for joint in model.joints] == ["a_b", "a_c", "c_d"]
    turning, bounded = model.joint("a_b"), model.joint("a_c")
    assert turning.type is JointType.CONTINUOUS
    assert turning.axis == (0, 0, -1)
    assert (turning.limits.upper, turning.limits.effort) == (math.inf, math.inf)
    assert bounded.axis == (1, 0, 0)
    assert (bounded.limits.lower, bounded.limits.upper) == (0, 0)
    assert (bounded.limits.effort, bounded.limits.velocity) == (2, 3)
    assert str(model.locations["joint:a_c"]) == "r.urdf:2"


def test_principal_moments_agree_with_numpy() -> None:
    import numpy as np

    rng = np.random.default_rng(seed=3)
    for _ in range(200):
        root = rng.normal(size=(3, 3))
        tensor = root @ root.T
        text = INERTIA.format(
            mass=1, xx=tensor[0, 0], yy=tensor[1, 1], zz=tensor[2, 2], xy=tensor[0, 1]
        )
        tensor[0, 2] = tensor[2, 0] = tensor[1, 2] = tensor[2, 1] = 0.0
        expected = np.linalg.eigvalsh(tensor)
        possible = expected[0] > 0 and expected[0] + expected[1] >= expected[2]
        try:
            inertial = read(f'<link name="a">{text}</link>').links[0].inertial
        except ModelError:
            assert not possible
            continue
        assert inertial is not None
        np.testing.assert_allclose(
            inertial.principal_moments, expected, rtol=1e-9, atol=1e-12
        )


IMPOSSIBLE = """<robot name="r"><link name="a"/><link name="b"><inertial>
  <mass value="0.05"/>
  <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.0008"/></inertial>
  </link>
  <joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint></robot>
"""


def test_an_inertia_that_no_body_has_is_refused_or_replaced(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    file = tmp_path / "r.urdf"
    file.write_text(IMPOSSIBLE)
    with pytest.raises(ModelError, match=r"inertia of link 'b'.*--relax-inertia"):
        load_description(DescriptionConfig(robot=file))
    model = load_description(DescriptionConfig(robot=file, relax_inertia=True)).model
    inertial = model.link("b").inertial
    assert inertial is not None
    assert inertial.principal_moments == (0.001, 0.001, 0.001)
    assert "the inertia of link 'b', which no body has, is replaced" in caplog.text
    with pytest.raises(ConfigError, match="relax_inertia: only for a robot file"):
        DescriptionConfig(relax_inertia=True)


def test_the_limits_of_a_fixed_joint_are_not_read() -> None:
    joint = (
        '<joint name="j" type="fixed"><parent link="a"/><child link="b"/>'
        '<limit lower="0" upper="0" effort="0" velocity="0"/></joint>'
    )
    model = read(f'<link name="a"/><link name="b"/>{joint}')
    assert model.joint("j").limits == JointLimits()
