"""Joints at rest that are at their effort limit or far from their setpoint."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from operator import ge
from typing import final

from tool0.description.model import JointLimits, RobotModel
from tool0.description.scene_state import Contact
from tool0.hardware.engine import JointState, joint_selector
from tool0.hardware.limits import PUSHING
from tool0.hardware.robot_hardware import RobotHardware
from tool0.protocol.state import Stall

logger = logging.getLogger(__name__)

STALL_TIME = 0.5
"""Time for which a joint must push at its limit without moving before it is considered
stalled [s]."""
LARGEST_LAG = 0.05
"""Maximum distance between a joint's measured position and its setpoint, as a travel
time at full speed [s]. The value is an estimate, because UR does not publish the limit.
For a UR5, the distance is 0.16 rad."""
LAG_PERIOD = 0.1
"""Simulated time between two comparisons of the joints with their setpoints [s]. A
comparison takes about 20 µs."""
STILL = 0.005
"""Travel below which a joint is considered to be at rest [rad | m]."""
CHATTER_TIME = 0.05
"""Longest time for which the effort may be below the limit without ending a push [s].
The effort varies because contacts chatter."""
MIN_CONTACT_SHARE = 0.1
"""Fraction of the strongest contact force below which a contact is not considered to
stop a joint."""


def external_contacts(
    groups: Iterable[frozenset[str]], contacts: Sequence[Contact]
) -> tuple[tuple[str, str], ...]:
    """Return contacts between a group of links and other bodies, strongest first.

    The links that a joint moves form a group, because contacts within the group do not
    stop the joint. The link of the group is the first element of each pair.
    """
    sides, found = tuple(groups), []
    for contact in contacts:
        pair = contact.first, contact.second
        for links in sides:
            if (pair[0] in links) != (pair[1] in links):
                ordered = pair if pair[0] in links else pair[::-1]
                found.append((math.hypot(*contact.force), ordered))
                break
    found.sort(reverse=True)
    return tuple(
        pair for force, pair in found if force >= MIN_CONTACT_SHARE * found[0][0]
    )


@final
class StallMonitor:
    """Detects stalled joints. Only the thread that owns the tick may use the monitor.

    The drives of grippers are ignored, because they are meant to push without moving.
    """

    def __init__(self, model: RobotModel, hardware: RobotHardware) -> None:
        grippers = {gripper.joint for gripper in model.grippers}
        self._drives = [
            _Drive(name, hardware.index[name], limits, model)
            for name, limits in hardware.limits.items()
            if name not in grippers and 0.0 < limits.effort < math.inf
        ]
        self._select = joint_selector([drive.index for drive in self._drives])
        self._limits = [drive.limit for drive in self._drives]
        self._last = self._compared = -math.inf
        """Times at which a joint last pushed at its limit, and at which the setpoints
        were last compared [s]."""
        self._lagging: list[_Drive] = []
        """Drives that are far from their setpoints."""
        self.stalls: tuple[Stall, ...] = ()

    def look(
        self,
        state: JointState,
        contacts: Callable[[], tuple[Contact, ...]],
        wanted: Callable[[], Mapping[str, float]],
    ) -> None:
        """Update the stalls from ``state``.

        ``contacts`` is called from the first push onward, because an engine may record
        contacts only after the first call. ``wanted`` returns the setpoint of each
        joint that is controlled by position [rad | m].
        """
        if not 0.0 <= state.time - self._compared < LAG_PERIOD:
            self._compared = state.time
            positions = wanted()
            self._lagging = [d for d in self._drives if d.lags(state, positions)]
        if any(map(ge, map(abs, self._select(state.effort)), self._limits)):
            self._last = state.time
        elif not (self._lagging or state.time - self._last < CHATTER_TIME):
            self.stalls = ()
            return
        pushing = [drive for drive in self._drives if drive.pushes(state)]
        touching = contacts()
        known = {stall.joint for stall in self.stalls}
        found = {
            drive.joint: drive.stall(state, touching)
            for drive in pushing
            if state.time - drive.since >= STALL_TIME
        }
        for drive in self._lagging:
            if state.time - drive.lagging_since >= STALL_TIME:
                stall = drive.stall(state, touching)._replace(lag=drive.lag)
                found.setdefault(drive.joint, stall)
        self.stalls = tuple(found.values())
        for stall in self.stalls:
            if stall.joint not in known:
                logger.warning("%s", stall)

    def forget(self) -> None:
        """Discard all pushes, for example after a reset."""
        self.stalls = ()
        self._last = self._compared = -math.inf
        self._lagging = []
        for drive in self._drives:
            drive.since = drive.last = -math.inf
            drive.lagging_since = math.inf


@final
class _Drive:
    """Observed state of one joint."""

    def __init__(
        self, joint: str, index: int, limits: JointLimits, model: RobotModel
    ) -> None:
        self.joint = joint
        self.index = index
        self.links = frozenset(model.links_from(model.joint(joint).child))
        self.since = -math.inf
        """Time at which the joint started to push at its current position [s]."""
        self.last = -math.inf
        """Time at which the joint last pushed at its limit [s]."""
        self.limit = PUSHING * limits.effort
        """Effort above which the joint is considered to push [N·m | N]."""
        self._position = 0.0
        self._sign = 0.0
        self.lag = 0.0
        """Distance of the joint from its setpoint [rad | m]."""
        self.lagging_since = math.inf
        """Time since which the joint has been far from its setpoint without moving
        [s]."""
        self._most = LARGEST_LAG * limits.velocity
        self._lags_at = 0.0

    def stall(self, state: JointState, touching: Sequence[Contact]) -> Stall:
        """Return the stall of this joint with its contacts."""
        contacts = external_contacts((self.links,), touching)
        return Stall(self.joint, state.effort[self.index], contacts)

    def lags(self, state: JointState, wanted: Mapping[str, float]) -> bool:
        """Return whether the joint is far from its setpoint; record the start time."""
        position = state.position[self.index]
        self.lag = abs(wanted.get(self.joint, position) - position)
        if self.lag <= self._most:
            self.lagging_since = math.inf
            return False
        has_moved = abs(position - self._lags_at) > STILL
        if has_moved or not self.lagging_since <= state.time:
            self.lagging_since, self._lags_at = state.time, position
        return True

    def pushes(self, state: JointState) -> bool:
        """Return whether the joint pushes; record when the push started."""
        effort, time = state.effort[self.index], state.time
        if abs(effort) < self.limit:
            return time - self.last < CHATTER_TIME
        position, sign = state.position[self.index], math.copysign(1.0, effort)
        has_moved = abs(position - self._position) > STILL
        if has_moved or sign != self._sign or not time - self.last < CHATTER_TIME:
            self.since, self._position, self._sign = time, position, sign
        self.last = time
        return True
