"""The dynamics that drives assume.

The dynamics are computed from the description and from declared payloads.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import final

import numpy as np

from tool0.description.bodies import DynamicsTable, JointDynamics, Matrix
from tool0.description.model import JointType, RobotModel
from tool0.description.payload import Payload
from tool0.description.payload_bodies import replaced_tools
from tool0.description.transform import Vector3
from tool0.hardware.engine import JointState
from tool0.hardware.servo_masses import (
    bounded_masses,
    expected_load,
    integral_rate,
    largest_ratio,
)


@final
class DriveDynamics:
    """Gravity loads, masses and mobilities of joints, by the engine's joint indices."""

    def __init__(
        self,
        model: RobotModel,
        joint_names: Sequence[str],
        dt: float,
        gravity: Vector3,
    ) -> None:
        """Start without declared payloads.

        For the arguments, see ``RobotHardware``.
        """
        self._model, self._gravity_vector, self._dt = model, gravity, dt
        self._payloads: dict[str, Payload] = {}
        self.own = self._declared = JointDynamics(model, gravity)
        """Dynamics without declared payloads and dynamics with declared payloads."""
        index = {name: i for i, name in enumerate(joint_names)}
        self.to_model = tuple(index[joint.name] for joint in model.movable_joints)
        """Engine index of each of the model's movable joints."""
        inertias = self.own.mass_matrix([0.0] * len(joint_names)).diagonal()
        self.inertias = {
            joint.name: float(inertia)
            for joint, inertia in zip(model.movable_joints, inertias, strict=True)
        }
        """Inertia at each joint in the zero pose [kg·m² | kg], by joint name."""
        carriers = [
            model.joint_by_name[name]
            for name in sorted(_joints_before_flanges(model))
            if not ((d := model.transmission_by_joint.get(name)) and d.armature)
        ]
        self.integral_rates = {
            joint.name: integral_rate(
                self.inertias[joint.name], joint.limits.effort, dt
            )
            for joint in carriers
        }
        """Integral rate [1/s] of the servo of each joint that carries a payload, by
        joint name."""
        self._expected_loads = {
            index[joint.name]: expected_load(joint.limits.effort) for joint in carriers
        }

    @property
    def payloads(self) -> Mapping[str, Payload]:
        """The declared payloads, by flange."""
        return self._payloads

    def set_payload(self, flange: str, payload: Payload | None) -> None:
        """Declare the payload at ``flange``.

        None selects the tool in the description.
        """
        self._payloads.pop(flange, None)
        if payload is not None:
            self._payloads[flange] = payload
        self._declared = JointDynamics(
            self._model,
            self._gravity_vector,
            replaced_tools(self._model, self._payloads),
        )

    @property
    def table(self) -> DynamicsTable:
        """The constants with which compiled code computes ``gravity``."""
        return self._declared.table

    def gravity(self, state: JointState) -> list[float]:
        """Return the efforts that balance gravity [N·m | N], shape (n_joints,)."""
        position = [state.position[i] for i in self.to_model]
        ordered = [0.0] * len(position)
        loads = self._declared.static_effort(position)
        for i, load in zip(self.to_model, loads, strict=True):
            ordered[i] = load
        return ordered

    def masses(self, joints: Sequence[int], state: JointState) -> Matrix:
        """Return the mass matrix of ``joints`` for servos [kg·m² | kg], shape (n, n).

        The effect of declared payloads on the matrix is bounded; see module
        ``servo_masses``.
        """
        position = [state.position[i] for i in self.to_model]
        declared = self._declared.mass_matrix(position)[None]
        return np.asarray(self.servo_masses(joints, declared, [position])[0])

    def servo_masses(
        self,
        joints: Sequence[int],
        declared: Matrix,
        positions: Sequence[Sequence[float]],
    ) -> Matrix:
        """Return ``masses`` of ``joints`` in k states, shape (k, n, n).

        Args:
            joints: Engine indices of the n joints.
            declared: The mass matrices of the model's joints with declared payloads,
                shape (k, n_joints, n_joints).
            positions: Positions of the model's joints [rad | m], shape (k, n_joints);
                used only if payloads are declared.
        """
        rows = [self.to_model.index(i) for i in joints]
        chosen = own = np.ascontiguousarray(declared[:, rows][:, :, rows])
        loads = [self._expected_loads.get(i, 0.0) for i in joints]
        if not self._payloads and not any(loads):
            return own
        if self._payloads:
            matrices = [self.own.mass_matrix(position) for position in positions]
            own = np.ascontiguousarray(np.array(matrices)[:, rows][:, :, rows])
        return bounded_masses(own, chosen + np.diag(loads), largest_ratio(self._dt))

    def mobility(
        self, joints: Sequence[int], state: JointState, rotors: Mapping[int, float]
    ) -> Matrix:
        """Return the velocity changes of ``joints`` in one step, per unit of effort.

        The result has shape (n, n) [rad/s/(N·m)].  The mobility is computed from the
        masses in the description and from the inertias of the ``rotors`` [kg·m²], which
        are given by joint index.
        """
        position = [state.position[i] for i in self.to_model]
        own = self.own.mass_matrix(position)[None]
        return np.asarray(self._mobilities(joints, own, rotors)[0])

    def mobilities(
        self,
        joints: Sequence[int],
        declared: Matrix,
        positions: Sequence[Sequence[float]],
        rotors: Mapping[int, float],
    ) -> Matrix:
        """Return the ``mobility`` of ``joints`` in k states, shape (k, n, n).

        ``declared`` and ``positions`` have the same meaning as in ``servo_masses``.
        """
        own = declared
        if self._payloads:
            own = np.array([self.own.mass_matrix(position) for position in positions])
        return self._mobilities(joints, own, rotors)

    def _mobilities(
        self, joints: Sequence[int], own: Matrix, rotors: Mapping[int, float]
    ) -> Matrix:
        rows = [self.to_model.index(i) for i in joints]
        masses = own[:, rows][:, :, rows]
        masses += np.diag([rotors.get(joint, 0.0) for joint in joints])
        return np.asarray(self._dt * np.linalg.inv(masses))


def _joints_before_flanges(model: RobotModel) -> set[str]:
    """Return the revolute joints that move a flange."""
    found = set()
    for flange in model.flanges:
        joint = model.parent_joint.get(flange)
        while joint is not None:
            if joint.is_movable and joint.type is not JointType.PRISMATIC:
                found.add(joint.name)
            joint = model.parent_joint.get(joint.parent)
    return found
