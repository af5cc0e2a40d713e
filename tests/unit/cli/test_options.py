import inspect
from pathlib import Path

import pytest
from tool0.cli.quick import read_bringup

from tool0.cli.options import (
    DEFAULT_SPAWN_Z,
    BringupOptions,
    ControllerOptions,
    RobotOptions,
    SimulationOptions,
    assignments,
    bringup_keywords,
    joint_values,
    pose,
)
from tool0.cli.parsing import gathered
from tool0.errors import ConfigError
from tool0.runtime.bringup import bringup


def test_every_option_is_a_keyword_of_bringup() -> None:
    full = BringupOptions(
        description=RobotOptions(
            robot=Path("r"),
            args=("a:=1",),
            mount_xyz=(0.0, 0.0, 0.1),
            mount_rpy=(0.0, 0.0, 1.0),
            joint_limit_params=Path("a"),
            kinematics_params=Path("a"),
            physical_params=Path("a"),
            visual_params=Path("a"),
            gripper_params=Path("a"),
            gripper_joint_limit_params=Path("a"),
            transmission_hw_interface="x",
            safety_limits=True,
            safety_pos_margin=0.1,
            safety_k_position=20.0,
            tf_prefix="x",
            spawn_z=0.1,
        ),
        control=ControllerOptions(
            controllers_file=(Path("a"),), controllers="a", stopped_controllers="b"
        ),
        simulation=SimulationOptions(
            engine="gazebo",
            initial_pose=("a=1",),
            scene=Path("a"),
            world=Path("a"),
            gazebo_gui=True,
            speed=2.0,
        ),
    )
    keywords = bringup_keywords(full)
    inspect.signature(bringup).bind(**keywords)
    in_python_only = {"dt", "control_period", "cameras"}  # a scene's file has them
    assert inspect.signature(bringup).parameters.keys() - keywords == in_python_only
    assert keywords["args"] == {"a": "1"}
    assert keywords["initial_pose"] == {"a": 1.0}


def test_defaults_are_those_of_bringup() -> None:
    written_out = {"meshes": "tool0", "safety_limits": False}
    parameters = inspect.signature(bringup).parameters
    for name, value in bringup_keywords(BringupOptions()).items():
        default = parameters[name].default
        assert value == (written_out.get(name) if default is None else default), name
    assert parameters["spawn_z"].default == DEFAULT_SPAWN_Z


def test_a_pose_is_a_name_or_joints() -> None:
    assert pose(("home",)) == "home"
    assert pose(("a=1", "b=-2.5")) == {"a": 1.0, "b": -2.5}


@pytest.mark.parametrize(
    "words",
    [("a",), ("=1",), ("a=",), ("a=x",), ("a=nan",), ("a=inf",), ("a=1", "a=2")],
)
def test_joints_that_make_no_sense_are_named(words: tuple[str, ...]) -> None:
    with pytest.raises(ConfigError, match="--joints"):
        joint_values(words, "--joints")


def test_an_argument_may_hold_the_sign_and_be_empty() -> None:
    words = ("a:=b:=c", "empty:=")
    assert assignments(words, ":=", "--args") == {"a": "b:=c", "empty": ""}


@pytest.mark.parametrize("duration", [-1.0, float("nan"), float("inf")])
def test_a_duration_that_makes_no_sense_is_refused(duration: float) -> None:
    with pytest.raises(ConfigError, match="--duration"):
        SimulationOptions(duration=duration)


@pytest.mark.parametrize(
    ("line", "option"),
    [("--world a.world", "--world"), ("--gazebo-gui", "--gazebo-gui")],
)
def test_what_is_for_gazebo_needs_gazebo(line: str, option: str) -> None:
    with pytest.raises(ConfigError, match=f"{option} .* add --engine gazebo"):
        read_bringup(line.split())
    options = read_bringup(["--engine", "gazebo", *line.split()])
    assert options is not None
    assert options.simulation.engine == "gazebo"


def test_repeated_options_are_gathered_in_order() -> None:
    words = [
        "--args",
        "a:=1",
        "--arm",
        "x",
        "--args",
        "b:=2",
        "c:=3",
        "--args=d:=4",
        "--arm",
        "y",
    ]
    assert gathered(words) == [
        "--args",
        "a:=1",
        "b:=2",
        "c:=3",
        "d:=4",
        "--arm",
        "x",
        "--arm",
        "y",
    ]
    assert gathered(["verb", "--name", "x"]) == ["verb", "--name", "x"]
