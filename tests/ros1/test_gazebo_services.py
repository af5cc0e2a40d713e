"""The services and topics of gazebo_ros, called as its own tools call them."""

from __future__ import annotations

import importlib
import math
from collections.abc import Iterator
from types import ModuleType
from typing import Any

import pytest
from ros import Bringup, Ros
from ros_client import Message, call, listening, publishing
from waits import until

from tool0.description.forward_kinematics import link_poses
from tool0.description.loading import assemble

ENGINES = ("mujoco", "gazebo")
EDGE = 0.05  # [m]
CUBE = f"""<?xml version="1.0"?>
<robot name="cube">
  <link name="cube_link">
    <inertial>
      <origin xyz="0 0 {EDGE / 2}"/>
      <mass value="0.1"/>
      <inertia ixx="4e-5" iyy="4e-5" izz="4e-5"/>
    </inertial>
    <collision>
      <origin xyz="0 0 {EDGE / 2}"/>
      <geometry><box size="{EDGE} {EDGE} {EDGE}"/></geometry>
    </collision>
  </link>
</robot>
"""
"""Its frame lies in the middle of its lowest face."""
TABLE = """<sdf version="1.6"><model name="table"><static>true</static>
<link name="top"><collision name="slab"><pose>0 0 0.2 0 0 0</pose>
<geometry><box><size>0.2 0.2 0.4</size></box></geometry></collision></link>
</model></sdf>
"""
BRACKET = """<sdf version="1.6"><model name="bracket"><static>true</static>
<link name="body"><collision name="post"><pose>0 0.3 0.2 0 0 0</pose>
<geometry><box><size>0.1 0.1 0.4</size></box></geometry></collision>
<collision name="slab"><pose>0 0 0.39 0 0 0</pose>
<geometry><box><size>0.2 0.6 0.02</size></box></geometry></collision></link>
</model></sdf>
"""
CUP = """<robot name="cup">
  <link name="foot">
    <inertial><mass value="0.1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>
    <collision>
      <origin xyz="0 0 0.005"/><geometry><box size="0.08 0.08 0.01"/></geometry>
    </collision>
  </link>
  <link name="wall">
    <inertial><mass value="0.1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>
    <collision>
      <origin xyz="0.035 0 0.05"/><geometry><box size="0.01 0.08 0.08"/></geometry>
    </collision>
    <collision>
      <origin xyz="-0.035 0 0.05"/><geometry><box size="0.01 0.08 0.08"/></geometry>
    </collision>
  </link>
  <joint name="glue" type="fixed"><parent link="foot"/><child link="wall"/></joint>
</robot>
"""
TYPES = {
    "pause_physics": "std_srvs/Empty",
    "unpause_physics": "std_srvs/Empty",
    "reset_simulation": "std_srvs/Empty",
    "reset_world": "std_srvs/Empty",
    "get_world_properties": "gazebo_msgs/GetWorldProperties",
    "get_physics_properties": "gazebo_msgs/GetPhysicsProperties",
    "get_model_properties": "gazebo_msgs/GetModelProperties",
    "get_model_state": "gazebo_msgs/GetModelState",
    "set_model_state": "gazebo_msgs/SetModelState",
    "get_link_state": "gazebo_msgs/GetLinkState",
    "get_joint_properties": "gazebo_msgs/GetJointProperties",
    "set_model_configuration": "gazebo_msgs/SetModelConfiguration",
    "spawn_urdf_model": "gazebo_msgs/SpawnModel",
    "spawn_sdf_model": "gazebo_msgs/SpawnModel",
    "delete_model": "gazebo_msgs/DeleteModel",
    "apply_body_wrench": "gazebo_msgs/ApplyBodyWrench",
    "clear_body_wrenches": "gazebo_msgs/BodyRequest",
}


