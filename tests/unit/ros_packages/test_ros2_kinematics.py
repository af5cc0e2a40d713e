"""Frames computed by the ROS 2 node, compared with tool0's own kinematics."""

from __future__ import annotations

import numpy as np
import pytest
from tool0_ros2.kinematics import LinkTree, read_joints
from tools.ros2_copies import MODULE, module_text

from tool0.description.forward_kinematics import link_poses
from tool0.description.loading import assemble
from tool0.description.urdf import read_model
from tool0.description.xml_source import parse_text

SLIDER = """
<robot name="slider">
  <link name="a"/><link name="b"/><link name="c"/>
  <joint name="slide" type="prismatic">
    <parent link="a"/><child link="b"/>
    <origin xyz="1 2 3" rpy="0.1 0.2 0.3"/><axis xyz="0 2 0"/>
    <limit lower="0" upper="1" velocity="1" effort="1"/>
  </joint>
  <joint name="turn" type="revolute">
    <parent link="b"/><child link="c"/><axis xyz="0.6 0 0.8"/>
    <limit lower="-9" upper="9" velocity="1" effort="1"/>
    <mimic joint="slide" multiplier="-2" offset="0.5"/>
  </joint>
</robot>
"""


@pytest.mark.parametrize("urdf", [SLIDER, assemble("ur5e").urdf], ids=["own", "ur5e"])
def test_frames_are_those_of_the_model(urdf: str) -> None:
    rng = np.random.default_rng(seed=4)
    model = read_model(parse_text(urdf))
    joints = read_joints(urdf)
    assert {joint.name for joint in joints} == model.joint_by_name.keys()
    given = {
        joint.name: float(rng.uniform(-1.5, 1.5))
        for joint in model.movable_joints
        if joint.mimic is None
    }
    tree, expected = LinkTree(urdf), link_poses(model, given)
    assert tree.root == model.root
    for link in model.link_by_name:
        actual = tree.pose(link, given)
        np.testing.assert_allclose(actual.position, expected[link].position, atol=1e-12)
        np.testing.assert_allclose(actual.rotation, expected[link].rotation, atol=1e-12)


def test_what_the_node_shares_with_tool0_is_copied() -> None:
    assert MODULE.read_text("utf-8") == module_text(), (
        "tool0's modules have changed; run `python -m tools.ros2_copies`"
    )
