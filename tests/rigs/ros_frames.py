"""Frames of a bring-up by tf2, against tool0's own kinematics."""

from __future__ import annotations

import time
from collections.abc import Mapping

import numpy as np
from ros import TIMEOUT
from ros_client import Message
from waits import until

from tool0.description.forward_kinematics import link_poses
from tool0.description.model import RobotModel
from tool0.description.transform import Transform, from_quaternion

_PATIENCE = 15.0
"""Time after which a listener is replaced [wall s]."""


def looked_up(target: str, source: str) -> Transform:
    """Return the newest pose of the frame ``source`` in ``target``.

    A latched message is sent once to each subscriber, so a listener that has missed one
    is replaced by a new one.
    """
    end = time.monotonic() + TIMEOUT
    while True:
        try:
            found = _newest(target, source)
        except AssertionError:
            if time.monotonic() > end:
                raise
        else:
            place, turn = found.translation, found.rotation
            return from_quaternion(
                (place.x, place.y, place.z), (turn.w, turn.x, turn.y, turn.z)
            )


def _newest(target: str, source: str) -> Message:
    """Ask a new listener; if it does not learn the frame in time, fail."""
    import tf2_ros
    from rospy import Time

    buffer = tf2_ros.Buffer()
    listener = tf2_ros.TransformListener(buffer)
    end = time.monotonic() + _PATIENCE
    try:
        until(
            lambda: (
                buffer.can_transform(target, source, Time()) or time.monotonic() > end
            ),
            f"frame {source} in {target}",
        )
        known = buffer.all_frames_as_yaml()
        assert buffer.can_transform(target, source, Time()), known
        found: Message = buffer.lookup_transform(target, source, Time()).transform
        return found
    finally:
        listener.unregister()


def assert_agrees(
    found: Transform,
    model: RobotModel,
    position: Mapping[str, float],
    target: str,
    source: str,
) -> None:
    """Assert that a pose is that of the link ``source`` in ``target``.

    The robot has to be nearly at rest: pose and positions are not of one instant.
    """
    poses = link_poses(model, position)
    expected = poses[target].inverse() @ poses[source]
    np.testing.assert_allclose(found.position, expected.position, atol=1e-3)
    np.testing.assert_allclose(found.rotation, expected.rotation, atol=1e-3)
