"""Contact forces of an arm, which cause a stop if they are too large.

A UR robot computes the force from the currents of its joints.  The simulation computes
the force from the contacts of the physics engine.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, final

from tool0.description.model import RobotModel
from tool0.description.parts import ArmParts
from tool0.description.payload_bodies import modelled_payload
from tool0.description.scene_state import Contact, contacts_text
from tool0.hardware.engine import World
from tool0.protocol.control_box_state import ControlBoxState
from tool0.sensing.stalls import external_contacts

DETECTION_TIME: Final = 0.1
"""Time constant of the low-pass filter of contact forces [s].  With the filter, short
impacts are not treated as clamping.  A force of 25 N above the limit is detected after
0.2 s.  The force limit of a UR robot has a trueness of 25 N and a detection time of 250
ms (user manual of the UR5/CB3, 5.1)."""
_NEGLIGIBLE: Final = 0.1
"""Force below which a filtered force is treated as zero [N]."""


@final
@dataclass(slots=True)
class _Body:
    """Links that move as one body, or the entire tool."""

    name: str
    links: frozenset[str]
    force: list[float] = field(default_factory=lambda: [0.0] * 3)
    """Filtered force that the body exerts [N]."""


@final
class ContactForces:
    """The filtered forces on the bodies of one arm; the tool is the last body."""

    def __init__(self, arm: ArmParts, model: RobotModel, world: World) -> None:
        self._world = world
        moved = [frozenset(model.links_from(joint.child)) for joint in arm.joints]
        further = [*moved[1:], frozenset[str]()]
        names = [*(joint.child for joint in arm.joints[:-1]), arm.flange]
        self._tool_mass = modelled_payload(model, arm.flange).mass
        self._links = moved[0]
        """Links of the arm, without the base."""
        self._bodies = [
            _Body(name, links - rest)
            for name, links, rest in zip(names, moved, further, strict=True)
        ]
        self.forget()

    def forget(self) -> None:
        """Clear the filtered forces, for example after a reset."""
        self._last = -math.inf
        """Time at which forces were last filtered [s]."""
        self._is_loaded = False
        """Whether any filtered force is not zero."""
        for body in self._bodies:
            body.force = [0.0] * 3

    def excess(self, time: float, box: ControlBoxState) -> str:
        """Filter the forces at ``time`` [s], and describe an excessive force.

        The result is empty if no force is excessive.

        A call to ``excess`` takes 1 µs if the arm has no contacts.
        """
        passed, self._last = time - self._last, time
        if not (self._is_loaded or self._world.is_touched(self._links)):
            return ""
        share = 1.0 - math.exp(-passed / DETECTION_TIME) if passed >= 0.0 else 1.0
        touching, largest = self._world.contacts(), box.safety_limits.force
        carried = box.payload.mass - self._tool_mass
        self._is_loaded = False
        for body in self._bodies:
            force, filtered = _exerted(body.links, touching), body.force
            if body is self._bodies[-1] and any(force):  # the tool carries the payload
                for k, g in enumerate(self._world.gravity):
                    force[k] += carried * g
            for k in range(3):
                filtered[k] += share * (force[k] - filtered[k])
            strength = math.hypot(*filtered)
            self._is_loaded |= strength > _NEGLIGIBLE
            if not strength <= largest:
                why = contacts_text(external_contacts((body.links,), touching))
                return (
                    f"contact force of {strength:.0f} N at '{body.name}', more than "
                    f"{largest:.0f} N ({why})"
                )
        return ""


def _exerted(links: frozenset[str], touching: Sequence[Contact]) -> list[float]:
    """Return the resultant force that ``links`` exert on all other bodies [N].

    The forces on a gripped object cancel each other; the remaining force is due to the
    object's weight, its inertia and its other contacts.
    """
    total = [0.0, 0.0, 0.0]
    for contact in touching:
        is_first = contact.first in links
        if is_first != (contact.second in links):
            sign = 1.0 if is_first else -1.0
            for k in range(3):
                total[k] += sign * contact.force[k]
    return total
