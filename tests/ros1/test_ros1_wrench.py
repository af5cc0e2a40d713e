"""The wrench at the wrist in ROS, as Universal Robots' driver has it."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest
from ros import Bringup
from ros_client import call, listening


def test_the_wrench_comes_at_its_rate_and_can_be_zeroed(
    rospy: ModuleType, bringup: Bringup
) -> None:
    from geometry_msgs.msg import WrenchStamped
    from std_srvs.srv import Trigger

    with listening("/wrench", WrenchStamped) as wrench:
        messages = wrench.next(60)
        stamps = [message.header.stamp.to_nsec() for message in messages]
        assert set(np.diff(stamps)) == {8_000_000}
        assert {message.header.frame_id for message in messages} == {"tool0"}
        assert messages[-1].wrench.force.z == pytest.approx(9.03, rel=0.02)
        assert call("/ur_hardware_interface/zero_ftsensor", Trigger).success
        later = wrench.next(80)[-1].wrench
        assert later.force.z == pytest.approx(0.0, abs=0.05)
        assert later.torque.x == pytest.approx(0.0, abs=0.01)
