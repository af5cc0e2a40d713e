"""The services and topics of gazebo_ros, called as its own tools call them."""

from __future__ import annotations

import importlib
import json
import math
from collections.abc import Iterator
from types import ModuleType
from typing import Any

import pytest
from promised import require_engine
from ros import Bringup, Ros, until
from ros_client import Message, call, listening, publishing

from tool0.description.catalogue import assemble
from tool0.description.forward_kinematics import link_poses

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
END = "--- end of an answer ---"
ROSSERVICE = f"""
import json, sys
from rosservice import rosservicemain
for name, request in json.loads(sys.argv[1]):
    rosservicemain(["rosservice", "call", name, request])
    print("{END}")
"""
"""The command, many times in one process: it takes a second to start."""
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
}


@pytest.fixture(scope="module", params=["mujoco", "gazebo"])
def bringup(ros: Ros, request: pytest.FixtureRequest) -> Iterator[Bringup]:
    require_engine(request.param)
    bringup = ros.bring_up("--engine", request.param)
    yield bringup
    bringup.close()


@pytest.fixture
def gazebo(rospy: ModuleType, bringup: Bringup) -> Iterator[Gazebo]:
    gazebo = Gazebo()
    yield gazebo
    gazebo.tell("unpause_physics")
    for name in gazebo.ask("get_world_properties").model_names:
        if name not in ("ground_plane", "robot"):
            gazebo.ask("delete_model", model_name=name)
    gazebo.tell("reset_world")


class Gazebo:
    """The services, by their names."""

    def tell(self, name: str) -> None:
        from std_srvs.srv import Empty

        call(f"/gazebo/{name}", Empty)

    def attempt(self, name: str, **request: object) -> Message:
        from gazebo_msgs import srv

        kind = getattr(srv, TYPES[name].partition("/")[2])
        return call(f"/gazebo/{name}", kind, **request)

    def ask(self, name: str, **request: object) -> Message:
        answer = self.attempt(name, **request)
        assert answer.success, answer.status_message
        return answer

    def spawn(self, name: str, xml: str, pose: Message, frame: str = "") -> Message:
        kind = "urdf" if "<robot" in xml else "sdf"
        return self.attempt(
            f"spawn_{kind}_model",
            model_name=name,
            model_xml=xml,
            initial_pose=pose,
            reference_frame=frame,
        )

    def place(self, name: str, pose: Message, frame: str = "", **more: Any) -> Message:
        from gazebo_msgs.msg import ModelState

        state = ModelState(model_name=name, pose=pose, reference_frame=frame, **more)
        return self.attempt("set_model_state", model_state=state)

    def position(self, name: str, frame: str = "") -> tuple[float, float, float]:
        state = self.ask("get_model_state", model_name=name, relative_entity_name=frame)
        return xyz(state.pose.position)

    @property
    def time(self) -> float:
        seconds: float = self.ask("get_world_properties").sim_time
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


def test_a_model_is_spawned_falls_and_is_taken_away(
    gazebo: Gazebo, rospy: ModuleType
) -> None:
    from gazebo_msgs.msg import LinkStates, ModelStates

    rospy.wait_for_service("/gazebo/spawn_urdf_model", timeout=10.0)
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
        gone = gazebo.ask("delete_model", model_name="cube")
        assert gone.status_message == "DeleteModel: successfully deleted model"
        models.wait_for(lambda s: not has("cube")(s), since=len(models.messages))
    again = gazebo.attempt("delete_model", model_name="cube")
    assert (again.success, again.status_message) == (
        False,
        "DeleteModel: model does not exist",
    )


def test_a_name_is_given_once(gazebo: Gazebo) -> None:
    assert gazebo.spawn("cube", CUBE, at(0.6, 0.0, 0.1)).success
    for name in ("cube", "robot", "ground_plane"):
        answer = gazebo.spawn(name, CUBE, at(0.6, 0.3, 0.1))
        assert (answer.success, answer.status_message) == (
            False,
            f"SpawnModel: Failure - model name {name} already exist.",
        )


