"""Command the gripper by its opening [m]: 0.085 is open, 0 is closed."""

import tool0
from tool0.scene import Box

with tool0.bringup(initial_pose="ready", realtime=False) as robot:
    gripper = robot.gripper
    slowest, fastest = gripper.geometry.speed
    print(f"opening {1000 * gripper.opening:.1f} mm")

    for opening, speed in ((0.040, fastest), (0.010, slowest), (0.085, None)):
        before = robot.time
        result = gripper.move(opening=opening, speed=speed).wait(timeout=10.0)
        print(
            f"{result.status!r} after {robot.time - before:.2f} s: "
            f"{1000 * gripper.opening:.1f} mm, "
            f"finger_joint {robot.joint_state.position['finger_joint']:.3f} rad"
        )

    # Speed and force are settings of the drive, like on the real gripper.
    shape = Box(size=(0.045, 0.045, 0.045))
    robot.scene.add("cube", shape, xyz=(0.5487, 0.1091, 0.003))  # fixed
    gripper.move(opening=0.0, speed=0.05, force=60.0)
    state = gripper.wait(timeout=10.0)
    print(
        f"{state.motion}: {1000 * (state.width or 0.0):.1f} mm wide, gOBJ {state.gobj}"
    )
    robot.scene.remove("cube")
    robot.run(0.1)  # until the fingers move again
    state = gripper.wait(timeout=10.0)
    print(f"{state.motion}: open {1000 * state.opening:.1f} mm, gOBJ {state.gobj}")
