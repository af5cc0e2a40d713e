"""Programs that take an arm and return it at once, again and again."""

import numpy as np
import pytest

import tool0
from tool0.protocol.arm_motion import ReturnArm, TakeArm


@pytest.mark.slow
@pytest.mark.parametrize("dialect", [False, True], ids=["efforts", "positions"])
def test_an_arm_does_not_sink_from_program_to_program(dialect):
    """A controller of efforts sags when it starts, until its integral carries."""
    with tool0.bringup(arm="ur5e", ros2_control=dialect) as robot:
        robot.run(0.5)
        start = np.array(list(robot.arm.joints.values()))
        for _ in range(10):
            robot.channel.call(TakeArm(by="a program"))
            robot.run(0.01)
            robot.channel.call(ReturnArm())
            robot.run(0.02)
        robot.run(3.0)
        end = np.array(list(robot.arm.joints.values()))
        assert np.abs(end - start).max() < 1e-3  # 0.04 rad without