@pytest.fixture
def gazebo(rospy: ModuleType, bringup: Bringup) -> Iterator[Gazebo]:
    gazebo = Gazebo()
    yield gazebo
    gazebo.call_empty("unpause_physics")
    for name in gazebo.expect("get_world_properties").model_names:
        if name not in ("ground_plane", "robot"):
            gazebo.expect("delete_model", model_name=name)
    gazebo.call_empty("reset_world")


class Gazebo:
    """The services, by their names."""

    def call_empty(self, name: str) -> None:
        from std_srvs.srv import Empty

        call(f"/gazebo/{name}", Empty)

    def call(self, name: str, **request: object) -> Message:
        from gazebo_msgs import srv

        kind = getattr(srv, TYPES[name].partition("/")[2])
        return call(f"/gazebo/{name}", kind, **request)

    def expect(self, name: str, **request: object) -> Message:
        answer = self.call(name, **request)
        assert answer.success, answer.status_message
        return answer

    def spawn(self, name: str, xml: str, pose: Message, frame: str = "") -> Message:
        kind = "urdf" if "<robot" in xml else "sdf"
        return self.call(
            f"spawn_{kind}_model",
            model_name=name,
            model_xml=xml,
            initial_pose=pose,
            reference_frame=frame,
        )

    def push(self, body: str, frame: str = "", at: Any = None, **wrench: Any) -> Any:
        """Apply a wrench without an end."""
        from geometry_msgs.msg import Point, Wrench
        from rospy import Duration

        return self.call(
            "apply_body_wrench",
            body_name=body,
            reference_frame=frame,
            reference_point=at or Point(),
            wrench=Wrench(**wrench),
            duration=Duration(-1),
        )

    def twist(self, name: str) -> Message:
        return self.expect("get_model_state", model_name=name).twist

    def place(self, name: str, pose: Message, frame: str = "", **more: Any) -> Message:
        from gazebo_msgs.msg import ModelState

        state = ModelState(model_name=name, pose=pose, reference_frame=frame, **more)
        return self.call("set_model_state", model_state=state)

    def position(self, name: str, frame: str = "") -> tuple[float, float, float]:
        state = self.expect(
            "get_model_state", model_name=name, relative_entity_name=frame
        )
        return xyz(state.pose.position)

    @property
    def time(self) -> float:
        seconds: float = self.expect("get_world_properties").sim_time
        return seconds


def at(x: float, y: float, z: float) -> Message:
    """Return a pose that is not turned, its quaternion as rosservice leaves it."""
    from geometry_msgs.msg import Point, Pose

    return Pose(position=Point(x, y, z))


def xyz(point: Message) -> tuple[float, float, float]:
    return point.x, point.y, point.z


def has(name: str) -> Any:
    return lambda states: name in states.name


def test_every_service_has_its_type(ros: Ros, gazebo: Gazebo) -> None:
    tool = importlib.import_module("rosservice")
    found = {name: tool.get_service_type(f"/gazebo/{name}") for name in TYPES}
    assert found == TYPES


def test_a_model_is_spawned_falls_and_is_deleted(
    gazebo: Gazebo, rospy: ModuleType
) -> None:
    from gazebo_msgs.msg import LinkStates, ModelStates

    rospy.wait_for_service("/gazebo/spawn_urdf_model", timeout=60.0)
    with listening("/gazebo/model_states", ModelStates) as models:
        assert models.messages[0].name == ["ground_plane", "robot"]
        table = gazebo.spawn("table", TABLE, at(0.5, -0.4, 0.0))
        assert table.status_message == "SpawnModel: Successfully spawned entity"
        assert gazebo.spawn("cube", CUBE, at(0.5, -0.4, 0.5)).success
        seen = models.wait_for(has("cube"))
        assert seen.name == ["ground_plane", "robot", "table", "cube"]
        assert xyz(seen.pose[1].position) == pytest.approx((0.0, 0.0, 0.1))
        assert xyz(seen.pose[2].position) == pytest.approx((0.5, -0.4, 0.0))
        fallen = models.wait_for(
            lambda states: (
                has("cube")(states) and abs(states.pose[3].position.z - 0.4) < 1e-3
            )
        )
        assert xyz(fallen.pose[3].position)[:2] == pytest.approx((0.5, -0.4), abs=1e-3)
        with listening("/gazebo/link_states", LinkStates) as links:
            names = links.messages[0].name
        assert names[:2] == ["ground_plane::link", "robot::base_link"]
        assert names[-2:] == ["table::top", "cube::cube_link"]
        gone = gazebo.expect("delete_model", model_name="cube")
        assert gone.status_message == "DeleteModel: successfully deleted model"
        models.wait_for(lambda s: not has("cube")(s), since=len(models.messages))
    again = gazebo.call("delete_model", model_name="cube")
    assert not again.success
    assert again.status_message.startswith("DeleteModel: ")


