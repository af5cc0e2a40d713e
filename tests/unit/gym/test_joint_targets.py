"""Targets of the joints by which the environments move an arm."""

from __future__ import annotations

import numpy as np
import pytest

from tool0.gym.actions import ArmActions
from tool0.gym.options import EnvOptions
from tool0.gym.workspace import workspaces


@pytest.mark.parametrize("action", ["joint", "cartesian"])
def test_a_joint_that_was_pushed_beyond_its_limit_is_commanded_to_it(
    action: str,
) -> None:
    options = EnvOptions(action=action)
    space = workspaces(options)["arm"]
    actions = ArmActions(space, options)
    still = np.zeros((1, len(actions.names)))
    for beyond in (space.lower - 0.4, space.upper + 0.4):
        found = actions.positions(still, beyond[None], beyond[None])
        assert (found >= space.lower).all()
        assert (found <= space.upper).all()
