"""The registers of Robotiq's two-finger grippers, byte by byte.

Sources: instruction manual of the 2F-85 and 2F-140, "Control", and the gripper SDK of
Robotiq (https://github.com/robotiq/grippers, register_map.hpp, fault_status.hpp).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Final, final

BLOCK_BYTES: Final = 16
"""Length of the command and of the status; the bytes from 6 on are reserved."""


class Activation(IntEnum):
    """gSTA: how far the activation is."""

    RESET = 0
    """The gripper is not activated, or in an automatic release."""
    IN_PROGRESS = 1
    COMPLETE = 3


class ObjectStatus(IntEnum):
    """gOBJ: whether the fingers have met an object."""

    MOVING = 0
    MET_OPENING = 1
    MET_CLOSING = 2
    ARRIVED = 3
    """The fingers are at the requested position: there is no object, or it was lost."""


class Fault(IntEnum):
    """gFLT; of those of a real gripper, the ones that occur."""

    NONE = 0x00
    ACTION_DELAYED = 0x05
    """The activation must be completed before the action."""
    ACTIVATION_NEEDED = 0x07
    """The activation bit must be set before the action."""
    RELEASE_IN_PROGRESS = 0x0B
    ACTIVATION_FAILED = 0x0D
    RELEASE_COMPLETE = 0x0F

    @property
    def is_major(self) -> bool:
        """Whether only a reset ends it."""
        return self >= Fault.RELEASE_IN_PROGRESS


_ACTIVATE, _GO_TO, _RELEASE, _RELEASE_OPENING = 0x01, 0x08, 0x10, 0x20


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class CommandRegisters:
    """The client's requests: the robot outputs."""

    activate: bool = False
    """rACT"""
    go_to: bool = False
    """rGTO"""
    release: bool = False
    """rATR: automatic release, for emergencies."""
    release_opening: bool = False
    """rARD: whether an automatic release opens."""
    position: int = 0
    """rPR: 0 open … 255 closed."""
    speed: int = 0
    """rSP: 0 slowest … 255."""
    force: int = 0
    """rFR: 0 weakest … 255."""

    @classmethod
    def decode(cls, block: bytes) -> CommandRegisters:
        """Return the command in a block of registers."""
        action, _, _, position, speed, force = block[:6]
        return cls(
            activate=bool(action & _ACTIVATE),
            go_to=bool(action & _GO_TO),
            release=bool(action & _RELEASE),
            release_opening=bool(action & _RELEASE_OPENING),
            position=position,
            speed=speed,
            force=force,
        )

    def encode(self) -> bytes:
        """Return the block of registers."""
        action = (
            _ACTIVATE * self.activate
            | _GO_TO * self.go_to
            | _RELEASE * self.release
            | _RELEASE_OPENING * self.release_opening
        )
        data = bytes([action, 0, 0, self.position, self.speed, self.force])
        return data.ljust(BLOCK_BYTES, b"\0")


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class StatusRegisters:
    """The gripper's reports: the robot inputs."""

    is_activated: bool
    """gACT: echo of rACT."""
    goes_to: bool
    """gGTO: whether it obeys rPR; not during activation and automatic release."""
    activation: Activation
    """gSTA"""
    object_status: ObjectStatus
    """gOBJ"""
    fault: Fault
    """gFLT"""
    request: int
    """gPR: echo of rPR."""
    position: int
    """gPO: 0 open … 255 closed, measured."""
    current: int
    """gCU: current of the motor [10 mA]."""

    def encode(self) -> bytes:
        """Return the block of registers."""
        state = (
            _ACTIVATE * self.is_activated
            | _GO_TO * self.goes_to
            | self.activation << 4
            | self.object_status << 6
        )
        data = bytes([state, 0, self.fault, self.request, self.position, self.current])
        return data.ljust(BLOCK_BYTES, b"\0")