def test_several_shapes_are_one_body(gazebo: Gazebo, rospy: ModuleType) -> None:
    """A cup of URDF, on its foot; a bracket of SDF, which carries it."""
    assert gazebo.spawn("bracket", BRACKET, at(0.5, -0.4, 0.0)).success
    assert gazebo.spawn("cup", CUP, at(0.5, -0.4, 0.45)).success
    until(
        lambda: gazebo.position("cup") == pytest.approx((0.5, -0.4, 0.4), abs=1e-3),
        "the cup on the bracket's upper shape",
    )
    bracket = gazebo.expect("get_model_properties", model_name="bracket")
    assert (bracket.body_names, bracket.geom_names) == (["body"], ["post", "slab"])
    cup = gazebo.expect("get_model_properties", model_name="cup")
    assert cup.body_names == ["foot"]
    assert cup.geom_names == ["foot_collision", "wall_collision", "wall_collision_1"]


def test_a_name_is_given_once(gazebo: Gazebo) -> None:
    assert gazebo.spawn("cube", CUBE, at(0.6, 0.0, 0.1)).success
    for name in ("cube", "robot", "ground_plane"):
        answer = gazebo.spawn(name, CUBE, at(0.6, 0.3, 0.1))
        assert not answer.success
        assert name in answer.status_message


def test_poses_refer_to_links_and_models(gazebo: Gazebo) -> None:
    gazebo.call_empty("pause_physics")
    flange = gazebo.expect("get_link_state", link_name="robot::tool0").link_state
    assert gazebo.spawn("cube", CUBE, at(0.0, 0.0, 0.3), "robot::tool0").success
    assert gazebo.position("cube", "tool0") == pytest.approx((0, 0, 0.3), abs=1e-6)
    # tool0 looks down in this pose.
    x, y, z = xyz(flange.pose.position)
    assert gazebo.position("cube") == pytest.approx((x, y, z - 0.3), abs=0.01)
    assert gazebo.spawn("other", TABLE, at(0.0, 0.0, 1.0), "cube").success
    assert gazebo.position("other", "cube") == pytest.approx((0, 0, 1), abs=1e-6)
    assert gazebo.position("robot", "robot::base_link") == pytest.approx((0, 0, 0))
    lost = gazebo.call(
        "get_model_state", model_name="cube", relative_entity_name="nothing"
    )
    assert not lost.success
    assert "'nothing'" in lost.status_message


def test_set_model_state_sets_pose_and_velocity(gazebo: Gazebo) -> None:
    from geometry_msgs.msg import Twist, Vector3

    gazebo.spawn("cube", CUBE, at(0.6, -0.5, 0.0))
    gazebo.call_empty("pause_physics")
    twist = Twist(linear=Vector3(0.1, 0.2, 0.3), angular=Vector3(1.0, 2.0, 3.0))
    assert gazebo.place("cube", at(0.0, 0.0, 1.0), "robot", twist=twist).success
    state = gazebo.expect("get_model_state", model_name="cube")
    assert state.status_message == "GetModelState: got properties"
    assert xyz(state.pose.position) == pytest.approx((0.0, 0.0, 1.1))
    assert xyz(state.twist.linear) == pytest.approx((0.1, 0.2, 0.3))
    assert xyz(state.twist.angular) == pytest.approx((1.0, 2.0, 3.0))
    assert not gazebo.place("robot", at(1.0, 0.0, 0.0)).success


