"""Grip a cube through the socket of Robotiq's URCap, like a program for a real UR.

    tool0 bringup --ur
    python 23_robotiq_socket.py 127.0.0.1

The client does not use tool0.  Without an address, the script brings up a robot.
"""

import socket
import sys

STATES = {1: "met something while opening", 2: "holds something", 3: "has arrived"}


def operate(host: str) -> None:
    """Activate the gripper, close it and open it."""
    with socket.create_connection((host, 63352)) as connection:

        def ask(command: str) -> str:
            connection.sendall(f"{command}\n".encode())
            return connection.recv(1024).decode()

        def read(variable: str) -> int:
            return int(ask(f"GET {variable}").split()[1])

        def move(position: int, speed: int = 255, force: int = 0) -> str:
            ask(f"SET POS {position} SPE {speed} FOR {force} GTO 1")
            while not (state := read("OBJ")):
                pass
            return f"{STATES[state]} at {read('POS')}"

        if read("STA") != 3:
            ask("SET ACT 0")
            ask("SET ACT 1")
            while read("STA") != 3:
                pass
        print("activated, fault", read("FLT"))
        print("closed:", move(255))
        print("opened:", move(0))


if sys.argv[1:]:
    operate(sys.argv[1])
else:
    import tool0
    from tool0.scene import Box

    options = tool0.UrOptions(host="127.20.0.1")  # a robot may already use 127.0.0.1
    with (
        tool0.bringup(initial_pose="ready") as robot,
        tool0.UrController(robot, options) as ur,
    ):
        address = ur.wait()["arm"].address
        pads = robot.arm.pose(tool=robot.gripper.tcp(0.04)).position
        robot.scene.add("cube", Box(size=(0.04, 0.04, 0.04)), xyz=pads)
        operate(address)
