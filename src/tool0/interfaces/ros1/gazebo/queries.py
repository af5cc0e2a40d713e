"""The services of gazebo_ros that tell how the world is."""

from __future__ import annotations

from typing import Any, final

from tool0.api.robot import Robot
from tool0.description.forward_kinematics import FrameMotion
from tool0.description.model import JointType
from tool0.errors import ControlError
from tool0.interfaces.ros1.conversions import Message
from tool0.interfaces.ros1.gazebo.messages import GazeboMessages
from tool0.interfaces.ros1.gazebo.world import GROUND, GazeboWorld, WorldView
from tool0.interfaces.ros1.node import RosNode

_KINDS = {
    JointType.REVOLUTE: 0,
    JointType.CONTINUOUS: 1,
    JointType.PRISMATIC: 2,
    JointType.FIXED: 3,
}
"""gazebo_msgs/GetJointProperties; gazebo_ros itself calls every joint revolute."""
_DONE = "got properties"


@final
class GazeboQueries:
    """Answers in the words of gazebo_ros; each raises ControlError for a refusal."""

    def __init__(self, node: RosNode, robot: Robot, world: GazeboWorld) -> None:
        from geometry_msgs.msg import Vector3

        self._node, self._robot, self._world = node, robot, world
        self._messages = GazeboMessages()
        self._vector = Vector3

    def world_properties(self, request: Message, answer: Message) -> str:
        view = self._world.now()
        answer.sim_time = self._node.time.to_ros(view.snapshot.time).to_sec()
        answer.model_names = list(view.models())
        answer.rendering_enabled = True
        return _DONE

    def physics_properties(self, request: Message, answer: Message) -> str:
        """Tell of the step; the figures of a solver are left at zero."""
        snapshot, dt = self._robot.snapshot, self._robot.engine.dt
        answer.time_step = dt
        answer.pause = snapshot.is_paused
        answer.max_update_rate = 0.0 if snapshot.speed is None else snapshot.speed / dt
        answer.gravity = self._vector(*self._robot.engine.world.gravity)
        return _DONE

    def model_properties(self, request: Message, answer: Message) -> str:
        name, view = request.model_name, self._world.now()
        if self._world.is_robot(name):
            model = self._world.model
            answer.body_names = list(self._world.robot_links)
            answer.geom_names = [
                f"{link.name}_collision" for link in model.links if link.collisions
            ]
            answer.joint_names = [joint.name for joint in model.movable_joints]
        elif name in view.objects:
            item, made_of, _ = view.objects[name]
            answer.body_names, answer.geom_names = [made_of.link], [made_of.collision]
            answer.is_static = item.mass is None
        elif name == GROUND and self._world.has_ground:
            answer.body_names, answer.geom_names = ["link"], ["collision"]
            answer.is_static = True
        else:
            raise ControlError("model does not exist")
        answer.canonical_body_name = answer.body_names[0]
        return _DONE

    def model_state(self, request: Message, answer: Message) -> str:
        view = self._world.now()
        motion = view.model(request.model_name)
        if motion is None:
            raise ControlError("model does not exist")
        self._fill(answer, view, motion, request.relative_entity_name)
        answer.header = self._node.header(view.snapshot.time)
        answer.header.frame_id = request.relative_entity_name
        return _DONE

    def link_state(self, request: Message, answer: Message) -> str:
        view = self._world.now()
        motion = view.link(request.link_name)
        if motion is None:
            raise ControlError(
                "link not found, did you forget to scope the link by model name?"
            )
        state = answer.link_state
        self._fill(state, view, motion, request.reference_frame)
        state.link_name = request.link_name
        state.reference_frame = request.reference_frame
        return "got state"

    def joint_properties(self, request: Message, answer: Message) -> str:
        joint = self._world.joint(request.joint_name)
        if joint is None or joint.type not in _KINDS:
            raise ControlError("joint not found")
        answer.type = _KINDS[joint.type]
        if joint.is_movable:
            snapshot = self._robot.snapshot
            i = snapshot.joint_names.index(joint.name)
            answer.damping = [joint.damping]
            answer.position = [snapshot.position[i]]
            answer.rate = [snapshot.velocity[i]]
        return _DONE

    def _fill(
        self, state: Any, view: WorldView, motion: FrameMotion, frame: str
    ) -> None:
        seen = motion.seen_from(view.frame(frame))
        state.pose = self._messages.pose(seen.pose)
        state.twist = self._messages.twist(seen)
