"""Pick a cube and place it in a bin, in one call and step by step."""

import tool0
from tool0.scene import Pose

with tool0.bringup(scene="table_and_bin", realtime=False) as robot:
    # Pick and place in one call, which returns a report.
    report = tool0.pick_and_place(
        robot, "cube", tool0.find_bin(robot.scene.objects, "bin")
    )
    print(report.to_text())

    # Pick step by step.  The z axis of tool0 points out of the flange.  A half turn
    # about the x axis makes the z axis point down.
    robot.reset()
    # in the tool0 frame, with the pads 45 mm apart
    between_pads = Pose(xyz=(0.0, 0.0, 0.1418))
    cube = robot.scene.pose("cube").position
    at = Pose(xyz=cube, rpy=(3.14159, 0.0, 0.0))
    above = Pose(xyz=(cube[0], cube[1], cube[2] + 0.15), rpy=at.rpy)
    robot.arm.move_to(above, tool=between_pads).wait()
    robot.run(0.5)  # wait until the arm is at rest
    robot.force_torque.zero()  # tare: subtract the weight of the gripper
    robot.arm.move_linear(at, tool=between_pads, speed=0.2).wait()
    robot.gripper.move(opening=0.0, speed=0.05, force=40.0)
    state = robot.gripper.wait()
    print(f"{state.motion}, gOBJ {state.gobj}")
    robot.arm.move_linear(above, tool=between_pads, speed=0.2).wait()
    robot.run(0.5)
    _, _, down = robot.force_torque.read().force
    print(f"the cube weighs {1000 * down / 9.81:.0f} g, says the wrist")
