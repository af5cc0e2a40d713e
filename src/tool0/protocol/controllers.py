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
    """Accepts a number for each joint: ``CommandTaker``."""
    MOTION = "motion"
    """Lets requests to an arm move it: tool0's own controller, and UR's driver's
    controllers for freedrive and force mode (``simulation/handlers/arm_motion.py``)."""
    READER = "reader"
    """Moves nothing."""


KIND_OF: Final = {
    Role.TRAJECTORY: "JointTrajectoryController",
    Role.GRIPPER: "GripperActionController",
    Role.COMMAND: "ForwardCommandController",
}
"""Role → usual controller class, for messages."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class ControllerStatus:
    """A loaded controller: controller_manager_msgs/ControllerState."""

    name: str
    """Name of the controller in the YAML."""
    type: str
    """Type in the YAML, such as ``effort_controllers/JointTrajectoryController``."""
    role: Role
    """Role of the controller."""
    state: str
    """State of the controller.  ROS 1: ``initialized`` after loading, then ``running``
    or ``stopped``.  ROS 2: ``unconfigured`` after loading, then ``inactive`` or
    ``active``."""
    is_running: bool
    """Whether the controller is running (ROS 1) or active (ROS 2)."""
    claimed: tuple[tuple[str, tuple[str, ...]], ...]
    """Command interfaces with the joints that the controller claims while it is
    running."""
    command_interfaces: tuple[str, ...] = ()
    """Required command interfaces, such as ``elbow_joint/position``."""
    state_interfaces: tuple[str, ...] = ()
    """Required state interfaces, by their ROS 2 names."""
    blocked: str = ""
    """Reason why the controller cannot be started: its arm is in a protective stop,
    powered off, or taken by another program.  Empty if it can."""

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

    The message is for requests that need such a controller.
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
    """Return how to start a loaded controller and stop others, for a message."""
    if instead_of:
        return (
            f"`tool0 controllers switch --stop {' '.join(instead_of)} --start {name}` "
            f"or robot.switch(start=['{name}'], stop={list(instead_of)})"
        )
    return f"`tool0 controllers start {name}` or robot.switch(start=['{name}'])"


UNLIMITED: Final = sys.float_info.max
"""Value of an unlimited limit in gains, which are sent as JSON without infinity."""


class Unwinding(enum.Enum):
    """Protection of a PID's integral from growing while its command is limited."""

    NONE = 0
    CONDITIONAL_INTEGRATION = 1
    """Errors that would drive the command further beyond its limit are not
    integrated."""
    BACK_CALCULATION = 2
    """The integral shrinks by the amount by which the limits clamp the command."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Gains:
    """PID gains of one joint: ``p e + clamp(i ∫e dt) + d de/dt``.

    ``e`` is the position error [rad | m]; the command of an effort controller is an
    effort [N·m | N].  As in control_toolbox, an integral without a clamp contributes
    nothing.
    """

    p: float
    """Command per position error [N·m/rad | N/m]."""
    i: float = 0.0
    """Command per integral of the position error [N·m/(rad·s) | N/(m·s)]."""
    d: float = 0.0
    """Command per velocity error [N·m·s/rad | N·s/m]."""
    i_min: float = 0.0
    """Least contribution of the integral, at most 0 [N·m | N]."""
    i_max: float = 0.0
    """Greatest contribution of the integral, at least 0 [N·m | N]."""
    antiwindup: bool = False
    """Whether the integral itself is clamped, not only its contribution."""
    u_min: float = -UNLIMITED
    """Least command, at most 0; this field and the next four exist only in ROS 2."""
    u_max: float = UNLIMITED
    """Greatest command, at least 0."""
    error_deadband: float = 0.0
    """Errors up to this are not integrated [rad | m]."""
    unwinding: Unwinding = Unwinding.NONE
    """Behaviour of the integral while the command is at a limit."""
    tracking_time: float = 1.0
    """Time constant of BACK_CALCULATION [s]; a shorter one shrinks the integral
    faster."""

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
    """List the loaded controllers with their states and claims."""


class LoadController(Request[None], frozen=True):
    """Load a controller from the bring-up's configuration or, for ROS 2, from files."""

    name: Name
    type: Name | None = None
    """Type of the controller, if the files do not contain it; like the controller
    manager's parameter ``<name>.type``."""
    files: Annotated[tuple[str, ...], Meta(max_length=100)] = ()
    """YAML files on the simulation's machine, like the parameter
    ``<name>.params_file``.  If this and the type are left out, the bring-up's
    configuration is used."""
    configure: bool = True
    """Whether to configure the controller at once; ROS 1 controllers always are."""

    def read_paths(self) -> tuple[str, ...]:
        return self.files


class ConfigureController(Request[None], frozen=True):
    """Configure a loaded controller: check its parameters so that it can be started."""

    name: Name


class CleanupController(Request[None], frozen=True):
    """Return an inactive ROS 2 controller to ``unconfigured``."""

    name: Name


class ControllerTypeInfo(Struct, frozen=True, kw_only=True):
    """A controller type that can be loaded."""

    name: str
    """Name of the type, such as
    ``joint_trajectory_controller/JointTrajectoryController``."""
    base: str
    """C++ base class that ROS reports for the type."""


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
    """Whether one impossible change rejects the whole request; otherwise that change is
    skipped."""


class ReadController(Request[TrajectoryState], frozen=True):
    """Read a trajectory controller's desired and measured motion, and the error."""

    controller: Name


class QueryState(Request[JointsMotion], frozen=True):
    """Compute a trajectory controller's setpoint at a given time."""

    controller: Name
    time: float | None = None
    """Simulated time [s]; if left out, the current time."""


class ReadGains(Request[dict[str, Gains]], frozen=True):
    """Read the PID gains of a controller's joints, except for joints without a PID."""

    controller: Name


class SetGains(Request[Gains], frozen=True):
    """Change PID gains of one joint; the response contains all of its gains.

    Gains left out keep their values.  A running controller continues with the new
    gains, and the integral's contribution does not jump.  The gains apply until the
    controller is unloaded; no file changes.
    """

    controller: Name
    joint: Name
    p: float | None = None
    """Command per position error: [N·m/rad | N/m] for an effort controller."""
    i: float | None = None
    """Command per integral of the position error."""
    d: float | None = None
    """Command per velocity error."""
    i_clamp: Annotated[float, Meta(ge=0.0)] | None = None
    """Largest contribution of the integral in either direction: [N·m | N] for an effort
    controller."""
    antiwindup: bool | None = None
    """Whether the integral itself is clamped, not only its contribution."""


class ControllerParameter(Struct, frozen=True, kw_only=True):
    """A parameter of a controller."""

    value: Any
    """A boolean, a number, a text, or a list of these."""
    is_adjustable: bool
    """Whether the parameter may change while the controller runs."""


class ReadControllerParameters(Request[dict[str, ControllerParameter]], frozen=True):
    """Read a loaded controller's parameters by dotted name, including defaults."""

    controller: Name


class SetControllerParameters(Request[None], frozen=True):
    """Change parameters of a loaded controller that may change while it runs.

    The values apply until the controller is unloaded; no file changes.
    """

    controller: Name
    parameters: dict[
        str, bool | int | float | str | tuple[bool | int | float | str, ...]
    ]
    """Values by dotted parameter name, such as ``constraints.goal_time``."""
