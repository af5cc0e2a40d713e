"""Several picks from random poses, and a report of them."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, final

from tool0.cli.demos.grasps import Bin
from tool0.cli.demos.hand import PickOptions
from tool0.cli.demos.monitor import GraspMonitor
from tool0.cli.demos.picker import PickReport, pick_and_place
from tool0.description.transform import Pose, to_transform
from tool0.sensing.snapshot import Snapshot

if TYPE_CHECKING:
    from tool0.api.robot import Robot

RETURN_TIMEOUT = 20.0
"""Longest motion back between two picks, simulated [s]."""
SETTLE = 0.3
"""For an object to come to rest where it was put [s]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class DemoReport:
    """All picks of a demo, and their conditions."""

    engine: str
    gripper_model: str
    grasp_assist: bool
    """Whether gripped objects were fixed to the gripper, which is not physical."""
    picks: tuple[PickReport, ...]
    sim_time: float
    wall_time: float
    video: str | None = None
    """The file that was written."""

    @property
    def n_succeeded(self) -> int:
        """How many ended in the bin."""
        return sum(pick.success for pick in self.picks)

    def to_json(self) -> dict[str, object]:
        """Return plain values."""
        return {**asdict(self), "succeeded": self.n_succeeded}

    def to_text(self) -> str:
        """Return a summary as text."""
        lines = []
        if self.grasp_assist:
            lines.append("grasp assist was on: objects were fixed to the gripper")
        if self.video is not None:
            lines.append(f"video: {self.video}")
        ratio = self.sim_time / self.wall_time if self.wall_time > 0.0 else 0.0
        lines.append(
            f"{self.n_succeeded} of {len(self.picks)} in the bin; {self.engine}, "
            f"{self.gripper_model} gripper, {self.sim_time:.1f} s simulated in "
            f"{self.wall_time:.1f} s ({ratio:.1f} x real time)"
        )
        return "\n".join(lines)


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
    """Pick an object from one pose after the other, starting with the arm as it is.

    Args:
        robot: As for ``pick_and_place``.
        item: The object, which is put back on the table between picks.
        into: Where it goes.
        poses: The start poses of the object; None leaves it where it is.
        n_picks: How many.
        options: Force and speeds.
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
        with contextlib.closing(GraspMonitor(robot, item, on_snapshot)) as monitor:
            if number:
                _go_back(robot, home, monitor)
            if pose is not None:
                T_root_item = to_transform(pose)
                robot.scene.place(item, T_root_item.position, T_root_item.quat_wxyz)
                monitor.wait(SETTLE)
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


def _go_back(robot: Robot, home: Mapping[str, float], monitor: GraspMonitor) -> None:
    """Open the gripper and move the arm ``home``; after a failure it may be anywhere.

    If that takes longer than ``RETURN_TIMEOUT``, the next pick starts elsewhere.
    """
    opened = robot.gripper.move(opening=robot.gripper.geometry.max_opening)
    monitor.until(lambda: opened.result is not None, RETURN_TIMEOUT)
    moves = robot.move_joints(home)
    monitor.until(
        lambda: all(move.result is not None for move in moves), RETURN_TIMEOUT
    )
