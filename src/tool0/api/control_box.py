"""Handle for the control box of an arm."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

from tool0.protocol.channel import Channel
from tool0.protocol.control_box import (
    PauseProgram,
    PlayProgram,
    PowerOff,
    PowerOn,
    ReadIO,
    ReleaseBrakes,
    RestartSafety,
    SetAnalogInput,
    SetAnalogOutput,
    SetIO,
    SetPayload,
    SetSafetyLimits,
    SetSpeedSlider,
    SetTcp,
    StopProgram,
    StopProtectively,
    UnlockProtectiveStop,
)
from tool0.protocol.control_box_state import AnalogDomain, ControlBoxState
from tool0.protocol.real_robot import DisableMotion, EnableMotion
from tool0.protocol.request import Place, checked_value


@final
class ControlBox:
    """Pins, speed slider, payload, program, power and protective stop of one arm.

    Pins only store values: clients read and set outputs, and you set the values of the
    inputs.  All other functions have the same effect as on a UR.  The brakes hold a
    stopped or powered-off arm; the other arms of a cell continue to run.
    """

    def __init__(self, arm: str, channel: Channel) -> None:
        self._arm = arm
        self._channel = channel

    @property
    def state(self) -> ControlBoxState:
        """Current state of the control box."""
        return self._channel.call(ReadIO(arm=self._arm))

    def set_digital_output(self, pin: int, value: bool) -> None:
        """Set an output: standard 0 … 7, configurable 8 … 15, or tool 16 and 17."""
        number: int = checked_value("set_digital_output", "pin", pin, int)
        self._channel.call(SetIO(arm=self._arm, digital_outputs={number: value}))

    def set_digital_input(self, pin: int, value: bool) -> None:
        """Set the level of an input; ``set_digital_output`` lists the pin numbers."""
        number: int = checked_value("set_digital_input", "pin", pin, int)
        self._channel.call(SetIO(arm=self._arm, digital_inputs={number: value}))

    def set_analog_output(
        self, pin: int, level: float, domain: AnalogDomain = AnalogDomain.VOLTAGE
    ) -> None:
        """Set analog output 0 or 1 to ``level``, a fraction of the range, 0 … 1."""
        self._channel.call(
            SetAnalogOutput(arm=self._arm, pin=pin, level=level, domain=domain)
        )

    def set_analog_input(
        self,
        pin: int,
        value: float,
        domain: AnalogDomain = AnalogDomain.VOLTAGE,
        *,
        tool: bool = False,
    ) -> None:
        """Set the value of analog input 0 or 1 of the box or the tool [V | A]."""
        self._channel.call(
            SetAnalogInput(
                arm=self._arm, pin=pin, value=value, domain=domain, tool=tool
            )
        )

    def set_tool_voltage(self, voltage: int) -> None:
        """Set the voltage at the tool's connector: 0, 12 or 24 V."""
        self._channel.call(
            SetIO(arm=self._arm, tool_voltage=voltage)  # type: ignore[arg-type]
        )

    def set_speed_slider(self, fraction: float) -> None:
        """Set the speed slider, the fraction of the programmed speed, 0.01 … 1."""
        self._channel.call(SetSpeedSlider(arm=self._arm, fraction=fraction))

    def set_payload(
        self, mass: float, center_of_gravity: Sequence[float] = (0.0, 0.0, 0.0)
    ) -> None:
        """Set the payload that the drives assume, including the gripper.

        Args:
            mass: Mass of the payload [kg].
            center_of_gravity: Center of gravity in the flange frame [m].
        """
        name = "center_of_gravity"
        center: Place = checked_value("set_payload", name, center_of_gravity, Place)
        self._channel.call(
            SetPayload(arm=self._arm, mass=mass, center_of_gravity=center)
        )

    def clear_payload(self) -> None:
        """Reset the payload to the mass at the flange in the robot's description."""
        self._channel.call(SetPayload(arm=self._arm))

    def play(self) -> None:
        """Start or resume the program, so that clients can control the arm."""
        self._channel.call(PlayProgram(arm=self._arm))

    def pause(self) -> None:
        """Pause the program: scaled trajectories decelerate to rest."""
        self._channel.call(PauseProgram(arm=self._arm))

    def stop(self) -> None:
        """Stop the program and the controllers of the arm; ``play`` restarts both."""
        self._channel.call(StopProgram(arm=self._arm))

    def power_off(self) -> None:
        """Switch the arm off: stop its controllers, and engage its brakes."""
        self._channel.call(PowerOff(arm=self._arm))

    def power_on(self) -> None:
        """Switch the arm on; its brakes remain engaged until ``release_brakes``."""
        self._channel.call(PowerOn(arm=self._arm))

    def release_brakes(self) -> None:
        """Release the brakes; if the arm is off, it is switched on first.

        The arm does not move until ``play`` restarts the controllers.
        """
        self._channel.call(ReleaseBrakes(arm=self._arm))

    def stop_protectively(self, reason: str) -> None:
        """Trigger a protective stop of this arm; ``unlock`` ends the stop."""
        self._channel.call(StopProtectively(arm=self._arm, reason=reason))

    def unlock(self) -> None:
        """End a protective stop; the arm holds its position until ``play``.

        Raises:
            ControlError: If there is no protective stop, or if the stop occurred less
                than 5 simulated seconds ago.
        """
        self._channel.call(UnlockProtectiveStop(arm=self._arm))

    def restart_safety(self) -> None:
        """Clear all stops and faults of the safety system; the arm is then off."""
        self._channel.call(RestartSafety(arm=self._arm))

    def enable_motion(
        self, serial_number: str, *, accept_calibration: bool = False
    ) -> None:
        """Enable motion of this real arm until ``disable_motion`` or the session's end.

        Args:
            serial_number: Serial number on the nameplate of the robot in front of you.
            accept_calibration: Enable motion even if the robot's calibration differs
                from the description; poses then have errors on the order of
                millimeters.

        Raises:
            ControlError: If motion is not allowed; the message contains all reasons.
        """
        request = EnableMotion(
            arm=self._arm,
            serial_number=serial_number,
            accept_calibration=accept_calibration,
        )
        self._channel.call(request)

    def disable_motion(self) -> None:
        """Stop a real arm and disable motion; the arm's state is still read."""
        self._channel.call(DisableMotion(arm=self._arm))

    def set_tcp(self, pose: Sequence[float]) -> None:
        """Set the tool center point (TCP), for clients of UR's protocols.

        Args:
            pose: Pose of the TCP in the flange frame: x, y, z [m] and a rotation vector
                [rad].
        """
        self._channel.call(
            SetTcp(arm=self._arm, pose=pose)  # type: ignore[arg-type]
        )

    def set_safety_limits(
        self, *, enabled: bool | None = None, force: float | None = None
    ) -> None:
        """Configure the automatic protective stops.

        Args:
            enabled: Whether a path error, a contact force or a command beyond a joint
                limit stops the arm.  The initial value is false.
            force: Maximum contact force on the tool or a link [N].  The initial value
                is 150.
        """
        self._channel.call(SetSafetyLimits(arm=self._arm, enabled=enabled, force=force))
