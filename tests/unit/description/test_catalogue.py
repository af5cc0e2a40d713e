import math
import re
import struct
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest
import yaml

from tool0.description.catalogue import arms, grippers
from tool0.description.config import DescriptionConfig
from tool0.description.forward_kinematics import link_pose
from tool0.description.loading import (
    assemble,
    load_description,
    load_robot,
    named_poses,
    part_names,
)
from tool0.description.model import Inertial, Interface, RobotModel, RotaryOpening
from tool0.description.shapes import Cylinder, Mesh
from tool0.description.urdf import read_model
from tool0.description.xml_source import parse_text
from tool0.errors import ConfigError, DescriptionError, LimitsError, ModelError

DATA = Path(__file__).parents[2] / "data"
GOLDEN = DATA / "golden"

# Link and joint names of ur_description (noetic-devel, a7a2c54) with jr-robotics'
# robotiq_2f_85_gripper_visualization (3aab694) on it.
ARM_LINKS = (
    "world base_link pedestal base_link_inertia base shoulder_link upper_arm_link "
    "forearm_link "
    "wrist_1_link wrist_2_link wrist_3_link flange tool0 robotiq_arg2f_base_link"
)
ARM_JOINTS = (
    "world_joint base_link-pedestal base_link-base_link_inertia "
    "base_link-base_fixed_joint "
    "shoulder_pan_joint shoulder_lift_joint elbow_joint wrist_1_joint wrist_2_joint "
    "wrist_3_joint wrist_3-flange flange-tool0 ur_robotiq_joint finger_joint "
    "right_finger_joint"
)
FINGER_LINKS = "outer_knuckle outer_finger inner_knuckle inner_finger inner_finger_pad"
FINGER_JOINTS = "outer_finger inner_knuckle inner_finger inner_finger_pad"
SIDES = ("left", "right")
LINKS = set(ARM_LINKS.split()) | {
    f"{side}_{name}" for side in SIDES for name in FINGER_LINKS.split()
}
JOINTS = set(ARM_JOINTS.split()) | {
    f"{side}_{name}_joint" for side in SIDES for name in FINGER_JOINTS.split()
}


@pytest.fixture(scope="module")
def model() -> RobotModel:
    return assemble().model


def names(model: RobotModel) -> set[str]:
    return {item.name for item in (*model.links, *model.joints)}


def inertials(model: RobotModel) -> dict[str, Inertial]:
    return {link.name: link.inertial for link in model.links if link.inertial}


def gripper_mass(model: RobotModel) -> float:
    marks = ("finger", "knuckle", "robotiq")
    return sum(
        inertial.mass
        for name, inertial in inertials(model).items()
        if any(mark in name for mark in marks)
    )


def test_names_are_those_of_the_original(model: RobotModel) -> None:
    assert {link.name for link in model.links} == LINKS
    assert {joint.name for joint in model.joints} == JOINTS


def test_the_gripper_is_the_real_one(model: RobotModel) -> None:
    (gripper,) = model.grippers
    finger = model.joint("finger_joint")
    assert gripper_mass(model) == pytest.approx(0.92086, abs=1e-5)
    assert gripper.opening(finger.limits.upper) == pytest.approx(0, abs=1e-5)
    # 150 mm/s where the lever is shortest, 235 N where it is longest
    assert finger.limits.velocity * gripper.lever(0.0) == pytest.approx(0.150, rel=0.01)
    closed = gripper.position(0.0)
    assert finger.limits.effort / gripper.lever(closed) == pytest.approx(235, rel=0.01)
    assert model.transmission_by_joint["finger_joint"].armature == pytest.approx(
        0.0122, rel=0.01
    )
    assert isinstance(gripper.law, RotaryOpening)
    assert gripper.law.pad_offset == pytest.approx(0.0054057553, abs=1e-10)
    pad = model.link("left_inner_finger_pad").surface
    assert pad is not None
    assert pad.mu1 == 1.0


