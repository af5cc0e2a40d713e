"""Planned pick and place: from a shelf to a bin behind a wall.

A second arm can stand at the bin.  The second arm moves aside while the object is
carried.
"""

from __future__ import annotations

import contextlib
import math
import random
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final, final

from tool0.api.grasps import (
    Bin,
    Grasp,
    find_grasps,
    finger_reach,
    grasps_from_above,
    half_height,
)
from tool0.api.table import ITEM
from tool0.cli.demos.hand import Hand, PickOptions
from tool0.cli.demos.monitor import GraspMonitor
from tool0.cli.demos.picker import DROP, pick_into
from tool0.cli.demos.report import PickReport
from tool0.description.config import Cell, CellRobot, DescriptionConfig
from tool0.description.model import FLANGE
from tool0.description.scene import Scene, SceneObject
from tool0.description.scene_file import load_scene
from tool0.description.shapes import Box
from tool0.description.transform import Pose, Transform, Vector3, to_transform
from tool0.protocol.state import Snapshot

if TYPE_CHECKING:
    from tool0.api.robot import Robot

SMALLEST_SCALE: Final = 0.95
"""Smallest scale of the arms that reach both the shelf and the bin."""
BOARD: Final = "shelf.board"
"""Name of the shelf board on which the object stands."""
INTO_SHELF: Final = (0.0, 1.0, 0.0)
"""Direction into the shelf, in the root frame."""
RAISED: Final = 0.02
"""Height above the board at which the object leaves the shelf [m]."""
OUTSIDE: Final = 0.06
"""Distance between the middle of the pads and the shelf before and after the grasp
[m]."""
PICKER, HELPER = "picker", "helper"
"""Names of the two robots."""
HELPER_XYZ: Final = (1.05, -0.34, 0.0)
"""Base position of the second robot, in the root frame [m]; this robot faces the first
robot."""
ASIDE: Final = {"shoulder_pan_joint": 1.6, "shoulder_lift_joint": -1.9}
"""Posture of the second robot when it moves aside [rad]."""
_BESIDE: Final = 0.12
"""Minimum distance of an object's center from the sides of the shelf [m]."""
_DEPTHS: Final = (0.04, 0.09)
"""Depth range of random poses, measured from the edge of the board [m]."""
_TURN: Final = 0.3
"""Largest yaw of random poses, in either direction [rad]."""
_TILT: Final = math.radians(70.0)
"""Tilt of the gripper from vertical [rad]: the gripper points slightly downward, to
clear the edge of the board."""
_FACING: Final = math.cos(math.radians(46.0))


def shelf_scene(*, edge: float, mass: float, friction: float) -> Scene:
    """Return the scene with a cube of ``edge`` [m] and ``mass`` [kg] on the board."""
    scene = load_scene("shelf")
    item = next(item for item in scene.objects if item.name == ITEM)
    x, y, _ = item.pose.xyz
    _, (_, _, top) = _board(scene.objects)
    cube = replace(
        item,
        geometry=Box(size=(edge, edge, edge)),
        pose=Pose(xyz=(x, y, top + edge / 2.0)),
        mass=mass,
        friction=friction,
    )
    return replace(
        scene,
        objects=tuple(cube if each is item else each for each in scene.objects),
    )


def two_robots(picker: DescriptionConfig, helper: DescriptionConfig) -> Cell:
    """Return a cell with one robot at the shelf and one robot at the bin."""
    turned = replace(helper, base_xyz=HELPER_XYZ, base_rpy=(0.0, 0.0, math.pi))
    robots = ((PICKER, picker), (HELPER, turned))
    return Cell(
        name="shelf",
        robots=tuple(
            CellRobot(name=name, description=description)
            for name, description in robots
        ),
    )


def random_poses(scene: Scene, edge: float, seed: int) -> Iterator[Pose]:
    """Yield an endless sequence of random poses of a cube on the board."""
    rng = random.Random(seed)
    low, high = _board(scene.objects)
    while True:
        x = rng.uniform(low[0] + _BESIDE, high[0] - _BESIDE)
        y = low[1] + rng.uniform(*_DEPTHS)
        yaw = rng.uniform(-_TURN, _TURN)
        yield Pose(xyz=(x, y, high[2] + edge / 2.0), rpy=(0.0, 0.0, yaw))


