"""Gains that follow from the model: stable, and as exact as the bounds demand."""

from __future__ import annotations

import pytest
from benchmarks.drives import drift, spectral_radius, tracking

from tool0.description.loading import assemble

ROBOTS = (("ur3e", "hande"), ("ur10e", "2f140"), ("ur30", "none"))


@pytest.mark.parametrize(("arm", "gripper"), [*ROBOTS, ("ur5", "2f85")])
def test_the_closed_loop_is_stable_in_random_poses(arm: str, gripper: str) -> None:
    description = assemble(arm, gripper)
    for loaded in (False, True):
        assert spectral_radius(description, loaded=loaded, n_poses=200) < 1.0


@pytest.mark.parametrize(("arm", "gripper"), ROBOTS[:2])
def test_a_loaded_arm_follows_at_most_of_its_speed(arm: str, gripper: str) -> None:
    moved = tracking(assemble(arm, gripper, pedestal_height=0.0), n_moves=3)
    assert moved.n_motions == 3
    assert moved.path < 0.05
    assert moved.final < 0.002


@pytest.mark.parametrize(("arm", "gripper"), ROBOTS)
def test_an_arm_holds_its_pose(arm: str, gripper: str) -> None:
    assert drift(assemble(arm, gripper)) < 0.02
