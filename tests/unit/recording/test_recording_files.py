"""A recording is read by mcap, by rosbags and by tool0, and equals the snapshots."""

from __future__ import annotations

import json
import math
from collections import defaultdict
from typing import Any

import numpy as np
import pytest
from recording_session import Session, recorded

import tool0
from tool0.description.forward_kinematics import link_pose
from tool0.description.model import FLANGE
from tool0.protocol.state import Snapshot

TOPICS = {
    "/joint_states": "sensor_msgs/msg/JointState",
    "/joint_commands": "sensor_msgs/msg/JointState",
    "/gripper_states": "sensor_msgs/msg/JointState",
    "/robot_description": "std_msgs/msg/String",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/objects": "tf2_msgs/msg/TFMessage",
    "/contacts": "sensor_msgs/msg/PointCloud2",
    "/wrench": "geometry_msgs/msg/WrenchStamped",
    "/rosout": "rcl_interfaces/msg/Log",
    "/tool0/state": "std_msgs/msg/String",
    "/tool0/events": "std_msgs/msg/String",
    "/tool0/requests": "std_msgs/msg/String",
}


def read_by_mcap(session: Session) -> dict[str, list[tuple[int, Any]]]:
    """Return topic → log time and message, decoded by mcap's schemas and rosbags."""
    from mcap.reader import make_reader
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.EMPTY)
    found: dict[str, list[tuple[int, Any]]] = defaultdict(list)
    with session.path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            assert schema is not None
            assert schema.encoding == "ros2msg"
            if schema.name not in store.types:
                types = get_types_from_msg(schema.data.decode(), schema.name)
                store.register({k: v for k, v in types.items() if k not in store.types})
            decoded = store.deserialize_cdr(message.data, schema.name)
            found[channel.topic].append((message.log_time, decoded))
    return found


def read_by_rosbags(session: Session) -> dict[str, list[tuple[int, Any]]]:
    """Return the same by rosbags alone: the path of a program of ROS 2 without ROS."""
    from rosbags.highlevel import AnyReader

    found: dict[str, list[tuple[int, Any]]] = defaultdict(list)
    with AnyReader([session.path]) as reader:
        for connection, time, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            assert connection.msgtype == TOPICS[connection.topic]
            found[connection.topic].append((time, message))
    return found


@pytest.mark.parametrize("read", [read_by_mcap, read_by_rosbags])
def test_other_libraries_read_what_the_snapshots_were(
    session: Session, read: Any
) -> None:
    snapshots, topics = recorded(session), read(session)
    assert topics.keys() == TOPICS.keys()
    n_objects = 0
    for snapshot, (time, states), (_, commands) in zip(
        snapshots, topics["/joint_states"], topics["/joint_commands"], strict=True
    ):
        assert time == round(snapshot.time * 1e9)
        assert states.header.stamp.sec == time // 10**9
        assert states.header.stamp.nanosec == time % 10**9
        assert tuple(states.name) == tuple(commands.name) == snapshot.joint_names
        assert tuple(states.position) == snapshot.position
        assert tuple(states.velocity) == snapshot.velocity
        assert tuple(states.effort) == snapshot.effort
        setpoints = snapshot.setpoints()
        for name, p, v in zip(
            commands.name, commands.position, commands.velocity, strict=True
        ):
            if name in setpoints:
                assert (p, v) == (setpoints[name].position, setpoints[name].velocity)
            else:
                assert math.isnan(p)
                assert math.isnan(v)
        _, objects = topics["/objects"][n_objects]
        n_objects += 1
        assert [item.child_frame_id for item in objects.transforms] == [
            item.name for item in snapshot.scene
        ]
        for item, state in zip(objects.transforms, snapshot.objects, strict=True):
            at, turn = item.transform.translation, item.transform.rotation
            assert (at.x, at.y, at.z) == state.position
            assert (turn.w, turn.x, turn.y, turn.z) == state.quat_wxyz
    assert n_objects == len(topics["/objects"])


def test_other_libraries_read_the_forces(session: Session) -> None:
    sampled = [snapshot for snapshot in recorded(session) if snapshot.arms]
    topics = read_by_rosbags(session)
    for snapshot, (time, wrench), (_, contacts) in zip(
        sampled, topics["/wrench"], topics["/contacts"], strict=True
    ):
        assert time == round(snapshot.time * 1e9)
        assert wrench.header.frame_id == FLANGE
        f, t = wrench.wrench.force, wrench.wrench.torque
        assert (f.x, f.y, f.z, t.x, t.y, t.z) == snapshot.arms["arm"].wrench
        names = [field.name for field in contacts.fields]
        rows = contacts.data.reshape(contacts.width, contacts.point_step)
        values = rows[:, :72].copy().view("<f8")
        assert names[:6] == ["x", "y", "z", "fx", "fy", "fz"]
        assert [tuple(row[:6]) for row in values] == [
            (*item.point, *item.force) for item in snapshot.contacts
        ]
    assert len(sampled) > 30


def test_frames_lead_from_the_root_to_every_link(session: Session) -> None:
    """The transforms of one instant, chained, are the forward kinematics."""
    from tool0.description.forward_kinematics import link_poses
    from tool0.description.transform import Transform, from_quaternion

    topics = read_by_rosbags(session)
    time, moving = topics["/tf"][10]
    ((_, fixed),) = topics["/tf_static"]
    T_parent: dict[str, tuple[str, Transform]] = {}
    for item in [*moving.transforms, *fixed.transforms]:
        at, turn = item.transform.translation, item.transform.rotation
        pose = from_quaternion((at.x, at.y, at.z), (turn.w, turn.x, turn.y, turn.z))
        T_parent[item.child_frame_id] = item.header.frame_id, pose
    model = tool0.open_recording(session.path).description.model
    states = next(s for s in recorded(session) if round(s.time * 1e9) == time)
    for link, T_root_link in link_poses(model, states.positions).items():
        found, frame = Transform(), link
        while frame != model.root:
            frame, pose = T_parent[frame]
            found = pose @ found
        np.testing.assert_allclose(found.matrix, T_root_link.matrix, atol=1e-12)


