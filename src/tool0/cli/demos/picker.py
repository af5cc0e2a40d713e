"""Pick an object from above and place it in a bin."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, final

from tool0.cli.demos.grasps import (
    CLEARANCE,
    Bin,
    find_grasps,
    finger_reach,
    half_height,
)
from tool0.cli.demos.hand import Hand, PickOptions, TaskFailure
from tool0.cli.demos.monitor import GraspMonitor
from tool0.errors import ControlError, ModelError
from tool0.sensing.snapshot import Snapshot

if TYPE_CHECKING:
    from tool0.api.robot import Robot

DROP = 0.015
"""Height above the floor of the bin at which it is released [m]."""
SETTLE_TIMEOUT = 1.0
"""Longest time for an object in the bin to come to rest [s]."""


@final
class Picker:
    """Does one pick with one arm and its gripper."""

    def __init__(
        self,
        robot: Robot,
        item: str,
        options: PickOptions,
        monitor: GraspMonitor,
        name: str | None = None,
    ) -> None:
        """Find the grasps of the object where it is now.

        Args:
            robot: The robot.
            item: An upright box, cylinder or sphere.
            options: Force and speeds.
            monitor: Advances time, and measures.
            name: Of the arm and the gripper; the only ones, if left out.

        Raises:
            ControlError: If there is no such object, it cannot be gripped at all, or
                the gripper has no such force or speed.
        """
        self.hand = Hand(robot, options, monitor, name)
        geometry = self.hand.gripper.geometry
        self._options = options
        self._monitor = monitor
        thing, pose = robot.scene[item], monitor.pose()
        self._grasps = find_grasps(thing, pose, geometry.max_opening)
        self._floor = pose.position[2] - half_height(thing, pose)
        reach = finger_reach(robot.description.model, geometry)
        top = 2.0 * pose.position[2] - self._floor
        # Lower, the fingers would touch the table, or the knuckles a tall object.
        self._height = max(
            pose.position[2], top - reach, self._floor + reach + CLEARANCE
        )
        """Of the middle of the pads, when they take it [m]."""
        self._grasp = self._grasps[0]
        self.width: float | None = None
        """Width of the gripped object, from the gripper's joint [m]."""
        self.force: float | None = None
        """That a pad exerts on it when it is lifted [N]."""

    def take(self) -> None:
        """Go there, grip it, and lift it, or raise TaskFailure."""
        hand, monitor, lift = self.hand, self._monitor, self._options.lift
        x, y, _ = self._grasps[0].pose.position
        self._grasp = hand.nearest((x, y, self._height + lift), self._grasps)
        tool = hand.tool_for(self._grasp.width)
        above = self._grasp.pose
        down = replace(above, position=(x, y, self._height))

        monitor.begin("approaching")
        opening = hand.open()
        hand.move_to(above, tool)
        hand.finish(opening)
        monitor.begin("going down")
        hand.move_linear(down, tool)
        monitor.begin("gripping")
        hand.grip()
        self.width, self.force = hand.gripper.state.width, monitor.pad_force()
        monitor.start_slip(hand.gripper)
        monitor.begin("lifting")
        hand.move_linear(above, tool)
        hand.check_hold()

    def put(self, into: Bin) -> None:
        """Carry the object to a bin and release it, or raise TaskFailure."""
        hand, monitor, width = self.hand, self._monitor, self._grasp.width
        tool = hand.tool_for(width)

        monitor.begin("carrying")
        x, y, bottom = into.center
        height = bottom + self._height - self._floor + DROP
        above = hand.nearest((x, y, height + self._options.lift), self._grasps).pose
        down = replace(above, position=(x, y, height))
        hand.move_to(above, tool)
        hand.check_hold()
        monitor.begin("lowering")
        hand.move_linear(down, tool)
        hand.check_hold()
        monitor.begin("letting go")
        monitor.stop_slip()
        hand.finish(hand.open(width))
        monitor.begin("leaving")
        hand.move_linear(above, tool)
        if not monitor.until(lambda: into.holds(monitor.pose()), SETTLE_TIMEOUT):
            x, y, z = monitor.pose().position
            raise TaskFailure(f"it is at ({x:.3f}, {y:.3f}, {z:.3f}), not in the bin")


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class PickReport:
    """One pick and place.  Values that were never reached are None."""

    success: bool
    """Whether the object is in the bin."""
    failure: str | None = None
    """In which phase it failed, and why."""
    item: str
    """The object."""
    start: tuple[float, float, float]
    """Start position of the object, in the root [m]."""
    end: tuple[float, float, float] | None
    """Final position [m]; None if it was removed."""
    force: float
    """Requested force at each pad [N]."""
    grip_force: float | None = None
    """Force of a pad when the object was lifted [N]."""
    peak_force: float
    """The largest that a pad exerted, of samples at 125 Hz: pads that meet a rigid
    object must also stop the rotor of their drive [N]."""
    width: float | None = None
    """Width of the held object, from the gripper's joint [m]."""
    slip: float | None = None
    """Largest slip between the pads while it was held [m]."""
    duration: float
    """Simulated [s]."""
    phases: Mapping[str, float] = field(default_factory=dict)
    """Phase → its duration, simulated [s]."""

    def to_text(self) -> str:
        """Return it as a line for people."""
        x, y, _ = self.start
        what = f"'{self.item}' from ({x:.3f}, {y:.3f})"
        if not self.success:
            return f"{what}: FAILED {self.failure}"
        words = [f"{what}: in the bin after {self.duration:.1f} s"]
        if self.width is not None:
            words.append(f"{1e3 * self.width:.1f} mm wide")
        if self.slip is not None:
            words.append(f"slip {1e3 * self.slip:.2f} mm")
        if self.grip_force is not None:
            words.append(f"gripped with {self.grip_force:.0f} N")
        words.append(f"peak {self.peak_force:.0f} N")
        return ", ".join(words)


def pick_and_place(
    robot: Robot,
    item: str,
    into: Bin,
    options: PickOptions | None = None,
    on_snapshot: Callable[[Snapshot], None] = lambda snapshot: None,
) -> PickReport:
    """Pick an object from above, place it in a bin, and report what was measured.

    The object is held by friction alone, unless the robot has grasp assist.

    Args:
        robot: With one arm that has analytic inverse kinematics, and one gripper.
        item: The name of an upright box, cylinder or sphere that can move.
        into: Where it goes.
        options: Force and speeds.
        on_snapshot: Called with each snapshot, for recording.

    Raises:
        ControlError: If there is no such object, or it cannot be gripped at all.
        EngineError: If the physics fails.
    """
    options = options or PickOptions()
    monitor = GraspMonitor(robot, item, on_snapshot)
    try:
        picker = Picker(robot, item, options, monitor)
        start, begun, failure = monitor.pose().position, robot.time, None
        try:
            picker.take()
            picker.put(into)
        except (TaskFailure, ControlError, ModelError) as error:
            failure = f"while {monitor.phase}: {error}"
        monitor.begin("")
        return PickReport(
            success=failure is None,
            failure=failure,
            item=item,
            start=start,
            end=monitor.pose().position if item in robot.scene else None,
            force=options.force,
            grip_force=picker.force,
            peak_force=monitor.peak_force,
            width=picker.width,
            slip=monitor.slip,
            duration=robot.time - begun,
            phases=monitor.phases,
        )
    finally:
        monitor.close()
