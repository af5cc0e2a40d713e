"""Whether a gripper moves, has arrived, or holds something: as Robotiq's ``gOBJ``."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, final

from tool0.description.model import ParallelGripper
from tool0.sensing.snapshot import Snapshot

GripperMotion = Literal[
    "moving", "at_target", "holding_inside", "holding_outside", "idle"
]

WINDOW = 0.1
"""Simulated time over which pads must have been still to hold something [s]: the pads
of a simulated grip chatter, so no instant's velocity tells."""
STILL = 0.0002
"""Way within the window up to which pads count as still [m]; the slowest speed of a
2F-85 makes ten times that, weak gains creep to their target at twice that."""
CREEP = 0.0005
"""The same for pads that push firmly: what they squeeze gives way."""
MOVED = 2.0 * CREEP
"""Way within the window from which pads that were still move again [m]."""
PARALLEL = math.radians(3.0)
"""How far a linkage may be from where it rests while it pinches: what presses on the
pads bends it by up to 1°, fingers that wrap leave it by 5° and more."""
_ROUNDING = 1e-6  # [s]
TOLERANCE = 0.001
"""How far from where they are wanted pads count as there [m]: what a PID leaves, so
that what is squeezed by less than this is not noticed."""
PUSH = 0.05
"""Part of the weakest grip from which the drive counts as pushing: 1 N for a 2F-85,
whose own weight and friction take up to 0.8 N at a pad that nothing touches."""
FIRM = 0.5
"""Part of the weakest grip from which the drive counts as pushing firmly."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class GraspState:
    motion: GripperMotion
    """``holding_inside`` squeezes between the pads, ``holding_outside`` presses them
    apart against something; ``idle`` if no controller wants a position of them."""
    opening: float
    """Distance between the pads [m]."""
    width: float | None = None
    """Of what is held between the pads [m]; None where fingers wrap around it."""

    @property
    def gobj(self) -> int:
        """The same as Robotiq's register: 0 … 3; 0 if ``idle``.

        0 is on the way, 1 stopped by something while opening, 2 while closing, 3 where
        it was sent, with nothing in the way.
        """
        return _GOBJ[self.motion]


_GOBJ: dict[GripperMotion, int] = {
    "moving": 0,
    "idle": 0,
    "holding_outside": 1,
    "holding_inside": 2,
    "at_target": 3,
}


class _Sample(NamedTuple):
    time: float
    position: float
    """Of the driven joint [rad]."""
    opening: float
    effort: float


@final
class GraspDetector:
    """Judges one gripper by the snapshots that it is shown, in their order.

    It tells by what the controller wants: pads that stand still, where they are not
    wanted, and are pushed on, have something in their way.
    """

    def __init__(self, geometry: ParallelGripper) -> None:
        self._geometry = geometry
        self._samples: deque[_Sample] = deque()
        self._target: float | None = None
        self._was_still = True

    def observe(self, snapshot: Snapshot) -> GraspState:
        """Return the state at a snapshot not older than the last; older is a reset."""
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
            self._target = target
        self._remember(
            _Sample(snapshot.time, position, opening, snapshot.effort[index])
        )
        motion: GripperMotion = "idle" if wanted is None else self._judge(*wanted)
        pinches = motion == "holding_inside" and _is_parallel(geometry, snapshot)
        return GraspState(
            motion=motion,
            opening=opening,
            width=opening if pinches else None,
        )

    def _remember(self, sample: _Sample) -> None:
        """Keep what is needed to look back over the window, and no more."""
        samples = self._samples
        samples.append(sample)
        while len(samples) > 1 and samples[1].time <= sample.time - WINDOW:
            samples.popleft()

    def _judge(self, desired: float, target: float) -> GripperMotion:
        """Return the state for openings that are wanted now and in the end [m]."""
        openings = [sample.opening for sample in self._samples]
        way = max(openings) - min(openings)
        last = self._samples[-1]
        lack = desired - last.opening
        push = self._push() * math.copysign(1.0, lack) / self._geometry.force[0]
        still = CREEP if push >= FIRM else STILL
        self._was_still = way <= (MOVED if self._was_still else still)
        if not self._was_still:
            return "moving"
        is_there = abs(lack) <= TOLERANCE
        is_long_still = last.time - self._samples[0].time >= WINDOW - _ROUNDING
        if is_long_still and not is_there and push >= PUSH:
            return "holding_inside" if lack < 0.0 else "holding_outside"
        if abs(target - desired) <= TOLERANCE and (is_there or is_long_still):
            return "at_target"
        return "moving"

    def _push(self) -> float:
        """Return how hard the drive opened the pads over the window, on average [N]."""
        samples = self._samples
        lever = self._geometry.lever(samples[-1].position)
        # A positive effort closes the gripper: the opening shrinks.
        return -sum(sample.effort for sample in samples) / len(samples) / lever


def _is_parallel(gripper: ParallelGripper, snapshot: Snapshot) -> bool:
    """Return whether the pads are parallel, as they are unless fingers wrap."""
    position = dict(zip(snapshot.joint_names, snapshot.position, strict=True))
    drive = position[gripper.joint]
    return all(
        abs(position[name] - way.multiplier * drive - way.offset) <= PARALLEL
        for name, way in gripper.passive
    )


def judge(geometry: ParallelGripper, snapshots: Sequence[Snapshot]) -> GraspState:
    """Return the state at the end of ``snapshots``, which are not empty.

    What came before the last ``WINDOW`` matters little, and what came before a new
    target not at all.
    """
    detector = GraspDetector(geometry)
    return [detector.observe(snapshot) for snapshot in snapshots][-1]


def wanted_openings(
    snapshot: Snapshot, gripper: ParallelGripper
) -> tuple[float, float] | None:
    """Return the openings wanted now and in the end [m]; None if none are."""
    wanted = snapshot.desired_and_target(gripper.joint)
    if wanted is None:
        return None
    desired, target = wanted
    return gripper.opening(desired), gripper.opening(target)
