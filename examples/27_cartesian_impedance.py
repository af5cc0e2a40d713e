"""Cartesian impedance in URScript: a spring pulls the tool along a circle."""

import socket
import subprocess
import sys

HOST = "127.0.0.27"
CIRCLE = """
def circle():
  sleep(0.5)
  center = get_actual_tcp_pose()
  stiffness = [1500, 1500, 1500, 60, 60, 60]  # [N/m, N*m/rad]
  damping = [120, 120, 120, 4, 4, 4]
  worst = 0.0
  t = 0.0
  while t < 4:
    angle = 3.14159 * t
    goal = pose_add(center, p[0.05 * cos(angle) - 0.05, 0.05 * sin(angle), 0, 0, 0, 0])
    pose = get_actual_tcp_pose()
    turn = pose_trans(goal, pose_inv(pose))
    way = [goal[0] - pose[0], goal[1] - pose[1], goal[2] - pose[2]]
    if norm(way) > worst:
      worst = norm(way)
    end
    jacobian = get_jacobian()
    error = [way[0], way[1], way[2], turn[3], turn[4], turn[5]]
    wrench = stiffness * error - damping * (jacobian * get_actual_joint_speeds())
    direct_torque(transpose(jacobian) * wrench + get_coriolis_and_centrifugal_torques())
    t = t + get_steptime()
  end
  stopj(4)
  socket_open("{}", {})
  socket_send_line(worst)
end
"""


def program() -> None:
    with (
        socket.create_server(("127.0.0.1", 0)) as ours,
        socket.create_connection((HOST, 30002)) as script,
    ):
        ours.settimeout(60.0)  # in case something stops the program
        script.sendall(CIRCLE.format(*ours.getsockname()).encode())
        with ours.accept()[0] as peer:
            print(f"at most {1000.0 * float(peer.recv(100)):.0f} mm off the circle")


if sys.argv[1:] == ["program"]:
    program()
else:
    import tool0

    with (  # At a quarter of the speed, the program has 8 ms for each answer.
        tool0.bringup(arm="ur5e", initial_pose="ready", speed=0.25) as robot,
        tool0.UrController(robot, tool0.UrOptions(host=HOST)) as ur,
    ):
        ur.wait()
        subprocess.run([sys.executable, __file__, "program"], check=True)
