"""RViz, on a screen of our own, shows the robot and follows it."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from in_rviz import black, blue, shown, start_rviz, view
from promised import absent, require_ros
from ros import TIMEOUT, Bringup, Ros
from screen import Pixels, Screen, find_xvfb

SIZE = (900, 640)
MOVE = (
    "{joint_names: [elbow_joint, shoulder_lift_joint, shoulder_pan_joint, "
    "wrist_1_joint, wrist_2_joint, wrist_3_joint], "
    "points: [{positions: [1.6, -1.8, -0.5, -1.4, -1.57, 0.0], "
    "time_from_start: {secs: 1}}]}"
)


@pytest.fixture
def screen() -> Iterator[Screen]:
    require_ros(rviz=True)
    if find_xvfb() is None:
        absent("ros1", "no Xvfb is installed")
    with Screen(*SIZE) as screen:
        yield screen


def shows_the_robot(pixels: Pixels) -> bool:
    """Return whether its joints' caps and its gripper are seen, meshes and all."""
    world = view(pixels)
    return bool(blue(world).sum() > 400 and black(world).sum() > 600)


def test_it_shows_the_robot_moving(
    screen: Screen, ros: Ros, bringup: Bringup, tmp_path: Path
) -> None:
    rviz, before = shown(
        lambda: start_rviz(ros, screen, tmp_path, size=SIZE),
        screen,
        shows_the_robot,
        TIMEOUT,
    )

    ros.run(
        *("rostopic", "pub", "--once", "/eff_joint_traj_controller/command"),
        *("trajectory_msgs/JointTrajectory", MOVE),
    )

    def is_elsewhere(pixels: Pixels) -> bool:
        if not shows_the_robot(pixels):
            return False
        here, there = blue(view(before)), blue(view(pixels))
        return (
            here.shape == there.shape and np.count_nonzero(here != there) > here.sum()
        )

    assert screen.wait_for(is_elsewhere, TIMEOUT) is not None
    assert rviz.exit_status is None
    rviz.close()
