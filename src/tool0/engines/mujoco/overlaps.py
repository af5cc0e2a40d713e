"""Overlaps of links with each other, the ground and objects in any pose.

MuJoCo's collision detection runs on a separate model without dynamics.  Therefore the
detection works with every engine and in any thread.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import final

import mujoco

from tool0.description.model import RobotModel
from tool0.description.scene import Scene, SceneObject
from tool0.description.scene_state import ObjectState
from tool0.description.transform import Transform, from_arrays
from tool0.engines.mujoco.model import build_spec
from tool0.engines.mujoco.objects import compile_with_scene, free_joint_name
from tool0.engines.mujoco.world import geom_owners

NEAR = 0.001
"""Distance below which pairs of shapes are reported even if they do not overlap [m].
Shapes that touch in one physics step can be micrometers apart in the next step."""

Pair = tuple[str, str]
"""The names of links, objects or the ground, in alphabetical order."""


@final
class OverlapFinder:
    """Model of the robot and objects.  Only one thread at a time may use the model."""

    def __init__(self, model: RobotModel, ground: float | None) -> None:
        """Use a ground at height ``ground`` [m] in the root; None means no ground."""
        self._robot = model
        self._spec = build_spec(model, dt=0.001, ground=ground)
        self._mesh_files: Mapping[str, bytes] = {}
        self._objects: tuple[SceneObject, ...] | None = None

    def use(self, objects: tuple[SceneObject, ...]) -> None:
        """Compile the objects, unless they are the same as in the last call.

        Raises:
            ModelError: If MuJoCo does not support an object.
        """
        if objects is self._objects or objects == self._objects:
            return
        self._model, self._mesh_files = compile_with_scene(
            self._spec.copy(), self._robot, Scene(objects), self._mesh_files
        )
        self._model.geom_margin[:] = self._model.pair_margin[:] = NEAR
        self._data = mujoco.MjData(self._model)
        self._owners = geom_owners(self._model)
        self._objects = objects
        joints = self._robot.movable_joints
        self._addresses = [
            int(self._model.joint(joint.name).qposadr[0]) for joint in joints
        ]

    def put_object(self, item: SceneObject, state: ObjectState) -> None:
        """Place one of the objects at the pose in ``state``."""
        pose = (*state.position, *state.quat_wxyz)
        if item.mass is None:
            body = self._model.body(item.name)
            body.pos[:], body.quat[:] = state.position, state.quat_wxyz
        else:
            self._data.joint(free_joint_name(item.name)).qpos[:] = pose

    def put_joints(self, position: Sequence[float]) -> None:
        """Move the joints to ``position`` [rad | m], in the model's order."""
        self._data.qpos[self._addresses] = position
        mujoco.mj_kinematics(self._model, self._data)

    def link_pose(self, link: str) -> Transform:
        """Return the pose of a link in the robot's root."""
        site = self._data.site(link)
        return from_arrays(site.xpos, site.xmat.reshape(3, 3))

    def depths(self) -> dict[Pair, float]:
        """Return the penetration depths [m] by pair.

        The depth is negative for a pair that is closer than ``NEAR`` but does not
        overlap.
        """
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_collision(self._model, self._data)
        contacts = self._data.contact
        found: dict[Pair, float] = {}
        for (one, two), distance in zip(
            contacts.geom.tolist(), contacts.dist.tolist(), strict=True
        ):
            first, second = sorted((self._owners[one], self._owners[two]))
            depth = found.get((first, second), -distance)
            found[first, second] = max(depth, -distance)
        return found
