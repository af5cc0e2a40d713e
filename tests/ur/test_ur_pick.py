"""A program of ur_rtde and the gripper's socket places cubes in the bin."""

from __future__ import annotations

import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path

import pytest
from promised import require_engine, require_ur_rtde
from ur_address import free_host

import tool0
from tool0.scene import Box, Pose, Scene, load_scene

PROGRAM = Path(__file__).parent.parent / "rigs" / "ur_pick.py"
PLACES = [(x, y) for x in (0.38, 0.51, 0.64) for y in (-0.11, 0.02, 0.15, 0.28)][:10]
"""Of the cubes, in the robot's root [m]."""
WIDTH, REST = 0.045, 0.0025
"""Edge of a cube, and the height of its middle on the table [m]."""
TIMEOUT = 120.0
"""[wall s]"""


def scene() -> Scene:
    """Return a table with a bin and ten cubes."""
    others = load_scene("table_and_bin").objects
    (cube,) = (item for item in others if item.name == "cube")
    assert isinstance(cube.geometry, Box)
    assert cube.geometry.size == (WIDTH,) * 3
    cubes = [
        replace(cube, name=f"cube_{k}", pose=Pose(xyz=(x, y, REST)))
        for k, (x, y) in enumerate(PLACES)
    ]
    return Scene(tuple(item for item in others if item is not cube) + tuple(cubes))


def n_in_bin(robot: tool0.Robot) -> int:
    box = tool0.find_bin(robot.scene.objects, "bin")
    return sum(box.holds(robot.scene.pose(f"cube_{k}")) for k in range(len(PLACES)))


@pytest.mark.parametrize(("engine", "n"), [("mujoco", len(PLACES)), ("gazebo", 4)])
def test_each_cube_ends_in_the_bin(engine: str, n: int) -> None:
    require_engine(engine)
    require_ur_rtde()
    options = tool0.UrOptions(host=free_host())
    has_ended = threading.Event()
    with (
        tool0.bringup(
            arm="ur5e", engine=engine, scene=scene(), realtime=False
        ) as robot,
        tool0.UrController(robot, options) as controller,
    ):

        def run() -> None:
            while not has_ended.is_set():
                robot.run(0.2)

        clock = threading.Thread(target=run)
        clock.start()
        try:
            controller.wait()
            places = [f"{-x},{-y}" for x, y in PLACES[:n]]  # UR's base is turned
            done = subprocess.run(
                [sys.executable, str(PROGRAM), options.host, *places],
                capture_output=True,
                text=True,
                timeout=TIMEOUT,
                check=False,
            )
        finally:
            has_ended.set()
            clock.join()
        assert done.returncode == 0, done.stderr
        robot.run(0.5)  # the last one falls
        assert done.stdout.split() == ["gOBJ", "2"] * n
        assert n_in_bin(robot) == n
