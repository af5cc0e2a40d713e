"""Selection of the robot, or the cell of robots, to simulate.

These options are declared only in ``DescriptionConfig``.  ``tool0.bringup``, the
command line and ``ur_robotiq.urdf.xacro`` all accept the fields of this class.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from enum import Enum
from pathlib import Path
from typing import Final, Literal, final

from tool0.description.scene import Scene
from tool0.description.units import Metres, Radians, require_plausible_angles
from tool0.errors import ConfigError, SourceLocation

Argument = str | bool | int | float | Path | Sequence[float] | None
"""Value of a xacro argument; None leaves the argument at its default."""
File = Path | str


class Unset(Enum):
    """Type of ``UNSET``."""

    UNSET = "unset"

    def __str__(self) -> str:
        return self.value


SPAWN_Z: Final = 0.1
"""Default height of a robot's root above the ground [m].  At this height, which
ur_gazebo also uses, the outstretched arm does not touch the ground."""
UNSET: Final = Unset.UNSET
"""Placeholder for a value that was not given, for fields in which None has another
meaning."""

_OF_SEVERAL: Final = ("robot", "cell", "robots")
"""The options that select robots other than by an arm and a gripper."""
_NOT_XACRO: Final = (*_OF_SEVERAL, "namespaces", "args", "relax_inertia", "srdf")
"""The fields that are not arguments of the xacro file."""
_OF_EACH: Final = ("ros2_control",)
"""The options that also apply to each robot of a cell, and to your own file."""
_OF_ALL: Final = ("prefix", "tf_prefix", "srdf", *_OF_SEVERAL)
"""The options that cannot be set for a single robot of a cell."""
_ROBOT_NAME: Final = re.compile(r"[A-Za-z](\w*[A-Za-z0-9])?", re.ASCII)


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class DescriptionConfig:
    """The robot: an arm and a gripper from the catalogue, a cell, or your own file.

    Each field except ``robot``, ``cell``, ``robots``, ``namespaces``, ``args``,
    ``relax_inertia`` and ``srdf`` is the argument of the same name in
    ``tool0_description/urdf/ur_robotiq.urdf.xacro``.
    A field that is not given (None) leaves the argument at its default.  Relative paths
    are relative to the working directory.

    Raises:
        ConfigError: If two of ``robot``, ``cell`` and ``robots`` are given, if one of
            them is given together with a field that applies only to robots from the
            catalogue, or if ``namespaces`` is given without a cell.
    """

    arm: str | None = None
    """Name of the arm, such as ur10e, or a folder with your own arm.  The default is
    ur5."""
    gripper: str | Unset | None = UNSET
    """Name of the gripper, a folder with your own gripper, or none.  The default is
    2f85."""
    gripper_model: Literal["mimic", "linkage"] | None = None
    """mimic (the default): the fingers follow the drive; linkage: five-bar fingers
    that wrap around an object (MuJoCo only)."""
    prefix: str | None = None
    """Prefix of all link and joint names, such as `left_`."""
    robot: File | None = None
    """Your own URDF or xacro file, instead of an arm and a gripper."""
    cell: Cell | File | None = None
    """YAML file with several robots and a scene (docs/how-to/cells.md)."""
    robots: Sequence[str] | None = None
    """Several robots without a file, such as left=ur5+2f85@0,0.4,0 right=ur5@0,-0.4,0.
    Each entry contains the name, the arm, the gripper (optional), the position of the
    base [m] and, optionally, roll, pitch and yaw [rad]."""
    namespaces: bool = False
    """Give each robot of a cell a separate namespace and controller manager in ROS.
    `namespaces: true` in the cell's file has the same effect."""
    args: Mapping[str, Argument] | None = None
    """Arguments for the xacro file; they override the other options."""
    relax_inertia: bool = False
    """If your own file contains physically impossible inertias, replace them and print
    a warning, instead of rejecting the robot."""
    srdf: File | None = None
    """SRDF file.  Planned motions ignore collisions between pairs of links that are
    listed in the file's `<disable_collisions>` elements."""
    mount_xyz: Sequence[Metres] | None = None
    """Position of the gripper in the frame `tool0` [m]."""
    mount_rpy: Sequence[Radians] | None = None
    """Orientation of the gripper in the frame `tool0`: roll, pitch, yaw [rad]."""
    base_xyz: Sequence[Metres] | None = None
    """Position of the arm in the world [m]."""
    base_rpy: Sequence[Radians] | None = None
    """Orientation of the arm in the world: roll, pitch, yaw [rad]."""
    pedestal_height: Metres | None = None
    """Height of the pedestal below the arm's base [m]; 0 means no pedestal.  If the
    height is not given, the pedestal of an upright arm reaches the ground."""
    meshes: Literal["tool0", "upstream"] | None = None
    """tool0 (the default): the built-in meshes; upstream: the meshes of ur_description
    and robotiq_2f_85_gripper_visualization."""
    joint_limit_params: File | None = None
    """YAML file with the arm's joint limits, in the format of ur_description."""
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
    ros2_control: bool = False
    """For ROS 2, describe the drives with `<ros2_control>` tags instead of
    `<transmission>` tags.  Your own file declares which joints are driven; if your file
    declares no driven joint, all joints are driven."""
    safety_limits: bool = False
    """Add soft limits to the arm's joints."""
    safety_pos_margin: Radians | None = None
    """Distance of the soft limits from the hard limits [rad]."""
    safety_k_position: float | None = None
    """Position gain of the soft limits [1/s]."""
    tf_prefix: str | None = None
    """Prefix of all frame names in ROS.  The names in the robot's description do not
    change."""

    def __post_init__(self) -> None:
        for name in ("base_rpy", "mount_rpy"):
            require_plausible_angles(getattr(self, name), name)
        given = [name for name in self._given() if name not in _OF_EACH]
        if self.ros2_control and self.transmission_hw_interface is not None:
            raise ConfigError(
                "transmission_hw_interface: not with ros2_control, which offers "
                "position and velocity interfaces"
            )
        several = [name for name in _OF_SEVERAL if getattr(self, name) is not None]
        if len(several) > 1:
            raise ConfigError(f"give only one of {', '.join(several)}")
        if self.namespaces and self.cell is None and self.robots is None:
            raise ConfigError(
                "namespaces: only for several robots; give cell or robots, too"
            )
        if self.relax_inertia and self.robot is None:
            raise ConfigError("relax_inertia: only for a robot file of your own")
        if self.robot is not None and given:
            raise ConfigError(
                f"{', '.join(given)}: only for robots of the catalogue; '{self.robot}' "
                "takes the arguments that it declares with <xacro:arg>, through args"
            )
        if several and several != ["robot"] and (given or self.args):
            names = ", ".join((*given, *(["args"] if self.args else [])))
            raise ConfigError(
                f"{names}: only for a single robot; give them for each robot of the "
                "cell, in its file"
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
            if is_given and item.name not in _NOT_XACRO:
                given[item.name] = value
        return given


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class CellRobot:
    """Settings of one robot of a cell."""

    name: str
    """Name of the robot, such as ``left``.  The names of this robot's links, joints and
    controllers then start with ``left_``."""
    description: DescriptionConfig
    """Options of this robot, such as its arm, gripper, base and mount."""
    initial_pose: str | Mapping[str, float] | None = None
    """Start pose: the name of a pose, or the positions of joints by name without the
    prefix [rad | m].  The default is the pose ``home``."""
    controllers_file: File | None = None
    """ros_control YAML file that replaces the built-in controllers.  The file is
    written for a single robot: the robot's prefix is added to the names of joints and
    controllers."""
    location: SourceLocation | None = None
    """Source location of the robot's entry, for error messages."""

    def __post_init__(self) -> None:
        if not _ROBOT_NAME.fullmatch(self.name):
            raise ConfigError(
                f"'{self.name}' cannot name a robot; use letters, digits and '_', a "
                "letter first and no '_' at the end, such as left",
                self.location,
            )
        for option in _OF_ALL:
            if getattr(self.description, option) is not None:
                raise ConfigError(
                    f"robot '{self.name}' of a cell cannot have '{option}'",
                    self.location,
                )

    @property
    def prefix(self) -> str:
        """Prefix of the names of the robot's links, joints and controllers."""
        return f"{self.name}_"


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """Several robots in one world, and the objects around them.

    Raises:
        ConfigError: If the cell has no robot, or if two robots have the same name.
    """

    name: str = ""
    """Name of the whole model.  An empty name is replaced by a name that is composed of
    the robots' names."""
    robots: tuple[CellRobot, ...]
    """Robots of the cell, in the order of their joints."""
    scene: Scene | File | None = None
    """The objects around the robots; ``SimulationConfig.scene`` replaces them."""
    namespaces: bool = False
    """Whether each robot has a separate namespace and controller manager in ROS."""
    location: SourceLocation | None = None
    """Location of the cell's file, for error messages."""

    def __post_init__(self) -> None:
        if not self.robots:
            raise ConfigError(
                "the cell has no robot; give it at least one under 'robots'",
                self.location,
            )
        names: set[str] = set()
        for robot in self.robots:
            if robot.name in names:
                raise ConfigError(
                    f"two robots are called '{robot.name}'; rename one", robot.location
                )
            names.add(robot.name)
