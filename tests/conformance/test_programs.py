"""A program does the same on every engine."""

from __future__ import annotations

import math
from collections.abc import Iterator

import pytest
from flat_options import configured
from taught_programs import TABLE, TOOL, search, taught_pick

import tool0

TIMEOUT = 60.0
"""[simulated s]"""


@pytest.fixture(scope="module")
def shared_robot(engine: str) -> Iterator[tool0.Robot]:
    """Bring a robot up before a table, for all tests."""
    options = configured(
        arm="ur5e",
        engine=engine,
        scene="table_and_bin",
        initial_pose="home",
        realtime=False,
    )
    with tool0.bringup(**options) as robot:
        yield robot


def test_a_taught_pick_puts_the_cube_into_the_bin(robot: tool0.Robot) -> None:
    end = robot.run_program(taught_pick(robot)).wait(TIMEOUT)
    assert (end.state, end.error) == ("succeeded", "")
    box = tool0.find_bin(robot.scene.objects, "bin")
    assert box.holds(robot.scene.pose("cube"))


@pytest.mark.parametrize(
    "changes",
    [{}, {"force": 8.0}, {"frame": "tool", "direction": (0.0, 0.0, 2.0)}],
    ids=["contact", "force", "tool frame"],
)
def test_a_search_stops_at_the_table_and_goes_on_from_there(
    robot: tool0.Robot, changes: dict[str, object]
) -> None:
    box = robot.arm.control_box
    box.set_digital_output(5, False)  # the program sets it at the table
    handle = robot.run_program(search(**changes))
    assert robot.channel.wait_until(lambda: box.state.digital_outputs[5], TIMEOUT)
    lowest = robot.arm.pose(tool=TOOL).position[2]
    forces = [
        math.hypot(*contact.force)
        for contact in robot.contacts()
        if "table" in {contact.first, contact.second}
    ]
    assert TABLE < lowest < TABLE + 0.03
    assert len(forces) >= 1
    assert max(forces) < 60.0
    assert handle.wait(TIMEOUT).state == "succeeded"
    assert robot.arm.pose(tool=TOOL).position == pytest.approx(
        (0.5, 0.1, 0.06), abs=2e-3
    )
