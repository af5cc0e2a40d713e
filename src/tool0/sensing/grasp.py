"""Grasps: gripper motion, held objects, parallel pads and grasp assist.

Grasp assist fixes gripped objects to the gripper. Grasp assist is off by default,
because no real gripper fixes objects. Grasp assist is intended for users who study the
task after a grasp, regardless of friction and force. An object that both pads touch is
fixed to the gripper's base as soon as the gripper holds it. The object is released when
the gripper is commanded to open or the pads move.
"""

from __future__ import annotations

import logging
import math
from collections import deque
from collections.abc import Sequence
from typing import NamedTuple, final

from tool0.description.grasp_frames import pad_links
from tool0.description.model import ParallelGripper, RobotModel
from tool0.errors import ConfigError
from tool0.hardware.engine import Engine
from tool0.protocol.gripper import GraspState, GripperMotion
from tool0.protocol.state import Snapshot

WINDOW = 0.1
"""Simulated time for which the pads must be at rest before a gripper is considered to
hold an object [s]. The pads of a simulated grip chatter, so their velocity at one time
is not a suitable criterion."""
SHORT_OF_IT = 0.3
"""Time for which pads must be at rest before their motion is considered complete, if
they are neither at their target nor pushing [s]. A real gripper reports an object up to
0.15 s after its pads have started to push the object."""
STILL = 0.1
"""Pads are considered to be at rest if their travel within the window is less than this
fraction of the travel at the slowest speed. With weak gains, pads creep to their target
at twice this fraction of the travel."""
CREEP = 2.5 * STILL
"""Fraction that replaces ``STILL`` for pads that push firmly. The fraction is larger
because the object yields."""
MOVED = 2.0 * CREEP
"""Fraction of the same travel above which pads at rest are considered to move again."""
PARALLEL = math.radians(3.0)
"""Maximum deviation of a linkage from its rest shape in a pinch grip [rad]. The grip
force bends the linkage by up to 1°, whereas fingers that wrap an object deviate by 5°
or more."""
_ROUNDING = 1e-6  # [s]
TOLERANCE = 0.001
"""Maximum steady-state error of pads that have reached their target [m]. An object that
is squeezed by less than the steady-state error is not detected."""
PUSH = 0.05
"""Fraction of the minimum grip force above which the drive is considered to push. If
the pads are free, the weight and friction of the fingers need less force than this
fraction. On a 2F-85, the fingers need 0.8 N, and the fraction corresponds to 1 N."""
FIRM = 0.5
"""Fraction of the minimum grip force above which the drive is considered to push
firmly."""


class _Sample(NamedTuple):
    time: float
    position: float
    """Position of the driven joint [rad | m]."""
    opening: float
    effort: float


@final
class GraspDetector:
    """Detects the state of one gripper from consecutive snapshots.

    Pads have met an object if they are at rest away from the controller's setpoint, the
    drive pushes them, and a body presses on both fingers.
    """

    def __init__(self, geometry: ParallelGripper) -> None:
        self._geometry = geometry
        self._slowest_travel = geometry.speed[0] * WINDOW
        self._samples: deque[_Sample] = deque()
        self._target: float | None = None
        self._was_still = True
        self._still_since = math.inf
        """Simulated time at which the gripper came to rest [s]."""

    def observe(self, snapshot: Snapshot) -> GraspState:
        """Return the state at a snapshot; an older snapshot indicates a reset."""
        geometry = self._geometry
        index = snapshot.joint_names.index(geometry.joint)
        position = snapshot.position[index]
        opening = max(0.0, geometry.opening(position))
        wanted = wanted_openings(snapshot, geometry)
        target = None if wanted is None else wanted[1]
        if target != self._target or (
            self._samples and snapshot.time < self._samples[-1].time
        ):
            self._samples.clear()
            self._target, self._still_since = target, math.inf
        self._remember(
            _Sample(snapshot.time, position, opening, snapshot.effort[index])
        )
        motion: GripperMotion = "idle" if wanted is None else self._judge(*wanted)
        if motion.startswith("holding") and geometry.name not in snapshot.gripping:
            motion = "blocked"
        pinches = motion == "holding_inside" and _is_parallel(geometry, snapshot)
        return GraspState(
            motion=motion,
            opening=opening,
            width=opening if pinches else None,
        )

    def _remember(self, sample: _Sample) -> None:
        """Add a sample and remove the samples that are older than the window."""
        samples = self._samples
        samples.append(sample)
        while len(samples) > 1 and samples[1].time <= sample.time - WINDOW:
            samples.popleft()

    def _judge(self, desired: float, target: float) -> GripperMotion:
        """Return the motion for the desired opening and the final opening [m]."""
        openings = [sample.opening for sample in self._samples]
        way = (max(openings) - min(openings)) / self._slowest_travel
        last = self._samples[-1]
        lack = desired - last.opening
        push = self._push() * math.copysign(1.0, lack) / self._geometry.force[0]
        still = CREEP if push >= FIRM else STILL
        self._was_still = way <= (MOVED if self._was_still else still)
        if not self._was_still:
            self._still_since = math.inf
            return "moving"
        self._still_since = min(self._still_since, last.time)
        is_there = abs(lack) <= TOLERANCE
        is_long_still = last.time - self._samples[0].time >= WINDOW - _ROUNDING
        if is_long_still and not is_there and push >= PUSH:
            return "holding_inside" if lack < 0.0 else "holding_outside"
        has_ended = last.time - self._still_since >= SHORT_OF_IT - _ROUNDING
        if abs(target - desired) <= TOLERANCE and (is_there or has_ended):
            return "at_target"
        return "moving"

    def _push(self) -> float:
        """Return the mean opening force of the drive over the window [N]."""
        samples = self._samples
        lever = self._geometry.lever(samples[-1].position)
        # A positive effort closes every gripper, so the opening decreases.
        return -sum(sample.effort for sample in samples) / len(samples) / lever


