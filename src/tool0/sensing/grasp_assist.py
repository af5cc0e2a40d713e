"""Grasp assist: fixes gripped objects to the gripper.  Off by default.

No real gripper does so.  It is for users who study what follows a grasp, with any
friction and force.  What both pads touch, once the gripper holds, is fixed to the
gripper's base until the gripper is commanded to open, or its pads move.
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
    "grasp assist is on: objects are fixed to the gripper that holds them, "
    "which no real gripper does"
)
PADS_MOVED = 0.002
"""Motion of the pads that releases the object [m]: more than a stronger grip squeezes
them together."""


@final
class GraspAssist:
    """Attaches and detaches.  Only the thread that owns the tick may use it."""

    def __init__(self, model: RobotModel, engine: Engine) -> None:
        """Hold nothing yet, and log the warning.

        Raises:
            ConfigError: If there is no gripper.
            ControlError: If a gripper has no two pads.
        """
        if not model.grippers:
            raise ConfigError("grasp assist needs a gripper, and this robot has none")
        logger.warning(WARNING)
        self._world = engine.world
        self._grippers = [
            _AssistedGripper(model, gripper) for gripper in model.grippers
        ]

    def look(self, snapshot: Snapshot) -> None:
        """Attach what is held at ``snapshot``, the newest, and detach what is not."""
        for assisted in self._grippers:
            self._look(assisted, snapshot)

    def forget(self) -> None:
        """Forget what is held: a reset has detached everything."""
        for assisted in self._grippers:
            assisted.forget()

    def _look(self, assisted: _AssistedGripper, snapshot: Snapshot) -> None:
        state = assisted.detector.observe(snapshot)
        if assisted.held is not None:
            if assisted.lets_go(snapshot, state.opening):
                self._world.detach(assisted.held.name)
                assisted.held = None
        elif state.motion == "holding_inside":
            name = self._between(assisted.pads, snapshot)
            if name is not None:
                self._world.attach(name, assisted.base)
                assisted.held = _Held(name, state.opening)

    def _between(self, pads: tuple[str, str], snapshot: Snapshot) -> str | None:
        """Return the object that both pads press on, if there is one that can move."""
        contacts = self._world.contacts()
        pressed = [
            {
                c.second if c.first == pad else c.first
                for c in contacts
                if pad in (c.first, c.second)
            }
            for pad in pads
        ]
        # What another gripper hands over is attached once that has let go.
        taken = {
            assisted.held.name
            for assisted in self._grippers
            if assisted.held is not None
        }
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
class _AssistedGripper:
    """One gripper, and what is attached to it."""

    def __init__(self, model: RobotModel, gripper: ParallelGripper) -> None:
        self.gripper = gripper
        self.base = model.joint(gripper.joint).parent
        self.pads = pad_links(model, gripper)
        self.forget()

    def forget(self) -> None:
        """Hold nothing, without a history."""
        self.detector = GraspDetector(self.gripper)
        self.held: _Held | None = None

    def lets_go(self, snapshot: Snapshot, opening: float) -> bool:
        """Return whether the gripper is to open, or its pads have moved."""
        held = self.held
        if held is None or abs(opening - held.opening) > PADS_MOVED:
            return True
        wanted = wanted_openings(snapshot, self.gripper)
        return wanted is not None and wanted[1] > held.opening + TOLERANCE
