"""Detection of fingers that press on an object from both sides, as in a grip."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Sequence
from typing import final

from tool0.description.grasp_frames import pad_links
from tool0.description.model import ParallelGripper, RobotModel
from tool0.description.scene_state import Contact
from tool0.description.transform import Vector3
from tool0.errors import ControlError
from tool0.hardware.engine import JointState
from tool0.sensing.grasp import PUSH

PERIOD = 0.04
"""Simulated time between contact checks of pushing fingers [s]. A check takes about 50
µs in an engine, and a grip is reported after 0.1 s."""
GRACE = 0.1
"""Simulated time for which a grip remains valid after the last check that detected it
[s]. A chattering finger is sometimes not in contact."""


@final
class GripContacts:
    """Checks the contacts of all grippers in the thread of the tick."""

    def __init__(self, model: RobotModel, joint_names: Sequence[str]) -> None:
        """Start without grips; ``joint_names`` is the order of joints in the states."""
        self._hands = [
            _Hand(model, gripper, joint_names.index(gripper.joint))
            for gripper in model.grippers
        ]
        self.gripping: tuple[str, ...] = ()
        """Names of the grippers whose fingers press on an object from two sides."""

    def look(
        self, state: JointState, contacts: Callable[[], tuple[Contact, ...]]
    ) -> None:
        """Update the grips from ``state``; call ``contacts`` while fingers push."""
        for hand in self._hands:
            if hand.changes(state, contacts):
                self.gripping = tuple(h.name for h in self._hands if h.is_gripping)

    def note(self, gripping: Collection[str]) -> None:
        """Use the grips that real grippers report."""
        self.gripping = tuple(h.name for h in self._hands if h.name in gripping)

    def forget(self) -> None:
        """Discard all grips, for example after a reset."""
        self.gripping = ()
        for hand in self._hands:
            hand.forget()


@final
class _Hand:
    """One gripper and the links of each of its fingers."""

    def __init__(self, model: RobotModel, gripper: ParallelGripper, index: int) -> None:
        self.name = gripper.name
        self._index = index
        self._lever = gripper.law.lever
        self._weakest = PUSH * gripper.force[0]
        """Force above which the fingers are considered to push [N]."""
        self._links = frozenset(model.link_by_name)
        try:
            pads = pad_links(model, gripper)
        except ControlError:  # the fingers are unknown without pads
            self._fingers = None
        else:
            base = model.joint(gripper.joint).parent
            self._fingers = tuple(finger_links(model, base, pad) for pad in pads)
        self.forget()

    def forget(self) -> None:
        self.is_gripping = False
        self._looked = self._gripped = -math.inf

    def changes(
        self, state: JointState, contacts: Callable[[], tuple[Contact, ...]]
    ) -> bool:
        """Update the grip from ``state``; return whether ``is_gripping`` changed."""
        time, position, _, effort = state
        i = self._index
        if time - self._looked >= PERIOD and abs(
            effort[i]
        ) >= self._weakest * self._lever(position[i]):
            self._looked = time
            if self._fingers is None or self._is_pressed(self._fingers, contacts()):
                self._gripped = time
        before = self.is_gripping
        self.is_gripping = time - self._gripped <= GRACE
        return self.is_gripping != before

    def _is_pressed(
        self, fingers: Iterable[frozenset[str]], contacts: tuple[Contact, ...]
    ) -> bool:
        """Return whether the forces on the two fingers have opposite directions.

        If the fingers rest on a table, both forces have the same direction.
        """
        one, two = (self._force_on(finger, contacts) for finger in fingers)
        return sum(a * b for a, b in zip(one, two, strict=True)) < 0.0

    def _force_on(
        self, finger: frozenset[str], contacts: tuple[Contact, ...]
    ) -> Vector3:
        """Return the force on a finger from all bodies except the robot [N]."""
        x = y = z = 0.0
        for contact in contacts:
            first, second = contact.first, contact.second
            fx, fy, fz = contact.force
            if second in finger and first not in self._links:
                x, y, z = x + fx, y + fy, z + fz
            elif first in finger and second not in self._links:
                x, y, z = x - fx, y - fy, z - fz
        return x, y, z


def finger_links(model: RobotModel, base: str, pad: str) -> frozenset[str]:
    """Return the links between a gripper's base and a pad, including the pad's link."""
    found = []
    link = pad
    while link != base:
        found.append(link)
        link = model.parent_joint[link].parent
    return frozenset(found)
