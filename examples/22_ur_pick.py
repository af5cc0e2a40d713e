"""A pick by ur_rtde and the gripper's socket alone, as in a real cell."""

import math
import socket
import subprocess
import sys

HOST = "127.0.0.22"
DOWN = (math.pi, 0.0, 0.0)  # a rotation vector
CUBE, BIN = (-0.5487, -0.1091), (-0.50, 0.32)  # in the robot's base [m]
BETWEEN_PADS = [0.0, 0.0, 0.1418, 0.0, 0.0, 0.0]  # in the flange, 45 mm apart


class Gripper:
    """The socket of Robotiq's URCap: SET and GET in ASCII."""

    def __init__(self) -> None:
        self.socket = socket.create_connection((HOST, 63352))
        self.set("ACT 1 GTO 1 SPE 255 FOR 50")
        while self.get("STA") != 3:
            pass  # it opens and closes once

    def set(self, pairs: str) -> None:
        self.socket.sendall(f"SET {pairs}\n".encode())
        assert self.socket.recv(10) == b"ack"

    def get(self, name: str) -> int:
        self.socket.sendall(f"GET {name}\n".encode())
        return int(self.socket.recv(100).split()[1])

    def move(self, count: int) -> int:
        """Move to 0, open, … 255; return OBJ: 2 is an object between the fingers."""
        self.set(f"POS {count}")
        while self.get("PRE") != count or self.get("OBJ") == 0:
            pass
        return self.get("OBJ")


def program() -> None:
    from rtde_control import RTDEControlInterface

    gripper, arm = Gripper(), RTDEControlInterface(HOST)
    arm.setTcp(BETWEEN_PADS)
    arm.moveJ_IK([*CUBE, 0.15, *DOWN], 1.5, 3.0)
    arm.moveL([*CUBE, 0.0025, *DOWN], 0.5, 1.5)
    print("OBJ", gripper.move(255))
    arm.moveL([*CUBE, 0.15, *DOWN], 0.5, 1.5)
    arm.moveL([*BIN, 0.15, *DOWN], 0.5, 1.5)
    print("OBJ", gripper.move(0))
    arm.stopScript()
    gripper.socket.close()


if sys.argv[1:] == ["program"]:
    program()
else:
    import tool0

    with tool0.bringup(arm="ur5e", scene="table_and_bin", realtime=False) as robot:
        with tool0.UrController(robot, tool0.UrOptions(host=HOST)) as ur:
            ur.wait()
            client = subprocess.Popen([sys.executable, __file__, "program"])
            while client.poll() is None:
                robot.run(0.1)  # as fast as possible
        robot.run(0.5)  # the cube falls
        place = tool0.find_bin(robot.scene.objects, "bin")
        print("in the bin:", place.holds(robot.scene.pose("cube")))
