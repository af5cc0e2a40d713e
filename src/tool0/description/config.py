"""Which robot to simulate.

``DescriptionConfig`` is the only declaration of these options: ``tool0.bringup``, the
command line and ``ur_robotiq.urdf.xacro`` all take its fields.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from enum import Enum
from pathlib import Path
from typing import Final, Literal, final

from tool0.description.units import Metres, Radians
from tool0.errors import ConfigError

Argument = str | bool | int | float | Path | Sequence[float] | None
"""The value of a xacro argument; None leaves the argument at its default."""
File = Path | str


class Unset(Enum):
    """The type of ``UNSET``."""

    UNSET = "unset"

    def __str__(self) -> str:
        return self.value


SPAWN_Z: Final = 0.1
"""Default height of a robot's root above the ground [m], as in ur_gazebo: the
outstretched arm must clear the ground."""
UNSET: Final = Unset.UNSET
"""A value that was not given, where None means something else."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class DescriptionConfig:
    """The robot: an arm and a gripper of the catalogue, or your own file.

    Each field except ``robot`` and ``args`` is the argument of the same name in
    ``tool0_description/urdf/ur_robotiq.urdf.xacro``.  A field that is not given (None)
    leaves the argument at its default.  Relative paths count from the working
    directory.

    Raises:
        ConfigError: If ``robot`` is given together with a field of the catalogue.
    """

    arm: str | None = None
    """The arm; ur5 if not given."""
    gripper: str | Unset | None = UNSET
    """The gripper on the arm's tool0, or none; 2f85 if not given."""
    gripper_model: Literal["mimic", "linkage"] | None = None
    """mimic (the default): the fingers follow the drive; linkage: five-bar fingers
    that wrap around an object (MuJoCo only)."""
    prefix: str | None = None
    """Prefix of all link and joint names, such as `left_`."""
    robot: File | None = None
    """Your own URDF or xacro file, instead of an arm and a gripper."""
    args: Mapping[str, Argument] | None = None
    """Arguments of the xacro file; they override the other options."""
    mount_xyz: Sequence[Metres] | None = None
    """Position of the gripper in tool0 [m]."""
    mount_rpy: Sequence[Radians] | None = None
    """Orientation of the gripper in tool0: roll, pitch, yaw [rad]."""
    base_xyz: Sequence[Metres] | None = None
    """Position of the arm in the world [m]."""
    base_rpy: Sequence[Radians] | None = None
    """Orientation of the arm in the world: roll, pitch, yaw [rad]."""
    pedestal_height: float | None = None
    """Height of the pedestal below the arm's base [m], 0 for none.  If not given, it
    reaches from an upright arm to the ground."""
    meshes: Literal["tool0", "upstream"] | None = None
    """tool0 (the default): the built-in meshes; upstream: those of ur_description and
    robotiq_2f_85_gripper_visualization."""
    joint_limit_params: File | None = None
    """YAML file with the arm's joint limits, as in ur_description."""
    kinematics_params: File | None = None
    """YAML file with the arm's kinematics, such as a calibration."""
    physical_params: File | None = None
    """YAML file with the arm's masses and inertias."""
    visual_params: File | None = None
    """YAML file with the arm's visual and collision shapes."""
    gripper_params: File | None = None
    """YAML file with the gripper's masses and drive."""
    gripper_joint_limit_params: File | None = None
    """YAML file with the gripper's joint limits."""
    gripper_visual_params: File | None = None
    """YAML file with the gripper's visual and collision shapes."""
    transmission_hw_interface: str | None = None
    """Command interface of all joints, such as
    hardware_interface/EffortJointInterface."""
    safety_limits: bool = False
    """Add soft limits to the arm's joints."""
    safety_pos_margin: Radians | None = None
    """Distance of the soft limits from the hard limits [rad]."""
    safety_k_position: float | None = None
    """Position gain of the soft limits [1/s]."""
    tf_prefix: str | None = None
    """Prefix of the frames in ROS; the robot itself does not change."""

    def __post_init__(self) -> None:
        given = self._given()
        if self.robot is not None and given:
            raise ConfigError(
                f"{', '.join(given)}: only for robots of the catalogue; '{self.robot}' "
                "takes the arguments that it declares with <xacro:arg>, through args"
            )

    def xacro_arguments(self) -> dict[str, Argument]:
        """Return the given arguments of ``ur_robotiq.urdf.xacro`` by name."""
        return {**self._given(), **(self.args or {})}

    def _given(self) -> dict[str, Argument]:
        given: dict[str, Argument] = {}
        for item in fields(self):
            value = getattr(self, item.name)
            if item.name == "gripper" and value is None:
                value = "none"
            is_given = value is not None and value is not UNSET and value is not False
            if is_given and item.name not in ("robot", "args"):
                given[item.name] = value
        return given
