"""The numbers that tell one Universal Robots arm from another."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import yaml


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmParameters:
    """Kinematics, and the size of housings and tubes; everything in metres.

    Lengths are positive. The links' frames are those of ``ur_description``.
    """

    name: str
    d1: float
    """Height of the shoulder lift axis above the mounting face."""
    a2: float
    """Shoulder lift axis to elbow axis."""
    a3: float
    """Elbow axis to wrist 1 axis."""
    d4: float
    """Base axis to wrist 2 axis, along the shoulder lift axis."""
    d5: float
    """Wrist 1 axis to wrist 3 axis."""
    d6: float
    """Wrist 2 axis to the tool flange."""
    shoulder_offset: float
    """Base axis to the axis of the upper arm's tube, along the shoulder lift axis."""
    elbow_offset: float
    """Base axis to the axis of the forearm's tube, along the shoulder lift axis."""
    foot_radius: float
    shoulder_radius: float
    elbow_radius: float
    wrist_radius: float
    flange_radius: float
    upper_arm_radius: float
    forearm_radius: float


# Kinematics and offsets: config/<model>/*.yaml of ur_description,
# https://github.com/ros-industrial/universal_robot at a7a2c54. The radii are estimates:
# they shape what a person sees, and the collision primitives, but no mass.
UR3 = ArmParameters(
    name="ur3",
    d1=0.1519,
    a2=0.24365,
    a3=0.21325,
    d4=0.11235,
    d5=0.08535,
    d6=0.0819,
    shoulder_offset=0.1198,
    elbow_offset=0.0275,
    foot_radius=0.064,
    shoulder_radius=0.05,
    elbow_radius=0.044,
    wrist_radius=0.038,
    flange_radius=0.032,
    upper_arm_radius=0.041,
    forearm_radius=0.034,
)
UR5 = ArmParameters(
    name="ur5",
    d1=0.089159,
    a2=0.425,
    a3=0.39225,
    d4=0.10915,
    d5=0.09465,
    d6=0.0823,
    shoulder_offset=0.13585,
    elbow_offset=0.0165,
    foot_radius=0.0745,
    shoulder_radius=0.06,
    elbow_radius=0.055,
    wrist_radius=0.044,
    flange_radius=0.0375,
    upper_arm_radius=0.049,
    forearm_radius=0.04,
)
UR10 = ArmParameters(
    name="ur10",
    d1=0.1273,
    a2=0.612,
    a3=0.5723,
    d4=0.163941,
    d5=0.1157,
    d6=0.0922,
    shoulder_offset=0.220941,
    elbow_offset=0.049042,
    foot_radius=0.095,
    shoulder_radius=0.0745,
    elbow_radius=0.066,
    wrist_radius=0.05,
    flange_radius=0.045,
    upper_arm_radius=0.06,
    forearm_radius=0.047,
)
ARMS = {arm.name: arm for arm in (UR3, UR5, UR10)}


def with_kinematics(arm: ArmParameters, file: Path) -> ArmParameters:
    """Return ``arm`` with the joint origins of a ``default_kinematics.yaml``."""
    joints = yaml.safe_load(file.read_text(encoding="utf-8"))["kinematics"]
    return replace(
        arm,
        d1=float(joints["shoulder"]["z"]),
        a2=-float(joints["forearm"]["x"]),
        a3=-float(joints["wrist_1"]["x"]),
        d4=float(joints["wrist_1"]["z"]),
        d5=-float(joints["wrist_2"]["y"]),
        d6=float(joints["wrist_3"]["y"]),
    )
