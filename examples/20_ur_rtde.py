"""Move an arm with ur_rtde, like a real arm: `pip install ur-rtde`.

The program runs in a separate process and contains no tool0 code.  Instead of the end
of this file, you can run `tool0 bringup --ur --arm ur5e` in another terminal.
"""

import subprocess
import sys

HOST = "127.0.0.20"


def program() -> None:
    """Move the joints and the tool."""
    from rtde_control import RTDEControlInterface
    from rtde_receive import RTDEReceiveInterface

    control, state = RTDEControlInterface(HOST), RTDEReceiveInterface(HOST)
    q = state.getActualQ()
    q[0] += 0.3
    print("moveJ:", control.moveJ(q, 1.05, 1.4))  # [rad], [rad/s], [rad/s²]

    # Follow a path.  The tool does not stop at the first two corners.
    x, y, z, *rotation = state.getActualTCPPose()  # in the base frame [m, rad]
    corners = [(0.0, 0.1, 0.02), (0.1, 0.1, 0.02), (0.1, 0.0, 0.0)]
    path = [[x, y + b, z - a, *rotation, 0.4, 1.5, r] for a, b, r in corners]
    print("moveL:", control.moveL(path))
    print("down by", round(z - state.getActualTCPPose()[2], 3), "m")

    # Start a motion without waiting for its end.
    q[5] += 1.0
    control.moveJ(q, 1.05, 1.4, True)
    while control.getAsyncOperationProgress() >= 0:
        pass
    print("wrist_3 has turned to", round(state.getActualQ()[5], 3), "rad")
    print("reachable:", control.getInverseKinematicsHasSolution([x, y, z, *rotation]))
    control.stopScript()


if sys.argv[1:] == ["program"]:
    program()
else:
    import tool0

    with (
        tool0.bringup(arm="ur5e", realtime=False) as robot,
        tool0.UrController(robot, tool0.UrOptions(host=HOST)) as ur,
    ):
        ur.wait()
        client = subprocess.Popen([sys.executable, __file__, "program"])
        while client.poll() is None:
            robot.run(0.1)  # as fast as possible
