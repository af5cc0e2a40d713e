"""Pick with ur_rtde and the gripper's socket only, like in a real cell."""

import socket
import subprocess
import sys

HOST = "127.0.0.22"
DOWN = (3.14159265, 0.0, 0.0)  # rotation vector [rad]
CUBE, BIN = (-0.5487, -0.1091), (-0.50, 0.32)  # in the base frame of the robot [m]


class Gripper:
    """The socket of Robotiq's URCap, with the commands SET and GET in ASCII."""

    def __init__(self) -> None:
        self.socket = socket.create_connection((HOST, 63352))
        self.ask("SET ACT 1 GTO 1 SPE 255 FOR 50")
        while self.ask("GET STA") != "STA 3":  # 3 means activated
            pass

    def ask(self, line: str) -> str:
        self.socket.sendall(f"{line}\n".encode())
        return self.socket.recv(100).decode().strip()

    def move(self, count: int) -> str:
        self.ask(f"SET POS {count}")  # the answer is "ack"
        while (found := self.ask("GET OBJ")) == "OBJ 0":  # 0 means moving
            pass
        return found


def program() -> None:
    from rtde_control import RTDEControlInterface

    gripper, arm = Gripper(), RTDEControlInterface(HOST)
    arm.setTcp([0.0, 0.0, 0.1418, 0.0, 0.0, 0.0])  # the point between the pads
    arm.moveJ_IK([*CUBE, 0.15, *DOWN], 1.5, 3.0)
    arm.moveL([*CUBE, 0.0025, *DOWN], 0.5, 1.5)
    print(gripper.move(255), "is an object between the fingers")
    arm.moveL([*CUBE, 0.15, *DOWN], 0.5, 1.5)
    arm.moveL([*BIN, 0.15, *DOWN], 0.5, 1.5)
    print(gripper.move(0), "is an arrival")
    arm.stopScript()


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
        cube = robot.scene.pose("cube")
        print("in:", tool0.find_bin(robot.scene.objects, "bin").holds(cube))
