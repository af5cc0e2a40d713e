"""A motion that fails is a protective stop, and the program ends, as on a UR."""

from __future__ import annotations

import math
from collections.abc import Iterator

import pytest
from browser import eventually
from ur_rig import UrRig, ur_rig

import tool0

OVER_TABLE = tool0.Pose(xyz=(0.45, 0.15, 0.2), rpy=(math.pi, 0.0, 0.0))
UNLOCK_AFTER = 5.1
"""[s]"""
GOES_ON = 1
"""The output that a program sets after its motion."""
DOWN = "p = get_actual_tcp_pose()\n  p[2] = p[2] - 0.3\n"
WAYS = {
    "movel": f"{DOWN}  movel(p, a=1.2, v=0.25)",
    "movej": f"{DOWN}  movej(get_inverse_kin(p), a=1.4, v=0.6)",
    "movep": f"{DOWN}  movep(p, a=1.2, v=0.2)",
    "speedl": "speedl([0, 0, -0.25, 0, 0, 0], 1.2, 20)",
    "speedj": "speedj([0, 0.4, 0, 0, 0, 0], 1.4, 20)",
    "servoj": f"{DOWN}  servoj(get_inverse_kin(p), t=5, gain=100)",
    "freedrive": "freedrive_mode()\n  sleep(20)",
}


@pytest.fixture(scope="module")
def rig() -> Iterator[UrRig]:
    with ur_rig(speed=4.0, scene="table_and_cubes") as rig:
        yield rig


def start(rig: UrRig, motion: str) -> None:
    """Move over the table, and start a program there."""
    robot, box = rig.robot, rig.robot.arm.control_box
    if box.state.protective_stop:
        robot.reset(keep_time=True)  # the brakes hold it pressed on the table
        robot.run(UNLOCK_AFTER)
        box.unlock()
        box.play()
    box.set_digital_output(GOES_ON, False)
    assert robot.arm.move_to(OVER_TABLE, speed=0.2).wait(20.0)
    text = f"def test():\n  {motion}\n  set_digital_out({GOES_ON}, True)\nend\n"
    with rig.connect(30002) as client:
        client.sendall(text.encode())
        eventually(lambda: box.state.taken_by == "test", "the program has the arm")


def require_end(rig: UrRig) -> None:
    """The program has ended, without going on, and the arm stays where it is."""
    robot, box = rig.robot, rig.robot.arm.control_box
    eventually(lambda: not box.state.taken_by, "the program has lost the arm")
    with rig.connect(29999) as dashboard, dashboard.makefile("rw") as lines:
        lines.readline()

        def has_ended() -> bool:
            lines.write("running\n")
            lines.flush()
            return lines.readline() == "Program running: false\n"

        eventually(has_ended, "the program has ended")
    robot.run(1.0)
    before = robot.arm.joints
    robot.run(0.5)
    after = robot.arm.joints
    assert max(abs(after[name] - before[name]) for name in before) < 0.01
    assert not box.state.digital_outputs[GOES_ON]


@pytest.mark.parametrize("way", [way for way in WAYS if way != "freedrive"])
def test_the_table_in_the_way(rig: UrRig, way: str) -> None:
    start(rig, WAYS[way])
    box = rig.robot.arm.control_box
    eventually(lambda: bool(box.state.protective_stop), "a protective stop")
    assert "'table'" in box.state.protective_stop
    require_end(rig)


@pytest.mark.parametrize("way", WAYS)
def test_an_emergency_stop(rig: UrRig, way: str) -> None:
    """However short it is."""
    start(rig, WAYS[way])
    rig.robot.emergency_stop()
    rig.robot.emergency_stop(False)
    require_end(rig)
