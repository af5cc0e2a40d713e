"""Computes the wrench of a tool on its flange with the Newton-Euler equations.

The accelerations in a physics step determine the total wrench on the rigid bodies
beyond the flange.  The part of this wrench that is neither weight nor contact force
acts through the flange.  Drives, linkages, springs and friction inside the tool act
between parts of the tool, so that their forces cancel.

A rotor inside the tool is part of the mass and inertia of its link.  The faster
rotation of the rotor is neglected, as in the engines.  With an armature A behind a
reduction N, the neglected angular momentum is A q̇ / N.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple, final

import numpy as np

from tool0.description.bodies import (
    STANDARD_GRAVITY,
    BodyInertia,
    DynamicBody,
    JointDynamics,
    Matrix,
    MovingBody,
    fixed_to_world,
    moving_bodies,
    total_inertia,
)
from tool0.description.flat_frames import (
    ROOT,
    Frame,
    compose,
    flat_frame,
    rotate,
    rotate_back,
)
from tool0.description.model import JointType, RobotModel
from tool0.description.scene_state import Contact, Wrench
from tool0.description.transform import Vector3
from tool0.description.transform_arrays import turn_z_to

_ZERO: Vector3 = (0.0, 0.0, 0.0)


class _BodyMotion(NamedTuple):
    """Motion of a body, in the axes of the robot's root."""

    angular_velocity: Vector3
    """Angular velocity [rad/s]."""
    angular_acceleration: Vector3
    """Angular acceleration [rad/s²]."""
    acceleration: Vector3
    """Acceleration of the body's origin relative to free fall [m/s²].  At rest, the
    acceleration points up."""


class ToolPart(NamedTuple):
    """Mass properties of the part of a body beyond the flange, in the body's frame."""

    body: int
    """Index of the body; -1 for the world."""
    mass: float
    center: Vector3
    tensor: tuple[float, ...]
    """Inertia about the center of mass, as 9 floats [kg·m²]."""


class ToolForces(NamedTuple):
    """The wrench of a tool on its flange, without contacts, in the root's axes."""

    force: Vector3
    """Force on the flange [N]."""
    torque: Vector3
    """Torque about the flange [N·m]."""
    flange: Frame
    """Pose of the flange in the frame of the robot's root."""


class ToolTable(NamedTuple):
    """The constants of ``ToolDynamics.forces``."""

    bodies: tuple[DynamicBody, ...]
    """All moving bodies of the robot, in the order of the model's joints."""
    parts: tuple[ToolPart, ...]
    carrier: int
    """Index of the body that contains the flange; -1 for the world."""
    flange: Frame
    """Pose of the flange in the frame of ``carrier``."""
    rise: Vector3
    """Acceleration of the root relative to free fall [m/s²]."""


