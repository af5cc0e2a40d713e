"""Rigid-body model of the robot: masses, gravity loads of joints, and mass matrix.

Fixed links are merged into their movable parent link.  Loads and the mass matrix are
computed without a physics engine: forward kinematics gives the body frames, and a
joint's load is a sum over the bodies that the joint moves.  The computation runs in
every tick, and plain floats make it faster than NumPy arrays would.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, final

import numpy as np

from tool0.description.flat_frames import FlatTree, Frame
from tool0.description.joint_tree import TreeJoint
from tool0.description.model import Inertial, Joint, JointType, RobotModel
from tool0.description.transform import Vector3, pose_matrix
from tool0.description.transform_arrays import turn_z_to
from tool0.errors import ModelError

Matrix = np.ndarray


@final
@dataclass(frozen=True, slots=True)
class BodyInertia:
    """Mass, center of mass (3,) and inertia about that center (3, 3), in one frame."""

    mass: float
    center: Matrix
    tensor: Matrix

    @staticmethod
    def of(inertial: Inertial, frame: Matrix) -> BodyInertia:
        """Return ``inertial`` in a frame in which its link has the pose ``frame``."""
        pose = frame @ pose_matrix(inertial.origin)
        i = inertial
        tensor = np.array(
            [[i.ixx, i.ixy, i.ixz], [i.ixy, i.iyy, i.iyz], [i.ixz, i.iyz, i.izz]]
        )
        rotation = pose[:3, :3]
        return BodyInertia(i.mass, pose[:3, 3], rotation @ tensor @ rotation.T)

    def moved(self, frame: Matrix) -> BodyInertia:
        """Return this inertia in the frame relative to which ``frame`` is given."""
        rotation = frame[:3, :3]
        center = rotation @ self.center + frame[:3, 3]
        return BodyInertia(self.mass, center, rotation @ self.tensor @ rotation.T)

    @staticmethod
    def total(parts: Sequence[BodyInertia]) -> BodyInertia:
        """Return the combined inertia of all parts (parallel-axis theorem)."""
        mass = sum(part.mass for part in parts)
        if mass == 0.0:
            return BodyInertia(0.0, np.zeros(3), np.zeros((3, 3)))
        center = sum((p.mass * p.center for p in parts), np.zeros(3)) / mass
        tensor = np.zeros((3, 3))
        for part in parts:
            offset = part.center - center
            tensor += part.tensor + part.mass * (
                offset @ offset * np.eye(3) - np.outer(offset, offset)
            )
        return BodyInertia(mass, center, tensor)


@final
@dataclass(frozen=True, slots=True)
class MovingBody:
    """A movable link and all links that are fixed to it."""

    joint: Joint
    parent: int
    """Index of the body that carries this body's joint; -1 denotes the world."""
    placement: Matrix
    """Frame of the joint in the parent body's frame, shape (4, 4)."""
    links: tuple[tuple[str, Matrix], ...]
    """Links of the body, and the frame of each link in the body's frame."""
    inertia: BodyInertia
    """Inertia in the frame of the joint's child link."""

    @property
    def tree_joint(self) -> TreeJoint:
        """The body's joint, for forward kinematics."""
        is_prismatic = self.joint.type is JointType.PRISMATIC
        return TreeJoint(self.parent, self.placement, self.joint.axis, is_prismatic)


def moving_bodies(model: RobotModel) -> tuple[MovingBody, ...]:
    """Return the bodies that move, in the order of ``model.movable_joints``."""
    index = {joint.name: i for i, joint in enumerate(model.movable_joints)}
    bodies = []
    for joint in model.movable_joints:
        if joint.type in (JointType.FLOATING, JointType.PLANAR):
            raise ModelError(
                f"joint '{joint.name}' is {joint.type.value}, which is not supported; "
                "use revolute, continuous, prismatic or fixed joints"
            )
        placement, link = pose_matrix(joint.origin), joint.parent
        while (above := model.parent_joint.get(link)) and not above.is_movable:
            placement, link = pose_matrix(above.origin) @ placement, above.parent
        links = tuple(_fixed_links(model, joint.child, np.eye(4)))
        bodies.append(
            MovingBody(
                joint=joint,
                parent=index[above.name] if above else -1,
                placement=placement,
                links=links,
                inertia=total_inertia(model, links),
            )
        )
    return tuple(bodies)


