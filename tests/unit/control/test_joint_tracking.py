"""The half of a trajectory controller that ROS 1 and ROS 2 share."""

from __future__ import annotations

import math

from tool0.control.joint_tracking import JointTracking
from tool0.control.spline import hold
from tool0.description.model import Joint, JointType
from tool0.hardware.engine import JointState
from tool0.protocol.controllers import Gains

STATE = JointState(2.0, [0.5, 9.0, 3.0], [0.1, 9.0, -0.2], [0.0, 0.0, 0.0])


def tracking(velocity_ff: tuple[float, ...] = ()) -> JointTracking:
    """Return two joints, the third and the first of the state."""
    joints = tuple(
        Joint(name=kind.value, type=kind, parent="world", child=kind.value)
        for kind in (JointType.CONTINUOUS, JointType.REVOLUTE)
    )
    return JointTracking(joints, [Gains(p=1.0)] * 2, velocity_ff, (2, 0), STATE)


def test_it_holds_the_measured_positions() -> None:
    joints = tracking()
    assert joints.setpoint().target() == (3.0, 0.5)
    assert joints.errors(2.0) == ([0.0, 0.0], [0.2, -0.1])


def test_errors_of_continuous_joints_go_the_shortest_way_round() -> None:
    joints = tracking()
    joints.follow([hold(2.0, -3.0), hold(2.0, -3.0)], 2.0)
    errors, _ = joints.errors(2.0)
    assert math.isclose(errors[0], math.tau - 6.0)
    assert errors[1] == -3.5
    assert list(joints.law(None).wrapping) == [0]


def test_feed_forward_of_nothing_is_none() -> None:
    assert tracking((0.0, 0.0)).law(None).feed_forward == ()
    joints = tracking((0.0, 2.0))
    assert joints.law(None).feed_forward == (0.0, 2.0)
    joints.set_feed_forward((0.0, 0.0))
    assert joints.law(None).feed_forward == ()


def test_splines_of_some_joints_are_replaced_by_number() -> None:
    joints = tracking()
    kept, new = joints.sampler.splines[0], hold(2.0, 1.0)
    assert joints.merged({1: new}) == [kept, new]
