"""How wide the gripper really is: by where its pads are, whatever moves them there."""

from __future__ import annotations

import numpy as np
from conformance_types import BringUp

import tool0

PADS = ("left_inner_finger_pad", "right_inner_finger_pad")


def between_pads(robot: tool0.Robot) -> float:
    """Return the distance between the faces of the pads, by all joints between [m]."""
    links = robot.description.model.link_by_name
    left, right = (robot.pose(pad).matrix for pad in PADS)
    thick = links[PADS[0]].collisions[0].geometry.size[1]  # type: ignore[union-attr]
    normal = -left[:3, 1]
    return float((right[:3, 3] - left[:3, 3]) @ normal) - thick


def test_the_opening_is_that_of_the_formula_over_the_whole_range(
    bring_up: BringUp,
) -> None:
    robot = bring_up()
    seen = []
    for opening in (0.0, 0.085):
        goal = robot.gripper.move(opening=opening)
        while goal.status is tool0.GoalStatus.ACTIVE:
            robot.run(0.004)
            seen.append(between_pads(robot))
            angle = robot.joint_state.position["finger_joint"]
            assert abs(seen[-1] - robot.gripper.geometry.opening(angle)) <= 5e-4
    assert np.ptp(seen) >= 0.084
