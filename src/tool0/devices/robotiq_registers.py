"""The registers of Robotiq's two-finger grippers as bytes.

Sources: the instruction manual of the 2F-85 and 2F-140, section "Control", and
Robotiq's gripper SDK (https://github.com/robotiq/grippers, register_map.hpp,
fault_status.hpp).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Final, final

BLOCK_BYTES: Final = 16
"""Length of the command block and of the status block [bytes]. The bytes starting at
index 6 are reserved."""


class Activation(IntEnum):
    """Progress of the activation (gSTA)."""

    RESET = 0
    """The gripper is not activated, or is performing an automatic release."""
    IN_PROGRESS = 1
    COMPLETE = 3


class ObjectStatus(IntEnum):
    """Object detection (gOBJ): whether an object has stopped the fingers."""

    MOVING = 0
    MET_OPENING = 1
    MET_CLOSING = 2
    ARRIVED = 3
    """The fingers are at the requested position. There is no object, or the object was
    lost."""


class Fault(IntEnum):
    """Fault codes (gFLT) that can occur; a real gripper has additional codes."""

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
        """Whether the fault can be cleared only by a reset."""
        return self >= Fault.RELEASE_IN_PROGRESS


_ACTIVATE, _GO_TO, _RELEASE, _RELEASE_OPENING = 0x01, 0x08, 0x10, 0x20


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class CommandRegisters:
    """The client's requests, which Robotiq calls robot outputs."""

    activate: bool = False
    """Activation bit (rACT)."""
    go_to: bool = False
    """Whether to move to the requested position (rGTO)."""
    release: bool = False
    """Whether to perform an automatic release for emergencies (rATR)."""
    release_opening: bool = False
    """Whether an automatic release opens the fingers (rARD)."""
    position: int = 0
    """Requested position (rPR): 0 is open, 255 is closed."""
    speed: int = 0
    """Speed (rSP): 0 is the slowest, 255 is the fastest."""
    force: int = 0
    """Force (rFR): 0 is the weakest, 255 is the strongest."""

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
    """The gripper's reports, which Robotiq calls robot inputs."""

    is_activated: bool
    """Echo of the activation bit rACT (gACT)."""
    goes_to: bool
    """Whether the gripper moves to the position rPR (gGTO); False during activation and
    automatic release."""
    activation: Activation
    """Progress of the activation (gSTA)."""
    object_status: ObjectStatus
    """Object detection (gOBJ)."""
    fault: Fault
    """Fault code (gFLT)."""
    request: int
    """Echo of the requested position rPR (gPR)."""
    position: int
    """Measured position (gPO): 0 is open, 255 is closed."""
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