def test_the_topic_set_model_state_does_the_same(gazebo: Gazebo) -> None:
    from gazebo_msgs.msg import ModelState

    gazebo.spawn("table", TABLE, at(0.6, -0.5, 0.0))
    with publishing("/gazebo/set_model_state", ModelState) as publish:
        publish(ModelState(model_name="table", pose=at(0.7, 0.2, 0.0)))
        until(
            lambda: gazebo.position("table") == pytest.approx((0.7, 0.2, 0.0)),
            "the table's new place",
        )


def test_links_are_where_the_joints_put_them(gazebo: Gazebo) -> None:
    model = assemble().model
    gazebo.call_empty("pause_physics")
    position = {}
    for joint in model.movable_joints:
        answer = gazebo.expect("get_joint_properties", joint_name=joint.name)
        (position[joint.name],) = answer.position
        assert answer.type == answer.REVOLUTE
        assert len(answer.rate) == len(answer.damping) == 1
    poses = link_poses(model, position)
    for link in ("base_link", "wrist_3_link", "tool0", "left_inner_finger_pad"):
        state = gazebo.expect("get_link_state", link_name=f"robot::{link}").link_state
        x, y, z = poses[link].position
        assert xyz(state.pose.position) == pytest.approx((x, y, z + 0.1), abs=1e-6)
        turn = state.pose.orientation
        assert (turn.w, turn.x, turn.y, turn.z) == pytest.approx(
            poses[link].quat_wxyz, abs=1e-6
        )
    wrist = gazebo.expect("get_joint_properties", joint_name="robot::wrist_3_joint")
    assert wrist.position[0] == position["wrist_3_joint"]


def test_a_model_has_the_links_that_gazebo_keeps(gazebo: Gazebo) -> None:
    robot = gazebo.expect("get_model_properties", model_name="robot")
    assert robot.canonical_body_name == "base_link"
    assert "wrist_3_link" in robot.body_names
    assert "tool0" not in robot.body_names  # is fixed: Gazebo lumps it
    assert "elbow_joint" in robot.joint_names
    assert not robot.is_static
    gazebo.spawn("table", TABLE, at(0.6, -0.5, 0.0))
    table = gazebo.expect("get_model_properties", model_name="table")
    assert (table.body_names, table.geom_names) == (["top"], ["slab"])
    assert table.is_static
    assert gazebo.expect("get_model_properties", model_name="ur5_robot").body_names


def test_physics_is_paused_and_unpaused(gazebo: Gazebo) -> None:
    gazebo.call_empty("pause_physics")
    physics = gazebo.expect("get_physics_properties")
    assert physics.pause
    assert physics.time_step == 0.001
    assert physics.gravity.z in (-9.81, -9.8)  # MuJoCo's, Gazebo's
    stopped = gazebo.time
    gazebo.place("robot", at(0.0, 0.0, 0.0))  # whatever is asked
    assert gazebo.time == stopped
    gazebo.call_empty("unpause_physics")
    assert not gazebo.expect("get_physics_properties").pause
    until(lambda: gazebo.time > stopped + 0.1, "time that goes on")


def test_reset_world_keeps_time_and_reset_simulation_does_not(gazebo: Gazebo) -> None:
    gazebo.spawn("table", TABLE, at(0.6, -0.5, 0.0))
    gazebo.place("table", at(0.6, 0.5, 0.0))
    until(lambda: gazebo.time > 1.0, "a second of simulated time")
    gazebo.call_empty("pause_physics")
    before = gazebo.time
    gazebo.call_empty("reset_world")
    assert gazebo.position("table") == pytest.approx((0.6, -0.5, 0.0))
    assert gazebo.time == before
    gazebo.call_empty("reset_simulation")
    assert gazebo.time == 0.0


