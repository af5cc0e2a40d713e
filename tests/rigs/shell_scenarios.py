"""What the readers of the guides and of the reference have, and what no test runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from document import blocks

ROOT = Path(__file__).parents[2]


@dataclass(frozen=True)
class Scenario:
    """How a page is followed; one that is not in ``SCENARIOS`` needs nothing."""

    before: tuple[str, ...] = ()
    """Commands that the reader has typed before."""
    during: Mapping[int, str] = field(default_factory=dict)
    """Number of a block of commands → the bring-up that it takes for granted."""
    files: Mapping[str, str] = field(default_factory=dict)
    instead: Mapping[str, str] = field(default_factory=dict)
    """What the page says → what is run, such as fewer episodes."""
    speed: int = 4
    """Of bring-ups that other commands use, in simulated seconds per second."""
    fails: tuple[str, ...] = ()
    """Commands that end with a status other than 0."""


def saved(page: str, title: str) -> str:
    """Return a file that the reader has saved from another page."""
    found = blocks(ROOT / "docs" / page)
    (text,) = (block.text for block in found if block.title == title)
    return text


_LEROBOT = "it needs LeRobot's environment; tests/with_lerobot run its programs there"
_CUDA = "it measures on a GPU, or tests one"
_NOETIC = "it needs Noetic, or RoboStack"
_PIP = "it makes the environment that runs this test"
_ELSEWHERE = "it installs, or removes, what other tests use"
_REAL_ROBOT = "a late link ends the motions of a real robot: its tests run alone"
_DEMOS = "it takes long; tests/unit/cli/test_demo_command.py runs it"
_MOVEIT = "it takes long; tests of the workspace write the packages of all robots"
_MACHINE = "it names another machine"

NOT_RUN: dict[str, str] = {
    "pip ": _PIP,
    "make ": _PIP,
    "git pull": _PIP,
    "source .venv/bin/activate": _PIP,
    "tool0 gazebo install": _ELSEWHERE,
    "tool0 gazebo uninstall": _ELSEWHERE,
    "tool0 ros2 install": _ELSEWHERE,
    "tool0 ros2 uninstall": _ELSEWHERE,
    "sudo apt-get install ": _ELSEWHERE,
    "source /opt/ros/noetic/setup.bash": _NOETIC,
    "python3.11 -m venv .venv": _NOETIC,
    ".venv/bin/tool0 ros1 status": _NOETIC,
    "mamba ": _NOETIC,
    "export ROS_MASTER_URI=http://robotics-pc:11311": _MACHINE,
    "export ROS_IP=192.168.1.20": _MACHINE,
    "rviz": "it opens a window; tests/ros1 have one on a screen of their own",
    "ros2 ": "PyPI's wheels have no `ros2`; tests/ros2 call what it calls",
    "tool0 bringup --ros2 --robot ur_description/": "it needs UR's package",
    "tool0 bringup --engine gazebo --gazebo-gui": "it opens Gazebo's window",
    "tool0 move --joints elbow_joint=1.4": _REAL_ROBOT,
    "tool0 hardware speed 50": _REAL_ROBOT,
    "tool0 hardware disable": _REAL_ROBOT,
    "tool0 bringup --ros1 --engine gazebo": "tests/ros1 bring it up",
    "tool0 demo pick --engine gazebo": "tests/gazebo pick the cube",
    "tool0 demo pick --arm ur20 --gripper 2f140": "tests/conformance pick with it",
    "tool0 demo pick --headless --n 20": "tests/unit/cli pick with these options",
    "tool0 demo handover": _DEMOS,
    "tool0 demo shelf": _DEMOS,
    "tool0 workspace ~/catkin_ur10e --moveit": _MOVEIT,
    "tool0 workspace ~/catkin_cell --moveit": _MOVEIT,
    "tool0 bringup --ros1 --roscore": "tests/ros1 bring it up",
    "tool0 collect --task Lift --episodes 10000 --ray 10.0.0.1:6379": (
        "it needs a cluster; tests/unit/collect have a Ray of their own"
    ),
    "tool0 policy run ws://": "it needs openpi; tests/unit/policy have such a server",
    "tool0 policy run lerobot:": _LEROBOT,
    "lerobot-": _LEROBOT,
    "python3.12 -m venv lerobot": _LEROBOT,
    "tool0 bringup --name tool0 &": _LEROBOT,
    "tool0 bringup --name leader &": _LEROBOT,
    "python benchmarks/gpu.py": _CUDA,
    "TOOL0_TEST_DEVICE=cuda ": _CUDA,
}
"""How a command begins → why no test of a page runs it."""

SEND = """
import socket, sys
with socket.create_connection((sys.argv[1], int(sys.argv[2]))) as peer:
    peer.sendall(sys.stdin.buffer.read())
    while sys.argv[2] == "29999" and (data := peer.recv(1000)):
        sys.stdout.write(data.decode())
