"""An arm moved by ur_rtde, as a real one: `pip install ur-rtde`.

The program runs in a process of its own, and knows nothing of tool0.  Instead of the
end of this file, you can run `tool0 bringup --ur --arm ur5e` in another terminal.
"""

import subprocess
import sys

HOST = "127.0.0.20"


def program() -> None:
    """Move joints and the tool."""
    from rtde_control import RTDEControlInterface
    from rtde_receive import RTDEReceiveInterface

    control, state = RTDEControlInterface(HOST), RTDEReceiveInterface(HOST)
    q = state.getActualQ()
    q[0] += 0.3
    print("moveJ:", control.moveJ(q, 1.05, 1.4))  # [rad], [rad/s], [rad/s²]

    # A path: the tool does not stop at the first two corners.
    x, y, z, *rotation = state.getActualTCPPose()  # in the base [m, rad]
    corners = [(0.0, 0.1, 0.02), (0.1, 0.1, 0.02), (0.1, 0.0, 0.0)]
    path = [[x, y + b, z - a, *rotation, 0.4, 1.5, r] for a, b, r in corners]
    print("moveL:", control.moveL(path))
    print("down by", round(z - state.getActualTCPPose()[2], 3), "m")

    # A move that the program does not wait for.
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
