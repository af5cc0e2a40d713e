"""Forward kinematics of every arm against its table; inverse kinematics back again."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from arm_rig import only_chain
from benchmarks.kinematics import round_trip

from tool0.description.catalogue import arms, find_part
from tool0.description.forward_kinematics import link_pose
from tool0.description.loading import assemble
from tool0.kinematics.chain import Array

DATA = Path(__file__).parents[2] / "data" / "kinematics" / "dh_tables.yaml"
TABLES: dict[str, Any] = yaml.safe_load(DATA.read_text(encoding="utf-8"))
N_POSES = 200


def by_table(table: dict[str, float], q: Array) -> Array:
    """Return the poses of the last frame in the first, shape (n, 4, 4)."""
    d = (table["d1"], 0.0, 0.0, table["d4"], table["d5"], table["d6"])
    a = (0.0, table["a2"], table["a3"], 0.0, 0.0, 0.0)
    T = np.broadcast_to(np.eye(4), (len(q), 4, 4))
    for k, alpha in enumerate(TABLES["alpha"]):
        c, s = np.cos(q[:, k]), np.sin(q[:, k])
        ca, sa = np.cos(alpha), np.sin(alpha)
        row = np.zeros((len(q), 4, 4))
        row[:, 0] = np.stack([c, -s * ca, s * sa, a[k] * c], axis=1)
        row[:, 1] = np.stack([s, c * ca, -c * sa, a[k] * s], axis=1)
        row[:, 2] = (0.0, sa, ca, d[k])
        row[:, 3, 3] = 1.0
        T = T @ row
    return T


def test_every_arm_has_a_table_and_says_where_it_is_from() -> None:
    assert set(TABLES["arms"]) == set(arms())
    for name, table in TABLES["arms"].items():
        source = find_part("arm", name).load("specifications")["dh_source"]
        assert (source is None) == (table["source"] is None)


@pytest.mark.parametrize("name", arms())
def test_the_flange_is_where_the_table_says(name: str) -> None:
    model = assemble(name, gripper=None).model
    frame = link_pose(model, {}, "base_link_inertia", relative_to="base")
    np.testing.assert_allclose(frame.matrix, np.eye(4), atol=1e-12)
    q = np.random.default_rng(seed=2).uniform(-np.pi, np.pi, (N_POSES, 6))
    q[0] = 0.0
    poses = only_chain(model).forward(q).T_base_tip
    np.testing.assert_allclose(poses, by_table(TABLES["arms"][name], q), atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("name", arms())
def test_inverse_kinematics_find_the_way_back(name: str) -> None:
    """``make bench`` does the same with 10 000 poses."""
    trip = round_trip(name, n=N_POSES, seed=7)
    assert trip.n_missed == 0
    assert trip.worst <= 1e-9
    assert trip.mean_solutions > 6.0
