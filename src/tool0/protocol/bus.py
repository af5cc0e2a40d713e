"""The only output of a robot: a stream of immutable snapshots, and events."""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import final

from tool0.protocol.fork_guard import OwnProcess
from tool0.protocol.goals import Goal
from tool0.protocol.state import SNAPSHOT_PERIOD, Snapshot

EVENTS_KEPT = 1000
"""Maximum number of unread events; older events are lost."""

SNAPSHOTS_KEPT = 256
"""Maximum number of unread snapshots of a subscriber: half a second at 500 Hz."""

HISTORY_LENGTH = 64
"""Number of snapshots in the history: half a second at the default rate.

Commands, short runs and faster subscribers cause many snapshots at almost the same
time.  The history skips these snapshots, so that they do not displace older
snapshots."""

_ROUNDING = 1e-6  # tolerance [s]


@final
@dataclass(frozen=True, slots=True)
class GoalFinished:
    """The goal of a controller has ended."""

    goal: Goal
    """The goal, with its ``controller``, ``status`` and ``result``."""
    time: float | None = None
    """Simulated time [s]; None if the event was received from another process."""


@final
@dataclass(frozen=True, slots=True)
class Overran:
    """The simulation is behind the wall clock, or has caught up again."""

    count: int
    """Number of ticks that started late in the last second; 0 if the simulation has
    caught up again."""
    time: float
    """Simulated time [s]."""


@final
@dataclass(frozen=True, slots=True)
class Faulted:
    """The physics or a controller has failed: simulated time stops until a reset."""

    message: str
    """Description of the failure, with its cause."""
    time: float
    """Simulated time [s]."""


@final
@dataclass(frozen=True, slots=True)
class WasReset:
    """The robot and the objects were returned to their start poses."""

    time: float = 0.0
    """Simulated time after the reset [s]."""
    step: int = 0
    """Ticks since the bring-up; 0 if the event was received from another process."""


@final
@dataclass(frozen=True, slots=True)
class Reported:
    """A part other than the simulation, such as a recording, has failed."""

    message: str
    """Description of the failure, with its cause."""
    time: float
    """Simulated time [s]."""


@final
@dataclass(frozen=True, slots=True)
class WasFrozen:
    """The process was suspended for some time; every motion was stopped."""

    duration: float
    """Duration of the suspension [wall s]."""
    time: float
    """Simulated time [s]."""


Event = GoalFinished | Overran | Faulted | WasReset | Reported | WasFrozen