@pytest.mark.parametrize(
    ("q", "gap_mm"),
    [(0.0, 86.01), (0.2, 67.43), (0.4, 46.59), (0.6, 24.32), (0.8, 1.51)],
)
def test_openings_follow_the_linkage(
    model: RobotModel, q: float, gap_mm: float
) -> None:
    (gripper,) = model.grippers
    assert gripper.opening(q) * 1e3 == pytest.approx(gap_mm, abs=0.005)


def test_opening_and_position_undo_each_other(model: RobotModel) -> None:
    (gripper,) = model.grippers
    for i in range(101):
        opening = gripper.max_opening * i / 100
        assert gripper.opening(gripper.position(opening)) == pytest.approx(
            opening, abs=1e-12
        )
    for opening in (-1e-9, 0.0851, math.nan):
        with pytest.raises(ModelError):
            gripper.position(opening)


def test_only_the_driven_finger_joint_can_meet_its_stop(model: RobotModel) -> None:
    finger = model.joint("finger_joint").limits
    for joint in model.joints:
        if joint.mimic is not None:
            assert joint.mimic.joint == "finger_joint"
            ends = [joint.mimic.multiplier * q for q in (finger.lower, finger.upper)]
            assert joint.limits.lower < min(ends)
            assert joint.limits.upper > max(ends)
    driven = set(model.transmission_by_joint)
    assert len(driven) == 7
    assert {j.name for j in model.movable_joints if j.mimic is None} == driven


def test_every_mass_is_possible(model: RobotModel) -> None:
    for inertial in inertials(model).values():
        low, middle, high = inertial.principal_moments
        assert low > 0
        assert low + middle >= high
        # gyration radii of parts of this size [m]
        assert math.sqrt(high / inertial.mass) < 0.2


def test_meshes_are_there_and_collisions_are_primitives(model: RobotModel) -> None:
    assert any(link.visuals for link in model.links)
    for link in model.links:
        assert not any(isinstance(c.geometry, Mesh) for c in link.collisions)


def test_urdf_to_model_to_urdf_is_a_fixed_point() -> None:
    for description in (assemble(), assemble(gripper=None, safety_limits=True)):
        assert read_model(parse_text(description.urdf)) == description.model
        assert "xacro" not in description.urdf


def test_a_prefix_reaches_every_name_but_world(model: RobotModel) -> None:
    prefixed = assemble(prefix="left_").model
    assert names(prefixed) == {
        name if name == "world" else f"left_{name}" for name in names(model)
    }
    items = [*prefixed.transmissions, *prefixed.grippers]
    assert all(item.name.startswith("left_") for item in items)


def test_two_robots_stand_in_one_scene() -> None:
    path = DATA / "description" / "two_robots.urdf.xacro"
    description = load_robot(path, {"distance": 2})
    model = description.model
    assert len(model.links) == 2 * len(LINKS - {"world", "pedestal"}) + 1
    assert [gripper.name for gripper in model.grippers] == [
        "left_gripper",
        "right_gripper",
    ]
    T_left_right = link_pose(model, {}, "right_base_link", relative_to="left_base_link")
    assert T_left_right.position == pytest.approx((0, -2, 0))
    assert named_poses(description) == part_names(description) == {}


def test_bare_arm_mounting_and_place_in_the_world() -> None:
    bare = assemble(gripper=None)
    assert bare.model.grippers == ()
    assert assemble(gripper="none").model == bare.model
    assert "open" not in named_poses(bare)
    assert "finger_joint" not in named_poses(bare)["home"]
    description = assemble(
        mount_xyz=(0, 0, 0.011),
        mount_rpy=(0, 0, 1.5),
        base_xyz=[1, 2, 3],
        tf_prefix="robot1",
    )
    assert description.tf_prefix == "robot1"
    model = description.model
    assert model.joint("ur_robotiq_joint").origin.xyz == (0, 0, 0.011)
    assert model.joint("ur_robotiq_joint").origin.rpy == (0, 0, 1.5)
    assert model.joint("world_joint").origin.xyz == (1, 2, 3)


