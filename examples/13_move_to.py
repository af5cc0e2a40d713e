"""Command the arm by poses: inverse kinematics, joint motions and straight lines."""

import math

import tool0
from tool0 import Branch
from tool0.scene import Pose

DOWN = (math.pi, 0.0, 0.0)  # tool0's z axis, which is along the gripper, points down
ABOVE = Pose(xyz=(0.45, 0.2, 0.35), rpy=DOWN)
# a point between the gripper's pads, in the tool0 frame
PADS = Pose(xyz=(0.0, 0.0, 0.15))
START = {"shoulder_lift_joint": -1.57, "elbow_joint": 1.57, "wrist_1_joint": -1.57}

with tool0.bringup(
    realtime=False, initial_pose={**START, "wrist_2_joint": -1.57}
) as robot:
    arm = robot.arm
    print("it stands", arm.branch, "with tool0 at", arm.pose())

    # Up to eight solutions reach a pose.  The nearest solution is first.
    for solution in arm.inverse_kinematics(ABOVE):
        elbow = solution.positions["elbow_joint"]
        print(
            f"{solution.branch!s:24} elbow at {elbow:+.2f}, {solution.distance:.2f} s"
        )

    # All joints move at the same time, within their velocities and accelerations.
    print("there:", arm.move_to(ABOVE, speed=1.0).wait(timeout=10.0))

    # Move the point between the pads down in a straight line: 0.1 m at 0.1 m/s.
    x, y, z = arm.pose(tool=PADS).position
    below = Pose(xyz=(x, y, z - 0.1), rpy=DOWN)
    print("down:", arm.move_linear(below, tool=PADS, speed=0.1).wait(timeout=10.0))

    # Move relative to a link.  Here, the link is tool0, and the tool moves back 5 cm.
    back = Pose(xyz=(0.0, 0.0, -0.05))
    arm.move_linear(back, relative_to="tool0").wait(timeout=10.0)
    print("now at", arm.pose())

    # Move to the same pose in another branch, with the wrist flipped.
    goal = arm.move_to(ABOVE, branch=Branch(wrist="flip"), speed=1.0)
    print("flipped:", goal.wait(timeout=10.0), arm.branch)

    try:
        arm.move_linear(Pose(xyz=(1.5, 0.2, 0.35), rpy=DOWN))
    except tool0.UnreachableError as error:
        print("refused:", error)
