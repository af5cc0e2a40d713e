"""The colcon packages of `tool0 workspace --ros2` fit the robot that they are for."""

from __future__ import annotations

import ast
from pathlib import Path, PurePosixPath
from typing import Any
from xml.etree import ElementTree as ET

import pytest
import yaml

from tool0.control.config import ControllerConfig
from tool0.control.default_controllers import controllers_yaml
from tool0.description.config import DescriptionConfig
from tool0.description.expansion import expand
from tool0.description.loading import load_description
from tool0.description.packages import preferring
from tool0.description.robot import RobotDescription
from tool0.description.urdf import read_model
from tool0.installation.colcon.bringup import (
    BRINGUP,
    colcon_packages,
    controller_parameters,
    gazebo_controllers,
)
from tool0.installation.moveit.ros2_package import moveit2_package
from tool0.installation.robot_packages import Files
from tool0.installation.workspace import write_workspace
from tool0.lint.check import CheckReport, check
from tool0.lint.launch.model import Include, LaunchFile, Node
from tool0.lint.launch.reader import read_launch
from tool0.lint.packages import PackageIndex
from tool0.simulation.config import ControlConfig
from tool0.simulation.controllers import choose_controllers

pytestmark = pytest.mark.slow

LAUNCH = PurePosixPath(BRINGUP, "launch")
CELL = ("left=ur5e+2f85@0,0.4,0", "right=ur3e@0,-0.4,0")
ABSENT = ("ros_gz_sim", "robotiq_controllers")
"""Packages that findings may name: they are not part of the workspace."""


def written(description: RobotDescription) -> Files:
    controllers = controllers_yaml(description)
    parameters, limits = controller_parameters(controllers)
    return colcon_packages(
        description,
        controllers=controllers,
        started=choose_controllers(description, ControlConfig()).started,
    ) | moveit2_package(description, disabled={}, controllers=parameters, limits=limits)


class Workspace:
    """A workspace, and what launch files in it do."""

    def __init__(self, folder: Path, description: RobotDescription) -> None:
        self.description = description
        self.source = write_workspace(folder, written(description)).source
        self.packages = {p.name: p for p in sorted(self.source.iterdir())}
        (self.moveit,) = (n for n in self.packages if n.endswith("_moveit_config"))

    def launch(self, package: str, file: str, **arguments: str) -> LaunchFile:
        path = self.packages[package] / "launch" / file
        return read_launch(path, arguments, PackageIndex(self.packages))

    def config(self, package: str, end: str) -> Any:
        (path,) = (self.packages[package] / "config").glob(f"*{end}")
        return yaml.safe_load(path.read_text(encoding="utf-8"))


def robot(**config: Any) -> RobotDescription:
    return load_description(DescriptionConfig(ros2_control=True, **config))


