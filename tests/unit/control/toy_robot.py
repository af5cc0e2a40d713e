"""Three unit masses on rails, and hardware that hands commands to them."""

from __future__ import annotations

from collections.abc import Sequence

from tool0.control.config import ControllerConfig
from tool0.control.manager import ControllerManager, Strictness
from tool0.description.model import Interface, Joint, JointLimits, JointType
from tool0.hardware.engine import JointState

DT = 0.001


def make_joint(name: str, kind: JointType = JointType.REVOLUTE) -> Joint:
    return Joint(
        name=name,
        type=kind,
        parent="x",
        child="y",
        limits=JointLimits(lower=-6.0, upper=6.0, velocity=3.0, effort=50.0),
    )


JOINTS = {
    "idle": make_joint("idle"),
    "hip": make_joint("hip"),
    "slide": make_joint("slide", JointType.PRISMATIC),
    "wheel": make_joint("wheel", JointType.CONTINUOUS),
}
"""``idle`` has no transmission."""


class ToyHardware:
    def __init__(self, interface: Interface, gripper_delay: float = 0.0) -> None:
        self.joint_names = tuple(JOINTS)
        self.index = {name: i for i, name in enumerate(JOINTS)}
        self.interfaces = {name: (interface,) for name in JOINTS if name != "idle"}
        self.command = [0.0] * len(JOINTS)
        self.claimed: list[str] = []
        self.speed_scaling = {"": 1.0}
        self.gripper_delay = gripper_delay

    def claim(
        self, joints: Sequence[str], interface: Interface, state: JointState
    ) -> None:
        self.claimed += joints

    def release(self, joints: Sequence[str], state: JointState) -> None:
        for name in joints:
            self.claimed.remove(name)


class ToyRobot:
    """A loop: update, step.  ``blocked`` joints do not move."""

    def __init__(
        self,
        yaml: str,
        interface: Interface = Interface.EFFORT,
        gripper_delay: float = 0.0,
    ) -> None:
        self.hardware = ToyHardware(interface, gripper_delay)
        self.manager = ControllerManager(
            self.hardware, ControllerConfig.from_text(yaml), JOINTS
        )
        self.ticks = 0
        self.position = [0.0] * len(JOINTS)
        self.velocity = [0.0] * len(JOINTS)
        self.blocked: set[str] = set()
        self.interface = interface

    @property
    def time(self) -> float:
        return self.ticks * DT

    @property
    def state(self) -> JointState:
        n = len(JOINTS)
        return JointState(
            self.time, list(self.position), list(self.velocity), [0.0] * n
        )

    def start(self, *names: str):
        for name in names:
            self.manager.load(name)
        self.manager.switch(names, [], Strictness.STRICT, self.state)
        return self.manager.running(names[0])

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / DT)):
            self.tick()

    def tick(self) -> None:
        self.manager.update(self.state, DT)
        for i, name in enumerate(JOINTS):
            command = self.hardware.command[i]
            if name in self.blocked:
                self.velocity[i] = 0.0
            elif self.interface is Interface.POSITION:
                self.velocity[i] = (command - self.position[i]) / DT
                self.position[i] = command
            else:
                if self.interface is Interface.EFFORT:
                    self.velocity[i] += command * DT
                else:
                    self.velocity[i] = command
                self.position[i] += self.velocity[i] * DT
        self.ticks += 1


GAINS = "{p: 4000, d: 126, i: 10, i_clamp: 1}"
ARM = f"""
arm:
  type: effort_controllers/JointTrajectoryController
  joints: [hip, slide, wheel]
  gains: {{hip: {GAINS}, slide: {GAINS}, wheel: {GAINS}}}
  constraints:
    goal_time: 0.5
    stopped_velocity_tolerance: 0.05
    hip: {{trajectory: 0.1, goal: 0.01}}
    slide: {{trajectory: 0.1, goal: 0.01}}
    wheel: {{trajectory: 0.1, goal: 0.01}}
  stop_trajectory_duration: 0.5
"""
POSITION_ARM = """
arm:
  type: position_controllers/JointTrajectoryController
  joints: [hip, slide, wheel]
  allow_partial_joints_goal: true
  constraints:
    hip: {trajectory: 0.1, goal: 0.01}
"""
