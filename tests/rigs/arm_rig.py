"""Arms to solve for: ours, calibrated ones, and a URDF as ur_description once had."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tool0.description.loading import assemble, load_robot
from tool0.description.model import RobotModel
from tool0.kinematics.chain import ArmChain, find_chains

JOINTS = ("shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3")
QUARTER = np.pi / 2
NOMINAL = {
    "shoulder": (0, 0, 0.089159, 0, 0, 0),
    "upper_arm": (0, 0, 0, QUARTER, 0, 0),
    "forearm": (-0.425, 0, 0, 0, 0, 0),
    "wrist_1": (-0.39225, 0, 0.10915, 0, 0, 0),
    "wrist_2": (0, -0.09465, 0, QUARTER, 0, 0),
    "wrist_3": (0, 0.0823, 0, -QUARTER, 0, 0),
}
"""The UR5's, in the layout of kinematics_params."""

# Lengths and axes of a UR5 as in https://github.com/ros-industrial/universal_robot at
# its release for ROS Kinetic (urdf/ur5.urdf.xacro), without our own elements.
_OLD = """<robot name="mine"><link name="pedestal"/>
<joint name="up" type="fixed"><parent link="pedestal"/><child link="base_link"/>
  <origin xyz="0.1 -0.2 0.7" rpy="0 0 0.6"/></joint>
<link name="base_link"/>{joints}
<link name="tool0"/>
<joint name="flange" type="fixed"><parent link="l6"/><child link="tool0"/>
  <origin xyz="0 0.0823 0" rpy="-1.5707963267948966 0 0"/></joint></robot>"""
_SOLID = (
    '<inertial><mass value="2"/><inertia ixx="0.01" iyy="0.01" izz="0.01" '
    'ixy="0" ixz="0" iyz="0"/></inertial>'
)
_OLD_JOINTS = (
    ("0 0 0.089159", 0.0, "0 0 1"),
    ("0 0.13585 0", QUARTER, "0 1 0"),
    ("0 -0.1197 0.425", 0.0, "0 1 0"),
    ("0 0 0.39225", QUARTER, "0 1 0"),
    ("0 0.093 0", 0.0, "0 0 1"),
    ("0 0 0.09465", 0.0, "0 1 0"),
)


def ur5(**options: object) -> ArmChain:
    return only_chain(assemble("ur5", gripper=None, **options).model)  # type: ignore[arg-type]


def only_chain(model: RobotModel) -> ArmChain:
    (chain,) = find_chains(model).values()
    return chain


def calibration(folder: Path, seed: int = 1) -> Path:
    """Write the kinematics of a robot that was made a little inexactly."""
    rng = np.random.default_rng(seed)
    rows = []
    for name in JOINTS:
        error = np.concatenate([rng.normal(0, 5e-4, 3), rng.normal(0, 2e-3, 3)])
        values = np.array(NOMINAL[name]) + error
        keys = ("x", "y", "z", "roll", "pitch", "yaw")
        text = ", ".join(
            f"{key}: {value!r}"
            for key, value in zip(keys, values.tolist(), strict=True)
        )
        rows.append(f"  {name}: {{{text}}}")
    path = folder / "calibration.yaml"
    path.write_text("kinematics:\n" + "\n".join(rows) + "\n")
    return path


def old_urdf(
    folder: Path, *, kind: str = "revolute", elbow: str = "0 1 0", lower: str = "-6.3"
) -> Path:
    """Write a UR5 on a pedestal as a URDF of the old layout.

    Args:
        folder: Where to.
        kind: The type of the joints.
        elbow: The elbow's axis.
        lower: The joints' lower limit.
    """
    joints = ""
    for k, (xyz, pitch, axis) in enumerate(_OLD_JOINTS):
        parent = f"l{k}" if k else "base_link"
        turned = elbow if k == 2 else axis
        joints += (
            f'<link name="l{k + 1}">{_SOLID}</link>'
            f'<joint name="j{k + 1}" type="{kind}">'
            f'<parent link="{parent}"/><child link="l{k + 1}"/>'
            f'<origin xyz="{xyz}" rpy="0 {pitch!r} 0"/><axis xyz="{turned}"/>'
            f'<limit lower="{lower}" upper="6.3" velocity="3.14" effort="150"/></joint>'
        )
    path = folder / "mine.urdf"
    path.write_text(_OLD.format(joints=joints))
    return path


def old_model(folder: Path, **options: str) -> RobotModel:
    return load_robot(old_urdf(folder, **options)).model
