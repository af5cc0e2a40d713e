"""The MoveIt package is built, linted and launched by Debian's ROS 1.

Debian has no MoveIt: empty packages stand in, so that roslaunch finds them.  What it
would set and run is read, not run.
"""

from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import pytest
import yaml
from catkin_rig import Catkin, require_catkin

from tool0.cli import OK, main
from tool0.description.loading import assemble
from tool0.description.urdf import read_model
from tool0.description.xml_source import parse_text
from tool0.lint.check import check

PACKAGE = "ur5_2f85_moveit_config"
SIMPLE = "moveit_simple_controller_manager/MoveItSimpleControllerManager"


@pytest.fixture(scope="module")
def catkin(tmp_path_factory: pytest.TempPathFactory) -> Catkin:
    """Write a workspace, as a person does."""
    require_catkin()
    catkin = Catkin(tmp_path_factory.mktemp("moveit") / "workspace")
    assert main(["workspace", str(catkin.folder), "--moveit"]) == OK
    return catkin


@pytest.fixture(scope="module")
def parameters(catkin: Catkin) -> dict[str, Any]:
    return catkin.parameters(PACKAGE, "move_group.launch")


def config(catkin: Catkin, file: str) -> Any:
    return yaml.safe_load((catkin.source / PACKAGE / "config" / file).read_text())


def below(parameters: dict[str, Any], name: str) -> dict[str, Any]:
    """Return the parameters of a namespace as the nested mapping that YAML has."""
    found: dict[str, Any] = {}
    for path, value in parameters.items():
        if path.startswith(f"{name}/"):
            *parents, last = path.removeprefix(f"{name}/").split("/")
            at = found
            for parent in parents:
                at = at.setdefault(parent, {})
            at[last] = value
    return found


def test_catkin_installs_every_file(catkin: Catkin) -> None:
    catkin.out("catkin_make", f"-DCMAKE_INSTALL_PREFIX={catkin.install}", "install")
    here, there = catkin.source / PACKAGE, catkin.install / "share" / PACKAGE
    for path in here.rglob("*"):
        if path.is_file() and path.name != "CMakeLists.txt" and path.name[0] != ".":
            assert (there / path.relative_to(here)).read_bytes() == path.read_bytes()


def test_catkin_lint_has_nothing_to_say(catkin: Catkin) -> None:
    answer = catkin.run("catkin_lint", "-W2", "--strict", f"src/{PACKAGE}")
    assert "found 0 problems" in answer.stderr, answer.stderr


def test_every_launch_file_is_resolved(catkin: Catkin) -> None:
    files = sorted((catkin.source / PACKAGE / "launch").glob("*.launch*"))
    assert len(files) > 8
    for file in files:
        catkin.out("roslaunch", "--dump-params", file)
        for argument in ET.parse(file).getroot().iterfind("arg"):
            assert len(argument.get("doc", "")) > 9, (file, argument.attrib)


def test_move_group_is_given_robot_limits_and_solvers(
    catkin: Catkin, parameters: dict[str, Any]
) -> None:
    folder = catkin.source / PACKAGE / "config"
    srdf = (folder / "ur5_2f85.srdf").read_text()
    assert str(parameters["/robot_description_semantic"]).split() == srdf.split()
    planning = below(parameters, "/robot_description_planning")
    assert planning == config(catkin, "joint_limits.yaml")
    kinematics = below(parameters, "/robot_description_kinematics")
    assert kinematics == config(catkin, "kinematics.yaml")
    ompl = below(parameters, "/move_group/planning_pipelines/ompl")
    assert ompl.pop("planning_plugin") == "ompl_interface/OMPLPlanner"
    adapters = str(ompl.pop("request_adapters")).split()
    assert all(a.startswith("default_planner_request_adapters/") for a in adapters)
    assert ompl.pop("start_state_max_bounds_error") == 0.1
    assert ompl == config(catkin, "ompl_planning.yaml")
    assert parameters["/move_group/default_planning_pipeline"] == "ompl"
    assert catkin.nodes(PACKAGE, "move_group.launch") == {"/move_group"}


def test_the_simulation_sets_the_robot_unless_it_is_asked_for(
    catkin: Catkin, parameters: dict[str, Any]
) -> None:
    assert "/robot_description" not in parameters
    loaded = catkin.parameters(
        PACKAGE, "planning_context.launch", "load_robot_description:=true"
    )
    robot = read_model(parse_text(str(loaded["/robot_description"])))
    assert robot == assemble().model


@pytest.mark.parametrize(
    ("gripper_action", "kind"),
    [("false", "FollowJointTrajectory"), ("true", "GripperCommand")],
)
def test_the_controllers_follow_the_grippers(
    catkin: Catkin, gripper_action: str, kind: str
) -> None:
    found = catkin.parameters(
        PACKAGE, "move_group.launch", f"gripper_action:={gripper_action}"
    )
    assert found["/move_group/moveit_controller_manager"] == SIMPLE
    types = {
        controller["name"]: controller["type"]
        for controller in found["/move_group/controller_list"]
    }
    assert types == {
        "eff_joint_traj_controller": "FollowJointTrajectory",
        "gripper_controller": kind,
    }


def test_the_demo_pretends(catkin: Catkin) -> None:
    found = catkin.parameters(PACKAGE, "demo.launch", "fake_execution_type:=last point")
    assert "Fake" in str(found["/move_group/moveit_controller_manager"])
    controllers = found["/move_group/controller_list"]
    assert {controller["type"] for controller in controllers} == {"last point"}
    assert found["/joint_state_publisher/source_list"] == [
        "move_group/fake_controller_joint_states"
    ]
    nodes = catkin.nodes(PACKAGE, "demo.launch")
    named = {"/joint_state_publisher", "/robot_state_publisher", "/move_group"}
    (rviz,) = nodes - named  # its name is a random one
    assert rviz.startswith("/rviz")


def test_the_demo_in_gazebo_is_the_bringup_with_move_group(catkin: Catkin) -> None:
    nodes = catkin.nodes(PACKAGE, "demo_gazebo.launch")
    bringup = catkin.nodes("tool0_gazebo", "bringup.launch", "rqt:=false")
    assert bringup | {"/move_group"} < nodes
    found = catkin.parameters(
        PACKAGE, "demo_gazebo.launch", "gripper_action:=true", "gui:=false"
    )
    kind = "effort_controllers/GripperActionController"
    assert found["/gripper_controller/type"] == kind
    assert found["/move_group/controller_list"][1]["type"] == "GripperCommand"
    assert found["/gazebo_started/gui"] is False


@pytest.mark.parametrize(
    "options",
    [
        ["--arm", "ur10e", "--gripper", "2f140"],
        ["--robots", "left=ur5e+2f85@0,0.4,0", "right=ur10e@0,-0.4,0"],
    ],
    ids=" ".join,
)
def test_other_robots_have_packages_that_launch(
    tmp_path: Path, options: list[str]
) -> None:
    require_catkin()
    catkin = Catkin(tmp_path / "workspace")
    assert main(["workspace", str(catkin.folder), "--moveit", *options]) == OK
    (package,) = (path.name for path in catkin.source.glob("*_moveit_config"))
    found = catkin.parameters(package, "demo.launch")
    groups = below(found, "/robot_description_kinematics")
    names = {c["name"] for c in found["/move_group/controller_list"]}
    assert {f"fake_{group}_controller" for group in groups} <= names
    rules = {finding.rule for finding in check([catkin.folder]).findings}
    assert rules <= {"implausible-inertia"}  # of the knuckles in Gazebo, on purpose
