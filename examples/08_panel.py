"""The panel: a web page, and a program that uses the same connection."""

import json
import logging
from urllib.parse import urlsplit

from websockets.sync.client import ClientConnection, connect

import tool0


def drive(socket: ClientConnection) -> None:
    """Steer the elbow like a slider does, and close the gripper halfway."""
    hello = json.loads(socket.recv())
    print(f"connected to tool0 {hello['version']}")

    # A request has an id.  The reply has the same id, and an error if the request
    # failed.
    grip = {"id": 1, "method": "grip", "params": {"opening": 0.04, "force": 60.0}}
    socket.send(json.dumps(grip))
    # A setpoint of a stream has no id.  Only the newest setpoint is executed.
    params = {
        "controller": "eff_joint_traj_controller",
        "positions": {"elbow_joint": 1.4},
        "speed": 1.0,
    }
    socket.send(json.dumps({"method": "steer_joints", "params": params}))
    # Subscribe to the view, which the page shows.
    socket.send(json.dumps({"id": 2, "method": "subscribe_view"}))

    joints: list[str] = []
    for text in socket:
        message = json.loads(text)
        if message["type"] == "reply":
            print("refused" if "error" in message else "accepted", message["id"])
        if message["type"] == "view":
            joints = [joint["name"] for joint in message["robot"]["joints"]]
        if message["type"] == "state":
            position = dict(zip(joints, message["position"], strict=True))
            if abs(position["elbow_joint"] - 1.4) < 0.01:
                print(f"t = {message['time']:.2f} s: the elbow is there")
                return


logging.disable(logging.WARNING)  # late ticks do not matter here
with tool0.bringup() as robot, tool0.Panel(robot) as panel:
    print(f"open {panel.url} in a browser to watch")  # for a few seconds
    address = urlsplit(panel.url)
    with connect(f"ws://{address.netloc}/ws?{address.query}") as socket:
        drive(socket)
