"""The robot's URDF for Gazebo: mimic constraints, stops, meshes and colours."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tool0.description.bodies import MovingBody, moving_bodies
from tool0.description.forward_kinematics import link_poses
from tool0.description.loading import assemble, load_robot
from tool0.description.model import JointType, Mimic, RobotModel
from tool0.description.urdf import read_model
from tool0.description.xml_source import parse_text
from tool0.engines.gazebo.connection import pack_pose
from tool0.engines.gazebo.robot_urdf import (
    STOP_SLACK,
    MimicConstraint,
    gazebo_urdf,
    mimic_constraints,
)
from tool0.engines.mujoco.model import quat_wxyz as quat_by_mujoco
from tool0.errors import ModelError

TWO_ROBOTS = Path("tests/data/description/two_robots.urdf.xacro")
WHEEL = """\
<robot name="cart">
  <link name="world"/>
  <link name="wheel">
    <inertial>
      <mass value="1"/>
      <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
  <joint name="axle" type="continuous">
    <parent link="world"/>
    <child link="wheel"/>
    <limit effort="1" velocity="2"/>
  </joint>
  <transmission name="drive">
    <type>transmission_interface/SimpleTransmission</type>
    <joint name="axle">
      <hardwareInterface>hardware_interface/EffortJointInterface</hardwareInterface>
    </joint>
    <actuator name="motor">
      <mechanicalReduction>10</mechanicalReduction>
      <rotorInertia>1e-4</rotorInertia>
    </actuator>
  </transmission>
</robot>
"""


def held(
    model: RobotModel,
) -> tuple[tuple[MovingBody, ...], tuple[MimicConstraint, ...]]:
    bodies = moving_bodies(model)
    return bodies, mimic_constraints(model, bodies)


def urdf_of(path: Path | None = None, **options: str) -> ET.Element:
    description = load_robot(path) if path else assemble(**options)
    model = description.model
    return ET.fromstring(gazebo_urdf(description.urdf, model, *held(model)))


def gearboxes(robot: ET.Element) -> dict[str, tuple[str, str, float]]:
    return {
        joint.findtext("child", ""): (
            joint.findtext("parent", ""),
            joint.findtext("gearbox_reference_body", ""),
            float(joint.findtext("gearbox_ratio", "nan")),
        )
        for joint in robot.iterfind("gazebo/joint[@type='gearbox']")
    }


OF_THE_2F85 = {
    "left_inner_knuckle": ("left_outer_knuckle", "wrist_3_link", -1.0),
    "left_inner_finger": ("wrist_3_link", "left_outer_knuckle", -1.0),
    "right_inner_knuckle": ("right_outer_knuckle", "wrist_3_link", -1.0),
    "right_inner_finger": ("wrist_3_link", "right_outer_knuckle", -1.0),
}


def test_the_xacro_s_gearboxes_stay_where_they_are_exact() -> None:
    assert gearboxes(urdf_of()) == OF_THE_2F85


@pytest.mark.slow
def test_gearboxes_are_made_where_the_urdf_brings_none() -> None:
    made = gearboxes(urdf_of(TWO_ROBOTS))
    assert made == {
        f"{side}_{child}": (f"{side}_{parent}", f"{side}_{reference}", ratio)
        for side in ("left", "right")
        for child, (parent, reference, ratio) in OF_THE_2F85.items()
    }


def test_fingers_that_turn_opposite_ways_mesh_by_teeth() -> None:
    model = assemble().model
    bodies, all_held = held(model)
    (gear,) = (c for c in all_held if not c.is_gearbox)
    assert bodies[gear.joint].joint.name == "right_finger_joint"
    assert bodies[gear.other].joint.name == "finger_joint"
    assert gear.multiplier == 1.0


def test_a_mimic_joint_is_held_to_its_neighbour_and_not_to_a_far_master() -> None:
    bodies, all_held = held(assemble().model)
    names = [body.joint.name for body in bodies]
    by_name = {names[c.joint]: c for c in all_held}
    follower = by_name["right_inner_finger_joint"]
    assert names[follower.other] == "right_finger_joint"
    assert follower.multiplier == -1.0


def changed(name: str, **changes: object) -> RobotModel:
    """Return the 2F-85's model with one joint changed."""
    model = assemble().model
    joints = tuple(
        replace(joint, **changes)  # type: ignore[arg-type]
        if joint.name == name
        else joint
        for joint in model.joints
    )
    return replace(model, joints=joints)


@pytest.mark.parametrize(
    "changes",
    [
        {"type": JointType.PRISMATIC},
        {"axis": (0.0, 1.0, 0.0)},
        {"mimic": Mimic(joint="finger_joint", multiplier=1.0, offset=0.1)},
    ],
)
def test_what_no_gear_can_hold_is_refused_by_name(changes: dict[str, object]) -> None:
    with pytest.raises(ModelError) as error:
        held(changed("right_finger_joint", **changes))
    assert "'right_finger_joint'" in str(error.value)


