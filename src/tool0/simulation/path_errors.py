"""Joints that are not where they are sent: which, by how much, and why."""

from __future__ import annotations

import math
from typing import Final, NamedTuple, final

from tool0.control.arm.stream import SINGULAR
from tool0.control.manager import ControllerManager
from tool0.description.model import RobotModel
from tool0.description.parts import ArmParts
from tool0.hardware.engine import JointState, World
from tool0.hardware.robot_hardware import RobotHardware
from tool0.protocol.state import Contact, contacts_text
from tool0.sensing.stalls import LARGEST_LAG, external_contacts

RECENT: Final = 0.1
"""For how long a contact counts as a cause after it has ended [s]: what hits the ground
rebounds."""
_AT_LIMIT: Final = 0.02
"""Distance from a limit at which a joint is held by it [rad]."""
_FULL: Final = 0.98
"""Part of its largest effort from which a drive gives all that it can."""


@final
class TrackedJoint(NamedTuple):
    """A joint that is to be where it is sent."""

    name: str
    number: int
    """In the engine's order."""
    lower: float
    upper: float
    """Its limits [rad]."""
    error: float
    """Largest distance from the setpoint [rad]."""
    links: frozenset[str]
    """All that it moves."""


@final
class PathErrors:
    """Describes the path errors of one arm."""

    def __init__(
        self,
        arm: ArmParts,
        model: RobotModel,
        hardware: RobotHardware,
        manager: ControllerManager,
        world: World,
    ) -> None:
        self._arm, self._model, self._world = arm, model, world
        self._hardware, self._manager = hardware, manager
        self.joints = tuple(
            TrackedJoint(
                joint.name,
                hardware.index[joint.name],
                limits.lower,
                limits.upper,
                LARGEST_LAG * limits.velocity,
                frozenset(model.links_from(joint.child)),
            )
            for joint in arm.joints
            if (limits := hardware.limits.get(joint.name)) is not None
        )
        """The joints with drives."""
        self._touching: tuple[Contact, ...] = ()
        """The last contacts of the arm that were seen, and when [s]:"""
        self._touched_at = -math.inf

    def watch(self, time: float) -> None:
        """Note what touches the arm at ``time`` [s]: it may cause an error."""
        contacts = self._world.contacts()
        if self.joints and external_contacts(self.joints[0].links, contacts):
            self._touching, self._touched_at = contacts, time

    def off_path(self, joint: TrackedJoint, error: float, state: JointState) -> str:
        """Return that a joint is ``error`` [rad] off its path, and why."""
        return (
            f"joint '{joint.name}' is {error:.3f} rad off its path, more than "
            f"{joint.error:.3f} rad ({self._cause(joint, state)})"
        )

    def not_arrived(self, joint: TrackedJoint, error: float, state: JointState) -> str:
        """Return that a joint has not reached the end of its path, and why."""
        return (
            f"joint '{joint.name}' is {error:.3f} rad from the end of its path "
            f"({self._cause(joint, state)})"
        )

    def _cause(self, joint: TrackedJoint, state: JointState) -> str:
        """Return what most likely keeps a joint off its path."""
        self.watch(state.time)
        if 0.0 <= state.time - self._touched_at <= RECENT:
            touching = external_contacts(joint.links, self._touching)
            if touching:
                return contacts_text(touching)
        position = state.position[joint.number]
        for limit in (joint.lower, joint.upper):
            if abs(position - limit) <= _AT_LIMIT:
                return f"no contact: it is at its limit of {limit:.4g} rad"
        if self._is_wanted_fast() and self._singular_value(state) < SINGULAR:
            return (
                "no contact: the arm is at a singularity, where its joints would have "
                "to turn faster than they can"
            )
        most = self._hardware.limits[joint.name].effort
        if abs(state.effort[joint.number]) >= _FULL * most:
            return (
                f"no contact: its drive gives all of its {most:.4g} N·m; the motion is "
                "too fast for the load, or the payload is not the one that is set"
            )
        return "no contact: the motion is too fast, or the payload is not as set"

    def _is_wanted_fast(self) -> bool:
        """Return whether a joint is to turn at more than half of its speed."""
        limits = self._hardware.limits
        return any(
            abs(spline.sample(setpoint.time).velocity) > limits[model.name].velocity / 2
            for setpoint in self._manager.setpoints().values()
            for model, spline in zip(
                setpoint.joint_models, setpoint.splines, strict=True
            )
            if model.name in limits
        )

    def _singular_value(self, state: JointState) -> float:
        """Return the smallest singular value of the Jacobian: 0 where singular."""
        import numpy as np  # only once something is wrong

        from tool0.kinematics.chain import ArmChain

        model, arm = self._model, self._arm
        position = [state.position[self._hardware.index[j.name]] for j in arm.joints]
        posture = ArmChain(model, arm.flange, arm.joints).forward(np.array([position]))
        return float(np.linalg.svd(posture.jacobian[0], compute_uv=False)[-1])
