"""What changes rarely in a snapshot: written when it changes, as JSON."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, final

import msgspec
from msgspec import UNSET, Struct, UnsetType

from tool0.protocol.control_box_state import ControlBoxState
from tool0.protocol.controllers import ControllerStatus
from tool0.protocol.objects import ObjectInfo, info_of
from tool0.protocol.state import MotionMode, Snapshot, Stall

_TIMING: Final = ("real_time_factor", "overruns", "late_ticks")
_COMPARED: Final = ("is_paused", "is_stopped", "fault", "speed", "stalls", "gripping")
_IDENTICAL: Final = ("controllers", "control_boxes")


@final
class Derived(Struct, frozen=True, kw_only=True):
    """What is no field of a snapshot, but follows from one; as in ``StateChange``."""

    targets: Mapping[str, float] = {}
    modes: Mapping[str, MotionMode] = {}
    bodies: tuple[str, ...] = ()


@final
class StateChange(Struct, frozen=True, kw_only=True):
    """The fields of a snapshot that changed since the last one in the file."""

    is_paused: bool | UnsetType = UNSET
    is_stopped: bool | UnsetType = UNSET
    """Whether the emergency stop is engaged."""
    fault: str | UnsetType | None = UNSET
    speed: float | UnsetType | None = UNSET
    stalls: tuple[Stall, ...] | UnsetType = UNSET
    gripping: tuple[str, ...] | UnsetType = UNSET
    real_time_factor: float | UnsetType = UNSET
    overruns: int | UnsetType = UNSET
    late_ticks: int | UnsetType = UNSET
    controllers: tuple[ControllerStatus, ...] | UnsetType = UNSET
    control_boxes: tuple[ControlBoxState, ...] | UnsetType = UNSET
    scene: tuple[ObjectInfo, ...] | UnsetType = UNSET
    targets: Mapping[str, float] | UnsetType = UNSET
    """Joint → end of its motion [rad | m], of joints that are moved by position."""
    modes: Mapping[str, MotionMode] | UnsetType = UNSET
    """Arm → what moves it."""
    bodies: tuple[str, ...] | UnsetType = UNSET
    """Links and objects that touched something, in the order of their numbers."""


_encoder: Final = msgspec.json.Encoder()
_decoder: Final = msgspec.json.Decoder(StateChange)


def encode_change(
    snapshot: Snapshot,
    before: Snapshot | None,
    derived: Derived,
    derived_before: Derived,
) -> bytes | None:
    """Return what has changed since ``before``; None if nothing has.

    How well the simulation keeps pace is no change of its own.
    """
    changes: dict[str, Any] = {}
    if before is None:
        changes = {name: getattr(snapshot, name) for name in (*_COMPARED, *_IDENTICAL)}
        changes["scene"] = tuple(map(info_of, snapshot.scene))
    else:
        for name in _COMPARED:
            value = getattr(snapshot, name)
            if value != getattr(before, name):
                changes[name] = value
        for name in _IDENTICAL:
            value, old = getattr(snapshot, name), getattr(before, name)
            if value is not old and value != old:
                changes[name] = value
        if snapshot.scene is not before.scene:
            changes["scene"] = tuple(map(info_of, snapshot.scene))
    for name in Derived.__struct_fields__:
        value = getattr(derived, name)
        if before is None or value != getattr(derived_before, name):
            changes[name] = value
    if not changes:
        return None
    changes |= {name: getattr(snapshot, name) for name in _TIMING}
    return _encoder.encode(StateChange(**changes))


def decode_change(text: bytes) -> dict[str, Any]:
    """Return the changed fields; ``scene`` is a tuple of ObjectInfo."""
    change = _decoder.decode(text)
    fields = ((name, getattr(change, name)) for name in StateChange.__struct_fields__)
    return {name: value for name, value in fields if value is not UNSET}