def test_the_stops_of_mimic_joints_alone_are_set_back() -> None:
    model = assemble().model
    mimics = {joint.name for joint in model.movable_joints if joint.mimic}
    assert len(mimics) == 5
    seen = set()
    for joint in urdf_of().iterfind("joint"):
        limit, name = joint.find("limit"), joint.get("name", "")
        if limit is not None:
            own = model.joint(name)
            back = STOP_SLACK if name in mimics else 0.0
            stops = float(limit.get("lower", "")), float(limit.get("upper", ""))
            assert stops == pytest.approx(
                (own.limits.lower - back, own.limits.upper + back), abs=1e-12
            )
            seen.add(name)
    assert seen == {joint.name for joint in model.movable_joints}


def test_a_joint_without_stops_gets_none(tmp_path: Path) -> None:
    path = tmp_path / "wheel.urdf"
    path.write_text(WHEEL)
    model = load_robot(path).model
    assert model.transmissions[0].armature > 0.0
    (limit,) = urdf_of(path).iter("limit")
    assert limit.attrib == {"effort": "1", "velocity": "2"}


def test_a_robot_without_a_world_is_fixed_to_it(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text("<robot name='arm'><link name='foot'/></robot>")
    (joint,) = urdf_of(path).iterfind("joint")
    assert joint.get("type") == "fixed"
    assert [element.get("link") for element in joint] == ["world", "foot"]


def test_meshes_are_named_by_absolute_path() -> None:
    meshes = [mesh.get("filename", "") for mesh in urdf_of().iter("mesh")]
    assert meshes
    assert all(name.startswith("file:///") for name in meshes)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
def test_bodies_are_sent_where_the_kinematics_say(seed: int) -> None:
    model = load_robot(TWO_ROBOTS).model
    rng = np.random.default_rng(seed)
    position = rng.uniform(-3.0, 3.0, len(model.movable_joints)).tolist()
    names = [joint.name for joint in model.movable_joints]
    poses = link_poses(model, dict(zip(names, position, strict=True)))
    for joint in model.movable_joints:
        pose = poses[joint.child].matrix
        sent = np.frombuffer(pack_pose(pose))
        quat = quat_by_mujoco(pose)
        np.testing.assert_allclose(sent[:3], pose[:3, 3])
        np.testing.assert_allclose(abs(sent[3:] @ quat), 1.0, atol=1e-12)


BOX = "<visual><geometry><box size='1 1 1'/></geometry>{}</visual>"
PAINTED = f"""\
<robot name="r">
  <material name="red"><color rgba="1 0 0 0.5"/></material>
  <link name="a">
    {BOX.format("")}
    {BOX.format("<material name='red'/>")}
  </link>
</robot>
"""


def test_every_shape_keeps_its_place_and_gets_its_color() -> None:
    robot = urdf_of()
    parents = {
        joint.find("child").get("link"): joint.find("parent").get("link")  # type: ignore[union-attr]
        for joint in robot.iterfind("joint[@type='fixed']")
    }
    links = {link.get("name"): link for link in robot.iterfind("link")}
    for link in assemble().model.links:
        for number, visual in enumerate(link.visuals):
            own = f"tool0_paint_{number}_{link.name}"
            assert parents[own] == link.name
            (shape,) = links[own]
            assert shape.tag == "visual"
            diffuse = robot.findtext(
                f"gazebo[@reference='{own}']/visual/material/diffuse", ""
            )
            assert tuple(map(float, diffuse.split())) == visual.rgba
        assert links[link.name].find("visual") is None


def test_what_has_no_color_or_its_own_is_left_alone(tmp_path: Path) -> None:
    file = tmp_path / "robot.urdf"
    file.write_text(PAINTED)
    robot = urdf_of(file)
    (left,) = robot.findall("link[@name='a']/visual")
    assert left.find("material") is None
    extension = robot.find("gazebo[@reference='tool0_paint_1_a']/visual")
    assert extension is not None
    assert extension.findtext("transparency") == "0.5"


def test_collada_brings_its_own_colors(tmp_path: Path) -> None:
    shape, file = tmp_path / "shape.dae", tmp_path / "robot.urdf"
    shape.touch()
    mesh = f"<mesh filename='{shape}'/>"
    file.write_text(PAINTED.replace("<box size='1 1 1'/>", mesh))
    robot = urdf_of(file)
    assert len(robot.findall("link[@name='a']/visual")) == 2
    assert robot.findall("gazebo") == []


def test_controller_managers_of_ros2_are_left_out() -> None:
    plugin = '<plugin name="p" filename="{}"/>'
    names = ("gz_ros2_control-system", "libgazebo_ros2_control.so", "libcamera.so")
    extensions = "".join(map(plugin.format, names))
    text = WHEEL.replace("</robot>", f"<gazebo>{extensions}</gazebo></robot>")
    model = read_model(parse_text(text))
    robot = ET.fromstring(gazebo_urdf(text, model, *held(model)))
    assert [item.get("filename") for item in robot.iter("plugin")] == ["libcamera.so"]
