"""The rarely changing part of a snapshot, which is written as JSON at each change."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, final

import msgspec
from msgspec import UNSET, Struct, UnsetType

from tool0.protocol.state import MotionMode, Snapshot
from tool0.protocol.state_message import RareChanges, changes

_TIMING: Final = ("real_time_factor", "overruns", "late_ticks")
_WRITTEN: Final = tuple(
    name for name in RareChanges.__struct_fields__ if name not in _TIMING
)


@final
class Derived(Struct, frozen=True, kw_only=True):
    """Values that are derived from a snapshot, but are not its fields."""

    targets: Mapping[str, float] = {}
    modes: Mapping[str, MotionMode] = {}
    bodies: tuple[str, ...] = ()


@final
class StateChange(RareChanges, frozen=True, kw_only=True):
    """The fields of a snapshot that changed since the last snapshot in the file."""

    targets: Mapping[str, float] | UnsetType = UNSET
    """End positions of the current motions [rad | m], by joint, for joints with
    position setpoints."""
    modes: Mapping[str, MotionMode] | UnsetType = UNSET
    """Modes of motion, by arm."""
    bodies: tuple[str, ...] | UnsetType = UNSET
    """Links and objects that have touched another body, in the order of their numbers
    in ``/contacts``."""


_encoder: Final = msgspec.json.Encoder()
_decoder: Final = msgspec.json.Decoder(StateChange)


def encode_change(
    snapshot: Snapshot,
    before: Snapshot | None,
    derived: Derived,
    derived_before: Derived,
) -> bytes | None:
    """Return the changes since ``before``; None if there are no changes.

    A change of the simulation's real-time performance alone is ignored.
    """
    found = changes(snapshot, before, _WRITTEN)
    for name in Derived.__struct_fields__:
        value = getattr(derived, name)
        if before is None or value != getattr(derived_before, name):
            found[name] = value
    if not found:
        return None
    found |= {name: getattr(snapshot, name) for name in _TIMING}
    return _encoder.encode(StateChange(**found))


def decode_change(text: bytes) -> dict[str, Any]:
    """Return the changed fields by name; ``scene`` is a tuple of ObjectInfo."""
    change = _decoder.decode(text)
    fields = ((name, getattr(change, name)) for name in StateChange.__struct_fields__)
    return {name: value for name, value in fields if value is not UNSET}
