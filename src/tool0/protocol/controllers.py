"""Controllers: their status, roles and gains, and the related requests."""

from __future__ import annotations

import enum
import math
import sys
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Final, final

from msgspec import Meta, Struct

from tool0.errors import ConfigError, did_you_mean
from tool0.protocol.request import Name, Request
from tool0.protocol.trajectories import JointsMotion, TrajectoryState


class Role(enum.Enum):
    """Purpose of a controller, which determines the requests that it accepts."""

    TRAJECTORY = "trajectory"
    """Follows trajectories: ``TrajectoryFollower``."""
    GRIPPER = "gripper"
    """Moves one joint and can squeeze an object: ``GripperDriver``."""
    COMMAND = "command"
    """Accepts one command for each joint: ``CommandTaker``."""
    MOTION = "motion"
    """Moves an arm according to requests to the arm: tool0's own controller, and the
    controllers of UR's driver for freedrive and force mode
    (``simulation/handlers/arm_motion.py``)."""
    READER = "reader"
    """Only reads states, without moving any joint."""


KIND_OF: Final = {
    Role.TRAJECTORY: "JointTrajectoryController",
    Role.GRIPPER: "GripperActionController",
    Role.COMMAND: "ForwardCommandController",
}
"""Role → name of the usual controller class, for messages."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class ControllerStatus:
    """Status of a loaded controller, like controller_manager_msgs/ControllerState."""

    name: str
    """Name of the controller in the YAML."""
    type: str
    """Type of the controller in the YAML, such as
    ``effort_controllers/JointTrajectoryController``."""
    role: Role
    """Role of the controller."""
    state: str
    """State of the controller.  ROS 1: ``initialized`` after loading, then ``running``
    or ``stopped``.  ROS 2: ``unconfigured`` after loading, then ``inactive`` or
    ``active``."""
    is_running: bool
    """Whether the controller is running (ROS 1) or active (ROS 2)."""
    claimed: tuple[tuple[str, tuple[str, ...]], ...]
    """Command interfaces, each with the joints that the controller claims while it is
    running."""
    command_interfaces: tuple[str, ...] = ()
    """Required command interfaces, such as ``elbow_joint/position``."""
    state_interfaces: tuple[str, ...] = ()
    """Required state interfaces, with their ROS 2 names."""
    blocked: str = ""
    """Reason why the controller cannot be started: its arm is in a protective stop,
    powered off, or taken by another program, or a real arm has stopped.  Empty if the
    controller can be started."""

    @property
    def joints(self) -> frozenset[str]:
        """The joints that the controller drives while it is running."""
        return frozenset(joint for _, joints in self.claimed for joint in joints)


def why_not_driven(
    statuses: Sequence[ControllerStatus],
    joints: Collection[str],
    roles: Collection[Role] = (Role.TRAJECTORY,),
) -> str:
    """Return why no running controller of these roles drives ``joints``, with a remedy.

    The text is part of the error of a request that needs such a controller.
    """
    able = [status for status in statuses if status.role in roles]
    known = frozenset[str]().union(*(status.joints for status in able))
    names = ", ".join(f"'{joint}'" for joint in joints)
    problem = (
        f"no running {' or '.join(KIND_OF[role] for role in roles)} drives {names}"
    )
    stopped = next((s for s in able if s.joints.issuperset(joints)), None)
    if stopped is None:
        unknown = next((joint for joint in joints if joint not in known), "")
        return problem + (did_you_mean(unknown, known) if unknown else "")
    name = stopped.name
    if stopped.blocked:
        return f"{problem}: {stopped.blocked}"
    for other in statuses:
        if other.is_running and other.joints & stopped.joints:
            return (
                f"{problem}: '{other.name}' is running instead of '{name}'; switch "
                f"with {start_command(name, [other.name])}"
            )
    return (
        f"{problem}: controller '{name}' is {stopped.state}; start it with "
        f"{start_command(name)}"
    )


def start_command(name: str, instead_of: Sequence[str] = ()) -> str:
    """Return the command that starts a loaded controller and stops others."""
    if instead_of:
        return (
            f"`tool0 controllers switch --stop {' '.join(instead_of)} --start {name}` "
            f"or robot.switch(start=['{name}'], stop={list(instead_of)})"
        )
    return f"`tool0 controllers start {name}` or robot.switch(start=['{name}'])"


UNLIMITED: Final = sys.float_info.max
"""Value of a limit that is not set.  It is finite because JSON does not support
infinity."""


class Unwinding(enum.Enum):
    """Method that prevents windup of a PID's integral at a command limit."""

    NONE = 0
    CONDITIONAL_INTEGRATION = 1
    """Errors are not integrated if they would drive the command further beyond its
    limit."""
    BACK_CALCULATION = 2
    """The integral decreases in proportion to the clamped part of the command."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Gains:
    """PID gains of one joint: ``p e + clamp(i ∫e dt) + d de/dt``.

    ``e`` is the position error [rad | m]; the command of an effort controller is an
    effort [N·m | N].  As in control_toolbox, an integral term without a clamp is zero.
    """

    p: float
    """Proportional gain: command per unit of position error [N·m/rad | N/m]."""
    i: float = 0.0
    """Integral gain: command per unit of the position error's time integral
    [N·m/(rad·s) | N/(m·s)]."""
    d: float = 0.0
    """Derivative gain: command per unit of velocity error [N·m·s/rad | N·s/m]."""
    i_min: float = 0.0
    """Lower limit of the integral term, at most 0 [N·m | N]."""
    i_max: float = 0.0
    """Upper limit of the integral term, at least 0 [N·m | N]."""
    antiwindup: bool = False
    """Whether the integral itself is clamped, in addition to the integral term."""
    u_min: float = -UNLIMITED
    """Lower limit of the command, at most 0.  This field and the next four fields exist
    only in ROS 2."""
    u_max: float = UNLIMITED
    """Upper limit of the command, at least 0."""
    error_deadband: float = 0.0
    """Size of the deadband: errors up to this value are not integrated [rad | m]."""
    unwinding: Unwinding = Unwinding.NONE
    """Method that prevents windup of the integral at a command limit."""
    tracking_time: float = 1.0
    """Time constant of BACK_CALCULATION [s]; with a shorter time, the integral
    decreases faster."""

    def __post_init__(self) -> None:
        if not all(map(math.isfinite, (self.p, self.i, self.d))):
            raise ConfigError(f"gains must be finite numbers, got {self}")
        if not self.i_min <= 0.0 <= self.i_max:
            raise ConfigError(f"need i_min <= 0 <= i_max, got {self}")
        if not self.u_min <= 0.0 <= self.u_max:
            raise ConfigError(f"need u_min <= 0 <= u_max, got {self}")
        if not (self.error_deadband >= 0.0 and self.tracking_time > 0.0):
            raise ConfigError(
                f"need error_deadband >= 0 and tracking_time > 0, got {self}"
            )


Names = Annotated[tuple[Name, ...], Meta(max_length=100)]


class ListControllers(Request[tuple[ControllerStatus, ...]], frozen=True):
    """List the loaded controllers with their states and claimed joints."""


class LoadController(Request[None], frozen=True):
    """Load a controller from the bring-up's configuration or from files (ROS 2)."""

    name: Name
    type: Name | None = None
    """Type of the controller, required if the files do not contain it; it corresponds
    to the controller manager's parameter ``<name>.type``."""
    files: Annotated[tuple[str, ...], Meta(max_length=100)] = ()
    """YAML files on the simulation's machine; they correspond to the parameter
    ``<name>.params_file``.  If the files and the type are left out, the configuration
    of the bring-up is used."""
    configure: bool = True
    """Whether to configure the controller immediately; ROS 1 controllers are always
    configured."""

    def read_paths(self) -> tuple[str, ...]:
        return self.files


