from __future__ import annotations

import pickle

from robot_xml import DRIVEN, check, joint, link, plugin, root_of, transmission

from tool0.description.loading import assemble
from tool0.lint.robot.elements import Tag
from tool0.lint.robot.facts import facts_of


def root_tag(*parts: str) -> Tag:
    return Tag(root_of(*parts))


def test_the_facts_of_a_good_robot() -> None:
    facts = facts_of(root_tag(DRIVEN))
    assert facts.name == "r"
    assert list(facts.links) == ["world", "arm"]
    hinge = facts.joints["hinge"]
    assert (hinge.type, hinge.parent, hinge.child) == ("revolute", "world", "arm")
    assert hinge.has_limits
    assert facts.driven_joints == {"hinge"}
    (interface,) = facts.interfaces_of("hinge")
    assert interface.meant == "hardware_interface/EffortJointInterface"
    assert len(facts.control_plugins) == 1


def test_a_wrong_robot_has_facts_too() -> None:
    facts = facts_of(
        root_tag("<joint/><link/>", '<joint name="j"/>', "<transmission/>")
    )
    assert (list(facts.joints), facts.links) == (["j"], {})
    assert not facts.joints["j"].has_limits


def test_facts_can_be_sent_to_another_process() -> None:
    facts = facts_of(root_tag(DRIVEN, plugin("libx.so", "<a>1</a>")))
    assert pickle.loads(pickle.dumps(facts)) == facts


def test_the_joints_of_ros2() -> None:
    system = (
        '<ros2_control><joint name="hinge"><command_interface name="position"/></joint>'
        '<joint name="passive"/></ros2_control>'
    )
    facts = facts_of(root_tag(system))
    assert facts.ros2_joints == {"hinge": ("position",), "passive": ()}
    assert facts.driven_joints == {"hinge"}


def test_the_gearboxes_of_the_projects_own_gripper() -> None:
    root = root_of(assemble().urdf.partition("<robot")[2].partition(">")[2][:-10])
    facts = facts_of(Tag(root))
    assert len(facts.gearboxes) == 5
    assert facts.driven_joints >= {"elbow_joint", "finger_joint"}
    followers = {j.name for j in facts.joints.values() if j.mimic_of}
    assert len(followers) == 5


def test_a_second_joint_of_the_name_does_not_hide_the_first() -> None:
    again = joint("hinge", "x", "y", type="fixed") + link("y")
    assert facts_of(root_tag(DRIVEN, again)).joints["hinge"].type == "revolute"
    assert check(DRIVEN, again, transmission("hinge"))