def pick_from_shelf(
    robot: Robot,
    item: str,
    into: Bin,
    options: PickOptions,
    on_snapshot: Callable[[Snapshot], None] = lambda snapshot: None,
) -> PickReport:
    """Pick an object from the shelf, place it in a bin, and return a report.

    The paths to the shelf and to the bin are planned around all obstacles.  The second
    path is planned with the object in the gripper.

    Args:
        robot: A robot with one arm and one gripper, or a cell from ``two_robots``, in
            the scene ``shelf``.
        item: The name of an upright box, cylinder or sphere.
        into: Bin for the object.
        options: Force and speeds of the pick.
        on_snapshot: Called with each snapshot, for recording.

    Raises:
        ControlError: If the object does not exist, or if it cannot be gripped.
        EngineError: If the physics fails.
    """
    with contextlib.closing(GraspMonitor(robot, item, on_snapshot)) as monitor:
        picker = ShelfPicker(robot, item, options, monitor)
        return pick_into(robot, picker, monitor, into)


@final
class ShelfPicker:
    """Picks an object from the front, with one arm and its gripper."""

    def __init__(
        self, robot: Robot, item: str, options: PickOptions, monitor: GraspMonitor
    ) -> None:
        """Find the grasps of the object at its present pose.

        Raises:
            ControlError: If the object does not exist, or if it cannot be gripped.
        """
        helper = robot.arms.get(HELPER)
        name = None if helper is None else PICKER
        self.hand = Hand(robot, options, monitor, name)
        self._helper = helper
        self._monitor = monitor
        geometry = self.hand.gripper.geometry
        thing, pose = robot.scene[item], monitor.pose()
        self._grasps = _from_front(find_grasps(thing, pose, geometry.max_opening))
        (_, self._front, _), _ = _board(robot.scene.objects)
        reach = finger_reach(robot.description.model, geometry)
        self._below = max(half_height(thing, pose), reach)
        self.width: float | None = None
        self.force: float | None = None

    def take(self) -> None:
        """Take the object out of the shelf; a failed step raises TaskFailure."""
        hand, monitor = self.hand, self._monitor
        monitor.begin("approaching")
        opening = hand.open()
        before = hand.go_around([self._before(grasp) for grasp in self._grasps])
        hand.finish(opening)
        tool = hand.tool_for(before.width)
        x, y, z = self._grasps[0].pose.position
        monitor.begin("reaching in")
        hand.move_linear(replace(before.pose, position=(x, y, z)), tool)
        monitor.begin("gripping")
        hand.grip()
        self.width, self.force = hand.gripper.state.width, monitor.pad_force()
        monitor.start_slip(hand.gripper)
        monitor.begin("taking out")
        hand.move_linear(replace(before.pose, position=(x, y, z + RAISED)), tool)
        x, y, z = before.pose.position
        hand.move_linear(replace(before.pose, position=(x, y, z + RAISED)), tool)
        hand.check_hold()

    def put(self, into: Bin) -> None:
        """Carry the object to a bin and release it; a failure raises TaskFailure."""
        hand, height = self.hand, self._below + DROP
        x, y, bottom = into.center
        above = (x, y, bottom + height + hand.options.lift)
        self._monitor.begin("carrying")
        others = []
        if (helper := self._helper) is not None:
            prefix = helper.tip.removesuffix(FLANGE)
            aside = {prefix + joint: value for joint, value in ASIDE.items()}
            others.append(helper.target(aside))
        grasps = grasps_from_above(above, self._grasps[0].width)
        place = hand.go_around(grasps, others)
        hand.release(into, place, height)

    def _before(self, grasp: Grasp) -> Grasp:
        """Return a copy of a grasp, moved backward out of the shelf."""
        pose = grasp.pose
        ahead = _axis(pose, 2)
        x, y, z = pose.position
        back = (y - (self._front - OUTSIDE)) / ahead[1]
        moved = (x - back * ahead[0], y - back * ahead[1], z - back * ahead[2])
        return replace(grasp, pose=replace(pose, position=moved))


def _from_front(grasps: Sequence[Grasp]) -> list[Grasp]:
    """Return grasps from above, tilted about the line between the pads."""
    found = []
    for grasp in grasps:
        for turn in (-_TILT, _TILT):
            pose = grasp.pose @ to_transform(Pose(rpy=(0.0, turn, 0.0)))
            ahead = _axis(pose, 2)
            if sum(a * b for a, b in zip(ahead, INTO_SHELF, strict=True)) > _FACING:
                found.append(replace(grasp, pose=pose))
    return found


def _axis(pose: Transform, k: int) -> Vector3:
    x, y, z = (row[k] for row in pose.rotation)
    return x, y, z


def _board(objects: Iterable[SceneObject]) -> tuple[Vector3, Vector3]:
    """Return the corners of the board with the lowest and highest coordinates [m]."""
    board = next(item for item in objects if item.name == BOARD)
    assert isinstance(board.geometry, Box)  # the board is a box in the scene file
    (x, y, z), (dx, dy, dz) = board.pose.xyz, board.geometry.size
    return (x - dx / 2, y - dy / 2, z - dz / 2), (x + dx / 2, y + dy / 2, z + dz / 2)
