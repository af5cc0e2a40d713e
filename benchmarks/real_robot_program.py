"""Compares a program in simulation and on a real robot: joints and the object.

usage: python benchmarks/real_robot_program.py [RUNS]

The robot is simulated by tool0's own UR controller in another process, with a table and
a cube that are not in tool0's scene.  Joints are compared at equal times of each path,
because a real robot starts a path some milliseconds later.  In the first run after a
start, tool0 has not yet measured the delay of the robot.
"""

from __future__ import annotations

import math
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/rigs"))

from real_robot_rig import real_robot

import tool0
from tool0.protocol.state import Snapshot

SCENE = "table_and_bin"
PROGRAM = """\
name: pick and place
tool: {xyz: [0, 0, 0.1418]}
steps:
  - {kind: gripper, opening: open}
  - {kind: move_joint, pose: {xyz: [0.45, 0.0, 0.3], rpy: [180deg, 0, 0]}, blend: 0.03}
  - kind: move_joint
    pose: {xyz: [0.5487, 0.1091, 0.2], rpy: [180deg, 0, 0]}
    blend: 0.03
  - {kind: move_linear, pose: {xyz: [0.5487, 0.1091, 0.0025], rpy: [180deg, 0, 0]}}
  - {kind: gripper, opening: closed, force: 40, must_hold: true}
  - kind: move_linear
    pose: {xyz: [0.5487, 0.1091, 0.15], rpy: [180deg, 0, 0]}
    blend: 0.05
  - {kind: move_linear, pose: {xyz: [0.5, 0.2, 0.2], rpy: [180deg, 0, 0]}, blend: 50mm}
  - {kind: move_joint, pose: {xyz: [0.5, 0.3, 0.1], rpy: [180deg, 0, 20deg]}}
  - kind: until
    direction: [0, 0, -1]
    distance: 0.12
    speed: 0.02
    force: 15
    must_touch: true
  - {kind: gripper, opening: open}
  - kind: move_linear
    pose: {xyz: [0.5, 0.3, 0.2], rpy: [180deg, 0, 20deg]}
    blend: 0.02
  - {kind: move_joint, pose: {xyz: [0.45, 0.1, 0.3], rpy: [180deg, 0, 0]}}
  - {kind: move_joint, named_pose: home}
"""


Paths = list[tuple[Any, Any]]
"""Times [s] of each path, shape (n,), and the joint positions at these times [rad],
shape (n, 6)."""


def main() -> None:
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "pick_and_place.yaml")
        file.write_text(PROGRAM)
        with simulated() as robot:
            with watched(robot) as seen:
                run(robot, file)
                robot.run(1.0)
            model, wanted = paths(robot, seen), robot.scene.pose("cube").position
        print(f"{len(model)} paths; the cube ends at {np.round(wanted, 4)} m")
        for number in range(1, runs + 1):
            with real_robot("ur5", "--scene", SCENE) as rig, rig.twin() as twin:
                rig.enable()
                for turn in ("first", "second"):
                    start = twin.scene.pose("cube").position
                    with watched(rig.robot) as seen:
                        run(rig.robot, file)
                    print(f"start {number}, {turn} run:")
                    compare(model, paths(rig.robot, seen))
                    end = twin.scene.pose("cube").position
                    print(f"   cube: {1e3 * math.dist(end, wanted):.2f} mm apart")
                    twin.scene.place("cube", start)


def simulated() -> tool0.Robot:
    """Return the simulated robot in the start pose of the real robot.

    The robot uses the description for ROS 2, like a real robot, so that its joints have
    acceleration limits.
    """
    arm = "ur5"
    with tool0.bringup(arm=arm, realtime=False) as robot:
        start = {name: robot.joint_state.position[name] for name in robot.arm.joints}
    return tool0.bringup(
        arm=arm,
        scene=SCENE,
        ros2_control=True,
        initial_pose=start,
        realtime=False,
    )


def run(robot: tool0.Robot, file: Path) -> None:
    end = robot.run_program(file).wait(120.0)
    if end.state != "succeeded":
        raise SystemExit(f"{end.state}: {end.error}")


@contextmanager
def watched(robot: tool0.Robot) -> Iterator[list[Snapshot]]:
    """Provide a list that contains a block's snapshots when the block ends."""
    subscription = robot.simulation.subscribe(125.0, keep_all=True, with_arms=True)
    seen: list[Snapshot] = []
    try:
        yield seen
    finally:
        seen += subscription.pending()
        subscription.close()


def paths(robot: tool0.Robot, seen: list[Snapshot]) -> Paths:
    """Return the paths that the arm followed, in order."""
    index = [seen[0].joint_names.index(name) for name in robot.arm.joint_names]
    found: dict[int, list[tuple[float, list[float]]]] = {}
    for snapshot in seen:
        (sample,) = snapshot.arms.values()
        if sample.mode == "path" and not sample.is_done:
            joints = [snapshot.position[k] for k in index]
            found.setdefault(sample.path, []).append((sample.path_time, joints))
    return [
        (np.array([t for t, _ in rows]), np.array([q for _, q in rows]))
        for rows in found.values()
    ]


def compare(model: Paths, real: Paths) -> None:
    """Print how the joint positions differ on each path."""
    for k, ((times, joints), (at, measured)) in enumerate(
        zip(model, real, strict=True), 1
    ):
        moving = (at > 0.0) & (at < times[-1])
        expected = np.stack(
            [np.interp(at[moving], times, column) for column in joints.T], axis=1
        )
        errors = 1e3 * (measured[moving] - expected)
        rms = np.sqrt(np.mean(errors**2, axis=0)).max()
        print(
            f"   path {k}, {times[-1]:.1f} s: rms {rms:.2f}, most "
            f"{np.abs(errors).max():.2f} mrad (worst joint)"
        )


if __name__ == "__main__":
    main()
