"""Names of one robot of a cell in its namespace."""

from __future__ import annotations

from tool0_ros2.names import Names


def test_without_a_prefix_names_stay() -> None:
    names = Names("/cell")
    assert names.to_ros("left_tool0") == names.to_model("left_tool0") == "left_tool0"
    assert names.topic("joint_states") == "/cell/joint_states"
    assert names.topic("/tf") == "/tf"
    assert names.frame("left_tool0") == "left_tool0"
    assert names.own_values({"a": ["left_x"]}) == {"a": ["left_x"]}


def test_a_robot_has_the_names_that_it_has_alone() -> None:
    names = Names("/left", "left_", tf_prefix="left", longer=["left_arm_"])
    assert names.to_ros("left_elbow_joint") == "elbow_joint"
    assert names.to_model("elbow_joint") == "left_elbow_joint"
    assert names.frame("left_tool0") == "left/tool0"
    assert not names.owns("right_elbow_joint")
    assert not names.owns("left_arm_elbow_joint")
    assert names.to_ros("right_elbow_joint") == "right_elbow_joint"
    assert names.text("unknown joint 'left_a'; my_left_a") == (
        "unknown joint 'a'; my_left_a"
    )
    values = {"constraints.left_a.goal": 0.1, "joints": ["left_a", "right_a"], "n": 2}
    assert names.own_values(values) == {
        "constraints.a.goal": 0.1,
        "joints": ["a", "right_a"],
        "n": 2,
    }