def test_set_model_configuration_moves_joints_alone(gazebo: Gazebo) -> None:
    gazebo.spawn("table", TABLE, at(0.6, -0.5, 0.0))
    gazebo.place("table", at(0.6, 0.5, 0.0))
    gazebo.call_empty("pause_physics")
    before, time = joint_positions(gazebo), gazebo.time
    asked = {"model_name": "robot", "joint_names": ["elbow_joint"]}
    gazebo.expect("set_model_configuration", **asked, joint_positions=[1.0])
    after = joint_positions(gazebo)
    assert after.pop("elbow_joint") == pytest.approx(1.0)
    assert after == pytest.approx({name: before[name] for name in after}, abs=5e-3)
    assert gazebo.position("table") == pytest.approx((0.6, 0.5, 0.0))
    assert gazebo.time == time
    assert gazebo.expect("get_physics_properties").pause  # as it was
    for refused in ([9.0], [math.nan], [1.0, 2.0], []):
        answer = gazebo.call(
            "set_model_configuration", **asked, joint_positions=refused
        )
        assert not answer.success
    assert joint_positions(gazebo)["elbow_joint"] == pytest.approx(1.0)


def joint_positions(gazebo: Gazebo) -> dict[str, float]:
    joints = gazebo.expect("get_model_properties", model_name="robot").joint_names
    return {
        name: gazebo.expect("get_joint_properties", joint_name=name).position[0]
        for name in joints
    }


def test_a_body_is_pushed_until_it_is_cleared(gazebo: Gazebo) -> None:
    """Without a frame, a force acts at the centre of mass, above the link's origin."""
    from geometry_msgs.msg import Vector3

    assert gazebo.spawn("cube", CUBE, at(1.5, 0, 0.2)).success
    gazebo.call_empty("pause_physics")
    gazebo.place("cube", at(1.5, 0, 30))  # it falls for a while
    start = gazebo.time
    assert gazebo.push("cube::cube_link", force=Vector3(0.5, 0, 0)).success
    gazebo.call_empty("unpause_physics")
    until(lambda: gazebo.time > start + 0.2, "0.2 s")
    gazebo.call("clear_body_wrenches", body_name="cube::cube_link")
    gazebo.call_empty("pause_physics")
    pushed = gazebo.twist("cube")
    assert 5.0 * 0.2 < pushed.linear.x <= 5.0 * (gazebo.time - start)
    assert abs(pushed.angular.y) < 1e-6
    gazebo.call_empty("unpause_physics")
    until(lambda: gazebo.time > start + 0.6, "another 0.2 s")
    gazebo.call_empty("pause_physics")
    assert gazebo.twist("cube").linear.x < 5.0 * 0.6


