"""Springs that pull links toward target points, for manual guidance of an arm.

The force is updated in the thread of the tick.  If a client computed the force from
snapshots, the force would be delayed, and a light wrist would oscillate.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple, final

from tool0.description.forward_kinematics import link_pose
from tool0.description.model import RobotModel
from tool0.description.transform import Vector3
from tool0.hardware.engine import JointState
from tool0.simulation.applied_wrenches import AppliedWrench, AppliedWrenches

PERIOD: Final = 0.004
"""Simulated time between two force updates of a spring [s]."""
_ROUNDING: Final = 1e-9
"""Tolerance for differences between a time and a multiple of the tick [s]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class PullSpring:
    """A damped spring between a point of a link and a fixed target point."""

    link: str
    point: Vector3
    """Attachment point in the link's frame [m]."""
    target: Vector3
    """Target point in the robot's root frame [m]."""
    stiffness: float
    """Stiffness of the spring [N/m]."""
    damping: float
    """Damping of the spring [N·s/m]."""
    max_force: float
    """Largest force of the spring [N]."""
    duration: float
    """Duration of the pull [s]."""


class _Pull(NamedTuple):
    spring: PullSpring
    until: float
    """Time at which the pull ends [s]."""
    due: float
    """Time at which the next force update is due [s]."""
    before: Vector3
    """Position of the attachment point when the last force began, in the robot's root
    frame [m]."""


@final
class PullSprings:
    """Springs, with at most one spring per link.

    Only the thread that executes the tick may use ``PullSprings``.
    """

    def __init__(
        self, model: RobotModel, joint_names: Sequence[str], wrenches: AppliedWrenches
    ) -> None:
        self._model, self._wrenches = model, wrenches
        self._joint_names = tuple(joint_names)
        self._pulls: dict[str, _Pull] = {}

    @property
    def is_idle(self) -> bool:
        """Whether a call to ``tick`` has no effect."""
        return not self._pulls

    def pull(self, spring: PullSpring, now: JointState) -> None:
        """Pull a link, starting with the next tick.

        The spring replaces an existing spring on the link.

        Raises:
            ModelError: If there is no such link.
            EngineError: If the link cannot move.
        """
        link = self._model.link(spring.link).name
        self._wrenches.check(link)
        until = now.time + spring.duration
        known = self._pulls.get(link)
        if known is None or known.spring.point != spring.point:
            here = self._place(spring, now)
            self._pulls[link] = _Pull(spring, until, now.time, here)
        else:
            self._pulls[link] = known._replace(spring=spring, until=until)

    def release(self, link: str | None = None) -> None:
        """Remove the spring from one link, or remove all springs."""
        self._pulls = {
            name: pull
            for name, pull in self._pulls.items()
            if link is not None and name != link
        }

    def tick(self, state: JointState) -> None:
        """Apply the forces that are due, and end expired springs."""
        now = state.time + _ROUNDING
        for link, pull in list(self._pulls.items()):
            if pull.until <= now:
                del self._pulls[link]
            elif pull.due <= now:
                here = self._place(pull.spring, state)
                self._push(pull, here, state.time)
                due = state.time + PERIOD
                self._pulls[link] = pull._replace(due=due, before=here)

    def _push(self, pull: _Pull, here: Vector3, now: float) -> None:
        spring = pull.spring
        x, y, z = (
            spring.stiffness * (there - at) - spring.damping * (at - was) / PERIOD
            for there, at, was in zip(spring.target, here, pull.before, strict=True)
        )
        part = min(1.0, spring.max_force / (math.hypot(x, y, z) or math.inf))
        self._wrenches.add(
            AppliedWrench(
                name=spring.link,
                force=(part * x, part * y, part * z),
                torque=(0.0, 0.0, 0.0),
                point=here,
                start=now,
                duration=PERIOD,
            )
        )

    def _place(self, spring: PullSpring, state: JointState) -> Vector3:
        """Return the spring's attachment point in the robot's root frame [m]."""
        position = dict(zip(self._joint_names, state.position, strict=True))
        return link_pose(self._model, position, spring.link).apply(spring.point)
