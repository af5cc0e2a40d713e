"""The one way out: frozen snapshots, the newest or one after the other, and events."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import final

from tool0.control.goal import Goal
from tool0.control.manager import ControllerStatus
from tool0.control.setpoint import Setpoint
from tool0.description.scene import SceneObject
from tool0.hardware.engine import ObjectState

EVENTS_KEPT = 1000
"""Events that a subscriber may fall behind before it loses the oldest."""

SNAPSHOTS_KEPT = 64
"""Snapshots that a subscriber to all of them may fall behind: half a second's."""

SNAPSHOT_PERIOD = 0.008
"""Simulated time between snapshots [s]: 125 Hz, the rate of the UR's own reports.

Commands and short runs publish many at one instant, which must not push out of the
history what came before: there it is the shortest time between two of them."""
_ROUNDING = 1e-6  # [s]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Snapshot:
    """The whole robot at one instant.

    ``position``, ``velocity`` and ``effort`` have shape (n_joints,), ordered as
    ``joint_names``: [rad | m], [rad/s | m/s], [N·m | N].
    """

    time: float
    """Simulated time [s]."""
    tick: int
    joint_names: tuple[str, ...]
    position: tuple[float, ...]
    velocity: tuple[float, ...]
    effort: tuple[float, ...]
    controllers: tuple[ControllerStatus, ...]
    is_paused: bool
    is_stopped: bool
    """Whether the emergency stop is engaged."""
    real_time_factor: float
    """Simulated per wall second, over about the last second."""
    overruns: int
    """Ticks that began more than one control period late, since the start."""
    fault: str | None = None
    """Why the simulation stands still, until it is reset."""
    speed: float | None = None
    """Simulated seconds per wall second that were asked for; None runs only when
    asked to, as fast as possible."""
    setpoints: Mapping[str, Setpoint] = field(default_factory=dict)
    """What each running controller wants of its joints, of those that want anything."""
    scene: tuple[SceneObject, ...] = ()
    """What is around the robot: the same tuple until something comes or goes."""
    objects: tuple[ObjectState, ...] = ()
    """Where it is and how it moves, in the order of ``scene``."""


@final
@dataclass(frozen=True, slots=True)
class GoalFinished:
    goal: Goal


@final
@dataclass(frozen=True, slots=True)
class Overran:
    """Real time was missed during the last second of wall time."""

    count: int
    time: float


@final
@dataclass(frozen=True, slots=True)
class Faulted:
    message: str
    time: float


@final
@dataclass(frozen=True, slots=True)
class WasReset:
    """Robot and objects are where they began."""

    time: float = 0.0
    """Simulated time, which may have gone on [s]."""


Event = GoalFinished | Overran | Faulted | WasReset


@final
class Subscription:
    """What one reader has not yet seen."""

    def __init__(self, bus: Bus) -> None:
        self._bus = bus
        self._seen: Snapshot | None = None
        self.events: deque[Event] = deque(maxlen=EVENTS_KEPT)

    def next(self, timeout: float | None = None) -> Snapshot | None:
        """Wait for a snapshot newer than the last one; None after ``timeout``."""
        newer = self._bus.newer_than(self._seen, timeout)
        if newer is not None:
            self._seen = newer
        return newer

    def following(self, timeout: float | None = None) -> Snapshot | None:
        """Wait for the snapshot after the last one; None after ``timeout``.

        No snapshot is left out unless the reader falls ``SNAPSHOTS_KEPT`` behind.
        """
        following = self._bus.following(self._seen, timeout)
        if following is not None:
            self._seen = following
        return following

    def close(self) -> None:
        self._bus.forget(self)


@final
class Bus:
    """Keeps the newest snapshots.  Publishing never waits for a reader."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._latest: Snapshot | None = None
        self._recent: deque[Snapshot] = deque(maxlen=SNAPSHOTS_KEPT)
        self._history: deque[Snapshot] = deque(maxlen=SNAPSHOTS_KEPT)
        self._subscriptions: tuple[Subscription, ...] = ()

    @property
    def latest(self) -> Snapshot | None:
        return self._latest

    def history(self) -> tuple[Snapshot, ...]:
        """Return the last half second of simulated time, the newest at the end."""
        with self._changed:
            kept, latest = tuple(self._history), self._latest
        return kept if latest is None or kept[-1] is latest else (*kept, latest)

    def subscribe(self) -> Subscription:
        subscription = Subscription(self)
        with self._changed:
            self._subscriptions = (*self._subscriptions, subscription)
        return subscription

    def forget(self, subscription: Subscription) -> None:
        with self._changed:
            self._subscriptions = tuple(
                other for other in self._subscriptions if other is not subscription
            )

    def publish(self, snapshot: Snapshot) -> None:
        with self._changed:
            self._latest = snapshot
            self._recent.append(snapshot)
            before = self._history[-1].time if self._history else -SNAPSHOT_PERIOD
            if not 0.0 <= snapshot.time - before < SNAPSHOT_PERIOD - _ROUNDING:
                self._history.append(snapshot)
            self._changed.notify_all()

    def announce(self, event: Event) -> None:
        for subscription in self._subscriptions:
            subscription.events.append(event)

    def newer_than(
        self, seen: Snapshot | None, timeout: float | None
    ) -> Snapshot | None:
        """Return a snapshot other than ``seen``, or None after ``timeout`` [s]."""
        with self._changed:
            self._changed.wait_for(lambda: self._latest is not seen, timeout)
            return None if self._latest is seen else self._latest

    def following(
        self, seen: Snapshot | None, timeout: float | None
    ) -> Snapshot | None:
        """Return the snapshot after ``seen``, or None after ``timeout`` [s].

        It is the oldest there is if that has been forgotten, and the newest to begin
        with.
        """
        newest = self.newer_than(seen, timeout)
        if newest is None or seen is None:
            return newest
        with self._changed:
            found = newest
            for snapshot in reversed(self._recent):
                if snapshot is seen:
                    break
                found = snapshot
            return found
