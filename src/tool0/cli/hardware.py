"""``tool0 hardware``: motion enable, power, payload and speed of a real robot."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Annotated, Final

from tool0.cli.connection import DEFAULT, Bringup
from tool0.cli.parameters import AsJson, Option
from tool0.cli.text import print_json
from tool0.errors import ConfigError, ControlError

if TYPE_CHECKING:
    from tool0.api.control_box import ControlBox
    from tool0.api.robot import Robot
    from tool0.cli.outputs import HardwareOutput
    from tool0.protocol.control_box_state import ControlBoxState, RobotLink

Percent = Annotated[float, Option(is_positional=True, metavar="PERCENT")]


def _box(robot: Robot) -> ControlBox:
    """Return the control box of a real arm; raise ControlError if no arm is real."""
    box = robot.arm.control_box
    _link(box.state)
    return box


def _link(state: ControlBoxState) -> RobotLink:
    if state.link is None:
        raise ControlError(
            "this robot is simulated; `tool0 hardware` is for a real one"
        )
    return state.link


def why_stopped(state: ControlBoxState) -> str:
    """Return the reason why the arm of an enabled robot stopped.

    The text is empty if the arm did not stop, or was never enabled.
    """
    from tool0.protocol.control_box_state import ProgramState

    if state.motion_failure:
        return state.motion_failure
    if state.program is ProgramState.STOPPED and _link(state).is_enabled:
        return state.protective_stop or "a command stopped the arm"
    return ""


def show(*, as_json: AsJson = False, bringup: Bringup = DEFAULT) -> None:
    """Print a robot's model, serial number and modes, and why it cannot be moved.

    Args:
        as_json: Print one JSON object.
    """
    with bringup.connect() as robot:
        state = _box(robot).state
    link = _link(state)
    if as_json:
        found: HardwareOutput = {
            "link": link,
            "robot_mode": state.robot_mode.name,
            "safety_mode": state.safety_mode.name,
            "program": state.program.value,
            "stopped": why_stopped(state),
            "speed_slider": state.speed_slider,
        }
        print_json(found)
        return
    remote = {True: "remote control", False: "local control", None: "CB3"}
    print(
        f"robot: {link.model} {link.serial_number} at {link.address}, "
        f"PolyScope {link.software}, {remote[link.is_remote]}"
    )
    print(f"link: {'connected' if link.is_connected else 'LOST'}")
    print(
        f"modes: {state.robot_mode.name}, safety {state.safety_mode.name}, "
        f"program {state.program.value}, speed {state.speed_slider:.0%}"
    )
    print(f"motion: {'enabled' if link.is_enabled else 'not enabled'}")
    if reason := why_stopped(state):
        print(f"stopped: {reason}")
    if link.gripper_problem:
        print(f"gripper: {link.gripper_problem}")
    for text in link.obstacles:
        print(f"before it may move: {text}")


def enable(
    *,
    serial: str | None = None,
    accept_calibration: bool = False,
    bringup: Bringup = DEFAULT,
) -> None:
    """Enable motion, with the speed slider at 25 %.

    The command asks for the serial number on the robot's nameplate, to make sure that
    the intended robot moves.

    Args:
        serial: The serial number.  With this option, the command does not ask for the
            number.
        accept_calibration: Enable motion even if the robot's calibration differs from
            the description; tool poses are then off by millimeters.
    """
    with bringup.connect() as robot:
        box = _box(robot)
        link = _link(box.state)
        if serial is None:
            if not sys.stdin.isatty():
                raise ConfigError("enable: give --serial, as nobody can be asked")
            print(
                f"{link.model} at {link.address}: is its area clear, and the "
                "emergency stop in reach?"
            )
            serial = input("Serial number on its nameplate: ")
        box.enable_motion(serial, accept_calibration=accept_calibration)
        slider = box.state.speed_slider
    print(
        f"the robot may move, at {slider:.0%} of its speed; "
        "`tool0 hardware speed` changes that"
    )


def disable(*, bringup: Bringup = DEFAULT) -> None:
    """Stop the robot and disable motion; the robot's state is still read."""
    with bringup.connect() as robot:
        _box(robot).disable_motion()


def play(*, bringup: Bringup = DEFAULT) -> None:
    """Restart the controllers after the arm has stopped."""
    with bringup.connect() as robot:
        _box(robot).play()


def power_on(*, bringup: Bringup = DEFAULT) -> None:
    """Switch the arm on; its brakes remain engaged."""
    with bringup.connect() as robot:
        _box(robot).power_on()


def power_off(*, bringup: Bringup = DEFAULT) -> None:
    """Switch the arm off."""
    with bringup.connect() as robot:
        _box(robot).power_off()


def release_brakes(*, bringup: Bringup = DEFAULT) -> None:
    """Release the brakes; if the arm is off, it is switched on first."""
    with bringup.connect() as robot:
        _box(robot).release_brakes()


def unlock(*, bringup: Bringup = DEFAULT) -> None:
    """Clear a protective stop after its cause is known; the robot does not move."""
    with bringup.connect() as robot:
        _box(robot).unlock()


def payload(*, mass: float | None = None, bringup: Bringup = DEFAULT) -> None:
    """Set the payload of the robot.

    Args:
        mass: Mass of the gripper and the load [kg]; the default is the mass at the
            flange in the description.  The center of mass is always taken from the
            description.
    """
    with bringup.connect() as robot:
        box = _box(robot)
        box.clear_payload()
        if mass is not None:
            box.set_payload(mass, box.state.payload.center_of_gravity)


def speed(percent: Percent, *, bringup: Bringup = DEFAULT) -> None:
    """Set the speed slider.

    Args:
        percent: Percentage of the programmed speed, 1 to 100.
    """
    if not 1.0 <= percent <= 100.0:
        raise ConfigError(f"speed: {percent:g} % is not from 1 to 100")
    with bringup.connect() as robot:
        _box(robot).set_speed_slider(percent / 100.0)


hardware: Final = {
    "show": show,
    "enable": enable,
    "disable": disable,
    "play": play,
    "power-on": power_on,
    "power-off": power_off,
    "release-brakes": release_brakes,
    "unlock": unlock,
    "payload": payload,
    "speed": speed,
}
