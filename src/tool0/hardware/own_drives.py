"""Drives of a real robot, which execute motions without tool0's servos.

An engine that uses the drives of a real robot does not accept efforts.  In each tick,
the engine receives the desired motion starting at that tick, and reports the state of
the robot's own controller.
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
    """Motion that an arm follows until it is replaced."""

    at: Callable[[float], ArmSetpoint]
    """Function that returns the positions, velocities and accelerations of the arm's
    joints at a time [s]."""
    is_streamed: bool = False
    """Whether the motion is known only until the end of this tick.  If True, the robot
    assumes constant velocities after the tick."""
    target: tuple[float, ...] = ()
    """Final joint positions [rad]; empty for a stream."""
    key: tuple[object, ...] = ()
    """Identifier of the motion.  Two motions with equal keys are the same motion, even
    if their speeds differ."""


@final
class WantedGrip(NamedTuple):
    """Grip that the controllers command to a gripper."""

    position: float
    """Final position of the driven joint [rad | m]."""
    limits: DriveLimits | None
    """Limits of speed and force; if None, the gripper's own limits apply."""


@final
class Wanted(NamedTuple):
    """Commands of the controllers."""

    now: JointState
    """The measured state at the start of the tick."""
    arm: WantedMotion | None
    """Motion of the arm; None if no controller moves or holds the arm, so that the arm
    comes to rest."""
    grips: Mapping[str, WantedGrip]
    """Commanded grips, by gripper.  Grippers that no controller commands are not in the
    mapping and receive no command."""


@final
class RobotReport(Struct, frozen=True, kw_only=True):
    """State of a robot's controller, without the motion of the joints."""

    link: RobotLink
    robot_mode: RobotMode
    safety_mode: SafetyMode
    program: ProgramState
    """State of tool0's program on the robot's controller.  The arm can be moved only
    while this program runs."""
    motion_failure: str = ""
    """Reason why the arm came to rest without a command; empty if it did not."""
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
    """Center of gravity of the payload in the flange frame [m]."""
    tcp: Pose6


class OwnDrives(abc.ABC):
    """The interface through which the tick uses the drives of a real robot."""

    @abc.abstractmethod
    def follow(self, wanted: Wanted) -> None:
        """Send the commands to the robot, before the tick's physics step."""

    @property
    @abc.abstractmethod
    def start_delay(self) -> float:
        """Time that the robot needs to start a motion from rest [s]."""

    @property
    @abc.abstractmethod
    def gripper_delay(self) -> float:
        """Longest delay until a gripper's state reflects a command [s]."""

    @property
    @abc.abstractmethod
    def report(self) -> RobotReport:
        """The newest report.  The same object is returned until a value changes."""

    @property
    @abc.abstractmethod
    def wrench(self) -> Wrench:
        """Measured external force and torque on the tool, in the axes of the flange."""

    @property
    @abc.abstractmethod
    def currents(self) -> tuple[float, ...]:
        """Measured currents of the arm's motors [A], from base to flange."""

    @property
    @abc.abstractmethod
    def gripping(self) -> frozenset[str]:
        """The grippers that report an object between their fingers."""

    @abc.abstractmethod
    def set_digital_outputs(self, pins: Mapping[int, bool]) -> None:
        """Set digital outputs.

        Raises TransportError if the robot cannot be reached.
        """

    @abc.abstractmethod
    def set_analog_output(self, pin: int, value: float, *, is_voltage: bool) -> None:
        """Set an analog output to a fraction of its range, 0 … 1.

        Raises TransportError.
        """

    @abc.abstractmethod
    def set_speed_slider(self, fraction: float) -> None:
        """Set the speed slider to a fraction, 0.01 … 1.  Raises TransportError."""

    @abc.abstractmethod
    def start_force_mode(
        self,
        frame: Pose6,
        selection: Sequence[bool],
        wrench: Sequence[float],
        kind: int,
        limits: Sequence[float],
    ) -> None:
        """Start force mode, like URScript's ``force_mode``.  Raises TransportError."""

    @abc.abstractmethod
    def end_force_mode(self) -> None:
        """End force mode."""

    @abc.abstractmethod
    def start_freedrive(self, axes: Sequence[bool], frame: Pose6) -> None:
        """Start freedrive.  Raises TransportError."""

    @abc.abstractmethod
    def end_freedrive(self) -> None:
        """End freedrive; the arm holds its position."""

    @abc.abstractmethod
    def forgive(self) -> None:
        """Follow motions again after the arm came to rest without a command."""

    @abc.abstractmethod
    def brake(self) -> None:
        """Bring the arm to rest immediately; any thread may call this method."""
