"""A motion that ends because two links of one arm meet."""

from __future__ import annotations

import tool0


def test_an_aborted_motion_names_the_two_links_in_contact() -> None:
    pose = {"shoulder_lift_joint": -1.8, "elbow_joint": 2.75, "wrist_1_joint": 2.2}
    with tool0.bringup(realtime=False) as robot:
        found = robot.find_collisions({**pose, "wrist_2_joint": 0.0})
        assert [(c.first, c.second) for c in found] == [
            ("forearm_link", "wrist_2_link")
        ]
        positions = {**pose, "wrist_2_joint": 0.0}
        (goal,) = robot.move_joints(positions, collision="ignore")
        text = goal.wait().error_string
    # the shoulder moves both links; what they do to each other stops joints between
    assert text.endswith("; 'wrist_2_link' touches 'forearm_link'")
