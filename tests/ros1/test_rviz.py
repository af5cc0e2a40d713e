"""RViz, on a screen of our own, shows the robot and follows it."""

from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from in_rviz import black, blue, shown, start_rviz, view
from promised import absent, require_ros
from ros import TIMEOUT, Bringup, Ros
from ros_client import arm_client, follow_goal, outcome, trajectory
from screen import Pixels, Screen, find_xvfb

SIZE = (900, 640)
ELSEWHERE = (-0.5, -1.8, 1.6, -1.4, -1.57, 0.0)


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
    screen: Screen, ros: Ros, rospy: ModuleType, bringup: Bringup, tmp_path: Path
) -> None:
    rviz, _ = shown(
        lambda: start_rviz(ros, screen, tmp_path, size=SIZE),
        screen,
        shows_the_robot,
        TIMEOUT,
    )
    before = screen.wait_until_still(TIMEOUT)
    assert shows_the_robot(before)
    caps_before = blue(view(before))

    client = arm_client()
    client.send_goal(follow_goal(trajectory([(1.0, ELSEWHERE)])))
    status, result = outcome(client)
    assert not result.error_code, (status, result)

    def is_elsewhere(pixels: Pixels) -> bool:
        caps = blue(view(pixels))
        return bool(
            shows_the_robot(pixels)
            and caps.shape == caps_before.shape
            and np.count_nonzero(caps != caps_before) > caps_before.sum()
        )

    assert screen.wait_for(is_elsewhere, TIMEOUT) is not None, rviz.last_output(60)
    assert rviz.exit_status is None
    rviz.close()