def _is_parallel(gripper: ParallelGripper, snapshot: Snapshot) -> bool:
    """Return whether the pads are parallel, so the fingers do not wrap the object."""
    position = snapshot.positions
    drive = position[gripper.joint]
    return all(
        abs(position[name] - way.multiplier * drive - way.offset) <= PARALLEL
        for name, way in gripper.passive
    )


def judge(geometry: ParallelGripper, snapshots: Sequence[Snapshot]) -> GraspState:
    """Return the state at the end of ``snapshots``, which span ``SHORT_OF_IT``."""
    detector = GraspDetector(geometry)
    return [detector.observe(snapshot) for snapshot in snapshots][-1]


def wanted_openings(
    snapshot: Snapshot, gripper: ParallelGripper
) -> tuple[float, float] | None:
    """Return the desired and the final opening [m]; None if there is no setpoint."""
    wanted = snapshot.desired_and_target(gripper.joint)
    if wanted is None:
        return None
    desired, target = wanted
    return gripper.opening(desired), gripper.opening(target)


logger = logging.getLogger(__name__)

WARNING = (
    "grasp assist is on: objects are fixed to the gripper that holds them, "
    "which no real gripper does"
)
PADS_MOVED = 0.002
"""Change of the opening that releases the object [m]; it is larger than any change that
a stronger grip causes."""


@final
class GraspAssist:
    """Attaches and detaches objects in the thread that owns the tick."""

    def __init__(self, model: RobotModel, engine: Engine) -> None:
        """Start without held objects and log a warning.

        Raises:
            ConfigError: If the robot has no gripper.
            ControlError: If a gripper does not have two pads.
        """
        if not model.grippers:
            raise ConfigError("grasp assist needs a gripper, but this robot has none")
        logger.warning(WARNING)
        self._world = engine.world
        self._grippers = [
            _AssistedGripper(model, gripper) for gripper in model.grippers
        ]

    def look(self, snapshot: Snapshot) -> None:
        """Attach and detach objects according to the newest snapshot."""
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
        """Discard held objects after a reset, which has detached them."""
        for assisted in self._grippers:
            assisted.forget()

    def _between(self, pads: tuple[str, str], snapshot: Snapshot) -> str | None:
        """Return the movable object that both pads press on, or None."""
        pairs = [{c.first, c.second} for c in self._world.contacts()]
        # In a handover, the object is attached after the other gripper has released it.
        held = {assisted.held for assisted in self._grippers}
        for item in snapshot.scene:
            if item.mass is None or item.name in held:
                continue
            if all({pad, item.name} in pairs for pad in pads):
                return item.name
        return None


@final
class _AssistedGripper:
    """One gripper and the object that is attached to it."""

    def __init__(self, model: RobotModel, gripper: ParallelGripper) -> None:
        self.gripper = gripper
        self.base = model.joint(gripper.joint).parent
        self.pads = pad_links(model, gripper)
        self.opening = 0.0
        """Opening of the gripper when the object was attached [m]."""
        self.forget()

    def forget(self) -> None:
        """Discard the held object and the history."""
        self.detector = GraspDetector(self.gripper)
        self.held: str | None = None

    def releases(self, snapshot: Snapshot, opening: float) -> bool:
        """Return whether the gripper is commanded to open or its pads have moved."""
        if abs(opening - self.opening) > PADS_MOVED:
            return True
        wanted = wanted_openings(snapshot, self.gripper)
        return wanted is not None and wanted[1] > self.opening + TOLERANCE
