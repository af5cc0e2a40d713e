"""Lets a robot's time pass, and measures meanwhile what a grip does."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, final

from tool0.api.scene import object_pose
from tool0.description.kinematics import Transform, transforms
from tool0.description.model import Vector3
from tool0.errors import ControlError, EngineError
from tool0.sensing.pads import pad_links
from tool0.sensing.snapshot import SNAPSHOT_PERIOD, Snapshot

if TYPE_CHECKING:
    from tool0.api.gripper import Gripper
    from tool0.api.robot import Robot

_LOOK = 0.5
"""Longest wait for a snapshot, in real time [wall s]: who pauses keeps us waiting."""


@final
class Witness:
    """Sees every snapshot between two moments."""

    def __init__(
        self,
        robot: Robot,
        gripper: Gripper,
        item: str,
        on_snapshot: Callable[[Snapshot], None] = lambda snapshot: None,
    ) -> None:
        """Watch what ``gripper`` does to the object ``item``.

        Args:
            robot: Whose time passes.
            gripper: One of its grippers.
            item: The name of an object of its scene.
            on_snapshot: Called with each snapshot, for who records them.
        """
        self._robot = robot
        self._item = item
        self._on_snapshot = on_snapshot
        self._subscription = robot.subscribe()
        self._pads = pad_links(robot.description.model, gripper.geometry)
        self._base = robot.description.model.joint(gripper.geometry.joint).parent
        self._start: Vector3 | None = None
        self.slip: float | None = None
        """How far the object has moved between the pads since it was held [m]."""
        self.peak_force = 0.0
        """The largest that a pad has exerted on the object so far [N]."""
        self.phases: dict[str, float] = {}
        """Name → how long it took, simulated [s]."""
        self._phase = ""
        self._since = robot.time

    def begin(self, phase: str) -> None:
        """End the phase before, and begin another."""
        now = self._robot.time
        if self._phase:
            self.phases[self._phase] = self.phases.get(self._phase, 0.0) + (
                now - self._since
            )
        self._phase, self._since = phase, now

    @property
    def phase(self) -> str:
        """What is going on."""
        return self._phase

    def until(self, done: Callable[[], bool], timeout: float) -> bool:
        """Let time pass until ``done()``; return whether it was within ``timeout``.

        Args:
            done: Asked after each snapshot.
            timeout: Simulated [s].

        Raises:
            ControlError: If the object is taken away meanwhile, or the robot is paused
                and does not run in real time.
            EngineError: If the physics failed.
        """
        end = self._robot.time + timeout
        while not done():
            if self._robot.time >= end:
                return False
            self._advance()
        return True

    def wait(self, duration: float) -> None:
        """Let ``duration`` simulated seconds pass."""
        self.until(lambda: False, duration)

    def hold(self) -> None:
        """From now on the object should stay between the pads as it is."""
        self._start = self._held_at(self._robot.snapshot)
        self.slip = 0.0

    def release(self) -> None:
        """From now on it may go."""
        self._start = None

    def pose(self) -> Transform:
        """Return where the object is, in the root."""
        return self._robot.scene.pose(self._item)

    def pressing(self) -> float:
        """Return the largest force between a pad and the object [N]."""
        item, pads = self._item, self._pads
        return max(
            (
                math.hypot(*contact.force)
                for contact in self._robot.contacts()
                if (contact.first == item and contact.second in pads)
                or (contact.second == item and contact.first in pads)
            ),
            default=0.0,
        )

    def close(self) -> None:
        """See no more."""
        self._subscription.close()

    def _advance(self) -> None:
        robot = self._robot
        if not robot.is_realtime:
            robot.run(max(SNAPSHOT_PERIOD, robot.control_period))
        snapshot = self._subscription.following(_LOOK)
        while snapshot is not None:
            self._look_at(snapshot)
            snapshot = self._subscription.following(0.0)
        self.peak_force = max(self.peak_force, self.pressing())

    def _look_at(self, snapshot: Snapshot) -> None:
        if snapshot.fault is not None:
            raise EngineError(snapshot.fault)
        if self._item not in {item.name for item in snapshot.scene}:
            raise ControlError(f"the object '{self._item}' is gone")
        self._on_snapshot(snapshot)
        if self._start is not None and self.slip is not None:
            moved = math.dist(self._start, self._held_at(snapshot))
            self.slip = max(self.slip, moved)

    def _held_at(self, snapshot: Snapshot) -> Vector3:
        """Return where the object is from midway between the pads, in the gripper."""
        position = dict(zip(snapshot.joint_names, snapshot.position, strict=True))
        found = transforms(self._robot.description.model, position)
        (ax, ay, az), (bx, by, bz) = (found[pad].position for pad in self._pads)
        middle = Transform(
            position=((ax + bx) / 2.0, (ay + by) / 2.0, (az + bz) / 2.0),
            rotation=found[self._base].rotation,
        )
        return middle.inverse().apply(object_pose(snapshot, self._item).position)
