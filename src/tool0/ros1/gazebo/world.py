"""The world as Gazebo represents it: models with links, in the world frame."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import final

from tool0.api.robot import Robot
from tool0.description.forward_kinematics import FrameMotion, link_motions
from tool0.description.model import Joint, RobotModel
from tool0.description.rigid_model import RigidModel, read_rigid_model
from tool0.description.scene import SceneObject
from tool0.description.shapes import geometry_names
from tool0.description.transform import Transform, from_quaternion
from tool0.errors import ControlError, did_you_mean
from tool0.protocol.objects import ApplyWrench
from tool0.protocol.state import Snapshot
from tool0.ros1.messages import Message, to_motion, to_transform, to_vector

ROBOT = "robot"
"""Name of the robot's model in the launch files of ur_gazebo."""
GROUND = "ground_plane"
_RESERVED = ("collision", "link", "sun", "visual")
"""Names that Gazebo reserves."""
MAX_NAME_LENGTH = 60
"""Largest length of a name [characters].  The length is limited because the Gazebo
engine uses names as file names."""
_WORLD = ("", "world", "map", "/map")
_AT_ORIGIN = FrameMotion()


@final
class GazeboWorld:
    """The constant part of the world, and the models of spawned objects."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self.model = model = robot.description.model
        self.T_world_root = Transform(position=(0.0, 0.0, robot.info.spawn_z))
        self.has_ground = robot.info.ground is not None
        self.robot_links = lumped_links(model)
        self.reserved = {*_RESERVED, *model.joint_by_name}
        """Names that no model may have."""
        self._spawned: dict[str, tuple[SceneObject, RigidModel]] = {}

    def record_model(self, item: SceneObject, model: RigidModel) -> None:
        """Record a spawned object's model, and drop records of removed objects."""
        present = {item.name: item for item in self._robot.scene.objects}
        self._spawned = {
            name: (known, spawned)
            for name, (known, spawned) in self._spawned.items()
            if present.get(name) is known
        } | {item.name: (item, model)}

    def model_of(self, item: SceneObject) -> RigidModel:
        """Return the model of an object, whether it was spawned or not."""
        known, model = self._spawned.get(item.name, (None, None))
        if model is not None and known is item:
            return model
        return RigidModel(
            name=item.name,
            geometry=item.geometry,
            collisions=geometry_names("collision", item.geometry),
            mass=item.mass,
            friction=item.friction,
            rgba=item.rgba,
        )

    def now(self) -> WorldState:
        """Return the newest state of the world."""
        return WorldState(self, self._robot.snapshot)

    def is_robot(self, name: str) -> bool:
        return name in (ROBOT, self.model.name)

    def joint(self, name: str) -> Joint | None:
        """Return the robot's joint ``name``.  The name may include the model's name."""
        model, separator, joint = name.rpartition("::")
        if separator and not self.is_robot(model):
            return None
        return self.model.joint_by_name.get(joint)


@final
class WorldState:
    """Poses and velocities of all models and links at one instant."""

    def __init__(self, world: GazeboWorld, snapshot: Snapshot) -> None:
        self._world = world
        self.snapshot = snapshot

    @cached_property
    def objects(self) -> Mapping[str, tuple[SceneObject, RigidModel, FrameMotion]]:
        """The objects around the robot, including their models and motions."""
        found = {}
        items, states = self.snapshot.scene, self.snapshot.objects
        for item, state in zip(items, states, strict=True):
            model = self._world.model_of(item)
            shape = FrameMotion(
                pose=from_quaternion(state.position, state.quat_wxyz),
                linear=state.linear,
                angular=state.angular,
            ).placed_in(self._world.T_world_root)
            found[item.name] = item, model, shape.carry(model.T_model_shape.inverse())
        return found

    @cached_property
    def _robot_links(self) -> Mapping[str, FrameMotion]:
        """All links of the robot, including links without mass."""
        names = self.snapshot.joint_names
        in_root = link_motions(
            self._world.model,
            dict(zip(names, self.snapshot.position, strict=True)),
            dict(zip(names, self.snapshot.velocity, strict=True)),
        )
        T_world_root = self._world.T_world_root
        return {link: in_root[link].placed_in(T_world_root) for link in in_root}

    def models(self) -> dict[str, FrameMotion]:
        """Return all models, in the order in which Gazebo adds them."""
        found = {GROUND: _AT_ORIGIN} if self._world.has_ground else {}
        found[ROBOT] = FrameMotion(pose=self._world.T_world_root)
        for name, (_, _, motion) in self.objects.items():
            found.setdefault(name, motion)
        return found

    def links(self) -> dict[str, FrameMotion]:
        """Return the links that exist in Gazebo, by their full names."""
        found = {f"{GROUND}::link": _AT_ORIGIN} if self._world.has_ground else {}
        for link in self._world.robot_links:
            found[f"{ROBOT}::{link}"] = self._robot_links[link]
        for name, (_, model, motion) in self.objects.items():
            found[f"{name}::{model.link}"] = motion.carry(model.T_model_link)
        return found

    def model(self, name: str) -> FrameMotion | None:
        """Return the model named ``name``; None if there is none."""
        return self.models().get(ROBOT if self._world.is_robot(name) else name)

    def link(self, name: str) -> FrameMotion | None:
        """Return a link; names of the robot's links need not contain a model name."""
        model, separator, link = name.rpartition("::")
        if not separator or self._world.is_robot(model):
            return self._robot_links.get(link)
        return self.links().get(name)

    def body(self, name: str) -> str:
        """Return the robot's link ``name``, or the object that has this link.

        Raises:
            ControlError: If neither the robot nor an object has this link.
        """
        model, separator, link = name.rpartition("::")
        if not separator or self._world.is_robot(model):
            if link in self._robot_links:
                return link
        elif model in self.objects and self.objects[model][1].link == link:
            return model
        raise ControlError(
            f"there is no body '{name}'; write MODEL::LINK"
            + did_you_mean(name, list(self.links()))
        )

    def frame(self, name: str) -> FrameMotion:
        """Return a reference frame, which is the world, a link or a model.

        Raises:
            ControlError: If there is no frame of this name.
        """
        if name in _WORLD:
            return _AT_ORIGIN
        found = self.link(name) or self.model(name)
        if found is None:
            raise ControlError(
                f"reference frame '{name}' not found; write world, a model, or a link "
                "as MODEL::LINK"
            )
        return found