@final
class ToolDynamics:
    """Computes the wrench that a link and all links beyond it exert on their parent."""

    def __init__(
        self, model: RobotModel, link: str, gravity: Vector3 = STANDARD_GRAVITY
    ) -> None:
        """Separate the links beyond the flange from the robot, just before ``link``.

        ``gravity`` [m/s²] is in the axes of the robot's root.

        Raises:
            ModelError: If the model has no link named ``link``.
        """
        self.links = frozenset(model.links_from(link))
        """The names of ``link`` and all links beyond it."""
        self._model = model
        self._bodies = bodies = moving_bodies(model)
        self._dynamics = JointDynamics(model)
        gx, gy, gz = gravity
        self._world_motion = _BodyMotion(_ZERO, _ZERO, (-gx, -gy, -gz))
        self._parent = [body.parent for body in bodies]
        self._prismatic = [b.joint.type is JointType.PRISMATIC for b in bodies]
        # The frames are rotated so that each joint acts along its z axis.
        turns = [turn_z_to(body.joint.axis) for body in bodies]
        turns.append(np.eye(3))  # the last element, at index -1, is for the world
        self._turns = turns
        self._carrier, frame = _find_body(model, bodies, link)
        back = turns[self._carrier].T
        self._flange = flat_frame(back @ frame[:3, :3], back @ frame[:3, 3])
        self._parts = [
            _as_part(i, inertia, turns[i])
            for i, body in enumerate(bodies)
            if (inertia := self._inertia(model, body.links)).mass > 0.0
        ]
        if self._carrier < 0:
            still = self._inertia(model, fixed_to_world(model))
            self._parts.append(_as_part(-1, still, turns[-1]))
        self._payloads: list[ToolPart] = []

    def subtract(self, payloads: Mapping[str, BodyInertia]) -> None:
        """Subtract the effect of bodies that are fixed to links.

        The bodies are given in the frames of the links.  Bodies on links that the
        wrench does not include are ignored.
        """
        self._payloads = []
        for link in payloads.keys() & self.links:
            body, frame = _find_body(self._model, self._bodies, link)
            moved = payloads[link].moved(frame)
            less = BodyInertia(-moved.mass, moved.center, -moved.tensor)
            self._payloads.append(_as_part(body, less, self._turns[body]))

    def wrench(
        self,
        position: Sequence[float],
        velocity: Sequence[float],
        acceleration: Sequence[float],
        contacts: Iterable[Contact],
    ) -> Wrench:
        """Return the force and torque on the flange, in the link's axes at its origin.

        Args:
            position: Positions of the movable joints, in the model's order [rad | m].
            velocity: Velocities [rad/s | m/s].
            acceleration: Accelerations [rad/s² | m/s²].
            contacts: All contacts at that instant.  Contacts of other links are
                ignored.
        """
        forces = self.forces(position, velocity, acceleration)
        return self.with_contacts(forces, contacts)

    @property
    def table(self) -> ToolTable:
        """The constants of ``forces``, valid until other payloads are subtracted."""
        return ToolTable(
            self._dynamics.table.bodies,
            (*self._parts, *self._payloads),
            self._carrier,
            self._flange,
            self._world_motion.acceleration,
        )

    def forces(
        self,
        position: Sequence[float],
        velocity: Sequence[float],
        acceleration: Sequence[float],
    ) -> ToolForces:
        """Return the wrench without contacts.  For the arguments, see ``wrench``."""
        # The kernel computes the same values (wrench.c).
        frames = [*self._dynamics.frames(position), ROOT]
        motions = self._motions(frames, velocity, acceleration)
        flange = compose(frames[self._carrier], self._flange)
        px, py, pz = flange[9:]
        fx = fy = fz = tx = ty = tz = 0.0
        for i, mass, center, tensor in (*self._parts, *self._payloads):
            frame, motion = frames[i], motions[i]
            rx, ry, rz = rotate(frame, center)
            ax, ay, az = _acceleration_at(motion, (rx, ry, rz))
            ax, ay, az = -mass * ax, -mass * ay, -mass * az
            w = rotate_back(frame, motion.angular_velocity)
            dw = rotate_back(frame, motion.angular_acceleration)
            nx, ny, nz = rotate(frame, _inertial_torque(tensor, w, dw))
            rx, ry, rz = rx + frame[9] - px, ry + frame[10] - py, rz + frame[11] - pz
            fx, fy, fz = fx + ax, fy + ay, fz + az
            tx += ry * az - rz * ay - nx
            ty += rz * ax - rx * az - ny
            tz += rx * ay - ry * ax - nz
        return ToolForces((fx, fy, fz), (tx, ty, tz), flange)

    def with_contacts(self, forces: ToolForces, contacts: Iterable[Contact]) -> Wrench:
        """Return the wrench including contacts, in the flange's axes at its origin."""
        (fx, fy, fz), (tx, ty, tz), flange = forces
        px, py, pz = flange[9:]
        for contact in contacts:
            if sign := (contact.second in self.links) - (contact.first in self.links):
                x, y, z = contact.point
                ax, ay, az = contact.force
                nx, ny, nz = contact.torque
                rx, ry, rz = x - px, y - py, z - pz
                fx, fy, fz = fx + sign * ax, fy + sign * ay, fz + sign * az
                tx += sign * (ry * az - rz * ay + nx)
                ty += sign * (rz * ax - rx * az + ny)
                tz += sign * (rx * ay - ry * ax + nz)
        force, torque = (fx, fy, fz), (tx, ty, tz)
        return (*rotate_back(flange, force), *rotate_back(flange, torque))

    def _inertia(
        self, model: RobotModel, links: Iterable[tuple[str, Matrix]]
    ) -> BodyInertia:
        """Return the inertia of the ``links`` beyond the flange."""
        return total_inertia(model, [link for link in links if link[0] in self.links])

    def _motions(
        self,
        frames: Sequence[Frame],
        velocity: Sequence[float],
        acceleration: Sequence[float],
    ) -> list[_BodyMotion]:
        """Return the motion of each body, followed by the motion of the world."""
        motions: list[_BodyMotion] = []
        still = self._world_motion
        for i, parent in enumerate(self._parent):
            carrier = motions[parent] if parent >= 0 else still
            w, dw, _ = carrier
            frame, before = frames[i], frames[parent]
            _, _, _, _, _, _, zx, zy, zz, x, y, z = frame
            lever = x - before[9], y - before[10], z - before[11]
            a = _acceleration_at(carrier, lever)
            qd, qdd = velocity[i], acceleration[i]
            wx, wy, wz = w
            # The rate at which the parent's rotation turns the joint's axis.
            cx, cy, cz = wy * zz - wz * zy, wz * zx - wx * zz, wx * zy - wy * zx
            if self._prismatic[i]:
                ax, ay, az = a
                a = (
                    ax + 2.0 * qd * cx + qdd * zx,
                    ay + 2.0 * qd * cy + qdd * zy,
                    az + 2.0 * qd * cz + qdd * zz,
                )
            else:
                ex, ey, ez = dw
                dw = (
                    ex + qd * cx + qdd * zx,
                    ey + qd * cy + qdd * zy,
                    ez + qd * cz + qdd * zz,
                )
                w = wx + qd * zx, wy + qd * zy, wz + qd * zz
            motions.append(_BodyMotion(w, dw, a))
        motions.append(still)
        return motions


