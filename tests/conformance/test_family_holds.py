"""Arms of any size hold their pose with any gripper."""

from __future__ import annotations

import pytest
from conformance_types import BringUp


@pytest.mark.parametrize(
    ("arm", "gripper"),
    [("ur3e", "hande"), ("ur10e", "2f140"), ("ur30", "2f140")],
)
def test_it_holds_home_for_ten_seconds(
    bring_up: BringUp, arm: str, gripper: str
) -> None:
    robot = bring_up(arm=arm, gripper=gripper)
    assert robot.warnings == ()
    robot.run(10.0)
    assert robot.summary()["max_drift"] <= 0.02
    assert robot.snapshot.fault is None
