"""The services and topics of gazebo_ros, for both physics engines."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, final

from gazebo_msgs import msg, srv
from geometry_msgs.msg import Vector3
from std_srvs.srv import Empty, EmptyResponse

from tool0.api.robot import Robot
from tool0.description.forward_kinematics import FrameMotion
from tool0.description.model import JointType
from tool0.errors import ControlError, Tool0Error
from tool0.protocol.state import Snapshot
from tool0.ros1.gazebo.world import GROUND, GazeboChanges, GazeboWorld, WorldState
from tool0.ros1.messages import Message, pose_message, twist_message
from tool0.ros1.namespace import RosNamespace
from tool0.ros1.options import NODE_NAME

Handler = Callable[[Message, Message], str]
"""Function that takes a request, fills in the response, and returns the text of its
status_message."""

_JOINT_TYPES = {
    JointType.REVOLUTE: 0,
    JointType.CONTINUOUS: 1,
    JointType.PRISMATIC: 2,
    JointType.FIXED: 3,
}
"""Number of each joint type in gazebo_msgs/GetJointProperties. gazebo_ros reports every
joint as revolute."""
_SUCCESS = "got properties"


def offer_gazebo_services(ros: RosNamespace, robot: Robot) -> GazeboStatePublisher:
    """Offer the services under the node's name, and return the topics' publisher."""
    world = GazeboWorld(robot)
    queries = GazeboQueries(ros, robot, world)
    changes = GazeboChanges(robot, world, ros.node.clock.from_ros)
    services = [
        (name := handler.__name__, getattr(srv, name.title().replace("_", "")), handler)
        for handler in (
            queries.get_world_properties,
            queries.get_physics_properties,
            queries.get_model_properties,
            queries.get_model_state,
            queries.get_link_state,
            queries.get_joint_properties,
            changes.set_model_state,
            changes.set_model_configuration,
            changes.delete_model,
            changes.apply_body_wrench,
        )
    ]
    for name in ("spawn_urdf_model", "spawn_sdf_model"):
        services.append((name, srv.SpawnModel, changes.spawn_model))
    for name, kind, handler in services:
        ros.service(f"{NODE_NAME}/{name}", kind, _with_status(kind, handler))

    def clear_body_wrenches(request: Message) -> Message:
        changes.clear_body_wrenches(request.body_name)
        return srv.BodyRequestResponse()

    ros.service(
        f"{NODE_NAME}/clear_body_wrenches", srv.BodyRequest, clear_body_wrenches
    )

    def offer(name: str, operation: Callable[[], None]) -> None:
        def handle(request: Message) -> Message:
            operation()
            return EmptyResponse()

        ros.service(f"{NODE_NAME}/{name}", Empty, handle)

    offer("pause_physics", robot.pause)
    offer("unpause_physics", robot.resume)
    offer("reset_simulation", robot.reset)
    offer("reset_world", lambda: robot.reset(keep_time=True))
    topic = f"{NODE_NAME}/set_model_state"
    ros.subscriber(topic, msg.ModelState, changes.place)
    return GazeboStatePublisher(ros, world)


def _with_status(kind: Any, handler: Handler) -> Callable[[Message], Message]:
    """Return a handler that also sets ``success`` and ``status_message``."""

    def handle(request: Message) -> Message:
        response = kind._response_class()
        try:
            text = handler(request, response)
            response.success = True
        except Tool0Error as error:
            response = kind._response_class(success=False)
            text = str(error)
        response.status_message = f"{kind.__name__}: {text}"
        return response

    return handle


@final
class GazeboQueries:
    """The services that read the world.

    The services raise ControlError to refuse a request.
    """

    def __init__(self, ros: RosNamespace, robot: Robot, world: GazeboWorld) -> None:
        self._ros, self._robot, self._world = ros, robot, world

    def get_world_properties(self, request: Message, response: Message) -> str:
        state = self._world.now()
        response.sim_time = self._ros.node.clock.to_ros(state.snapshot.time).to_sec()
        response.model_names = list(state.models())
        response.rendering_enabled = True
        return _SUCCESS

    def get_physics_properties(self, request: Message, response: Message) -> str:
        """Fill in the step, rate and gravity.  The parameters of ODE remain zero."""
        snapshot, dt = self._robot.snapshot, self._robot.engine.dt
        response.time_step = dt
        response.pause = snapshot.is_paused
        response.max_update_rate = (
            0.0 if snapshot.speed is None else snapshot.speed / dt
        )
        response.gravity = Vector3(*self._robot.engine.world.gravity)
        return _SUCCESS

    def get_model_properties(self, request: Message, response: Message) -> str:
        name, state = request.model_name, self._world.now()
        if self._world.is_robot(name):
            model = self._world.model
            response.body_names = list(self._world.robot_links)
            response.geom_names = [
                f"{link.name}_collision" for link in model.links if link.collisions
            ]
            response.joint_names = [joint.name for joint in model.movable_joints]
        elif name in state.objects:
            item, rigid, _ = state.objects[name]
            response.body_names = [rigid.link]
            response.geom_names = list(rigid.collisions)
            response.is_static = item.mass is None
        elif name == GROUND and self._world.has_ground:
            response.body_names, response.geom_names = ["link"], ["collision"]
            response.is_static = True
        else:
            raise ControlError("model does not exist")
        response.canonical_body_name = response.body_names[0]
        return _SUCCESS

    def get_model_state(self, request: Message, response: Message) -> str:
        state, frame = self._world.now(), request.relative_entity_name
        motion = state.model(request.model_name)
        if motion is None:
            raise ControlError("model does not exist")
        self._fill(response, state, motion, frame)
        response.header = self._ros.header(state.snapshot.time, frame)
        return _SUCCESS

    def get_link_state(self, request: Message, response: Message) -> str:
        state = self._world.now()
        motion = state.link(request.link_name)
        if motion is None:
            raise ControlError(
                "link not found, did you forget to scope the link by model name?"
            )
        self._fill(response.link_state, state, motion, request.reference_frame)
        response.link_state.link_name = request.link_name
        response.link_state.reference_frame = request.reference_frame
        return "got state"

    def get_joint_properties(self, request: Message, response: Message) -> str:
        joint = self._world.joint(request.joint_name)
        if joint is None or joint.type not in _JOINT_TYPES:
            raise ControlError("joint not found")
        response.type = _JOINT_TYPES[joint.type]
        if joint.is_movable:
            snapshot = self._robot.snapshot
            i = snapshot.joint_names.index(joint.name)
            response.damping = [joint.damping]
            response.position = [snapshot.position[i]]
            response.rate = [snapshot.velocity[i]]
        return _SUCCESS

    def _fill(
        self, message: Message, state: WorldState, motion: FrameMotion, frame: str
    ) -> None:
        seen = motion.relative_to(state.frame(frame))
        message.pose = pose_message(seen.pose)
        message.twist = twist_message(seen)


@final
class GazeboStatePublisher:
    """Topics ``model_states`` and ``link_states``, published for every snapshot."""

    def __init__(self, ros: RosNamespace, world: GazeboWorld) -> None:
        self._world = world
        self._topics = [
            (ros.publisher(f"{NODE_NAME}/{name}", kind), motions_of)
            for name, kind, motions_of in (
                ("model_states", msg.ModelStates, WorldState.models),
                ("link_states", msg.LinkStates, WorldState.links),
            )
        ]

    def publish(self, snapshot: Snapshot) -> None:
        state = WorldState(self._world, snapshot)
        for publisher, motions_of in self._topics:
            if publisher.get_num_connections():
                motions = motions_of(state)
                publisher.publish(
                    name=list(motions),
                    pose=[pose_message(motion.pose) for motion in motions.values()],
                    twist=[twist_message(motion) for motion in motions.values()],
                )

    def close(self) -> None:
        for publisher, _ in self._topics:
            publisher.unregister()
