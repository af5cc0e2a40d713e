"""Requests to a real robot: enabling and disabling its motion."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from tool0.protocol.request import ArmRequest


class EnableMotion(ArmRequest[None], frozen=True):
    """Enable motion of a real arm until ``disable_motion`` or the end of the session.

    The arm must be of the described type, under remote control, and have the expected
    calibration, payload and TCP; the arm's state lists what is missing
    (``link.obstacles``).  Then tool0's program starts on the robot's controller, with
    the speed slider at 25 % or less.
    """

    serial_number: Annotated[str, Meta(min_length=1, max_length=40)]
    """Serial number on the robot's nameplate, to confirm that this is the right
    robot."""
    accept_calibration: bool = False
    """Whether to move with the catalogue's kinematics although the robot's calibration
    differs; poses are then off by millimetres."""


class DisableMotion(ArmRequest[None], frozen=True):
    """Stop a real arm and disable its motion; tool0 then only reads its state."""

    is_urgent = True
    revokes = ("enable_motion", "play_program", "run_program", "take_arm")
