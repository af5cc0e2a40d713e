"""Every scene that comes along lies still around the robot that comes along."""

from __future__ import annotations

import logging

import numpy as np
import pytest
from conformance_types import BringUp

from tool0.scene import shipped_scenes

SCENES = shipped_scenes()


@pytest.mark.parametrize("name", SCENES)
def test_nothing_overlaps_and_nothing_moves(
    bring_up: BringUp, name: str, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.WARNING):
        robot = bring_up(scene=name)
        before = robot.snapshot.objects
        assert before
        robot.run(5.0)
        for start, end in zip(before, robot.snapshot.objects, strict=True):
            np.testing.assert_allclose(end.position, start.position, atol=1e-4)
            np.testing.assert_allclose(end.quat_wxyz, start.quat_wxyz, atol=1e-4)
    assert caplog.records == []


def test_there_are_scenes() -> None:
    assert {"table_and_bin", "table_and_cubes"} <= SCENES.keys()
