"""Compare the same motion in MuJoCo and in Gazebo."""

import tool0

AWAY = [0.5, -1.1708, 1.0708, -0.9708, -1.0708, 1.0]  # [rad]


def move(engine: str) -> list[tuple[float, ...]]:
    """Return the positions of all joints [rad], sampled every 10 ms."""
    with tool0.bringup(engine=engine, realtime=False) as robot:
        arm = robot.controller("eff_joint_traj_controller")
        arm.follow([tool0.TrajectoryPoint(AWAY, time_from_start=2.0)])
        robot.gripper.move(opening=0.04)
        seen = []
        for _ in range(250):
            robot.run(0.01)
            seen.append(robot.snapshot.position)
        return seen


try:
    pairs = zip(move("mujoco"), move("gazebo"), strict=True)
except tool0.EngineUnavailableError as error:
    # The error says: "there is no Gazebo 11 here; install one: …"
    print("nothing to compare with:", error)
else:
    apart = max(
        abs(one - other)
        for first, second in pairs
        for one, other in zip(first, second, strict=True)
    )
    print(f"never more than {1000.0 * apart:.2f} mrad apart")
