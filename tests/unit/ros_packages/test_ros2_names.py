"""Names of one robot of a cell in its namespace."""

from __future__ import annotations

import re

import pytest
from tool0_ros2.names import Names

from tool0.protocol.controllers import start_command


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


@pytest.mark.parametrize(
    ("advice", "command"),
    [
        (start_command("left_a"), "switch_controllers --activate a"),
        (
            start_command("left_a", ["left_b", "left_c"]),
            "switch_controllers --deactivate b c --activate a",
        ),
        (
            "`tool0 controllers load left_a` or robot.load('left_a')",
            "load_controller a",
        ),
        (
            "`tool0 controllers configure left_a` or robot.configure('left_a')",
            "set_controller_state a inactive",
        ),
    ],
)
def test_advice_about_controllers_is_a_command_of_ros2(
    advice: str, command: str
) -> None:
    text = Names("/left", "left_").text(f"refused; start it with {advice}; again")
    assert text == (
        f"refused; start it with `ros2 control {command} -c /left/controller_manager`"
        "; again"
    )
    alone = Names("").text(advice)
    assert re.fullmatch(r"`ros2 control [^`]+`", alone)
    assert "controller_manager" not in alone
