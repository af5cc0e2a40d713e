"""Loops, passive joints and springs: read strictly, and closed wherever they rest."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from tool0.description.catalogue import assemble
from tool0.description.forward_kinematics import link_poses
from tool0.description.model import JointType, RobotModel, Spring
from tool0.description.urdf import read_model
from tool0.description.xml_source import parse_text
from tool0.errors import DescriptionError, ModelError, Tool0Error


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


def test_unknown_gripper_models_and_those_of_no_gripper_are_refused() -> None:
    with pytest.raises(DescriptionError) as unknown:
        assemble(gripper_model="linkag")
    assert "'linkage'" in str(unknown.value)
    with pytest.raises(DescriptionError) as none:
        assemble(gripper=None, gripper_model="linkage")
    assert "gripper_model" in str(none.value)
