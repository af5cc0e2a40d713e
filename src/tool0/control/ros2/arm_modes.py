"""FreedriveModeController and ForceModeController from Universal Robots.

Freedrive cannot be active together with any controller of the arm's joints.  Force mode
can be active together with only one controller of these joints: the passthrough
controller.  In force mode, the arm deviates from the trajectory that the passthrough
controller executes.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from tool0.control.arm.mode import ArmModeSpec
from tool0.control.parameters import RobotJoints
from tool0.description.finding import quoted
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError

FREEDRIVE: Final = "ur_controllers/FreedriveModeController"
FORCE_MODE: Final = "ur_controllers/ForceModeController"
PASSTHROUGH: Final = "ur_controllers/PassthroughTrajectoryController"


def parse(
    name: str, type_name: str, parameters: Namespace, robot: RobotJoints
) -> ArmModeSpec:
    """Return the checked parameters of a controller for freedrive or force mode."""
    prefix = parameters.text("tf_prefix", "")
    parameters.integer("check_io_successful_retries", 10)
    is_freedrive = type_name == FREEDRIVE
    if is_freedrive:
        _check_timeout(parameters)
    joints = () if robot.arms is None else robot.arms.get(prefix)
    if joints is None:
        entry = parameters.find("tf_prefix") or parameters.entry
        raise ConfigError(
            f"'{entry.key}': no arm has the prefix '{prefix}'; "
            f"valid: {quoted(robot.arms) if robot.arms else '(the robot has no arm)'}",
            entry.location,
        )
    items = _freedrive_interfaces() if is_freedrive else _force_interfaces()
    return ArmModeSpec(
        name=name,
        type=type_name,
        joints=joints,
        companions=frozenset() if is_freedrive else frozenset({PASSTHROUGH}),
        is_freedrive=is_freedrive,
        further_interfaces=tuple(f"{prefix}{item}" for item in items),
        state_interfaces=()
        if is_freedrive
        else (f"{prefix}system_interface/initialized",),
    )


def _check_timeout(parameters: Namespace) -> None:
    """Reject a timeout of less than 1 s; the ROS node uses the timeout."""
    if parameters.integer("inactive_timeout", 1) < 1:
        entry = parameters.find("inactive_timeout") or parameters.entry
        raise ConfigError(
            f"'{entry.key}' must be at least 1 s, as an integer", entry.location
        )


def _freedrive_interfaces() -> Iterator[str]:
    """Yield the command interfaces of UR's driver for freedrive."""
    yield from (f"freedrive_mode/{item}" for item in ("async_success", "enable"))
    yield "freedrive_mode/abort"


def _force_interfaces() -> Iterator[str]:
    """Yield the command interfaces of UR's driver for force mode."""
    axes = ("x", "y", "z", "rx", "ry", "rz")
    for item in ("task_frame", "selection_vector", "wrench"):
        yield from (f"force_mode/{item}_{axis}" for axis in axes)
    yield "force_mode/type"
    yield from (f"force_mode/limits_{axis}" for axis in axes)
    others = ("force_mode_async_success", "disable_cmd", "damping", "gain_scaling")
    yield from (f"force_mode/{item}" for item in others)
