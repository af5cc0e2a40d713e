"""Use your own robot: a xacro file with two arms, and its controllers."""

from pathlib import Path

import tool0

CELL = Path(__file__).parent / "cell"
REST = [0.0, -1.57, 1.57, -1.57, -1.57, 0.0]
JOINTS = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
START = {
    f"{side}_{joint}_joint": position
    for side in ("left", "right")
    for joint, position in zip(JOINTS, REST, strict=True)
}

with tool0.bringup(
    robot=CELL / "two_arms.urdf.xacro",
    args={"distance": "1.0"},
    controllers_file=CELL / "two_arms.yaml",
    controllers="left_arm right_arm left_gripper right_gripper",
    initial_pose=START,
    realtime=False,
) as robot:
    # Both arms turn inward at the same time, and each gripper closes halfway.
    goals = [
        robot.controller(f"{side}_arm").follow(
            [
                tool0.TrajectoryPoint(
                    positions=[turn, *REST[1:]],
                    velocities=[0.0] * 6,
                    time_from_start=2.0,
                )
            ]
        )
        for side, turn in (("left", -0.4), ("right", 0.4))
    ]
    goals += [gripper.move(opening=0.04) for gripper in robot.grippers.values()]
    for goal in goals:
        print(goal.controller, goal.wait(timeout=5.0).status)

    between = robot.pose("left_tool0", relative_to="right_tool0")
    print("left tool seen from the right one:", between)
