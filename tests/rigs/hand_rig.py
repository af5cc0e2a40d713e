"""A gripper on a wall in MuJoCo, driven at its motor, without arm and controllers.

The 2F-85 hangs at the root's origin.  Lengths are [m], forces [N].
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import final

import mujoco
import numpy as np
from numpy.typing import NDArray

from tool0.description.bodies import JointDynamics
from tool0.description.loading import load_robot
from tool0.description.model import RobotModel
from tool0.description.scene import Scene, SceneObject
from tool0.engines.mujoco.engine import MujocoEngine

Vector = NDArray[np.float64]

XACRO = """<robot name="hand" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:arg name="gripper_model" default="mimic"/>
<xacro:arg name="rpy" default="0 0 0"/>
<xacro:include filename="$(find tool0_description)/config/grippers/2f85/macro.xacro"/>
<link name="wall"/>
<xacro:tool0_gripper prefix="" parent="wall" gripper_model="$(arg gripper_model)"
    folder="$(find tool0_description)/config/grippers/2f85">
  <origin xyz="0 0 0" rpy="$(arg rpy)"/>
</xacro:tool0_gripper>
</robot>"""

UP, DOWN, LEVEL, ON_ITS_SIDE = "0 0 0", f"{math.pi} 0 0", "1.5708 0 0", "0 1.5708 0"
"""How the hand points, as roll, pitch, yaw."""
SIDES = ("left", "right")


def hand_model(folder: Path, gripper_model: str, rpy: str = UP) -> RobotModel:
    path = folder / "hand.xacro"
    path.write_text(XACRO)
    return load_robot(path, {"gripper_model": gripper_model, "rpy": rpy}).model


@final
class Hand:
    """The engine with a motor that keeps to a position, or to a speed and a force."""

    def __init__(self, model: RobotModel, *objects: SceneObject) -> None:
        self.engine = MujocoEngine(model, ground=None, scene=Scene(objects))
        self.geometry = model.grippers[0]
        self._dynamics = JointDynamics(model)
        self._driven = self.engine.joint_names.index("finger_joint")
        self.engine.reset([0.0] * len(self.engine.joint_names))
        self.state = self.engine.read()

    @property
    def angle(self) -> float:
        """Of the driven joint [rad]."""
        return self.state.position[self._driven]

    def joint(self, name: str) -> float:
        return self.state.position[self.engine.joint_names.index(name)]

    def drive(self, torque: float) -> None:
        """Let one step pass; the drive carries the fingers' weight by itself."""
        effort = [0.0] * len(self.state.position)
        effort[self._driven] = (
            torque + self._dynamics.static_effort(self.state.position)[self._driven]
        )
        self.engine.write(effort)
        self.engine.step()
        self.state = self.engine.read()

    def hold(self, angle: float, rate: float = 0.0) -> None:
        """Let one step pass at ``angle`` [rad], moving at ``rate`` [rad/s]."""
        lag = rate - self.state.velocity[self._driven]
        self.drive(60.0 * (angle - self.angle) + 1.5 * lag)

    def squeeze(self, force: float, duration: float, speed: float = 0.1) -> None:
        """Close at ``speed`` [m/s], with no more than ``force`` at each pad."""
        for _ in range(round(duration / self.engine.dt)):
            lever = self.geometry.lever(self.angle)
            slow = self.state.velocity[self._driven] < speed / lever
            self.drive(force * lever if slow else 0.0)

    def pad(self, side: str) -> tuple[Vector, Vector]:
        """Return the middle of a pad's face, and its normal, away from the finger."""
        geom = self.engine.data.geom(f"{side}_inner_finger_pad/collision0")
        size = self.engine.model.geom(geom.id).size
        normal = -geom.xmat.reshape(3, 3)[:, 1]
        return geom.xpos + size[1] * normal, normal

    def tip(self, side: str) -> Vector:
        """Return the end of a pad's face."""
        middle, _ = self.pad(side)
        geom = self.engine.data.geom(f"{side}_inner_finger_pad/collision0")
        size = self.engine.model.geom(geom.id).size
        end: Vector = middle + size[2] * geom.xmat.reshape(3, 3)[:, 2]
        return end

    def opening(self) -> float:
        """Return the distance between the faces of the pads, as they are."""
        (left, normal), (right, _) = self.pad("left"), self.pad("right")
        return float((right - left) @ normal)

    def skew(self) -> float:
        """Return the angle between the faces of the pads [deg]."""
        (_, one), (_, other) = self.pad("left"), self.pad("right")
        return math.degrees(
            math.asin(min(1.0, float(np.linalg.norm(np.cross(one, other)))))
        )

    def press(self, side: str, name: str) -> float:
        """Return how hard a pad presses on an object, along its normal."""
        _, normal = self.pad(side)
        total = 0.0
        for contact in self.engine.world.contacts():
            if {contact.first, contact.second} == {f"{side}_inner_finger_pad", name}:
                total += abs(float(np.array(contact.force) @ normal))
        return total

    def place(self, name: str) -> Vector:
        """Return where an object is."""
        (found,) = (s for s in self.engine.world.object_states() if s.name == name)
        return np.array(found.position)

    def gap(self, loop: str) -> float:
        """Return how far apart the two ends of a loop are."""
        data, equality = self.engine.data, self.engine.model.equality(loop)
        assert int(equality.type[0]) == mujoco.mjtEq.mjEQ_CONNECT
        ends = data.site_xpos[[int(equality.obj1id[0]), int(equality.obj2id[0])]]
        return float(np.linalg.norm(ends[1] - ends[0]))