def test_the_reader_returns_the_same_snapshots(session: Session) -> None:
    expected = recorded(session)
    recording = tool0.open_recording(session.path)
    assert recording.is_complete
    assert len(recording) == len(expected)
    sampled = expected[0]
    for read, snapshot in zip(recording.snapshots(), expected, strict=True):
        sampled = snapshot if snapshot.arms else sampled
        assert comparable(read, read) == comparable(snapshot, sampled)


def comparable(snapshot: Snapshot, sampled: Snapshot) -> dict[str, Any]:
    """Return what a recording has of a snapshot, and of the last one with forces."""
    names = (
        *("time", "tick", "joint_names", "position", "velocity", "effort"),
        *("controllers", "is_paused", "is_stopped", "fault", "speed", "scene"),
        *("stalls", "gripping", "control_boxes"),
    )
    return {name: getattr(snapshot, name) for name in names} | {
        "setpoints": dict(snapshot.setpoints()),
        "objects": [(o.name, o.position, o.quat_wxyz) for o in snapshot.objects],
        "arms": {arm: (a.mode, a.wrench) for arm, a in sampled.arms.items()},
        "contacts": sampled.contacts,
    }


def test_arrays_have_a_row_for_each_snapshot(session: Session) -> None:
    snapshots = recorded(session)
    recording = tool0.open_recording(session.path)
    assert recording.time.tolist() == [s.time for s in snapshots]
    assert recording.tick.tolist() == [s.tick for s in snapshots]
    assert recording.position.tolist() == [list(s.position) for s in snapshots]
    assert recording.velocity.tolist() == [list(s.velocity) for s in snapshots]
    assert recording.effort.tolist() == [list(s.effort) for s in snapshots]
    assert recording.duration == snapshots[-1].time - snapshots[0].time
    for name in ("box", "ball", "table"):
        for row, snapshot in zip(recording.objects[name], snapshots, strict=True):
            state = next((o for o in snapshot.objects if o.name == name), None)
            if state is None:
                assert np.isnan(row).all()
            else:
                assert tuple(row) == (*state.position, *state.quat_wxyz)
    opening = recording.gripper_states["gripper"][:, 0]
    geometry = recording.robot.grippers["gripper"]
    column = recording.joint_names.index(geometry.joint)
    assert opening[-1] == max(0.0, geometry.opening(snapshots[-1].position[column]))
    assert opening[0] > 0.08
    assert opening[-1] < 0.03


def test_a_table_has_every_column(session: Session) -> None:
    pytest.importorskip("pandas", reason="pandas is not installed")
    recording = tool0.open_recording(session.path)
    table = recording.to_pandas()
    assert table.index.name == "time"
    assert table["elbow_joint.position"].tolist() == recording.position[:, 2].tolist()
    assert table["box.x"].isna().sum() > 0
    assert table["arm.fz"].tolist() == recording.wrenches["arm"][:, 2].tolist()
    for tool in ("tool0", "gripper.tcp"):
        poses = recording.tool_poses[tool]
        assert table[f"{tool}.z"].tolist() == poses[:, 2].tolist()
        assert table[f"{tool}.qw"].tolist() == poses[:, 3].tolist()
    snapshot = recording.snapshots()[-1]
    T = link_pose(recording.description.model, snapshot.positions, "tool0")
    last = recording.tool_poses["tool0"][-1, :3]
    assert last.tolist() == pytest.approx(T.position, abs=1e-9)


def test_events_say_what_happened(session: Session) -> None:
    events = tool0.open_recording(session.path).events
    kinds = [event.kind for event in events]
    assert kinds.count("emergency_stop") == 2
    (ended,) = [event for event in events if event.kind == "goal_preempted"]
    assert ended.data["controller"] == "gripper_controller"
    assert "goal preempted" in ended.text
    times = [event.time for event in events]
    assert times == sorted(times)


def test_events_are_in_rosout_too(session: Session) -> None:
    topics = read_by_rosbags(session)
    events = tool0.open_recording(session.path).events
    logged = [message.msg for _, message in topics["/rosout"]]
    assert logged == [event.text for event in events]


def test_requests_are_those_of_the_journal(session: Session) -> None:
    requests = tool0.open_recording(session.path).requests
    methods = [request.method for request in requests]
    assert methods.count("emergency_stop") == 2
    (place,) = [request for request in requests if request.method == "place_object"]
    assert place.params["xyz"] == [0.6, 0.5, 0.5]
    assert place.error is None
    assert [request.number for request in requests] == list(range(len(requests)))


def test_the_robot_is_in_the_file(session: Session) -> None:
    recording = tool0.open_recording(session.path)
    assert recording.description.title == "ur5 + 2f85"
    meshes = [name for name in recording.attachments if name.startswith("meshes/")]
    assert len(meshes) > 20
    folder = recording.robot.folder
    for link in recording.description.model.links:
        for visual in link.visuals:
            path = getattr(visual.geometry, "path", folder)
            assert path.is_relative_to(folder)
    assert json.loads(recording.attachments["bringup.json"])["engine"] == "mujoco"
    assert recording.simulation.control_period == 0.001
