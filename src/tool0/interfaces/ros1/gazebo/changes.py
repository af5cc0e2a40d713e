"""The services of gazebo_ros that change the world."""

from __future__ import annotations

from typing import final

from tool0.api.robot import Robot
from tool0.description.rigid_model import RigidModel, read_rigid_model
from tool0.errors import ControlError
from tool0.interfaces.ros1.gazebo.world import GROUND, GazeboWorld, WorldState
from tool0.interfaces.ros1.messages import Message, to_motion, to_transform

MAX_NAME_LENGTH = 60
"""[characters], since the Gazebo engine uses it as a file name."""


@final
class GazeboChanges:
    """Each carries out a request, or raises a Tool0Error and changes nothing."""

    def __init__(self, robot: Robot, world: GazeboWorld) -> None:
        self._robot, self._world = robot, world

    def spawn_model(self, request: Message, response: Message) -> str:
        state, name = self._world.now(), request.model_name
        if state.model(name) is not None:
            raise ControlError(f"Failure - model name {name} already exist.")
        if name in self._world.reserved or len(name) > MAX_NAME_LENGTH:
            raise ControlError(
                f"Failure - '{name[:MAX_NAME_LENGTH]}' is a name of Gazebo's own, or "
                f"longer than {MAX_NAME_LENGTH} characters; choose another"
            )
        T_world_frame = state.frame(request.reference_frame).pose
        T_frame_model = to_transform(request.initial_pose)
        model = read_rigid_model(request.model_xml)
        T_world_model = T_world_frame @ T_frame_model @ model.placement
        T_root_model = self._world.T_world_root.inverse() @ T_world_model
        item = self._robot.scene.add(model.scene_object(name, T_root_model))
        self._world.record_model(item, model)
        return "Successfully spawned entity"

    def delete_model(self, request: Message, response: Message) -> str:
        self._object(self._world.now(), request.model_name, "removed")
        self._robot.scene.remove(request.model_name)
        return "successfully deleted model"

    def set_model_state(self, request: Message, response: Message) -> str:
        self.place(request.model_state)
        return "set model state done"

    def place(self, state: Message) -> None:
        """Give an object pose and velocity of a gazebo_msgs/ModelState."""
        now, name = self._world.now(), state.model_name
        model = self._object(now, name, "moved")
        T_world_frame = now.frame(state.reference_frame).pose
        motion = to_motion(state.pose, state.twist).placed_in(T_world_frame)
        T_root_world = self._world.T_world_root.inverse()
        shape = motion.carry(model.T_model_shape).placed_in(T_root_world)
        self._robot.scene.place(
            name,
            shape.pose.position,
            shape.pose.quat_wxyz,
            linear=shape.linear,
            angular=shape.angular,
        )

    def set_model_configuration(self, request: Message, response: Message) -> str:
        """Set positions of the robot's joints at once; all else stays as it is."""
        name, joints = request.model_name, request.joint_names
        if self._world.now().model(name) is None:
            raise ControlError(f"model [{name}] does not exist")
        if len(joints) != len(request.joint_positions):
            raise ControlError("joint name and position list have different lengths")
        if not joints:
            return "success"
        if not self._world.is_robot(name):
            raise ControlError(f"model [{name}] has no joints")
        names = (joint.rpartition("::")[2] for joint in joints)
        self._teleport(dict(zip(names, request.joint_positions, strict=True)))
        return "success"

    def _teleport(self, positions: dict[str, float]) -> None:
        """Reset to the present state, with some joints at ``positions`` [rad | m]."""
        robot = self._robot
        was_paused = robot.snapshot.is_paused
        robot.pause()
        try:
            snapshot = robot.snapshot
            mimics = {j.name for j in self._world.model.movable_joints if j.mimic}
            joints = self._world.model.joint_by_name
            present = {
                name: joints[name].limits.clamp(position)
                for name, position in zip(
                    snapshot.joint_names, snapshot.position, strict=True
                )
                if name not in mimics
            }
            robot.reset({**present, **positions}, keep_time=True)
            for state in snapshot.objects:
                robot.scene.place(
                    state.name,
                    state.position,
                    state.quat_wxyz,
                    linear=state.linear,
                    angular=state.angular,
                )
        finally:
            if not was_paused:
                robot.resume()

    def _object(self, state: WorldState, name: str, verb: str) -> RigidModel:
        """Return the model of the object ``name``, or raise ControlError."""
        if self._world.is_robot(name):
            raise ControlError(
                f"'{name}' is the robot, which is bolted to the world and cannot be "
                f"{verb}; set_model_configuration moves its joints"
            )
        if name == GROUND and self._world.has_ground:
            raise ControlError(f"the ground cannot be {verb}")
        if name not in state.objects:
            raise ControlError("model does not exist")
        return state.objects[name][1]
