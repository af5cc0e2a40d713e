"""What an arm is drawn from: its kinematics, and the sizes in ``appearance.yaml``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any  # any YAML value

import yaml


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmParameters:
    """Kinematics, and the size of housings and tubes; everything in metres.

    Lengths are positive. The links' frames are those of ``ur_description``.
    """

    name: str
    style: str
    """The generation that the arm looks like: a key of ``arm.STYLES``."""
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
    upper_arm_offset: float
    """Base axis to the axis of the upper arm's tube, along the shoulder lift axis."""
    forearm_offset: float
    """Base axis to the axis of the forearm's tube, along the shoulder lift axis."""
    foot_radius: float
    shoulder_radius: float
    elbow_radius: float
    wrist_radius: float
    flange_radius: float
    upper_arm_radius: float
    forearm_radius: float


def read_parameters(folder: Path) -> ArmParameters:
    """Return the parameters in an arm's folder."""
    joints = _read(folder / "default_kinematics.yaml")["kinematics"]
    return ArmParameters(
        name=folder.name,
        d1=float(joints["shoulder"]["z"]),
        a2=-float(joints["forearm"]["x"]),
        a3=-float(joints["wrist_1"]["x"]),
        d4=float(joints["wrist_1"]["z"]),
        d5=-float(joints["wrist_2"]["y"]),
        d6=float(joints["wrist_3"]["y"]),
        **_read(folder / "appearance.yaml")["appearance"],
    )


def _read(file: Path) -> dict[str, dict[str, Any]]:
    mapping: dict[str, dict[str, Any]] = yaml.safe_load(file.read_text("utf-8"))
    return mapping