@final
class Subscription:
    """Delivers snapshots and events to one reader, at the reader's pace.

    Use ``next`` for the newest snapshot, ``following`` to read snapshots one after the
    other, and ``pending`` for all unread snapshots.  Each reader needs a separate
    subscription.
    """

    def __init__(
        self,
        bus: Bus,
        period: float = SNAPSHOT_PERIOD,
        when_closed: Callable[[], None] = lambda: None,
        *,
        keep_all: bool = False,
        most_kept: int | None = None,
        with_commands: bool = False,
        with_arms: bool = False,
        with_contacts: bool = False,
        forces_period: float = 0.0,
        latest_only: bool = False,
        when_published: Callable[[], None] | None = None,
    ) -> None:
        self._period = period
        self._with_commands = with_commands
        """Whether snapshots must contain the joints' commands."""
        self._with_arms = with_arms
        """Whether snapshots must contain the arms' motions and the wrenches on the
        tools."""
        self._with_contacts = with_contacts
        """Whether snapshots must contain the contacts."""
        self._forces_period = forces_period if with_arms or with_contacts else math.inf
        """Simulated time between two snapshots with arms or contacts [s]."""
        self._latest_only = latest_only
        """Whether the reader takes only events and the newest snapshot.  In this case,
        the bus does not keep older snapshots."""
        self._when_published = when_published
        """Callback for every snapshot, called in the thread of the tick; it must not
        block."""
        self._bus = bus
        self._when_closed = when_closed
        self._seen: Snapshot | None = None
        self._events: deque[Event] = deque(maxlen=EVENTS_KEPT)
        self._backlog: deque[Snapshot] | None = (
            deque(maxlen=most_kept) if keep_all else None
        )

    @property
    def period(self) -> float:
        """Requested simulated time between snapshots [s]."""
        return self._period

    @property
    def events(self) -> deque[Event]:
        """Unread events, oldest first; ``popleft`` returns the oldest event.

        The last 1000 events are kept.
        """
        return self._events

    @property
    def backlog(self) -> deque[Snapshot] | None:
        """Snapshots that ``pending`` has not returned; None without ``keep_all``."""
        return self._backlog

    def next(self, timeout: float | None = None) -> Snapshot | None:
        """Wait for a new snapshot, and return the newest snapshot.

        Older unread snapshots are skipped.  After ``timeout`` [wall s], None is
        returned.
        """
        newer = self._bus.newer_than(self._seen, timeout)
        self._seen = newer or self._seen
        return newer

    def following(self, timeout: float | None = None) -> Snapshot | None:
        """Wait for the next snapshot and return it; None after ``timeout`` [wall s].

        No snapshot is skipped unless the reader falls more than ``SNAPSHOTS_KEPT``
        snapshots behind.
        """
        following = self._bus.newer_than(self._seen, timeout)
        if following is not None and self._seen is not None:
            following = self._bus.since(self._seen)[0]
        self._seen = following or self._seen
        return following

    def pending(self) -> list[Snapshot]:
        """Return all unread snapshots without waiting, oldest first."""
        if (backlog := self._backlog) is not None:
            return [backlog.popleft() for _ in range(len(backlog))]
        found = self._bus.since(self._seen)
        if found:
            self._seen = found[-1]
        return found

    def close(self) -> None:
        """End the subscription."""
        self._bus.forget(self)
        self._when_closed()


