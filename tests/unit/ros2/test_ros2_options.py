"""Options of the ROS 2 interface, and of the command line."""

from __future__ import annotations

import pytest

from tool0.cli.options import BringupOptions, Ros2NodeOptions, RunOptions
from tool0.errors import ConfigError
from tool0.ros2.options import Ros2Options


@pytest.mark.parametrize(
    "wrong",
    [
        {"ns": "1robot"},
        {"ns": "a//b"},
        {"domain": -1},
        {"domain": 233},
        {"tf_rate": 0.0},
        {"tf_rate": float("nan")},
        {"camera_rate": 200.0},
    ],
    ids=str,
)
def test_a_wrong_option_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ConfigError):
        Ros2Options(**wrong)  # type: ignore[arg-type]


@pytest.mark.parametrize("ns", ["", "/", "robot1", "/cell/robot_1", "cell/robot1/"])
def test_namespaces(ns: str) -> None:
    assert Ros2Options(ns=ns).ns == ns


def test_options_of_the_node_need_the_node() -> None:
    with pytest.raises(ConfigError, match="--ros2"):
        BringupOptions(ros2=Ros2NodeOptions(domain=3))
    with pytest.raises(ConfigError, match="exclude"):
        RunOptions(ros1=True, ros2=True)
    with pytest.raises(ConfigError, match="--no-remote"):
        RunOptions(ros2=True, remote=False)