class ConfigureController(Request[None], frozen=True):
    """Configure a loaded controller: check its parameters, and prepare its start."""

    name: Name


class CleanupController(Request[None], frozen=True):
    """Return an inactive ROS 2 controller to the state ``unconfigured``."""

    name: Name


class ControllerTypeInfo(Struct, frozen=True, kw_only=True):
    """A controller type that can be loaded."""

    name: str
    """Name of the controller type, such as
    ``joint_trajectory_controller/JointTrajectoryController``."""
    base: str
    """C++ base class that ROS reports for the controller type."""


class ListControllerTypes(Request[tuple[ControllerTypeInfo, ...]], frozen=True):
    """List the controller types that can be loaded."""


class UnloadController(Request[None], frozen=True):
    """Unload a controller that is not running."""

    name: Name


class SwitchControllers(Request[None], frozen=True):
    """Stop and start controllers at the same instant."""

    start: Names = ()
    stop: Names = ()
    strict: bool = True
    """Whether an impossible change rejects the whole request; otherwise, it is
    skipped."""


class ReadController(Request[TrajectoryState], frozen=True):
    """Read the desired motion, the measured motion and the error of a controller.

    The controller must be a trajectory controller.
    """

    controller: Name


class QueryState(Request[JointsMotion], frozen=True):
    """Compute the setpoint of a trajectory controller at a given time."""

    controller: Name
    time: float | None = None
    """Simulated time of the setpoint [s]; the default is the current time."""


class ReadGains(Request[dict[str, Gains]], frozen=True):
    """Read the PID gains of a controller's joints; omit joints without a PID."""

    controller: Name


class SetGains(Request[Gains], frozen=True):
    """Change the PID gains of one joint; the response contains all gains.

    Omitted gains keep their values.  A running controller continues with the new gains,
    without a jump of the integral term.  The gains apply until the controller is
    unloaded; no file is changed.
    """

    controller: Name
    joint: Name
    p: float | None = None
    """Proportional gain: command per unit of position error; [N·m/rad | N/m] for an
    effort controller."""
    i: float | None = None
    """Integral gain: command per unit of the position error's time integral."""
    d: float | None = None
    """Command per velocity error."""
    i_clamp: Annotated[float, Meta(ge=0.0)] | None = None
    """Maximum magnitude of the integral term; [N·m | N] for an effort controller."""
    antiwindup: bool | None = None
    """Whether the integral itself is clamped, in addition to the integral term."""


class ControllerParameter(Struct, frozen=True, kw_only=True):
    """Value of a controller's parameter."""

    value: Any
    """Value of the parameter: a boolean, a number, a string, or a list of such
    values."""
    is_adjustable: bool
    """Whether the parameter can be changed while the controller is running."""


class ReadControllerParameters(Request[dict[str, ControllerParameter]], frozen=True):
    """Read the parameters of a loaded controller by name, including defaults."""

    controller: Name


class SetControllerParameters(Request[None], frozen=True):
    """Change adjustable parameters of a loaded controller.

    The values apply until the controller is unloaded; no file is changed.
    """

    controller: Name
    parameters: dict[
        str, bool | int | float | str | tuple[bool | int | float | str, ...]
    ]
    """New values by dotted parameter name, such as ``constraints.goal_time``."""
