"""Loops, springs, transmissions, surfaces and grippers of URDF, read strictly."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from tool0.description.forward_kinematics import link_poses
from tool0.description.loading import assemble
from tool0.description.model import (
    ROBOTIQ,
    Interface,
    JointType,
    RobotModel,
    Spring,
    Surface,
)
from tool0.description.units import LENGTH
from tool0.description.urdf import read_model
from tool0.description.xml_source import parse_text
from tool0.errors import DescriptionError, LimitsError, ModelError, Tool0Error


def bar(name: str, parent: str, xyz: str, mimic: str = "") -> str:
    """Return a link that swings about x, where ``xyz`` is in its parent."""
    return (
        f'<link name="{name}"/><joint name="{name}_joint" type="revolute">'
        f'<origin xyz="{xyz}"/><parent link="{parent}"/><child link="{name}"/>'
        f'<limit lower="-1" upper="1" effort="1" velocity="1"/>{mimic}</joint>'
    )


def follows(multiplier: float) -> str:
    return f'<mimic joint="crank_joint" multiplier="{multiplier}"/>'


def parallelogram(coupler: float = -1.0) -> str:
    return (
        '<link name="base"/>'
        + bar("crank", "base", "0 0 0")
        + bar("coupler", "crank", "0 0 0.2", follows(coupler))
        + bar("rocker", "base", "0 0.3 0", follows(1.0))
    )


PASSIVE = '<passive_joint name="rocker_joint"/><passive_joint name="coupler_joint"/>'


def loop(first: str = "rocker", second: str = "coupler", y: float = 0.3) -> str:
    return (
        f'<loop_joint name="loop"><end link="{first}" xyz="0 0 0.2"/>'
        f'<end link="{second}" xyz="0 {y} 0"/></loop_joint>'
    )


def spring(joint: str, *values: str) -> str:
    return f'<gazebo reference="{joint}">{"".join(values)}</gazebo>'


def read(*parts: str) -> RobotModel:
    text = f'<robot name="r">{"".join(parts)}</robot>'
    return read_model(parse_text(text, Path("r.urdf")))


def test_a_parallelogram_is_read() -> None:
    stiff = spring("rocker_joint", "<springStiffness>2</springStiffness>")
    reference = "<springReference>-1.5</springReference>"
    bent = spring("coupler_joint", "<springStiffness>1</springStiffness>", reference)
    model = read(parallelogram(), PASSIVE, loop(), stiff, bent)
    (found,) = model.loops
    assert (found.name, found.links) == ("loop", ("rocker", "coupler"))
    assert found.points == ((0.0, 0.0, 0.2), (0.0, 0.3, 0.0))
    assert [j.passive for j in model.joints] == [False, True, True]
    assert model.joint("rocker_joint").spring == Spring(stiffness=2.0)
    bent_spring = Spring(stiffness=1.0, reference=-1.5)
    assert model.joint("coupler_joint").spring == bent_spring
    assert model.joint("crank_joint").spring is None


@pytest.mark.parametrize(
    ("error", "part", "named"),
    [
        (ModelError, loop(first="rockr"), "'rocker'"),
        (ModelError, loop(second="rocker"), "'rocker'"),
        (ModelError, loop(y=0.31), "10.000 mm"),
        (DescriptionError, '<loop_joint name="l"/>', "<end>"),
        (ModelError, '<passive_joint name="rock"/>', "'rock'"),
        (ModelError, '<passive_joint name="crank_joint"/>', "<mimic>"),
        (ModelError, spring("crank_joint", "<springStiffness>-1</springStiffness>"),
         "'crank_joint'"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_refused(
    error: type[Tool0Error], part: str, named: str
) -> None:
    with pytest.raises(error) as caught:
        read(parallelogram(), PASSIVE, part)
    assert named in str(caught.value)


def test_a_loop_must_stay_closed_as_its_joints_move() -> None:
    with pytest.raises(ModelError) as caught:
        read(parallelogram(coupler=-0.9), PASSIVE, loop())
    assert "'loop'" in str(caught.value)


@pytest.mark.parametrize("prefix", ["", "left_"])
def test_the_fingers_loops_close_at_every_opening(prefix: str) -> None:
    model = assemble(gripper_model="linkage", prefix=prefix).model
    assert len(model.loops) == 2
    for position in (0.0, 0.3, 0.8133):
        frames = link_poses(model, {f"{prefix}finger_joint": position})
        for found in model.loops:
            ends = zip(found.links, found.points, strict=True)
            first, second = (frames[link].apply(point) for link, point in ends)
            assert math.dist(first, second) < 1e-9


@pytest.mark.slow
def test_the_linkage_differs_from_mimic_in_its_passive_joints_alone() -> None:
    mimic, linkage = assemble().model, assemble(gripper_model="linkage").model
    assert mimic.links == linkage.links
    (gripper,) = linkage.grippers
    assert mimic.grippers == (replace(gripper, passive=()),)
    assert mimic.transmissions == linkage.transmissions
    assert not any(joint.passive or joint.spring for joint in mimic.joints)
    assert mimic.loops == ()
    changed = {
        after.name
        for before, after in zip(mimic.joints, linkage.joints, strict=True)
        if before != after
    }
    passive = {joint.name for joint in linkage.joints if joint.passive}
    parts = ("outer_finger", "inner_finger", "inner_knuckle")
    sides = ("left", "right")
    assert (
        changed
        == passive
        == dict(gripper.passive).keys()
        == {f"{s}_{p}_joint" for s in sides for p in parts}
    )
    for side in sides:  # the pin stops it where the finger is parallel
        pin = linkage.joint(f"{side}_outer_finger_joint")
        assert pin.type is JointType.REVOLUTE
        assert pin.limits.upper == 0.0


ROBOT = """<robot name="r"><link name="pad"/><link name="finger"/>
<joint name="elbow_joint" type="continuous"><parent link="pad"/><child link="finger"/>
</joint>{slide}
{body}
</robot>"""
EFFORT = "hardware_interface/EffortJointInterface"
GRIPPER = (
    '<parallel_gripper name="g" joint="elbow_joint" pad_offset="0.005" pad_cos="0.04" '
    'pad_sin="-0.04" max_opening="0.08" min_speed="0.02" max_speed="0.15" '
    'min_force="20" max_force="235"/>'
)


JAWS = (
    '<parallel_gripper name="g" joint="slide" pad_offset="0.025" pad_slope="-1" '
    'max_opening="0.05" min_speed="0.02" max_speed="0.15" '
    'min_force="60" max_force="130"/>'
)
SLIDE = (
    '<link name="jaw"/><joint name="slide" type="prismatic"><parent link="pad"/>'
    '<child link="jaw"/><limit lower="0" upper="0.025" effort="260" velocity="0.1"/>'
    "</joint>"
)


def read_inside(body: str) -> RobotModel:
    text = ROBOT.format(slide=SLIDE, body=body)
    return read_model(parse_text(text, Path("r.urdf")))


def transmission(
    joint: str = "elbow_joint", in_joint: str = "", in_actuator: str = ""
) -> str:
    return (
        f'<transmission name="t"><joint name="{joint}">{in_joint}</joint>'
        f'<actuator name="m">{in_actuator}</actuator></transmission>'
    )


def interface(text: str) -> str:
    return f"<hardwareInterface>{text}</hardwareInterface>"


@pytest.mark.parametrize("expected", list(Interface))
@pytest.mark.parametrize("prefix", ["", "hardware_interface/"])
def test_reads_the_interface_with_and_without_its_package(
    expected: Interface, prefix: str
) -> None:
    text = interface(prefix + expected.value.partition("/")[2])
    (found,) = read_inside(transmission(in_joint=text)).transmissions
    assert found.interfaces == (expected,)
    assert found.armature == 0


def test_the_joints_interface_goes_before_the_actuators() -> None:
    position = interface("PositionJointInterface")
    (both,) = read_inside(
        transmission("elbow_joint", interface(EFFORT), position)
    ).transmissions
    (one,) = read_inside(transmission(in_actuator=position)).transmissions
    assert both.interfaces == (Interface.EFFORT,)
    assert one.interfaces == (Interface.POSITION,)


def test_reads_the_motor() -> None:
    motor = (
        "<mechanicalReduction>26</mechanicalReduction><rotorInertia>2e-5</rotorInertia>"
    )
    (found,) = read_inside(
        transmission(in_joint=interface(EFFORT), in_actuator=motor)
    ).transmissions
    assert found.mechanical_reduction == 26
    assert found.armature == pytest.approx(2e-5 * 26**2)


@pytest.mark.parametrize(
    ("body", "named"),
    [
        (transmission(in_joint=interface("hardware/interface/EffortJointInterface")),
         "'hardware_interface/EffortJointInterface'"),
        (transmission(in_joint=interface("hardware_interface/EfortJointInterface")),
         "'hardware_interface/EffortJointInterface'"),
        (transmission(), "<hardwareInterface>"),
        (transmission("elbow", interface(EFFORT)),
         "'elbow_joint'"),
        (transmission(in_joint=interface(EFFORT)) * 2, "'elbow_joint'"),
        ("<transmission name='t'/>", "<joint>"),
        (transmission(in_joint=interface(EFFORT),
                      in_actuator="<mechanicalReduction>0</mechanicalReduction>"),
         "reduction 0"),
        (transmission(in_joint=interface(EFFORT),
                      in_actuator="<rotorInertia>-1</rotorInertia>"), "inertia -1"),
        (transmission(in_joint=interface(EFFORT),
                      in_actuator="<rotorInertia>x</rotorInertia>"),
         "'x'"),
        ('<gazebo reference="pad"><mu1>-1</mu1></gazebo>', "<mu1>"),
        ('<gazebo reference="pad"><kp>stiff</kp></gazebo>', "'stiff'"),
        ('<gazebo reference="pad"><selfCollide>maybe</selfCollide></gazebo>',
         "'maybe'"),
        (GRIPPER.replace("elbow_joint", "knee"), "'knee'"),
        (GRIPPER.replace("235", "nan"), "'nan'"),
        (GRIPPER.replace('"0.08"', '"0.2"'), "0.2"),
        (GRIPPER.replace("pad_sin", "pad_tan"), 'pad_sin="'),
        (GRIPPER.replace("pad_cos", "a").replace("pad_sin", "b"), "either pad_cos"),
        (GRIPPER.replace("/>", ' pad_slope="-1"/>'), "either pad_cos"),
        (JAWS.replace("slide", "elbow_joint"),
         "'elbow_joint', but with pad_slope it must slide"),
        (JAWS.replace('"-1"', '"1"'), "'slide' grows, but must close"),
        (JAWS.replace('"-1"', '"0"'), "'slide' grows, but must close"),
        (GRIPPER.replace("elbow_joint", "slide"),
         "'slide', but with pad_cos and pad_sin it must turn"),
    ],
)  # fmt: skip
def test_refuses_what_cannot_be_driven_or_touched(body: str, named: str) -> None:
    with pytest.raises((ModelError, DescriptionError)) as caught:
        read_inside(body)
    assert named in str(caught.value)
    assert str(caught.value.location) == "r.urdf:4"


def test_a_reference_to_what_is_not_there_is_told(
    caplog: pytest.LogCaptureFixture,
) -> None:
    read_inside('<gazebo reference="pads"><mu1>1</mu1></gazebo>')
    for named in ("r.urdf:4", "'pads'", "'pad'"):
        assert named in caplog.text


def test_refuses_speeds_the_wrong_way_round() -> None:
    with pytest.raises(LimitsError):
        read_inside(GRIPPER.replace('min_speed="0.02"', 'min_speed="0.2"'))


def test_all_gazebo_elements_of_a_link_count_together() -> None:
    model = read_inside(
        '<gazebo reference="pad"><mu1>1.5</mu1><kp>100000.0</kp></gazebo>'
        '<gazebo reference="pad"><minDepth>0.001</minDepth><maxVel>0.1</maxVel>'
        "<selfCollide>true</selfCollide></gazebo>"
        '<gazebo reference="elbow_joint"><implicitSpringDamper>1</implicitSpringDamper>'
        "</gazebo><gazebo><plugin/></gazebo>"
    )
    pad = model.link("pad")
    assert pad.surface == Surface(mu1=1.5)
    finger = model.link("finger")
    assert finger.surface is None


def test_reads_a_parallel_gripper() -> None:
    (gripper,) = read_inside(GRIPPER).grippers
    assert gripper.position(gripper.opening(0.3)) == pytest.approx(0.3)
    assert (gripper.speed, gripper.force) == ((0.02, 0.15), (20, 235))


def test_a_gripper_may_name_its_protocol() -> None:
    (gripper,) = read_inside(GRIPPER).grippers
    assert gripper.protocol is None
    (gripper,) = read_inside(GRIPPER.replace("/>", ' protocol="robotiq"/>')).grippers
    assert gripper.protocol == ROBOTIQ
    wrong = GRIPPER.replace("/>", ' protocol="onrobot"/>')
    with pytest.raises(DescriptionError) as caught:
        read_inside(wrong)
    assert "unknown gripper protocol 'onrobot'; tool0 has robotiq" in str(caught.value)
    assert "r.urdf:4" in str(caught.value)


def test_reads_a_gripper_whose_fingers_slide() -> None:
    (gripper,) = read_inside(JAWS).grippers
    assert gripper.quantity is LENGTH
    assert [gripper.position(o) for o in (0.05, 0.03, 0.0)] == pytest.approx(
        [0.0, 0.01, 0.025]
    )
    for position in (0.0, 0.007, 0.025):
        assert gripper.position(gripper.opening(position)) == pytest.approx(position)
        assert gripper.lever(position) == 2.0