def with_added(
    bodies: Sequence[MovingBody], added: Mapping[str, Sequence[BodyInertia]]
) -> list[MovingBody]:
    """Return ``bodies`` with ``added`` inertias, which are given in the links' frames.

    Inertia added to a link that never moves has no effect.
    """
    found = []
    for body in bodies:
        parts = [
            part.moved(frame)
            for name, frame in body.links
            for part in added.get(name, ())
        ]
        total = BodyInertia.total([body.inertia, *parts]) if parts else body.inertia
        found.append(replace(body, inertia=total))
    return found


def total_inertia(
    model: RobotModel, links: Iterable[tuple[str, Matrix]]
) -> BodyInertia:
    """Return the total inertia of ``links``, which are given with their frames."""
    return BodyInertia.total(
        [
            BodyInertia.of(inertial, frame)
            for name, frame in links
            if (inertial := model.link_by_name[name].inertial) is not None
        ]
    )


def check_masses(model: RobotModel, bodies: Sequence[MovingBody]) -> None:
    """Raise ModelError if a body has no mass, since no engine can move such a body."""
    for body in bodies:
        if not body.inertia.mass > 0.0:
            joint = body.joint
            raise ModelError(
                f"link '{joint.child}' moves with joint '{joint.name}' but has no "
                "mass; give it an <inertial>",
                model.locations.get(f"link:{joint.child}"),
            )


def fixed_to_world(model: RobotModel) -> tuple[tuple[str, Matrix], ...]:
    """Return the links that never move, with their frames in the world."""
    return tuple(_fixed_links(model, model.root, np.eye(4)))


def _fixed_links(
    model: RobotModel, link: str, frame: Matrix
) -> list[tuple[str, Matrix]]:
    found = [(link, frame)]
    for joint in model.child_joints[link]:
        if not joint.is_movable:
            below = frame @ pose_matrix(joint.origin)
            found.extend(_fixed_links(model, joint.child, below))
    return found


ROTOR_INERTIA = 0.1
"""Inertia of an arm joint's rotor and gear, reflected to the joint [kg·m²].

Manufacturers do not publish this inertia.  The value is taken from MuJoCo's UR5e and
UR10e models
(https://github.com/google-deepmind/mujoco_menagerie/tree/main/universal_robots_ur5e).
"""
STANDARD_GRAVITY: Vector3 = (0.0, 0.0, -9.81)
"""Gravitational acceleration [m/s²].  The value is MuJoCo's default; Gazebo's default
is 9.8 m/s²."""


class DynamicBody(NamedTuple):
    """A moving body, in a frame that is rotated so that its joint acts along z."""

    parent: int
    """Index of the body that carries this body; -1 denotes the world."""
    is_prismatic: bool
    master: int
    """Index of the joint that this body's joint follows.  If this body's joint is not a
    mimic joint, the index is that of the joint itself."""
    multiplier: float
    """Ratio of the velocity of this body's joint to the velocity of the master
    joint."""
    placement: Frame
    """Frame of the joint in the parent body's frame."""
    mass: float
    center: Vector3
    tensor: tuple[float, ...]
    """Inertia tensor about the center of mass, as 9 numbers [kg·m²]."""
    armature: float
    """Rotor inertia reflected to the joint [kg·m² | kg]."""


class DynamicSpring(NamedTuple):
    """A spring in a joint."""

    joint: int
    master: int
    multiplier: float
    stiffness: float
    reference: float


