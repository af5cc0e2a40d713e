"""Several picks from random poses, and a report of the picks."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, final

from tool0.cli.demos.monitor import GraspMonitor
from tool0.cli.demos.report import PickReport
from tool0.description.transform import Pose, to_transform
from tool0.errors import CollisionError, PlanningError
from tool0.protocol.state import Snapshot

if TYPE_CHECKING:
    from tool0.api.controller import GoalHandle
    from tool0.api.robot import Robot

RETURN_TIMEOUT = 20.0
"""Longest duration of the return motion between two picks [simulated s]."""
SETTLE = 0.3
"""Time for an object to come to rest after it is placed [simulated s]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class DemoReport:
    """Report of all picks in a demo, with their conditions."""

    engine: str
    """Physics engine."""
    gripper_model: str
    """Model of the gripper's linkage."""
    grasp_assist: bool
    """Whether gripped objects were fixed to the gripper; this is physically
    unrealistic."""
    picks: tuple[PickReport, ...]
    """The picks in the order of their execution."""
    sim_time: float
    """Duration [simulated s]."""
    wall_time: float
    """Duration [wall s]."""
    video: str | None = None
    """The video file that was written; None if there is no video."""

    @property
    def n_succeeded(self) -> int:
        """Number of objects that ended up in the bin."""
        return sum(pick.success for pick in self.picks)

    def to_json(self) -> dict[str, object]:
        """Return the results as JSON-compatible values."""
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
    task: Callable[[], PickReport],
    poses: Iterator[Pose | None],
    n_picks: int,
    *,
    on_snapshot: Callable[[Snapshot], None] = lambda snapshot: None,
    on_pick: Callable[[PickReport], None] = lambda report: None,
) -> DemoReport:
    """Perform a task with an object several times, from different poses.

    The first trial starts at the present posture of the robot.  Before each further
    trial, the robot returns to this posture.

    Args:
        robot: A robot with one or several arms and grippers.
        item: The object, which is put back on the table between picks.
        task: Function that picks the object, such as ``pick_and_place``.
        poses: The start poses of the object; with None, the object is not moved.
        n_picks: Number of picks to perform.
        on_snapshot: Called with each snapshot between the picks.
        on_pick: Called after each pick.

    Raises:
        ControlError: If ``task`` raises this error, or if the emergency stop is engaged
            between two picks.
        EngineError: If the physics fails.
    """
    wall_start, sim_start = time.perf_counter(), robot.time
    home = {
        name: position
        for arm in robot.arms.values()
        for name, position in arm.joints.items()
    }
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
        report = task()
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
    """Open the grippers and move the arms ``home`` from any posture.

    If the motion takes longer than ``RETURN_TIMEOUT``, the next pick starts at another
    posture.
    """
    opened = [
        gripper.move(opening=gripper.geometry.max_opening)
        for gripper in robot.grippers.values()
    ]
    monitor.until(
        lambda: all(goal.result is not None for goal in opened), RETURN_TIMEOUT
    )
    moves = _start_back(robot, home)
    monitor.until(
        lambda: all(move.result is not None for move in moves), RETURN_TIMEOUT
    )


def _start_back(robot: Robot, home: Mapping[str, float]) -> tuple[GoalHandle, ...]:
    """Start to move the arms ``home``: directly, around obstacles, or unchecked."""
    with contextlib.suppress(CollisionError):
        return robot.move_joints(home)
    targets = [
        arm.target({name: home[name] for name in arm.joint_names})
        for arm in robot.arms.values()
    ]
    with contextlib.suppress(CollisionError, PlanningError):
        return robot.execute(robot.plan(targets))
    return robot.move_joints(home, collision="ignore")
