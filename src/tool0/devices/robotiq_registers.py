"""The registers of Robotiq's two-finger grippers, byte by byte.

Sources: instruction manual of the 2F-85 and 2F-140, "Control", and the gripper SDK of
Robotiq (https://github.com/robotiq/grippers, register_map.hpp, fault_status.hpp).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Final, final

BLOCK_BYTES: Final = 16
"""Length of the command block and of the status block; bytes from 6 on are reserved."""


class Activation(IntEnum):
    """Progress of the activation (gSTA)."""

    RESET = 0
    """The gripper is not activated, or performs an automatic release."""
    IN_PROGRESS = 1
    COMPLETE = 3


class ObjectStatus(IntEnum):
    """Object detection (gOBJ): whether the fingers have met an object."""

    MOVING = 0
    MET_OPENING = 1
    MET_CLOSING = 2
    ARRIVED = 3
    """The fingers are at the requested position: there is no object, or it was lost."""


class Fault(IntEnum):
    """Fault codes (gFLT) that occur; a real gripper has more."""

    NONE = 0x00
    ACTION_DELAYED = 0x05
    """The gripper ignores motions until the activation is complete."""
    ACTIVATION_NEEDED = 0x07
    """The activation bit must be set before a motion is requested."""
    RELEASE_IN_PROGRESS = 0x0B
    ACTIVATION_FAILED = 0x0D
    RELEASE_COMPLETE = 0x0F

    @property
    def is_major(self) -> bool:
        """Whether the fault can only be cleared by a reset."""
        return self >= Fault.RELEASE_IN_PROGRESS


_ACTIVATE, _GO_TO, _RELEASE, _RELEASE_OPENING = 0x01, 0x08, 0x10, 0x20


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class CommandRegisters:
    """The client's requests (Robotiq calls them robot outputs)."""

    activate: bool = False
    """Activation bit (rACT)."""
    go_to: bool = False
    """Whether to move to the requested position (rGTO)."""
    release: bool = False
    """Automatic release for emergencies (rATR)."""
    release_opening: bool = False
    """Whether an automatic release opens the fingers (rARD)."""
    position: int = 0
    """Requested position (rPR): 0 open … 255 closed."""
    speed: int = 0
    """Speed (rSP): 0 slowest … 255 fastest."""
    force: int = 0
    """Force (rFR): 0 weakest … 255 strongest."""

    @classmethod
    def decode(cls, block: bytes) -> CommandRegisters:
        """Return the command that a block of registers contains."""
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
        """Return the command as a block of registers."""
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
    """The gripper's reports (Robotiq calls them robot inputs)."""

    is_activated: bool
    """Echo of rACT (gACT)."""
    goes_to: bool
    """Whether the gripper follows rPR (gGTO); False during activation and automatic
    release."""
    activation: Activation
    """Progress of the activation (gSTA)."""
    object_status: ObjectStatus
    """Object detection (gOBJ)."""
    fault: Fault
    """Fault (gFLT)."""
    request: int
    """Echo of rPR (gPR)."""
    position: int
    """Measured position (gPO): 0 open … 255 closed."""
    current: int
    """Motor current (gCU) [10 mA]."""

    def encode(self) -> bytes:
        """Return the status as a block of registers."""
        state = (
            _ACTIVATE * self.is_activated
            | _GO_TO * self.goes_to
            | self.activation << 4
            | self.object_status << 6
        )
        data = bytes([state, 0, self.fault, self.request, self.position, self.current])
        return data.ljust(BLOCK_BYTES, b"\0")
