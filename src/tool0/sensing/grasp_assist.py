"""The cheat that holds what a gripper grips: ``--grasp-assist``, off unless asked for.

No hand does so.  It is for who wants to work on what comes after a grasp, on whatever
friction and force: what both pads touch, once the gripper holds, is fixed to the
gripper's base until the gripper is told to open, or its pads move.
"""

from __future__ import annotations

import logging
from typing import NamedTuple, final

from tool0.description.model import ParallelGripper, RobotModel
from tool0.errors import ConfigError
from tool0.hardware.engine import Engine
from tool0.sensing.grasp import TOLERANCE, GraspDetector, wanted_openings
from tool0.sensing.pads import pad_links
from tool0.sensing.snapshot import Snapshot

logger = logging.getLogger(__name__)

WARNING = (
    "grasp assist is on: a cheat, which fixes to the gripper what it grips; "
    "what is held says nothing about the grip"
)
PADS_MOVED = 0.002
"""Way of the pads from which what they held is let go [m]: more than a stronger grip
squeezes them together."""


@final
class GraspAssist:
    """Attaches and detaches.  Only the thread that owns the tick may touch it."""

    def __init__(self, model: RobotModel, engine: Engine) -> None:
        """Hold nothing yet, and log that this is a cheat.

        Raises:
            ConfigError: If there is no gripper.
            ControlError: If a gripper has no two pads.
        """
        if not model.grippers:
            raise ConfigError("grasp assist needs a gripper, and this robot has none")
        logger.warning(WARNING)
        self._engine = engine
        self._hands = [_Hand(model, gripper) for gripper in model.grippers]

    def look(self, snapshot: Snapshot) -> None:
        """Attach what is held at ``snapshot``, the newest, and detach what is not."""
        for hand in self._hands:
            self._look(hand, snapshot)

    def forget(self) -> None:
        """Know that a reset has detached everything and moved the pads."""
        for hand in self._hands:
            hand.forget()

    def _look(self, hand: _Hand, snapshot: Snapshot) -> None:
        state = hand.detector.observe(snapshot)
        if hand.held is not None:
            if hand.lets_go(snapshot, state.opening):
                self._engine.detach(hand.held.name)
                hand.held = None
        elif state.motion == "holding_inside":
            name = self._between(hand.pads, snapshot)
            if name is not None:
                self._engine.attach(name, hand.base)
                hand.held = _Held(name, state.opening)

    def _between(self, pads: tuple[str, str], snapshot: Snapshot) -> str | None:
        """Return the object that both pads press on, if there is one that can move."""
        contacts = self._engine.contacts()
        pressed = [
            {
                c.second if c.first == pad else c.first
                for c in contacts
                if pad in (c.first, c.second)
            }
            for pad in pads
        ]
        # What another gripper hands over is attached once that has let go.
        taken = {hand.held.name for hand in self._hands if hand.held is not None}
        for item in snapshot.scene:
            if item.mass is None or item.name in taken:
                continue
            if all(item.name in names for names in pressed):
                return item.name
        return None


class _Held(NamedTuple):
    name: str
    opening: float
    """Of the gripper when it was attached [m]."""


@final
class _Hand:
    """One gripper, and what is attached to it."""

    def __init__(self, model: RobotModel, gripper: ParallelGripper) -> None:
        self.gripper = gripper
        self.base = model.joint(gripper.joint).parent
        self.pads = pad_links(model, gripper)
        self.forget()

    def forget(self) -> None:
        """Hold nothing, and know nothing of what was before."""
        self.detector = GraspDetector(self.gripper)
        self.held: _Held | None = None

    def lets_go(self, snapshot: Snapshot, opening: float) -> bool:
        """Return whether the gripper is to open, or its pads have moved."""
        held = self.held
        if held is None or abs(opening - held.opening) > PADS_MOVED:
            return True
        wanted = wanted_openings(snapshot, self.gripper)
        return wanted is not None and wanted[1] > held.opening + TOLERANCE
