"""Trajectories: several points, tolerances, replacement and cancellation."""

import tool0

HOME = [0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0]
LEFT = [0.8, -1.2, 1.3, -1.2, -1.2, 0.6]
STILL = [0.0] * 6

with tool0.bringup(realtime=False) as robot:
    arm = robot.controller("eff_joint_traj_controller")

    # With velocities, the motion is smooth (cubic).  Without velocities, the motion is
    # linear and has jerks.
    way = [
        tool0.TrajectoryPoint(LEFT, STILL, time_from_start=2.0),
        tool0.TrajectoryPoint(HOME, STILL, time_from_start=4.0),
    ]
    print("there and back:", arm.follow(way).wait(timeout=10.0))

    # If a joint deviates too far from its path, the goal is aborted and the arm stops.
    # Without velocities, the motion starts with a jerk, which no joint can follow.
    jerk = [tool0.TrajectoryPoint(LEFT, time_from_start=0.6)]
    goal = arm.follow(jerk, path_tolerance={"shoulder_pan_joint": 0.005})
    print("too strict:", goal.wait(timeout=10.0))

    # A new goal starts from the current setpoint of the old goal.
    first = arm.follow(way)
    robot.run(1.0)
    wanted = arm.query_state(robot.time).positions[0]
    second = arm.follow([tool0.TrajectoryPoint(HOME, STILL, time_from_start=2.0)])
    print(f"replaced at {wanted:.3f} rad:", first.result)
    print("the new one:", second.wait(timeout=5.0))

    # After a cancellation, the arm stops within stop_trajectory_duration, 0.5 s here.
    goal = arm.follow(way)
    robot.run(1.0)
    goal.cancel()
    robot.run(1.0)
    speed = max(map(abs, arm.state.actual.velocities))
    print(f"cancelled: {goal.result}, speed now {speed:.4f} rad/s")

    try:
        arm.follow([tool0.TrajectoryPoint([0.0] * 5, time_from_start=1.0)])
    except tool0.GoalRejectedError as error:
        print("rejected:", error.code, error)
