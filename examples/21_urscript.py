"""Send URScript to port 30002, and requests to the dashboard server, by sockets."""

import socket
import subprocess
import sys

HOST = "127.0.0.21"
SQUARE = """
def square():
  start = get_actual_tcp_pose()
  i = 0
  while i < 3:
    corner = p[0, [0.1, 0.1, 0][i], [0, -0.1, -0.1][i], 0, 0, 0]
    movel(pose_add(start, corner), a=1.5, v=0.5, r=0.02)
    i = i + 1
  end
  movel(start, a=1.5, v=0.5)
  socket_open("{}", {})
  socket_send_line(point_dist(start, get_actual_tcp_pose()) < 0.001)
  socket_close()
end
"""


def ask(question: str) -> str:
    with socket.create_connection((HOST, 29999)) as dashboard:
        lines = dashboard.makefile("rw")
        lines.readline()  # the server's greeting
        print(question, file=lines, flush=True)
        return lines.readline().strip()


def program() -> None:
    print(ask("robotmode"))
    with (
        socket.create_server(("127.0.0.1", 0)) as ours,
        socket.create_connection((HOST, 30002)) as script,
    ):
        script.sendall(SQUARE.format(*ours.getsockname()).encode())
        peer, _ = ours.accept()
        print("back to within a millimetre:", peer.recv(100).decode().strip())
        peer.close()


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