class DynamicsTable(NamedTuple):
    """Constants with which ``JointDynamics`` computes."""

    gravity: float
    """Gravity vector [m/s²]."""
    bodies: tuple[DynamicBody, ...]
    springs: tuple[DynamicSpring, ...]


@final
class JointDynamics:
    """Gravity loads, spring loads and mass matrix of a robot.

    The load of a mimic joint is added to the load of its master joint.  Passive joints
    are treated as mimic joints, which is valid while nothing touches the linkage.
    """

    def __init__(
        self,
        model: RobotModel,
        gravity: Vector3 = STANDARD_GRAVITY,
        added: Mapping[str, Sequence[BodyInertia]] | None = None,
    ) -> None:
        """Read the model; ``gravity`` [m/s²] is in the axes of the model's root.

        ``added`` maps a link to additional inertia, given in that link's frame.
        """
        bodies = with_added(moving_bodies(model), added or {})
        self._n = len(bodies)
        self._gravity = math.hypot(*gravity)
        # In the rotated root, gravity points along -z.
        upright = _upright(gravity)
        index = {body.joint.name: i for i, body in enumerate(bodies)}
        self._masters = [_master(model, body.joint, index) for body in bodies]
        self._springs = [
            (i, *self._masters[i], spring.stiffness, spring.reference)
            for i, body in enumerate(bodies)
            if (spring := body.joint.spring) is not None
        ]
        self.armature = [
            transmission.armature if transmission else 0.0
            for body in bodies
            for transmission in [model.transmission_by_joint.get(body.joint.name)]
        ]
        """Rotor inertia reflected to each joint [kg·m² | kg]."""
        self._tree = FlatTree([body.tree_joint for body in bodies], upright)
        self._mass: list[float] = []
        self._center: list[tuple[float, float, float]] = []
        self.tensors: list[Matrix] = []
        """Inertia of each body about its center of mass, in the frame that ``frames``
        returns."""
        for body, turn in zip(bodies, self._tree.turns, strict=True):
            self._mass.append(body.inertia.mass)
            x, y, z = (turn.T @ body.inertia.center).tolist()
            self._center.append((x, y, z))
            self.tensors.append(turn.T @ body.inertia.tensor @ turn)
        self._flat_tensors = [tuple(each.ravel().tolist()) for each in self.tensors]

    @cached_property
    def table(self) -> DynamicsTable:
        """Constants for ``static_effort`` and ``mass_matrix``."""
        bodies = tuple(
            DynamicBody(parent, prismatic, *master, *constants)
            for parent, prismatic, master, *constants in zip(
                self._tree.parents,
                self._tree.is_prismatic,
                self._masters,
                self._tree.placements,
                self._mass,
                self._center,
                self._flat_tensors,
                self.armature,
                strict=True,
            )
        )
        springs = tuple(DynamicSpring(*spring) for spring in self._springs)
        return DynamicsTable(self._gravity, bodies, springs)

    def static_effort(self, position: Sequence[float]) -> list[float]:
        """Return the efforts that balance gravity and springs, shape (n_joints,).

        These efforts [N·m | N] keep the robot at rest.  ``position`` is in the order of
        the model's movable joints.
        """
        frames = self.frames(position)
        mass = self._mass.copy()
        moment_x = [0.0] * self._n  # sums of m·x and m·y beyond a joint [kg·m]
        moment_y = [0.0] * self._n
        for i, (frame, center) in enumerate(zip(frames, self._center, strict=True)):
            cx, cy, cz = center
            m = mass[i]
            moment_x[i] = m * (frame[0] * cx + frame[3] * cy + frame[6] * cz + frame[9])
            moment_y[i] = m * (
                frame[1] * cx + frame[4] * cy + frame[7] * cz + frame[10]
            )
        effort = [0.0] * self._n
        g = self._gravity
        parents, is_prismatic = self._tree.parents, self._tree.is_prismatic
        for i in range(self._n - 1, -1, -1):
            frame, parent = frames[i], parents[i]
            if is_prismatic[i]:
                load = g * mass[i] * frame[8]
            else:  # derivative of the height: z of (axis x lever)
                lever_x = moment_x[i] - mass[i] * frame[9]
                lever_y = moment_y[i] - mass[i] * frame[10]
                load = g * (frame[6] * lever_y - frame[7] * lever_x)
            master, multiplier = self._masters[i]
            effort[master] += multiplier * load
            if parent >= 0:
                mass[parent] += mass[i]
                moment_x[parent] += moment_x[i]
                moment_y[parent] += moment_y[i]
        for i, master, multiplier, stiffness, reference in self._springs:
            effort[master] += multiplier * stiffness * (position[i] - reference)
        return effort

    def mass_matrix(self, position: Sequence[float]) -> Matrix:
        """Return the mass matrix [kg·m² | kg], shape (n_joints, n_joints).

        The matrix is evaluated at ``position`` and includes the rotors' inertia.  The
        rows of mimic joints are 0.
        """
        # Composite-rigid-body algorithm with plain floats, as implemented by the kernel
        # in masses.c.
        frames = self.frames(position)
        carried = list(
            map(_about_root, frames, self._mass, self._center, self._flat_tensors)
        )
        matrix = [[0.0] * self._n for _ in frames]
        for i, armature in enumerate(self.armature):
            matrix[i][i] = armature
        parents = self._tree.parents
        for i in range(self._n - 1, -1, -1):
            momentum = self._momentum(i, frames[i], carried[i])
            master, multiplier = self._masters[i]
            joint = i
            while joint >= 0:
                value = self._along(joint, frames[joint], momentum)
                other, ratio = self._masters[joint]
                value = multiplier * ratio * value
                matrix[master][other] += value
                if joint != i:
                    matrix[other][master] += value
                joint = parents[joint]
            if parents[i] >= 0:
                together = zip(carried[parents[i]], carried[i], strict=True)
                carried[parents[i]] = [a + b for a, b in together]
        return np.array(matrix).reshape(self._n, self._n)

    def _momentum(
        self, joint: int, frame: Frame, carried: Sequence[float]
    ) -> Sequence[float]:
        """Return linear and angular momentum about the root at unit joint velocity."""
        m, hx, hy, hz, xx, xy, xz, yy, yz, zz = carried
        x, y, z, ox, oy, oz = frame[6:]
        if self._tree.is_prismatic[joint]:
            return (
                *(m * x, m * y, m * z),
                *(hy * z - hz * y, hz * x - hx * z, hx * y - hy * x),
            )
        vx, vy, vz = oy * z - oz * y, oz * x - ox * z, ox * y - oy * x
        return (
            m * vx + (y * hz - z * hy),
            m * vy + (z * hx - x * hz),
            m * vz + (x * hy - y * hx),
            (hy * vz - hz * vy) + (xx * x + xy * y + xz * z),
            (hz * vx - hx * vz) + (xy * x + yy * y + yz * z),
            (hx * vy - hy * vx) + (xz * x + yz * y + zz * z),
        )

    def _along(self, joint: int, frame: Frame, momentum: Sequence[float]) -> float:
        """Return the component of a momentum along a joint's axis."""
        px, py, pz, lx, ly, lz = momentum
        x, y, z, ox, oy, oz = frame[6:]
        if self._tree.is_prismatic[joint]:
            return x * px + y * py + z * pz
        vx, vy, vz = oy * z - oz * y, oz * x - ox * z, ox * y - oy * x
        return (vx * px + vy * py + vz * pz) + (x * lx + y * ly + z * lz)

    def jacobian(
        self, frames: Sequence[Frame], body: int, point: Vector3
    ) -> tuple[Matrix, Matrix]:
        """Return a body's linear and angular Jacobians, each of shape (n_joints, 3).

        The linear Jacobian is that of the ``point`` on the body [m/rad | m/m].  Both
        Jacobians are in the axes of the ``frames``.  The motion of a mimic joint is
        added to the row of its master joint.
        """
        linear = [[0.0, 0.0, 0.0] for _ in frames]
        angular = [[0.0, 0.0, 0.0] for _ in frames]
        px, py, pz = point
        joint = body
        while joint >= 0:
            x, y, z, ox, oy, oz = frames[joint][6:]
            master, multiplier = self._masters[joint]
            x, y, z = multiplier * x, multiplier * y, multiplier * z
            way = linear[master]
            if self._tree.is_prismatic[joint]:
                way[0], way[1], way[2] = way[0] + x, way[1] + y, way[2] + z
            else:
                rx, ry, rz = px - ox, py - oy, pz - oz
                way[0] += y * rz - z * ry
                way[1] += z * rx - x * rz
                way[2] += x * ry - y * rx
                turn = angular[master]
                turn[0], turn[1], turn[2] = turn[0] + x, turn[1] + y, turn[2] + z
            joint = self._tree.parents[joint]
        return np.array(linear), np.array(angular)

    def frames(self, position: Sequence[float]) -> list[Frame]:
        """Return each body's frame in the root, rotated so that its joint acts along z.

        If gravity is not along -z, the root is rotated so that it is.
        """
        return self._tree.frames(position)


