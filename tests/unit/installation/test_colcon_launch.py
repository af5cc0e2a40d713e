"""The written launch files in ROS 2's own launch, where it is installed."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import takewhile
from pathlib import Path
from typing import Any

import pytest

from tool0.control.default_controllers import controllers_yaml
from tool0.description.config import DescriptionConfig
from tool0.description.loading import load_description
from tool0.installation.colcon.bringup import BRINGUP, colcon_packages
from tool0.installation.workspace import write_workspace
from tool0.lint.launch.reader import read_launch
from tool0.lint.packages import PackageIndex

launch = pytest.importorskip("launch", reason="ROS 2's launch is not in this Python")
pytest.importorskip("launch_ros", reason="launch_ros is not in this Python")

ROBOTS = (
    {"arm": "ur5e"},
    {"arm": "ur3", "gripper": None},
    {"robots": ("left=ur5e+2f85@0,0.4,0", "right=ur3e@0,-0.4,0")},
)
OF_GAZEBO = """
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, LogInfo
from launch.substitutions import LaunchConfiguration
def generate_launch_description():
    args = LogInfo(msg=LaunchConfiguration("gz_args"))
    return LaunchDescription([DeclareLaunchArgument("gz_args"), args])
"""
Started = list[tuple[str, str, tuple[str, ...]]]
"""Package, program and arguments of each node."""


@pytest.fixture
def source(
    tmp_path: Path, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> Path:
    """The sources of a workspace, which ament finds as if they were installed."""
    description = load_description(
        DescriptionConfig(ros2_control=True, **request.param)
    )
    files = colcon_packages(
        description, controllers=controllers_yaml(description), started=["a"]
    )
    source = write_workspace(tmp_path / "workspace", files).source
    gazebo = source / "ros_gz_sim" / "launch" / "gz_sim.launch.py"
    gazebo.parent.mkdir(parents=True)
    gazebo.write_text(OF_GAZEBO, encoding="utf-8")
    share = tmp_path / "prefix" / "share"
    index = share / "ament_index" / "resource_index" / "packages"
    index.mkdir(parents=True)
    for package in source.iterdir():
        (index / package.name).touch()
        (share / package.name).symlink_to(package)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "prefix"))
    monkeypatch.setenv("GZ_SIM_RESOURCE_PATH", "")  # launch changes the real one
    return source


def started(entity: Any, context: Any) -> Iterator[tuple[str, str, tuple[str, ...]]]:
    """Yield the nodes that launch would start; no process is started."""
    from launch.actions import ExecuteLocal
    from launch.utilities import perform_substitutions as perform
    from launch_ros.actions import Node

    if isinstance(entity, ExecuteLocal):
        if isinstance(entity, Node) and (
            entity.condition is None or entity.condition.evaluate(context)
        ):
            words = (perform(context, word) for word in entity.cmd[1:])
            own = tuple(takewhile(lambda word: word != "--ros-args", words))
            yield entity.node_package, entity.node_executable, own
        return
    for inner in entity.visit(context) or ():
        yield from started(inner, context)


def without_prefix(nodes: Started, source: Path) -> Started:
    """Return the nodes with paths in the source, where links are followed."""
    return [
        (
            package,
            program,
            tuple(
                str(Path(word).resolve()) if str(source.parent.parent) in word else word
                for word in words
            ),
        )
        for package, program, words in nodes
    ]


@pytest.mark.parametrize("source", ROBOTS, indirect=True)
@pytest.mark.parametrize(
    ("file", "arguments"),
    [
        ("gz.launch.py", {}),
        ("gz.launch.py", {"activate_joint_controller": "false"}),
        ("view.launch.py", {"gui": "false", "launch_rviz": "false"}),
        ("tool0.launch.py", {"launch_rviz": "true"}),
        ("tool0.launch.py", {"start_tool0": "false", "name": "other"}),
    ],
)
def test_the_reader_finds_the_nodes_that_launch_starts(
    source: Path, file: str, arguments: dict[str, str]
) -> None:
    from launch.launch_description_sources import PythonLaunchDescriptionSource

    path = source / BRINGUP / "launch" / file
    context = launch.LaunchContext()
    context.launch_configurations.update(arguments)
    real = PythonLaunchDescriptionSource(str(path)).get_launch_description(context)
    packages = PackageIndex({folder.name: folder for folder in source.iterdir()})
    read = read_launch(path, arguments, packages)
    found = [
        (node.package.resolved or "", node.type.resolved or "", node.words)
        for node in read.nodes()
    ]
    expected = without_prefix(list(started(real, context)), source)
    assert without_prefix(found, source) == expected
    assert expected or file == "tool0.launch.py"
    assert read.findings == ()
