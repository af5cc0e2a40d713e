"""Picks one after the other, from poses drawn by chance, and what came of them."""

from __future__ import annotations

import contextlib
import math
import random
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

from tool0.cli.pick_demo.bin import Bin
from tool0.cli.pick_demo.pick import pick_and_place
from tool0.cli.pick_demo.picker import PickOptions
from tool0.cli.pick_demo.report import DemoReport, PickReport
from tool0.cli.pick_demo.witness import Witness
from tool0.description.kinematics import to_transform
from tool0.description.model import Pose
from tool0.sensing.snapshot import Snapshot

if TYPE_CHECKING:
    from tool0.api.robot import Robot

PATIENCE = 20.0
"""Longest way back between two picks, simulated [s]."""
SETTLE = 0.3
"""For an object to come to rest where it was put [s]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Area:
    """Where on a table an object may stand."""

    x: tuple[float, float]
    """[m], in the root."""
    y: tuple[float, float]
    z: float
    """Of the table's top [m]."""

    def draw(self, chance: random.Random, height: float) -> Pose:
        """Return a pose of something so high [m] that stands there, turned anyhow."""
        return Pose(
            xyz=(
                chance.uniform(*self.x),
                chance.uniform(*self.y),
                self.z + height / 2.0,
            ),
            rpy=(0.0, 0.0, chance.uniform(-math.pi, math.pi)),
        )


TABLE = Area(x=(0.40, 0.65), y=(-0.10, 0.30), z=-0.02)
"""Of the scene ``table_and_bin``: clear of the bin, and within the arm's reach."""


def random_poses(area: Area, height: float, seed: int) -> Iterator[Pose]:
    """Yield poses without end, the same ones for the same seed."""
    chance = random.Random(seed)
    while True:
        yield area.draw(chance, height)


def run_trials(
    robot: Robot,
    item: str,
    into: Bin,
    poses: Iterator[Pose | None],
    n_picks: int,
    *,
    options: PickOptions | None = None,
    on_snapshot: Callable[[Snapshot], None] = lambda snapshot: None,
    on_pick: Callable[[PickReport], None] = lambda report: None,
) -> DemoReport:
    """Pick an object from one pose after the other, the arm beginning as it is now.

    Args:
        robot: As for ``pick_and_place``.
        item: The object, which is put back on the table between picks.
        into: Where it goes.
        poses: Where it is taken from; None leaves it where it is.
        n_picks: How many.
        options: How.
        on_snapshot: Called with each snapshot, those between the picks too.
        on_pick: Called after each pick.

    Raises:
        ControlError: As ``pick_and_place``, or if the emergency stop is engaged
            between two picks.
        EngineError: If the physics fails.
    """
    wall_start, sim_start = time.perf_counter(), robot.time
    home = robot.arm.joints
    reports = []
    for number in range(n_picks):
        pose = next(poses)
        with contextlib.closing(
            Witness(robot, robot.gripper, item, on_snapshot)
        ) as witness:
            if number:
                _go_back(robot, home, witness)
            if pose is not None:
                T_root_item = to_transform(pose)
                robot.scene.place(item, T_root_item.position, T_root_item.quat_wxyz)
                witness.wait(SETTLE)
        report = pick_and_place(robot, item, into, options, on_snapshot)
        on_pick(report)
        reports.append(report)
    return DemoReport(
        engine=robot.engine.name,
        gripper_model="linkage" if robot.description.model.loops else "mimic",
        grasp_assist=robot.info.grasp_assist,
        picks=tuple(reports),
        sim_time=robot.time - sim_start,
        wall_time=time.perf_counter() - wall_start,
    )


def _go_back(robot: Robot, home: Mapping[str, float], witness: Witness) -> None:
    """Let go, and bring the arm ``home``; after a failure it may be anywhere.

    What it does not reach within ``PATIENCE`` the next pick has to do without.
    """
    opened = robot.gripper.move(opening=robot.gripper.geometry.max_opening)
    witness.until(lambda: opened.result is not None, PATIENCE)
    goals = robot.move_joints(home)
    witness.until(lambda: all(goal.result is not None for goal in goals), PATIENCE)
