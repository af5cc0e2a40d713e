"""The gripper's fingers at their stops, where soft gains drive them."""

from __future__ import annotations

from conformance_types import BringUp
from ur5_rig import POST, POST_GRIPPER

SPEED = 0.06  # [m/s] of the pads


def test_fingers_rest_at_their_stops_and_leave_them_no_faster_than_told(
    bring_up: BringUp,
) -> None:
    robot = bring_up(controllers_file=[POST, POST_GRIPPER])
    joint = robot.description.model.joint("finger_joint")
    geometry = robot.gripper.geometry
    for target, stop in ((0.0, joint.limits.upper), (0.085, joint.limits.lower)):
        robot.gripper.move(opening=target, speed=SPEED)
        fastest = 0.0
        for _ in range(900):
            robot.run(0.002)
            q = robot.joint_state.position[joint.name]
            qd = robot.joint_state.velocity[joint.name]
            fastest = max(fastest, abs(qd) * geometry.lever(q))
            assert (q - stop) * (1.0 if target == 0.0 else -1.0) < 1e-3
        assert 0.95 * SPEED < fastest < 1.1 * SPEED
