"""Every scene that comes along lies still around the robot that comes along."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
import pytest
from conformance_types import BringUp

SCENES = sorted((Path(__file__).parents[2] / "examples" / "scenes").glob("*.yaml"))


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_nothing_overlaps_and_nothing_moves(
    bring_up: BringUp, path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.WARNING):
        robot = bring_up(scene=path)
        before = robot.snapshot.objects
        assert before
        robot.run(5.0)
        for start, end in zip(before, robot.snapshot.objects, strict=True):
            np.testing.assert_allclose(end.position, start.position, atol=1e-4)
            np.testing.assert_allclose(end.quat_wxyz, start.quat_wxyz, atol=1e-4)
    assert caplog.records == []


def test_there_are_scenes() -> None:
    assert SCENES
