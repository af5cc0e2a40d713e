"""One arm hands a cube to another, which places it in the bin."""

from __future__ import annotations

import pytest
from conformance_types import BringUp

from tool0.api.grasps import find_bin
from tool0.cli.demos.handover import HandoverCell, hand_over
from tool0.description.config import DescriptionConfig

PLACES = HandoverCell.of(1.0, 1.45)


def test_a_cube_changes_hands_and_ends_in_the_bin(bring_up: BringUp) -> None:
    cell = PLACES.cell(
        DescriptionConfig(arm="ur5", gripper="2f85"),
        DescriptionConfig(arm="ur10e", gripper="hande"),
    )
    scene = PLACES.scene(edge=0.045, mass=0.1, friction=1.0)
    robot = bring_up(cell=cell, scene=scene)
    into = find_bin(robot.scene.objects, "bin")
    report = hand_over(robot, "cube", into, PLACES.meeting)
    assert report.failure is None
    assert report.success
    assert into.holds(robot.scene.pose("cube"))
    assert report.slip is not None
    assert report.slip < 3e-3
    phases = list(report.phases)
    assert phases.index("taking it") < phases.index("handing over")
    assert report.force == 60.0


@pytest.mark.parametrize(("giver", "taker"), [(1.0, 1.0), (0.56, 1.0), (2.0, 1.3)])
def test_robots_of_any_size_meet_in_front_of_both(giver: float, taker: float) -> None:
    places = HandoverCell.of(giver, taker)
    x, y, z = places.meeting
    for table, scale in ((places.giver, giver), (places.taker, taker)):
        assert x - table.base[0] == pytest.approx(0.45 * scale)
        assert abs(y - table.base[1]) == pytest.approx(0.55 * scale)
    assert z <= 0.33
    assert places.giver.base[1] > 0.0 > places.taker.base[1]
