"""Joint impedance by torques.  Each joint acts like a spring and yields to a force.

The robot adds the torques that balance gravity, like a UR with `direct_torque`.  A
program in URScript or with ur_rtde would send the same torques.  Simulated time
advances only between two torque commands.
"""

import numpy as np

import tool0

STIFFNESS = np.array([400.0, 400.0, 300.0, 60.0, 60.0, 60.0])  # [N·m/rad]
DAMPING = np.array([60.0, 60.0, 40.0, 5.0, 5.0, 5.0])  # [N·m·s/rad]
PERIOD = 0.002  # [s]


def hold(robot: tool0.Robot, goal: np.ndarray, duration: float) -> np.ndarray:
    """Pull the joints to the goal with springs, and return their deviations [rad]."""
    for _ in range(round(duration / PERIOD)):
        state = robot.snapshot
        q, qd = np.array(state.position), np.array(state.velocity)
        robot.arm.motion.drive_torques(STIFFNESS * (goal - q) - DAMPING * qd)
        robot.run(PERIOD)
    return goal - np.array(robot.snapshot.position)


with tool0.bringup(arm="ur5e", gripper=None, realtime=False) as robot:
    robot.arm.motion.take("joint impedance")
    robot.run(0.5)
    goal = np.array(robot.snapshot.position)
    print(f"at rest: {abs(hold(robot, goal, 0.5)).max():.3f} rad off")

    robot.apply_wrench("wrist_3_link", force=(0.0, 60.0, 0.0))  # an external force [N]
    pushed = hold(robot, goal, 2.0)
    mode = robot.arm.motion.state.mode
    print(f"pushed: {abs(pushed).max():.2f} rad off, {mode} mode")
    robot.clear_wrenches()
    print(f"released: {abs(hold(robot, goal, 2.0)).max():.3f} rad off")

    # If no further torques are sent, the arm returns to position control.
    robot.run(0.5)
    print("then:", robot.arm.motion.state.mode)
