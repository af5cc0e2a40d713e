"""URScript to port 30002, and questions to the dashboard server, by plain sockets."""

import socket

import tool0

HOST = "127.0.0.21"
SQUARE = """
def square():
  start = get_actual_tcp_pose()
  corners = [p[0, 0.1, 0, 0, 0, 0], p[0, 0.1, -0.1, 0, 0, 0], p[0, 0, -0.1, 0, 0, 0]]
  i = 0
  while i < 3:
    movel(pose_add(start, corners[i]), a=1.5, v=0.5, r=0.02)
    i = i + 1
  end
  movel(start, a=1.5, v=0.5)
  socket_open("{host}", {port})
  socket_send_line(str_cat("back within mm: ", point_dist(start, get_actual_tcp_pose()) < 0.001))
  socket_close()
end
"""


def ask(question: str) -> str:
    """Return what the dashboard server answers."""
    with socket.create_connection((HOST, 29999)) as dashboard:
        lines = dashboard.makefile("rw")
        lines.readline()  # its greeting
        lines.write(f"{question}\n")
        lines.flush()
        return lines.readline().strip()


with tool0.bringup(arm="ur5e") as robot:
    with tool0.UrController(robot, tool0.UrOptions(host=HOST)) as ur:
        ur.wait()
        print(ask("robotmode"), "/", ask("PolyscopeVersion"))
        with (
            socket.create_server(("127.0.0.1", 0)) as ours,
            socket.create_connection((HOST, 30002)) as script,
        ):
            address, port = ours.getsockname()
            script.sendall(SQUARE.format(host=address, port=port).encode())
            peer, _ = ours.accept()
            with peer:
                print(peer.makefile().readline().strip())
        # A mistake is found before anything moves.
        with socket.create_connection((HOST, 30001)) as primary:
            primary.sendall(b"movej([0, -1.57], a=1)\n")
            while b"six" not in (received := primary.recv(65536)):
                pass
            print("refused:", b"movej" in received)
