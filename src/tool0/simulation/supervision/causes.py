"""Reasons why joints are not at their setpoints: contacts, limits or effort limits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, NamedTuple, final

from tool0.control.arm.stream import SINGULAR
from tool0.description.parts import ArmParts
from tool0.description.scene_state import Contact, contacts_text
from tool0.hardware.engine import JointState
from tool0.sensing.stalls import LARGEST_LAG, external_contacts
from tool0.simulation.core import Core

RECENT: Final = 0.1
"""Time for which a contact is still considered a cause after it has ended [s].  For
example, a link that hits the ground rebounds."""
_AT_LIMIT: Final = 0.02
"""Distance from a limit within which the limit is considered to stop the joint
[rad]."""
_FULL: Final = 0.98
"""Fraction of the largest effort above which a drive is considered fully loaded."""


@final
class TrackedJoint(NamedTuple):
    """A joint that should be at its setpoint."""

    name: str
    number: int
    """Index of the joint in the order of the engine."""
    lower: float
    upper: float
    """Lower and upper limits of the joint [rad]."""
    error: float
    """Largest permissible distance of the joint from its setpoint [rad]."""
    effort: float
    """Largest effort of the joint's drive [N·m]."""
    links: frozenset[str]
    """Links that the joint moves."""


@final
class Causes:
    """Finds the reasons why the joints of an arm are not at their setpoints."""

    def __init__(self, arm: ArmParts, core: Core) -> None:
        self._arm, self._core = arm, core
        model, hardware = core.model, core.hardware
        self.joints = tuple(
            TrackedJoint(
                joint.name,
                hardware.index[joint.name],
                limits.lower,
                limits.upper,
                LARGEST_LAG * limits.velocity,
                limits.effort,
                frozenset(model.links_from(joint.child)),
            )
            for joint in arm.joints
            if (limits := hardware.limits.get(joint.name)) is not None
        )
        """Driven joints, from the base to the flange."""
        self._touching: tuple[Contact, ...] = ()
        """Last detected contacts of the arm; ``_touched_at`` is their time [s]."""
        self._touched_at = -math.inf

    def watch(self, time: float) -> None:
        """Record the contacts of the arm at ``time`` [s] as possible causes."""
        contacts = self._core.engine.world.contacts()
        if external_contacts((joint.links for joint in self.joints), contacts):
            self._touching, self._touched_at = contacts, time

    def of(self, joint: TrackedJoint, state: JointState) -> str:
        """Return the most likely reason why a joint is not at its setpoint."""
        return (
            self._obstacle(joint, (joint,), state)
            or self._singularity(state)
            or _weakness(joint, state)
            or "no contact: the motion is too fast, or the payload is not as set"
        )

    def known(
        self, joint: TrackedJoint, moving: Sequence[TrackedJoint], state: JointState
    ) -> str:
        """Return the reason why a joint is not at its setpoint.

        The result is empty if the reason is unknown.  Contacts may stop the joints in
        ``moving``, which contains the joint and possibly other joints.
        """
        return self._obstacle(joint, moving, state) or _weakness(joint, state)

    def _obstacle(
        self, joint: TrackedJoint, moving: Sequence[TrackedJoint], state: JointState
    ) -> str:
        """Return the contacts that stop ``moving`` joints, or the limit of ``joint``.

        The result is empty if neither contacts nor a limit stop the joint.
        """
        self.watch(state.time)
        if 0.0 <= state.time - self._touched_at <= RECENT:
            touching = external_contacts((j.links for j in moving), self._touching)
            if touching:
                return contacts_text(touching)
        position = state.position[joint.number]
        for limit in (joint.lower, joint.upper):
            if abs(position - limit) <= _AT_LIMIT:
                return f"no contact: '{joint.name}' is at its limit of {limit:.4g} rad"
        return ""

    def _singularity(self, state: JointState) -> str:
        """Describe a singularity that a fast motion approaches.

        The result is empty if there is no singularity nearby.
        """
        if self._is_wanted_fast() and self._singular_value(state) < SINGULAR:
            return (
                "no contact: the arm is at a singularity, where its joints would have "
                "to turn faster than they can"
            )
        return ""

    def _is_wanted_fast(self) -> bool:
        """Return whether a commanded speed exceeds half of the largest joint speed."""
        limits = self._core.hardware.limits
        return any(
            abs(spline.sample(setpoint.time).velocity) > limits[model.name].velocity / 2
            for setpoint in self._core.manager.setpoints().values()
            for model, spline in zip(
                setpoint.joint_models, setpoint.splines, strict=True
            )
            if model.name in limits
        )

    def _singular_value(self, state: JointState) -> float:
        """Return the smallest singular value of the Jacobian (0 at a singularity)."""
        import numpy as np  # only for failed motions

        from tool0.kinematics.chain import ArmChain

        model, arm, index = self._core.model, self._arm, self._core.hardware.index
        position = [state.position[index[joint.name]] for joint in arm.joints]
        posture = ArmChain(model, arm.flange, arm.joints).forward(np.array([position]))
        return float(np.linalg.svd(posture.jacobian[0], compute_uv=False)[-1])


def _weakness(joint: TrackedJoint, state: JointState) -> str:
    """Describe a drive that is at its largest effort.

    The result is empty if the effort is smaller.
    """
    if abs(state.effort[joint.number]) < _FULL * joint.effort:
        return ""
    return (
        f"no contact: the drive of '{joint.name}' gives all of its {joint.effort:.4g} "
        "N·m; the motion is too fast for the load, or the payload is not as set"
    )
