"""Kinematics of the tool: laws that hold for every copy."""

from __future__ import annotations

import numpy as np
import pytest

from tool0.description.transform_arrays import Frames, from_rotation_vectors
from tool0.gym.options import EnvOptions
from tool0.gym.tool import chord_vectors, downward
from tool0.gym.workspace import workspaces

PAIRS = [("ur5", "2f85"), ("ur3e", "hande"), ("ur20", "2f140")]

rng = np.random.default_rng(0)


def test_a_chord_is_about_the_rotation_vector() -> None:
    R = from_rotation_vectors(rng.uniform(-2.0, 2.0, (50, 3)))
    vectors = rng.uniform(-0.1, 0.1, (50, 3))
    found = chord_vectors(R, from_rotation_vectors(vectors) @ R)
    np.testing.assert_allclose(found, vectors, atol=2e-4)


@pytest.mark.parametrize("pair", PAIRS)
def test_a_step_takes_the_tool_where_it_is_to_go(pair: tuple[str, str]) -> None:
    arm, gripper = pair
    space = workspaces(EnvOptions(arm=arm, gripper=gripper))["arm"]
    n, tool = 20, space.tool
    q = space.start + rng.uniform(-0.1, 0.1, (n, 6))
    pose = tool.pose(q)
    wanted = Frames(
        pose.position + rng.uniform(-0.015, 0.015, (n, 3)),
        from_rotation_vectors(rng.uniform(-0.05, 0.05, (n, 3))) @ pose.rotation,
    )
    found = tool.pose(tool.approach(q, wanted, np.full(6, 1.0)))
    np.testing.assert_allclose(found.position, wanted.position, atol=5e-4)
    np.testing.assert_allclose(found.rotation, wanted.rotation, atol=5e-3)
    limit = np.full(6, 0.001)
    assert np.abs(tool.approach(q, wanted, limit) - q).max() <= 0.001 + 1e-12


@pytest.mark.parametrize("pair", PAIRS)
def test_the_kernel_computes_what_numpy_does(
    pair: tuple[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    options = EnvOptions(arm=pair[0], gripper=pair[1])
    compiled = workspaces(options)["arm"].tool
    monkeypatch.setenv("TOOL0_KERNEL", "python")
    space = workspaces(options)["arm"]
    reference = space.tool
    q = space.start + rng.uniform(-0.5, 0.5, (200, 6))
    pose = reference.pose(q)
    for a, b in zip(compiled.pose(q), pose, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-12)
    wanted = Frames(
        pose.position + rng.uniform(-0.05, 0.05, (200, 3)),
        from_rotation_vectors(rng.uniform(-1.5, 1.5, (200, 3))) @ pose.rotation,
    )
    for limit in (np.full(6, 0.02), np.full(6, 10.0)):
        np.testing.assert_allclose(
            compiled.approach(q, wanted, limit),
            reference.approach(q, wanted, limit),
            atol=1e-8,
        )


@pytest.mark.parametrize("pair", PAIRS)
def test_the_tool_starts_above_the_table_and_looks_down(pair: tuple[str, str]) -> None:
    space = workspaces(EnvOptions(arm=pair[0], gripper=pair[1]))["arm"]
    pose = space.tool.pose(space.start[None])
    np.testing.assert_allclose(pose.position[0], space.start_position, atol=1e-6)
    np.testing.assert_allclose(
        pose.rotation, downward(np.array([space.start_yaw])), atol=1e-6
    )
    low, high = space.area()
    assert (low < high).all()
    assert space.is_in_reach(space.start_position)
    assert not space.is_in_reach(np.array([5.0, 0.0, 0.0]))
