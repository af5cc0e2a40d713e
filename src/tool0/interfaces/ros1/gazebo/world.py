"""The world as Gazebo names it: models, each with links, seen from the world."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import final

from tool0.api.robot import Robot
from tool0.description.forward_kinematics import FrameMotion, link_motions
from tool0.description.model import Joint, RobotModel
from tool0.description.rigid_model import RigidModel
from tool0.description.scene import SceneObject
from tool0.description.transform import Transform, from_quaternion
from tool0.errors import ControlError
from tool0.sensing.snapshot import Snapshot

ROBOT = "robot"
"""What the launch files of ur_gazebo call the robot's model."""
GROUND = "ground_plane"
_GAZEBOS_OWN = ("collision", "link", "sun", "visual")
_BETWEEN = "::"
_WORLD = ("", "world", "map", "/map")
_STILL = FrameMotion()


@final
class GazeboWorld:
    """What stays the same of the world, and what objects were made of."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self.model = model = robot.description.model
        self.T_world_root = Transform(position=(0.0, 0.0, robot.info.spawn_z))
        self.has_ground = robot.info.ground is not None
        self.robot_names = (ROBOT, model.name)
        self.robot_links = lumped_links(model)
        self.reserved = {*_GAZEBOS_OWN, *model.joint_by_name}
        """Names that Gazebo gives to no second thing, of whatever kind."""
        self._made_of: dict[str, tuple[SceneObject, RigidModel]] = {}

    def remember(self, item: SceneObject, model: RigidModel) -> None:
        """Note what an object was made of."""
        alive = {name.name: name for name in self._robot.scene.objects}
        self._made_of = {
            name: (known, made_of)
            for name, (known, made_of) in self._made_of.items()
            if alive.get(name) is known
        } | {item.name: (item, model)}

    def made_of(self, item: SceneObject) -> RigidModel:
        """Return what an object was made of, whoever put it there."""
        known, model = self._made_of.get(item.name, (None, None))
        if model is not None and known is item:
            return model
        return RigidModel(
            name=item.name,
            geometry=item.geometry,
            mass=item.mass,
            friction=item.friction,
            rgba=item.rgba,
        )

    def now(self) -> WorldView:
        """Return how the world is."""
        return WorldView(self, self._robot.snapshot)

    def is_robot(self, name: str) -> bool:
        return name in self.robot_names

    def joint(self, name: str) -> Joint | None:
        """Return a joint of the robot, with or without the model's name before it."""
        model, between, joint = name.rpartition(_BETWEEN)
        if between and not self.is_robot(model):
            return None
        return self.model.joint_by_name.get(joint)


@final
class WorldView:
    """Where everything is at one instant, and how it moves, in the world."""

    def __init__(self, world: GazeboWorld, snapshot: Snapshot) -> None:
        self._world = world
        self.snapshot = snapshot

    @cached_property
    def objects(self) -> Mapping[str, tuple[SceneObject, RigidModel, FrameMotion]]:
        """What is around the robot, with the motion of its model's frame."""
        found = {}
        items, states = self.snapshot.scene, self.snapshot.objects
        for item, state in zip(items, states, strict=True):
            model = self._world.made_of(item)
            shape = FrameMotion(
                pose=from_quaternion(state.position, state.quat_wxyz),
                linear=state.linear,
                angular=state.angular,
            ).placed_in(self._world.T_world_root)
            found[item.name] = (
                item,
                model,
                shape.carry(model.T_model_shape.inverse()),
            )
        return found

    @cached_property
    def _in_root(self) -> Mapping[str, FrameMotion]:
        """All links of the robot, those of no mass included, in its root."""
        snapshot = self.snapshot
        names = snapshot.joint_names
        return link_motions(
            self._world.model,
            dict(zip(names, snapshot.position, strict=True)),
            dict(zip(names, snapshot.velocity, strict=True)),
        )

    def _robot_link(self, name: str) -> FrameMotion | None:
        motion = self._in_root.get(name)
        return None if motion is None else motion.placed_in(self._world.T_world_root)

    def models(self) -> dict[str, FrameMotion]:
        """Return every model, in the order in which Gazebo would have got them."""
        found = {GROUND: _STILL} if self._world.has_ground else {}
        found[ROBOT] = FrameMotion(pose=self._world.T_world_root)
        for name, (_, _, motion) in self.objects.items():
            found.setdefault(name, motion)
        return found

    def links(self) -> dict[str, FrameMotion]:
        """Return the links that Gazebo would have, by their full names."""
        found = {f"{GROUND}::link": _STILL} if self._world.has_ground else {}
        for link in self._world.robot_links:
            motion = self._in_root[link].placed_in(self._world.T_world_root)
            found[f"{ROBOT}::{link}"] = motion
        for name, (_, model, motion) in self.objects.items():
            found[f"{name}::{model.link}"] = motion.carry(model.T_model_link)
        return found

    def model(self, name: str) -> FrameMotion | None:
        """Return the model called ``name``."""
        return self.models().get(ROBOT if self._world.is_robot(name) else name)

    def link(self, name: str) -> FrameMotion | None:
        """Return a link: of the robot with or without its name before it."""
        model, between, link = name.rpartition(_BETWEEN)
        if not between or self._world.is_robot(model):
            return self._robot_link(link)
        return self.links().get(name)

    def frame(self, name: str) -> FrameMotion:
        """Return what poses may refer to: the world, a link or a model.

        Raises:
            ControlError: If there is none of this name.
        """
        if name in _WORLD:
            return _STILL
        found = self.link(name) or self.model(name)
        if found is None:
            raise ControlError(
                f"reference frame '{name}' not found; write world, a model, or a link "
                "as MODEL::LINK"
            )
        return found


def lumped_links(model: RobotModel) -> tuple[str, ...]:
    """Return the links that Gazebo keeps: fixed ones go into those they sit on."""
    root = model.root
    if root == "world" and model.child_joints[root]:
        fixed = [joint for joint in model.child_joints[root] if not joint.is_movable]
        first = tuple(joint.child for joint in fixed)
    else:
        first = (root,)
    return first + tuple(joint.child for joint in model.movable_joints)
