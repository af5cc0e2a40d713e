"""The MoveIt package agrees with the URDF that it is for, name by name."""

import itertools
from collections.abc import Iterator, Mapping
from pathlib import Path, PurePosixPath
from typing import Any
from xml.etree import ElementTree as ET

import pytest
import yaml

from tool0.control.default_controllers import controllers_yaml
from tool0.description.config import DescriptionConfig
from tool0.description.loading import (
    assemble,
    load_description,
    load_robot,
    named_poses,
)
from tool0.description.model import RobotModel
from tool0.description.robot import RobotDescription
from tool0.description.urdf import read_model
from tool0.description.xml_source import parse_text
from tool0.engines.mujoco.link_collisions import disabled_collisions
from tool0.errors import DescriptionError
from tool0.installation.moveit.package import moveit_package

OWN = Path(__file__).parents[2] / "data/description/two_robots.urdf.xacro"


class Package:
    """A MoveIt package, read back."""

    def __init__(self, description: RobotDescription) -> None:
        home = named_poses(description)["home"]
        self.files = moveit_package(
            description,
            disabled=disabled_collisions(description.model, home, n_samples=500),
            controllers=yaml.safe_load(controllers_yaml(description)),
            action_controllers=yaml.safe_load(
                controllers_yaml(description, gripper_action=True)
            ),
        )
        (folder,) = {path.parts[0] for path in self.files}
        name = folder.removesuffix("_moveit_config")
        self.folder = PurePosixPath(folder)
        self.description = description
        self.srdf = ET.fromstring(self.text(f"config/{name}.srdf"))
        self.model: RobotModel = read_model(
            parse_text(self.text(f"config/{name}.urdf"))
        )

    def text(self, file: str) -> str:
        return self.files[self.folder / file].decode()

    def config(self, file: str) -> dict[str, Any]:
        found: dict[str, Any] = yaml.safe_load(self.text(f"config/{file}.yaml"))
        return found

    def links_of(self, group: str) -> set[str]:
        """Return the links of a group, as srdfdom and MoveIt read it."""
        element = self.srdf.find(f"group[@name='{group}']")
        assert element is not None
        found = {str(link.get("name")) for link in element.iterfind("link")}
        for chain in element.iterfind("chain"):
            link, base = str(chain.get("tip_link")), chain.get("base_link")
            found |= {link, str(base)}
            while link != base:
                link = self.model.parent_joint[link].parent
                found.add(link)
        for subgroup in element.iterfind("group"):
            found |= self.links_of(str(subgroup.get("name")))
        return found

    def joints_of(self, group: str) -> set[str]:
        links = self.links_of(group)
        return {j.name for j in self.model.movable_joints if j.child in links}


CELL = ("left=ur5e+2f85@0,0.4,0", "right=ur10e+hande@0,-0.4,0", "third=ur3@2,0,0")


@pytest.fixture(
    scope="module",
    params=[
        DescriptionConfig(),
        DescriptionConfig(arm="ur3e", gripper="hande"),
        DescriptionConfig(arm="ur30", gripper=None),
        DescriptionConfig(robots=CELL),
    ],
    ids=lambda config: " ".join(config.robots or [str(config.arm)]),
)
def package(request: pytest.FixtureRequest) -> Package:
    return Package(load_description(request.param))


@pytest.fixture(scope="module")
def cell() -> Package:
    return Package(load_description(DescriptionConfig(robots=CELL)))


@pytest.fixture(scope="module")
def ur5() -> Package:
    return Package(assemble("ur5", None))


@pytest.mark.slow
def test_the_urdf_is_the_robot(package: Package) -> None:
    assert package.model == package.description.model


