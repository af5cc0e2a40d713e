"""Detection of contacts of a tool that moves in a direction."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, final

import numpy as np

from tool0.protocol.program import UntilStep
from tool0.simulation.simulation import Simulation

if TYPE_CHECKING:
    from tool0.description.scene_state import Contact
    from tool0.kinematics.chain import Array
    from tool0.programs.robot_context import RobotContext

CONTACT_FORCE: Final = 1.0
"""Smallest increase of the contact force against the direction of motion that is
treated as a contact [N]."""


@final
class Touch:
    """Monitors the contacts of an arm's tool.

    Only the thread that executes the tick may use ``Touch``.

    The tool consists of the links beyond the last joint, and of an object that the
    gripper holds.  Contacts of the tool with any other body are detected.  Contacts
    that exist at the start are ignored until their force against the direction of
    motion increases.
    """

    def __init__(
        self, simulation: Simulation, context: RobotContext, step: UntilStep
    ) -> None:
        self._core, self._context = simulation.core, context
        self._force = step.force
        self._links = frozenset(context.model.links_from(context.joints[-1].child))
        self._direction = context.direction(step, context.tool(self._posture())[0])
        self._start: float | None = None
        """Force against the direction of motion at the start [N]."""
        self._known: frozenset[frozenset[str]] = frozenset()
        self._group = self._links
        self._has_occurred = False
        self._contacts()  # an engine may record contacts only after the first call

    def has_occurred(self) -> bool:
        """Return whether a contact or the requested force has already occurred."""
        if not self._has_occurred:
            self._has_occurred = (
                self._is_touching() if self._force is None else self._is_pushing()
            )
        return self._has_occurred

    def _is_touching(self) -> bool:
        contacts = self._contacts()
        is_first = self._start is None
        if self._start is None:
            self._group = self._links | self._held(contacts)
        external = [
            item
            for item in contacts
            if (item.first in self._group) != (item.second in self._group)
        ]
        pairs = frozenset(frozenset((item.first, item.second)) for item in external)
        opposing = -float(
            sum((self._on_tool(item) for item in external), np.zeros(3))
            @ self._direction
        )
        if self._start is None:
            self._start, self._known = opposing, pairs
        return not is_first and (
            not pairs <= self._known or opposing - self._start > CONTACT_FORCE
        )

    def _on_tool(self, contact: Contact) -> Array:
        force = np.array(contact.force)
        return -force if contact.first in self._group else force

    def _held(self, contacts: tuple[Contact, ...]) -> frozenset[str]:
        """Return the names of the objects that the gripper holds."""
        geometry = self._context.geometry
        if geometry is None or geometry.name not in self._core.grip_contacts.gripping:
            return frozenset()
        names = {
            name
            for item in contacts
            if item.first in self._links or item.second in self._links
            for name in (item.first, item.second)
        }
        return frozenset(names.intersection(self._context.objects))

    def _is_pushing(self) -> bool:
        assert self._force is not None
        sample = self._core.arm_samples()[self._context.arm]
        R = self._context.tool(self._posture())[0][:3, :3]
        T_tip_tool = self._context.T_tip_tool
        R_root_tip = R @ T_tip_tool[:3, :3].T
        opposing = -float(R_root_tip @ np.array(sample.wrench[:3]) @ self._direction)
        if self._start is None:
            self._start = opposing
        return opposing - self._start >= self._force

    def _posture(self) -> Array:
        core = self._core
        index = core.hardware.index
        q = [core.state.position[index[name]] for name in self._context.joint_names]
        return np.array([q])

    def _contacts(self) -> tuple[Contact, ...]:
        return self._core.engine.world.contacts()
