"""The same program simulated and on a real robot: joints at equal time, and the object.

usage: python benchmarks/real_robot_program.py [RUNS]

The robot is tool0's own UR controller in another process, with a table and a cube that
tool0 does not know of.  Each run is compared with a simulation of what was requested of
the robot, at the times at which it was requested; the cube, with the program simulated
by itself.  The first run after a start is one in which tool0 does not know yet how late
the robot follows.
"""

from __future__ import annotations

import math
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/rigs"))

from real_robot_rig import real_robot

import tool0
from tool0.recording.simulated_run import simulate_beside

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
    pose: {xyz: [0.5, 0.3, 0.15], rpy: [180deg, 0, 20deg]}
    blend: 0.02
  - kind: move_joint
    pose: {xyz: [0.45, 0.1, 0.3], rpy: [180deg, 0, 0]}
    blend: 0.05
  - {kind: move_joint, named_pose: home}
"""


def main() -> None:
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "pick_and_place.yaml")
        file.write_text(PROGRAM)
        wanted = simulated_end(file)
        print(f"simulated: the cube ends at {rounded(wanted)}")
        for number in range(1, runs + 1):
            with real_robot("ur5", "--scene", SCENE) as rig, rig.twin() as twin:
                rig.enable()
                for turn in ("first", "second"):
                    start = cube(twin)
                    record = Path(folder, f"{number}{turn}.mcap")
                    rig.robot.start_recording(record)
                    end = rig.robot.run_program(file).wait(120.0)
                    rig.robot.stop_recording()
                    if end.state != "succeeded":
                        print(f"run {number}, {turn}: {end.state}: {end.error}")
                        break
                    report(number, turn, record)
                    print(
                        f"   the cube is {1e3 * math.dist(cube(twin), wanted):.2f} mm "
                        "from where the simulation leaves it"
                    )
                    twin.scene.place("cube", start)


def simulated_end(file: Path) -> tuple[float, float, float]:
    """Return where the simulated program leaves the cube [m]."""
    with tool0.bringup(arm="ur5", scene=SCENE, realtime=False) as robot:
        end = robot.run_program(file).wait(120.0)
        if end.state != "succeeded":
            raise SystemExit(f"simulated: {end.state}: {end.error}")
        robot.run(1.0)
        return cube(robot)


def cube(robot: tool0.Robot) -> tuple[float, float, float]:
    """Return where the cube is [m]."""
    return robot.scene.pose("cube").position


def report(number: int, turn: str, record: Path) -> None:
    """Print how the joints differ from those of the simulation."""
    run = simulate_beside(record)
    for note in run.notes:
        print("   not repeated:", note)
    joints = ", ".join(
        f"{name.removesuffix('_joint')} {1e3 * item.position_rms:.2f}/"
        f"{1e3 * item.position_most:.2f}"
        for name, item in run.joints.items()
        if name != "finger_joint"
    )
    print(
        f"run {number}, {turn}: lag {1e3 * run.lag:.0f} ms; rms/most [mrad]: {joints}"
    )


def rounded(point: tuple[float, float, float]) -> str:
    return ", ".join(f"{x:.4f}" for x in point)


if __name__ == "__main__":
    main()
