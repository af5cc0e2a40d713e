"""Control time: pause, single steps, reset, emergency stop and real time."""

import tool0

LEFT = [0.8, -1.2, 1.3, -1.2, -1.2, 0.6]

with tool0.bringup(realtime=False) as robot:
    arm = robot.controller("eff_joint_traj_controller")
    goal = arm.follow([tool0.TrajectoryPoint(LEFT, time_from_start=2.0)])
    robot.run(0.5)

    robot.pause()
    robot.step(10)  # ten control periods of 1 ms
    print(f"paused at {robot.time:.3f} s, the goal is {goal.status!r}")
    robot.resume()

    robot.emergency_stop()  # all joints brake, and all goals end
    robot.run(1.0)
    print(f"stopped: {goal.status!r}")
    try:
        arm.follow([tool0.TrajectoryPoint(LEFT, time_from_start=2.0)])
    except tool0.Tool0Error as error:
        print("refused:", error)
    robot.emergency_stop(engaged=False)

    # the time is 0, and all joints except the elbow are in the initial pose
    robot.reset({"elbow_joint": 1.0})
    elbow = robot.joint_state.position["elbow_joint"]
    print(f"reset: {robot.time} s, elbow {elbow} rad")

# In real time, the simulation runs in its own thread, here at ten times the speed.
with tool0.bringup(realtime=True, speed=10.0) as robot:
    arm = robot.controller("eff_joint_traj_controller")
    goal = arm.follow([tool0.TrajectoryPoint(LEFT, time_from_start=1.0)])
    result = goal.wait(timeout=10.0)  # seconds of wall time
    print(f"{result} after {robot.time:.1f} simulated seconds")
