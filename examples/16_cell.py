"""A cell from a YAML file, with two different robots, one of which has a gripper."""

from pathlib import Path

import tool0

CELL = Path(__file__).parent / "cell" / "two_robots.yaml"

with tool0.bringup(cell=CELL, realtime=False) as robot:
    print("robots:", ", ".join(item.title for item in robot.description.robots))
    print("cameras:", ", ".join(robot.cameras))

    # A named pose moves all robots at the same time, or only one robot.
    for goal in robot.go_to_pose("up"):
        print(goal.controller, goal.wait(timeout=20.0).status)
    for goal in robot.go_to_pose("home", robot="left"):
        goal.wait(timeout=20.0)

    # Joint names start with the name of the robot, so that one call can move both
    # robots.
    for goal in robot.move_joints(
        {"left_shoulder_pan_joint": 0.3, "right_wrist_3_joint": 0.5}
    ):
        goal.wait(timeout=10.0)

    # Arms and grippers are selected by the names of their robots.
    left, right = robot.arms["left"], robot.arms["right"]
    robot.grippers["left"].move(opening=0.03).wait(timeout=5.0)
    print(f"left gripper: {1e3 * robot.grippers['left'].opening:.0f} mm")
    print(f"left wrist: {left.force_torque.read().force[2]:.1f} N")
    apart = robot.pose(left.tip, relative_to=right.tip).position
    print(f"tools apart: {sum(value**2 for value in apart) ** 0.5:.2f} m")

    # The emergency stop stops all robots.
    robot.emergency_stop()
    print("stopped:", robot.snapshot.is_stopped)