@final
class Bus:
    """Keeps the newest snapshots; publishing never waits for readers."""

    def __init__(self) -> None:
        self.process = OwnProcess()
        self._lock = threading.RLock()
        self._changed = threading.Condition(self._lock)
        self._n_waiting = 0
        """Number of readers that wait for a change.  If no reader waits, the wake-up is
        skipped."""
        self.latest: Snapshot | None = None
        self._recent: deque[Snapshot] = deque(maxlen=SNAPSHOTS_KEPT)
        """Recent snapshots, which are kept only if a subscriber needs them.  Freeing a
        snapshot that is no longer in the processor's cache takes longer than creating
        one."""
        self._keeps_recent = False
        self._history: deque[Snapshot] = deque(maxlen=HISTORY_LENGTH)
        self._history_time = -math.inf
        """Simulated time of the newest snapshot in the history [s]."""
        self._subscriptions: tuple[Subscription, ...] = ()
        self._backlogs: tuple[deque[Snapshot], ...] = ()
        self._wakers: tuple[Callable[[], None], ...] = ()
        self.wants_commands = False
        """Whether a subscriber needs the joints' commands."""
        self.wants_arms = False
        """Whether a subscriber needs the arms' motions."""
        self.wants_contacts = False
        """Whether a subscriber needs the contacts."""
        self._forces_period = math.inf
        self._forces_time = -math.inf
        """Simulated time of the newest snapshot with arms or contacts [s]."""

    def history(self) -> tuple[Snapshot, ...]:
        """Return snapshots of the last half second of simulated time, oldest first."""
        with self._lock:
            kept, latest = tuple(self._history), self.latest
        return kept if latest is None or kept[-1] is latest else (*kept, latest)

    def subscribe(
        self,
        period: float = SNAPSHOT_PERIOD,
        when_closed: Callable[[], None] = lambda: None,
        *,
        keep_all: bool = False,
        most_kept: int | None = None,
        with_commands: bool = False,
        with_arms: bool = False,
        with_contacts: bool = False,
        forces_period: float = 0.0,
        latest_only: bool = False,
        when_published: Callable[[], None] | None = None,
    ) -> Subscription:
        """Return a new reader; with ``keep_all``, ``pending`` returns every snapshot.

        If more than ``most_kept`` snapshots are unread, the oldest snapshots are lost.

        For the other arguments, see ``Subscription``.
        """
        subscription = Subscription(
            self,
            period,
            when_closed,
            keep_all=keep_all,
            most_kept=most_kept,
            with_commands=with_commands,
            with_arms=with_arms,
            with_contacts=with_contacts,
            forces_period=forces_period,
            latest_only=latest_only,
            when_published=when_published,
        )
        with self._lock:
            self._use((*self._subscriptions, subscription))
        return subscription

    @property
    def has_subscribers(self) -> bool:
        return bool(self._subscriptions)

    @property
    def shortest_period(self) -> float:
        """The shortest snapshot period of any subscriber [s]."""
        periods = (subscription.period for subscription in self._subscriptions)
        return min(periods, default=SNAPSHOT_PERIOD)

    def forget(self, subscription: Subscription) -> None:
        with self._lock:
            self._use(s for s in self._subscriptions if s is not subscription)

    def _use(self, subscriptions: Iterable[Subscription]) -> None:
        self._subscriptions = tuple(subscriptions)
        backlogs = (subscription.backlog for subscription in self._subscriptions)
        self._backlogs = tuple(backlog for backlog in backlogs if backlog is not None)
        wakers = (subscription._when_published for subscription in self._subscriptions)
        self._wakers = tuple(waker for waker in wakers if waker is not None)
        self.wants_commands = any(s._with_commands for s in self._subscriptions)
        self.wants_arms = any(s._with_arms for s in self._subscriptions)
        self.wants_contacts = any(s._with_contacts for s in self._subscriptions)
        self._forces_period = min(
            (s._forces_period for s in self._subscriptions), default=math.inf
        )
        self._keeps_recent = not all(s._latest_only for s in self._subscriptions)
        if not self._keeps_recent:
            self._recent.clear()

    def are_forces_due(self, time: float) -> bool:
        """Return whether a snapshot at ``time`` [s] needs arms or contacts."""
        passed = time - self._forces_time
        if 0.0 < passed < self._forces_period - _ROUNDING:
            return False
        self._forces_time = time
        return True

    def publish(self, snapshot: Snapshot) -> None:
        time = snapshot.time
        with self._lock:
            self.latest = snapshot
            if self._keeps_recent:
                self._recent.append(snapshot)
            if not 0.0 <= time - self._history_time < SNAPSHOT_PERIOD - _ROUNDING:
                self._history.append(snapshot)
                self._history_time = time
            for backlog in self._backlogs:
                backlog.append(snapshot)
            if self._n_waiting:
                self._changed.notify_all()
        for wake in self._wakers:
            wake()

    def announce(self, event: Event) -> None:
        for subscription in self._subscriptions:
            subscription.events.append(event)

    def newer_than(
        self, seen: Snapshot | None, timeout: float | None
    ) -> Snapshot | None:
        """Return a snapshot other than ``seen``, or None after ``timeout`` [wall s]."""
        self.process.check()
        with self._lock:
            if self.latest is seen:
                self._n_waiting += 1
                try:
                    self._changed.wait_for(lambda: self.latest is not seen, timeout)
                finally:
                    self._n_waiting -= 1
            return None if self.latest is seen else self.latest

    def since(self, seen: Snapshot | None) -> list[Snapshot]:
        """Return the snapshots after ``seen``, oldest first; if None, only the newest.

        If ``seen`` is no longer stored, all stored snapshots are returned.
        """
        self.process.check()
        with self._lock:
            latest = [] if self.latest is None else [self.latest]
            if seen is None:
                return latest
            found: list[Snapshot] = []
            for snapshot in reversed(self._recent or latest):
                if snapshot is seen:
                    break
                found.append(snapshot)
        found.reverse()
        return found