def test_poses_refer_to_links_and_models(gazebo: Gazebo) -> None:
    gazebo.tell("pause_physics")
    flange = gazebo.ask("get_link_state", link_name="robot::tool0").link_state
    assert gazebo.spawn("cube", CUBE, at(0.0, 0.0, 0.3), "robot::tool0").success
    assert gazebo.position("cube", "tool0") == pytest.approx((0, 0, 0.3), abs=1e-6)
    # tool0 looks down in this pose.
    x, y, z = xyz(flange.pose.position)
    assert gazebo.position("cube") == pytest.approx((x, y, z - 0.3), abs=0.01)
    assert gazebo.spawn("other", TABLE, at(0.0, 0.0, 1.0), "cube").success
    assert gazebo.position("other", "cube") == pytest.approx((0, 0, 1), abs=1e-6)
    assert gazebo.position("robot", "robot::base_link") == pytest.approx((0, 0, 0))
    lost = gazebo.attempt(
        "get_model_state", model_name="cube", relative_entity_name="nothing"
    )
    assert not lost.success
    assert "'nothing' not found" in lost.status_message


def test_a_model_is_put_somewhere_moving(gazebo: Gazebo) -> None:
    from geometry_msgs.msg import Twist, Vector3

    gazebo.spawn("cube", CUBE, at(0.6, -0.5, 0.0))
    gazebo.tell("pause_physics")
    twist = Twist(linear=Vector3(0.1, 0.2, 0.3), angular=Vector3(1.0, 2.0, 3.0))
    assert gazebo.place("cube", at(0.0, 0.0, 1.0), "robot", twist=twist).success
    state = gazebo.ask("get_model_state", model_name="cube")
    assert state.status_message == "GetModelState: got properties"
    assert xyz(state.pose.position) == pytest.approx((0.0, 0.0, 1.1))
    assert xyz(state.twist.linear) == pytest.approx((0.1, 0.2, 0.3))
    assert xyz(state.twist.angular) == pytest.approx((1.0, 2.0, 3.0))
    refused = gazebo.place("robot", at(1.0, 0.0, 0.0))
    assert not refused.success
    assert "bolted to the world" in refused.status_message


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
    gazebo.tell("pause_physics")
    position = {}
    for joint in model.movable_joints:
        answer = gazebo.ask("get_joint_properties", joint_name=joint.name)
        (position[joint.name],) = answer.position
        assert answer.type == answer.REVOLUTE
        assert len(answer.rate) == len(answer.damping) == 1
    poses = link_poses(model, position)
    for link in ("base_link", "wrist_3_link", "tool0", "left_inner_finger_pad"):
        state = gazebo.ask("get_link_state", link_name=f"robot::{link}").link_state
        x, y, z = poses[link].position
        assert xyz(state.pose.position) == pytest.approx((x, y, z + 0.1), abs=1e-6)
        turn = state.pose.orientation
        assert (turn.w, turn.x, turn.y, turn.z) == pytest.approx(
            poses[link].quat_wxyz, abs=1e-6
        )
    wrist = gazebo.ask("get_joint_properties", joint_name="robot::wrist_3_joint")
    assert wrist.position[0] == position["wrist_3_joint"]


def test_the_robot_has_the_parts_that_gazebo_leaves_it(gazebo: Gazebo) -> None:
    robot = gazebo.ask("get_model_properties", model_name="robot")
    assert robot.canonical_body_name == "base_link"
    assert "wrist_3_link" in robot.body_names
    assert "tool0" not in robot.body_names  # is fixed: Gazebo lumps it
    assert "elbow_joint" in robot.joint_names
    assert not robot.is_static
    gazebo.spawn("table", TABLE, at(0.6, -0.5, 0.0))
    table = gazebo.ask("get_model_properties", model_name="table")
    assert (table.body_names, table.geom_names) == (["top"], ["slab"])
    assert table.is_static
    assert gazebo.ask("get_model_properties", model_name="ur5_robot").body_names


def test_time_stands_still_and_goes_on(gazebo: Gazebo) -> None:
    gazebo.tell("pause_physics")
    physics = gazebo.ask("get_physics_properties")
    assert physics.pause
    assert physics.time_step == 0.001
    assert physics.gravity.z in (-9.81, -9.8)  # MuJoCo's, Gazebo's
    stopped = gazebo.time
    gazebo.place("robot", at(0.0, 0.0, 0.0))  # whatever is asked
    assert gazebo.time == stopped
    gazebo.tell("unpause_physics")
    assert not gazebo.ask("get_physics_properties").pause
    until(lambda: gazebo.time > stopped + 0.1, "time that goes on")