@pytest.fixture(scope="module")
def single(tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    return Workspace(tmp_path_factory.mktemp("single"), robot(arm="ur5e"))


@pytest.fixture(scope="module")
def cell(tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    return Workspace(tmp_path_factory.mktemp("cell"), robot(robots=CELL))


@pytest.fixture(params=["single", "cell"])
def workspace(request: pytest.FixtureRequest) -> Workspace:
    found: Workspace = request.getfixturevalue(request.param)
    return found


def programs(launch: LaunchFile) -> list[str]:
    return [f"{n.package.resolved}/{n.type.resolved}" for n in launch.nodes()]


def spawned(launch: LaunchFile) -> list[str]:
    nodes = [n for n in launch.nodes() if n.type.resolved == "spawner"]
    return [word for n in nodes for word in n.words if word[0] not in "-/"]


@pytest.mark.usefixtures("at_once")
@pytest.mark.slow
def test_the_checker_finds_no_error(workspace: Workspace) -> None:
    ours = [workspace.packages[name] for name in (BRINGUP, workspace.moveit)]
    report: CheckReport = check(ours)
    found = [f for f in report.findings if not any(a in f.message for a in ABSENT)]
    assert found == []
    assert sum(path.name.endswith(".launch.py") for path in report.files) == 6


def test_every_manifest_names_what_is_used(workspace: Workspace) -> None:
    for name in (BRINGUP, workspace.moveit):
        root = ET.parse(workspace.packages[name] / "package.xml").getroot()
        needed = {e.text for e in root.iter("exec_depend")}
        assert root.get("format") == "3"
        assert root.findtext("export/build_type") == "ament_cmake"
        for file in (workspace.packages[name] / "launch").iterdir():
            launch = workspace.launch(name, file.name)
            used = {n.package.resolved for n in launch.nodes()}
            assert used - {name} <= needed | {"robot_state_publisher"}


def test_gazebo_gets_the_robot_with_its_plugin(workspace: Workspace) -> None:
    launch = workspace.launch(BRINGUP, "gz.launch.py")
    assert programs(launch) == [
        "robot_state_publisher/robot_state_publisher",
        "ros_gz_sim/create",
        "ros_gz_bridge/parameter_bridge",
        "controller_manager/spawner",
        "controller_manager/spawner",
        "rviz2/rviz2",
    ]
    (command,) = (p for p in launch.parameters() if p.source == "command")
    given = dict(word.split(":=") for word in command.words[2:])
    with preferring(workspace.packages):
        document = expand(Path(command.words[1]), given).document
    plugins = document.getElementsByTagName("plugin")
    files = [p.getAttribute("filename") for p in plugins if p.hasAttribute("filename")]
    assert files == ["gz_ros2_control-system"]
    (parameters,) = document.getElementsByTagName("parameters")
    assert parameters.firstChild.data.endswith("_controllers_gz.yaml")
    model = read_model(document)
    assert {j.name for j in model.joints} == {
        j.name for j in workspace.description.model.joints
    }
    joints = workspace.config(BRINGUP, "_gz.yaml")
    assert set(spawned(launch)) <= set(joints)


def test_the_arguments_are_those_of_ur_simulation_gz(single: Workspace) -> None:
    launch = single.launch(BRINGUP, "gz.launch.py")
    values = {
        a.name: a.default.resolved
        for file in launch.files()
        for a in file.arguments
        if a.default is not None
    }
    assert (
        values.items()
        >= {
            "ur_type": "ur5e",
            "safety_limits": "true",
            "safety_pos_margin": "0.15",
            "safety_k_position": "20",
            "tf_prefix": "",
            "activate_joint_controller": "true",
            "initial_joint_controller": "joint_trajectory_controller",
            "launch_rviz": "true",
            "gazebo_gui": "true",
            "world_file": "empty.sdf",
        }.items()
    )
    assert {"controllers_file", "description_file", "rviz_config_file"} <= set(values)
    idle = single.launch(BRINGUP, "gz.launch.py", activate_joint_controller="false")
    assert "--inactive" in [word for node in idle.nodes() for word in node.words]


def test_controllers_in_gazebo_need_only_what_joints_offer(
    workspace: Workspace,
) -> None:
    config = workspace.config(BRINGUP, "_gz.yaml")
    text = yaml.safe_dump(config)
    offered = {
        name
        for component in workspace.description.model.hardware
        for name in component.command_interfaces
    }
    assert "speed_scaling" not in text
    assert "set_gripper_max" not in text
    for node in config.values():
        values = node["ros__parameters"]
        kinds = values.get("command_interfaces", [values.get("interface_name")])
        joints = values.get("joints", [])
        claims = {f"{joint}/{kind}" for joint in joints for kind in kinds}
        assert claims <= offered
    names = set(ControllerConfig.from_text(text).names)
    assert names == set(config) - {"controller_manager"}


def test_a_forwarder_of_an_interface_that_joints_lack_is_left_out() -> None:
    manager = {"f": {"type": "forward_command_controller/ForwardCommandController"}}
    parameters = {
        "controller_manager": {"ros__parameters": {"update_rate": 500, **manager}},
        "f": {"ros__parameters": {"joints": ["a"], "interface_name": "effort"}},
    }
    kept = gazebo_controllers(parameters, frozenset({"a/effort"}))
    assert set(kept) == {"controller_manager", "f"}
    without = gazebo_controllers(parameters, frozenset({"a/position"}))
    assert without == {"controller_manager": {"ros__parameters": {"update_rate": 500}}}


def test_tool0_starts_with_controllers_that_exist(workspace: Workspace) -> None:
    launch = workspace.launch(BRINGUP, "tool0.launch.py")
    assert programs(launch) == []  # tool0 is a program, and the only one
    started = launch.argument("controllers")
    assert started is not None
    assert started.value is not None
    (path,) = (workspace.packages[BRINGUP] / "config").glob("*_controllers.yaml")
    names = (started.value.resolved or "").split()
    assert names
    assert set(names) <= set(ControllerConfig.from_files(path).names)
    alone = workspace.launch(BRINGUP, "tool0.launch.py", start_tool0="false")
    assert programs(alone) == ["tool0_ros2/node"]


def test_moveit_executes_by_controllers_that_exist(workspace: Workspace) -> None:
    config = workspace.config(workspace.moveit, "moveit_controllers.yaml")
    simple = config["moveit_simple_controller_manager"]
    (path,) = (workspace.packages[BRINGUP] / "config").glob("*_controllers.yaml")
    names = ControllerConfig.from_files(path).names
    assert set(simple["controller_names"]) <= set(names)
    kinds = {simple[name]["type"] for name in simple["controller_names"]}
    assert kinds == {"FollowJointTrajectory", "ParallelGripperCommand"}
    moved = {j for name in simple["controller_names"] for j in simple[name]["joints"]}
    limits = workspace.config(workspace.moveit, "joint_limits.yaml")["joint_limits"]
    assert moved == set(limits)
    srdf = next((workspace.packages[workspace.moveit] / "config").glob("*.srdf"))
    groups = {g.get("name") for g in ET.parse(srdf).getroot().iter("group")}
    assert set(workspace.config(workspace.moveit, "kinematics.yaml")) <= groups
    planning = workspace.config(workspace.moveit, "ompl_planning.yaml")
    assert groups & set(planning)


def test_moveit_s_launch_files_name_what_they_need(workspace: Workspace) -> None:
    demo = workspace.launch(workspace.moveit, "demo.launch.py")
    assert "moveit_ros_move_group/move_group" in programs(demo)
    assert "controller_manager/ros2_control_node" in programs(demo)
    (urdf,) = (workspace.packages[workspace.moveit] / "config").glob("*.urdf")
    text = urdf.read_text(encoding="utf-8")
    assert "mock_components/GenericSystem" in text
    assert "gz_ros2_control" not in text


def test_a_launch_file_finds_all_that_it_includes(workspace: Workspace) -> None:
    for name in (BRINGUP, workspace.moveit):
        for file in (workspace.packages[name] / "launch").iterdir():
            ast.parse(file.read_text(encoding="utf-8"))
            launch = workspace.launch(name, file.name)
            includes = [e for e in launch.walk() if isinstance(e, Include)]
            missing = [i.file.raw for i in includes if i.launch is None]
            assert all("$(find ros_gz_sim)" in raw for raw in missing)
            assert [n for n in launch.nodes() if not isinstance(n, Node)] == []


@pytest.mark.slow
@pytest.mark.parametrize("arm", ["ur3", "ur10e", "ur30"])
@pytest.mark.parametrize("gripper", ["none", "2f140", "hande"])
def test_any_robot_of_the_catalogue_can_be_written(arm: str, gripper: str) -> None:
    files = written(robot(arm=arm, gripper=None if gripper == "none" else gripper))
    text = files[LAUNCH / "description.launch.py"].decode()
    assert f'"ur_type": ("{arm}"' in text
    assert f'"{gripper}",' in text
    assert not [path for path, data in files.items() if b"@robot@" in data]
