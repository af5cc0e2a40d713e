"""Use your own controllers: the gripper as a GripperActionController."""

from pathlib import Path

import tool0

CONTROLLERS = Path(__file__).parent / "cell" / "gripper_action.yaml"

control = tool0.ControlConfig(
    controllers_file=CONTROLLERS,
    controllers="joint_state_controller gripper_controller",
    stopped_controllers="arm_controller",
)
with tool0.bringup(control=control, realtime=False) as robot:
    for warning in robot.warnings:  # unused keys in the file
        print(f"{warning.file}:{warning.line}: {warning.message}")

    # No controller claims the arm yet, so the arm's brakes hold the arm.
    robot.switch(start=["arm_controller"])
    for status in robot.controllers():
        print(f"{status.name:24} {status.state:12} {status.type}")

    # Send a goal in joint units, like in ROS's action.
    goal = robot.controller("gripper_controller").command_gripper(0.5, max_effort=10.0)
    print(goal.wait(timeout=5.0))
    # Command the opening.  Every controller of the gripper accepts an opening.
    print(robot.gripper.move(opening=0.02).wait(timeout=5.0))