@pytest.mark.parametrize(
    ("options", "spawn_z", "height"),
    [
        ({}, 0.1, 0.1),
        ({}, 0.7, 0.7),
        ({"base_xyz": (1.0, 2.0, 0.4)}, 0.1, 0.5),
        ({"base_xyz": (0.0, 0.0, -0.3), "base_rpy": (0.0, 0.0, 1.5)}, 0.5, 0.2),
        ({"pedestal_height": 0.25}, 0.1, 0.25),
        ({"prefix": "left_"}, 0.004, 0.004),
    ],
)
def test_the_pedestal_reaches_from_the_base_to_the_ground(
    options: dict[str, Any], spawn_z: float, height: float
) -> None:
    model = load_description(DescriptionConfig(**options), spawn_z=spawn_z).model
    prefix = options.get("prefix", "")
    assert model.parent_joint[prefix + "pedestal"].parent == prefix + "base_link"
    link = model.link(prefix + "pedestal")
    for shapes, gap in ((link.visuals, 0.0), (link.collisions, min(0.005, height / 2))):
        ends = [
            [shape.origin.xyz[2] + sign * shape.geometry.length / 2 for sign in (-1, 1)]
            for shape in shapes
            if isinstance(shape.geometry, Cylinder)
        ]
        assert len(ends) == len(shapes) == 2
        assert max(top for _, top in ends) == pytest.approx(0.0, abs=1e-12)
        assert [low for low, _ in ends] == pytest.approx([gap - height] * 2)


@pytest.mark.parametrize(
    ("options", "spawn_z"),
    [
        ({}, 0.0),
        ({"pedestal_height": 0}, 0.1),
        ({"base_rpy": (math.pi, 0.0, 0.0)}, 0.1),
        ({"args": {"base_rpy": "0 1.57 0"}}, 0.1),
        ({"base_xyz": (0.0, 0.0, -0.1)}, 0.1),
    ],
)
def test_there_is_no_pedestal_where_none_can_stand(
    options: dict[str, Any], spawn_z: float
) -> None:
    model = load_description(DescriptionConfig(**options), spawn_z=spawn_z).model
    assert "pedestal" not in model.link_by_name


@pytest.mark.parametrize("interface", list(Interface))
def test_the_interface_can_be_chosen(interface: Interface) -> None:
    model = assemble(transmission_hw_interface=interface.value).model
    assert {item.interfaces for item in model.transmissions} == {(interface,)}


def test_safety_limits_narrow_the_arm_by_their_margin(model: RobotModel) -> None:
    assert all(joint.safety is None for joint in model.joints)
    safe = assemble(safety_limits=True, safety_pos_margin=0.2, safety_k_position=30)
    elbow = safe.model.joint("elbow_joint")
    assert elbow.safety is not None
    assert elbow.safety.soft_upper_limit == pytest.approx(elbow.limits.upper - 0.2)
    assert elbow.safety.soft_lower_limit == pytest.approx(elbow.limits.lower + 0.2)
    assert elbow.safety.k_position == 30


def test_the_parameters_of_the_recordings_are_the_originals() -> None:
    model = assemble(
        physical_params=GOLDEN / "ur5_physical_parameters.yaml",
        gripper_params=GOLDEN / "2f85_physical_parameters.yaml",
        gripper_joint_limit_params=GOLDEN / "2f85_joint_limits.yaml",
    ).model
    found = inertials(model)
    assert gripper_mass(model) == pytest.approx(0.36385, abs=5e-6)
    upper_arm = found["upper_arm_link"]
    assert upper_arm.origin.xyz == (-0.2125, 0, 0.136)
    assert (upper_arm.mass, upper_arm.ixx) == (8.393, 0.133885782)
    assert found["base_link_inertia"].izz == 0.0072
    assert found["left_inner_finger"].iyz == 6.74715432769696e-07
    finger = model.joint("finger_joint")
    assert (finger.limits.velocity, finger.limits.effort) == (0.5, 1000)
    assert finger.damping == 0
    assert model.transmission_by_joint["finger_joint"].armature == 0
    assert model.link("left_inner_finger_pad").surface is None


