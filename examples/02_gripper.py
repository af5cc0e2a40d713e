"""The gripper by its opening in metres: 0.085 is open, 0 is closed."""

import tool0

with tool0.bringup(realtime=False) as robot:
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

    # With a bound on the torque of the driven joint, the fingers squeeze no harder.
    gripper.move(opening=0.0, effort=5.0).wait(timeout=10.0)
    lever = gripper.geometry.lever(robot.joint_state.position["finger_joint"])
    print(f"closed; 5 N·m would grip with {5.0 / lever:.0f} N at each pad")
