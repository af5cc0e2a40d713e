"""The services of gazebo_ros that change the world."""

from __future__ import annotations

from typing import final

from tool0.api.robot import Robot
from tool0.description.rigid_model import RigidModel, read_rigid_model
from tool0.errors import ControlError
from tool0.interfaces.ros1.conversions import Message
from tool0.interfaces.ros1.gazebo.messages import to_motion, to_transform
from tool0.interfaces.ros1.gazebo.world import GROUND, GazeboWorld, WorldView

LONGEST_NAME = 60
"""[characters] Gazebo's engine makes it a file's name."""


@final
class GazeboChanges:
    """Carries out what is asked, or raises a Tool0Error and changes nothing."""

    def __init__(self, robot: Robot, world: GazeboWorld) -> None:
        self._robot, self._world = robot, world

    def spawn(self, request: Message, answer: Message) -> str:
        view, name = self._world.now(), request.model_name
        if view.model(name) is not None:
            raise ControlError(f"Failure - model name {name} already exist.")
        if name in self._world.reserved or len(name) > LONGEST_NAME:
            raise ControlError(
                f"Failure - '{name[:LONGEST_NAME]}' is the name of a part of Gazebo's "
                f"world, or longer than {LONGEST_NAME} characters; choose another"
            )
        T_world_frame = view.frame(request.reference_frame).pose
        asked = to_transform(request.initial_pose)
        made_of = read_rigid_model(request.model_xml)
        T_world_model = T_world_frame @ asked @ made_of.placement
        T_root_model = self._world.T_world_root.inverse() @ T_world_model
        item = made_of.scene_object(name, T_root_model)
        self._robot.scene.add(item)
        self._world.remember(item, made_of)
        return "Successfully spawned entity"

    def delete(self, request: Message, answer: Message) -> str:
        self._object(self._world.now(), request.model_name, "taken away")
        self._robot.scene.remove(request.model_name)
        return "successfully deleted model"

    def set_model_state(self, request: Message, answer: Message) -> str:
        self.place(request.model_state)
        return "set model state done"

    def place(self, state: Message) -> None:
        """Put an object where a gazebo_msgs/ModelState says, moving so."""
        view, name = self._world.now(), state.model_name
        made_of = self._object(view, name, "put elsewhere")
        frame = view.frame(state.reference_frame).pose
        asked = to_motion(state.pose, state.twist).placed_in(frame)
        T_root_world = self._world.T_world_root.inverse()
        shape = asked.carry(made_of.T_model_shape).placed_in(T_root_world)
        self._robot.scene.place(
            name,
            shape.pose.position,
            shape.pose.quat_wxyz,
            linear=shape.linear,
            angular=shape.angular,
        )

    def set_model_configuration(self, request: Message, answer: Message) -> str:
        """Put joints of the robot somewhere at once; all else stays as it is."""
        name, joints = request.model_name, request.joint_names
        if self._world.now().model(name) is None:
            raise ControlError(f"model [{name}] does not exist")
        if len(joints) != len(request.joint_positions):
            raise ControlError("joint name and position list have different lengths")
        if not joints:
            return "success"
        if not self._world.is_robot(name):
            raise ControlError(f"model [{name}] has no joints")
        asked = dict(zip(joints, request.joint_positions, strict=True))
        self._teleport({joint.rpartition("::")[2]: asked[joint] for joint in asked})
        return "success"

    def _teleport(self, asked: dict[str, float]) -> None:
        """Reset the robot to where it is, but for ``asked``; and objects to theirs."""
        robot = self._robot
        was_paused = robot.snapshot.is_paused
        robot.pause()
        try:
            snapshot = robot.snapshot
            mimics = {j.name for j in self._world.model.movable_joints if j.mimic}
            limits = self._world.model.joint_by_name
            here = {
                name: limits[name].limits.clamp(position)
                for name, position in zip(
                    snapshot.joint_names, snapshot.position, strict=True
                )
                if name not in mimics
            }
            robot.reset({**here, **asked}, keep_time=True)
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

    def _object(self, view: WorldView, name: str, verb: str) -> RigidModel:
        """Return what the object ``name`` was made of, or raise ControlError."""
        if self._world.is_robot(name):
            raise ControlError(
                f"'{name}' is the robot, which is bolted to the world and cannot be "
                f"{verb}; set_model_configuration moves its joints"
            )
        if name == GROUND and self._world.has_ground:
            raise ControlError(f"the ground cannot be {verb}")
        if name not in view.objects:
            raise ControlError("model does not exist")
        return view.objects[name][1]
