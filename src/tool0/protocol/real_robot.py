"""Requests to a real robot: enabling and disabling its motion."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from tool0.protocol.request import ArmRequest


class EnableMotion(ArmRequest[None], frozen=True):
    """Enable motion of a real arm until ``disable_motion`` or the end of the session.

    The arm must be of the described type and under remote control, and must have the
    expected calibration, payload and TCP.  The arm's state lists unmet conditions
    (``link.obstacles``).  After the check, tool0's program starts on the robot's
    controller, with the speed slider at 25 % or less.
    """

    serial_number: Annotated[str, Meta(min_length=1, max_length=40)]
    """Serial number on the robot's nameplate, to confirm that the connected robot is
    the intended robot."""
    accept_calibration: bool = False
    """Whether to move with the catalog's kinematics even if the robot's calibration
    differs; poses then have errors on the order of millimeters."""


class DisableMotion(ArmRequest[None], frozen=True):
    """Stop a real arm and disable its motion; tool0 then only reads its state."""

    is_urgent = True
    revokes = ("enable_motion", "play_program", "run_program", "take_arm")