"""
"""Stands in for nc, which not every machine has."""
DEMONSTRATE = """
import subprocess, tool0
words = ["tool0", "record", "--episodes", "lift", "--task", "lift the cube"]
with subprocess.Popen(words, stdin=subprocess.PIPE, bufsize=0) as recorder:
    recorder.stdin.write(b" ")
    with tool0.connect() as robot:
        while not ((status := robot.episodes.status) and status.is_recording):
            robot.run(0.02)
        robot.gripper.move(opening=0.02).wait()
    recorder.stdin.write(b"yq")
"""
"""Presses the reader's keys."""
WORLD = """<sdf version="1.6"><world name="default">
<include><uri>model://ground_plane</uri></include></world></sdf>"""
MISPLACED = (
    "# a comment\n" * 36
    + """gripper_controller:
  type: effort_controllers/JointTrajectoryController
  joints: [finger_joint]
  gains: {finger_joint: {p: 20, d: 1}}
  goal_tolerance: 0.01
"""
)
MY_CELL = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="cell">
  <xacro:arg name="side" default="right"/>
  <xacro:include filename="$(find tool0_description)/urdf/ur_macro.xacro"/>
  <link name="world"/>
  <xacro:ur_arm prefix="" parent="world"
      transmission_hw_interface="hardware_interface/EffortJointInterface">
    <origin xyz="0 ${0.4 if '$(arg side)' == 'left' else -0.4} 0" rpy="0 0 0"/>
  </xacro:ur_arm>
</robot>"""
UR_BOX = "tool0 bringup --ur --arm ur5e --ur-active-gripper --dt 0.002 --name robot"
CELL = "--robots left=ur5e+2f85@0,0.4,0 right=ur10e+hande@0,-0.4,0"

SCENARIOS: dict[str, Scenario] = {
    "cameras": Scenario(during={0: "tool0 bringup --scene table_and_cubes"}, speed=1),
    "cells": Scenario(during={1: f"tool0 bringup {CELL}"}),
    "check": Scenario(
        files={"src/robot/config/ur5_controllers.yaml": MISPLACED},
        fails=("tool0 check src --strict",),
    ),
    "cli": Scenario(
        during={0: "tool0 bringup"},
        before=(
            "mkdir -p ~/.local/share/bash-completion/completions ~/.zfunc",
            "tool0 describe controllers --gripper none --output built_in.yaml",
            "sed 's/eff_joint_traj_con/arm_con/; s/joint_group_eff_con/spare_con/' "
            "built_in.yaml > my_controllers.yaml",
        ),
        files={"my_cell.urdf.xacro": MY_CELL},
    ),
    "collect": Scenario(
        instead={
            "--episodes 10000": "--episodes 1",
            "--episodes 500": "--episodes 1",
            "--workers 8": "--workers 1",
            "image_size=160,120": "image_size=16,12 max_episode_steps=5",
        }
    ),
    "gazebo": Scenario(files={"my.world": WORLD}),
    "grasping": Scenario(instead={"--n 20": "--n 1", " --video pick.mp4": ""}),
    "hardware": Scenario(
        during=dict.fromkeys((0, 1), UR_BOX),
        instead={
            "192.168.1.10": "127.0.0.1",
            "tool0 hardware enable": "tool0 hardware enable --serial "
            "$(tool0 hardware show | grep -o '[0-9]\\{11\\}')",
        },
    ),
    "own-robot": Scenario(files={"my_cell.urdf.xacro": MY_CELL}),
    "planning": Scenario(
        fails=("tool0 move --pose 0.48 -0.34 0.35 180deg 0 0 --check",)
    ),
    "policies": Scenario(
        during={0: "tool0 bringup"},
        files={"my_policy.py": saved("how-to/collect.md", "my_policy.py")},
        instead={
            "--episodes 100": "--episodes 2 --env max_episode_steps=20",
            "--episodes 200": "--episodes 1",
            "--duration 20": "--duration 0.2",
        },
    ),
    "programs": Scenario(
        instead={"tool0 run pick  ": "tool0 reset && tool0 run pick  "},
    ),
    "recordings": Scenario(
        speed=1,  # what is recorded is simulated and drawn again
        during={1: "tool0 bringup --name plain"},
        files={"demonstrate.py": DEMONSTRATE},
        instead={
            "later.mcap": "later.mcap --name plain",
            "--format mp4": "--format mp4 --end 0.4 --fps 10 --width 64 --height 48",
            "close.mp4": "close.mp4 --end 0.2 --fps 5 --width 64 --height 48",
            "--rate 25": "--rate 5",
            "320 --height 240": "64 --height 48",
            'tool0 record --episodes lift --task "lift the cube"': (
                "python demonstrate.py"
            ),
        },
    ),
    "ros1": Scenario(
        during={
            1: "tool0 bringup --ros1",
            10: "tool0 bringup --ros1",
            11: "tool0 bringup --ros1",
        },
        instead={
            "tool0 ros1 install ": "tool0 ros1 install --dry-run ",
            "rostopic echo /": "rostopic echo -n1 /",
        },
    ),
    "tuning": Scenario(during={2: "tool0 bringup"}),
    "ur": Scenario(
        files={"send.py": SEND},
        instead={"nc -q 1": "python send.py", "nc 127": "python send.py 127"},
    ),
}