def test_reset_world_keeps_time_and_reset_simulation_does_not(gazebo: Gazebo) -> None:
    gazebo.spawn("table", TABLE, at(0.6, -0.5, 0.0))
    gazebo.place("table", at(0.6, 0.5, 0.0))
    until(lambda: gazebo.time > 1.0, "a second of simulated time")
    gazebo.tell("pause_physics")
    before = gazebo.time
    gazebo.tell("reset_world")
    assert gazebo.position("table") == pytest.approx((0.6, -0.5, 0.0))
    assert gazebo.time == before
    gazebo.tell("reset_simulation")
    assert gazebo.time == 0.0


def test_set_model_configuration_moves_joints_alone(gazebo: Gazebo) -> None:
    gazebo.spawn("table", TABLE, at(0.6, -0.5, 0.0))
    gazebo.place("table", at(0.6, 0.5, 0.0))
    gazebo.tell("pause_physics")
    before, time = joint_positions(gazebo), gazebo.time
    asked = {"model_name": "robot", "joint_names": ["elbow_joint"]}
    gazebo.ask("set_model_configuration", **asked, joint_positions=[1.0])
    after = joint_positions(gazebo)
    assert after.pop("elbow_joint") == pytest.approx(1.0)
    assert after == pytest.approx({name: before[name] for name in after}, abs=5e-3)
    assert gazebo.position("table") == pytest.approx((0.6, 0.5, 0.0))
    assert gazebo.time == time
    assert gazebo.ask("get_physics_properties").pause  # as it was
    for refused in ([9.0], [math.nan], [1.0, 2.0], []):
        answer = gazebo.attempt(
            "set_model_configuration", **asked, joint_positions=refused
        )
        assert not answer.success
    assert joint_positions(gazebo)["elbow_joint"] == pytest.approx(1.0)


def joint_positions(gazebo: Gazebo) -> dict[str, float]:
    joints = gazebo.ask("get_model_properties", model_name="robot").joint_names
    return {
        name: gazebo.ask("get_joint_properties", joint_name=name).position[0]
        for name in joints
    }


def test_nonsense_is_refused_and_changes_nothing(gazebo: Gazebo) -> None:
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
        gazebo.attempt("delete_model", model_name="robot"),
        gazebo.attempt("delete_model", model_name="ground_plane"),
        gazebo.attempt("get_link_state", link_name="robot::nothing"),
        gazebo.attempt("get_joint_properties", joint_name="nothing"),
        gazebo.attempt("get_model_properties", model_name="nothing"),
    ]
    for answer in refusals:
        assert not answer.success, answer
        assert answer.status_message
    world = gazebo.ask("get_world_properties")
    assert world.model_names == ["ground_plane", "robot", "table"]
    assert gazebo.position("table") == pytest.approx((0.6, -0.5, 0.0))


def test_the_topics_tell_125_times_a_second(gazebo: Gazebo) -> None:
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


@pytest.mark.parametrize("bringup", ["mujoco"], indirect=True)
def test_rosservice_calls_them_all(ros: Ros, gazebo: Gazebo) -> None:
    pose = {"position": {"x": 0.6, "y": 0.0, "z": 0.1}}
    cube = {"model_name": "cube", "model_xml": CUBE, "initial_pose": pose}
    requests: tuple[tuple[str, dict[str, object]], ...] = (
        ("pause_physics", {}),
        ("unpause_physics", {}),
        ("spawn_urdf_model", cube),
        ("spawn_sdf_model", {**cube, "model_name": "table", "model_xml": TABLE}),
        ("get_world_properties", {}),
        ("get_physics_properties", {}),
        ("get_model_properties", {"model_name": "cube"}),
        ("get_model_state", {"model_name": "cube"}),
        ("set_model_state", {"model_state": {"model_name": "cube", "pose": pose}}),
        ("get_link_state", {"link_name": "cube::cube_link"}),
        ("get_joint_properties", {"joint_name": "elbow_joint"}),
        (
            "set_model_configuration",
            {
                "model_name": "robot",
                "joint_names": ["elbow_joint"],
                "joint_positions": [1.5],
            },
        ),
        ("delete_model", {"model_name": "cube"}),
        ("reset_world", {}),
        ("reset_simulation", {}),
    )
    assert {name for name, _ in requests} == TYPES.keys()
    calls = [(f"/gazebo/{name}", json.dumps(request)) for name, request in requests]
    answers = ros.python(ROSSERVICE, json.dumps(calls)).split(END)[:-1]
    for (name, _), answer in zip(requests, answers, strict=True):
        if TYPES[name] != "std_srvs/Empty":
            assert "success: True" in answer, (name, answer)
