"""Grasp assist: fixes gripped objects to the gripper.  Off by default.

No real gripper does so.  It is for users who study what follows a grasp, with any
friction and force.  An object that both pads touch is fixed to the gripper's base, from
the time the gripper holds it until it is commanded to open or its pads move.
"""

from __future__ import annotations

import logging
from typing import final

from tool0.description.model import ParallelGripper, RobotModel
from tool0.errors import ConfigError
from tool0.hardware.engine import Engine
from tool0.sensing.grasp import TOLERANCE, GraspDetector, pad_links, wanted_openings
from tool0.sensing.snapshot import Snapshot

logger = logging.getLogger(__name__)

WARNING = (
    "grasp assist is on: objects are fixed to the gripper that holds them, "
    "which no real gripper does"
)
PADS_MOVED = 0.002
"""Motion of the pads that releases the object [m]: more than from a stronger grip."""


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
        """Attach and detach objects at ``snapshot``, the newest one."""
        for assisted in self._grippers:
            state = assisted.detector.observe(snapshot)
            if assisted.held is not None:
                if assisted.releases(snapshot, state.opening):
                    self._world.detach(assisted.held)
                    assisted.held = None
            elif state.motion == "holding_inside":
                name = self._between(assisted.pads, snapshot)
                if name is not None:
                    self._world.attach(name, assisted.base)
                    assisted.held, assisted.opening = name, state.opening

    def forget(self) -> None:
        """Forget held objects: a reset has detached them."""
        for assisted in self._grippers:
            assisted.forget()

    def _between(self, pads: tuple[str, str], snapshot: Snapshot) -> str | None:
        """Return the movable object that both pads press on, if there is one."""
        pairs = [{c.first, c.second} for c in self._world.contacts()]
        # An object that another gripper hands over is attached after that releases it.
        held = {assisted.held for assisted in self._grippers}
        for item in snapshot.scene:
            if item.mass is None or item.name in held:
                continue
            if all({pad, item.name} in pairs for pad in pads):
                return item.name
        return None


@final
class _AssistedGripper:
    """One gripper, and the object attached to it."""

    def __init__(self, model: RobotModel, gripper: ParallelGripper) -> None:
        self.gripper = gripper
        self.base = model.joint(gripper.joint).parent
        self.pads = pad_links(model, gripper)
        self.opening = 0.0
        """Of the gripper when the object was attached [m]."""
        self.forget()

    def forget(self) -> None:
        """Hold nothing, without a history."""
        self.detector = GraspDetector(self.gripper)
        self.held: str | None = None

    def releases(self, snapshot: Snapshot, opening: float) -> bool:
        """Return whether the gripper is to open, or its pads have moved."""
        if abs(opening - self.opening) > PADS_MOVED:
            return True
        wanted = wanted_openings(snapshot, self.gripper)
        return wanted is not None and wanted[1] > self.opening + TOLERANCE