def _acceleration_at(body: _BodyMotion, r: Vector3) -> Vector3:
    """Return the acceleration of the point at offset ``r`` from a body's origin."""
    (wx, wy, wz), (ex, ey, ez), origin = body
    ax, ay, az = origin
    x, y, z = r
    ux, uy, uz = wy * z - wz * y, wz * x - wx * z, wx * y - wy * x
    return (
        ax + ey * z - ez * y + wy * uz - wz * uy,
        ay + ez * x - ex * z + wz * ux - wx * uz,
        az + ex * y - ey * x + wx * uy - wy * ux,
    )


def _inertial_torque(tensor: tuple[float, ...], w: Vector3, dw: Vector3) -> Vector3:
    """Return the torque that accelerates a body's rotation (Euler), in body axes."""
    a, b, c, d, e, f, g, h, i = tensor
    wx, wy, wz = w
    ex, ey, ez = dw
    hx, hy, hz = (
        a * wx + b * wy + c * wz,
        d * wx + e * wy + f * wz,
        g * wx + h * wy + i * wz,
    )
    return (
        a * ex + b * ey + c * ez + wy * hz - wz * hy,
        d * ex + e * ey + f * ez + wz * hx - wx * hz,
        g * ex + h * ey + i * ez + wx * hy - wy * hx,
    )


def _find_body(
    model: RobotModel, bodies: Sequence[MovingBody], link: str
) -> tuple[int, Matrix]:
    """Return the index of the body with ``link``, and the link's frame in the body.

    The index is -1 for the world.
    """
    for i, body in enumerate(bodies):
        for name, frame in body.links:
            if name == link:
                return i, frame
    return -1, dict(fixed_to_world(model))[link]


def _as_part(body: int, inertia: BodyInertia, turn: Matrix) -> ToolPart:
    tensor = (turn.T @ inertia.tensor @ turn).ravel().tolist()
    center = _vector3((turn.T @ inertia.center).tolist())
    return ToolPart(body, inertia.mass, center, tuple(tensor))


def _vector3(values: Sequence[float]) -> Vector3:
    x, y, z = values
    return x, y, z
