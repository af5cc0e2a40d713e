"""Cameras, and the services that pause, step, reset and fill the simulation."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from ros import Bringup
from ros2_client import Client, Message
from waits import until

OPTIONS = ("--arm", "ur5e")
SIMULATION = "/simulation"
EMPTY = "std_srvs/srv/Empty"
CLOCK = "rosgraph_msgs/msg/Clock"
PLAYING, PAUSED = 1, 2
OK, NOT_FOUND, INCORRECT_STATE = 1, 2, 3
CUBE = """
<sdf version="1.6"><model name="cube"><link name="link">
  <pose>0 0 0.05 0 0 0</pose>
  <inertial><mass>0.2</mass></inertial>
  <collision name="c"><geometry><box><size>0.1 0.1 0.1</size></box></geometry>
  </collision>
</link></model></sdf>
"""
PLACE = {"x": 0.8, "y": 0.3, "z": 0.4}


def call(client: Client, name: str, /, **request: object) -> Message:
    kind = "".join(word.capitalize() for word in name.split("_"))
    service = f"{SIMULATION}/{name}"
    return client.call(service, f"simulation_interfaces/srv/{kind}", **request)


@pytest.fixture
def paused(client: Client, bringup: Bringup) -> Iterator[None]:
    client.call("/pause_physics", EMPTY)
    yield
    client.call("/unpause_physics", EMPTY)


def spawn(client: Client, name: str, **options: object) -> Message:
    pose = {"pose": {"position": PLACE}}
    return call(
        client,
        "spawn_entity",
        name=name,
        resource_string=CUBE,
        initial_pose=pose,
        **options,
    )


def height(client: Client, entity: str) -> float:
    reply = call(client, "get_entity_state", entity=entity)
    assert reply.result.result == OK, reply.result.error_message
    assert reply.state.header.frame_id == "world"
    z: float = reply.state.pose.position.z
    return z


def test_it_pauses_steps_and_resumes(client: Client, paused: None) -> None:
    assert call(client, "get_simulation_state").state.state == PAUSED
    with client.listening("/clock", CLOCK, wait=False) as clock:
        assert call(client, "step_simulation", steps=1000).result.result == OK
        end = clock.wait_for().clock
        assert call(client, "step_simulation", steps=500).result.result == OK
        clock.wait_for(lambda message: message.clock >= end + 0.99)
    state = {"state": PLAYING}
    assert call(client, "set_simulation_state", state=state).result.result == OK
    again = call(client, "set_simulation_state", state=state).result
    assert again.result == 101
    assert again.error_message
    assert call(client, "get_simulation_state").state.state == PLAYING
    refused = call(client, "step_simulation", steps=1).result
    assert refused.result == INCORRECT_STATE


def test_a_reset_sets_the_time_back(client: Client, bringup: Bringup) -> None:
    with client.listening("/clock", CLOCK) as clock:
        before = clock.last.clock
        client.call("/reset_world", EMPTY)
        assert clock.next()[0].clock >= before
        client.call("/reset_simulation", EMPTY)
        clock.wait_for_new(lambda message: message.clock < before)


def test_entities_come_move_and_go(client: Client, paused: None) -> None:
    assert spawn(client, "one").entity_name == "one"
    assert height(client, "one") == pytest.approx(PLACE["z"], abs=1e-9)
    assert spawn(client, "one").result.result == 101
    renamed = spawn(client, "one", allow_renaming=True)
    assert renamed.entity_name == "one_1"
    robot, *others = call(client, "get_entities").entities
    assert others == ["one", "one_1"]
    named = call(client, "get_entities", filters={"filter": "_1$"}).entities
    assert named == ["one_1"]
    moved = call(
        client,
        "set_entity_state",
        entity="one",
        state={"pose": {"position": {**PLACE, "z": 0.7}}},
    )
    assert moved.result.result == OK
    assert height(client, "one") == pytest.approx(0.7, abs=1e-9)
    call(client, "step_simulation", steps=100)  # of 2 ms: it falls
    assert height(client, "one") < 0.65
    assert call(client, "delete_entity", entity="one_1").result.result == OK
    assert call(client, "delete_entity", entity=robot).result.result not in (
        OK,
        NOT_FOUND,
    )
    assert call(client, "delete_entity", entity="one_1").result.result == NOT_FOUND
    assert call(client, "reset_simulation").result.result == OK
    assert call(client, "get_entities").entities == [robot]


def test_models_that_are_none_are_refused(client: Client, bringup: Bringup) -> None:
    def result(**request: object) -> int:
        reply = call(client, "spawn_entity", name="two", **request)
        assert reply.result.error_message
        code: int = reply.result.result
        return code

    assert result() == 104
    assert result(resource_string="<sdf>") == 106
    assert result(resource_string=CUBE, entity_namespace="/left") == 105
    assert result(uri="http://example.org/model.sdf") == 103
    assert result(uri="/nowhere/model.sdf") == 104
    pose = {"header": {"frame_id": "nowhere"}}
    assert result(resource_string=CUBE, initial_pose=pose) == 109


def test_cameras_publish_to_subscribers(client: Client, bringup: Bringup) -> None:
    with client.listening(
        "/scene_camera/depth/camera_info", "sensor_msgs/msg/CameraInfo"
    ) as topic:
        info = topic.last
    assert info.k[0] == info.k[4] > 0.0
    with client.listening(
        "/scene_camera/depth/image_raw", "sensor_msgs/msg/Image"
    ) as topic:
        image = topic.last
    assert (image.width, image.height) == (info.width, info.height)
    assert (image.encoding, image.step) == ("32FC1", 4 * image.width)
    assert len(image.data) == image.step * image.height
    assert image.header.frame_id == info.header.frame_id
    with client.listening(
        "/tf_static", "tf2_msgs/msg/TFMessage", latched=True
    ) as topic:
        until(
            lambda: any(
                frame.child_frame_id == image.header.frame_id
                for message in topic.since(0)
                for frame in message.transforms
            ),
            "the camera's frame",
        )
