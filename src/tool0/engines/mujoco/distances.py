"""Distances between a robot, the objects around it and the objects in its gripper.

Distances are measured in a separate model without dynamics.  Therefore the measurement
works with every engine and in any thread.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, final

import mujoco
import numpy as np

from tool0.description.bodies import moving_bodies
from tool0.description.model import RobotModel
from tool0.description.scene import Scene, SceneObject
from tool0.description.scene_state import ObjectState
from tool0.description.surroundings import HeldObject, Plane
from tool0.engines.mujoco.library import address_of, mujoco_library
from tool0.engines.mujoco.model import build_spec
from tool0.engines.mujoco.objects import add_shapes, compile_with_scene
from tool0.engines.mujoco.world import geom_owners
from tool0.errors import ModelError
from tool0.hardware.shape_memory import FloatArray, ShapeMemory


@final
class Shape(NamedTuple):
    """One shape for which distances to other shapes are measured."""

    geom: int
    owner: str
    """Name of the link, object or plane that contains the shape, or ``ground``."""
    body: int
    """Number of the body that moves the shape."""


@final
class DistanceModel:
    """Model with the compiled shapes.  Only one thread at a time may use the model."""

    def __init__(
        self,
        robot: RobotModel,
        ground: float | None,
        *,
        objects: Sequence[SceneObject] = (),
        held: Sequence[HeldObject] = (),
        planes: Sequence[Plane] = (),
    ) -> None:
        """Compile the shapes.

        Args:
            robot: The robot with its links.
            ground: Height of the ground in the robot's root [m]; None means no ground.
            objects: Objects around the robot.  ``place`` sets the poses of these
                objects.
            held: Objects that the robot carries.
            planes: Planes that bound the workspace.

        Raises:
            ModelError: If MuJoCo does not support a shape.
        """
        spec = build_spec(robot, dt=0.001, ground=ground)
        places = {
            name: (body, frame)
            for body in moving_bodies(robot)
            for name, frame in body.links
        }
        for load in held:
            body, frame = places[load.link]
            handle = spec.body(body.joint.child)
            add_shapes(spec, handle, load.item, frame @ load.T_link_item.matrix)
        for plane in planes:
            quat = np.empty(4)
            normal = np.array(plane.normal) / np.linalg.norm(plane.normal)
            mujoco.mju_quatZ2Vec(quat, normal)
            spec.worldbody.add_geom(
                name=plane.name,
                pos=plane.point,
                quat=quat,
                type=mujoco.mjtGeom.mjGEOM_PLANE,
                size=[0.0, 0.0, 0.05],
            )
        still = tuple(replace(item, mass=None) for item in objects)
        self.model, _ = compile_with_scene(spec, robot, Scene(still), {})
        self.data = mujoco.MjData(self.model)
        joints = robot.movable_joints
        self._addresses = {
            joint.name: int(self.model.joint(joint.name).qposadr[0]) for joint in joints
        }
        owners = geom_owners(self.model)
        self.shapes = tuple(
            Shape(k, owners[k], int(self.model.geom_bodyid[k]))
            for k in range(self.model.ngeom)
        )

    def place(self, states: Iterable[ObjectState]) -> None:
        """Place the objects at the poses in ``states``."""
        for state in states:
            body = self.model.body(state.name)
            body.pos[:], body.quat[:] = state.position, state.quat_wxyz

    def put(self, positions: Mapping[str, float]) -> None:
        """Move the joints to ``positions`` [rad | m]."""
        for name, position in positions.items():
            self.data.qpos[self._addresses[name]] = position
        mujoco.mj_kinematics(self.model, self.data)

    def overlapping(
        self, links: Collection[str], positions: Mapping[str, float]
    ) -> frozenset[frozenset[str]]:
        """Return the pairs of links that overlap at joint positions [rad | m]."""
        before = self.data.qpos.copy()
        self.put(positions)
        mine = [shape for shape in self.shapes if shape.owner in links]
        found = frozenset(
            frozenset((one.owner, two.owner))
            for one, two in itertools.combinations(mine, 2)
            if one.owner != two.owner and self._is_overlap(one.geom, two.geom)
        )
        self.data.qpos[:] = before
        mujoco.mj_kinematics(self.model, self.data)
        return found

    def _is_overlap(self, one: int, two: int) -> bool:
        model, data = self.model, self.data
        apart = np.linalg.norm(data.geom_xpos[one] - data.geom_xpos[two])
        if apart > model.geom_rbound[one] + model.geom_rbound[two]:
            return False
        ends = np.empty(6)
        return bool(mujoco.mj_geomDistance(model, data, one, two, 1e-6, ends) < 0.0)

    def addresses(self, joints: Sequence[str]) -> Any:
        """Return the indices of the joints' positions in ``qpos``, shape (n,)."""
        return np.array([self._addresses[name] for name in joints], dtype=np.int32)

    def axis_rows(self, joints: Sequence[str]) -> Any:
        """Return the rows of the joints in ``ShapeMemory.axes``, shape (n,)."""
        return np.array([self.model.joint(name).id for name in joints], dtype=np.int32)

    def body_of(self, link: str) -> int:
        """Return the number of the body that contains a link."""
        return int(self.model.site(link).bodyid[0])

    def rotation_in_body(self, link: str) -> FloatArray:
        """Return the rotation of a link in its body, shape (3, 3)."""
        found = np.empty(9)
        mujoco.mju_quat2Mat(found, self.model.site_quat[self.model.site(link).id])
        return found.reshape(3, 3)

    def joints_above(self, body: int) -> Iterator[tuple[str, float]]:
        """Yield the joints that move a body, nearest first, with distance bounds.

        The bound [m] is an upper bound on the distance from the body's origin to the
        joint's axis.  The bound is valid for all positions of the joints between the
        joint and the body.
        """
        model, length = self.model, 0.0
        while body > 0:
            for k in range(model.body_jntnum[body]):
                joint = int(model.body_jntadr[body]) + k
                yield model.joint(joint).name, length
                if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE:
                    length += float(np.abs(model.jnt_range[joint]).max())
            length += float(np.linalg.norm(model.body_pos[body]))
            body = int(model.body_parentid[body])

    def slides(self, joint: str) -> bool:
        """Return whether a joint is prismatic."""
        return bool(self.model.joint(joint).type[0] == mujoco.mjtJoint.mjJNT_SLIDE)

    def extent(self, shape: Shape) -> float:
        """Return a shape's largest distance from its body's origin [m]."""
        offset = float(np.linalg.norm(self.model.geom_pos[shape.geom]))
        return offset + float(self.model.geom_rbound[shape.geom])

    def is_plane(self, shape: Shape) -> bool:
        """Return whether a shape is a plane, such as the ground."""
        return bool(self.model.geom_type[shape.geom] == mujoco.mjtGeom.mjGEOM_PLANE)

    def size(self, shape: Shape) -> float:
        """Return the radius of a shape's bounding sphere [m]; infinite for a plane."""
        radius = float(self.model.geom_rbound[shape.geom])
        return math.inf if self.is_plane(shape) else radius

    def is_parallel(self, joint: str, plane: Shape) -> bool:
        """Return whether a joint's axis is now parallel to a plane's normal."""
        axis = self.data.xaxis[self.model.joint(joint).id]
        normal = self.data.geom_xmat[plane.geom].reshape(3, 3)[:, 2]
        return bool(np.linalg.norm(np.cross(axis, normal)) < 1e-9)

    def parent(self, body: int) -> int:
        """Return the number of a body's parent."""
        return int(self.model.body_parentid[body])

    def memory(self) -> ShapeMemory:
        """Return the memory of the shapes, for compiled code.

        Raises:
            ModelError: If MuJoCo's library is not found.
        """
        library = mujoco_library()
        if library is None:
            raise ModelError("MuJoCo's library is not in its Python package")
        model, data = self.model, self.data
        return ShapeMemory(
            kinematics=address_of(library.mj_kinematics),
            distance=address_of(library.mj_geomDistance),
            model=model._address,
            data=data._address,
            position=data.qpos,
            centres=data.geom_xpos,
            rotations=data.geom_xmat,
            axes=data.xaxis,
            anchors=data.xanchor,
            bodies=data.xmat,
            radii=model.geom_rbound,
            boxes=model.geom_aabb,
        )
