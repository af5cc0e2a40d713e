"""Wrench of a tool on its flange during a step, computed by the kernel if possible."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

import numpy as np

from tool0.description.model import RobotModel
from tool0.description.payload import Payload
from tool0.description.payload_bodies import payload_inertia
from tool0.description.scene_state import Contact, Wrench
from tool0.hardware.engine import Engine, JointState
from tool0.hardware.tool_dynamics import ToolDynamics, ToolForces
from tool0.kernel import library
from tool0.kernel.memory import Addresses
from tool0.kernel.tool_forces import ToolForcesKernel, ToolWrenches


@final
class ToolMeter:
    """Measures the wrench that a link and all links beyond it exert on their parent."""

    def __init__(self, model: RobotModel, link: str, engine: Engine) -> None:
        self._dynamics = ToolDynamics(model, link, engine.world.gravity)
        names = engine.joint_names
        self._joints = [names.index(joint.name) for joint in model.movable_joints]
        self._dt = engine.dt
        self._step = np.zeros((3, len(names)))
        """State of a step: positions and velocities before the step, and velocities
        after the step."""
        at = [row.ctypes.data for row in self._step]
        self._step_at: Addresses = np.array([at], dtype=np.uintp)
        self._compiled = library.load()
        self._load()

    @property
    def links(self) -> frozenset[str]:
        """Links with contacts that are included in the wrench."""
        return self._dynamics.links

    def subtract(self, payloads: Mapping[str, Payload]) -> None:
        """Subtract payloads by flange from later wrenches."""
        inertias = {link: payload_inertia(item) for link, item in payloads.items()}
        self._dynamics.subtract(inertias)
        self._load()

    def _load(self) -> None:
        self._kernel = None
        if self._compiled is not None:
            table, joints = self._dynamics.table, self._joints
            self._kernel = ToolForcesKernel(self._compiled, table, joints, self._dt)

    def wrench(
        self, before: JointState, after: JointState, contacts: tuple[Contact, ...]
    ) -> Wrench:
        """Return the force [N] and torque [N·m] during the step between two states.

        The wrench acts at the flange and is given in the flange's axes. ``contacts``
        are all contacts of the step.
        """
        was, velocity = before.velocity, after.velocity
        if self._kernel is None:
            order, dt = self._joints, self._dt
            return self._dynamics.wrench(
                [before.position[i] for i in order],
                [was[i] for i in order],
                [(velocity[i] - was[i]) / dt for i in order],
                contacts,
            )
        self._step[:] = before.position, was, velocity
        found = self._kernel.of_steps(self._step_at)
        if contacts:
            return self._dynamics.with_contacts(found.forces(0), contacts)
        fx, fy, fz, tx, ty, tz = found.wrench[0].tolist()
        return fx, fy, fz, tx, ty, tz

    def wrenches(self, steps: Addresses) -> ToolWrenches:
        """Return the wrenches without contacts for steps that the kernel executed."""
        assert self._kernel is not None
        return self._kernel.of_steps(steps)

    def with_contacts(
        self, forces: ToolForces, contacts: tuple[Contact, ...]
    ) -> Wrench:
        """Return the wrench at the flange, including all contacts of the step."""
        return self._dynamics.with_contacts(forces, contacts)