def test_noetics_layout_of_masses_gives_noetics_inertias() -> None:
    layout = DATA / "description" / "ur5_noetic_physical_parameters.yaml"
    found = inertials(assemble(physical_params=layout).model)
    golden = inertials(
        assemble(physical_params=GOLDEN / "ur5_physical_parameters.yaml").model
    )
    for name, inertial in golden.items():
        for field in ("mass", "ixx", "iyy", "izz", "ixy", "ixz", "iyz"):
            value = getattr(inertial, field)
            assert getattr(found[name], field) == pytest.approx(value, rel=1e-6)
        assert found[name].origin.xyz == pytest.approx(inertial.origin.xyz, abs=1e-12)
        assert found[name].origin.rpy == pytest.approx(inertial.origin.rpy, abs=1e-9)


def cube(path: Path) -> None:
    """Write the smallest binary STL: one triangle."""
    path.write_bytes(bytes(80) + struct.pack("<I12fH", 1, *([0.0] * 12), 0))


def test_upstreams_layout_of_looks_places_its_meshes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "package.xml").write_text("<name>cube_description</name>")
    cube(tmp_path / "cube.stl")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    looks = DATA / "description" / "ur5_noetic_visual_parameters.yaml"
    model = assemble(visual_params=looks, gripper=None).model
    for link, z, rpy in (
        ("base_link_inertia", 0, (0, 0, math.pi)),
        ("upper_arm_link", 0.13585, (math.pi / 2, 0, -math.pi / 2)),
        ("forearm_link", 0.0165, (math.pi / 2, 0, -math.pi / 2)),
        ("wrist_1_link", -0.093, (math.pi / 2, 0, 0)),
        ("wrist_2_link", -0.093, (0, 0, 0)),
    ):
        (visual,) = model.link(link).visuals
        (collision,) = model.link(link).collisions
        assert visual.origin == collision.origin
        assert visual.origin.xyz == (0, 0, z)
        assert visual.origin.rpy == pytest.approx(rpy)
        assert visual.rgba == (0.7, 0.7, 0.7, 1)
        assert isinstance(collision.geometry, Mesh)
        assert collision.geometry.path == tmp_path / "cube.stl"


def test_upstream_meshes_change_the_looks_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, model: RobotModel
) -> None:
    arm = tmp_path / "ur_description"
    (arm / "config" / "ur5").mkdir(parents=True)
    (arm / "package.xml").write_text("<name>ur_description</name>")
    cube(arm / "cube.stl")
    looks = (DATA / "description" / "ur5_noetic_visual_parameters.yaml").read_text()
    (arm / "config" / "ur5" / "visual_parameters.yaml").write_text(
        looks.replace("cube_description", "ur_description")
    )
    package = "robotiq_2f_85_gripper_visualization"
    gripper = tmp_path / package
    meshes = gripper / "meshes" / "visual"
    meshes.mkdir(parents=True)
    (gripper / "package.xml").write_text(f"<name>{package}</name>")
    cube(meshes / "robotiq_arg2f_base_link.stl")
    for part in ("outer_knuckle", "outer_finger", "inner_knuckle", "inner_finger"):
        (meshes / f"robotiq_arg2f_85_{part}.dae").touch()
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    upstream = assemble(meshes="upstream").model
    for ours, theirs in zip(model.links, upstream.links, strict=True):
        assert ours.collisions == theirs.collisions
    used = {
        visual.geometry.uri
        for link in upstream.links
        for visual in link.visuals
        if isinstance(visual.geometry, Mesh)
    }
    assert len(used) == 6
    assert not any("tool0" in uri for uri in used)


