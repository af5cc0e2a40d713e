"""Handover of an object: one arm picks it, and a second arm places it in a bin."""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple, final

from tool0.api.grasps import Bin, finger_reach, grasps_from_above, half_height
from tool0.api.table import BIN, TABLE, PickTable, joined
from tool0.cli.demos.hand import Hand, PickOptions, TaskFailure
from tool0.cli.demos.monitor import GraspMonitor
from tool0.cli.demos.picker import DROP, Picker, measured
from tool0.cli.demos.report import PickReport
from tool0.description.config import Cell, CellRobot, DescriptionConfig
from tool0.description.scene import Scene
from tool0.description.transform import Pose, Transform, Vector3, to_transform
from tool0.errors import ModelError
from tool0.protocol.state import Snapshot

if TYPE_CHECKING:
    from tool0.api.robot import Robot

GIVER, TAKER = "giver", "taker"
"""Names of the two robots."""
FORWARD, SIDEWAYS = 0.45, 0.55
"""Distances of the meeting point from each base, for arms of scale 1 [m]."""
HEIGHT = 0.33
"""Height of the meeting point above the root [m]; for shorter arms, the height is
reduced."""
APART = 0.1
"""Length of a gripper's approach to the meeting point, and of its retreat [m]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class HandoverCell:
    """Two robots side by side: the giver is on the left, and the taker is on the right.

    The grippers meet face to face, in front of and halfway between the bases.
    """

    giver: PickTable
    taker: PickTable

    @classmethod
    def of(cls, giver: float, taker: float) -> HandoverCell:
        """Return the cell for two arms with the given scales (see ``arm_scale``)."""
        largest = max(giver, taker)

        def table(name: str, scale: float, side: float) -> PickTable:
            x = FORWARD * (largest - scale)
            return PickTable(scale=scale, base=(x, side * SIDEWAYS * scale), arm=name)

        return cls(giver=table(GIVER, giver, 1.0), taker=table(TAKER, taker, -1.0))

    @property
    def meeting(self) -> Vector3:
        """Point where the object is handed over, in the root frame [m]."""
        scales = self.giver.scale, self.taker.scale
        return FORWARD * max(scales), 0.0, HEIGHT * min(1.0, *scales)

    @property
    def lift(self) -> float:
        """Height at which the object is carried [m]."""
        return min(self.giver.lift, self.taker.lift)

    def cell(self, giver: DescriptionConfig, taker: DescriptionConfig) -> Cell:
        """Return a cell with the two robots at their positions."""
        return Cell(
            name="handover",
            robots=tuple(
                CellRobot(
                    name=name,
                    description=replace(description, base_xyz=(*table.base, 0.0)),
                )
                for name, description, table in (
                    (GIVER, giver, self.giver),
                    (TAKER, taker, self.taker),
                )
            ),
        )

    def scene(self, *, edge: float, mass: float, friction: float) -> Scene:
        """Return a scene: a table with a cube for the giver and a bin for the taker."""
        one, other = (
            table.scene(edge=edge, mass=mass, friction=friction)
            for table in (self.giver, self.taker)
        )
        walls = [item for item in other.objects if item.name.startswith(f"{BIN}.")]
        table = joined(
            item for item in (*one.objects, *other.objects) if item.name == TABLE
        )
        rest = [
            item
            for item in one.objects
            if item.name != TABLE and not item.name.startswith(f"{BIN}.")
        ]
        return replace(one, objects=(table, *rest, *walls))


def hand_over(
    robot: Robot,
    item: str,
    into: Bin,
    meeting: Vector3,
    *,
    options: PickOptions | None = None,
    on_snapshot: Callable[[Snapshot], None] = lambda snapshot: None,
) -> PickReport:
    """Pick an object, hand it to the second robot, and place it in a bin.

    The giver picks the object from above.  The grippers meet face to face, with their
    pads on different sides of the object.  Only friction holds the object, unless the
    robot has grasp assist.

    Args:
        robot: A cell of two robots called giver and taker.
        item: The name of an upright, movable cube.
        into: Bin for the object, within the taker's reach.
        meeting: Point of the handover, in the root frame [m].
        options: Force and speeds of the task.
        on_snapshot: Called with each snapshot, for recording.

    Raises:
        ControlError: If the object does not exist, or if it cannot be gripped.
        EngineError: If the physics fails.
    """
    options = options or PickOptions()
    with contextlib.closing(GraspMonitor(robot, item, on_snapshot)) as monitor:
        picker = Picker(robot, item, options, monitor, GIVER)
        taker = Hand(robot, options, monitor, TAKER)
        handover = _Handover(robot, monitor, picker, taker, meeting)

        def task() -> None:
            picker.take()
            width = handover.do()
            geometry = taker.gripper.geometry
            below = max(
                half_height(robot.scene[item], Transform()),
                finger_reach(robot.description.model, geometry),
            )
            taker.put(into, grasps_from_above((0.0, 0.0, 0.0), width), below + DROP)

        return measured(robot, picker, monitor, task)


class _Way(NamedTuple):
    """The frames of the two grippers at the meeting point, in the root frame."""

    give: Transform
    take: Transform


@final
class _Handover:
    """The transfer of an object from the giver's gripper to the taker's gripper."""

    def __init__(
        self,
        robot: Robot,
        monitor: GraspMonitor,
        picker: Picker,
        taker: Hand,
        meeting: Vector3,
    ) -> None:
        self._robot = robot
        self._monitor = monitor
        self._picker = picker
        self._giver, self._taker = picker.hand, taker
        self._meeting = meeting

    def do(self) -> float:
        """Bring the object to the meeting point, and hand it over.

        Returns:
            The width of the object between the taker's pads [m].
        """
        giver, taker, monitor = self._giver, self._taker, self._monitor
        width = self._picker.width_between_pads
        give_tool, take_tool = giver.tool_for(width), taker.tool_for(width)
        way = self._nearest_way(give_tool, take_tool)
        monitor.begin("meeting")
        for goal in (
            taker.open(),
            giver.start(way.give, give_tool),
            taker.start(_behind(way.take), take_tool),
        ):
            giver.finish(goal)
        giver.check_hold()
        monitor.begin("reaching for it")
        taker.move_linear(
            replace(way.take, position=monitor.pose().position), take_tool
        )
        monitor.begin("taking it")
        taker.grip()
        monitor.begin("handing over")
        monitor.stop_slip()
        giver.finish(giver.open(width))
        taker.check_hold()
        monitor.start_slip(taker.gripper)
        monitor.begin("parting")
        giver.move_linear(_behind(way.give), give_tool)
        taker.check_hold()
        # Return along the same path; on a shorter one, the arm might collide with
        # itself or the giver.
        monitor.begin("withdrawing")
        taker.move_linear(_behind(way.take), take_tool)
        taker.move_home()
        taker.check_hold()
        return width

    def _nearest_way(self, give_tool: Transform, take_tool: Transform) -> _Way:
        """Return the frames with the least joint motion, or raise TaskFailure."""
        best: tuple[float, _Way] | None = None
        refused: ModelError | None = None
        for way in self._ways():
            try:
                moved = sum(
                    hand.arm.inverse_kinematics(pose, tool=tool)[0].distance
                    for hand, pose, tool in (
                        (self._giver, way.give, give_tool),
                        (self._giver, _behind(way.give), give_tool),
                        (self._taker, _behind(way.take), take_tool),
                        (self._taker, way.take, take_tool),
                    )
                )
            except ModelError as error:
                refused = error
                continue
            if best is None or moved < best[0]:
                best = moved, way
        if best is None:
            raise TaskFailure(f"the grippers cannot meet: {refused}")
        return best[1]

    def _ways(self) -> Iterator[_Way]:
        """Yield frames with the pads of the two grippers on different sides."""
        (ax, ay, _), (bx, by, _) = (
            self._robot.pose(hand.arm.chain.base).position
            for hand in (self._giver, self._taker)
        )
        towards = math.atan2(by - ay, bx - ax)
        for turn, other in itertools.product(range(4), (1, 3)):
            yield _Way(
                self._facing(towards, turn * math.pi / 2.0),
                self._facing(towards + math.pi, (turn + other) * math.pi / 2.0),
            )

    def _facing(self, yaw: float, turn: float) -> Transform:
        """Return the frame of a horizontal gripper, rotated about its axis."""
        level = to_transform(Pose(xyz=self._meeting, rpy=(0.0, math.pi / 2.0, yaw)))
        return level @ to_transform(Pose(rpy=(0.0, 0.0, turn)))


def _behind(frame: Transform) -> Transform:
    """Return the frame of a gripper before its approach or after its retreat."""
    return frame @ Transform(position=(0.0, 0.0, -APART))
