import tool0                                # examples/01_hello_arm.py, runs verbatim as a test

with tool0.bringup(arm="ur5", gripper="2f85", realtime=False) as robot:
    goal = robot.controller("eff_joint_traj_controller").follow(
        [tool0.TrajectoryPoint(positions=[0.0, -1.2, 1.4, -1.7, -1.6, 0.0], time_from_start=2.0)]
    )                                       # joint_names=, stamp=, path_tolerance=, goal_tolerance=, goal_time_tolerance= as in ROS
    print(goal.wait(timeout=5.0))           # GoalResult(status=SUCCEEDED, error_code=0, error_string="")
    robot.gripper.move(opening=0.040)
    robot.run(1.0)                          # simulated seconds; with realtime=True the loop runs by itself
    print(robot.time, robot.joint_state.position["elbow_joint"], robot.pose("tool0", relative_to="base"))
