"""Requests to a real robot: whether tool0 may move it."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from tool0.protocol.request import ArmRequest


class EnableMotion(ArmRequest[None], frozen=True):
    """Enable motion of a real arm, until the end of the session or `disable_motion`.

    The arm must be under remote control, of the described type, with the expected
    calibration, payload and TCP; the state of the arm says what is missing
    (`link.obstacles`).  tool0's program then starts on the robot's controller, with the
    speed slider at 25 % or less.
    """

    serial_number: Annotated[str, Meta(min_length=1, max_length=40)]
    """Serial number on the robot's nameplate, to confirm that it is the right robot."""
    accept_calibration: bool = False
    """Whether to move with the catalogue's kinematics although the robot's calibration
    is another one: poses are off by millimetres then."""


class DisableMotion(ArmRequest[None], frozen=True):
    """Stop a real arm, and let tool0 only read its state from now on."""

    is_urgent = True
    revokes = ("enable_motion", "play_program", "run_program", "take_arm")