def test_upstream_meshes_without_their_package_are_a_clear_error(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    with pytest.raises(DescriptionError) as error:
        assemble(meshes="upstream")
    assert "'ur_description'" in str(error.value)


@pytest.mark.parametrize(
    ("args", "names"),
    [
        ({"arm": "ur55"}, ["'ur55'", "'ur5'"]),
        ({"arm": "kuka"}, ["'kuka'", "ur5"]),
        ({"gripper": "2f140x"}, ["'2f140x'", "2f85"]),
        ({"prefix": "left arm"}, ["'left arm'"]),
        ({"meshes": "fancy"}, ["'fancy'", "tool0", "upstream"]),
        ({"gripper_model": "x"}, ["'x'", "linkage", "mimic"]),
        ({"gripper": None, "gripper_model": "linkage"}, ["gripper_model"]),
        ({"saftey_limits": True}, ["'saftey_limits'", "'safety_limits'"]),
        ({"kinematics_params": "no.yaml"}, ["no.yaml"]),
        ({"transmission_hw_interface": "hardware/interface/EffortJointInterface"},
         ["'hardware_interface/EffortJointInterface'"]),
        ({"mount_xyz": (0, 0)}, ["2 numbers"]),
        ({"base_xyz": (0, 0, math.nan)}, ["'nan'"]),
    ],
)  # fmt: skip
def test_wrong_options_are_refused(args: dict[str, object], names: list[str]) -> None:
    with pytest.raises(DescriptionError) as error:
        assemble(**args)  # type: ignore[arg-type]
    for name in names:
        assert name in str(error.value)


def test_the_fields_are_the_arguments_of_the_xacro_file() -> None:
    text = assemble().source.read_text()
    declared = re.findall(r'<xacro:arg name="(\w+)"', text)
    names = {item.name for item in fields(DescriptionConfig)}
    without_tool0 = {  # workspace.md
        *("gripper_damping", "gripper_knuckle_inertia", "ros2_control_plugin"),
    }
    own = {"robot", "cell", "robots", "namespaces", "args", "relax_inertia", "srdf"}
    assert names == {*declared, *own} - without_tool0


def test_args_override_fields_and_no_field_given_is_a_default() -> None:
    config = DescriptionConfig(prefix="a_", args={"prefix": "b_", "gripper": "none"})
    description = load_description(config)
    (robot,) = description.robots
    assert (robot.prefix, robot.gripper) == ("b_", None)
    assert load_description(DescriptionConfig()).model == assemble().model
    bare = load_description(DescriptionConfig(gripper=None))
    assert bare.model == assemble(gripper=None).model


@pytest.mark.parametrize(
    "given",
    [{"arm": "ur5"}, {"gripper": None}, {"prefix": ""}, {"safety_limits": True}],
    ids=str,
)
def test_fields_of_the_catalogue_are_refused_with_a_file_of_your_own(
    given: dict[str, object],
) -> None:
    with pytest.raises(ConfigError) as error:
        DescriptionConfig(robot="my.urdf", **given)  # type: ignore[arg-type]
    assert next(iter(given)) in str(error.value)


def edited(tmp_path: Path, source: Path, old: str, new: str) -> Path:
    text = source.read_text()
    assert old in text
    path = tmp_path / source.name
    path.write_text(text.replace(old, new))
    return path


def test_wrong_parameters_of_a_person_are_refused(tmp_path: Path) -> None:
    masses = GOLDEN / "ur5_physical_parameters.yaml"
    limits = GOLDEN / "2f85_joint_limits.yaml"
    light = edited(tmp_path, masses, "forearm_mass: 2.275", "forearm_mass: -1")
    with pytest.raises(ModelError) as mass:
        assemble(physical_params=light)
    assert "'forearm_link'" in str(mass.value)
    typo = edited(tmp_path, masses, "forearm_mass", "forarm_mass")
    with pytest.raises(DescriptionError) as key:
        assemble(physical_params=typo)
    assert "'forearm_mass'" in str(key.value)
    assert "'forarm_mass'" in str(key.value)
    empty = tmp_path / "empty.yaml"
    empty.write_text("# nothing yet")
    with pytest.raises(DescriptionError) as nothing:
        assemble(joint_limit_params=empty)
    assert "empty.yaml" in str(nothing.value)
    turned = edited(tmp_path, limits, "max_position: 0.8,", "max_position: -0.8,")
    with pytest.raises(LimitsError) as limits:
        assemble(gripper_joint_limit_params=turned)
    assert "'finger_joint'" in str(limits.value)


def test_paths_count_from_the_working_directory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    edited(tmp_path, GOLDEN / "2f85_joint_limits.yaml", "1000.0", "7.0")
    monkeypatch.chdir(tmp_path)
    model = assemble(gripper_joint_limit_params="2f85_joint_limits.yaml").model
    assert model.joint("finger_joint").limits.effort == 7


def test_a_joint_without_position_limits_turns_without_end(tmp_path: Path) -> None:
    bound = {"max_velocity": 3.0, "max_effort": 9.0}
    both = {"min_position": -1.0, "max_position": 1.0, **bound}
    keys = ("shoulder_pan", "shoulder_lift", "elbow_joint", "wrist_1", "wrist_2")
    limits = {
        **dict.fromkeys(keys, both),
        "wrist_3": {"has_position_limits": False, **bound},
    }
    path = tmp_path / "limits.yaml"
    path.write_text(yaml.safe_dump({"joint_limits": limits}))
    wrist = assemble(joint_limit_params=path).model.joint("wrist_3_joint")
    assert wrist.type.value == "continuous"
    assert wrist.limits.upper == math.inf
    assert wrist.limits.effort == 9


def test_a_persons_urdf_needs_no_xacro(tmp_path: Path) -> None:
    path = tmp_path / "r.urdf"
    path.write_text('<robot name="r"><link name="${a}"/></robot>')
    description = load_robot(path)
    assert description.model.root == "${a}"
    assert (description.robots, description.source) == ((), path)
    with pytest.raises(DescriptionError) as error:
        load_robot(path, {"k": "v"})
    assert str(path) in str(error.value)
    with pytest.raises(DescriptionError) as missing:
        load_robot(tmp_path / "no.urdf")
    assert "no.urdf" in str(missing.value)


@pytest.mark.parametrize("prefix", ["", "left_"])
def test_poses_place_driven_joints_within_their_limits(prefix: str) -> None:
    description = assemble(prefix=prefix)
    driven = set(description.model.transmission_by_joint)
    poses = named_poses(description)
    assert poses.keys() >= {"home", "ready", "up", "zero", "open", "half", "closed"}
    assert poses["home"].keys() == driven
    for pose in poses.values():
        for name, position in pose.items():
            assert name in driven
            assert description.model.joint(name).limits.clamp(position) == position


def test_gripper_poses_open_close_and_halve() -> None:
    description = assemble()
    (gripper,) = description.model.grippers
    opening = {
        name: gripper.opening(pose["finger_joint"])
        for name, pose in named_poses(description).items()
        if "finger_joint" in pose
    }
    assert opening["open"] >= gripper.max_opening
    assert opening["half"] == pytest.approx(gripper.max_opening / 2, abs=1e-6)
    assert opening["closed"] == pytest.approx(0, abs=1e-6)


ROBOTS = [
    *((arm, None, "mimic", "left_") for arm in arms()),
    *((arms()[0], gripper, "mimic", "") for gripper in grippers()),
    (arms()[0], grippers()[0], "linkage", "left_"),
]
"""Each arm and each gripper once: their parts have no name in common."""


@pytest.mark.slow
@pytest.mark.parametrize(("arm", "gripper", "gripper_model", "prefix"), ROBOTS)
def test_what_moves_or_is_seen_has_a_name_for_people(
    arm: str, gripper: str | None, gripper_model: str, prefix: str
) -> None:
    description = assemble(arm, gripper, prefix=prefix, gripper_model=gripper_model)
    model, names = description.model, part_names(description)
    seen = {link.name for link in model.links if link.visuals}
    assert names.keys() >= seen | {joint.name for joint in model.movable_joints}
    assert names.keys() <= model.link_by_name.keys() | model.joint_by_name.keys()
    for language in ("en", "zh"):
        called = [getattr(name, language) for name in names.values()]
        assert all(text.strip() for text in called)
        assert len(called) == len(set(called))


def test_the_arm_is_called_as_in_the_table_of_the_post() -> None:
    names = {part: name.zh for part, name in part_names(assemble()).items()}
    assert names["base_link"] == "底座"
    assert names["shoulder_pan_joint"] == "肩连杆与底座的关节"
    assert names["upper_arm_link"] == "上臂"
    assert names["wrist_3_joint"] == "腕关节3"
    assert names["tool0"].startswith("末端")


ROS2_PARTS = [("ur5", "2f85"), ("ur5e", "hande"), ("ur10e", "2f140"), ("ur3e", None)]


@pytest.mark.parametrize(("arm", "gripper"), ROS2_PARTS)
def test_ros2_control_describes_the_same_drives(arm: str, gripper: str | None) -> None:
    usual = assemble(arm, gripper, prefix="left_").model
    found = assemble(arm, gripper, prefix="left_", ros2_control=True)
    model = found.model
    assert "<transmission" not in found.urdf
    assert (model.links, model.joints) == (usual.links, usual.joints)
    drives, before = model.transmission_by_joint, usual.transmission_by_joint
    assert list(drives) == list(before)
    grips = {item.joint for item in model.grippers}
    for joint, drive in drives.items():
        assert drive.armature == before[joint].armature
        assert drive.gravity_compensation == before[joint].gravity_compensation
        several = (Interface.POSITION, Interface.VELOCITY, Interface.EFFORT)
        assert drive.interfaces == (several[:1] if joint in grips else several)
    assert model.wrench_sensors == {"left_tcp_fts_sensor": "left_tool0"}
    assert model.initial_positions["left_shoulder_lift_joint"] == -1.57


def test_every_moving_joint_has_a_state_in_ros2_control() -> None:
    for kind in ("mimic", "linkage"):
        model = assemble(ros2_control=True, gripper_model=kind).model
        states = {name for item in model.hardware for name in item.state_interfaces}
        joints = {joint.name for joint in model.movable_joints}
        assert {f"{joint}/position" for joint in joints} <= states
        commands = {n for item in model.hardware for n in item.command_interfaces}
        assert "finger_joint/set_gripper_max_velocity" in commands
        assert "reactivate_gripper/reactivate_gripper_cmd" in commands


def test_a_cell_gives_ros2_control_to_each_robot() -> None:
    robots = ["left=ur5+2f85@0,0.6,0", "right=ur10e@0,-0.6,0"]
    config = DescriptionConfig(robots=robots, ros2_control=True)
    model = load_description(config).model
    names = [component.name for component in model.hardware]
    assert names == ["left_ur5", "left_2f85", "right_ur10e"]
    assert set(model.wrench_sensors.values()) == {"left_tool0", "right_tool0"}


def test_ros2_control_offers_its_own_interfaces() -> None:
    effort = Interface.EFFORT.value
    with pytest.raises(ConfigError, match="not with ros2_control"):
        DescriptionConfig(ros2_control=True, transmission_hw_interface=effort)