def test_a_wrench_is_given_in_a_frame_and_at_a_point(gazebo: Gazebo) -> None:
    from geometry_msgs.msg import Point, Pose, Quaternion, Vector3

    assert gazebo.spawn("table", TABLE, at(5, 5, 0)).success
    turned = Pose(position=Point(1.5, 0, 30))
    turned.orientation = Quaternion(0, 0, math.sqrt(0.5), math.sqrt(0.5))
    assert gazebo.spawn("cube", CUBE, at(1.5, 0, 0.2)).success
    gazebo.call_empty("pause_physics")
    gazebo.place("cube", turned)
    start = gazebo.time
    body, middle = "cube::cube_link", Point(0.01, 0, EDGE / 2)
    # Along the cube's x, which is the world's y; at its y = 0 and 1 cm along its x.
    gazebo.push(body, frame=body, at=middle, force=Vector3(0.1, 0, 0))
    gazebo.push(body, frame=body, at=middle, force=Vector3(0, 0.001, 0))
    gazebo.call_empty("unpause_physics")
    until(lambda: gazebo.time > start + 0.05, "0.05 s")
    gazebo.call_empty("pause_physics")
    twist = gazebo.twist("cube")
    duration = twist.linear.y / 1.0  # [s], of 0.1 N on 0.1 kg
    assert duration > 0.05
    assert twist.linear.x == pytest.approx(-0.01 * duration, rel=0.05)
    inertia = 0.1 * EDGE**2 / 6.0
    expected = 0.01 * 0.001 / inertia * duration
    assert twist.angular.z == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize(
    ("body", "frame", "says"),
    [
        ("cube::link", "", "there is no body 'cube::link'"),
        ("nobody", "", "there is no body 'nobody'"),
        ("cube::cube_link", "nowhere", "'nowhere' not found"),
        ("robot::base_link", "", "is fixed"),
        ("ground_plane::link", "", "there is no body"),
    ],
)
def test_a_wrench_on_what_cannot_be_pushed_is_refused(
    gazebo: Gazebo, body: str, frame: str, says: str
) -> None:
    from geometry_msgs.msg import Vector3

    assert gazebo.spawn("cube", CUBE, at(1.5, 0, 0)).success
    answer = gazebo.push(body, frame=frame, force=Vector3(1, 0, 0))
    assert not answer.success
    assert says in answer.status_message


def test_invalid_requests_change_nothing(gazebo: Gazebo) -> None:
    gazebo.spawn("table", TABLE, at(0.6, -0.5, 0.0))
    far, nowhere = at(1e300, 0.0, 0.0), at(math.nan, 0.0, 0.0)
    odd = at(0.6, -0.5, 0.0)
    odd.orientation.w = math.inf
    here = at(0.6, 0.5, 0.0)
    refusals = [
        *(gazebo.place("table", pose) for pose in (far, nowhere, odd)),
        gazebo.place("nobody", here),
        gazebo.place("table", here, "nowhere"),
        *(gazebo.spawn("other", CUBE, pose) for pose in (far, nowhere, odd)),
        gazebo.spawn("other", CUBE, here, "nowhere"),
        gazebo.spawn("other", CUBE[:-20], here),
        gazebo.spawn("other", CUBE.replace("0.1", "-0.1"), here),
        gazebo.spawn("other", "<robot>" * 10_000, here),
        gazebo.spawn("other", " " * 2_000_000, here),
        gazebo.spawn("other", "", here),
        *(gazebo.spawn(name, CUBE, here) for name in ("", "a::b", "../a", "link")),
        gazebo.spawn("x" * 10_000, CUBE, here),
        gazebo.call("delete_model", model_name="robot"),
        gazebo.call("delete_model", model_name="ground_plane"),
        gazebo.call("get_link_state", link_name="robot::nothing"),
        gazebo.call("get_joint_properties", joint_name="nothing"),
        gazebo.call("get_model_properties", model_name="nothing"),
    ]
    for answer in refusals:
        assert not answer.success, answer
        assert answer.status_message
    world = gazebo.expect("get_world_properties")
    assert world.model_names == ["ground_plane", "robot", "table"]
    assert gazebo.position("table") == pytest.approx((0.6, -0.5, 0.0))


def test_the_topics_come_125_times_a_second(gazebo: Gazebo) -> None:
    from gazebo_msgs.msg import LinkStates
    from rosgraph_msgs.msg import Clock

    with (
        listening("/gazebo/link_states", LinkStates) as links,
        listening("/clock", Clock) as clock,
    ):
        start, since = clock.messages[-1].clock.to_sec(), len(links.messages)
        clock.wait_for(lambda message: message.clock.to_sec() >= start + 2.0)
        until(lambda: len(links.messages) - since >= 240, "250 link_states")
        passed = clock.messages[-1].clock.to_sec() - start  # it went on meanwhile
        count = len(links.messages) - since
    assert count <= 125 * passed + 10  # what is under way at the ends