def _about_root(
    frame: Frame, mass: float, center: Vector3, tensor: Sequence[float]
) -> list[float]:
    """Return mass, first moment and inertia (xx xy xz yy yz zz) about the root."""
    ax, ay, az, bx, by, bz, cx, cy, cz, ox, oy, oz = frame
    u, v, w = center
    x = ax * u + bx * v + cx * w + ox
    y = ay * u + by * v + cy * w + oy
    z = az * u + bz * v + cz * w + oz
    t0, t1, t2, t3, t4, t5, t6, t7, t8 = tensor
    # Rows of the product of the rotation and the tensor.
    xa, xb, xc = (
        ax * t0 + bx * t3 + cx * t6,
        ax * t1 + bx * t4 + cx * t7,
        ax * t2 + bx * t5 + cx * t8,
    )
    ya, yb, yc = (
        ay * t0 + by * t3 + cy * t6,
        ay * t1 + by * t4 + cy * t7,
        ay * t2 + by * t5 + cy * t8,
    )
    za, zb, zc = (
        az * t0 + bz * t3 + cz * t6,
        az * t1 + bz * t4 + cz * t7,
        az * t2 + bz * t5 + cz * t8,
    )
    return [
        mass,
        mass * x,
        mass * y,
        mass * z,
        (xa * ax + xb * bx + xc * cx) + mass * (y * y + z * z),
        (xa * ay + xb * by + xc * cy) - mass * (x * y),
        (xa * az + xb * bz + xc * cz) - mass * (x * z),
        (ya * ay + yb * by + yc * cy) + mass * (x * x + z * z),
        (ya * az + yb * bz + yc * cz) - mass * (y * z),
        (za * az + zb * bz + zc * cz) + mass * (x * x + y * y),
    ]


def _master(
    model: RobotModel, joint: Joint, index: dict[str, int]
) -> tuple[int, float]:
    """Return the joint that drives ``joint``, and the ratio of their velocities."""
    multiplier = 1.0
    while joint.mimic is not None:
        multiplier *= joint.mimic.multiplier
        joint = model.joint_by_name[joint.mimic.joint]
    return index[joint.name], multiplier


def _upright(gravity: Vector3) -> Matrix:
    """Return the rotation, shape (3, 3), that turns ``gravity`` towards -z."""
    x, y, z = gravity
    if x == y == 0.0 and z <= 0.0:
        return np.eye(3)
    g = math.hypot(x, y, z)
    return turn_z_to((-x / g, -y / g, -z / g)).T
