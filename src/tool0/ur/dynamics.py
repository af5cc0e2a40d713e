"""Dynamics of an arm, which the arm's control box computes for programs.

The model is that of the drives: the robot's description with the declared payload
instead of the tool. Joints are ordered from base to flange. Matrices are tuples of
rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol, TypeAlias, cast, final

from tool0.description.bodies import ROTOR_INERTIA, JointDynamics
from tool0.description.model import RobotModel
from tool0.description.payload_bodies import modelled_payload, replaced_tools
from tool0.description.transform import Vector3
from tool0.description.velocity_torques import velocity_efforts

if TYPE_CHECKING:
    from tool0.kinematics.chain import ArmChain
    from tool0.kinematics.scalar_kinematics import ScalarPosture
    from tool0.protocol.control_box_state import ControlBoxState
    from tool0.protocol.state import Six, Snapshot

Rows: TypeAlias = tuple["Six", ...]
"""A matrix with rows of six numbers."""


class MeasuredArm(Protocol):
    """Current state of an arm in its control box."""

    chain: ArmChain
    snapshot: Snapshot
    state: ControlBoxState

    @property
    def qd(self) -> Six: ...

    @property
    def tcp(self) -> Six: ...

    def posture(self) -> ScalarPosture: ...

    def posture_at(self, q: Sequence[float]) -> ScalarPosture: ...


@final
class BoxDynamics:
    """Mass matrix, Jacobians and velocity torques of a control box's arm.

    If the joint positions [rad] or velocities [rad/s] are omitted, the measured values
    are used. If the TCP is omitted, the control box's TCP is used.
    """

    def __init__(
        self, box: MeasuredArm, model: RobotModel, joint_names: Sequence[str]
    ) -> None:
        """Use the arm of ``box``; ``joint_names`` is the order of joints in states."""
        self._box, self._model = box, model
        self._own = modelled_payload(model, box.chain.tip)
        in_states = {name: k for k, name in enumerate(joint_names)}
        names = [joint.name for joint in model.movable_joints]
        self._in_states = [in_states[name] for name in names]
        self._joints = [names.index(name) for name in box.chain.joint_names]
        self._armatures = [
            0.0 if drive is None else drive.armature
            for name in box.chain.joint_names
            for drive in [model.transmission_by_joint.get(name)]
        ]
        self._known = self._own, JointDynamics(model)
        """Last payload, and the dynamics of the robot with this payload."""

    def mass_matrix(
        self, q: Sequence[float] | None = None, *, with_rotors: bool = False
    ) -> Rows:
        """Return the mass matrix of the joints [kg·m²].

        With ``with_rotors``, the matrix includes the inertia of rotors and gears.
        """
        matrix = self._loaded().mass_matrix(self._position(q))
        matrix = matrix[self._joints][:, self._joints]
        for k, armature in enumerate(self._armatures):
            matrix[k, k] += (armature or ROTOR_INERTIA) * with_rotors - armature
        return cast("Rows", tuple(map(tuple, matrix.tolist())))

    def velocity_torques(
        self, q: Sequence[float] | None = None, qd: Sequence[float] | None = None
    ) -> Six:
        """Return the Coriolis and centrifugal torques [N·m]."""
        position = self._position(q)
        velocity = [0.0] * len(position)
        speeds = self._box.qd if qd is None else qd
        for k, speed in zip(self._joints, speeds, strict=True):
            velocity[k] = speed
        efforts = velocity_efforts(self._loaded(), position, velocity)
        return cast("Six", tuple(efforts[self._joints].tolist()))

    def jacobian(
        self, q: Sequence[float] | None = None, tcp: Sequence[float] | None = None
    ) -> Rows:
        """Return the Jacobian of the TCP in base axes; the linear rows come first."""
        posture, point = self._placed(q, tcp)
        return jacobian(posture, point)

    def jacobian_derivative(
        self,
        q: Sequence[float] | None = None,
        qd: Sequence[float] | None = None,
        tcp: Sequence[float] | None = None,
    ) -> Rows:
        """Return the time derivative of ``jacobian``."""
        posture, point = self._placed(q, tcp)
        return jacobian_derivative(posture, point, self._box.qd if qd is None else qd)

    def _loaded(self) -> JointDynamics:
        """Return the dynamics of the robot with the current payload."""
        payload = self._box.state.payload
        if self._known[0] != payload:
            declared = {} if payload == self._own else {self._box.chain.tip: payload}
            added = replaced_tools(self._model, declared)
            self._known = payload, JointDynamics(self._model, added=added)
        return self._known[1]

    def _position(self, q: Sequence[float] | None) -> list[float]:
        """Return the positions of all joints in the model's order [rad | m]."""
        measured = self._box.snapshot.position
        position = [measured[k] for k in self._in_states]
        if q is not None:
            for k, value in zip(self._joints, q, strict=True):
                position[k] = value
        return position

    def _placed(
        self, q: Sequence[float] | None, tcp: Sequence[float] | None
    ) -> tuple[ScalarPosture, Vector3]:
        """Return the arm's posture and the TCP's position in the base frame [m]."""
        box = self._box
        posture = box.posture() if q is None else box.posture_at(q)
        x, y, z, *_ = box.tcp if tcp is None else tcp
        return posture, posture.flange.apply((x, y, z))


def jacobian(posture: ScalarPosture, point: Vector3) -> Rows:
    """Return the Jacobian of a point that is fixed to the flange.

    The linear rows come first. The rows and ``point`` [m] are in the posture's frame.
    """
    columns = []
    for axis, origin in zip(posture.axes, posture.points, strict=True):
        columns.append((*_cross(axis, _less(point, origin)), *axis))
    return _transposed(columns)


def jacobian_derivative(
    posture: ScalarPosture, point: Vector3, qd: Sequence[float]
) -> Rows:
    """Return the time derivative of ``jacobian`` at joint velocities [rad/s]."""
    point_velocity, _ = posture.velocity(point, qd)
    columns = []
    for k, (axis, origin) in enumerate(zip(posture.axes, posture.points, strict=True)):
        moved, omega = posture.velocity(origin, qd, n_joints=k)
        turned = _cross(omega, axis)
        linear = _plus(
            _cross(turned, _less(point, origin)),
            _cross(axis, _less(point_velocity, moved)),
        )
        columns.append((*linear, *turned))
    return _transposed(columns)


def _transposed(columns: Sequence[Sequence[float]]) -> Rows:
    return cast("Rows", tuple(zip(*columns, strict=True)))


def _cross(a: Vector3, b: Vector3) -> Vector3:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def _less(a: Vector3, b: Vector3) -> Vector3:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def _plus(a: Vector3, b: Vector3) -> Vector3:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])