def test_every_name_in_the_srdf_is_in_the_urdf(package: Package) -> None:
    links = {link.name for link in package.model.links}
    joints = {joint.name for joint in package.model.joints}
    groups = {group.get("name") for group in package.srdf.findall("group")}
    valid: Mapping[tuple[str, str], set[Any]] = {
        ("link", "name"): links,
        ("chain", "base_link"): links,
        ("chain", "tip_link"): links,
        ("joint", "name"): joints,
        ("passive_joint", "name"): joints,
        ("group_state", "group"): groups,
        ("end_effector", "group"): groups,
        ("end_effector", "parent_group"): groups,
        ("end_effector", "parent_link"): links,
        ("disable_collisions", "link1"): links,
        ("disable_collisions", "link2"): links,
    }
    found = {
        (element.tag, key): value
        for element in package.srdf.iter()
        for key, value in element.items()
        if (element.tag, key) in valid and value not in valid[element.tag, key]
    }
    assert not found
    assert package.srdf.get("name") == package.model.name
    known = {tag for tag, _ in valid} | {"robot", "group"}
    assert {element.tag for element in package.srdf.iter()} <= known


def arms(package: Package) -> list[str]:
    """Return the groups of single arms."""
    names = (robot.name for robot in package.description.robots)
    return [f"{name}_manipulator" if name else "manipulator" for name in names]


def test_an_arm_is_a_chain_of_its_six_joints(package: Package) -> None:
    drives = package.model.transmission_by_joint.keys()
    found = [package.joints_of(arm) & drives for arm in arms(package)]
    assert [len(joints) for joints in found] == [6] * len(found)
    assert len(set().union(*found)) == 6 * len(found)


def test_a_cell_has_a_group_of_all_arms(cell: Package) -> None:
    groups = [group.get("name") for group in cell.srdf.findall("group")]
    assert groups == [
        *("left_manipulator", "left_gripper"),
        *("right_manipulator", "right_gripper"),
        *("third_manipulator", "arms"),
    ]
    alone = [cell.links_of(arm) for arm in arms(cell)]
    assert cell.links_of("arms") == set().union(*alone)
    homes = cell.srdf.findall("group_state[@name='home'][@group='arms']/joint")
    assert len(homes) == 18
    assert "demo_gazebo.launch" not in {path.name for path in cell.files}
    assert "tool0_gazebo" not in cell.text("package.xml")


def test_the_end_effector_is_what_moveit_accepts(package: Package) -> None:
    """Its parent is in the arm's group, and no link is in both groups."""
    found = package.srdf.findall("end_effector")
    robots = package.description.robots
    assert len(found) == sum(robot.gripper is not None for robot in robots)
    for element in found:
        arm = package.links_of(str(element.get("parent_group")))
        hand = package.links_of(str(element.get("group")))
        assert element.get("parent_link") in arm
        assert not arm & hand
        assert len(package.joints_of(str(element.get("group")))) > 0


def test_the_states_are_the_named_poses_within_the_limits(package: Package) -> None:
    poses = named_poses(package.description)
    found: dict[str, dict[str, float]] = {}
    for state in package.srdf.findall("group_state"):
        group, name = str(state.get("group")), str(state.get("name"))
        values = {
            str(j.get("name")): float(str(j.get("value"))) for j in state.iter("joint")
        }
        driven = package.model.transmission_by_joint.keys()
        assert values.keys() == package.joints_of(group) & driven
        for joint, value in values.items():
            limits = package.model.joint(joint).limits
            assert limits.lower <= value <= limits.upper
        found.setdefault(name, {}).update(values)
        assert all(poses[name][joint] == value for joint, value in values.items())
    assert found == poses


def test_joints_that_nothing_drives_are_passive(package: Package) -> None:
    passive = {joint.get("name") for joint in package.srdf.findall("passive_joint")}
    movable = {joint.name for joint in package.model.movable_joints}
    assert passive == movable - package.model.transmission_by_joint.keys()


def test_each_disabled_pair_is_named_once(package: Package) -> None:
    pairs = [
        frozenset((element.get("link1"), element.get("link2")))
        for element in package.srdf.findall("disable_collisions")
    ]
    assert len(set(pairs)) == len(pairs)
    assert all(len(pair) == 2 for pair in pairs)


