"""The services and topics of gazebo_ros that people call, on either engine."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tool0.api.robot import Robot
from tool0.errors import Tool0Error
from tool0.interfaces.ros1.conversions import Message
from tool0.interfaces.ros1.gazebo.changes import GazeboChanges
from tool0.interfaces.ros1.gazebo.queries import GazeboQueries
from tool0.interfaces.ros1.gazebo.topics import GazeboTopics
from tool0.interfaces.ros1.gazebo.world import GazeboWorld
from tool0.interfaces.ros1.node import Part, RosNode

Answer = Callable[[Message, Message], str]
"""Takes a request, fills the response, returns what status_message says."""


def present_gazebo(node: RosNode, robot: Robot) -> Part:
    """Present the world under the node's name; return what publishes it."""
    from gazebo_msgs import msg, srv

    world = GazeboWorld(robot)
    queries = GazeboQueries(node, robot, world)
    changes = GazeboChanges(robot, world)
    place = node.options.node
    for name, kind, answer in (
        ("get_world_properties", srv.GetWorldProperties, queries.world_properties),
        (
            "get_physics_properties",
            srv.GetPhysicsProperties,
            queries.physics_properties,
        ),
        ("get_model_properties", srv.GetModelProperties, queries.model_properties),
        ("get_model_state", srv.GetModelState, queries.model_state),
        ("get_link_state", srv.GetLinkState, queries.link_state),
        ("get_joint_properties", srv.GetJointProperties, queries.joint_properties),
        ("set_model_state", srv.SetModelState, changes.set_model_state),
        (
            "set_model_configuration",
            srv.SetModelConfiguration,
            changes.set_model_configuration,
        ),
        ("spawn_urdf_model", srv.SpawnModel, changes.spawn),
        ("spawn_sdf_model", srv.SpawnModel, changes.spawn),
        ("delete_model", srv.DeleteModel, changes.delete),
    ):
        node.service(f"{place}/{name}", kind, _telling(kind, answer))
    _present_time(node, robot)
    node.subscriber(f"{place}/set_model_state", msg.ModelState, changes.place)
    return GazeboTopics(node, world)


def _telling(kind: Any, answer: Answer) -> Callable[[Message], Message]:
    """Return a handler whose response says by itself whether it went well."""
    title = kind.__name__

    def handle(request: Message) -> Message:
        response = kind._response_class()
        try:
            text = answer(request, response)
        except Tool0Error as error:
            return kind._response_class(
                success=False, status_message=f"{title}: {error}"
            )
        response.success = True
        response.status_message = f"{title}: {text}"
        return response

    return handle


def _present_time(node: RosNode, robot: Robot) -> None:
    from std_srvs.srv import Empty, EmptyResponse

    def offer(name: str, act: Callable[[], None]) -> None:
        def handle(_: Message) -> Message:
            act()
            return EmptyResponse()

        node.service(f"{node.options.node}/{name}", Empty, handle)

    offer("pause_physics", robot.pause)
    offer("unpause_physics", robot.resume)
    offer("reset_simulation", robot.reset)
    offer("reset_world", lambda: robot.reset(keep_time=True))