def lumped_links(model: RobotModel) -> tuple[str, ...]:
    """Return the links that Gazebo does not merge into a parent link.

    Gazebo merges a link into its parent if the joint between them is fixed.
    """
    root = model.root
    if root == "world" and model.child_joints[root]:
        fixed = [joint for joint in model.child_joints[root] if not joint.is_movable]
        first = tuple(joint.child for joint in fixed)
    else:
        first = (root,)
    return first + tuple(joint.child for joint in model.movable_joints)


@final
class GazeboChanges:
    """Handlers that either execute a request or raise a Tool0Error.

    After a Tool0Error, nothing has changed.
    """

    def __init__(
        self,
        robot: Robot,
        world: GazeboWorld,
        to_simulated: Callable[[Message], float | None],
    ) -> None:
        """Create handlers.

        ``to_simulated`` converts a ROS time to simulated time [s].
        """
        self._robot, self._world, self._to_simulated = robot, world, to_simulated

    def spawn_model(self, request: Message, response: Message) -> str:
        state, name = self._world.now(), request.model_name
        if state.model(name) is not None:
            raise ControlError(f"Failure - model name {name} already exist.")
        if name in self._world.reserved or len(name) > MAX_NAME_LENGTH:
            raise ControlError(
                f"Failure - '{name[:MAX_NAME_LENGTH]}' is reserved by Gazebo, or "
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
        """Set an object's pose and velocity to those in a gazebo_msgs/ModelState."""
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

    def apply_body_wrench(self, request: Message, response: Message) -> str:
        """Apply a wrench to a link for a duration in ROS time.

        If the duration is negative, the wrench has no end.

        The force acts at the reference point.  If there is no reference frame, the
        force acts at the center of mass, as in gazebo_ros.
        """
        duration = request.duration.to_sec()
        if duration == 0.0:
            return "a duration of 0 does nothing; use a positive one, or -1 for no end"
        state, frame = self._world.now(), request.reference_frame
        T_root_frame = self._world.T_world_root.inverse() @ state.frame(frame).pose
        point = T_root_frame.apply(to_vector("point", request.reference_point))
        start = self._to_simulated(request.start_time)
        self._robot.channel.call(
            ApplyWrench(
                name=state.body(request.body_name),
                force=T_root_frame.rotate(to_vector("force", request.wrench.force)),
                torque=T_root_frame.rotate(to_vector("torque", request.wrench.torque)),
                point=None if frame in _WORLD else point,
                start=max(0.0, start or 0.0),
                duration=duration if duration > 0.0 else None,
            )
        )
        return "wrench applied"

    def clear_body_wrenches(self, name: str) -> None:
        """End all wrenches on a link."""
        self._robot.clear_wrenches(self._world.now().body(name))

    def set_model_configuration(self, request: Message, response: Message) -> str:
        """Set the positions of the robot's joints immediately.

        The objects do not change.
        """
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
        positions = dict(zip(names, request.joint_positions, strict=True))
        robot = self._robot
        was_paused = robot.snapshot.is_paused
        robot.pause()
        try:
            snapshot = robot.snapshot
            mimics = {j.name for j in self._world.model.movable_joints if j.mimic}
            by_name = self._world.model.joint_by_name
            present = {
                name: by_name[name].limits.clamp(position)
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
                    allow_penetration=True,  # the object's pose before the reset
                )
        finally:
            if not was_paused:
                robot.resume()
        return "success"

    def _object(self, state: WorldState, name: str, verb: str) -> RigidModel:
        """Return the model of the object named ``name``, or raise ControlError."""
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
