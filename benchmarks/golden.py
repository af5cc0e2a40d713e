"""The goals in the recordings of the original system, executed on tool0's engines."""

from __future__ import annotations

import csv
import gzip
import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import tool0

DATA = Path(__file__).parent.parent / "tests" / "data" / "golden"
SCENARIOS = tuple(sorted(path.stem for path in DATA.glob("[0-9]*.json")))
ARM = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
SETTLE = 5.0
"""Simulated time before the first goal [s].  The arm comes to rest in this time."""
TRANSIENT = 0.2
"""Time after the first goal that the comparison excludes [s]."""


@dataclass(frozen=True)
class Comparison:
    """One scenario, recorded and simulated, at the times of the recording."""

    scenario: str
    joints: tuple[str, ...]
    time: np.ndarray
    recorded: np.ndarray
    """Recorded actual positions [rad], shape (n_times, n_joints)."""
    simulated: np.ndarray
    statuses: tuple[str, ...]

    @property
    def worst(self) -> float:
        """Largest difference of any joint after the transient [rad]."""
        return self._worst(self.recorded)

    def worst_beside(self, other: Comparison) -> float:
        """Return the largest difference from the same goals on another engine [rad]."""
        return self._worst(other.simulated)

    def _worst(self, expected: np.ndarray) -> float:
        late = self.time >= TRANSIENT
        return float(np.abs(expected - self.simulated)[late].max())


@cache
def compare(name: str, engine: str) -> Comparison:
    """Replay the scenario ``name`` on ``engine``, with the masses of the original."""
    script: dict[str, Any] = json.loads((DATA / f"{name}.json").read_text())
    with gzip.open(DATA / f"{name}.csv.gz", "rt") as file:
        rows = list(csv.DictReader(file))
    joints = ("finger_joint",) if "gripper" in name else ARM
    recorded = np.array([[float(r[f"act_pos.{j}"]) for j in joints] for r in rows])
    time = np.array([float(row["t"]) for row in rows])
    start = dict(zip(ARM, script["start_pose"], strict=True))
    original = tool0.DescriptionConfig(
        physical_params=DATA / "ur5_physical_parameters.yaml",
        gripper_params=DATA / "2f85_physical_parameters.yaml",
        gripper_joint_limit_params=DATA / "2f85_joint_limits.yaml",
    )
    with tool0.bringup(
        description=original,
        engine=engine,
        realtime=False,
        controllers_file=DATA.parent / "controllers" / "ur5_controllers.yaml",
        initial_pose={**start, "finger_joint": script["start_gripper"]},
    ) as robot:
        robot.run(SETTLE)
        goals, simulated = _replay(robot, script, time, joints)
        statuses = tuple(goal.status.value for goal in goals)
    return Comparison(name, joints, time, recorded, simulated, statuses)


def _replay(
    robot: tool0.Robot,
    script: dict[str, Any],
    time: np.ndarray,
    joints: tuple[str, ...],
) -> tuple[list[Any], np.ndarray]:
    """Send the recorded goals at their times, and sample at the recorded times."""
    controller = robot.controller(script["controller"])
    sent = [
        e["t"] for e in script["events"] if e["event"].endswith((" sent", "cancel"))
    ]
    actions = list(zip(sent, script["goals"], strict=True))
    goals: list[Any] = []
    simulated = []
    zero = robot.time + max(0.0, -time[0])
    for t in time:
        while actions and actions[0][0] <= t:
            at, action = actions.pop(0)
            robot.run(max(0.0, zero + at - robot.time))
            if "cancel" in action:
                goals[-1].cancel()
                continue
            points = [tool0.TrajectoryPoint(**point) for point in action["points"]]
            goals.append(controller.follow(points))
        robot.run(max(0.0, zero + t - robot.time))
        position = robot.joint_state.position
        simulated.append([position[joint] for joint in joints])
    return goals, np.array(simulated)