def test_the_ur5_agrees_with_the_published_package(ur5: Package) -> None:
    """Facts of ur5_moveit_config, https://github.com/ros-industrial/universal_robot
    (noetic-devel): config/ur5.srdf."""
    group = ur5.srdf.find("group[@name='manipulator']/chain")
    assert group is not None
    assert group.attrib == {"base_link": "base_link", "tip_link": "tool0"}
    states = {element.get("name") for element in ur5.srdf.findall("group_state")}
    assert {"home", "up"} <= states
    reasons = {
        (element.get("link1"), element.get("link2")): element.get("reason")
        for element in ur5.srdf.findall("disable_collisions")
    }
    for pair in (
        ("base_link_inertia", "shoulder_link"),
        ("forearm_link", "upper_arm_link"),
        ("forearm_link", "wrist_1_link"),
        ("shoulder_link", "upper_arm_link"),
        ("wrist_1_link", "wrist_2_link"),
        ("wrist_2_link", "wrist_3_link"),
    ):
        assert reasons[pair] == "Adjacent"
    for pair in (
        ("base_link_inertia", "upper_arm_link"),
        ("wrist_1_link", "wrist_3_link"),
    ):
        assert reasons[pair] == "Never"


def test_every_driven_joint_has_limits(package: Package) -> None:
    limits = package.config("joint_limits")["joint_limits"]
    model = package.model
    assert limits.keys() == model.transmission_by_joint.keys()
    for name, values in limits.items():
        joint = package.description.model.joint(name)
        assert values["has_velocity_limits"] is True
        assert values["has_acceleration_limits"] is True
        assert values["max_velocity"] == joint.max_velocity
        assert 0 < values["max_acceleration"] <= joint.max_velocity / 0.4 + 1e-6


def test_solvers_and_planners_are_of_groups(package: Package) -> None:
    groups = {str(group.get("name")) for group in package.srdf.findall("group")}
    assert [*package.config("kinematics")] == arms(package)
    ompl = package.config("ompl_planning")
    planners = ompl.pop("planner_configs")
    assert ompl.keys() == groups
    for group, settings in ompl.items():
        assert set(settings["planner_configs"]) == planners.keys()
        assert settings["default_planner_config"] in planners
        joints = settings["projection_evaluator"].removeprefix("joints(")[:-1]
        assert set(joints.split(",")) <= package.joints_of(group)


def controller_lists(package: Package) -> Iterator[tuple[str, dict[str, Any]]]:
    for file in (
        "simple_moveit_controllers",
        "simple_moveit_gripper_action_controllers",
    ):
        for controller in package.config(file)["controller_list"]:
            yield file, controller


def test_every_controller_is_one_of_the_robots(package: Package) -> None:
    """Its type fits its action, and together they have all driven joints, once."""
    for action in (False, True):
        file = "simple_moveit_gripper_action_controllers"
        ours = yaml.safe_load(
            controllers_yaml(package.description, gripper_action=action)
        )
        found = [c for f, c in controller_lists(package) if (f == file) is action]
        for controller in found:
            kind = ours[controller["name"]]["type"].partition("/")[2]
            assert (kind, controller["type"], controller["action_ns"]) in {
                (
                    "JointTrajectoryController",
                    "FollowJointTrajectory",
                    "follow_joint_trajectory",
                ),
                ("GripperActionController", "GripperCommand", "gripper_cmd"),
            }
        joints = list(itertools.chain(*(c["joints"] for c in found)))
        assert sorted(joints) == sorted(package.model.transmission_by_joint)


def test_fake_controllers_have_the_groups_joints(package: Package) -> None:
    fake = package.config("fake_controllers")
    for controller in fake["controller_list"]:
        group = controller["name"].removeprefix("fake_").removesuffix("_controller")
        driven = package.model.transmission_by_joint.keys()
        assert set(controller["joints"]) == package.joints_of(group) & driven
    states = {
        (state.get("group"), state.get("name"))
        for state in package.srdf.findall("group_state")
    }
    assert {(each["group"], each["pose"]) for each in fake["initial"]} <= states


def test_no_word_of_the_template_is_left(package: Package) -> None:
    for path, data in package.files.items():
        assert b"@robot@" not in data, path
        assert b"@group@" not in data, path


def test_your_own_file_names_no_arms() -> None:
    with pytest.raises(DescriptionError, match="which of its links are an arm"):
        moveit_package(
            load_robot(OWN), disabled={}, controllers={}, action_controllers={}
        )
