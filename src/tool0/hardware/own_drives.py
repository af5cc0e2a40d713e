"""Drives that are not ours: those of a real robot, which follow motions on their own.

An engine with such drives takes no efforts.  Each tick gives it the motion that is
wanted from then on, and it reports the state of the robot's own controller.
"""

from __future__ import annotations

import abc
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, final

from msgspec import Struct

from tool0.description.drive_limits import DriveLimits
from tool0.description.scene_state import Wrench
from tool0.hardware.engine import JointState
from tool0.protocol.control_box_state import (
    AnalogPin,
    Pose6,
    ProgramState,
    RobotLink,
    RobotMode,
    SafetyMode,
)
from tool0.protocol.state import ArmSetpoint


@final
class WantedMotion(NamedTuple):
    """Motion that an arm is to follow from now on, until the next one."""

    at: Callable[[float], ArmSetpoint]
    """Returns position, velocity and acceleration of its joints at a time [s]."""
    is_streamed: bool = False
    """Whether it is known only for the end of this tick; the robot then assumes
    constant velocities."""
    target: tuple[float, ...] = ()
    """End positions [rad]; empty for a stream."""
    key: tuple[object, ...] = ()
    """Equal as long as it is the same motion, at whatever speed."""


@final
class WantedGrip(NamedTuple):
    """Grip that the controllers command of a gripper."""

    position: float
    """Final position of the driven joint [rad | m]."""
    limits: DriveLimits | None
    """Speed and force; those of the gripper, if left out."""


@final
class Wanted(NamedTuple):
    """Commands of the controllers."""

    now: JointState
    """The measured state at the start of the tick."""
    arm: WantedMotion | None
    """None if nothing moves or holds it: it comes to rest."""
    grips: Mapping[str, WantedGrip]
    """Wanted grips by gripper; those that no controller commands are left alone."""


@final
class RobotReport(Struct, frozen=True, kw_only=True):
    """Report of a robot's controller, besides its motion."""

    link: RobotLink
    robot_mode: RobotMode
    safety_mode: SafetyMode
    program: ProgramState
    """State of tool0's program on the controller: without it, nothing can move the
    arm."""
    motion_failure: str = ""
    """Reason why the arm came to rest on its own; empty if it did not."""
    speed_slider: float
    speed_scaling: float
    digital_inputs: tuple[bool, ...]
    digital_outputs: tuple[bool, ...]
    analog_inputs: tuple[AnalogPin, ...]
    analog_outputs: tuple[AnalogPin, ...]
    tool_analog_inputs: tuple[AnalogPin, ...]
    tool_voltage: int
    tool_current: float
    tool_temperature: float
    payload_mass: float
    """Mass of the payload [kg]."""
    payload_center: tuple[float, float, float]
    """Center of gravity of the payload in the flange [m]."""
    tcp: Pose6


class OwnDrives(abc.ABC):
    """The drives of a real robot, as the tick uses them."""

    @abc.abstractmethod
    def follow(self, wanted: Wanted) -> None:
        """Send the robot its commands, before the step of a tick."""

    @property
    @abc.abstractmethod
    def start_delay(self) -> float:
        """Lead time with which the robot should know of a motion from rest [s]."""

    @property
    @abc.abstractmethod
    def gripper_delay(self) -> float:
        """Longest time until a command to a gripper shows in its state [s]."""

    @property
    @abc.abstractmethod
    def report(self) -> RobotReport:
        """The newest report: the same object until something changes."""

    @property
    @abc.abstractmethod
    def wrench(self) -> Wrench:
        """Measured external force and torque on the tool, in the flange's axes."""

    @property
    @abc.abstractmethod
    def currents(self) -> tuple[float, ...]:
        """Measured currents of the arm's motors [A], base to flange."""

    @property
    @abc.abstractmethod
    def gripping(self) -> frozenset[str]:
        """The grippers that report an object between their fingers."""

    @abc.abstractmethod
    def set_digital_outputs(self, pins: Mapping[int, bool]) -> None:
        """Set pins; TransportError if the robot is not reached."""

    @abc.abstractmethod
    def set_analog_output(self, pin: int, value: float, *, is_voltage: bool) -> None:
        """Set a pin to a part of its range, 0 … 1; TransportError as above."""

    @abc.abstractmethod
    def set_speed_slider(self, fraction: float) -> None:
        """Set the speed slider, 0.01 … 1; TransportError as above."""

    @abc.abstractmethod
    def start_force_mode(
        self,
        frame: Pose6,
        selection: Sequence[bool],
        wrench: Sequence[float],
        kind: int,
        limits: Sequence[float],
    ) -> None:
        """Push with a force, as URScript's ``force_mode``; TransportError as above."""

    @abc.abstractmethod
    def end_force_mode(self) -> None:
        """End that."""

    @abc.abstractmethod
    def start_freedrive(self, axes: Sequence[bool], frame: Pose6) -> None:
        """Start freedrive; TransportError as above."""

    @abc.abstractmethod
    def end_freedrive(self) -> None:
        """End that: the arm holds where it is."""

    @abc.abstractmethod
    def forgive(self) -> None:
        """Follow again after the arm came to rest on its own."""

    @abc.abstractmethod
    def brake(self) -> None:
        """Bring the arm to rest at once; any thread may call this."""
