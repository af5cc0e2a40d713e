"""The panel: the robot in a web page, and a program that drives it as the page does."""

import json
import logging
from urllib.parse import urlsplit

from websockets.sync.client import ClientConnection, connect

import tool0
from tool0.interfaces.panel.server import Panel


def elbow_of(hello: dict, frame: dict) -> float:
    """Return where the elbow is [rad]: arrays are in the order of the joints."""
    joints = [joint["name"] for joint in hello["robot"]["joints"]]
    return frame["position"][joints.index("elbow_joint")]


def drive(socket: ClientConnection) -> None:
    """Steer the elbow as a slider would, and close the gripper half."""
    hello = json.loads(socket.recv())
    print(f"connected to tool0 {hello['version']}, {hello['robot']['title']}")

    # A stream: send it as often as you like, the newest counts.
    steer = {
        "type": "steer",
        "controller": "eff_joint_traj_controller",
        "positions": {"elbow_joint": 1.4},
        "speed": 1.0,
    }
    socket.send(json.dumps(steer))
    # A request: its answer has the same id, and says what was wrong if anything was.
    gripper = hello["robot"]["grippers"][0]["name"]
    grip = {"type": "grip", "id": 1, "gripper": gripper, "opening": 0.04, "force": 60.0}
    socket.send(json.dumps(grip))

    for text in socket:
        message = json.loads(text)
        if message["type"] == "reply":
            print("refused" if "error" in message else "accepted")
        if message["type"] == "frame" and abs(elbow_of(hello, message) - 1.4) < 0.01:
            print(f"t = {message['time']:.2f} s: the elbow is there")
            return


logging.disable(logging.WARNING)  # a tick that began late is no news here
with tool0.bringup() as robot, Panel(robot) as panel:
    print(f"open {panel.url} in a browser to watch")  # here the program ends too soon
    address = urlsplit(panel.url)
    with connect(f"ws://{address.netloc}/ws?{address.query}") as socket:
        drive(socket)
