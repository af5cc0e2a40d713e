"""Objects around the robot: pick a cube from a table, hold it, and reset."""

import tool0
from tool0.scene import Box

HOME = [0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0]
READY = [0.0, -1.2, 1.9, -2.2708, -1.5708, 0.0]


def height(robot: tool0.Robot, name: str) -> float:
    """Return the height of the object in the root frame of the robot [m]."""
    return robot.scene.pose(name).position[2]


with tool0.bringup(scene="table_and_cubes", realtime=False) as robot:
    print("around it:", ", ".join(robot.scene))
    arm = robot.controller("eff_joint_traj_controller")

    arm.follow([tool0.TrajectoryPoint(READY, time_from_start=3.0)]).wait()
    # effort [N·m]; the cube stops the gripper
    robot.gripper.move(opening=0.0, effort=5.0)
    robot.run(1.5)
    print(f"the gripper stands at {1000 * robot.gripper.opening:.0f} mm")

    arm.follow([tool0.TrajectoryPoint(HOME, time_from_start=3.0)]).wait()
    print(f"the red cube is lifted to {height(robot, 'red cube'):.2f} m")
    print(f"the blue cube is still at {height(robot, 'blue cube'):.2f} m")

    tower = robot.scene.pose("blue cube").position
    above = (tower[0], tower[1], tower[2] + 0.06)
    robot.scene.add("die", Box(size=(0.02, 0.02, 0.02)), xyz=above, mass=0.01)
    robot.run(0.5)
    print(f"the die came to lie at {height(robot, 'die'):.2f} m")
    robot.scene.remove("die")

    robot.reset()  # the robot and all objects return to their start poses
    print(f"after a reset the red cube lies at {height(robot, 'red cube'):.2f} m")
